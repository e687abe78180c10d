"""Local solves from many starts, merged into basins.

Each start descends to a local optimum, and optima closer than a distance in scaled variables are one basin.  Starts
are drawn first over the kinds of place that a follower may have, the same number in each: a small place, as that beside
the leader, has its optima like a large one.  Good optima lie near other good optima, so starts are then drawn around
the best, and around those that this finds.  The same seed gives the same basins for any number of workers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled.descent import SOLVED
from upwash.optimum.compiled.pair_descent import solve_many
from upwash.optimum.edges import felt_lanes
from upwash.optimum.problem import ASTERN, OUTBOARD, PairProblem
from upwash.optimum.spacing import ON_WALL, moved_inside, wall_values
from upwash.optimum.variables import SCALE, VARIABLE_COUNT, neighbourhood_of

SAME_BASIN = 1e-4
"""Largest distance of two ends of local solves, in units of `SCALE`, that are taken for one optimum."""

NEAR_BEST = 1.02
"""Basins that cost at most this many times the best are searched around."""

NEIGHBOURS, MOST_NEIGHBOURHOODS = 30, 40
"""Starts around a basin; basins that are searched around at most, the best first."""


@dataclass(frozen=True)
class Basin:
    """One local optimum in scaled variables.

    Attributes
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    cost : float
        Cost over that of the lone leader.
    multipliers : (2,) ndarray of float
        Multipliers of the lift and the thrust balance.
    hits : int
        How many starts ended here.
    """

    point: NDArray[np.float64]
    cost: float
    multipliers: NDArray[np.float64]
    hits: int


class Search:
    """The basins of one problem, as far as they have been found.

    Parameters
    ----------
    problem : PairProblem
        What to solve.
    seed : int
        Seed of the random starts.
    """

    solve_many: Callable[..., int] = staticmethod(solve_many)

    def __init__(self, problem: PairProblem, seed: int = 0) -> None:
        self.problem = problem
        self.random = np.random.default_rng(seed)
        self.felt: Any = self.wake_felt()
        self.starts = 0
        self.basins: list[Basin] = []
        self.searched_around: list[Basin] = []

    def wake_felt(self) -> Any:
        """Return the wake as the local solve takes it."""
        return felt_lanes(self.problem.lanes, self.problem.bounds, self.problem.walls)

    @property
    def edge_count(self) -> int:
        """Number of core edges."""
        return len(self.felt.representative)

    @property
    def _surface_count(self) -> int:
        return self.edge_count + len(self.problem.walls)

    def random_starts(self, bounds: NDArray[np.float64], count: int) -> NDArray[np.float64]:
        """Draw starts evenly over a box."""
        return bounds[:, 0] + self.random.random((count, VARIABLE_COUNT)) * (bounds[:, 1] - bounds[:, 0])

    def descend(self, starts: NDArray[np.float64], bounds: NDArray[np.float64] | None = None) -> list[Basin]:
        """Solve from each start and return the basins reached, best first.

        Parameters
        ----------
        starts : (n, VARIABLE_COUNT) ndarray of float
            Starts.
        bounds : (6, 2) ndarray of float, optional
            Bounds to solve within; the problem's if not given.
        """
        found = self._solve(starts, self.problem.bounds if bounds is None else bounds)
        self.starts += len(starts)
        return merge_basins(found)

    def _solve(self, starts: NDArray[np.float64], bounds: NDArray[np.float64]) -> list[Basin]:
        n, edges, walls = len(starts), self._surface_count, self.problem.walls
        points, costs, status = np.empty((n, VARIABLE_COUNT)), np.empty(n), np.empty(n, dtype=np.int64)
        multipliers, pins = np.empty((n, 2)), np.empty((n, edges))
        found = points, costs, multipliers, pins, status
        starts = moved_inside(starts, walls, bounds) if len(walls) else starts
        self.solve_many(np.ascontiguousarray(starts), self.felt, self.problem.constants, bounds, *found)
        keeps = np.all(wall_values(points, walls) > -ON_WALL, axis=1)
        return [
            Basin(points[k], float(costs[k]), multipliers[k], 1)
            for k in np.flatnonzero((status == SOLVED) & keeps)
        ]

    def explore(self, starts: NDArray[np.float64]) -> None:
        """Solve from each start within the problem's bounds and keep the basins."""
        self.basins = merge_basins(self.basins + self.descend(starts))

    def explore_places(self, count: int) -> None:
        """Solve from so many starts each outboard and inboard, astern and abreast."""
        for axis_ranges in product(
            parts_of(self.problem.bounds[0], ASTERN), parts_of(self.problem.bounds[1], OUTBOARD)
        ):
            place = self.problem.bounds.copy()
            place[:2] = axis_ranges
            self.explore(self.random_starts(place, count))

    def explore_around_best(self, least: float = np.inf) -> None:
        """Solve from starts around each basin that costs nearly as little as the best, and those so found.

        Parameters
        ----------
        least : float
            Cost of the best, if that is of another problem.
        """
        while new := self._not_searched_around(least):
            self.searched_around += new
            self.explore(np.concatenate([self._neighbours(basin) for basin in new]))

    def _not_searched_around(self, least: float) -> list[Basin]:
        best = min([least, *(basin.cost for basin in self.basins[:1])])
        near = [basin for basin in self.basins if basin.cost <= NEAR_BEST * best]
        new = [basin for basin in near if find_basin(basin, self.searched_around) is None]
        return new[: MOST_NEIGHBOURHOODS - len(self.searched_around)]

    def _neighbours(self, basin: Basin) -> NDArray[np.float64]:
        around, far = self.problem.bounds.copy(), neighbourhood_of(self.problem.variables)
        is_near = np.isfinite(far)
        around[is_near] = basin.point[is_near, None] + far[is_near, None] * [-1.0, 1.0]
        return np.clip(self.random_starts(around, NEIGHBOURS), *self.problem.bounds.T)


def parts_of(bounds: NDArray[np.float64], wall: float) -> list[tuple[float, float]]:
    """Split a range at a wall, if it lies within."""
    low, high = bounds
    return [(low, wall), (wall, high)] if low < wall < high else [(low, high)]


def find_basin(basin: Basin, known: list[Basin]) -> int | None:
    """Return which of the known basins is the same as one, or None."""
    if not known:
        return None
    apart = np.abs(np.array([one.point for one in known]) - basin.point) / SCALE
    same = np.flatnonzero(np.max(apart, axis=1) < SAME_BASIN)
    return int(same[0]) if same.size else None


def merge_basins(basins: list[Basin]) -> list[Basin]:
    """Merge basins that are one optimum, add up their hits and sort them by cost, the best first."""
    merged: list[Basin] = []
    for basin in sorted(basins, key=lambda b: b.cost):
        k = find_basin(basin, merged)
        if k is None:
            merged.append(basin)
        else:
            merged[k] = replace(merged[k], hits=merged[k].hits + basin.hits)
    return merged
