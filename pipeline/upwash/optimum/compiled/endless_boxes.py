"""Branch and bound behind an endless wake: boxes in (X, y, z_up, z_down, R), examined, cut and split.

X = λΦ is the place in the frozen wake, and the heights of the raised and the lowered tip make the height of each step
a mix of the two.  Bounds of the Lagrangian, contraction and the choice of what to split are those of a pair behind one
wavelength, whose sixth variable, the phase, has no range here.
"""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled.lanes import PHASE
from upwash.kernel import kernel
from upwash.optimum.compiled import enclosure
from upwash.optimum.compiled.boxes import (
    CLEARED,
    LEAST_MULTIPLIERS,
    LEAST_SLOPE,
    OPEN,
    SEARCH_WIDTH,
    TINY,
    WIDTHS,
)
from upwash.optimum.compiled.enclosure import ROUNDING
from upwash.optimum.compiled.endless_enclosure import (
    BY_DOWN,
    BY_RATIO,
    BY_UP,
    BY_X,
    BY_Y,
    RADIUS,
    VALUE,
    enclose_far_force,
    enclose_near_force,
)
from upwash.optimum.compiled.problem import cost_of
from upwash.optimum.compiled.relaxation import MARGIN, ascend, contract, couple, relax
from upwash.optimum.compiled.walls import cut_by_walls
from upwash.optimum.variables import VARIABLE_COUNT

_VALUE, _BY_X, _BY_Y, _BY_Z, _BY_RATIO, _RADIUS = (
    enclosure.VALUE,
    enclosure.BY_X,
    enclosure.BY_Y,
    enclosure.BY_Z,
    enclosure.BY_RATIO,
    enclosure.RADIUS,
)


WORTH_REPEATING = 0.5
SHARP = 0.1
"""The enclosure of the far runs over a larger box serves while its radius is at most this share of the near ones'."""

RADIUS_WEIGHT = 30.0


@kernel
def _split_variable(low, high, nu, relaxation):
    """Choose the variable whose range widens the bound most, by its slopes and by its share in the radii.

    Radii grow with the squares of the ranges.  Multipliers enter with a floor, or a coarse box would look flat in all
    but one variable.
    """
    weight_lift = max(abs(nu[0]), LEAST_MULTIPLIERS[0])
    weight_thrust = max(abs(nu[1]), LEAST_MULTIPLIERS[1])
    radius = weight_lift * relaxation[1, 7] + weight_thrust * relaxation[2, 7]
    squares = 0.0
    for i in range(PHASE):
        squares += (0.5 * (high[i] - low[i])) ** 2
    best, chosen = -1.0, 0
    for i in range(PHASE):
        width = 0.5 * (high[i] - low[i])
        score = width * (
            abs(relaxation[0, 1 + i])
            + weight_lift * abs(relaxation[1, 1 + i])
            + weight_thrust * abs(relaxation[2, 1 + i])
            + LEAST_SLOPE / WIDTHS[i]
        )
        score += RADIUS_WEIGHT * radius * width * width / squares
        if score > best:
            best, chosen = score, i
    return chosen


@kernel
def examine_endless(low, high, nu, wake, constants, limits, threshold, far, scratch, forms, places):
    """Try to clear a box; cut off what can be cut off.

    Parameters
    ----------
    low, high : (6,) ndarray of float
        The box, its sixth range being 0 to 0; shrunk in place.
    nu : (2,) ndarray of float
        Multipliers to start from; improved in place.
    wake : EndlessEnclosure
        The wake.
    constants : Constants
        The problem.
    limits : Limits
        Ranges of mean height and amplitude.
    threshold : float
        Cost to be exceeded.
    far : (3, 7) ndarray of float
        Enclosure of the far runs' force over a box that holds this one, lift and thrust, and that box's centre; the
        greatest radius, infinite, where there is none yet.  Renewed where it is not sharp enough.
    scratch : (12, 10) ndarray of float
        Scratch; on return rows 0 to 2 hold the last relaxation.
    forms : (2, 2, 2, 6) ndarray of float
        Scratch.
    places : (4, n) ndarray of float
        Scratch.

    Returns
    -------
    state : int
        `CLEARED` or `OPEN`.
    bound : float
        Lower bound of the cost of the feasible points of the box as it was given.
    """
    relaxation, widths, work = scratch[0:3, 0:8], scratch[3, 0:6], scratch[4:8]
    force, point, jacobian = scratch[8:10, 0:7], scratch[10, 0:5], np.empty((2, 5))
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
        up, down = 0.5 * (low[2] + high[2]), 0.5 * (low[3] + high[3])
        point[0] = 0.5 * (low[0] + high[0]) / wake.near.wavelength
        point[1], point[2], point[3] = 0.5 * (low[1] + high[1]), 0.5 * (up + down), up - down
        point[4] = 0.5 * (low[4] + high[4])
        enclose_near_force(point, widths, wake, places, jacobian, force)
        sharp = SHARP * min(force[0, RADIUS], force[1, RADIUS])
        if max(far[0, RADIUS], far[1, RADIUS]) > sharp:
            enclose_far_force(point, widths, wake, places, jacobian, far)
            for i in range(PHASE):
                far[2, i] = 0.5 * (low[i] + high[i])
        for c in range(2):
            force[c, VALUE] += far[c, VALUE]
            for i in range(PHASE):
                force[c, VALUE] += far[c, BY_X + i] * (0.5 * (low[i] + high[i]) - far[2, i])
                force[c, BY_X + i] += far[c, BY_X + i]
            force[c, RADIUS] += far[c, RADIUS]
        for c in range(2):
            for end in range(2):
                forms[0, end, c, :] = 0.0
                forms[1, end, c, :] = 0.0
                forms[0, end, c, _VALUE] = force[c, VALUE]
                forms[0, end, c, _BY_X] = force[c, BY_X]
                forms[0, end, c, _BY_Y] = force[c, BY_Y]
                forms[0, end, c, _BY_Z] = force[c, BY_UP]
                forms[1, end, c, _BY_Z] = force[c, BY_DOWN]
                forms[0, end, c, _BY_RATIO] = force[c, BY_RATIO]
                forms[0, end, c, _RADIUS] = force[c, RADIUS]
        product = relax(low, high, widths, forms, constants, 1.0, relaxation)
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


@kernel
def clear_endless_boxes(
    lows, highs, multipliers, floors, fars, height, limits, threshold, budget, wake, constants, walls, centre
):
    """Examine boxes from the top of a stack, and split those that stay open, until it is empty or the budget spent.

    Parameters
    ----------
    lows, highs, multipliers, floors, height, limits, threshold, budget, walls, centre
        As for `upwash.optimum.compiled.boxes.clear_boxes`.
    fars : (d, 3, 7) ndarray of float
        Of each box on the stack, an enclosure of the far runs' force, see `examine_endless`.
    wake : EndlessEnclosure
        The wake.
    constants : Constants
        The problem.

    Returns
    -------
    height : int
        Boxes left on the stack.
    boxes : int
        Boxes examined.
    left_open : float
        Least cost in the boxes that were given up, being too small to split; infinite if none was.
    """
    scratch, forms = np.empty((12, 10)), np.empty((2, 2, 2, 6))
    places = np.empty((4, wake.near.steps.shape[1]))
    low, high, nu, far = np.empty(VARIABLE_COUNT), np.empty(VARIABLE_COUNT), np.empty(2), np.empty((3, 7))
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
        for i in range(3):
            for k in range(7):
                far[i, k] = fars[height, i, k]
        state, bound = examine_endless(
            low, high, nu, wake, constants, limits, threshold, far, scratch, forms, places
        )
        if state == CLEARED:
            continue
        bound = max(bound, floors[height])
        widest = 0.0
        for i in range(PHASE):
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
            for i in range(3):
                for k in range(7):
                    fars[height, i, k] = far[i, k]
            height += 1
    return height, boxes, left_open
