"""The job of one bird, as a command line asks for it: the same job, with the same id, as in a sweep.

And, around it, those of the birds that the species' own ranges allow.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from upwash.aero.bird import Bird
from upwash.aero.checked import Rule
from upwash.aero.wake import WakeModel
from upwash.errors import UpwashError
from upwash.jobs.job import BUILT_IN_SOLVER, Job
from upwash.jobs.kind import Kind
from upwash.jobs.pair import Pair
from upwash.species import Species, load_species
from upwash.species.file import did_you_mean, printable
from upwash.species.species import OF_THE_AMPLITUDE
from upwash.sweep.block import Block, Sample, model_of
from upwash.sweep.choices import (
    ALTITUDE,
    CHOICES,
    LEADER,
    MEMBERS,
    MODEL,
    OF_THE_BIRD,
    PARAMETERS,
    SPEED_OF,
)
from upwash.sweep.speeds import FOLLOWERS
from upwash.sweep.values import Setting


def single_job(
    kind: type[Kind],
    species: str,
    settings: Iterable[str],
    amplitude: str,
    model: str | None = None,
    parts: Mapping[str, Any] | None = None,
    leader: str | None = None,
    members: Sequence[str] = (),
    **choices: Any,
) -> Job:
    """Make the job of one bird.

    Parameters
    ----------
    kind : type of Kind
        What the job is.
    species : str
        Name in the library, or path of a species file.
    settings : iterable of str
        Inputs that differ from the species' own, each ``NAME=VALUE`` in SI units, named as in a sweep file.
    amplitude : str
        Amplitude convention.
    model : str
        Named model of the wake; the paper's if neither this nor a setting says.
    parts : mapping, optional
        Parts of it, and the distance, by options of their own -> value; None for one that is not given.
    leader : str, optional
        Species of the bird ahead in a pair, if it is another.
    members : sequence of str
        Species of the birds behind the first of a flock, if they are told.
    **choices
        Objective, seed, tolerance, whether birds beat in step, of a pair whose speed it is and, of a flock, birds,
        shape, wake and reading.

    Raises
    ------
    UpwashError
        If the species, an input or a value is wrong, or they make no bird.
    """
    if leader is not None:
        choices[LEADER] = load_species(leader)
    if members:
        choices[MEMBERS] = [load_species(one) for one in members]
    ((job, _),) = _block(kind, species, settings, amplitude, model, parts, choices).jobs()
    return job


@dataclass(frozen=True)
class Changing:
    """A bird some of whose inputs change, as a command line asks for it.

    Parameters
    ----------
    job : Job
        That of the bird as it is asked for.
    species : Species
        Its species.
    amplitude : str
        Amplitude convention.
    settings : mapping of str to Setting
        Inputs that differ from the species' own.
    """

    job: Job
    species: Species
    amplitude: str
    settings: Mapping[str, Setting]

    @property
    def model(self) -> WakeModel:
        """The model of the wake with the steps that were asked for, or those that it is named with."""
        return model_of(self.settings)

    @property
    def is_resolved(self) -> bool:
        """Whether the number of steps was asked for."""
        return "stroke_states" in self.settings

    def bird(self, **changes: float) -> Bird:
        """Return the bird with some inputs changed; the amplitude follows by its convention.

        Raises
        ------
        UpwashError
            If there is no such bird.
        """
        fixed = {name: one.value for name, one in self.settings.items() if name in OF_THE_BIRD}
        # Either tells the air.
        if "density_kg_m3" in changes:
            fixed.pop(ALTITUDE, None)
        if ALTITUDE in changes:
            fixed.pop("density_kg_m3", None)
        return self.species.bird(self.amplitude, **(fixed | changes))


def changing_bird(
    species: str, settings: Iterable[str], amplitude: str, model: str | None = None, **choices: Any
) -> Changing:
    """Return the bird of one job, some of whose inputs are to change; all else is as for `single_job`."""
    block = _block(Pair, species, settings, amplitude, model, None, choices)
    ((job, _),) = block.jobs()
    return Changing(job, block.species[0], amplitude, block.fixed)


def need_no_limits(job: Job, command: str) -> None:
    """Refuse limits on the follower's place where a command would not keep them.

    Raises
    ------
    UpwashError
        If the job has some.
    """
    if found := ", ".join(job.spacing.names):
        raise UpwashError(
            f"--set: expected no limit on the follower's place, as upwash {command} keeps none, found {found}; "
            "leave it out, or see `upwash optimum`"
        )


def jobs_within_ranges(count: int, points_seed: int, **asked: Any) -> dict[str, list[Job]]:
    """Make the jobs of a bird whose inputs are sampled from its species' own ranges, by both span laws.

    Parameters
    ----------
    count, points_seed : int
        Number of samples, the same points for both laws, and their seed.
    **asked
        As for `single_job`; what is set there is not sampled.

    Returns
    -------
    dict
        Span law -> the job of the bird itself, then those of the samples; samples that make no bird are left out.
    """
    kind, amplitude = asked.pop("kind"), asked.pop("amplitude")
    species, settings = asked.pop("species"), asked.pop("settings")
    if (leader := asked.pop(LEADER, None)) is not None:
        asked[LEADER] = load_species(leader)
    block = _block(
        kind, species, settings, amplitude, asked.pop("model", None), asked.pop("parts", None), asked
    )
    is_given = "amplitude_m" in block.fixed
    settled = {*block.fixed, *(OF_THE_AMPLITUDE if is_given else ())}
    if ALTITUDE in block.fixed:
        settled.add("density_kg_m3")
    if asked.get(SPEED_OF, FOLLOWERS) != FOLLOWERS:
        settled.add("speed_m_s")
    free = tuple(name for name in block.species[0].ranges(amplitude) if name not in settled)
    fixed = {name: setting for name, setting in block.fixed.items() if name != "span_law"}
    jobs = {}
    for law in ("stroke", "tip"):
        of_law = replace(block, fixed=fixed | {"span_law": Setting(law)})
        blocks = [of_law]
        if free and count:
            blocks.append(replace(of_law, sample=Sample("latin-hypercube", count, points_seed, None, free)))
        jobs[law] = [job for one in blocks for job, _ in one.jobs()]
    return jobs


def _block(
    kind: type[Kind],
    species: str,
    settings: Iterable[str],
    amplitude: str,
    model: str | None,
    parts: Mapping[str, Any] | None,
    choices: Mapping[str, Any],
) -> Block:
    """Return the block of one job; parameters and errors are those of `single_job`."""
    for name, value in choices.items():
        rule = CHOICES.get(name, kind.choices.get(name))
        if isinstance(rule, Rule) and (expected := rule.broken_by(value)):
            raise UpwashError(f"--{name}: expected {expected}, found {value}; correct it")
    fixed = settings_of(settings)
    for name, value in {MODEL: model, **(parts or {})}.items():
        option = f"--{name.replace('_', '-')}"
        if value is None:
            continue
        if name in fixed:
            raise UpwashError(f"{option}: expected each input once, found {name} in --set too; leave one out")
        fixed[name] = _checked(option, name, str(value))
    bird = load_species(species)
    # A stroke that no wing can make is a result in a sweep; here it is a mistake, which this finds.
    bird.bird(amplitude, **{name: one.value for name, one in fixed.items() if name in OF_THE_BIRD})
    return Block(
        kind=kind,
        solver=BUILT_IN_SOLVER,
        species=[bird],
        choices={"amplitude": [amplitude], **{name: [value] for name, value in choices.items()}},
        fixed=fixed,
        axes=[],
        sample=None,
        exclusions=[],
    )


def settings_of(texts: Iterable[str]) -> dict[str, Setting]:
    """Read inputs that are each written ``NAME=VALUE``.

    Raises
    ------
    UpwashError
        If one is written otherwise, unknown, out of range, or told twice.
    """
    fixed: dict[str, Setting] = {}
    for name, setting in map(_setting, texts):
        if name in fixed:
            raise UpwashError(f"--set {name}: expected each input once, found it twice; leave one out")
        fixed[name] = setting
    return fixed


def _setting(text: str) -> tuple[str, Setting]:
    """Read ``NAME=VALUE``."""
    name, equals, written = (part.strip() for part in text.partition("="))
    if not equals:
        raise UpwashError(f"--set: expected NAME=VALUE, found {printable(text)}; write as in speed_m_s=12")
    if name not in PARAMETERS:
        remedy = did_you_mean(name, PARAMETERS)
        raise UpwashError(f"--set: expected an input, found {printable(name)}; {remedy}")
    return name, _checked(f"--set {name}", name, written)


def _checked(option: str, name: str, written: str) -> Setting:
    """Return a parameter's value as it is written, if it can be."""
    value = _number(written)
    if expected := PARAMETERS[name].broken_by(value):
        raise UpwashError(f"{option}: expected {expected}, found {printable(written)}; correct it")
    return Setting(value)


def _number(written: str) -> Any:
    """Read a number as TOML would: whole without a point, and a text if it is none."""
    for kind in (int, float):
        with suppress(ValueError):
            return kind(written)
    return written
