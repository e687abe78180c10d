"""The best speed of a bird, a follower or a flock: least power, or least energy per distance over ground.

Speed is an outer variable: at each speed every follower is at its V optimum.  A few speeds are looked at from many
starts; about the best, lines are followed from speed to speed, and Newton's steps end where the slope vanishes.  There
the flock is found and proved by a complete search, and where that finds another flock, its speed is sought anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from upwash.journey.line import Birds, Line, Lines, line_of
from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.proof import PROVED
from upwash.optimum.settings import SearchSettings

LEAST_POWER, LEAST_TRANSPORT = CRITERIA = ("least-power", "least-transport")
"""What the best speed makes least: power, or energy per distance over ground."""

GRID = 11
"""Speeds that are looked at first."""

AROUND = (0.55, 1.6)
"""Between which multiples of the lone bird's best speed a flock's is sought first."""

STENCIL = 2e-3
"""Step of the slopes, in the logarithm of speed: noise and truncation are then alike, near 1e-9."""

FLAT = 1e-6
"""Slope of the logarithm of cost against that of speed that counts as none."""

SAME_COST = 1e-8
"""Costs that differ by no more than this share are one."""

ROUNDS = 5
"""How often a speed is sought anew, from the flock that the complete search finds there."""

KINK, BESIDE, SHARP, GOLDEN = 0.03, 1e-3, 1e-8, 0.5 * (math.sqrt(5.0) - 1.0)
"""How far to either side, in the logarithm of speed, a kink is sought; where its two sides are looked at; how sharply
it is told; and the golden section."""

NEXT = 1e-3
"""How far beyond the end of a line another one is looked for, in the logarithm of speed."""

NARROWEST, WIDEST = 0.3, 200.0
"""Speeds, in m/s, among which those at which a bird can fly are sought."""

Share = Callable[[Line], float]
"""The power that counts, in W, of a line."""


class NoSpeed(Exception):
    """There is no speed at which what is asked for can fly; the message says why, in one line."""


@dataclass(frozen=True)
class SpeedRange:
    """Speeds at which a bird can fly, and why not beyond.

    Attributes
    ----------
    low, high : float
        The ends, in m/s.
    below, above : str
        What forbids slower and faster flight, in one line.
    """

    low: float
    high: float
    below: str
    above: str


@dataclass(frozen=True)
class BestSpeed:
    """A best speed, and what is known of it.

    Attributes
    ----------
    line : Line
        The line that flies at it.
    power_w : float
        The power that counts there, in W.
    slope : float
        Slope of the logarithm of cost against that of speed: 0 where nothing holds the speed.
    bound : str
        What holds it otherwise, in one line; "" if nothing does.
    flock : FlockSolution or None
        The complete search and the proof there; None of a lone bird.
    """

    line: Line
    power_w: float
    slope: float
    bound: str
    flock: FlockSolution | None = None

    @property
    def speed_m_s(self) -> float:
        """The speed, in m/s."""
        return self.line.bird.speed_m_s

    @property
    def is_proved(self) -> bool:
        """Whether every follower's V optimum is proved to be its best at this speed."""
        members = self.flock.placed if self.flock else ()
        return all(member.proof.claims.v_optimum == PROVED for member in members if member.proof)


def speed_range(birds: Birds, errors: type[Exception] | tuple[type[Exception], ...]) -> SpeedRange:
    """Return the speeds at which there is a bird: the widest run of them.

    Parameters
    ----------
    birds : callable
        The bird at a speed in m/s; it raises one of `errors` where there is none.
    errors : type of exception
        What it raises.
    """

    def why_not(speed: float) -> str:
        try:
            birds(speed)
        except errors as error:
            return " ".join(str(error).split())
        return ""

    speeds = np.geomspace(NARROWEST, WIDEST, 120)
    known = [why_not(float(speed)) for speed in speeds]
    runs: list[list[int]] = []
    for number, reason in enumerate(known):
        if not reason:
            if number and not known[number - 1]:
                runs[-1].append(number)
            else:
                runs.append([number])
    if not runs:
        raise NoSpeed(known[len(known) // 2])
    widest = max(runs, key=len)

    def end(inside: float, outside: float) -> tuple[float, str]:
        reason = why_not(outside)
        while abs(outside / inside - 1.0) > 1e-9:
            middle = math.sqrt(inside * outside)
            if found := why_not(middle):
                outside, reason = middle, found
            else:
                inside = middle
        return inside, reason

    first, last = float(speeds[widest[0]]), float(speeds[widest[-1]])
    low, below = (
        end(first, float(speeds[widest[0] - 1])) if widest[0] else (first, "no slower speed is looked at")
    )
    is_open = widest[-1] + 1 < len(speeds)
    high, above = (
        end(last, float(speeds[widest[-1] + 1])) if is_open else (last, "no faster speed is looked at")
    )
    return SpeedRange(low, high, below, above)


@dataclass
class SpeedSearch:
    """The best speeds of one kind of bird, alone and in lines.

    Parameters
    ----------
    birds : callable
        The bird at a speed in m/s.
    within : SpeedRange
        At which speeds it can fly.
    lines : Lines
        Cost and wakes.
    search : SearchSettings
        Of the complete search at the speed found.
    tailwind_m_s : float
        Ground speed less airspeed, in m/s.
    depth : int
        Most followers of a line.
    """

    birds: Birds
    within: SpeedRange
    lines: Lines
    search: SearchSettings
    tailwind_m_s: float = 0.0
    depth: int = 0
    looked_at: dict[float, Line] = field(default_factory=dict)

    def cost(self, criterion: str, power_w: float, speed_m_s: float) -> float:
        """Return what a criterion makes least: power in W, or energy over ground in J/m."""
        if criterion == LEAST_POWER:
            return power_w
        ground = speed_m_s + self.tailwind_m_s
        return power_w / ground if ground > 0.0 else math.inf

    def alone(self, criterion: str, share: Share | None = None) -> BestSpeed:
        """Return the lone bird's best speed; `share` is its power if nothing else."""
        speeds = np.geomspace(self.within.low, self.within.high, 200)
        speeds[0], speeds[-1] = self.within.low, self.within.high
        share = share or (lambda line: self.lines.powers_w(line)[0])
        lines = [Line(self.birds(float(speed)), ()) for speed in speeds]
        costs = [self.cost(criterion, share(line), line.bird.speed_m_s) for line in lines]
        number = int(np.argmin(costs))
        if not math.isfinite(costs[number]):
            raise NoSpeed(_too_windy(self.tailwind_m_s, self.within))
        return self._refined(criterion, share, lines[number])

    def best(self, criterion: str, share: Share, depth: int) -> BestSpeed:
        """Return the best speed of a line of so many followers.

        Parameters
        ----------
        criterion : str
            One of `CRITERIA`.
        share : callable
            The power that counts of a line, in W.
        depth : int
            Followers.

        Raises
        ------
        NoSpeed
            If there is no such line at any speed that is looked at.
        """
        alone = self.alone(criterion).speed_m_s
        low, high = (max(self.within.low, min(self.within.high, alone * ratio)) for ratio in AROUND)
        grid = [float(speed) for speed in np.geomspace(low, high, GRID)]
        while True:
            lines = {speed: line for speed in grid if (line := self._line_at(speed).cut(depth))}
            if not lines:
                raise NoSpeed(
                    f"no line of {depth + 1} birds in a V at {grid[0]:.3g} to {grid[-1]:.3g} m/s: "
                    "expected some speed at which each has a V optimum, found none"
                )
            costs = {speed: self.cost(criterion, share(line), speed) for speed, line in lines.items()}
            least = min(costs, key=lambda speed: costs[speed])
            ratio = grid[1] / grid[0]
            if least == grid[-1] and least * ratio < self.within.high:
                grid.append(least * ratio)
            elif least == grid[0] and least / ratio > self.within.low:
                grid.insert(0, least / ratio)
            else:
                break
        return self._settled(criterion, share, lines[least], depth)

    def _line_at(self, speed: float) -> Line:
        """Look for the line at a speed, from those known next to it too; the same for any order of asking."""
        if speed not in self.looked_at:
            self.looked_at[speed] = self.lines.looked_for(
                self.birds(speed), self.depth, seed=self.search.seed
            )
        return self.looked_at[speed]

    def _settled(self, criterion: str, share: Share, line: Line, depth: int) -> BestSpeed:
        """Refine a speed until the complete search there finds the same flock."""
        seen: list[BestSpeed] = []
        for _ in range(ROUNDS):
            found = self._refined(criterion, share, line)
            flock = self.lines.proved(found.line.bird, depth, self.search)
            true = line_of(flock).cut(depth)
            if true is None:
                # The complete search ends the line where the local one went on.
                break
            power = share(true)
            if abs(power / found.power_w - 1.0) <= SAME_COST:
                return BestSpeed(found.line, found.power_w, found.slope, found.bound, flock)
            line = true
            slope = self._slope(criterion, share, true)
            seen.append(BestSpeed(true, power, slope[0] if slope else math.nan, ANOTHER, flock))
        if not seen:
            raise NoSpeed(
                f"no flock at {line.bird.speed_m_s:.4g} m/s: expected each bird at a V optimum, "
                "found by the complete search that the line ends"
            )
        return min(seen, key=lambda one: self.cost(criterion, one.power_w, one.speed_m_s))

    def _refined(self, criterion: str, share: Share, line: Line) -> BestSpeed:
        """Follow a line to the speed at which its cost is least."""
        edge = ""
        for _ in range(60):
            speed = line.bird.speed_m_s
            slopes = self._slope(criterion, share, line)
            if slopes is None:
                edge = edge or ENDS
                break
            slope, curvature = slopes
            if abs(slope) < 0.1 * FLAT:
                break
            # Newton's step where the cost is a valley, and never a long one.
            step = -slope / curvature if curvature > 0.0 else -math.copysign(0.05, slope)
            step = max(-0.1, min(0.1, step))
            moved, edge = self._moved(criterion, share, line, step)
            if moved is None or abs(math.log(moved.bird.speed_m_s / speed)) < NEXT:
                moved = (edge and self._beyond(criterion, share, line, step)) or moved
            if moved is None:
                break
            line = moved
            if abs(math.log(line.bird.speed_m_s / speed)) < 1e-12:
                break
        slopes = self._slope(criterion, share, line)
        if slopes is not None and abs(slopes[0]) <= FLAT:
            return BestSpeed(line, share(line), slopes[0], "")
        if held := self._end_of_range(line):
            return BestSpeed(line, share(line), slopes[0] if slopes else math.nan, held)
        return self._at_kink(criterion, share, line, edge or ENDS)

    def _at_kink(self, criterion: str, share: Share, line: Line, edge: str) -> BestSpeed:
        """Narrow down a least cost that no slope leads to: a kink, or the end of a line."""
        speed = line.bird.speed_m_s

        def cost(other: Line | None) -> float:
            return self.cost(criterion, share(other), other.bird.speed_m_s) if other else math.inf

        def at(offset: float) -> Line | None:
            target = speed * math.exp(offset)
            if not self.within.low <= target <= self.within.high:
                return None
            return self.lines.followed(line, self.birds, speed, target)

        low, high = -KINK, KINK
        while high - low > SHARP:
            inner, outer = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            low, high = (low, outer) if cost(at(inner)) <= cost(at(outer)) else (inner, high)
        best = min((at(0.5 * (low + high)), line), key=cost)
        assert best is not None
        speed, line = best.bird.speed_m_s, best
        before, after = at(-BESIDE), at(BESIDE)
        bound, slope = edge, math.nan
        if before and after:
            slopes = [math.log(cost(one) / cost(best)) for one in (before, after)]
            slope = (slopes[1] - slopes[0]) / (2.0 * BESIDE)
            bound = self.lines.what_changes(before, after)
        return BestSpeed(best, share(best), slope, bound)

    def _moved(self, criterion: str, share: Share, line: Line, step: float) -> tuple[Line | None, str]:
        """Return a line at another speed that costs no more, by a step or by part of it; and what held it."""
        speed = line.bird.speed_m_s
        cost, held = self.cost(criterion, share(line), speed), ""
        for _ in range(40):
            target = speed * math.exp(step)
            inside = min(max(target, self.within.low), self.within.high)
            found = self.lines.followed(line, self.birds, speed, inside)
            if found is None:
                held = ENDS
            elif self.cost(criterion, share(found), inside) <= cost * (1.0 + 1e-13):
                return found, held
            step *= 0.5
        return None, held

    def _beyond(self, criterion: str, share: Share, line: Line, step: float) -> Line | None:
        """Return a line just beyond the speed at which one ends, if it costs less."""
        speed, depth = line.bird.speed_m_s, len(line.poses)
        other = speed * math.exp(math.copysign(NEXT, step))
        if not self.within.low <= other <= self.within.high:
            return None
        found = self.lines.looked_for(self.birds(other), depth, [line], self.search.seed).cut(depth)
        least = self.cost(criterion, share(line), speed)
        return found if found and self.cost(criterion, share(found), other) < least else None

    def _slope(self, criterion: str, share: Share, line: Line) -> tuple[float, float] | None:
        """Return slope and curvature of the logarithm of cost against that of speed; None where the line ends."""
        speed = line.bird.speed_m_s
        centre = self.cost(criterion, share(line), speed)
        values = []
        for offset in (-2, -1, 1, 2):
            other = speed * math.exp(offset * STENCIL)
            if not self.within.low <= other <= self.within.high:
                return self._slope_at_end(criterion, share, line)
            found = self.lines.followed(line, self.birds, speed, other)
            if found is None:
                return None
            values.append(math.log(self.cost(criterion, share(found), other) / centre))
        back2, back, on, on2 = values
        slope = (8.0 * (on - back) - (on2 - back2)) / (12.0 * STENCIL)
        curvature = (16.0 * (on + back) - (on2 + back2)) / (12.0 * STENCIL**2)
        return slope, curvature

    def _slope_at_end(self, criterion: str, share: Share, line: Line) -> tuple[float, float] | None:
        """Return a one-sided slope near an end of the range, and a curvature of 0."""
        speed = line.bird.speed_m_s
        centre = self.cost(criterion, share(line), speed)
        inward = 1.0 if speed < math.sqrt(self.within.low * self.within.high) else -1.0
        other = speed * math.exp(inward * STENCIL)
        found = self.lines.followed(line, self.birds, speed, other)
        if found is None:
            return None
        return math.log(self.cost(criterion, share(found), other) / centre) / (inward * STENCIL), 0.0

    def _end_of_range(self, line: Line) -> str:
        speed = line.bird.speed_m_s
        if speed < self.within.low * math.exp(3.0 * STENCIL):
            return _limit(self.within.below)
        if speed > self.within.high * math.exp(-3.0 * STENCIL):
            return _limit(self.within.above)
        return ""


ENDS = "a follower's V optimum ends there"
ANOTHER = "another place becomes the best of a follower there"
"""What may hold a speed where the slope does not vanish."""


def _limit(reason: str) -> str:
    """Say that no bird flies beyond a speed, without what to do about it."""
    return f"no bird beyond: {reason.partition(';')[0]}"


def _too_windy(tailwind_m_s: float, within: SpeedRange) -> str:
    return (
        f"wind: expected a headwind slower than the bird can fly, {within.high:.3g} m/s, "
        f"found {-tailwind_m_s:.3g} m/s"
    )


def states_needed(birds: Birds, speeds: Iterable[float], lines: Lines) -> Lines:
    """Return lines in wakes of as many steps as the fastest of some speeds needs, the same for all speeds.

    A step more or less changes what followers save by a thousandth, which would be a jump on the way to a best speed.
    """
    model = lines.model
    for speed in speeds:
        bird = birds(speed)
        model = model.resolving(bird.wavelength_m / bird.semispan_m)
    return Lines(lines.objective, model)


def shares_of(lines: Lines, sizes: Sequence[int], shape: str) -> dict[int, Share]:
    """Return the mean power of flocks of some sizes, by size."""

    def mean(birds: int) -> Share:
        return lambda line: lines.flock_power_w(line, birds, shape)

    return {birds: mean(birds) for birds in sizes}
