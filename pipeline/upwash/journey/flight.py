"""A flight from take-off to landing: mass falls as fuel is burned, and distance and time follow.

What is burned is the independent variable, so that a flight that goes well ends at a known value of it.  How fast the
bird flies and what it spends at a mass and an altitude is asked of a `Law`; the integration knows nothing of flocks.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import RK45

from upwash.journey.fuel import Fuel

PARTS = 10
"""Parts of the fuel at whose ends a flight is told, kept and proved."""

ACCURACY = 1e-7
"""Error of a step that is let pass, as a share of distance, time and energy of such a step."""

SHORTEST = 1e-5
"""Steps of less than this share of the fuel are not tried: there the flight has ended."""

DISTANCE, TIME, ENERGY, THROUGH_AIR = range(4)
"""Where a state holds ground distance in m, time in s, mechanical energy in J, and distance through the air in m."""


class NoFlight(Exception):
    """A bird cannot fly on; the message says why, in one line."""


@dataclass(frozen=True)
class Profile:
    """Altitude over ground distance: straight between some points, and level beyond the last.

    Parameters
    ----------
    points : sequence of (distance_m, altitude_m)
        By growing distance, the first at 0.
    """

    points: tuple[tuple[float, float], ...]

    def altitude_m(self, distance_m: float) -> float:
        """Return the altitude, in m."""
        distances, altitudes = zip(*self.points, strict=True)
        return float(np.interp(distance_m, distances, altitudes))

    def gradient(self, distance_m: float) -> float:
        """Return how steeply it climbs, in m/m."""
        for (start, low), (end, high) in pairwise(self.points):
            if start <= distance_m < end:
                return (high - low) / (end - start)
        return 0.0


class Law(Protocol):
    """How a bird flies at a mass and an altitude, found from how it flew a little before."""

    def __call__(self, mass_kg: float, altitude_m: float | None, before: Cruise | None) -> Cruise:
        """Return how it flies; raise `NoFlight` if it cannot."""


@dataclass(frozen=True)
class Cruise:
    """How a bird flies at one mass and altitude.

    Attributes
    ----------
    speed_m_s : float
        Airspeed, in m/s.
    power_w : float
        Mechanical power of a bird, the mean of its flock, in level flight, in W.
    state : object
        What the law keeps of it.
    """

    speed_m_s: float
    power_w: float
    state: object = None


@dataclass(frozen=True)
class Step:
    """A flight so far.

    Attributes
    ----------
    burned_kg, mass_kg : float
        Fuel burned, and mass left, in kg.
    totals : tuple of float
        Ground distance in m, time in s, mechanical energy in J, distance through the air in m.
    altitude_m : float or None
        Altitude, in m; None where the air is told by its density.
    cruise : Cruise
        How the bird flies.
    error_m : float
        Estimated error of the distance, in m.
    step_kg : float
        Next step of the integration, in kg of fuel.
    """

    burned_kg: float
    mass_kg: float
    totals: tuple[float, float, float, float]
    altitude_m: float | None
    cruise: Cruise
    error_m: float
    step_kg: float

    @property
    def distance_m(self) -> float:
        """Distance over ground, in m."""
        return self.totals[DISTANCE]


@dataclass(frozen=True)
class Flight:
    """A flight that is asked for.

    Parameters
    ----------
    law : callable
        How the bird flies at a mass and an altitude.
    take_off_kg, fuel_kg : float
        Mass at take-off, and what of it is fuel, in kg.
    fuel : Fuel
        How fuel is turned into work.
    tailwind_m_s : float
        Ground speed less airspeed, in m/s.
    gravity_m_s2 : float
        Gravitational acceleration, for what climbing takes.
    profile : Profile or None
        Altitude over distance; None where the air is told by its density.
    """

    law: Law
    take_off_kg: float
    fuel_kg: float
    fuel: Fuel
    tailwind_m_s: float = 0.0
    gravity_m_s2: float = 9.80665
    profile: Profile | None = None

    def start(self) -> Step:
        """Return the flight at take-off; raises `NoFlight` if there is none."""
        altitude = self.profile.altitude_m(0.0) if self.profile else None
        cruise = self._cruise(self.take_off_kg, altitude, None)
        return Step(0.0, self.take_off_kg, (0.0, 0.0, 0.0, 0.0), altitude, cruise, 0.0, self.fuel_kg / PARTS)

    def steps(self, start: Step, ended: list[str]) -> Iterator[Step]:
        """Fly on and give each step after `start`; why the flight ended is added to `ended`.

        Parameters
        ----------
        start : Step
            From where.
        ended : list of str
            Filled with one line when the flight has ended.
        """
        step = start
        while step.burned_kg < self.fuel_kg * (1.0 - 1e-12):
            part = math.floor(step.burned_kg / self.fuel_kg * PARTS + 1e-9) + 1
            end = self.fuel_kg if part >= PARTS else self.fuel_kg * part / PARTS
            try:
                for reached in self._to(step, end):
                    step = reached
                    yield step
            except NoFlight as error:
                ended.append(str(error))
                return
        ended.append(SPENT)

    def _to(self, start: Step, end_kg: float) -> Iterator[Step]:
        """Give each step up to where so much fuel is burned."""
        step = start
        latest: tuple[float, Cruise] = (step.burned_kg, step.cruise)

        def slopes(burned: float, totals: NDArray[np.float64]) -> NDArray[np.float64]:
            nonlocal latest
            latest = burned, self._cruise_at(burned, totals, step.cruise)
            return np.array(self._rates(latest[1], burned, totals))

        first = min(max(step.step_kg, 2.0 * SHORTEST * self.fuel_kg), end_kg - step.burned_kg)
        solver = RK45(
            slopes,
            step.burned_kg,
            np.array(step.totals),
            end_kg,
            first_step=first,
            rtol=ACCURACY,
            atol=ACCURACY * self._scale(step),
        )
        while solver.status == "running":
            try:
                solver.step()
            except NoFlight:
                solver.h_abs *= 0.25
                if solver.h_abs < SHORTEST * self.fuel_kg:
                    raise
                continue
            if solver.status == "failed":
                raise NoFlight("steps: expected power to change evenly, found that it jumps; hold the speed")
            totals = solver.y
            altitude = self.profile.altitude_m(totals[DISTANCE]) if self.profile else None
            # The last slope of a step is that at its end.
            burned, cruise = latest
            if burned != solver.t:
                cruise = self._cruise(self.take_off_kg - solver.t, altitude, step.cruise)
            error = abs(float((solver.K.T @ RK45.E)[DISTANCE] * (solver.t - solver.t_old)))
            step = Step(
                float(solver.t),
                float(self.take_off_kg - solver.t),
                (float(totals[0]), float(totals[1]), float(totals[2]), float(totals[3])),
                altitude,
                cruise,
                step.error_m + error,
                float(solver.h_abs),
            )
            yield step

    def _scale(self, step: Step) -> NDArray[np.float64]:
        """Return what a part of the fuel brings, roughly: distance, time, energy, distance through the air."""
        rates = self._rates(step.cruise, step.burned_kg, np.array(step.totals))
        return np.abs(np.array(rates)) * self.fuel_kg / PARTS

    def _cruise_at(self, burned: float, totals: NDArray[np.float64], before: Cruise) -> Cruise:
        altitude = self.profile.altitude_m(float(totals[DISTANCE])) if self.profile else None
        return self._cruise(self.take_off_kg - burned, altitude, before)

    def _cruise(self, mass_kg: float, altitude_m: float | None, before: Cruise | None) -> Cruise:
        cruise = self.law(mass_kg, altitude_m, before)
        if cruise.speed_m_s + self.tailwind_m_s <= 0.0:
            raise NoFlight(
                f"wind: expected a headwind slower than the bird, {cruise.speed_m_s:.3g} m/s, "
                f"found {-self.tailwind_m_s:.3g} m/s"
            )
        return cruise

    def _rates(
        self, cruise: Cruise, burned: float, totals: NDArray[np.float64]
    ) -> tuple[float, float, float, float]:
        """Return what a kilogram of fuel brings: distance, time, mechanical energy, distance through the air."""
        ground = cruise.speed_m_s + self.tailwind_m_s
        power = cruise.power_w
        if self.profile:
            # Going down gives back what going up took, as long as there is power to be saved.
            climbing = (self.take_off_kg - burned) * self.gravity_m_s2 * ground
            power = max(0.0, power + climbing * self.profile.gradient(float(totals[DISTANCE])))
        seconds = 1.0 / self.fuel.burned_kg_s(power)
        return ground * seconds, seconds, power * seconds, cruise.speed_m_s * seconds


SPENT = "the fuel is spent"
"""How a flight ends well."""


def at_parts(steps: Sequence[Step], fuel_kg: float) -> list[int]:
    """Return the numbers of the steps at take-off, at each part of the fuel, and at the end."""
    ends = [fuel_kg * part / PARTS for part in range(PARTS + 1)]
    found = [
        number
        for number, step in enumerate(steps)
        if any(abs(step.burned_kg - end) <= 1e-9 * fuel_kg for end in ends)
    ]
    return sorted({*found, 0, len(steps) - 1})


Keep = Callable[[Sequence[Step]], None]
"""Takes a flight so far, to be kept."""
