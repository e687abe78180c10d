"""Limits of a follower's place that are no bounds of one variable: value, slopes, and what is left of a box; compiled.

A wall is a row (q_x, q_y, q_z, a_x, a_y, a_z, c) with q ≥ 0: the place keeps it where

    g = q_x x² + q_y y² + q_z z² + a_x x + a_y y + a_z z + c ≥ 0.
"""

from __future__ import annotations

import math

from upwash.kernel import kernel
from upwash.optimum.compiled.relaxation import MARGIN
from upwash.optimum.variables import VARIABLE_COUNT

NEVER_CROSSED = -1e300
"""What a wall pulls the Lagrangian's slope down by beyond it, where a core edge tells whether it pays to cross it."""

WALL_ROUNDING = 1e-13
"""What rounding may add to a wall's value, as a share of the sum of all its parts."""


@kernel(allocates=False)
def wall_value(point, walls, wall, gradient):
    """Return by how much a place keeps a wall, and fill in the gradient.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    walls : (w, 7) ndarray of float
        The walls.
    wall : int
        Which of them.
    gradient : (6,) ndarray of float
        Overwritten.

    Returns
    -------
    float
        g, negative beyond the wall.
    """
    value = walls[wall, 6]
    for i in range(VARIABLE_COUNT):
        gradient[i] = 0.0
    for i in range(3):
        square, slope = walls[wall, i], walls[wall, 3 + i]
        value += (square * point[i] + slope) * point[i]
        gradient[i] = 2.0 * square * point[i] + slope
    return value


@kernel(allocates=False)
def _most(square, slope, low, high):
    """Return the greatest value of square · v² + slope · v in a range."""
    # It is convex: the greatest is at an end.
    return max((square * low + slope) * low, (square * high + slope) * high)


@kernel(allocates=False)
def cut_by_walls(low, high, walls):
    """Cut off what of a box in (x, y, z_up, z_down, R, t) lies beyond a wall; return whether anything is left.

    What misses a wall by no more than `MARGIN` is left, as with a bound.
    """
    for wall in range(walls.shape[0]):
        z_low, z_high = 0.5 * (low[2] + low[3]), 0.5 * (high[2] + high[3])
        parts_x = _most(walls[wall, 0], walls[wall, 3], low[0], high[0])
        parts_y = _most(walls[wall, 1], walls[wall, 4], low[1], high[1])
        parts_z = _most(walls[wall, 2], walls[wall, 5], z_low, z_high)
        size = abs(parts_x) + abs(parts_y) + abs(parts_z) + abs(walls[wall, 6]) + 1.0
        slack = MARGIN + WALL_ROUNDING * size
        total = parts_x + parts_y + parts_z + walls[wall, 6] + slack
        if total < 0.0:
            return False
        for i in range(2):
            square, slope = walls[wall, i], walls[wall, 3 + i]
            rest = total - (parts_x if i == 0 else parts_y)
            at_low = (square * low[i] + slope) * low[i] + rest
            at_high = (square * high[i] + slope) * high[i] + rest
            # Convex, so that beyond the wall is what lies between its zeros.
            if at_low < 0.0 <= at_high:
                low[i] = max(low[i], _zero(square, slope, rest, 1.0) - slack)
            elif at_high < 0.0 <= at_low:
                high[i] = min(high[i], _zero(square, slope, rest, -1.0) + slack)
            if low[i] > high[i]:
                return False
    return True


@kernel(allocates=False)
def _zero(square, slope, rest, side):
    """Return the greater (1) or the lesser (−1) zero of square · v² + slope · v + rest."""
    if square == 0.0:
        return -rest / slope
    root = math.sqrt(max(slope * slope - 4.0 * square * rest, 0.0))
    return (-slope + side * root) / (2.0 * square)
