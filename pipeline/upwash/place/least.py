"""The least cost at each place of a plane, with the best of what is free there.

Three steps.  At each place a grid over what is free is looked at, a stroke being followed from one point to the next;
from the lowest dips of it the library's local solve, which minds core edges, descends with the place held.  Then each
place is tried from where its neighbours' best lies, round by round: a round reads what the one before it found, so the
result does not depend on the order or on the number of threads.  At last all strokes that balance at the place so found
are looked for, and the cheapest is told.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.endless.problem import DISTANCE
from upwash.optimum.variables import VARIABLE_COUNT
from upwash.place.balance import Behind
from upwash.place.choices import COORDINATES
from upwash.place.compiled import balances as compiled
from upwash.place.compiled.balances import RESULTS
from upwash.place.held import LAG, RATIO, H, HeldPlaces, Piece, X, Y, Z

HEIGHTS, ASIDE, PHASES, BEHIND_PER_WAVE = 9, 17, 16, 8
"""Points of the grid in height, to the side, over all phases, and along a wavelength."""

STARTS = 4
"""So many dips of the grid are descended from."""

MOST_ROUNDS = 12
"""Rounds in which places learn from their neighbours; they end earlier where nothing is gained any more."""

ALIKE = 0.05
"""A neighbour's best that lies nearer to a place's own, in the scales of the variables, is in the same dip."""

GAIN = 1e-9
"""Least gain in cost, over that of the lone bird, that counts."""

PLACES_AT_ONCE = 256
"""So many places are one piece of a thread's work."""

Told = Callable[[int, int], None]


@dataclass(frozen=True)
class Least:
    """What was found at each of n places; NaN where nothing balances.

    Attributes
    ----------
    places : (n, 4) ndarray of float
        x, y, z in m and the phase in wingbeats: what is held, and the best of what is free.
    count : (n,) ndarray of int
        How many strokes balance there; 0 where none does.
    missing : (n,) ndarray of int
        What keeps the others from balancing, a key of `upwash.place.balance.MISSING`.
    missing_share : (n,) ndarray of float
        How much of it, over weight or drag, where least is missing.
    amplitude_m, span_ratio, cost : (n,) ndarray of float
        The cheapest stroke, and its cost over that of the lone bird.
    """

    places: NDArray[np.float64]
    count: NDArray[np.int64]
    missing: NDArray[np.int64]
    missing_share: NDArray[np.float64]
    amplitude_m: NDArray[np.float64]
    span_ratio: NDArray[np.float64]
    cost: NDArray[np.float64]


def least_over(
    behind: Behind,
    places: NDArray[np.float64],
    free: Sequence[str],
    threads: int = 1,
    told: Told | None = None,
) -> Least:
    """Find the least cost at each place of a plane.

    Parameters
    ----------
    behind : Behind
        The follower, behind one bird.
    places : (r, c, 4) ndarray of float
        x, y, z in m and the phase, row by row; neighbours in the plane are neighbours here.  What stands for a free
        coordinate is not looked at.
    free : sequence of str
        Which of `COORDINATES` are free, within the ranges that `HeldPlaces` states.
    threads : int
        How many share the work.
    told : callable, optional
        Called with how many pieces of work are done, and how many there are by what is known then.

    Returns
    -------
    Least
        Row by row; the same for any number of threads.

    Raises
    ------
    ValueError
        If no optimum can be searched in the wake's model.
    """
    held, unit = HeldPlaces(behind, free), np.array([*[behind.bird.semispan_m] * 3, 1.0])
    at = places / unit
    if held.is_endless and {"x", "phase"} <= set(free):
        at[..., X] = DISTANCE * held.wavelength
    # Along a side that nothing feels all places are one.
    varies = [number for number in range(len(COORDINATES)) if not held.is_free[number]]
    few = at
    for side in (0, 1):
        first = np.take(few, [0], side)
        few = first if np.all(few[..., varies] == first[..., varies]) else few
    plane = _Plane(held, few, threads, told or (lambda done, of: None))
    plane.search()
    of_place = np.broadcast_to(np.arange(few[..., 0].size).reshape(few.shape[:2]), at.shape[:2]).ravel()
    results = plane.told()[of_place]
    count = results[:, compiled.FOUND].astype(np.int64)
    is_none = count == 0
    flat = at.reshape(-1, 4)
    points, pieces = plane.points[of_place], plane.pieces[of_place]
    if held.is_endless and "x" in free and "phase" not in free:
        # The distance follows from the phase, within one wavelength.
        flat[:, X] = (points[:, X] / held.wavelength + flat[:, LAG]) % 1.0 * held.wavelength
    found = held.places(flat, points, pieces)
    found[is_none] = np.nan
    results[is_none, :3] = np.nan
    return Least(
        np.where([name in free for name in COORDINATES], found * unit, places.reshape(-1, 4)),
        count,
        np.where(is_none, plane.missing[of_place], 0),
        np.where(is_none, plane.missing_share[of_place], 0.0),
        results[:, compiled.AMPLITUDE] * behind.bird.semispan_m,
        results[:, compiled.RATIO],
        results[:, compiled.COST],
    )


class _Plane:
    """The places of a plane, and the best that is known at each."""

    def __init__(self, held: HeldPlaces, places: NDArray[np.float64], threads: int, report: Told) -> None:
        self.held, self.threads, self.report, self.shape = held, threads, report, places.shape[:2]
        self.at = np.ascontiguousarray(places.reshape(-1, 4))
        count = len(self.at)
        self.points, self.pieces = np.full((count, VARIABLE_COUNT), np.nan), np.zeros(count, np.int64)
        self.costs = np.full(count, np.inf)
        self.missing, self.missing_share = np.zeros(count, np.int64), np.full(count, np.inf)
        # Behind an endless wake the phase stands for the distance as well.
        self.varied = held.is_free & ~np.array([held.is_endless, False, False, False])
        self.axes = self._axes()
        self.done = self.work = 0

    def search(self) -> None:
        """Search at each place by itself, and then let neighbours learn from one another."""
        list(self._each(self._look, np.arange(len(self.at))))
        changed = np.isfinite(self.costs)
        for _ in range(MOST_ROUNDS):
            changed = self._learn(changed)
            if not np.any(changed):
                break

    def told(self) -> NDArray[np.float64]:
        """Return what balances at the best place, the cheapest of all strokes, by the columns of `cheapest_at`."""
        results = np.full((len(self.at), RESULTS), np.nan)
        results[:, compiled.FOUND] = 0.0

        def work(rows: NDArray[np.int64]) -> None:
            at = self.held.places(self.at[rows], self.points[rows], self.pieces[rows])
            found = self.held.balanced(at)
            # At a fold two strokes are one, which is followed rather than found.
            followed = self.held.balanced(at, self.points[rows][:, [H, RATIO]])
            better = followed[:, compiled.COST] < found[:, compiled.COST] - GAIN
            results[rows] = np.where(better[:, None], followed, found)

        list(self._each(work, np.flatnonzero(np.isfinite(self.costs))))
        return results

    def _each(self, work: Callable[[NDArray[np.int64]], Any], which: NDArray[np.int64]) -> Iterator[Any]:
        """Do the same with pieces of some numbers, in threads; give what comes of each, in their order."""
        pieces = [which[begin : begin + PLACES_AT_ONCE] for begin in range(0, which.size, PLACES_AT_ONCE)]
        self.work += len(pieces)
        pool = ThreadPoolExecutor(self.threads) if self.threads > 1 and len(pieces) > 1 else None
        try:
            for result in pool.map(work, pieces) if pool else map(work, pieces):
                self.done += 1
                self.report(self.done, self.work)
                yield result
        finally:
            if pool:
                pool.shutdown(cancel_futures=True)

    def _axes(self) -> list[NDArray[np.float64]]:
        """Return for each coordinate the values that the grid has, or one without meaning if it has none."""
        held, bounds = self.held, self.held.bounds
        if held.is_endless or held.states > 2:
            count = PHASES if held.is_endless else max(PHASES, 2 * held.states)
            lags = np.arange(count) / count
        else:
            # With two states a lag and what it lacks of a whole wingbeat are alike.
            lags = np.linspace(0.0, 0.5, PHASES // 2 + 1)
        (_, reach), (left, right), (low, high) = ((float(a), float(b)) for a, b in bounds[[X, Y, Z]])
        axes = [
            np.linspace(0.0, reach, int(BEHIND_PER_WAVE * reach / held.wavelength) + 1),
            np.linspace(left, right, ASIDE),
            np.linspace(low, high, HEIGHTS),
            lags,
        ]
        return [axis if free else np.zeros(1) for axis, free in zip(axes, self.varied, strict=True)]

    def _look(self, rows: NDArray[np.int64]) -> None:
        """Look at the grid of some places, and descend from its dips."""
        shape = [len(axis) for axis in self.axes]
        grid = np.stack(np.meshgrid(*self.axes, indexing="ij"), axis=-1).reshape(-1, 4)
        costs, strokes = np.full((rows.size, len(grid)), np.inf), np.full((rows.size, len(grid), 2), np.nan)
        for number, point in enumerate(grid):
            # A stroke is followed along the last coordinate; its first is looked at without a guess.
            guess = strokes[:, number - 1] if number % shape[-1] else None
            results = self.held.balanced(np.where(self.varied, point, self.at[rows]), guess)
            costs[:, number], strokes[:, number] = results[:, compiled.COST], results[:, :2]
            share = np.where(results[:, compiled.FOUND] > 0.0, np.inf, results[:, compiled.MISSING_SHARE])
            lacks = share < self.missing_share[rows]
            self.missing[rows[lacks]] = results[lacks, compiled.MISSING]
            self.missing_share[rows[lacks]] = share[lacks]
        goes_round = self.held.is_endless or self.held.states > 2
        of_place, which = _dips(costs.reshape(-1, *shape), goes_round)
        chosen = rows[of_place]
        at = np.where(self.varied, grid[which], self.at[chosen])
        points, pieces = self.held.points(at, strokes[of_place, which])
        # What the grid itself found counts, if nothing better comes.
        self._keep(chosen, points, pieces, costs[of_place, which])
        self._keep(chosen, *self.held.descend(self.at[chosen], points, pieces))

    def _keep(
        self,
        rows: NDArray[np.int64],
        points: NDArray[np.float64],
        pieces: Piece,
        costs: NDArray[np.float64],
    ) -> NDArray[np.int64]:
        """Keep the best of what was found of each place, if it is better than what is known; return those places."""
        order = np.lexsort((costs, rows))
        best = order[np.unique(rows[order], return_index=True)[1]]
        best = best[costs[best] < self.costs[rows[best]] - GAIN]
        self.points[rows[best]], self.pieces[rows[best]] = points[best], pieces[best]
        self.costs[rows[best]] = costs[best]
        return rows[best]

    def _learn(self, changed: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Try each place from the best of those neighbours that changed; return which places gained."""
        number = np.arange(len(self.at)).reshape(self.shape)
        sides = [(number[1:], number[:-1]), (number[:, 1:], number[:, :-1])]
        place, neighbour = np.concatenate(
            [(a.ravel(), b.ravel()) for pair in sides for a, b in (pair, pair[::-1])], axis=1
        )
        apart = self.held.apart(
            self.points[place], self.points[neighbour], self.pieces[place], self.pieces[neighbour]
        )
        is_new = (apart > ALIKE) | ~np.isfinite(self.costs[place])

        def work(which: NDArray[np.int64]) -> tuple[Any, ...]:
            rows, others = place[which], neighbour[which]
            return rows, *self.held.descend(self.at[rows], self.points[others], self.pieces[others])

        # What a round finds is put in at its end.
        found = list(self._each(work, np.flatnonzero(changed[neighbour] & is_new)))
        gained = np.zeros(len(self.at), dtype=bool)
        if found:
            gained[self._keep(*map(np.concatenate, zip(*found, strict=True)))] = True
        return gained


def _dips(costs: NDArray[np.float64], goes_round: bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the lowest dips of each place's grid, as place and point; whether its last coordinate is a circle."""
    is_dip = np.isfinite(costs)
    for axis in range(1, costs.ndim):
        for step in (-1, 1):
            beside = np.roll(costs, step, axis)
            if not (goes_round and axis == costs.ndim - 1):
                edge = [slice(None)] * costs.ndim
                edge[axis] = slice(0, 1) if step == 1 else slice(-1, None)
                beside[tuple(edge)] = np.inf
            is_dip &= costs <= beside
    flat = np.where(is_dip, costs, np.inf).reshape(len(costs), -1)
    lowest = np.argsort(flat, axis=1, kind="stable")[:, :STARTS]
    place, rank = np.nonzero(np.isfinite(np.take_along_axis(flat, lowest, axis=1)))
    return place, lowest[place, rank]
