"""Core edges of a wake that ends, felt on the whole span: where a step crosses the core of a spanwise filament.

The force is smooth but there, as behind an endless wake.  An edge is a surface s = q/r_c² − 1 = 0, with q the squared
distance of a step's wing from a station of the wake; several parts of the wingbeat may share it.
"""

from __future__ import annotations

from upwash.aero.compiled.exact_span import ON_EDGE
from upwash.kernel import kernel
from upwash.optimum.compiled.endless_edges import corner_sum

# Rows of an array of stations; each column is one in one part of the wingbeat, those of one edge side by side.
STATION_X, STATION_Z = 0, 1
CARRIED_X, CARRIED_Z = 2, 3  # how they change with the phase coordinate
BEGINS, BEGINS_STRENGTH = 4, 5  # half-width and circulation of the run that begins there
ENDS, ENDS_STRENGTH = 6, 7  # of the run that ends there
HEIGHT, SPAN_FIXED, SPAN_FLEXED, STEADY, SLIDING, ON_DOWNSTROKE = range(8, 14)  # of the part
ROWS = 14


@kernel(allocates=False)
def edge_distance(point, core2, stations, first, gradient):
    """Return how far a step is from a core edge, and fill in the gradient.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    core2 : float
        Squared radius of the cores.
    stations : (14, m) ndarray of float
        Stations of the wake, part by part.
    first : int
        The first of the edge's columns.
    gradient : (6,) ndarray of float
        Overwritten.

    Returns
    -------
    float
        s.
    """
    height = stations[HEIGHT, first]
    dx = point[0] - stations[STATION_X, first] - stations[CARRIED_X, first] * point[5]
    dz = point[2] + height * point[3] - stations[STATION_Z, first] - stations[CARRIED_Z, first] * point[5]
    by_x, by_z = 2.0 * dx / core2, 2.0 * dz / core2
    gradient[0], gradient[1], gradient[2], gradient[3], gradient[4] = by_x, 0.0, by_z, height * by_z, 0.0
    gradient[5] = -stations[CARRIED_X, first] * by_x - stations[CARRIED_Z, first] * by_z
    return (dx * dx + dz * dz) / core2 - 1.0


@kernel(allocates=False)
def edge_force(point, core2, stations, first, beyond, side, force, jacobian):
    """Add to the force what continuing a branch past a core edge changes.

    Parameters
    ----------
    point, core2, stations, first
        As for `edge_distance`.
    beyond : int
        The column after the edge's last.
    side : int
        1 to continue the outer branch, −1 the inner; 0 for the inner branch alone, as a whole.
    force : (2,) ndarray of float
        Lift and thrust; added to.
    jacobian : (2, 6) ndarray of float
        Their slopes; added to.
    """
    t = point[5]
    for i in range(first, beyond):
        height, flexed = stations[HEIGHT, i], stations[SPAN_FLEXED, i]
        by_t_x, by_t_z = stations[CARRIED_X, i], stations[CARRIED_Z, i]
        x = point[0] - stations[STATION_X, i] - by_t_x * t
        z = point[2] + height * point[3] - stations[STATION_Z, i] - by_t_z * t
        q = x * x + z * z
        span = stations[SPAN_FIXED, i] + flexed * point[4]
        runs = (
            stations[BEGINS, i],
            stations[BEGINS_STRENGTH, i],
            stations[ENDS, i],
            stations[ENDS_STRENGTH, i],
        )
        right, right_q, right_e = corner_sum(point[1] + span, q, *runs)
        left, left_q, left_e = corner_sum(point[1] - span, q, *runs)
        size, by_q = right - left, right_q - left_q
        # What is added to 1 / max(q, core²), and to its slope by q, which on the edge is that from inside.
        share, share_q = (1.0 / q, -1.0 / (q * q)) if side > 0 else (1.0 / core2, 0.0)
        if side != 0:
            share -= 1.0 / max(q, core2)
            share_q += 1.0 / (q * q) if q > ON_EDGE * core2 else 0.0
        weight = stations[STEADY, i] + stations[SLIDING, i] * t
        value, slope = share * size, 2.0 * (share * by_q + share_q * size)
        by_y, by_r = share * (right_e - left_e), share * flexed * (right_e + left_e)
        # Lift goes with z, thrust with −x, of the plane vortex.
        xx, xz, zz = value + x * x * slope, x * z * slope, value + z * z * slope
        force[0] += weight * z * value
        force[1] -= weight * x * value
        jacobian[0, 0] += weight * xz
        jacobian[0, 1] += weight * z * by_y
        jacobian[0, 2] += weight * zz
        jacobian[0, 3] += weight * height * zz
        jacobian[0, 4] += weight * z * by_r
        jacobian[0, 5] += stations[SLIDING, i] * z * value - weight * (by_t_x * xz + by_t_z * zz)
        jacobian[1, 0] -= weight * xx
        jacobian[1, 1] -= weight * x * by_y
        jacobian[1, 2] -= weight * xz
        jacobian[1, 3] -= weight * height * xz
        jacobian[1, 4] -= weight * x * by_r
        jacobian[1, 5] -= stations[SLIDING, i] * x * value - weight * (by_t_x * xx + by_t_z * xz)
