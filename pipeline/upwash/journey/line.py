"""A line of birds, each behind the next, followed while the bird changes: its speed, its mass or its air.

A flock in which each bird feels the one that it follows is one line, or two that mirror each other; whoever flies in
one row flies alike.  A line is found as a flock is, bird by bird, by the search and the proof of `upwash.optimum`.
Where the bird changes a little it is *followed*: each local optimum is solved for again from the last one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.optimum.endless.evidence import gather_endless_evidence
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.endless.solve import stays_in_v
from upwash.optimum.evidence import Evidence, gather_evidence
from upwash.optimum.flock import solve_flock
from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.pair import pair_problems
from upwash.optimum.pieces import LEAST_CURVATURE, STATIONARY
from upwash.optimum.problem import PairProblem
from upwash.optimum.record import V_LABELS, labels, record
from upwash.optimum.search import Basin, Search
from upwash.optimum.settings import FlockRules, SearchSettings
from upwash.optimum.variables import SCALE
from upwash.optimum.verify import examine, point_in

JUMP = 0.5
"""How far an optimum may move in one step, in the scales of its variables, and still count as the same one."""

FEWEST_STEPS = 2**8
"""A change is followed in halves of halves, down to this part of it."""

STARTS = 60
"""Random starts in the V when a line is looked for without a proof."""

STARTS_ENDLESS = 16
"""The same behind an endless wake, where descents are longer and basins few."""

BOUNDS_IN_WORDS = {
    "h_lower": "least amplitude",
    "h_upper": "greatest amplitude",
    "R_lower": "least upstroke span ratio",
    "R_upper": "greatest upstroke span ratio",
    "mu_lower": "phase exactly opposite",
    "mu_upper": "phase exactly the same",
}
"""Bounds of a follower's variables, by their names in the results."""

Birds = Callable[[float], Bird]
"""The bird at a value of what changes."""


def row_of(number: int, shape: str) -> int:
    """Return how many birds of its own line fly ahead of a bird, the first being number 1."""
    return FlockRules(shape).row_of(number)


@dataclass(frozen=True)
class Line:
    """A line of birds.

    Attributes
    ----------
    bird : Bird
        The first, which sets weight, drag and circulation for all.
    poses : tuple of Pose
        Of each further bird, relative to the one ahead, to its right.
    """

    bird: Bird
    poses: tuple[Pose, ...]

    def strokes(self) -> tuple[Stroke, ...]:
        """Return how each bird flaps, the first one included."""
        return (self.bird.stroke, *(pose.stroke for pose in self.poses))

    def cut(self, depth: int) -> Line | None:
        """Return the line of the first so many followers; None if it ends before."""
        return replace(self, poses=self.poses[:depth]) if len(self.poses) >= depth else None


@dataclass(frozen=True)
class Lines:
    """Lines of birds of one kind: what is least for each, and in which wakes.

    Parameters
    ----------
    objective : str
        Name of the cost function that each follower minimises.
    model : WakeModel
        Resolution of the wakes.
    """

    objective: str
    model: WakeModel

    def power_w(self, bird: Bird, stroke: Stroke) -> float:
        """Return the power of a bird with a stroke, in W: the objective's, or total power where that is a force."""
        function = COST_FUNCTIONS[self.objective]
        if function.unit == "N":
            function = COST_FUNCTIONS["power"]
        # Alone it makes its weight and its drag, by their definition.
        force = (bird.weight_n, bird.drag_n) if stroke == bird.stroke else bird.self_force_n(stroke)
        return function.value(bird, *force) * (bird.speed_m_s if function.per_metre else 1.0)

    def powers_w(self, line: Line) -> list[float]:
        """Return the power of each bird of a line, in W."""
        return [self.power_w(line.bird, stroke) for stroke in line.strokes()]

    def flock_power_w(self, line: Line, birds: int, shape: str) -> float:
        """Return the mean power of the birds of a flock that flies in such lines, in W."""
        powers = self.powers_w(line)
        return sum(powers[row_of(number, shape)] for number in range(1, birds + 1)) / birds

    def imbalance(self, line: Line) -> float:
        """Return the largest imbalance of any bird, as a share of weight or drag, by the plain physics."""
        worst = 0.0
        for ahead, pose in zip(line.strokes(), line.poses, strict=False):
            found = record(line.bird, self.objective, ahead, pose, self.model)
            worst = max(worst, abs(found.residual_lift), abs(found.residual_thrust))
        return worst

    def active_bounds(self, line: Line) -> list[str]:
        """Return which bounds of its variables hold each follower of a line, comma separated."""
        held = []
        for ahead, pose in zip(line.strokes(), line.poses, strict=False):
            found = examine(self._problems(line.bird, ahead), pose)
            held.append(found[0].active_bounds if found else "")
        return held

    def what_changes(self, slower: Line, faster: Line) -> str:
        """Say in one line what holds a follower on one side of a speed and not on the other."""
        sides = zip(self.active_bounds(slower), self.active_bounds(faster), strict=True)
        for row, (before, after) in enumerate(sides, start=2):
            changed = sorted(set(before.split(",")) ^ set(after.split(",")) - {""})
            if bounds := " and ".join(BOUNDS_IN_WORDS.get(name, name) for name in changed if name):
                return f"a kink: row {row} of the flock flaps with its {bounds} on one side of it alone"
        return "a kink: what holds a follower, as the edge of a vortex core, changes there"

    def proved(self, bird: Bird, depth: int, search: SearchSettings) -> FlockSolution:
        """Find a line of so many followers by a complete search, each with its proof."""
        if depth < 1:
            raise ValueError(f"depth: expected at least one follower, found {depth}")
        rules = FlockRules("echelon")
        return solve_flock(bird, depth + 1, self.objective, rules=rules, model=self.model, search=search)

    def looked_for(self, bird: Bird, depth: int, known: Sequence[Line] = (), seed: int = 0) -> Line:
        """Look for a line from random starts and from those of other birds, without a proof; it may end early.

        Parameters
        ----------
        bird : Bird
            The first bird.
        depth : int
            Followers, at most.
        known : sequence of Line
            Lines of similar birds, from which it is looked for as well.
        seed : int
            Seed of the random starts.
        """
        poses: list[Pose] = []
        ahead = bird.stroke
        for row in range(depth):
            problems = self._problems(bird, ahead)
            starts = [_moved(line, row, bird, ahead) for line in known if len(line.poses) > row]
            if poses:
                starts.append(_moved(Line(bird, tuple(poses)), row - 1, bird, ahead))
            found = self._best(problems, starts, seed)
            if found is None:
                break
            poses.append(found)
            ahead = found.stroke
        return Line(bird, tuple(poses))

    def followed(self, line: Line, birds: Birds, start: float, end: float) -> Line | None:
        """Follow a line while the bird changes; None if it leaves the V, or its optima end.

        Parameters
        ----------
        line : Line
            That of `birds(start)`.
        birds : callable
            The bird at each value of what changes.
        start, end : float
            Between which values it changes.
        """
        at, step = 0.0, 1.0
        while at < 1.0:
            bird = birds(start + min(at + step, 1.0) * (end - start))
            found = self._followed(line, bird)
            if found is None:
                step *= 0.5
                if step * FEWEST_STEPS < 1.0:
                    return None
                continue
            line, at = found, at + step
        return line

    def _followed(self, line: Line, bird: Bird) -> Line | None:
        poses: list[Pose] = []
        ahead = bird.stroke
        for row in range(len(line.poses)):
            start = _moved(line, row, bird, ahead)
            found = self._nearest(self._problems(bird, ahead), start)
            if found is None:
                return None
            poses.append(found)
            ahead = found.stroke
        return Line(bird, tuple(poses))

    def _problems(self, bird: Bird, ahead: Stroke) -> Sequence[PairProblem]:
        return pair_problems(bird, self.objective, ahead, None, self.model)

    def _nearest(self, problems: Sequence[PairProblem], start: Pose) -> Pose | None:
        """Return the local optimum in the V that a start descends to, if it lies near."""
        best: tuple[float, Pose] | None = None
        for problem in problems:
            point = point_in(problem, start)
            if point is None:
                continue
            inside = np.clip(point, *problem.bounds.T)
            for basin in _search(problem).descend(inside[None, :]):
                near = np.max(np.abs(basin.point - point) / SCALE) < JUMP
                if near and _is_in_v(problem, basin) and (best is None or basin.cost < best[0]):
                    best = basin.cost, problem.pose(basin.point)
        return best[1] if best else None

    def _best(self, problems: Sequence[PairProblem], starts: Sequence[Pose], seed: int) -> Pose | None:
        """Return the best local optimum in the V of those that some starts descend to."""
        found: list[tuple[float, PairProblem, Search, Basin]] = []
        for problem in problems:
            search, v_bounds = _search(problem, seed), problem.v_bounds()
            if np.any(v_bounds[:, 0] > v_bounds[:, 1]):
                continue
            count = STARTS_ENDLESS if isinstance(problem, EndlessProblem) else STARTS
            points = list(search.random_starts(v_bounds, -(-count // len(problems))))
            known = [point_in(problem, start) for start in starts]
            points += [np.clip(point, *problem.bounds.T) for point in known if point is not None]
            found += [(basin.cost, problem, search, basin) for basin in search.descend(np.array(points))]
        for _, problem, search, basin in sorted(found, key=lambda one: one[0]):
            if _is_in_v(problem, basin) and _is_optimum(problem, search, basin):
                return problem.pose(basin.point)
        return None


def line_of(flock: FlockSolution) -> Line:
    """Return the line that a flock in echelon is, up to where it ends."""
    return Line(flock.bird, tuple(member.optimum.pose for member in flock.placed if member.optimum))


def _moved(line: Line, row: int, bird: Bird, ahead: Stroke) -> Pose:
    """Return where a bird of another line would fly: as far in wavelengths and in amplitudes of the one ahead."""
    pose, before = line.poses[row], line.strokes()[row]
    along = bird.wavelength_m / line.bird.wavelength_m
    high = ahead.amplitude_m / before.amplitude_m
    stroke = Stroke(pose.stroke.amplitude_m * high, pose.stroke.span_ratio)
    aside = bird.semispan_m / line.bird.semispan_m
    return replace(pose, x_m=pose.x_m * along, y_m=pose.y_m * aside, z_m=pose.z_m * high, stroke=stroke)


def _search(problem: PairProblem, seed: int = 0) -> Search:
    return EndlessSearch(problem, seed) if isinstance(problem, EndlessProblem) else Search(problem, seed)


def _is_in_v(problem: PairProblem, basin: Basin) -> bool:
    return labels(problem.bird, problem.pose(basin.point).position_m) == V_LABELS


def _is_optimum(problem: PairProblem, search: Search, basin: Basin) -> bool:
    """Whether a basin is a local optimum that is no artefact of steps, as the search of a pair asks."""
    evidence: Evidence
    if isinstance(problem, EndlessProblem):
        evidence = gather_endless_evidence(problem, basin.point)
    else:
        evidence = gather_evidence(problem, search.felt, basin.point)
    is_convex = evidence.curvature is None or evidence.curvature > LEAST_CURVATURE
    if evidence.stationarity >= STATIONARY or not is_convex:
        return False
    return not isinstance(problem, EndlessProblem) or stays_in_v(problem, basin.point)
