"""Branch and bound, written once: boxes in (x, y, z_up, z_down, R, t), examined, cut and split; compiled.

`clearing` makes it for a kind of wake from the kernel that encloses its force.  `upwash.optimum.certify` says what is
proved.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from upwash.kernel import kernel
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
from upwash.optimum.compiled.problem import cost_of
from upwash.optimum.compiled.relaxation import MARGIN, ascend, contract, couple, relax
from upwash.optimum.variables import VARIABLE_COUNT


def clearing(
    make_room: Any,
    enclose: Any,
    stay_within: Any,
    place: Any,
    *,
    radius_weight: float,
    worth_repeating: float,
) -> tuple[Any, Any]:
    """Return what examines a box of one kind of wake, and what clears a stack of them.

    Parameters
    ----------
    make_room : kernel
        (felt) -> scratch.
    enclose : kernel
        (low, high, widths, felt, phase_end, room, forms, by_phase, reach): fills in the forms of the wake's force over
        a box at both ends of the phase coordinate, as for `upwash.optimum.compiled.relaxation.relax`; the slopes by the
        phase coordinate of lift and thrust that are not a difference of the two; and how far each variable of the box
        reaches into the radii, in one unit for all.
    stay_within : kernel
        (low, high, felt) -> whether anything is left of a box, which is shrunk to the ranges that its variables have
        together.
    place : kernel
        (centre, felt): the centre of a box, changed in place to a point of the problem.
    radius_weight : float
        How much the radii count in the choice of the variable to split.
    worth_repeating : float
        A box that was cut to less than this share of its size is examined once more.

    Returns
    -------
    tuple of two kernels
        `examine` and `clear`, see there.
    """

    @kernel(allocates=False)
    def examine(low, high, nu, felt, constants, phase_end, limits, threshold, room, scratch, forms):
        """Try to clear a box; cut off what can be cut off.

        Parameters
        ----------
        low, high : (6,) ndarray of float
            The box; shrunk in place.
        nu : (2,) ndarray of float
            Multipliers to start from; improved in place.
        felt : NamedTuple
            The wake, as `enclose` takes it.
        constants : Constants
            The problem.
        phase_end : float
            Greatest phase coordinate.
        limits : Limits
            Ranges of mean height and amplitude.
        threshold : float
            Cost to be exceeded.
        room : NamedTuple
            Scratch of `enclose`.
        scratch : (10, 10) ndarray of float
            Scratch; on return rows 0 to 2 hold the last relaxation, and row 9 how far each variable reaches.
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
        by_phase, reach = scratch[8, 0:2], scratch[9, 0:6]
        bound = -np.inf
        while True:
            if not (couple(low, high, limits) and stay_within(low, high, felt)):
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
            enclose(low, high, widths, felt, phase_end, room, forms, by_phase, reach)
            product = relax(low, high, widths, forms, constants, phase_end, relaxation)
            for c in range(2):
                relaxation[1 + c, 6] += by_phase[c]
                relaxation[1 + c, 7] += ROUNDING * abs(by_phase[c]) * widths[5]
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
            if after > worth_repeating * before:
                return OPEN, bound

    @kernel(allocates=False)
    def split_variable(low, high, nu, relaxation, reach):
        """Choose the variable whose range widens the bound most, by its slopes and by its share in the radii.

        Radii grow with the squares of what the variables reach.  Multipliers enter with a floor, or a coarse box would
        look flat in all but one variable.
        """
        weight_lift = max(abs(nu[0]), LEAST_MULTIPLIERS[0])
        weight_thrust = max(abs(nu[1]), LEAST_MULTIPLIERS[1])
        radius = weight_lift * relaxation[1, 7] + weight_thrust * relaxation[2, 7]
        squares = 0.0
        for i in range(VARIABLE_COUNT):
            squares += (0.5 * reach[i] * (high[i] - low[i])) ** 2
        best, chosen = -1.0, 0
        for i in range(VARIABLE_COUNT):
            width = 0.5 * (high[i] - low[i])
            score = width * (
                abs(relaxation[0, 1 + i])
                + weight_lift * abs(relaxation[1, 1 + i])
                + weight_thrust * abs(relaxation[2, 1 + i])
                + LEAST_SLOPE / WIDTHS[i]
            )
            score += radius_weight * radius * (reach[i] * width) ** 2 / squares
            if score > best:
                best, chosen = score, i
        return chosen

    @kernel
    def clear(
        lows,
        highs,
        multipliers,
        floors,
        height,
        limits,
        threshold,
        budget,
        felt,
        constants,
        phase_end,
        walls,
        centre,
    ):
        """Examine boxes from the top of a stack, and split those that stay open, until it is empty or the budget spent.

        Parameters
        ----------
        lows, highs : (d, 6) ndarray of float
            The stack of boxes; changed in place.
        multipliers : (d, 2) ndarray of float
            Multipliers of the two balances to start from in each box.
        floors : (d,) ndarray of float
            What each box is known to cost at least.
        height : int
            Boxes on the stack.
        limits, threshold, felt, constants, phase_end
            As for `examine`.
        budget : int
            Most boxes to examine.
        walls : (w, 7) ndarray of float
            Limits of the place, which `stay_within` cuts by.
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
        room, scratch, forms = make_room(felt), np.empty((10, 10)), np.empty((2, 2, 2, 6))
        low, high, nu = np.empty(VARIABLE_COUNT), np.empty(VARIABLE_COUNT), np.empty(2)
        boxes, left_open = 0, np.inf
        centre[:] = np.nan
        while height > 0 and boxes < budget:
            height -= 1
            boxes += 1
            for i in range(VARIABLE_COUNT):
                low[i], high[i] = lows[height, i], highs[height, i]
            nu[0], nu[1] = multipliers[height, 0], multipliers[height, 1]
            state, bound = examine(
                low, high, nu, felt, constants, phase_end, limits, threshold, room, scratch, forms
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
                place(centre, felt)
            if widest < TINY or height + 2 > lows.shape[0]:
                left_open = min(left_open, bound)
                continue
            chosen = split_variable(low, high, nu, scratch[0:3, 0:8], scratch[9, 0:6])
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

    return examine, clear
