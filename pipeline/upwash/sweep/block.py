"""What one block of a sweep varies, and the jobs that follow from it."""

from __future__ import annotations

import itertools
import json
import logging
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

from upwash.aero.bird import Bird
from upwash.aero.checked import WrongInput
from upwash.aero.together import SHARED
from upwash.aero.wake import GIVEN, NAMES, WakeModel
from upwash.errors import UpwashError
from upwash.jobs.bird import AHEAD, BIRD_COLUMNS, Companion, NoBird, bird_of, inputs_of
from upwash.jobs.jitter import SIGMA
from upwash.jobs.job import BUILT_IN_SOLVER, Job
from upwash.jobs.kind import Kind
from upwash.optimum.settings import SearchSettings
from upwash.optimum.spacing import UNITS, Spacing
from upwash.species import ImpossibleAmplitude, Species
from upwash.species.species import OF_THE_AMPLITUDE
from upwash.sweep.choices import (
    LEADER,
    MEMBERS,
    MODEL,
    OF_THE_BIRD,
    PARTS,
    SPEED,
    SPEED_OF,
    STROKE_ANGLE,
)
from upwash.sweep.speeds import FOLLOWERS, LEADERS, OWN
from upwash.sweep.values import Setting, unit_sample

LOGGER = logging.getLogger(__name__)

# Where a job's inputs are named otherwise than in a sweep file.
COLUMN = {"amplitude": "amplitude_convention", LEADER: "ahead_species", **BIRD_COLUMNS}

Choice = dict[str, Any]
Point = dict[str, Setting]


@dataclass(frozen=True)
class Sample:
    """A sampled design: `method` and `seed` of the points, and the range of each parameter.

    `ranges` maps parameter -> (low, high, relative); None stands for each species' own ranges, of those
    `parameters` or, if there are none, of all.
    """

    method: str
    count: int
    seed: int
    ranges: Mapping[str, tuple[float, float, bool]] | None
    parameters: tuple[str, ...] = ()

    def ranges_of(self, species: Species, convention: str) -> Mapping[str, tuple[float, float, bool]]:
        """Return the range of each sampled parameter for one species."""
        if self.ranges is not None:
            return self.ranges
        own = species.ranges(convention)
        return {name: (*own[name], False) for name in self.parameters or own}

    def points(self, species: Species, convention: str) -> Iterator[Point]:
        """Give the design's points for one species; the same points of the unit cube for each."""
        ranges = self.ranges_of(species, convention)
        for point in unit_sample(self.method, self.count, len(ranges), self.seed):
            shares = zip(ranges.items(), point.tolist(), strict=True)
            yield {
                name: Setting(low + (high - low) * share, relative)
                for (name, (low, high, relative)), share in shares
            }

    def size(self, species: Species, convention: str) -> int:
        """Return how many points the design has for one species."""
        return self.count * (len(self.ranges_of(species, convention)) + 2 if self.method == "saltelli" else 1)


@dataclass(frozen=True)
class Axis:
    """Parameters that are varied side by side: their `names`, and a row of settings for each point."""

    names: tuple[str, ...]
    rows: list[tuple[Setting, ...]]


@dataclass(frozen=True)
class Condition:
    """A condition on one input: one of `values`, or a number between two bounds, themselves excluded."""

    values: tuple[Any, ...] = ()
    above: float = -math.inf
    below: float = math.inf

    def holds(self, value: Any) -> bool:
        """Whether a value meets the condition; numbers are equal to within rounding."""
        if not self.values:
            # The words for numbers, exact and endless, mean more than any.
            return self.above < (math.inf if isinstance(value, str) else value) < self.below
        if isinstance(value, str):
            return value in self.values
        return value is not None and any(
            not isinstance(one, str) and math.isclose(value, one, rel_tol=1e-9) for one in self.values
        )


@dataclass(frozen=True)
class Block:
    """A product of choices, and what is left out of it.

    Parameters
    ----------
    kind : type of Kind
        What its jobs are.
    solver : str
        As for `Job`.
    species : list of Species
        Birds.
    choices : dict
        Input of a job other than the parameters (``objective``, ``amplitude``, ``seed``, …) -> its values.
    fixed : dict
        Parameter -> setting, for every job.
    axes : list of Axis
        Each a list of points.
    sample : Sample or None
        A sampled design, crossed with the rest.
    exclusions : list of dict
        Input -> condition; a job that meets all of one is left out.
    """

    kind: type[Kind]
    solver: str
    species: list[Species]
    choices: dict[str, list[Any]]
    fixed: dict[str, Setting]
    axes: list[Axis]
    sample: Sample | None
    exclusions: list[dict[str, Condition]]

    def size(self) -> int:
        """Return the number of jobs before exclusions."""
        others = [values for name, values in self.choices.items() if name != "amplitude"]
        per_bird = math.prod(map(len, [*(axis.rows for axis in self.axes), *others]))
        birds = itertools.product(self.species, self.choices["amplitude"])
        return sum(per_bird * (self.sample.size(*bird) if self.sample else 1) for bird in birds)

    def jobs(self) -> Iterator[tuple[Job, int | None]]:
        """Make the jobs in the order of the file, each with the number of an exclusion it meets, or None.

        Raises
        ------
        UpwashError
            If a combination of values makes no bird.
        """
        others = {name: values for name, values in self.choices.items() if name != "amplitude"}
        for species, convention in itertools.product(self.species, self.choices["amplitude"]):
            for values in itertools.product(*others.values()):
                choice = {**dict(zip(others, values, strict=True)), "amplitude": convention}
                for point in self._points(species, convention):
                    job = self._job(species, choice, point)
                    met = (i for i, one in enumerate(self.exclusions) if _meets(job, one))
                    yield job, next(met, None)

    def _points(self, species: Species, convention: str) -> Iterator[Point]:
        """Give what is set, one point of axes and sample after another, the last varying fastest."""
        names = [name for axis in self.axes for name in axis.names]
        for rows in itertools.product(*(axis.rows for axis in self.axes)):
            point = self.fixed | dict(zip(names, itertools.chain(*rows), strict=True))
            for sampled in self.sample.points(species, convention) if self.sample else ({},):
                yield point | sampled

    def _job(self, species: Species, choice: Choice, point: Mapping[str, Setting]) -> Job:
        convention = choice["amplitude"]
        is_given = "amplitude_m" in point and not point["amplitude_m"].relative
        point = {**point, **_speed(species, choice, point)}
        point = {**point, **_best_speed(species, choice, point)}
        bird = _bird(species, convention, point)
        kind = self.kind.from_inputs(choice | _companions(species, bird, convention, choice))
        try:
            model = _model(kind.wavelength_ratio(bird), point)
            if self.solver == BUILT_IN_SOLVER:
                kind.need_solvable(model)
            return Job(
                species=species.slug,
                objective=choice["objective"],
                amplitude_convention=GIVEN if is_given else convention,
                bird=bird,
                model=model,
                search=SearchSettings(choice["seed"], choice["tolerance"]),
                kind=kind,
                solver=self.solver,
                distance_m=point["distance_m"].value if "distance_m" in point else None,
                position_sigma_ratio=point[SIGMA].value if SIGMA in point else None,
                spacing=Spacing(**{name: point[name].value for name in UNITS if name in point}),
            )
        except WrongInput as error:
            raise UpwashError(f"{species.slug}: {error}; correct it", field=error.name) from error


def _speed(species: Species, choice: Choice, point: Mapping[str, Setting]) -> Point:
    """Return the speed at which two birds fly together, if it is not the follower's own or one that is set."""
    leader, of = choice.get(LEADER), choice.get(SPEED_OF, FOLLOWERS)
    if leader is None or of == FOLLOWERS:
        return {}
    if "speed_m_s" in point:
        raise UpwashError(
            f"{species.slug}, {SPEED_OF}: expected either whose speed it is or a speed, found {of!r} and "
            "speed_m_s; leave one out",
            field=SPEED_OF,
        )
    own, other = species.inputs()["speed_m_s"], leader.inputs()["speed_m_s"]
    return {"speed_m_s": Setting(other if of == LEADERS else 0.5 * (own + other))}


def _best_speed(species: Species, choice: Choice, point: Mapping[str, Setting]) -> Point:
    """Return the speed at which the lone bird spends least, if that is asked for.

    It is told to a tenth of a millimetre a second, so that jobs have the same names on any machine.
    """
    from upwash.journey.line import Lines
    from upwash.journey.speed import NoSpeed, SpeedSearch, speed_range

    rule = choice.get(SPEED, OWN)
    if rule == OWN:
        return {}
    if "speed_m_s" in point:
        raise UpwashError(
            f"{species.slug}, {SPEED}: expected either a choice of the speed or a speed, found {rule!r} and another "
            "speed; leave one out",
            field="speed_m_s",
        )

    def at(speed: float) -> Bird:
        bird = _bird(species, choice["amplitude"], {**point, "speed_m_s": Setting(float(speed))})
        if isinstance(bird, NoBird):
            raise UpwashError(bird.why)
        return bird

    try:
        lines = Lines(choice["objective"], WakeModel())
        found = SpeedSearch(at, speed_range(at, UpwashError), lines, SearchSettings()).alone(rule)
    except NoSpeed as error:
        raise UpwashError(f"{species.slug}, {SPEED}: {error}", field=SPEED) from error
    return {"speed_m_s": Setting(round(found.speed_m_s, 4))}


def _companions(species: Species, bird: Bird | NoBird, convention: str, choice: Choice) -> dict[str, Any]:
    """Return the inputs, by column, that say which other birds fly with a job's, in its air and at its speed."""
    shared = {name: value for name, value in inputs_of(bird).items() if name in SHARED}

    def beside(other: Species) -> Bird:
        own = other.inputs()
        return other.bird(convention, **{name: value for name, value in shared.items() if own[name] != value})

    if choice.get(LEADER) is not None:
        leader = choice[LEADER]
        ahead = beside(leader)
        # A leader that is like its follower is none of its own.
        if ahead == bird:
            return {}
        own = Companion(leader.slug, ahead).own()
        return {**shared, "ahead_species": leader.slug, **{AHEAD[name]: own[name] for name in own}}
    if choice.get(MEMBERS):
        others = [Companion(one.slug, beside(one)) for one in choice[MEMBERS]]
        if all(one.bird == bird for one in others):
            return {"birds": len(others) + 1}
        told = [{"species": one.species, **one.own()} for one in others]
        return {**shared, "birds": len(others) + 1, "members": json.dumps(told)}
    return {}


def _model(wavelength_ratio: float, point: Mapping[str, Setting]) -> WakeModel:
    """Return the model of the wake with the steps that its core and the wavelength need, unless they are set."""
    model = model_of(point)
    if "stroke_states" not in point:
        return model.resolving(wavelength_ratio)
    if line := model.coarseness(wavelength_ratio):
        _tell_once(line)
    return model


@cache
def _tell_once(line: str) -> None:
    LOGGER.warning(line)


def model_of(point: Mapping[str, Setting]) -> WakeModel:
    """Return the model of the wake that is named, with some parts otherwise."""
    named = WakeModel.named(point[MODEL].value if MODEL in point else NAMES[0])
    parts: dict[str, Any] = {}
    for name in PARTS:
        if name in point:
            value = point[name].value * (getattr(named, name) if point[name].relative else 1)
            parts[name] = math.inf if value == "endless" else value
    return replace(named, **parts)


def _bird(species: Species, convention: str, point: Mapping[str, Setting]) -> Bird | NoBird:
    """Return a species' bird with some inputs set otherwise.

    An amplitude beyond the wingspan is kept: that the bird cannot fly so is a result, for the job to report.

    Raises
    ------
    UpwashError
        If the values make no bird for another reason.
    """
    own = {**species.inputs(), "circulation_ratio": 1.0}
    for name, setting in point.items():
        if setting.relative and name in OF_THE_AMPLITUDE and name not in own:
            raise UpwashError(
                f"{species.slug}: {name}: expected the species' own to be scaled, found none; state it",
                field=name,
            )
    overrides = {
        name: setting.value * (own[name] if setting.relative else 1.0)
        for name, setting in point.items()
        if name in OF_THE_BIRD and not (name == "amplitude_m" and setting.relative)
    }
    amplitude = point.get("amplitude_m")
    try:
        if amplitude is not None and amplitude.relative:
            overrides["amplitude_m"] = amplitude.value * _amplitude_m(species, convention, overrides)
        return species.bird(convention, **overrides)
    except ImpossibleAmplitude as error:
        # All but the amplitude must make a bird.
        of_the_bird = {name: value for name, value in overrides.items() if name not in OF_THE_AMPLITUDE}
        widest = species.bird(convention, **{**of_the_bird, "amplitude_m": error.wingspan_m})
        inputs = {**vars(widest), "amplitude_m": error.amplitude_m}
        return bird_of({entry.name: inputs[entry.name] for entry in fields(Bird)})


def _amplitude_m(species: Species, convention: str, overrides: dict[str, float]) -> float:
    try:
        return species.amplitude_m(convention, **overrides)
    except ImpossibleAmplitude as error:
        return error.amplitude_m


def _meets(job: Job, exclusion: Mapping[str, Condition]) -> bool:
    inputs = job.inputs()
    return all(condition.holds(_input(inputs, name)) for name, condition in exclusion.items())


def _input(inputs: Mapping[str, Any], name: str) -> Any:
    """Return one of a job's inputs by its name in a sweep file."""
    if name == STROKE_ANGLE:
        return math.degrees(math.asin(min(1.0, inputs["leader_amplitude_m"] / (2.0 * inputs["semispan_m"]))))
    return inputs[COLUMN.get(name, name)]
