"""A proof that nothing is better: branch and bound on the follower's problem.

Boxes live in (x, y, z_up, z_down, R, t), with z_up and z_down the heights of the raised and the lowered wingtips, so
that the force with tips up does not see z_down and the reverse.  A box is cleared when for some multipliers ν

    C + ν · (lift residual, thrust residual) > threshold

throughout it; then no point of the box both balances and costs as little as the threshold.  Any ν is valid: the
parent's is taken and improved by exact line searches on the dual of the affine relaxation.  The same bound, turned
round, tells how much of a box's rim can be cut off.  Boxes that stay open are searched for better solutions, and what
is left when the budget is spent is reported as open, with the bound reached.

Every way of clearing a box keeps one margin, `MARGIN`: cleared is what holds no point that keeps the bounds and both
balances to within the margin and costs as little as the threshold less the margin.  The sums are ordinary floating
point; what their rounding may add is part of the radii, see `relax`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.kernel import kernel
from upwash.optimum.enclosure import (
    BY_RATIO,
    BY_X,
    BY_Y,
    BY_Z,
    RADIUS,
    ROUNDING,
    VALUE,
    enclose_wake_force,
)
from upwash.optimum.problem import (
    CORE2,
    DRAG,
    LIFT_FIXED,
    LIFT_RATIO,
    THRUST_FIXED,
    THRUST_RATIO,
    PairProblem,
    cost_of,
)
from upwash.optimum.search import Basin
from upwash.optimum.settings import SearchSettings

Descend = Callable[[NDArray[np.float64]], list[Basin]]
"""Starts -> the solutions that local solves from them reach, best first."""

MARGIN = 1e-10
"""How much a point may miss a bound (in semispans) and a balance (in weights) and still keep its box from being
cleared, and by how much its cost must exceed the threshold (in costs of the lone leader)."""

TINY = 1e-9
"""Half-width, in units of `WIDTHS`, below which a box is not split further but left open."""

WIDTHS = np.array([0.3, 0.3, 0.3, 0.3, 0.1, 0.25])
"""Lengths over which the six variables of a box matter alike."""

DEPTH = 600
WORTH_REPEATING = 0.3
RADIUS_WEIGHT = 10.0
LEAST_SLOPE = 1e-3
UNREACHABLE_COST = 1e6
ASCENT_ROUNDS = 3
LEAST_MULTIPLIERS = (0.3, 0.5)
"""Floor of the multipliers in the branching score; without it a coarse box looks flat in all but one variable."""

SEARCH_WIDTH, SEARCH_EVERY = 0.25, 4000
"""After each so many boxes a local solve is tried from the centre of an open one that is narrower than the width."""

# What becomes of a box.
CLEARED, OPEN = range(2)


@dataclass(frozen=True)
class Certificate:
    """What a branch and bound has shown of one box.

    Attributes
    ----------
    lower_bound : float
        No feasible point of the box costs less (in costs of the lone leader); infinite if none is feasible.
    boxes : int
        Boxes examined.
    is_closed : bool
        Whether every box was cleared at the asked tolerance.
    found : Basin or None
        A better solution met on the way, if any.
    """

    lower_bound: float
    boxes: int
    is_closed: bool
    found: Basin | None


@kernel
def _couple(low, high, limits):
    """Shrink z_up and z_down to the ranges of mean height and amplitude; return whether anything is left."""
    z_low, z_high, h_low, h_high = limits[0], limits[1], limits[2], limits[3]
    low[2] = max(low[2], max(low[3] + h_low, 2.0 * z_low - high[3]) - MARGIN)
    high[2] = min(high[2], min(high[3] + h_high, 2.0 * z_high - low[3]) + MARGIN)
    low[3] = max(low[3], max(low[2] - h_high, 2.0 * z_low - high[2]) - MARGIN)
    high[3] = min(high[3], min(high[2] - h_low, 2.0 * z_high - low[2]) + MARGIN)
    return low[2] <= high[2] and low[3] <= high[3]


@kernel
def relax(low, high, widths, forms, constants, phase_end, relaxation):
    """Reduce a box to an affine relaxation: cost and two residuals as forms in the six offsets.

    The radii hold the margin to which a point may miss a balance, and what rounding may take from a sum of the three
    forms with any multipliers; the cost is lowered by both.

    Parameters
    ----------
    low, high, widths : (6,) ndarray of float
        The box, and its half-widths, rounded up.
    forms : (2, 2, 2, 6) ndarray of float
        Wake forces with tips up and tips down over the box, from `enclose_wake_force`.
    constants : (10,) ndarray of float
        `PairProblem.constants`.
    phase_end : float
        Greatest phase coordinate.
    relaxation : (3, 8) ndarray of float
        Overwritten: for cost, lift residual and thrust residual the value, six slopes and radius.  The own thrust
        also holds the product of the offsets of amplitude and span ratio, which cost and thrust residual share: it is
        left out of the radii, and in place of a radius the cost, whose form is a lower bound, has its slope by thrust.

    Returns
    -------
    float
        Radius of that product.
    """
    centre_ratio = 0.5 * (low[4] + high[4])
    w_x, w_y, w_up, w_down, w_ratio = widths[0], widths[1], widths[2], widths[3], widths[4]
    amplitude = 0.5 * (low[2] + high[2]) - 0.5 * (low[3] + high[3])
    share = 0.5 * (low[5] + high[5]) / phase_end
    w_share = widths[5] / phase_end
    lift = constants[LIFT_FIXED] + constants[LIFT_RATIO] * centre_ratio
    span = constants[THRUST_FIXED] + constants[THRUST_RATIO] * centre_ratio
    thrust = amplitude * span
    product = abs(constants[THRUST_RATIO]) * (w_up + w_down) * w_ratio
    by_ratio = amplitude * constants[THRUST_RATIO]
    # The cost is convex in lift and thrust, so its tangent plane supports it from below.
    cost, by_lift, by_thrust = cost_of(lift, thrust, constants)
    relaxation[:] = 0.0
    relaxation[0, 0] = cost
    relaxation[0, 3], relaxation[0, 4] = by_thrust * span, -by_thrust * span
    relaxation[0, 5] = by_lift * constants[LIFT_RATIO] + by_thrust * by_ratio
    relaxation[0, 7] = by_thrust
    relaxation[1, 0] = lift - 1.0
    relaxation[1, 5] = constants[LIFT_RATIO]
    relaxation[2, 0] = thrust - constants[DRAG]
    relaxation[2, 3], relaxation[2, 4], relaxation[2, 5] = span, -span, by_ratio
    for part in range(2):
        w_z = w_up if part == 0 else w_down
        for c in range(2):
            start, end, row = forms[part, 0, c], forms[part, 1, c], relaxation[1 + c]
            row[0] += start[VALUE] + share * (end[VALUE] - start[VALUE])
            dx, dy = end[BY_X] - start[BY_X], end[BY_Y] - start[BY_Y]
            dz, dr = end[BY_Z] - start[BY_Z], end[BY_RATIO] - start[BY_RATIO]
            row[1] += start[BY_X] + share * dx
            row[2] += start[BY_Y] + share * dy
            row[3 + part] += start[BY_Z] + share * dz
            row[5] += start[BY_RATIO] + share * dr
            row[6] += (end[VALUE] - start[VALUE]) / phase_end
            row[7] += start[RADIUS] + share * (end[RADIUS] - start[RADIUS])
            row[7] += w_share * (
                abs(dx) * w_x
                + abs(dy) * w_y
                + abs(dz) * w_z
                + abs(dr) * w_ratio
                + abs(end[RADIUS] - start[RADIUS])
            )
    for row in range(3):
        size = 2.0 + product + abs(relaxation[row, 0])
        for i in range(6):
            size += abs(relaxation[row, 1 + i]) * widths[i]
        if row == 0:
            relaxation[0, 0] -= MARGIN + ROUNDING * (size + by_thrust * product)
        else:
            relaxation[row, 7] += MARGIN + ROUNDING * (size + relaxation[row, 7])
    return product


@kernel
def dual_bound(relaxation, product, widths, nu_lift, nu_thrust):
    """Return a lower bound of the Lagrangian over a box.

    Parameters
    ----------
    relaxation, product
        From `relax`.
    widths : (6,) ndarray of float
        Half-widths of the box.
    nu_lift, nu_thrust : float
        Multipliers.

    Returns
    -------
    float
        The bound.
    """
    by_thrust = relaxation[0, 7]
    total = relaxation[0, 0] + nu_lift * relaxation[1, 0] + nu_thrust * relaxation[2, 0]
    for i in range(6):
        slope = relaxation[0, 1 + i] + nu_lift * relaxation[1, 1 + i] + nu_thrust * relaxation[2, 1 + i]
        total -= abs(slope) * widths[i]
    total -= abs(nu_lift) * relaxation[1, 7] + abs(nu_thrust) * relaxation[2, 7]
    return total - abs(nu_thrust + by_thrust) * product


@kernel
def _climb(relaxation, product, widths, nu, d_lift, d_thrust, work):
    """Move the multipliers to the maximum of the dual along a direction; return whether it has one.

    It has none where this combination of the residuals is nowhere zero in the box.
    """
    origins, rates, breaks, drops = work[0], work[1], work[2], work[3]
    for i in range(6):
        origins[i] = (
            relaxation[0, 1 + i] + nu[0] * relaxation[1, 1 + i] + nu[1] * relaxation[2, 1 + i]
        ) * widths[i]
        rates[i] = (d_lift * relaxation[1, 1 + i] + d_thrust * relaxation[2, 1 + i]) * widths[i]
    origins[6], rates[6] = nu[0] * relaxation[1, 7], d_lift * relaxation[1, 7]
    origins[7], rates[7] = nu[1] * relaxation[2, 7], d_thrust * relaxation[2, 7]
    origins[8], rates[8] = (nu[1] + relaxation[0, 7]) * product, d_thrust * product
    rate = d_lift * relaxation[1, 0] + d_thrust * relaxation[2, 0]
    # The dual is concave and piecewise linear along the direction: walk its breakpoints until the slope turns.
    slope, count = rate, 0
    for i in range(9):
        slope += abs(rates[i])
        if rates[i] == 0.0:
            continue
        step = -origins[i] / rates[i]
        k = count
        while k > 0 and breaks[k - 1] > step:
            breaks[k], drops[k] = breaks[k - 1], drops[k - 1]
            k -= 1
        breaks[k], drops[k] = step, 2.0 * abs(rates[i])
        count += 1
    if abs(rate) > slope - rate:
        return False
    chosen = 0.0
    for k in range(count):
        slope -= drops[k]
        chosen = breaks[k]
        if slope <= 0.0:
            break
    nu[0] += chosen * d_lift
    nu[1] += chosen * d_thrust
    return True


@kernel
def _ascend(relaxation, product, widths, nu, threshold, work):
    """Improve the multipliers until the bound exceeds the threshold or no search direction helps; return the bound."""
    best = dual_bound(relaxation, product, widths, nu[0], nu[1])
    for _ in range(ASCENT_ROUNDS):
        before = best
        for direction in range(3):
            if best > threshold:
                return best
            if direction == 0:
                d_lift, d_thrust = relaxation[1, 0], relaxation[2, 0]
                for i in range(6):
                    slope = relaxation[0, 1 + i] + nu[0] * relaxation[1, 1 + i] + nu[1] * relaxation[2, 1 + i]
                    sign = 1.0 if slope > 0.0 else -1.0
                    d_lift -= sign * relaxation[1, 1 + i] * widths[i]
                    d_thrust -= sign * relaxation[2, 1 + i] * widths[i]
                if d_lift == 0.0 and d_thrust == 0.0:
                    continue
            else:
                d_lift, d_thrust = (1.0, 0.0) if direction == 1 else (0.0, 1.0)
            if not _climb(relaxation, product, widths, nu, d_lift, d_thrust, work):
                return np.inf
            best = max(best, dual_bound(relaxation, product, widths, nu[0], nu[1]))
        if best - before < 1e-3 * (threshold - best):
            break
    return best


@kernel
def _contract(low, high, relaxation, product, widths, cost_weight, nu_lift, nu_thrust, level):
    """Cut off what of the rim violates weight·cost + ν·residuals ≤ level; return whether anything is left."""
    total = cost_weight * relaxation[0, 0] + nu_lift * relaxation[1, 0] + nu_thrust * relaxation[2, 0]
    for i in range(6):
        slope = (
            cost_weight * relaxation[0, 1 + i]
            + nu_lift * relaxation[1, 1 + i]
            + nu_thrust * relaxation[2, 1 + i]
        )
        total -= abs(slope) * widths[i]
    total -= abs(nu_lift) * relaxation[1, 7] + abs(nu_thrust) * relaxation[2, 7]
    total -= abs(nu_thrust + cost_weight * relaxation[0, 7]) * product
    slack = level - total
    if slack < 0.0:
        return False
    for i in range(6):
        slope = (
            cost_weight * relaxation[0, 1 + i]
            + nu_lift * relaxation[1, 1 + i]
            + nu_thrust * relaxation[2, 1 + i]
        )
        if abs(slope) * 2.0 * widths[i] > slack:
            kept = slack / abs(slope) + ROUNDING * (abs(low[i]) + abs(high[i]))
            if slope > 0.0:
                high[i] = min(high[i], low[i] + kept)
            else:
                low[i] = max(low[i], high[i] - kept)
    return True


@kernel
def examine(low, high, nu, lanes, constants, phase_end, limits, threshold, scratch, forms):
    """Try to clear a box; cut off what can be cut off.

    Parameters
    ----------
    low, high : (6,) ndarray of float
        The box; shrunk in place.
    nu : (2,) ndarray of float
        Multipliers to start from; improved in place.
    lanes, constants : ndarray of float
        The problem.
    phase_end : float
        Greatest phase coordinate.
    limits : (4,) ndarray of float
        Least and greatest mean height, least and greatest amplitude.
    threshold : float
        Cost to be exceeded.
    scratch : (8, 10) ndarray of float
        Scratch; on return rows 0 to 2 hold the last relaxation.
    forms : (2, 2, 2, 6) ndarray of float
        Scratch.

    Returns
    -------
    state : int
        `CLEARED` or `OPEN`.
    bound : float
        Lower bound of the cost of the feasible points of the box as it was given.
    """
    relaxation, widths, work = scratch[0:3, 0:8], scratch[3, 0:6], scratch[4:8]
    half = lanes.shape[1] // 2
    bound = -np.inf
    while True:
        if not _couple(low, high, limits):
            return CLEARED, np.inf
        # Own lift and thrust alone cost this much: decisive where a follower rests on the least amplitude and span.
        amplitude = max(low[2] - high[3], limits[2] - MARGIN)
        own, _, _ = cost_of(
            constants[LIFT_FIXED] + constants[LIFT_RATIO] * low[4],
            amplitude * (constants[THRUST_FIXED] + constants[THRUST_RATIO] * high[4]),
            constants,
        )
        bound = max(bound, own * (1.0 - ROUNDING) - MARGIN)
        if bound > threshold:
            return CLEARED, bound
        before = 1.0
        for i in range(6):
            widths[i] = 0.5 * (high[i] - low[i]) + ROUNDING * (abs(low[i]) + abs(high[i]))
            before *= max(0.5 * (high[i] - low[i]), 1e-12)
        for part in range(2):
            enclose_wake_force(
                0.5 * (low[0] + high[0]),
                0.5 * (low[1] + high[1]),
                0.5 * (low[2 + part] + high[2 + part]),
                0.5 * (low[4] + high[4]),
                widths[0],
                widths[1],
                widths[2 + part],
                widths[4],
                lanes,
                part * half,
                (part + 1) * half,
                part == 0,
                phase_end,
                constants[CORE2],
                forms[part],
            )
        product = relax(low, high, widths, forms, constants, phase_end, relaxation)
        if not (
            _contract(low, high, relaxation, product, widths, 0.0, 1.0, 0.0, 0.0)
            and _contract(low, high, relaxation, product, widths, 0.0, -1.0, 0.0, 0.0)
            and _contract(low, high, relaxation, product, widths, 0.0, 0.0, 1.0, 0.0)
            and _contract(low, high, relaxation, product, widths, 0.0, 0.0, -1.0, 0.0)
        ):
            return CLEARED, np.inf
        bound = max(bound, _ascend(relaxation, product, widths, nu, threshold, work))
        if bound > threshold:
            return CLEARED, bound
        if not _contract(low, high, relaxation, product, widths, 1.0, nu[0], nu[1], threshold):
            return CLEARED, bound
        after = 1.0
        for i in range(6):
            after *= max(0.5 * (high[i] - low[i]), 1e-12)
        if after > WORTH_REPEATING * before:
            return OPEN, bound


@kernel
def _split_variable(low, high, nu, relaxation):
    """Choose the variable whose range widens the bound most.

    A variable widens it by its slope and by its share in the radii, which grow with the squares of the ranges of the
    positions.  Multipliers enter with a floor, or a coarse box would look flat in all but one variable.
    """
    weight_lift = max(abs(nu[0]), LEAST_MULTIPLIERS[0])
    weight_thrust = max(abs(nu[1]), LEAST_MULTIPLIERS[1])
    radius = weight_lift * relaxation[1, 7] + weight_thrust * relaxation[2, 7]
    squares = 0.0
    for i in range(5):
        squares += (0.5 * (high[i] - low[i])) ** 2
    best, chosen = -1.0, 0
    for i in range(6):
        width = 0.5 * (high[i] - low[i])
        score = width * (
            abs(relaxation[0, 1 + i])
            + weight_lift * abs(relaxation[1, 1 + i])
            + weight_thrust * abs(relaxation[2, 1 + i])
            + LEAST_SLOPE / WIDTHS[i]
        )
        if i < 5:
            score += RADIUS_WEIGHT * radius * width * width / squares
        if score > best:
            best, chosen = score, i
    return chosen


@kernel
def clear_boxes(
    lows, highs, multipliers, floors, height, limits, threshold, budget, lanes, constants, phase_end, centre
):
    """Examine boxes from the top of a stack, and split those that stay open, until it is empty or the budget spent.

    Parameters
    ----------
    lows, highs : (d, 6) ndarray of float
        The stack of boxes in (x, y, z_up, z_down, R, t); changed in place.
    multipliers : (d, 2) ndarray of float
        Multipliers of the two balances to start from in each box.
    floors : (d,) ndarray of float
        What each box is known to cost at least.
    height : int
        Boxes on the stack.
    limits : (4,) ndarray of float
        Least and greatest mean height, least and greatest amplitude.
    threshold : float
        Cost to be exceeded.
    budget : int
        Most boxes to examine.
    lanes, constants : ndarray of float
        The problem, see `upwash.optimum.problem.PairProblem`.
    phase_end : float
        Greatest phase coordinate.
    centre : (6,) ndarray of float
        Overwritten: centre, in (x, y, z, h, R, t), of the last narrow box that stayed open, NaN if none did.

    Returns
    -------
    height : int
        Boxes left on the stack.
    boxes : int
        Boxes examined.
    left_open : float
        Least cost in the boxes that were given up, being too small to split; infinite if none was.
    """
    scratch, forms = np.empty((8, 10)), np.empty((2, 2, 2, 6))
    low, high, nu = np.empty(6), np.empty(6), np.empty(2)
    boxes, left_open = 0, np.inf
    centre[:] = np.nan
    while height > 0 and boxes < budget:
        height -= 1
        boxes += 1
        for i in range(6):
            low[i], high[i] = lows[height, i], highs[height, i]
        nu[0], nu[1] = multipliers[height, 0], multipliers[height, 1]
        state, bound = examine(low, high, nu, lanes, constants, phase_end, limits, threshold, scratch, forms)
        if state == CLEARED:
            continue
        bound = max(bound, floors[height])
        widest = 0.0
        for i in range(6):
            widest = max(widest, 0.5 * (high[i] - low[i]) / WIDTHS[i])
        if widest < SEARCH_WIDTH:
            for i in range(6):
                centre[i] = 0.5 * (low[i] + high[i])
            up, down = centre[2], centre[3]
            centre[2], centre[3] = 0.5 * (up + down), up - down
        if widest < TINY or height + 2 > lows.shape[0]:
            left_open = min(left_open, bound)
            continue
        chosen = _split_variable(low, high, nu, scratch[0:3, 0:8])
        middle = 0.5 * (low[chosen] + high[chosen])
        for child in range(2):
            for i in range(6):
                lows[height, i], highs[height, i] = low[i], high[i]
            if child == 0:
                highs[height, chosen] = middle
            else:
                lows[height, chosen] = middle
            multipliers[height, 0], multipliers[height, 1], floors[height] = nu[0], nu[1], bound
            height += 1
    return height, boxes, left_open


def certify(
    problem: PairProblem,
    bounds: NDArray[np.float64],
    incumbent: float,
    tolerance: float,
    budget: int = SearchSettings.most_boxes,
    descend: Descend | None = None,
) -> Certificate:
    """Prove that no feasible point within bounds costs less than an incumbent by more than a tolerance.

    Parameters
    ----------
    problem : PairProblem
        The problem, with two stroke states.
    bounds : (6, 2) ndarray of float
        Bounds in (x, y, z, h, R, t): the problem's, or those of its V part.
    incumbent : float
        Cost of the best solution known, in costs of the lone leader; infinite if none is known.
    tolerance : float
        By how much the incumbent may exceed the bound, as a share of the bound.
    budget : int
        Most boxes to examine.
    descend : callable, optional
        Starts -> the solutions that local solves within the bounds reach, best first.  With it open boxes are searched
        for better solutions, which then are to be undercut.

    Returns
    -------
    Certificate
        What was shown.
    """
    (x, y, z, h, ratio, phase) = bounds
    if np.any(bounds[:, 0] > bounds[:, 1]):
        return Certificate(np.inf, 0, True, None)
    lows, highs = np.empty((DEPTH, 6)), np.empty((DEPTH, 6))
    multipliers, floors = np.zeros((DEPTH, 2)), np.full(DEPTH, -np.inf)
    lows[0] = x[0], y[0], z[0] + 0.5 * h[0], z[0] - 0.5 * h[1], ratio[0], phase[0]
    highs[0] = x[1], y[1], z[1] + 0.5 * h[1], z[1] - 0.5 * h[0], ratio[1], phase[1]
    lows[0, 2:4] -= MARGIN
    highs[0, 2:4] += MARGIN
    limits, centre = np.array([*z, *h]), np.empty(6)
    # With no incumbent a box is cleared only where no balance is possible.
    best, threshold = incumbent, min(incumbent / (1.0 + tolerance), UNREACHABLE_COST)
    found: Basin | None = None
    height, boxes, left_open = 1, 0, np.inf
    while height > 0 and boxes < budget:
        height, examined, given_up = clear_boxes(
            lows,
            highs,
            multipliers,
            floors,
            height,
            limits,
            threshold,
            min(SEARCH_EVERY, budget - boxes),
            problem.lanes,
            problem.constants,
            problem.phase_span(),
            centre,
        )
        boxes, left_open = boxes + examined, min(left_open, given_up)
        if descend and height > 0 and not np.isnan(centre[0]):
            better = next((one for one in descend(centre[None, :]) if one.cost < best), None)
            if better is not None:
                found, best, threshold = better, better.cost, better.cost / (1.0 + tolerance)
    left_open = min(left_open, np.min(floors[:height], initial=np.inf))
    # What stayed open before a better solution lowered the threshold may lie above it now.
    is_closed = bool(left_open >= threshold)
    lower_bound = np.inf if is_closed and not np.isfinite(best) else min(left_open, threshold)
    return Certificate(float(lower_bound), boxes, is_closed, found)
