"""Branch and bound: boxes in (x, y, z_up, z_down, R, t), examined, cut and split; compiled.

`upwash.optimum.certify` says what is proved.
"""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled.lanes import PHASE, SPAN_RATIO, X, Y, Z
from upwash.kernel import kernel
from upwash.optimum.compiled.enclosure import ROUNDING, enclose_wake_force
from upwash.optimum.compiled.problem import (
    cost_of,
)
from upwash.optimum.compiled.relaxation import MARGIN, ascend, contract, couple, relax
from upwash.optimum.compiled.steps_enclosure import enclose_steps
from upwash.optimum.compiled.walls import cut_by_walls
from upwash.optimum.variables import SCALE, VARIABLE_COUNT

TINY = 1e-9
"""Half-width, in units of `WIDTHS`, below which a box is not split further but left open."""

WIDTHS = SCALE[np.array([X, Y, Z, Z, SPAN_RATIO, PHASE])]
"""Lengths over which the six variables of a box matter alike."""

WORTH_REPEATING = 0.3
RADIUS_WEIGHT = 10.0
LEAST_SLOPE = 1e-3
LEAST_MULTIPLIERS = (0.3, 0.5)
"""Floor of the multipliers in the branching score; without it a coarse box looks flat in all but one variable."""

SEARCH_WIDTH = 0.25
"""A local solve may be tried from the centre of an open box that is narrower than this."""

# What becomes of a box.
CLEARED, OPEN = range(2)


@kernel(allocates=False)
def examine(low, high, nu, lanes, first_lanes, constants, phase_end, limits, threshold, scratch, forms):
    """Try to clear a box; cut off what can be cut off.

    Parameters
    ----------
    low, high : (6,) ndarray of float
        The box; shrunk in place.
    nu : (2,) ndarray of float
        Multipliers to start from; improved in place.
    lanes, first_lanes, constants : ndarray
        The problem.
    phase_end : float
        Greatest phase coordinate.
    limits : Limits
        Ranges of mean height and amplitude.
    threshold : float
        Cost to be exceeded.
    scratch : (8, 10) ndarray of float
        Scratch; on return rows 0 to 2 hold the last relaxation.
    forms : (3, 2, 2, 6) ndarray of float
        Scratch.

    Returns
    -------
    state : int
        `CLEARED` or `OPEN`.
    bound : float
        Lower bound of the cost of the feasible points of the box as it was given.
    """
    relaxation, widths, work = scratch[0:3, 0:8], scratch[3, 0:6], scratch[4:8]
    bound = -np.inf
    while True:
        if not couple(low, high, limits):
            return CLEARED, np.inf
        # Own lift and thrust alone cost this much: decisive where a follower rests on the least amplitude and span.
        amplitude = max(low[2] - high[3], limits.least_amplitude - MARGIN)
        own, _, _ = cost_of(
            constants.lift_fixed + constants.lift_ratio * low[4],
            amplitude * (constants.thrust_fixed + constants.thrust_ratio * high[4]),
            constants,
        )
        bound = max(bound, own * (1.0 - ROUNDING) - MARGIN)
        if bound > threshold:
            return CLEARED, bound
        before = 1.0
        for i in range(VARIABLE_COUNT):
            widths[i] = 0.5 * (high[i] - low[i]) + ROUNDING * (abs(low[i]) + abs(high[i]))
            before *= max(0.5 * (high[i] - low[i]), 1e-12)
        if first_lanes.size > 3:
            enclose_steps(low, high, widths, lanes, first_lanes, phase_end, forms)
        else:
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
                    first_lanes[part],
                    first_lanes[part + 1],
                    part == 0,
                    phase_end,
                    forms[part],
                )
        product = relax(low, high, widths, forms, constants, phase_end, relaxation)
        if not (
            contract(low, high, relaxation, product, widths, 0.0, 1.0, 0.0, 0.0)
            and contract(low, high, relaxation, product, widths, 0.0, -1.0, 0.0, 0.0)
            and contract(low, high, relaxation, product, widths, 0.0, 0.0, 1.0, 0.0)
            and contract(low, high, relaxation, product, widths, 0.0, 0.0, -1.0, 0.0)
        ):
            return CLEARED, np.inf
        bound = max(bound, ascend(relaxation, product, widths, nu, threshold, work))
        if bound > threshold:
            return CLEARED, bound
        if not contract(low, high, relaxation, product, widths, 1.0, nu[0], nu[1], threshold):
            return CLEARED, bound
        after = 1.0
        for i in range(VARIABLE_COUNT):
            after *= max(0.5 * (high[i] - low[i]), 1e-12)
        if after > WORTH_REPEATING * before:
            return OPEN, bound


@kernel(allocates=False)
def _split_variable(low, high, nu, relaxation):
    """Choose the variable whose range widens the bound most.

    A variable widens it by its slope and by its share in the radii, which grow with the squares of the ranges of the
    positions.  Multipliers enter with a floor, or a coarse box would look flat in all but one variable.
    """
    weight_lift = max(abs(nu[0]), LEAST_MULTIPLIERS[0])
    weight_thrust = max(abs(nu[1]), LEAST_MULTIPLIERS[1])
    radius = weight_lift * relaxation[1, 7] + weight_thrust * relaxation[2, 7]
    squares = 0.0
    for i in range(PHASE):
        squares += (0.5 * (high[i] - low[i])) ** 2
    best, chosen = -1.0, 0
    for i in range(VARIABLE_COUNT):
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
    lows,
    highs,
    multipliers,
    floors,
    height,
    limits,
    threshold,
    budget,
    lanes,
    first_lanes,
    constants,
    phase_end,
    walls,
    centre,
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
    limits : Limits
        Ranges of mean height and amplitude.
    threshold : float
        Cost to be exceeded.
    budget : int
        Most boxes to examine.
    lanes, first_lanes, constants : ndarray
        The problem, see `upwash.optimum.problem.PairProblem`.
    phase_end : float
        Greatest phase coordinate.
    walls : (w, 7) ndarray of float
        Limits of the place, see `upwash.optimum.compiled.walls`.
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
    scratch, forms = np.empty((8, 10)), np.empty((3, 2, 2, 6))
    low, high, nu = np.empty(VARIABLE_COUNT), np.empty(VARIABLE_COUNT), np.empty(2)
    boxes, left_open = 0, np.inf
    centre[:] = np.nan
    while height > 0 and boxes < budget:
        height -= 1
        boxes += 1
        for i in range(VARIABLE_COUNT):
            low[i], high[i] = lows[height, i], highs[height, i]
        if not cut_by_walls(low, high, walls):
            continue
        nu[0], nu[1] = multipliers[height, 0], multipliers[height, 1]
        state, bound = examine(
            low, high, nu, lanes, first_lanes, constants, phase_end, limits, threshold, scratch, forms
        )
        if state == CLEARED:
            continue
        bound = max(bound, floors[height])
        widest = 0.0
        for i in range(VARIABLE_COUNT):
            widest = max(widest, 0.5 * (high[i] - low[i]) / WIDTHS[i])
        if widest < SEARCH_WIDTH:
            for i in range(VARIABLE_COUNT):
                centre[i] = 0.5 * (low[i] + high[i])
            up, down = centre[2], centre[3]
            centre[2], centre[3] = 0.5 * (up + down), up - down
        if widest < TINY or height + 2 > lows.shape[0]:
            left_open = min(left_open, bound)
            continue
        chosen = _split_variable(low, high, nu, scratch[0:3, 0:8])
        middle = 0.5 * (low[chosen] + high[chosen])
        for child in range(2):
            for i in range(VARIABLE_COUNT):
                lows[height, i], highs[height, i] = low[i], high[i]
            if child == 0:
                highs[height, chosen] = middle
            else:
                lows[height, chosen] = middle
            multipliers[height, 0], multipliers[height, 1], floors[height] = nu[0], nu[1], bound
            height += 1
    return height, boxes, left_open
