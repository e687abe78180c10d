"""How far a flock flies on its fuel, beside a bird alone: flights, kept as they go on and proved at each tenth."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import pandas as pd
from joblib import Parallel, delayed

from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.columns import INTEGER, TEXT, Column, column, told
from upwash.errors import UpwashError
from upwash.journey.cruise import ADAPTED, CruiseLaw
from upwash.journey.flight import PARTS, Cruise, Flight, NoFlight, Profile, Step, at_parts
from upwash.journey.fuel import Fuel
from upwash.journey.line import Line, Lines, line_of
from upwash.journey.speed import LEAST_TRANSPORT, NoSpeed, SpeedSearch, speed_range, states_needed
from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.proof import PROVED
from upwash.optimum.settings import SearchSettings

MOST_BOXES = 300_000
"""Budget of boxes of each proof: one that takes more is left open, and told so."""

FASTER = 1.1
"""Wakes are told in as many steps as so many times the lone bird's best speed at take-off needs."""

SAME_POWER = 1e-7
"""Mean powers that differ by no more than this share are those of one flock."""

REVISIONS = 4
"""How often a flight is flown anew from a tenth at which the complete search found a better flock."""

UNBALANCED = 1e-8
"""Largest imbalance that a step may have, as a share of weight or drag."""

PROOFS = ("proved", "open", "")
"""Whether each follower's place at a step is proved to be its best; empty between the tenths, and of a lone bird."""

MIGRATION = (
    column("species"),
    column("objective"),
    column("amplitude_convention"),
    column("model"),
    column("span_law"),
    Column("birds", "1", "birds that fly together, and take turns at the front", INTEGER),
    Column("speed_rule", "", "whether the airspeed is held or adapted", TEXT),
    Column("fuel", "1", "fuel at take-off, as a share of the mass there"),
    Column("wind_m_s", "m/s", "tailwind; below 0 a headwind"),
    Column("efficiency", "1", "work over the energy burned for it"),
    Column("step", "1", "number of the step, 0 at take-off", INTEGER),
    Column("distance_m", "m", "distance over ground"),
    Column("time_s", "s", "time since take-off"),
    column("mass_kg"),
    Column("altitude_m", "m", "altitude; absent where the air is told by its density"),
    column("density_kg_m3"),
    column("speed_m_s"),
    Column("ground_speed_m_s", "m/s", "speed over ground"),
    Column("power_w", "W", "mean mechanical power of a bird in level flight"),
    Column("power_alone_w", "W", "mechanical power of a lone bird there"),
    Column("power_burned_w", "W", "mean power that is burned in level flight"),
    Column("saving", "1", "mean mechanical power less a lone bird's there", percent=True, format=".1f"),
    *(column(name) for name in ("x_m", "y_m", "z_m", "phase", "amplitude_m", "upstroke_span_ratio")),
    Column("residual", "1", "largest imbalance of any bird, as a share of weight or drag"),
    Column(
        "proof",
        "",
        "whether each follower's place is proved to be its best: proved, open, or not asked",
        TEXT,
    ),
    Column("error_m", "m", "estimated error of the distance"),
    Column("energy_j_m", "J/m", "mechanical energy over distance through the air since take-off"),
    Column("ended", "", "in the last row, why the flight ended", TEXT),
)
"""Columns of `migrate`, one row a step; places are those of bird 2."""


@dataclass(frozen=True)
class Journey:
    """A migration that is asked for.

    Parameters
    ----------
    birds : callable
        The bird at ``speed_m_s``, ``mass_kg`` and, if it changes, ``altitude_m`` or ``density_kg_m3``.
    own : Bird
        The bird at take-off, at its own speed.
    objective : str
        Name of the cost function that each follower minimises; its power is what is spent.
    model : WakeModel
        The wake.
    is_resolved : bool
        Whether the number of the model's steps is to be kept as it is.
    size : int
        Birds in the flock.
    shape : str
        One of the shapes of a flock.
    fuel_share : float
        Fuel at take-off, as a share of the mass there, from 0 to below 1.
    speed_rule : str
        Whether the airspeed is held or adapted.
    tailwind_m_s : float
        Ground speed less airspeed, in m/s.
    profile : Profile or None
        Altitude over distance; None where the air is told by its density.
    efficiency : float or None
        Work over the energy burned for it; the usual one if None.
    search : SearchSettings
        Of the complete searches.
    labels : mapping
        Columns that say what the rows are of.
    """

    birds: Callable[..., Bird]
    own: Bird
    objective: str = "power"
    model: WakeModel = field(default_factory=WakeModel)
    is_resolved: bool = False
    size: int = 12
    shape: str = "vee"
    fuel_share: float = 0.3
    speed_rule: str = ADAPTED
    tailwind_m_s: float = 0.0
    profile: Profile | None = None
    efficiency: float | None = None
    search: SearchSettings = field(default_factory=SearchSettings)
    labels: Mapping[str, Any] = field(default_factory=dict)

    @property
    def take_off_kg(self) -> float:
        """Mass at take-off, in kg."""
        return self.own.mass_kg

    @property
    def fuel(self) -> Fuel:
        """How fuel is turned into work."""
        lean = self.take_off_kg * (1.0 - self.fuel_share)
        return Fuel(lean) if self.efficiency is None else Fuel(lean, efficiency=self.efficiency)

    def flight(self, size: int, lines: Lines) -> Flight:
        """Return the flight of so many birds."""
        limited = replace(self.search, most_boxes=min(MOST_BOXES, self.search.most_boxes))
        law = CruiseLaw(
            self.birds,
            lines,
            size,
            self.shape,
            self.fuel,
            None if self.speed_rule == ADAPTED else self.own.speed_m_s,
            self.tailwind_m_s,
            limited,
        )
        fuel_kg = self.fuel_share * self.take_off_kg
        return Flight(
            law, self.take_off_kg, fuel_kg, self.fuel, self.tailwind_m_s, self.own.gravity_m_s2, self.profile
        )

    def lines(self) -> Lines:
        """Return lines in wakes of as many steps as the whole flight needs."""
        lines = Lines(self.objective, self.model)
        if self.is_resolved or not self.model.is_endless:
            return lines
        changes: dict[str, float] = {}
        if self.profile:
            changes["altitude_m"] = max(altitude for _, altitude in self.profile.points)

        def at(speed: float) -> Bird:
            return self.birds(speed_m_s=speed, **changes)

        if self.speed_rule != ADAPTED:
            return states_needed(at, [self.own.speed_m_s], lines)
        within = speed_range(at, UpwashError)
        fastest = (
            SpeedSearch(at, within, lines, self.search, self.tailwind_m_s).alone(LEAST_TRANSPORT).speed_m_s
        )
        return states_needed(at, [min(within.high, FASTER * fastest)], lines)


@dataclass
class Flown:
    """A flight as far as it has been flown.

    Attributes
    ----------
    steps : list of Step
        From take-off on.
    ended : str
        Why it ended; "" if it goes on.
    proofs : dict of int to str
        Number of a step -> whether its places are proved, as in `PROOFS`.
    """

    steps: list[Step] = field(default_factory=list)
    ended: str = ""
    proofs: dict[int, str] = field(default_factory=dict)


Keep = Callable[[dict[int, Flown]], None]


def migrate(
    journey: Journey,
    *,
    workers: int = 1,
    known: dict[int, Flown] | None = None,
    keep: Keep | None = None,
) -> pd.DataFrame:
    """Fly a bird alone and a flock on the same fuel, and return each step.

    Parameters
    ----------
    journey : Journey
        What is asked for.
    workers : int
        Processes that prove.
    known : dict, optional
        Size -> a flight that was kept, to be flown on.
    keep : callable, optional
        Takes the flights so far at each tenth.

    Returns
    -------
    DataFrame
        The columns of `MIGRATION`; of a flock that cannot take off one row, which says why.

    Raises
    ------
    UpwashError
        If the lone bird cannot take off.
    """
    flights = dict(known or {})
    try:
        lines = journey.lines()
    except NoSpeed as error:
        raise UpwashError(f"take-off: {error}") from error
    for size in sorted({1, journey.size}):
        flight = journey.flight(size, lines)
        flown = flights.setdefault(size, Flown())
        try:
            for _ in _flown_on(flight, flown, workers):
                if keep:
                    keep(flights)
        except NoFlight as error:
            if size == 1:
                raise UpwashError(f"take-off: expected a bird that can fly, found: {error}") from error
            flown.ended = str(error)
    rows = [row for size, flown in sorted(flights.items()) for row in _rows(journey, lines, size, flown)]
    return pd.DataFrame(rows, columns=[one.name for one in MIGRATION])


def _flown_on(flight: Flight, flown: Flown, workers: int) -> Iterator[None]:
    """Fly to the end and prove, stopping at each tenth; again from a tenth at which another flock is better."""
    law = flight.law
    assert isinstance(law, CruiseLaw)
    if not flown.steps:
        flown.steps.append(flight.start())
        yield
    for _ in range(REVISIONS):
        yield from _to_the_end(flight, flown)
        if not law.depth:
            return
        tenths = [number for number in at_parts(flown.steps, flight.fuel_kg) if number not in flown.proofs]
        found = Parallel(n_jobs=min(workers, max(1, len(tenths))))(
            delayed(law.lines.proved)(_line(flown.steps[number]).bird, law.depth, law.search)
            for number in tenths
        )
        for number, flock in zip(tenths, found, strict=True):
            if not _is_kept(law, flown, number, flock):
                break
        else:
            return
        yield


def _to_the_end(flight: Flight, flown: Flown) -> Iterator[None]:
    ended: list[str] = []
    if flown.ended:
        return
    for step in flight.steps(flown.steps[-1], ended):
        _check_balance(flight, step)
        flown.steps.append(step)
        if abs(step.burned_kg / flight.fuel_kg * PARTS % 1.0) < 1e-9:
            yield
    flown.ended = ended[0]
    yield


def _check_balance(flight: Flight, step: Step) -> None:
    law = flight.law
    assert isinstance(law, CruiseLaw)
    found = law.lines.imbalance(_line(step))
    if not found <= UNBALANCED:
        raise NoFlight(f"balance: expected lift and thrust to balance to {UNBALANCED:g}, found {found:.2g}")


def _is_kept(law: CruiseLaw, flown: Flown, number: int, flock: FlockSolution) -> bool:
    """Note what a complete search says of a step; where it finds another flock, go back there, and return False."""
    step, line = flown.steps[number], line_of(flock)
    if line.cut(law.depth) is None:
        del flown.steps[max(1, number) :]
        flown.ended = flock.members[-1].error
        return True
    power = law.power_w(line)
    if abs(power / step.cruise.power_w - 1.0) <= SAME_POWER:
        claims = [member.proof.claims.v_optimum for member in flock.placed if member.proof]
        flown.proofs[number] = "proved" if all(claim == PROVED for claim in claims) else "open"
        return True
    del flown.steps[number + 1 :]
    flown.steps[number] = replace(step, cruise=Cruise(step.cruise.speed_m_s, power, line))
    flown.proofs = {other: proof for other, proof in flown.proofs.items() if other < number}
    flown.ended = ""
    return False


def _line(step: Step) -> Line:
    line = step.cruise.state
    assert isinstance(line, Line)
    return line


def _rows(journey: Journey, lines: Lines, size: int, flown: Flown) -> Iterator[dict[str, Any]]:
    same = {
        **journey.labels,
        "objective": journey.objective,
        "model": lines.model.name(journey.own.wavelength_m / journey.own.semispan_m),
        **told({"span_law": lines.model.span_law}),
        "birds": size,
        "speed_rule": journey.speed_rule,
        "fuel": journey.fuel_share,
        "wind_m_s": journey.tailwind_m_s,
        "efficiency": journey.fuel.efficiency,
        "proof": "",
        "ended": "",
    }
    if not flown.steps:
        yield same | {"step": 0, "distance_m": 0.0, "ended": flown.ended}
        return
    for number, step in enumerate(flown.steps):
        line, bird = _line(step), _line(step).bird
        distance, time, energy, through_air = step.totals
        alone = lines.power_w(bird, bird.stroke)
        row = same | {
            "step": number,
            "distance_m": distance,
            "time_s": time,
            "mass_kg": step.mass_kg,
            "altitude_m": math.nan if step.altitude_m is None else step.altitude_m,
            "density_kg_m3": bird.density_kg_m3,
            "speed_m_s": bird.speed_m_s,
            "ground_speed_m_s": bird.speed_m_s + journey.tailwind_m_s,
            "power_w": step.cruise.power_w,
            "power_alone_w": alone,
            "power_burned_w": journey.fuel.chemical_w(step.cruise.power_w),
            "saving": 1.0 - step.cruise.power_w / alone,
            "residual": lines.imbalance(line),
            "proof": flown.proofs.get(number, ""),
            "error_m": step.error_m,
            "energy_j_m": energy / through_air if through_air else math.nan,
            "ended": flown.ended if number == len(flown.steps) - 1 else "",
        }
        for place in line.poses[:1]:
            row |= {name: getattr(place, name) for name in ("x_m", "y_m", "z_m", "phase")}
            row |= {"amplitude_m": place.stroke.amplitude_m, "upstroke_span_ratio": place.stroke.span_ratio}
        yield row


def as_text(inputs: Mapping[str, Any], flights: Mapping[int, Flown]) -> str:
    """Write flights, with what they are of, so that `from_text` reads them to the last digit."""
    told_flights = {
        str(size): {
            "ended": flown.ended,
            "proofs": {str(number): proof for number, proof in flown.proofs.items()},
            "steps": [_told(step) for step in flown.steps],
        }
        for size, flown in flights.items()
    }
    return json.dumps({"inputs": inputs, "flights": told_flights}, indent=1)


def _told(step: Step) -> dict[str, Any]:
    line = _line(step)
    return {
        **{
            name: getattr(step, name) for name in ("burned_kg", "mass_kg", "altitude_m", "error_m", "step_kg")
        },
        "totals": list(step.totals),
        "power_w": step.cruise.power_w,
        "bird": asdict(line.bird),
        "poses": [asdict(pose) for pose in line.poses],
    }


def from_text(text: str, inputs: Mapping[str, Any], place: str) -> dict[int, Flown]:
    """Read flights that `as_text` wrote.

    Raises
    ------
    UpwashError
        If it is no such text, or of another flight.
    """
    remedy = "name another file, or delete this one"
    try:
        content = json.loads(text)
        kept, flights = content["inputs"], content["flights"]
        found = {
            int(size): Flown(
                [_step_of(step) for step in flown["steps"]],
                str(flown["ended"]),
                {int(number): str(proof) for number, proof in flown["proofs"].items()},
            )
            for size, flown in flights.items()
        }
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UpwashError(
            f"{place}: expected a flight kept by 'upwash migrate', found no such; {remedy}"
        ) from error
    if kept != json.loads(json.dumps(inputs)):
        differ = ", ".join(name for name in inputs if kept.get(name) != inputs[name]) or "inputs"
        raise UpwashError(f"{place}: expected this flight, found one with other {differ}; {remedy}")
    return found


def _step_of(kept: Mapping[str, Any]) -> Step:
    poses = tuple(Pose(**{**pose, "stroke": Stroke(**pose["stroke"])}) for pose in kept["poses"])
    line = Line(Bird(**kept["bird"]), poses)
    distance, time, energy, through_air = kept["totals"]
    return Step(
        kept["burned_kg"],
        kept["mass_kg"],
        (distance, time, energy, through_air),
        kept["altitude_m"],
        Cruise(line.bird.speed_m_s, kept["power_w"], line),
        kept["error_m"],
        kept["step_kg"],
    )
