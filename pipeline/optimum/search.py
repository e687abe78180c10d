"""Local solves from many starts, merged into basins.

Starts are drawn over the whole of a box, each descends to a local optimum, and optima closer than a distance in scaled
variables are one basin.  The same seed gives the same basins on any machine and for any number of workers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from pipeline.optimum.edges import distinct_edges
from pipeline.optimum.local import SCALE, SOLVED, solve_local
from pipeline.optimum.problem import CORE2, PairProblem

SAME_BASIN = 1e-4
"""Largest distance of two ends of local solves, in units of `SCALE`, that are taken for one optimum."""


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
    pins : (e,) ndarray of float
        Multipliers of the core edges to which the optimum is pinned, 0 for the others.
    hits : int
        How many starts ended here.
    """

    point: NDArray[np.float64]
    cost: float
    multipliers: NDArray[np.float64]
    pins: NDArray[np.float64]
    hits: int


@njit(cache=True, nogil=True, error_model="numpy")
def solve_many(
    starts, lanes, group, representative, constants, bounds, points, costs, multipliers, pins, status
):
    """Solve from every start; all results are written into the arrays given.

    Parameters
    ----------
    starts : (n, 6) ndarray of float
        Starts.
    lanes, group, representative, constants, bounds
        See `pipeline.optimum.local.solve_local`.
    points, costs, multipliers, pins, status : ndarray
        Overwritten: (n, 6), (n,), (n, 2), (n, e) and (n,), one row a start.

    Returns
    -------
    int
        Steps taken in all.
    """
    steps = 0
    for k in range(starts.shape[0]):
        status[k], costs[k], taken = solve_local(
            starts[k],
            lanes,
            group,
            representative,
            constants,
            bounds,
            points[k],
            multipliers[k],
            pins[k],
        )
        steps += taken
    return steps


class Search:
    """The basins of one problem, as far as they have been found.

    Parameters
    ----------
    problem : PairProblem
        What to solve.
    """

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        self.group, self.representative = distinct_edges(
            problem.lanes, problem.constants[CORE2], problem.bounds
        )
        self.starts = 0
        self.basins: list[Basin] = []

    def random_starts(self, bounds: NDArray[np.float64], count: int, seed: int) -> NDArray[np.float64]:
        """Draw starts evenly over a box; the same seed gives the same starts."""
        fractions = np.random.default_rng(seed).random((count, 6))
        return bounds[:, 0] + fractions * (bounds[:, 1] - bounds[:, 0])

    def descend(self, starts: NDArray[np.float64], bounds: NDArray[np.float64] | None = None) -> list[Basin]:
        """Solve from each start and return the basins reached, best first.

        Parameters
        ----------
        starts : (n, 6) ndarray of float
            Starts.
        bounds : (6, 2) ndarray of float, optional
            Bounds to solve within; the problem's if not given.
        """
        problem = self.problem
        n = len(starts)
        points, costs = np.empty((n, 6)), np.empty(n)
        multipliers, pins = np.empty((n, 2)), np.empty((n, len(self.representative)))
        status = np.empty(n, dtype=np.int64)
        solve_many(
            np.ascontiguousarray(starts),
            problem.lanes,
            self.group,
            self.representative,
            problem.constants,
            problem.bounds if bounds is None else bounds,
            points,
            costs,
            multipliers,
            pins,
            status,
        )
        self.starts += n
        found = [
            Basin(points[k], float(costs[k]), multipliers[k], pins[k], 1)
            for k in np.flatnonzero(status == SOLVED)
        ]
        return merge_basins(found)

    def explore(self, starts: NDArray[np.float64]) -> None:
        """Solve from each start within the problem's bounds and keep the basins."""
        self.basins = merge_basins(self.basins + self.descend(starts))


def merge_basins(basins: list[Basin]) -> list[Basin]:
    """Merge basins that are one optimum, add up their hits and sort them by cost, the best first."""
    merged: list[Basin] = []
    for basin in sorted(basins, key=lambda b: b.cost):
        for k, known in enumerate(merged):
            if np.max(np.abs(basin.point - known.point) / SCALE) < SAME_BASIN:
                merged[k] = Basin(
                    known.point, known.cost, known.multipliers, known.pins, known.hits + basin.hits
                )
                break
        else:
            merged.append(basin)
    return merged
