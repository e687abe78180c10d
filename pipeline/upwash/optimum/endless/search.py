"""Local solves from many starts behind an endless wake, merged into basins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled.endless_descent import FeltEndless, solve_many_endless
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.problem import OUTBOARD
from upwash.optimum.search import Basin, Search, merge_basins, parts_of
from upwash.optimum.variables import VARIABLE_COUNT, neighbourhood_of

BEYOND = 0.2
"""How far beyond the bounds of X, in wavelengths, a local solve may go before it is taken back by a wavelength."""

SHARE = 0.125
"""Starts in each place, as a share of those behind a wake that ends: descents are longer, and basins few."""

NEAR_BEST = 1.005
NEIGHBOURS, MOST_NEIGHBOURHOODS = 8, 8
"""Basins that cost at most so many times the best are searched around, from so many starts, and so many of them."""


class EndlessSearch(Search):
    """The basins of one problem, as far as they have been found.

    Parameters
    ----------
    problem : EndlessProblem
        What to solve.
    seed : int
        Seed of the random starts.
    """

    problem: EndlessProblem
    solve_many = staticmethod(solve_many_endless)

    def __init__(self, problem: EndlessProblem, seed: int = 0) -> None:
        super().__init__(problem, seed)

    def wake_felt(self) -> FeltEndless:
        """Return the wake as the local solve takes it."""
        return self.problem.felt

    @property
    def edge_count(self) -> int:
        """Number of core edges."""
        return self.felt.wake.steps.shape[1] * self.felt.stations.shape[2]

    def descend(self, starts: NDArray[np.float64], bounds: NDArray[np.float64] | None = None) -> list[Basin]:
        """Solve from each start and return the basins reached, best first.

        Parameters
        ----------
        starts : (n, VARIABLE_COUNT) ndarray of float
            Starts.
        bounds : (6, 2) ndarray of float, optional
            Bounds to solve within, all X being taken for bounds; the problem's if not given.
        """
        within = (self.problem.bounds if bounds is None else bounds).copy()
        if self.problem.phase_lock:
            within[0] = self.problem.bounds[0] + BEYOND * self.problem.wavelength * np.array([-1.0, 1.0])
        self.starts += len(starts)
        found = []
        for basin in self._solve(starts, within):
            wrapped = self.problem.wrapped(basin.point)
            # The window of the wake moves with X, and the balances with it in their last digits.
            moved = abs(wrapped[0] - basin.point[0]) > 0.0
            found += self._solve(wrapped[None, :], within) if moved else [basin]
        return merge_basins(found)

    def keep(self, basin: Basin) -> None:
        """Keep a basin that was found elsewhere."""
        self.basins = merge_basins([*self.basins, basin])

    def explore_places(self, count: int) -> None:
        """Solve from so many starts outboard and inboard."""
        for side in parts_of(self.problem.bounds[1], OUTBOARD):
            place = self.problem.bounds.copy()
            place[1] = side
            self.explore(self.random_starts(place, count))

    def explore_around_best(self, least: float = np.inf) -> None:
        """Solve from starts around the basins that cost nearly as little as the best; `least` as for `Search`."""
        for _ in range(MOST_NEIGHBOURHOODS):
            known = self.searched_around
            new = [
                basin
                for basin in self.basins
                if basin.cost <= NEAR_BEST * min(least, self.basins[0].cost)
                and not any(np.max(np.abs(basin.point - one.point)) < 1e-3 for one in known)
            ]
            if not new or len(known) >= MOST_NEIGHBOURHOODS:
                return
            known.append(new[0])
            around = self.random.uniform(-1.0, 1.0, (NEIGHBOURS, VARIABLE_COUNT))
            around *= neighbourhood_of(self.problem.variables)
            self.explore(new[0].point + around)
