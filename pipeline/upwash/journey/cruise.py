"""How a flock flies at a mass and in an air: its line followed from a little before, its speed held or adapted."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from upwash.aero.bird import Bird
from upwash.errors import UpwashError
from upwash.journey.flight import Cruise, NoFlight
from upwash.journey.fuel import Fuel
from upwash.journey.line import Line, Lines, row_of
from upwash.journey.speed import LEAST_TRANSPORT, NoSpeed, SpeedSearch, speed_range
from upwash.optimum.settings import SearchSettings

HELD, ADAPTED = SPEED_RULES = ("held", "adapted")
"""The species' own speed all the way, or at each mass the speed of most range."""

STENCIL = 4e-3
"""Step of the slopes, in the logarithm of speed: the cost is then told to 1e-9."""

STILL = 2e-5
"""Steps of the logarithm of speed shorter than this change the cost by no more than 1e-9."""

GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


@dataclass(frozen=True)
class CruiseLaw:
    """How a flock flies.

    Parameters
    ----------
    birds : callable
        The bird at ``speed_m_s``, ``mass_kg`` and, if it changes, ``altitude_m``.
    lines : Lines
        Cost and wakes.
    size : int
        Birds that fly together and take turns at the front.
    shape : str
        Shape of their flock.
    fuel : Fuel
        How fuel is turned into work: what is least for a distance depends on it.
    own_speed_m_s : float or None
        The airspeed that is held; None if it is adapted.
    tailwind_m_s : float
        Ground speed less airspeed, in m/s.
    search : SearchSettings
        Of the complete search at take-off.
    """

    birds: Callable[..., Bird]
    lines: Lines
    size: int
    shape: str
    fuel: Fuel
    own_speed_m_s: float | None
    tailwind_m_s: float
    search: SearchSettings

    @property
    def depth(self) -> int:
        """Followers of a line."""
        return row_of(self.size, self.shape)

    def __call__(self, mass_kg: float, altitude_m: float | None, before: Cruise | None) -> Cruise:
        """Return how it flies; see `upwash.journey.flight.Law`."""
        at = self._birds_at(mass_kg, altitude_m)
        try:
            if before is None:
                return self._cruise(self._at_take_off(at))
            line = before.state
            assert isinstance(line, Line)
            return self._cruise(self._from(line, at))
        except UpwashError as error:
            raise NoFlight(f"no bird: {error}") from error

    def _birds_at(self, mass_kg: float, altitude_m: float | None) -> Callable[[float], Bird]:
        changes = {"mass_kg": mass_kg} | ({} if altitude_m is None else {"altitude_m": altitude_m})
        return lambda speed: self.birds(speed_m_s=speed, **changes)

    def _cruise(self, line: Line) -> Cruise:
        return Cruise(line.bird.speed_m_s, self.power_w(line), line)

    def power_w(self, line: Line) -> float:
        """Return the mean mechanical power of the flock, in W."""
        return self.lines.flock_power_w(line, self.size, self.shape)

    def _cost(self, line: Line) -> float:
        """Return what a distance over ground costs, in J of fuel a metre."""
        ground = line.bird.speed_m_s + self.tailwind_m_s
        return self.fuel.chemical_w(self.power_w(line)) / ground if ground > 0.0 else math.inf

    def _at_take_off(self, at: Callable[[float], Bird]) -> Line:
        if self.own_speed_m_s is not None:
            bird = at(self.own_speed_m_s)
            if not self.depth:
                return Line(bird, ())
            flock = self.lines.proved(bird, self.depth, self.search)
            if len(flock.placed) <= self.depth:
                raise NoFlight(flock.members[-1].error)
            poses = tuple(member.optimum.pose for member in flock.placed if member.optimum)
            return Line(bird, poses)
        try:
            within = speed_range(at, UpwashError)
            sought = SpeedSearch(at, within, self.lines, self.search, self.tailwind_m_s, self.depth)

            def burned(line: Line) -> float:
                return self.fuel.chemical_w(self.power_w(line))

            if not self.depth:
                return sought.alone(LEAST_TRANSPORT, burned).line
            return sought.best(LEAST_TRANSPORT, burned, self.depth).line
        except NoSpeed as error:
            raise NoFlight(str(error)) from error

    def _from(self, line: Line, at: Callable[[float], Bird]) -> Line:
        """Return the line of another bird near by, at the speed that the rule says."""
        before = line.bird
        if self.own_speed_m_s is not None:
            return self._followed(line, at, self.own_speed_m_s)
        some = at(before.speed_m_s)
        heavier = some.weight_n / before.weight_n * before.density_kg_m3 / some.density_kg_m3
        here = self._followed(line, at, before.speed_m_s * math.sqrt(heavier))
        for _ in range(12):
            sides = [self._near(here, at, offset) for offset in (-STENCIL, STENCIL)]
            if sides[0] is None or sides[1] is None:
                break
            cost = self._cost(here)
            back, on = (math.log(self._cost(side) / cost) for side in sides if side)
            slope, curvature = (on - back) / (2.0 * STENCIL), (on + back) / STENCIL**2
            step = -slope / curvature if curvature > 0.0 else -math.copysign(0.05, slope)
            step = max(-0.05, min(0.05, step))
            if abs(step) < STILL:
                return here
            moved = self._near(here, at, step)
            if moved is None or self._cost(moved) > cost * (1.0 + 1e-12):
                break
            here = moved
        return self._at_kink(here, at)

    def _near(self, line: Line, at: Callable[[float], Bird], offset: float) -> Line | None:
        speed = line.bird.speed_m_s
        try:
            return self.lines.followed(line, at, speed, speed * math.exp(offset))
        except UpwashError:
            return None

    def _at_kink(self, line: Line, at: Callable[[float], Bird]) -> Line:
        """Return the cheapest near by where no slope leads to it: at a kink, or where a line or a range ends."""

        def cost(other: Line | None) -> float:
            return self._cost(other) if other else math.inf

        low, high = -2.5 * STENCIL, 2.5 * STENCIL
        while high - low > 1e-7:
            inner, outer = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            if cost(self._near(line, at, inner)) <= cost(self._near(line, at, outer)):
                high = outer
            else:
                low = inner
        return min((self._near(line, at, 0.5 * (low + high)) or line, line), key=cost)

    def _followed(self, line: Line, at: Callable[[float], Bird], speed: float) -> Line:
        """Return the line of a bird near by, followed or, where it ends, looked for anew."""
        start, end = line.bird, at(speed)

        def between(share: float) -> Bird:
            if share >= 1.0:
                return end
            return self.birds(
                speed_m_s=start.speed_m_s + share * (end.speed_m_s - start.speed_m_s),
                mass_kg=start.mass_kg + share * (end.mass_kg - start.mass_kg),
                density_kg_m3=start.density_kg_m3 + share * (end.density_kg_m3 - start.density_kg_m3),
            )

        found = self.lines.followed(line, between, 0.0, 1.0)
        if found is None:
            found = self.lines.looked_for(end, self.depth, [line], self.search.seed).cut(self.depth)
        if found is None:
            flock = self.lines.proved(end, self.depth, self.search)
            if len(flock.placed) <= self.depth:
                raise NoFlight(flock.members[-1].error)
            poses = tuple(member.optimum.pose for member in flock.placed if member.optimum)
            found = Line(end, poses)
        return found
