"""Core edges behind an endless wake: where a step of the follower crosses the core of a spanwise filament.

The force is smooth but there: a step's contribution is the lesser of an inner and an outer branch, and its slope jumps.
An edge is a step and a station of its window; its distance is s = q/r_c² − 1, with q the squared distance of the step's
wing from the station, negative inside.
"""

from __future__ import annotations

import math

from upwash.aero.compiled.endless import HEIGHT, SHIFT, SPAN_FIXED, SPAN_FLEXED, WEIGHT
from upwash.aero.compiled.exact_span import ON_EDGE
from upwash.kernel import kernel

# Rows of an array of stations; each column is one.
STATION_X, STATION_Z = 0, 1
BEGINS, BEGINS_STRENGTH = 2, 3  # half-width and circulation of the run that begins there
ENDS, ENDS_STRENGTH = 4, 5  # of the run that ends there


@kernel(allocates=False)
def edge_distance(point, wake, stations, edge, gradient):
    """Return how far a step is from a core edge, and fill in the gradient.

    Parameters
    ----------
    point : (6,) ndarray of float
        X = λΦ, y, z, h, R, 0.
    wake : EndlessWake
        The wake.
    stations : (2, 6, m) ndarray of float
        Stations of its windows.
    edge : int
        Number of the edge: step · m + station.
    gradient : (6,) ndarray of float
        Overwritten.

    Returns
    -------
    float
        s.
    """
    step, station = edge // stations.shape[2], edge % stations.shape[2]
    window, core2 = (0 if step < wake.downstroke_steps else 1), wake.core.least
    dx = point[0] + wake.wavelength * wake.steps[SHIFT, step] - stations[window, STATION_X, station]
    dz = point[2] + wake.steps[HEIGHT, step] * point[3] - stations[window, STATION_Z, station]
    gradient[0], gradient[1], gradient[2] = 2.0 * dx / core2, 0.0, 2.0 * dz / core2
    gradient[3], gradient[4], gradient[5] = wake.steps[HEIGHT, step] * gradient[2], 0.0, 0.0
    return (dx * dx + dz * dz) / core2 - 1.0


@kernel(allocates=False)
def corner_sum(e, q, begins, strength, ends, end_strength):
    """Return the difference of the distances to the corners at one end of the wing, and its slopes by q and e."""
    n0, n1 = math.sqrt(q + (e + begins) ** 2), math.sqrt(q + (e - begins) ** 2)
    n2, n3 = math.sqrt(q + (e + ends) ** 2), math.sqrt(q + (e - ends) ** 2)
    by_q = 0.5 * (strength * (1.0 / n0 - 1.0 / n1) - end_strength * (1.0 / n2 - 1.0 / n3))
    by_e = strength * ((e + begins) / n0 - (e - begins) / n1)
    by_e -= end_strength * ((e + ends) / n2 - (e - ends) / n3)
    return strength * (n0 - n1) - end_strength * (n2 - n3), by_q, by_e


@kernel(allocates=False)
def edge_force(point, wake, stations, edge, side, force, jacobian):
    """Add to the force what continuing a branch of a step's contribution past its core edge changes.

    Parameters
    ----------
    point, wake, stations, edge
        As for `edge_distance`.
    side : int
        1 to continue the outer branch, −1 the inner; 0 for the inner branch alone, as a whole.
    force : (2,) ndarray of float
        Lift and thrust; added to.
    jacobian : (2, 6) ndarray of float
        Their slopes by X, y, z, h, R and nothing; added to.
    """
    step, station = edge // stations.shape[2], edge % stations.shape[2]
    window, core2 = (0 if step < wake.downstroke_steps else 1), wake.core.least
    x = point[0] + wake.wavelength * wake.steps[SHIFT, step] - stations[window, STATION_X, station]
    height, flexed = wake.steps[HEIGHT, step], wake.steps[SPAN_FLEXED, step]
    z = point[2] + height * point[3] - stations[window, STATION_Z, station]
    q = x * x + z * z
    span = wake.steps[SPAN_FIXED, step] + flexed * point[4]
    begins, strength = stations[window, BEGINS, station], stations[window, BEGINS_STRENGTH, station]
    ends, end_strength = stations[window, ENDS, station], stations[window, ENDS_STRENGTH, station]
    right, right_q, right_e = corner_sum(point[1] + span, q, begins, strength, ends, end_strength)
    left, left_q, left_e = corner_sum(point[1] - span, q, begins, strength, ends, end_strength)
    size, by_q = right - left, right_q - left_q
    # What is added to 1 / max(q, core²), and to its slope by q, which on the edge is that from inside.
    share, share_q = (1.0 / q, -1.0 / (q * q)) if side > 0 else (1.0 / core2, 0.0)
    if side != 0:
        share -= 1.0 / max(q, core2)
        share_q += 1.0 / (q * q) if q > ON_EDGE * core2 else 0.0
    weight = wake.steps[WEIGHT, step]
    value, slope = weight * share * size, weight * (share * by_q + share_q * size)
    by_y, by_r = weight * share * (right_e - left_e), weight * share * flexed * (right_e + left_e)
    # Lift goes with z, thrust with −x, of the plane vortex.
    force[0] += z * value
    force[1] -= x * value
    jacobian[0, 0] += 2.0 * x * z * slope
    jacobian[0, 1] += z * by_y
    jacobian[0, 2] += value + 2.0 * z * z * slope
    jacobian[0, 3] += height * (value + 2.0 * z * z * slope)
    jacobian[0, 4] += z * by_r
    jacobian[1, 0] -= value + 2.0 * x * x * slope
    jacobian[1, 1] -= x * by_y
    jacobian[1, 2] -= 2.0 * x * z * slope
    jacobian[1, 3] -= height * 2.0 * x * z * slope
    jacobian[1, 4] -= x * by_r


@kernel(allocates=False)
def edge_pull(point, wake, stations, edge, multipliers, force, jacobian):
    """Return what a step adds to the Lagrangian through the filaments of a core edge, by the inner branch.

    Crossing the edge outwards changes the Lagrangian's slope along s by minus this much: the optimum can be pinned to
    the edge only where it is negative.

    Parameters
    ----------
    point, wake, stations, edge
        As for `edge_distance`.
    multipliers : (2,) ndarray of float
        Multipliers of the lift and the thrust balance.
    force, jacobian : (2,) and (2, 6) ndarray of float
        Scratch.
    """
    force[0] = force[1] = 0.0
    edge_force(point, wake, stations, edge, 0, force, jacobian)
    return multipliers[0] * force[0] + multipliers[1] * force[1]
