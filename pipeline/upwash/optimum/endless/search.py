"""Local solves from many starts behind an endless wake, merged into basins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled.descent import SOLVED
from upwash.optimum.compiled.endless_descent import solve_many_endless
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.problem import OUTBOARD
from upwash.optimum.search import Basin, merge_basins

BEYOND = 0.2
"""How far beyond the bounds of X, in wavelengths, a local solve may go before it is taken back by a wavelength."""

SHARE = 0.125
"""Starts in each place, as a share of those behind a wake that ends: descents are longer, and basins few."""

NEAR_BEST = 1.005
NEIGHBOURS, MOST_NEIGHBOURHOODS = 8, 8
"""Basins that cost at most so many times the best are searched around, from so many starts, and so many of them."""

NEIGHBOURHOOD = np.array([0.5, 0.3, 0.3, 0.3, 0.05, 0.0])
"""How far around a basin starts are drawn."""


class EndlessSearch:
    """The basins of one problem, as far as they have been found.

    Parameters
    ----------
    problem : EndlessProblem
        What to solve.
    seed : int
        Seed of the random starts.
    """

    def __init__(self, problem: EndlessProblem, seed: int = 0) -> None:
        self.problem = problem
        self.random = np.random.default_rng(seed)
        self.starts = 0
        self.basins: list[Basin] = []
        self._searched_around: list[Basin] = []

    def random_starts(self, bounds: NDArray[np.float64], count: int) -> NDArray[np.float64]:
        """Draw starts evenly over a box."""
        return bounds[:, 0] + self.random.random((count, 6)) * (bounds[:, 1] - bounds[:, 0])

    def descend(self, starts: NDArray[np.float64], bounds: NDArray[np.float64] | None = None) -> list[Basin]:
        """Solve from each start and return the basins reached, best first.

        Parameters
        ----------
        starts : (n, 6) ndarray of float
            Starts.
        bounds : (6, 2) ndarray of float, optional
            Bounds to solve within, all X being taken for bounds; the problem's if not given.
        """
        within = (self.problem.bounds if bounds is None else bounds).copy()
        within[0] = self.problem.bounds[0] + BEYOND * self.problem.wavelength * np.array([-1.0, 1.0])
        self.starts += len(starts)
        found = []
        for basin in self._solve(starts, within):
            wrapped = self.problem.wrapped(basin.point)
            # The window of the wake moves with X, and the balances with it in their last digits.
            moved = abs(wrapped[0] - basin.point[0]) > 0.0
            found += self._solve(wrapped[None, :], within) if moved else [basin]
        return merge_basins(found)

    def _solve(self, starts: NDArray[np.float64], bounds: NDArray[np.float64]) -> list[Basin]:
        n, problem = len(starts), self.problem
        points, costs = np.empty((n, 6)), np.empty(n)
        multipliers, status = np.empty((n, 2)), np.empty(n, dtype=np.int64)
        solve_many_endless(
            np.ascontiguousarray(starts),
            problem.wake_felt,
            problem.constants,
            problem.stations,
            bounds,
            points,
            costs,
            multipliers,
            status,
        )
        solved = np.flatnonzero(status == SOLVED)
        return [Basin(points[k], float(costs[k]), multipliers[k], 1) for k in solved]

    def explore(self, starts: NDArray[np.float64]) -> None:
        """Solve from each start within the problem's bounds and keep the basins."""
        self.basins = merge_basins(self.basins + self.descend(starts))

    def keep(self, basin: Basin) -> None:
        """Keep a basin that was found elsewhere."""
        self.basins = merge_basins([*self.basins, basin])

    def explore_places(self, count: int) -> None:
        """Solve from so many starts outboard and inboard."""
        for side in ((0.0, OUTBOARD), (OUTBOARD, self.problem.bounds[1, 1])):
            place = self.problem.bounds.copy()
            place[1] = side
            self.explore(self.random_starts(place, count))

    def explore_around_best(self) -> None:
        """Solve from starts around the basins that cost nearly as little as the best."""
        for _ in range(MOST_NEIGHBOURHOODS):
            known = self._searched_around
            new = [
                basin
                for basin in self.basins
                if basin.cost <= NEAR_BEST * self.basins[0].cost
                and not any(np.max(np.abs(basin.point - one.point)) < 1e-3 for one in known)
            ]
            if not new or len(known) >= MOST_NEIGHBOURHOODS:
                return
            known.append(new[0])
            around = self.random.uniform(-1.0, 1.0, (NEIGHBOURS, 6)) * NEIGHBOURHOOD
            self.explore(new[0].point + around)
