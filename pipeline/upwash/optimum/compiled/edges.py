"""Core edges: how far a follower's node is from one, and how the forces' slopes jump there; compiled.

An edge's distance is s = r²/r_c² − 1: negative in the core, zero on the edge.
"""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled.lanes import (
    ALONG_X,
    ALONG_Z,
    CENTRE_Y,
    CORE2,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    HEIGHT,
    LAST_X,
    LAST_Z,
    NODE,
    SLIDING,
    SPAN_FIXED,
    SPAN_FLEXED,
    STEADY,
)
from upwash.kernel import kernel

FIRST, LAST, LEFT, RIGHT = range(4)


@kernel(allocates=False)
def edge_distance(point, lanes, lane, filament, gradient):
    """Return how far a lane's node is from a filament's core edge, and fill in the gradient.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    lanes : (15, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    lane, filament : int
        Which lane, and which of `FILAMENTS`.
    gradient : (6,) ndarray of float
        Overwritten.

    Returns
    -------
    float
        s = r²/r_c² − 1.
    """
    height, node, core2 = lanes[HEIGHT, lane], lanes[NODE, lane], lanes[CORE2, lane]
    z = point[2] + height * point[3]
    gradient[5] = 0.0
    if filament == FIRST or filament == LAST:
        dx = point[0] - (lanes[FIRST_X, lane] if filament == FIRST else lanes[LAST_X, lane])
        dz = z - (lanes[FIRST_Z, lane] if filament == FIRST else lanes[LAST_Z, lane])
        gradient[0] = 2.0 * dx / core2
        gradient[1] = 0.0
        gradient[2] = 2.0 * dz / core2
        gradient[3] = height * gradient[2]
        gradient[4] = 0.0
        return (dx * dx + dz * dz) / core2 - 1.0
    span = lanes[SPAN_FIXED, lane] + lanes[SPAN_FLEXED, lane] * point[4]
    side = 1.0 if filament == LEFT else -1.0
    dy = point[1] + node * span - lanes[CENTRE_Y, lane] + side * lanes[HALF_WIDTH, lane]
    ax, az = lanes[ALONG_X, lane], lanes[ALONG_Z, lane]
    off_plane = az * (point[0] - lanes[FIRST_X, lane]) - ax * (z - lanes[FIRST_Z, lane])
    gradient[0] = 2.0 * off_plane * az / core2
    gradient[1] = 2.0 * dy / core2
    gradient[2] = -2.0 * off_plane * ax / core2
    gradient[3] = height * gradient[2]
    gradient[4] = node * lanes[SPAN_FLEXED, lane] * gradient[1]
    return (dy * dy + off_plane * off_plane) / core2 - 1.0


@kernel(allocates=False)
def edge_pull(point, lanes, group, edge, multipliers):
    """Return what the filaments of an edge add to the Lagrangian at that edge.

    Crossing the edge outwards changes the Lagrangian's slope along s by minus this much: the optimum can be pinned to
    the edge only where it is negative.

    Parameters
    ----------
    point, lanes
        As for `edge_distance`.
    group : (4, l) ndarray of int
        Number of the edge of each filament and lane, from `distinct_edges`.
    edge : int
        Which edge.
    multipliers : (2,) ndarray of float
        Multipliers of the lift and the thrust balance.

    Returns
    -------
    float
        ν · (lift, thrust) of the edge's filaments, evaluated with their inner branch.
    """
    total = 0.0
    for lane in range(lanes.shape[1]):
        for filament in range(4):
            if group[filament, lane] != edge:
                continue
            span = lanes[SPAN_FIXED, lane] + lanes[SPAN_FLEXED, lane] * point[4]
            weight = span * (lanes[STEADY, lane] + lanes[SLIDING, lane] * point[5])
            z = point[2] + lanes[HEIGHT, lane] * point[3]
            y = point[1] + lanes[NODE, lane] * span - lanes[CENTRE_Y, lane]
            x0, x1 = point[0] - lanes[FIRST_X, lane], point[0] - lanes[LAST_X, lane]
            z0, z1 = z - lanes[FIRST_Z, lane], z - lanes[LAST_Z, lane]
            yl, yr = y + lanes[HALF_WIDTH, lane], y - lanes[HALF_WIDTH, lane]
            if filament == FIRST or filament == LAST:
                xe, ze, sign = (x0, z0, 1.0) if filament == FIRST else (x1, z1, -1.0)
                q = xe * xe + ze * ze
                strength = sign * (yl / np.sqrt(q + yl * yl) - yr / np.sqrt(q + yr * yr))
                by_lift, by_thrust = ze, -xe
            else:
                ye, sign = (yl, -1.0) if filament == LEFT else (yr, 1.0)
                ax, az = lanes[ALONG_X, lane], lanes[ALONG_Z, lane]
                near = np.sqrt(x0 * x0 + ye * ye + z0 * z0)
                far = np.sqrt(x1 * x1 + ye * ye + z1 * z1)
                strength = sign * ye * ((ax * x0 + az * z0) / near - (ax * x1 + az * z1) / far)
                by_lift, by_thrust = -az, ax
            total += (
                weight
                * strength
                / lanes[CORE2, lane]
                * (multipliers[0] * by_lift + multipliers[1] * by_thrust)
            )
    return total
