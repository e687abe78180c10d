"""Bounds of the cost over a box from affine forms of what must balance: relaxation, multipliers, contraction.

A box is cleared when for some multipliers ν

    C + ν · (lift residual, thrust residual) > threshold

throughout it; then no point of the box both balances and costs as little as the threshold.  Any ν is valid: the
parent's is taken and improved by exact line searches on the dual of the affine relaxation.  The same bound, turned
round, tells how much of a box's rim can be cut off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from upwash.kernel import kernel
from upwash.optimum.compiled.enclosure import (
    BY_RATIO,
    BY_X,
    BY_Y,
    BY_Z,
    RADIUS,
    ROUNDING,
    VALUE,
)
from upwash.optimum.compiled.problem import (
    cost_of,
)
from upwash.optimum.variables import VARIABLE_COUNT

MARGIN = 1e-10
"""How much a point may miss a bound (in semispans) and a balance (in weights) and still keep its box from being
cleared, and by how much its cost must exceed the threshold (in costs of the lone leader)."""

ASCENT_ROUNDS = 3


class Limits(NamedTuple):
    """Ranges of the mean height of the wingtips and of the amplitude, in semispans."""

    least_height: float
    greatest_height: float
    least_amplitude: float
    greatest_amplitude: float


@kernel(allocates=False)
def couple(low, high, limits):
    """Shrink z_up and z_down to the ranges of mean height and amplitude; return whether anything is left."""
    z_low, z_high, h_low, h_high = limits
    low[2] = max(low[2], max(low[3] + h_low, 2.0 * z_low - high[3]) - MARGIN)
    high[2] = min(high[2], min(high[3] + h_high, 2.0 * z_high - low[3]) + MARGIN)
    low[3] = max(low[3], max(low[2] - h_high, 2.0 * z_low - high[2]) - MARGIN)
    high[3] = min(high[3], min(high[2] - h_low, 2.0 * z_high - low[2]) + MARGIN)
    return low[2] <= high[2] and low[3] <= high[3]


@kernel(allocates=False)
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
    constants : Constants
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
    lift = constants.lift_fixed + constants.lift_ratio * centre_ratio
    span = constants.thrust_fixed + constants.thrust_ratio * centre_ratio
    thrust = amplitude * span
    product = abs(constants.thrust_ratio) * (w_up + w_down) * w_ratio
    by_ratio = amplitude * constants.thrust_ratio
    # The cost is convex in lift and thrust, so its tangent plane supports it from below.
    cost, by_lift, by_thrust = cost_of(lift, thrust, constants)
    relaxation[:] = 0.0
    relaxation[0, 0] = cost
    relaxation[0, 3], relaxation[0, 4] = by_thrust * span, -by_thrust * span
    relaxation[0, 5] = by_lift * constants.lift_ratio + by_thrust * by_ratio
    relaxation[0, 7] = by_thrust
    relaxation[1, 0] = lift - 1.0
    relaxation[1, 5] = constants.lift_ratio
    relaxation[2, 0] = thrust - constants.drag
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
        for i in range(VARIABLE_COUNT):
            size += abs(relaxation[row, 1 + i]) * widths[i]
        if row == 0:
            relaxation[0, 0] -= MARGIN + ROUNDING * (size + by_thrust * product)
        else:
            relaxation[row, 7] += MARGIN + ROUNDING * (size + relaxation[row, 7])
    return product


@kernel(allocates=False)
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
    for i in range(VARIABLE_COUNT):
        slope = relaxation[0, 1 + i] + nu_lift * relaxation[1, 1 + i] + nu_thrust * relaxation[2, 1 + i]
        total -= abs(slope) * widths[i]
    total -= abs(nu_lift) * relaxation[1, 7] + abs(nu_thrust) * relaxation[2, 7]
    return total - abs(nu_thrust + by_thrust) * product


@kernel(allocates=False)
def _climb(relaxation, product, widths, nu, d_lift, d_thrust, work):
    """Move the multipliers to the maximum of the dual along a direction; return whether it has one.

    It has none where this combination of the residuals is nowhere zero in the box.
    """
    origins, rates, breaks, drops = work[0], work[1], work[2], work[3]
    for i in range(VARIABLE_COUNT):
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


@kernel(allocates=False)
def ascend(relaxation, product, widths, nu, threshold, work):
    """Improve the multipliers until the bound exceeds the threshold or no search direction helps; return the bound."""
    best = dual_bound(relaxation, product, widths, nu[0], nu[1])
    for _ in range(ASCENT_ROUNDS):
        before = best
        for direction in range(3):
            if best > threshold:
                return best
            if direction == 0:
                d_lift, d_thrust = relaxation[1, 0], relaxation[2, 0]
                for i in range(VARIABLE_COUNT):
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


@kernel(allocates=False)
def contract(low, high, relaxation, product, widths, cost_weight, nu_lift, nu_thrust, level):
    """Cut off what of the rim violates weight·cost + ν·residuals ≤ level; return whether anything is left."""
    total = cost_weight * relaxation[0, 0] + nu_lift * relaxation[1, 0] + nu_thrust * relaxation[2, 0]
    for i in range(VARIABLE_COUNT):
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
    for i in range(VARIABLE_COUNT):
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
