"""Many birds at their places: what each saves there, with the best of what is not known of it.

Of a bird whose phase or height is not given, the cheapest is sought, and what it saves on average and at worst over the
range: all phases, and heights within half the leader's amplitude.  A grid over the range tells about where the best
lies; from there one unknown is narrowed down by golden sections and two by ever smaller steps, neither of which minds
the kinks of core edges.  From one point to the next a stroke is followed; the one at the end is found anew.

Birds are looked at many at a time, each step for all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields
from functools import partial

import numpy as np
from numpy.typing import NDArray

from upwash.place.balance import Behind
from upwash.place.compiled import balances as compiled
from upwash.place.compiled.balances import RESULTS, cheapest_at

PHASES = 16
"""Phases of the wingbeat that are looked at where none is given."""

HEIGHTS = 9
"""Heights that are looked at where none is given."""

FINEST = 1e-8
"""How closely the best phase, in wingbeats, or height, in semispans, is found."""

FINEST_TOGETHER, MOST_ROUNDS = 1e-5, 200
"""The same of both together, in steps of the grids; rounds in which they are sought."""

DRAWS = 128
"""Places that stand for the errors of one; a power of two, as they are spread evenly."""

QUANTILES = (0.05, 0.95)
"""Of the saving, while the place is off by its errors."""

BIRDS_AT_ONCE = 64
"""So many birds are one piece of a thread's work."""

Z, LAG = 2, 3
"""Columns of a place."""

_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)
_UNKNOWN = np.nan


@dataclass(frozen=True)
class Birds:
    """Where birds fly, as far as it is known.

    Attributes
    ----------
    places : (p, 4) ndarray of float
        x, y, z in m and the lag in wingbeats, relative to each bird ahead; 0 for what is not known.
    first : (n + 1,) ndarray of int
        Each bird has the places from its `first` to the next.
    height_is_free, phase_is_free : (n,) ndarray of bool
        Whether its height, or its phase, is not known.
    errors : (n, 4) ndarray of float, optional
        Standard deviations of x, y, z in m, and of the lag in wingbeats.
    """

    places: NDArray[np.float64]
    first: NDArray[np.int64]
    height_is_free: NDArray[np.bool_]
    phase_is_free: NDArray[np.bool_]
    errors: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Survey:
    """What birds save at their places; each array holds a value for each bird, NaN for what was not asked.

    Attributes
    ----------
    count : (n,) ndarray of int
        How many strokes balance; 0 where none does.
    missing : (n,) ndarray of int
        What keeps the others from balancing, a key of `upwash.place.balance.MISSING`.
    missing_share : (n,) ndarray of float
        How much of it, over weight or drag.
    height_m, phase : (n,) ndarray of float
        What has to be added to height and lag of the place: 0 where they are known, else the best.
    amplitude_m, span_ratio, cost : (n,) ndarray of float
        The cheapest stroke, and its cost over that of the lone bird.
    mean_phase, worst_phase : (n,) ndarray of float
        Saving of power over all phases at which something balances, on average and at worst.
    mean_height, worst_height : (n,) ndarray of float
        The same over heights, each with its best phase if that is free.
    balanced_share : (n,) ndarray of float
        Share of the phases and heights that were looked at where something balances.
    low, high : (n,) ndarray of float
        Quantiles of the saving while the place is off by its errors; a place without balance counts as the least.
    balanced_nearby : (n,) ndarray of float
        Share of those places at which something balances.
    """

    count: NDArray[np.int64]
    missing: NDArray[np.int64]
    missing_share: NDArray[np.float64]
    height_m: NDArray[np.float64]
    phase: NDArray[np.float64]
    amplitude_m: NDArray[np.float64]
    span_ratio: NDArray[np.float64]
    cost: NDArray[np.float64]
    mean_phase: NDArray[np.float64]
    worst_phase: NDArray[np.float64]
    mean_height: NDArray[np.float64]
    worst_height: NDArray[np.float64]
    balanced_share: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    balanced_nearby: NDArray[np.float64]


def survey(behind: Behind, birds: Birds, threads: int = 1) -> Survey:
    """Find what birds save where they fly, with the best of what is not known of it.

    Parameters
    ----------
    behind : Behind
        Bird, wake, objective and bounds.
    birds : Birds
        Where they fly.
    threads : int
        How many threads share the work.

    Returns
    -------
    Survey
        In the order of the birds, and the same for any number of threads.
    """
    pieces = [
        _piece(birds, begin, min(begin + BIRDS_AT_ONCE, len(birds.first) - 1))
        for begin in range(0, len(birds.first) - 1, BIRDS_AT_ONCE)
    ]

    def work(piece: Birds) -> Survey:
        return _Looks(behind, piece).survey()

    if threads == 1 or len(pieces) < 2:
        parts = list(map(work, pieces))
    else:
        with ThreadPoolExecutor(threads) as pool:
            parts = list(pool.map(work, pieces))
    names = [entry.name for entry in fields(Survey)]
    return Survey(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def _piece(birds: Birds, begin: int, end: int) -> Birds:
    first = birds.first[begin : end + 1]
    return Birds(
        birds.places[first[0] : first[-1]],
        first - first[0],
        birds.height_is_free[begin:end],
        birds.phase_is_free[begin:end],
        None if birds.errors is None else birds.errors[begin:end],
    )


class _Looks:
    """Some birds that are looked at together."""

    def __init__(self, behind: Behind, birds: Birds) -> None:
        self.behind, self.birds = behind, birds
        self.count, self.unit = len(birds.first) - 1, np.array([*[behind.bird.semispan_m] * 3, 1.0])
        self.places = birds.places / self.unit
        self.half_height = 0.5 * behind.ahead.amplitude_m / behind.bird.semispan_m
        states = behind.model.stroke_states
        # Of birds that are held, the lag has a kink at each state.
        self.phases = PHASES if behind.model.is_endless else max(PHASES, 2 * states)

    def survey(self) -> Survey:
        free_height, free_phase = self.birds.height_is_free, self.birds.phase_is_free
        unknown = np.full((7, self.count), _UNKNOWN)
        mean_phase, worst_phase, mean_height, worst_height, balanced, low, high = unknown
        nearby, shift = np.full(self.count, _UNKNOWN), np.zeros((self.count, 4))

        if (rows := np.flatnonzero(free_height & free_phase)).size:
            costs, savings = self._over_grid(rows)
            balanced[rows] = np.mean(np.isfinite(costs), axis=(1, 2))
            best_phase = np.argmin(costs, axis=2)[..., None]
            of_height = np.take_along_axis(savings, best_phase, axis=2)[..., 0]
            mean_height[rows], worst_height[rows] = _mean_and_worst(of_height, is_closed=True)
            shift[rows] = self._finer(rows, costs)
        if (rows := np.flatnonzero(free_height & ~free_phase)).size:
            heights = self._heights()
            costs, savings = self._along(rows, Z, np.zeros((rows.size, 4)), heights)
            balanced[rows] = np.mean(np.isfinite(costs), axis=1)
            mean_height[rows], worst_height[rows] = _mean_and_worst(savings, is_closed=True)
            shift[rows, Z], least = self._narrowed(rows, Z, shift[rows], heights, costs)
            worst_height[rows] = self._narrowed(rows, Z, shift[rows], heights, savings, worst=True)[1]
        if (rows := np.flatnonzero(free_phase)).size:
            lags = np.arange(self.phases) / self.phases
            at = shift[rows] * [1.0, 1.0, 1.0, 0.0]
            costs, savings = self._along(rows, LAG, at, lags)
            balanced[rows] = np.where(free_height[rows], balanced[rows], np.mean(np.isfinite(costs), axis=1))
            mean_phase[rows], worst_phase[rows] = _mean_and_worst(savings, is_closed=False)
            lag, least = self._narrowed(rows, LAG, at, lags, costs)
            worst_phase[rows] = self._narrowed(rows, LAG, at, lags, savings, worst=True)[1]
            # Where height and phase were sought together, that place may be the better one.
            known = self._results(rows, shift[rows])[:, compiled.COST]
            keeps = free_height[rows] & (known <= least)
            shift[rows, LAG] = np.where(keeps, shift[rows, LAG], lag) % 1.0

        found = self._results(np.arange(self.count), shift)
        if self.birds.errors is not None:
            low[:], high[:], nearby[:] = self._nearby(shift, self.birds.errors / self.unit)
        is_balanced = found[:, compiled.FOUND] > 0.0
        for each in (mean_phase, worst_phase, mean_height, worst_height, low, high):
            each[~is_balanced] = _UNKNOWN
        b = self.behind.bird.semispan_m
        return Survey(
            found[:, compiled.FOUND].astype(np.int64),
            found[:, compiled.MISSING].astype(np.int64),
            found[:, compiled.MISSING_SHARE],
            shift[:, Z] * b,
            shift[:, LAG],
            found[:, compiled.AMPLITUDE] * b,
            found[:, compiled.RATIO],
            np.where(is_balanced, found[:, compiled.COST], _UNKNOWN),
            mean_phase,
            worst_phase,
            mean_height,
            worst_height,
            balanced,
            low,
            high,
            nearby,
        )

    def _results(
        self,
        rows: NDArray[np.int64],
        shifts: NDArray[np.float64],
        strokes: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Return what is found of birds where they are moved to, from strokes that balance nearby if given."""
        results = np.full((len(rows), RESULTS), _UNKNOWN)
        if strokes is not None:
            results[:, :2] = strokes
        cheapest_at(
            self.places,
            self.birds.first,
            np.ascontiguousarray(rows),
            np.ascontiguousarray(shifts),
            self.behind.bounds,
            self.behind.felt,
            results,
        )
        return results

    def _heights(self) -> NDArray[np.float64]:
        return np.linspace(-self.half_height, self.half_height, HEIGHTS)

    def _along(
        self, rows: NDArray[np.int64], axis: int, at: NDArray[np.float64], values: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return cost and saving of birds, each at several heights or phases: two arrays (bird, value)."""
        shifts = np.repeat(at, values.size, axis=0)
        shifts[:, axis] = np.tile(values, rows.size)
        results = self._results(np.repeat(rows, values.size), shifts)
        shape = rows.size, values.size
        return results[:, compiled.COST].reshape(shape), results[:, compiled.SAVING].reshape(shape)

    def _over_grid(self, rows: NDArray[np.int64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return cost and saving of birds over heights and phases: two arrays (bird, height, phase)."""
        heights, lags = self._heights(), np.arange(self.phases) / self.phases
        shifts = np.zeros((rows.size, heights.size, lags.size, 4))
        shifts[..., Z], shifts[..., LAG] = heights[:, None], lags
        results = self._results(np.repeat(rows, heights.size * lags.size), shifts.reshape(-1, 4))
        return tuple(results[:, k].reshape(shifts.shape[:3]) for k in (compiled.COST, compiled.SAVING))  # type: ignore[return-value]

    def _narrowed(
        self,
        rows: NDArray[np.int64],
        axis: int,
        at: NDArray[np.float64],
        values: NDArray[np.float64],
        known: NDArray[np.float64],
        worst: bool = False,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Narrow down the least cost, or the least saving, by golden sections about the two best values.

        Returns
        -------
        tuple of two (n,) ndarray of float
            Where it lies along the axis, and the least.
        """
        # Places without balance have infinite cost, and are no candidates for the least saving either.
        measure = np.where(np.isfinite(known), known, np.inf)
        step, all_rows = values[1] - values[0], np.arange(rows.size)
        best, least = np.zeros(rows.size), np.full(rows.size, np.inf)
        for which in _two_dips(measure, goes_round=axis == LAG):
            middle, at_middle = values[which], measure[all_rows, which]
            low, high = middle - step, middle + step
            if axis == Z:
                low, high = np.maximum(low, values[0]), np.minimum(high, values[-1])
            moved = at.copy()
            moved[:, axis] = middle
            strokes = self._results(rows, moved)[:, :2]
            found, at_found = _golden_sections(
                partial(self._measured, rows, axis, moved, strokes, worst), low, high
            )
            for value, at_value in ((middle, at_middle), (found, at_found)):
                better = at_value < least
                best, least = np.where(better, value, best), np.where(better, at_value, least)
        return best, least

    def _measured(
        self,
        rows: NDArray[np.int64],
        axis: int,
        moved: NDArray[np.float64],
        strokes: NDArray[np.float64],
        worst: bool,
        value: NDArray[np.float64],
    ) -> NDArray[np.float64]:
        """Return the cost, or to find the worst the saving, at values along an axis; follow the strokes there."""
        moved[:, axis] = value
        results = self._results(rows, moved, strokes)
        balances = np.isfinite(results[:, compiled.COST])
        strokes[balances] = results[balances, :2]
        return np.where(balances, results[:, compiled.SAVING if worst else compiled.COST], np.inf)

    def _finer(self, rows: NDArray[np.int64], costs: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return where the cost is least over height and phase, by steps that shrink where they do not help."""
        heights = self._heights()
        flat = costs.reshape(rows.size, -1)
        best = np.unravel_index(np.argmin(flat, axis=1), costs.shape[1:])
        at = np.zeros((rows.size, 4))
        at[:, Z], at[:, LAG] = heights[best[0]], best[1] / self.phases
        least = np.min(flat, axis=1)
        found = self._results(rows, at)
        strokes = found[:, :2]
        turns = np.arange(8) * np.pi / 4.0
        first_size = 0.5 * np.array([heights[1] - heights[0], 1.0 / self.phases])
        scale = np.ones(rows.size)
        for number in range(MOST_ROUNDS):
            active = np.flatnonzero(np.isfinite(least) & (scale > FINEST_TOGETHER))
            if not active.size:
                break
            # Along the axes and, in every other round, turned: a kink across all directions would hold the search.
            turned = turns + number * (number % 2)
            across = np.column_stack([np.cos(turned), np.sin(turned)])
            shifts = np.repeat(at[active], len(across), axis=0)
            steps = scale[active][:, None, None] * across * first_size
            shifts[:, [Z, LAG]] += steps.reshape(-1, 2)
            shifts[:, Z] = np.clip(shifts[:, Z], -self.half_height, self.half_height)
            results = self._results(
                np.repeat(rows[active], len(across)), shifts, np.repeat(strokes[active], len(across), axis=0)
            )
            cost = results[:, compiled.COST].reshape(active.size, -1)
            which = np.argmin(cost, axis=1) + np.arange(active.size) * len(across)
            better = results[which, compiled.COST] < least[active]
            moved, from_there = active[better], which[better]
            at[moved], strokes[moved] = shifts[from_there], results[from_there, :2]
            least[moved] = results[from_there, compiled.COST]
            scale[active[~better]] *= 0.7
        return at

    def _nearby(
        self, shift: NDArray[np.float64], errors: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return quantiles of the saving while places are off by their errors, and the share that balances."""
        draws = normal_draws(DRAWS)
        shifts = (shift[:, None, :] + errors[:, None, :] * draws).reshape(-1, 4)
        savings = self._results(np.repeat(np.arange(self.count), DRAWS), shifts)[:, compiled.SAVING]
        savings = np.sort(savings.reshape(self.count, DRAWS), axis=1)
        low, high = (_quantile(savings, share) for share in QUANTILES)
        return low, high, np.mean(np.isfinite(savings), axis=1)


def _two_dips(measure: NDArray[np.float64], goes_round: bool) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return for each row where the lowest of the local minima lies, and the next, or the lowest again."""
    ends = measure[:, [-1, 0]] if goes_round else np.full((len(measure), 2), np.inf)
    padded = np.column_stack([ends[:, 0], measure, ends[:, 1]])
    is_dip = (measure <= padded[:, :-2]) & (measure <= padded[:, 2:])
    lowest = np.argmin(measure, axis=1)
    dips = np.where(is_dip, measure, np.inf)
    dips[np.arange(len(measure)), lowest] = np.inf
    second = np.argmin(dips, axis=1)
    return lowest, np.where(np.isfinite(dips[np.arange(len(measure)), second]), second, lowest)


def normal_draws(count: int) -> NDArray[np.float64]:
    """Return evenly spread normal numbers for errors in x, y, z and phase, the same at each call.

    Returns
    -------
    (count, 4) ndarray of float
    """
    from scipy.special import ndtri
    from scipy.stats import qmc

    return np.ascontiguousarray(ndtri(qmc.Sobol(4, scramble=True, rng=0).random(count)))


def _quantile(ordered: NDArray[np.float64], share: float) -> NDArray[np.float64]:
    """Return a quantile of each row of sorted values; NaN where it falls among those without balance."""
    place = share * (ordered.shape[1] - 1)
    below = int(place)
    with np.errstate(invalid="ignore"):
        found = ordered[:, below] + (place - below) * (ordered[:, below + 1] - ordered[:, below])
    return np.where(np.isfinite(ordered[:, below]), found, _UNKNOWN)


def _mean_and_worst(
    savings: NDArray[np.float64], is_closed: bool
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return mean and least of the savings of each row, of what balances; by trapezoids if the range is closed."""
    weights = np.ones(savings.shape[1])
    if is_closed:
        weights[[0, -1]] = 0.5
    balances = np.isfinite(savings)
    weights = weights * balances
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.sum(weights * np.where(balances, savings, 0.0), axis=1) / np.sum(weights, axis=1)
    worst = np.min(np.where(balances, savings, np.inf), axis=1)
    return mean, np.where(np.isfinite(worst), worst, _UNKNOWN)


def _golden_sections(
    function: Callable[[NDArray[np.float64]], NDArray[np.float64]],
    low: NDArray[np.float64],
    high: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return where a function is least in each of many ranges, and the least."""
    low, high = low.copy(), high.copy()
    left, right = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
    at_left, at_right = function(left), function(right)
    while np.max(high - low) > FINEST:
        goes_left = at_left <= at_right
        low, high = np.where(goes_left, low, left), np.where(goes_left, right, high)
        kept, at_kept = np.where(goes_left, left, right), np.where(goes_left, at_left, at_right)
        new = np.where(goes_left, high - _GOLDEN * (high - low), low + _GOLDEN * (high - low))
        at_new = function(new)
        left, right = np.where(goes_left, new, kept), np.where(goes_left, kept, new)
        at_left, at_right = np.where(goes_left, at_new, at_kept), np.where(goes_left, at_kept, at_new)
    goes_left = at_left <= at_right
    return np.where(goes_left, left, right), np.where(goes_left, at_left, at_right)
