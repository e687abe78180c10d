"""Many followers' problems with part of their places held: what is free of a place is found by the library's search.

Places are in scaled variables, x, y, z in semispans and the lag; points are those of the scaled problem, x, y, z, h, R
and the phase coordinate.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import LEAST_PHASE
from upwash.optimum.compiled.descent import SOLVED
from upwash.optimum.edges import felt_lanes
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import BEYOND
from upwash.optimum.pair import pair_problems
from upwash.optimum.variables import SCALE, VARIABLE_COUNT
from upwash.place.balance import Behind
from upwash.place.choices import COORDINATES
from upwash.place.compiled.balances import RESULTS, cheapest_at
from upwash.place.compiled.descents import descend_each_endless, descend_each_pair

X, Y, Z, LAG = range(4)
H, RATIO, PHASE_COORDINATE = 3, 4, 5

Piece = NDArray[np.int64]
"""In which piece of phase each point lies; all in one behind an endless wake and of two stroke states."""


class HeldPlaces:
    """What is held of places, and what is free.

    Parameters
    ----------
    behind : Behind
        The follower, behind one bird.
    free : iterable of str
        Which of `COORDINATES` are free: x up to the far bound of a search, y likewise, z within half the leader's
        amplitude, all phases.  Behind an endless wake x and phase are felt through one number: either both are free
        or neither.

    Raises
    ------
    ValueError
        If no optimum can be searched in the wake's model.
    """

    def __init__(self, behind: Behind, free: Iterable[str]) -> None:
        self.behind = behind
        self.problems = pair_problems(behind.bird, behind.objective, behind.ahead, model=behind.model)
        self.is_endless = behind.model.is_endless
        self.wavelength, self.states = self.problems[0].wavelength, behind.model.stroke_states
        free = set(free)
        self.is_free = np.array([name in free for name in COORDINATES])
        if self.is_endless:
            self.is_free[[X, LAG]] = self.is_free[X] or self.is_free[LAG]
        self.bounds = self._bounds()
        self.felt: list[Any] = [
            one.felt if isinstance(one, EndlessProblem) else felt_lanes(one.lanes, self.bounds)
            for one in self.problems
        ]

    def _bounds(self) -> NDArray[np.float64]:
        """Return the bounds of the variables where their coordinates are free."""
        bounds, stroke = self.problems[0].bounds.copy(), self.behind.bounds
        half = 0.5 * self.problems[0].leader_height
        bounds[Z] = -half, half
        bounds[H] = stroke.least_amplitude, stroke.most_amplitude
        bounds[RATIO] = stroke.least_ratio, stroke.most_ratio
        if self.is_endless:
            bounds[X] += BEYOND * self.wavelength * np.array([-1.0, 1.0])
        return bounds

    def balanced(
        self, at: NDArray[np.float64], strokes: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Return what balances at places, by the columns of `cheapest_at`; strokes that balance nearby are followed."""
        results = np.full((len(at), RESULTS), np.nan)
        if strokes is not None:
            results[:, :2] = strokes
        nowhere, first, rows = np.zeros((1, 4)), np.array([0, 1]), np.zeros(len(at), np.int64)
        cheapest_at(
            nowhere, first, rows, np.ascontiguousarray(at), self.behind.bounds, self.behind.felt, results
        )
        return results

    def points(
        self, at: NDArray[np.float64], strokes: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], Piece]:
        """Return places and strokes as points, and in which piece of phase each lies."""
        lag = at[:, LAG] % 1.0
        points, pieces = np.column_stack([at[:, :3], strokes, lag]), np.zeros(len(at), np.int64)
        if self.is_endless:
            turns = at[:, X] / self.wavelength - lag
            points[:, X] = (turns - np.floor(turns - LEAST_PHASE)) * self.wavelength
            points[:, PHASE_COORDINATE] = 0.0
        elif len(self.problems) == 1:
            points[:, PHASE_COORDINATE] = np.abs(0.5 - lag)
        else:
            pieces = np.minimum((lag * self.states).astype(np.int64), self.states - 1)
            points[:, PHASE_COORDINATE] = lag - pieces / self.states
        return points, pieces

    def places(
        self, at: NDArray[np.float64], points: NDArray[np.float64], pieces: Piece
    ) -> NDArray[np.float64]:
        """Return places with what is free of them as at some points; behind an endless wake x stays as it is."""
        found = np.where(self.is_free, points[:, [X, Y, Z, PHASE_COORDINATE]], at)
        coordinate = points[:, PHASE_COORDINATE]
        if self.is_endless:
            found[:, X] = at[:, X]
            lag = (at[:, X] - points[:, X]) / self.wavelength
        else:
            lag = 0.5 - coordinate if len(self.problems) == 1 else pieces / self.states + coordinate
        found[:, LAG] = np.where(self.is_free[LAG], lag % 1.0, at[:, LAG])
        return found

    def apart(
        self, points: NDArray[np.float64], others: NDArray[np.float64], pieces: Piece, other_pieces: Piece
    ) -> NDArray[np.float64]:
        """Return how far points are from others in what is free, in the variables' scales; NaN of unknown ones."""
        distance = np.abs(points - others)
        if self.is_endless:
            distance[:, X] = np.abs(
                distance[:, X] - self.wavelength * np.round(distance[:, X] / self.wavelength)
            )
        varies = np.append(self.is_free[:3], [True, True, self.is_free[LAG]])
        found = np.max(np.where(varies, distance, 0.0) / SCALE, axis=1)
        return np.where((pieces != other_pieces) & self.is_free[LAG], np.inf, found)

    def descend(
        self, at: NDArray[np.float64], starts: NDArray[np.float64], pieces: Piece
    ) -> tuple[NDArray[np.float64], Piece, NDArray[np.float64]]:
        """Descend with what is held of places; return points, pieces, and costs, infinite where none is found."""
        held, own_pieces = self.points(at, starts[:, [H, RATIO]])
        if not self.is_free[LAG]:
            pieces = own_pieces
        bounds = np.repeat(self.bounds[None], len(at), axis=0)
        for variable, coordinate in ((X, X), (Y, Y), (Z, Z), (PHASE_COORDINATE, LAG)):
            if not self.is_free[coordinate]:
                bounds[:, variable] = held[:, variable, None]
        points, costs = np.empty_like(starts), np.full(len(at), np.inf)
        for number, (problem, felt) in enumerate(zip(self.problems, self.felt, strict=True)):
            if not (of_piece := np.flatnonzero(pieces == number)).size:
                continue
            ends, end_costs = np.empty((of_piece.size, VARIABLE_COUNT)), np.empty(of_piece.size)
            status = np.empty(of_piece.size, np.int64)
            if self.is_endless:
                descend, edges = descend_each_endless, felt.wake.steps.shape[1] * felt.stations.shape[2]
            else:
                descend, edges = descend_each_pair, len(felt.representative)
            descend(
                starts[of_piece], bounds[of_piece], felt, problem.constants, edges, ends, end_costs, status
            )
            points[of_piece], costs[of_piece] = ends, np.where(status == SOLVED, end_costs, np.inf)
        return points, pieces, costs
