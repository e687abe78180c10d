"""Every stroke with which a bird balances at a given place: compiled.

Two unknowns, the amplitude h and the upstroke span ratio R, and two balances.  Lift rises with R at any h (behind cores
as thick as a bird's the wake changes the slope of the bird's own lift by a quarter at most), so that R(h) follows from
the balance of lift, and what is left is one function of h: the thrust in excess along that curve.  It is looked at in
steps no longer than half a core radius, with its slope at both ends of each.  Where the cubic through them leaves no
doubt, there is one root or none in a step; where it does, the step is halved.  Cubics are told by their Bernstein
coefficients, which enclose them.  The curve is followed a little beyond the bounds of R, so that none of its ends has
to be found.

Behind thin cores lift may fall with R, and R(h) be several curves.  There Newton's method is started from a grid of
strokes as well, half as fine as the core.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from upwash.kernel import kernel
from upwash.place.compiled.felt import BY_AMPLITUDE, BY_RATIO, cost_of_stroke, look, make_room, settle

MOST_BALANCES = 8
"""So many strokes that balance are kept; three are the most that were met."""

BEYOND = 0.08
"""How far beyond its bounds the ratio is followed."""

BALANCED = 1e-12
"""Imbalance of lift over weight and of thrust over drag at which a stroke is said to balance."""

TOUCHING = 1e-10
"""Thrust over drag within which a curve that turns round short of the balance is said to touch it."""

KEPT = 1e-10
"""The same, at which a stroke counts: rounding may end its improvement before `BALANCED`."""

SAME = 1e-7
"""Strokes that differ less are one, in semispans and as a ratio."""

ON_BOUND = 1e-8
"""How far beyond its bounds a stroke may be by rounding, in semispans or as a ratio."""

OVERLAP = 1e-4
"""How far beyond its bounds the amplitude is followed, so that a stroke on a bound is not lost."""

LIFT_CLOSE = 1e-4
"""Excess of lift, over weight, at which its balance is followed; what the square of it leaves out is no more."""

# Columns of an array of steps' ends.
H, R, KIND, VALUE, SLOPE, R_SLOPE, STEP_COLUMNS = range(7)

# Columns of an array of balances, and of what is found at many places.
AMPLITUDE, RATIO, COST = range(3)
SAVING, FOUND, MISSING, MISSING_SHARE, RESULTS = range(3, 8)

MOST_HALVINGS = 45

SHORT, SHORTEST = 1e-2, 1e-12
"""Steps from which on the lift is balanced to the end, and are halved no more."""

FOLLOWED = 0.2
"""How far a stroke is followed from one place to another, in semispans."""

# What is missing where nothing balances.
BALANCES, LACKS_LIFT, EXCESS_LIFT, LACKS_THRUST, EXCESS_THRUST = range(5)


class StrokeBounds(NamedTuple):
    """Between which bounds a stroke is sought, in semispans.

    Attributes
    ----------
    least_amplitude, most_amplitude, least_ratio, most_ratio : float
        Bounds of h and R.
    step : float
        Longest step in h with which the curve is looked at.
    may_fall : bool
        Whether cores are so thin that lift may fall with R without being seen to.
    """

    least_amplitude: float
    most_amplitude: float
    least_ratio: float
    most_ratio: float
    step: float
    may_fall: bool


@kernel
def _ratio_at(amplitude, guess, close, bounds, felt, room):
    """Return the ratio that balances lift at an amplitude, and 0; or, where none does, its bound and on which side.

    The room is left as looked at with the ratio returned.
    """
    low, high = bounds.least_ratio - BEYOND, bounds.most_ratio + BEYOND
    ratio = min(max(guess, low), high)
    below, above = low, high
    for _ in range(60):
        look(amplitude, ratio, felt, room)
        excess, slope = room.balance[0], room.slopes[0, BY_RATIO]
        if abs(excess) < close:
            return ratio, 0
        if excess > 0.0:
            above = ratio
            if ratio <= low:
                return low, -1
        else:
            below = ratio
            if ratio >= high:
                return high, 1
        if slope <= 0.0:
            room.falls[0] = 1
        step = ratio - excess / slope if slope > 0.0 else 0.5 * (below + above)
        if step <= below:
            step = low if below == low else 0.5 * (below + above)
        elif step >= above:
            step = high if above == high else 0.5 * (below + above)
        if step == ratio:
            return ratio, 0
        ratio = step
    return ratio, 0


@kernel
def _look_along(amplitude, guess, close, bounds, felt, room, end):
    """Fill in the end of a step: what the balance of thrust is there, or of lift where that has none, and its slope."""
    ratio, kind = _ratio_at(amplitude, guess, close, bounds, felt, room)
    slopes, balance = room.slopes, room.balance
    end[H], end[KIND] = amplitude, kind
    if kind == 0:
        by_ratio = slopes[0, BY_RATIO] if slopes[0, BY_RATIO] > 0.0 else felt.own.lift_ratio
        # What little is missing of the lift moves ratio and thrust by as little.
        missing = -balance[0] / by_ratio
        end[R_SLOPE] = -slopes[0, BY_AMPLITUDE] / by_ratio
        end[R] = ratio + missing
        end[VALUE] = balance[1] + slopes[1, BY_RATIO] * missing
        end[SLOPE] = slopes[1, BY_AMPLITUDE] + slopes[1, BY_RATIO] * end[R_SLOPE]
    else:
        end[R], end[R_SLOPE] = ratio, 0.0
        end[VALUE], end[SLOPE] = balance[0], slopes[0, BY_AMPLITUDE]


@kernel
def _roots_within(left, right):
    """Return how many roots the values of a step have by its cubic: 0, 1, or −1 where that leaves doubt."""
    width = right[H] - left[H]
    a, d = left[VALUE], right[VALUE]
    b, c = a + width * left[SLOPE] / 3.0, d - width * right[SLOPE] / 3.0
    # By how much the cubic bends: what lies between may bend as much again.
    line = (d - a) / 3.0
    bend = max(abs(b - a - line), abs(c - d + line))
    if (a > 0.0) == (d > 0.0):
        sign = 1.0 if a > 0.0 else -1.0
        if min(min(sign * a, sign * b), min(sign * c, sign * d)) > bend:
            return 0
    else:
        rise = 1.0 if d > a else -1.0
        if min(min(rise * (b - a), rise * (c - b)), rise * (d - c)) > bend:
            return 1
    return -1


@kernel
def _polish(left, right, bounds, felt, room):
    """Return the amplitude and ratio that balance within a step at whose ends the thrust has other signs."""
    low, high, rises = left[H], right[H], right[VALUE] > left[VALUE]
    drag = felt.own.drag
    share = left[VALUE] / (left[VALUE] - right[VALUE])
    h = low + share * (high - low)
    ratio = left[R] + share * (right[R] - left[R])
    for attempt in range(100):
        ratio, _ = _ratio_at(h, ratio, BALANCED, bounds, felt, room)
        excess = room.balance[1]
        if abs(excess) < BALANCED * drag:
            break
        if (excess > 0.0) == rises:
            high = h
        else:
            low = h
        if high - low < 4e-16 * high:
            break
        slopes = room.slopes
        bend = -slopes[0, BY_AMPLITUDE] / slopes[0, BY_RATIO]
        slope = slopes[1, BY_AMPLITUDE] + slopes[1, BY_RATIO] * bend
        step = h - excess / slope if slope != 0.0 else h
        if not low < step < high or attempt % 8 == 7:
            step = 0.5 * (low + high)
        ratio += bend * (step - h)
        h = step
    return h, ratio


@kernel
def _keep(h, ratio, count, bounds, felt, room, found):
    """Add a stroke, just looked at, to those found, cheapest first, if it is good and new; return their number."""
    if not (abs(room.balance[0]) < KEPT and abs(room.balance[1]) < KEPT * felt.own.drag):
        return count
    if not (bounds.least_amplitude - ON_BOUND <= h <= bounds.most_amplitude + ON_BOUND):
        return count
    if not (bounds.least_ratio - ON_BOUND <= ratio <= bounds.most_ratio + ON_BOUND):
        return count
    for k in range(count):
        if abs(found[k, AMPLITUDE] - h) < SAME and abs(found[k, RATIO] - ratio) < SAME:
            return count
    cost = cost_of_stroke(h, ratio, felt.own)[0]
    place = count
    while place > 0 and found[place - 1, COST] > cost:
        place -= 1
    if place == MOST_BALANCES:
        return count
    last = min(count, MOST_BALANCES - 1)
    for k in range(last, place, -1):
        for i in range(3):
            found[k, i] = found[k - 1, i]
    found[place, AMPLITUDE], found[place, RATIO], found[place, COST] = h, ratio, cost
    return last + 1


@kernel
def _is_beyond(left, right, bounds):
    """Whether the whole of a short step lies beyond one bound of the ratio."""
    if right[H] - left[H] > 0.1:
        return False
    low, high = bounds.least_ratio - 1e-3, bounds.most_ratio + 1e-3
    return (left[R] < low and right[R] < low) or (left[R] > high and right[R] > high)


@kernel
def _start_everywhere(bounds, felt, room, found, count):
    """Add the strokes that Newton's method finds from a grid of starts; return how many there are then."""
    low, high = bounds.least_ratio, bounds.most_ratio
    rows = int(math.ceil((bounds.most_amplitude - bounds.least_amplitude) / bounds.step))
    columns = int(math.ceil((high - low) / bounds.step))
    for start in range(rows * columns):
        h = bounds.least_amplitude + (start // columns + 0.5) * bounds.step
        ratio = low + (start % columns + 0.5) * bounds.step
        for _ in range(30):
            look(h, ratio, felt, room)
            lift, thrust, slopes = room.balance[0], room.balance[1], room.slopes
            if abs(lift) < BALANCED and abs(thrust) < BALANCED * felt.own.drag:
                break
            a, b, c, d = (
                slopes[0, BY_AMPLITUDE],
                slopes[0, BY_RATIO],
                slopes[1, BY_AMPLITUDE],
                slopes[1, BY_RATIO],
            )
            size = a * d - b * c
            if size == 0.0:
                break
            by_h, by_ratio = (b * thrust - d * lift) / size, (c * lift - a * thrust) / size
            shorter = min(1.0, bounds.step / max(abs(by_h), abs(by_ratio), 1e-300))
            h, ratio = h + shorter * by_h, ratio + shorter * by_ratio
            if not (0.0 < h < 3.0 and -0.5 < ratio < 1.5):
                break
        count = _keep(h, ratio, count, bounds, felt, room, found)
    return count


@kernel
def _say_what_is_missing(ends, bounds, felt, room, missing):
    """Fill in what keeps a bird from balancing at a place where nothing does: the least of it that was looked at."""
    missing[0], missing[1] = EXCESS_LIFT, np.inf
    has_lift = False
    for k in (0, ends.shape[0] - 1):
        h = min(max(ends[k, H], bounds.least_amplitude), bounds.most_amplitude)
        _look_along(h, ends[k, R], BALANCED, bounds, felt, room, ends[k])
    for k in range(ends.shape[0]):
        ratio = min(max(ends[k, R], bounds.least_ratio), bounds.most_ratio)
        if ends[k, KIND] == 0.0 and ratio == ends[k, R]:
            value, share = ends[k, VALUE], abs(ends[k, VALUE]) / felt.own.drag
            if not has_lift or share < missing[1]:
                missing[0], missing[1] = (EXCESS_THRUST if value > 0.0 else LACKS_THRUST), share
            has_lift = True
        elif not has_lift:
            look(ends[k, H], ratio, felt, room)
            value = room.balance[0]
            if abs(value) < missing[1]:
                missing[0], missing[1] = (EXCESS_LIFT if value > 0.0 else LACKS_LIFT), abs(value)


@kernel
def find_balances(bounds, felt, room, found, missing):
    """Find every stroke that balances at the place in the room.

    Parameters
    ----------
    bounds : StrokeBounds
        Within which.
    felt : Felt
        The wakes.
    room : Room
        Scratch that `settle` has put a place into.
    found : (MOST_BALANCES, 3) ndarray of float
        Overwritten: amplitude, ratio and cost of each, the cheapest first.
    missing : (2,) ndarray of float
        Overwritten: which of `BALANCES` to `EXCESS_THRUST` holds, and by how much of weight or drag at the best.

    Returns
    -------
    int
        How many balance.
    """
    reach = bounds.most_amplitude - bounds.least_amplitude
    steps = max(int(math.ceil(reach / bounds.step)), 4)
    ends = np.empty((steps + 1, STEP_COLUMNS))
    waiting = np.empty((MOST_HALVINGS + 1, STEP_COLUMNS))
    left = np.empty(STEP_COLUMNS)
    guess = (1.0 - felt.own.lift_fixed) / max(felt.own.lift_ratio, 1e-12)
    count = 0
    room.falls[0] = 1 if bounds.may_fall else 0
    for k in range(steps + 1):
        h = bounds.least_amplitude - OVERLAP + k * (reach + 2.0 * OVERLAP) / steps
        _look_along(h, guess, LIFT_CLOSE, bounds, felt, room, ends[k])
        guess = ends[k, R] + ends[k, R_SLOPE] * reach / steps
    for k in range(steps):
        left[:] = ends[k]
        waiting[0] = ends[k + 1]
        last = 0
        while last >= 0:
            right, width = waiting[last], waiting[last, H] - left[H]
            may_split = last < MOST_HALVINGS and width > SHORTEST
            is_split = False
            if left[KIND] == 0.0 and right[KIND] == 0.0:
                if not _is_beyond(left, right, bounds):
                    roots = _roots_within(left, right)
                    is_split = roots < 0
                    if roots >= 0 or not may_split:
                        if (left[VALUE] > 0.0) != (right[VALUE] > 0.0):
                            h, ratio = _polish(left, right, bounds, felt, room)
                            count = _keep(h, ratio, count, bounds, felt, room, found)
                        elif min(abs(left[VALUE]), abs(right[VALUE])) < TOUCHING * felt.own.drag:
                            near = left if abs(left[VALUE]) < abs(right[VALUE]) else right
                            look(near[H], near[R], felt, room)
                            count = _keep(near[H], near[R], count, bounds, felt, room, found)
            elif left[KIND] == right[KIND]:
                is_split = _roots_within(left, right) != 0
            else:
                is_split = not _is_beyond(left, right, bounds)
            if is_split and may_split:
                middle = waiting[last + 1]
                ratio = 0.5 * (left[R] + right[R]) + 0.125 * width * (left[R_SLOPE] - right[R_SLOPE])
                close = LIFT_CLOSE if width > SHORT else BALANCED
                _look_along(0.5 * (left[H] + right[H]), ratio, close, bounds, felt, room, middle)
                last += 1
            else:
                left[:] = right
                last -= 1
    if room.falls[0] == 1:
        count = _start_everywhere(bounds, felt, room, found, count)
    missing[0], missing[1] = BALANCES, 0.0
    if count == 0:
        _say_what_is_missing(ends, bounds, felt, room, missing)
    return count


@kernel
def _follow(bounds, felt, room, stroke):
    """Move a stroke that balances nearby to one that balances at the place in the room; return whether it did."""
    h, ratio = stroke[AMPLITUDE], stroke[RATIO]
    for _ in range(8):
        if not (0.0 < h and abs(h - stroke[AMPLITUDE]) < FOLLOWED):
            return False
        look(h, ratio, felt, room)
        lift, thrust, slopes = room.balance[0], room.balance[1], room.slopes
        if abs(lift) < BALANCED and abs(thrust) < BALANCED * felt.own.drag:
            stroke[AMPLITUDE], stroke[RATIO] = h, ratio
            within = bounds.least_amplitude <= h <= bounds.most_amplitude
            return within and bounds.least_ratio <= ratio <= bounds.most_ratio
        size = slopes[0, BY_AMPLITUDE] * slopes[1, BY_RATIO] - slopes[0, BY_RATIO] * slopes[1, BY_AMPLITUDE]
        if size == 0.0:
            return False
        h += (slopes[0, BY_RATIO] * thrust - slopes[1, BY_RATIO] * lift) / size
        ratio += (slopes[1, BY_AMPLITUDE] * lift - slopes[0, BY_AMPLITUDE] * thrust) / size
    return False


@kernel
def cheapest_at(places, first, rows, shifts, bounds, felt, results):
    """Find the cheapest stroke at many places; releases the interpreter's lock, so threads may share the work.

    Parameters
    ----------
    places : (p, 4) ndarray of float
        Places of birds relative to those ahead of them, in semispans, with the lag.
    first : (n + 1,) ndarray of int
        Bird i has the places from ``first[i]`` to ``first[i + 1]``.
    rows : (m,) ndarray of int
        Which bird is looked at.
    shifts : (m, 4) ndarray of float
        Where: what is added to its places.
    bounds : StrokeBounds
        Within which.
    felt : Felt
        The wakes.
    results : (m, 7) ndarray of float
        Overwritten: amplitude, ratio, cost, saving of power, how many strokes balance, and what is missing as from
        `find_balances`.  Where an amplitude is stated, that stroke is followed if it can be, and one is counted.
    """
    found, missing, stroke = np.empty((MOST_BALANCES, 3)), np.empty(2), np.empty(2)
    room, moved = make_room(felt, 1), np.empty((1, 4))
    for k in range(rows.size):
        begin, birds = first[rows[k]], first[rows[k] + 1] - first[rows[k]]
        if birds != moved.shape[0]:
            room, moved = make_room(felt, birds), np.empty((birds, 4))
        for bird in range(birds):
            for i in range(4):
                moved[bird, i] = places[begin + bird, i] + shifts[k, i]
        settle(moved, felt, room)
        result = results[k]
        stroke[0], stroke[1] = result[AMPLITUDE], result[RATIO]
        result[FOUND], result[MISSING], result[MISSING_SHARE] = 1.0, BALANCES, 0.0
        if not _follow(bounds, felt, room, stroke):
            result[FOUND] = find_balances(bounds, felt, room, found, missing)
            result[MISSING], result[MISSING_SHARE] = missing[0], missing[1]
            stroke[0], stroke[1] = found[0, AMPLITUDE], found[0, RATIO]
        if result[FOUND] > 0.0:
            result[AMPLITUDE], result[RATIO] = stroke[0], stroke[1]
            result[COST] = cost_of_stroke(stroke[0], stroke[1], felt.own)[0]
            result[SAVING] = 1.0 - cost_of_stroke(stroke[0], stroke[1], felt.power)[0]
        else:
            result[AMPLITUDE] = result[RATIO] = np.nan
            result[COST], result[SAVING] = np.inf, -np.inf
