"""The force of an endless wake on a follower, averaged over a wingbeat, with its Jacobian: compiled.

With X = x − λθ the wake stands still and repeats with the wavelength λ, so where and when the follower flies enters
through one number, the spatial phase Φ = x/λ − κ.  The force on a follower at (Φ, y, z) with amplitude h and upstroke
span ratio R is

    F = Σ_steps w ∫_{y−s}^{y+s} V(λ(Φ − ψ), η, z + c h) dη,      s = a + d R,

with ψ the phase of the step, w its weight, c the height of its tip and s its half-span; lift comes from V_x and thrust
from V_z.  V sums the runs of a window of the wake, four wavelengths on each side of its middle, and what is
beyond them in the mean, as far as the fourth power of the distance.

The window's middle is X = 0 for the steps of the downstroke and X = −λ/2 for those of the upstroke and does not follow
the bird, so the force is smooth for −¼ ≤ Φ ≤ ¾ and somewhat beyond, and a phase is to be taken in that range.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.exact_span import Core, wind_of_runs
from upwash.aero.compiled.rings import FAST
from upwash.kernel import kernel

LEAST_PHASE, MOST_PHASE = -0.25, 0.75
"""Range of the spatial phase that the window is made for."""

# Rows of an array of tails; each column is a kind of run beyond one end of the window.
SIDE = 0  # 1 downstream, −1 upstream
START = 1  # where the tail starts, along its side
TAIL_HALF_WIDTH, TAIL_STRENGTH = 2, 3
SOURCE = 4  # strength of the point source in which the streamwise dipoles end
CURVED, STRETCHED, SPREAD = 5, 6, 7  # coefficients of the second derivatives of the potential

# Rows of an array of steps; each column is a step of the follower's wingbeat, the downstroke's first.
SHIFT = 0  # X of the window's middle at Φ = 0, in wavelengths
HEIGHT = 1  # c
SPAN_FIXED, SPAN_FLEXED = 2, 3  # a, d
WEIGHT = 4

# The variables of the force, in order.
PHASE, Y, Z, AMPLITUDE, SPAN_RATIO = range(5)


class EndlessWake(NamedTuple):
    """An endless wake and the steps of the follower in it.

    Attributes
    ----------
    wavelength : float
        Wavelength, in the unit of length.
    core : Core
        The filaments' core.
    runs : (2, 9, r) ndarray of float
        Runs of the window of the follower's downstroke and of its upstroke, see `upwash.aero.compiled.exact_span`.
    tails : (2, 8, 4) ndarray of float
        What is beyond the two windows.
    steps : (5, n) ndarray of float
        Steps of the follower.
    downstroke_steps : int
        How many of them belong to the downstroke.
    """

    wavelength: float
    core: Core
    runs: NDArray[np.float64]
    tails: NDArray[np.float64]
    steps: NDArray[np.float64]
    downstroke_steps: int


@kernel(fastmath=FAST, inline="always")
def _tail_field(m0, m1, m2, m3, log, xi, z, u, source, curved, stretched, spread):
    """Derivatives by x and by z of a tail's potential, linear in the moments of its corners.

    I, the potential of a spanwise segment, is a function of q = x² + z² = 1/u and the corners alone; g1 to g3 are its
    derivatives by q.
    """
    g1 = -0.5 * m0 * u
    g2 = (-0.25 * m1 + 0.5 * m0 * u) * u
    g3 = (0.125 * m2 + (0.5 * m1 - m0 * u) * u) * u
    ix, iz = 2.0 * xi * g1, 2.0 * z * g1
    ixx_z = (4.0 * g2 + 8.0 * xi * xi * g3) * z
    ixz_z = (4.0 * g2 + 8.0 * z * z * g3) * xi
    ixx_x = (12.0 * g2 + 8.0 * xi * xi * g3) * xi
    by_x = -0.5 * iz + source * ix + curved * ixx_z + stretched * ixx_x + spread * xi * m2
    by_z = 0.5 * (ix - log) + source * iz + curved * ixz_z + stretched * ixx_z + spread * z * m2
    return by_x, by_z


@kernel(fastmath=FAST, inline="always")
def _corner_moments(xi, q, e, w):
    """Differences between the left and the right corner of powers of their distance, and their slopes over y."""
    yl, yr = e + w, e - w
    nl, nr = math.sqrt(q + yl * yl), math.sqrt(q + yr * yr)
    fl, fr = nl - xi, nr - xi
    # One division gives all four reciprocals; ξ is far below zero, so the log's argument is near 1.
    n, f = nl * nr, fl * fr
    per_all = 1.0 / (n * f)
    per_n, per_f = per_all * f, per_all * n
    il, ir, sl, sr = per_n * nr, per_n * nl, per_f * fr, per_f * fl
    il3, ir3 = il * il * il, ir * ir * ir
    il5, ir5 = il3 * il * il, ir3 * ir * ir
    t = (fl - fr) / (fl + fr)
    t2 = t * t
    log = 1.0 / 11.0 + t2 * (1.0 / 13.0 + t2 * (1.0 / 15.0 + t2 * (1.0 / 17.0)))
    log = 2.0 * t * (1.0 + t2 * (1.0 / 3.0 + t2 * (0.2 + t2 * (1.0 / 7.0 + t2 * (1.0 / 9.0 + t2 * log)))))
    return (
        nl - nr,
        il - ir,
        il3 - ir3,
        il5 - ir5,
        log,
        il * sl - ir * sr,
        yl * il - yr * ir,
        yr * ir3 - yl * il3,
        3.0 * (yr * ir5 - yl * il5),
        yl * il * sl - yr * ir * sr,
    )


@kernel(fastmath=FAST, inline="always")
def _wind_of_tail(x, z, right, left, side, start, w, source, curved, stretched, spread):
    """As `wind_of_runs`, of a tail of unit strength."""
    xi = side * x - start
    q = xi * xi + z * z
    u = 1.0 / q
    r0, r1, r2, r3, r_log, r_k, r0e, r1e, r2e, r_log_e = _corner_moments(xi, q, right, w)
    l0, l1, l2, l3, l_log, l_k, l0e, l1e, l2e, l_log_e = _corner_moments(xi, q, left, w)
    m0, m1, m2, m3, log, k = r0 - l0, r1 - l1, r2 - l2, r3 - l3, r_log - l_log, r_k - l_k
    gx, gz = _tail_field(m0, m1, m2, m3, log, xi, z, u, source, curved, stretched, spread)
    xr, zr = _tail_field(r0e, r1e, r2e, 0.0, r_log_e, xi, z, u, source, curved, stretched, spread)
    xl, zl = _tail_field(l0e, l1e, l2e, 0.0, l_log_e, xi, z, u, source, curved, stretched, spread)
    g1 = -0.5 * m0 * u
    g2 = (-0.25 * m1 + 0.5 * m0 * u) * u
    g3 = (0.125 * m2 + (0.5 * m1 - m0 * u) * u) * u
    g4 = (-0.1875 * m3 + (-0.375 * m2 + (-1.5 * m1 + 3.0 * m0 * u) * u) * u) * u
    xi2, z2 = xi * xi, z * z
    ixx, ixz, izz = 2.0 * g1 + 4.0 * xi2 * g2, 4.0 * xi * z * g2, 2.0 * g1 + 4.0 * z2 * g2
    ixxxx = 12.0 * g2 + (48.0 * g3 + 16.0 * xi2 * g4) * xi2
    ixxxz = (24.0 * g3 + 16.0 * xi2 * g4) * xi * z
    ixxzz = 4.0 * g2 + 8.0 * (xi2 + z2) * g3 + 16.0 * xi2 * z2 * g4
    ixzzz = (24.0 * g3 + 16.0 * z2 * g4) * xi * z
    by_xx = -0.5 * ixz + source * ixx + curved * ixxxz + stretched * ixxxx + spread * (m2 - 3.0 * xi2 * m3)
    by_xz = -0.5 * izz + source * ixz + curved * ixxzz + stretched * ixxxz - 3.0 * spread * xi * z * m3
    by_zz = 0.5 * (ixz - z * k) + source * izz + curved * ixzzz + stretched * ixxzz
    by_zz += spread * (m2 - 3.0 * z2 * m3)
    return side * gx, gz, by_xx, side * by_xz, side * by_xz, by_zz, side * xr, side * xl, zr, zl


@kernel(fastmath=FAST, allocates=False)
def endless_force_jacobian(point, wake, places, jacobian):
    """Return the lift and thrust of an endless wake and fill in their Jacobian.

    Parameters
    ----------
    point : (5,) ndarray of float
        Spatial phase, y, z, amplitude, upstroke span ratio.
    wake : EndlessWake
        The wake and the follower's steps.
    places : (4, n) ndarray of float
        Scratch: station, height and both ends of the wing in each step.
    jacobian : (2, 5) ndarray of float
        Overwritten: derivatives of lift (row 0) and thrust (row 1) by the five variables.

    Returns
    -------
    tuple of float
        Lift and thrust, positive upstream.
    """
    steps, tails = wake.steps, wake.tails
    wavelength, count, downs = wake.wavelength, wake.steps.shape[1], wake.downstroke_steps
    phase, y, z, amplitude, ratio = point[0], point[1], point[2], point[3], point[4]
    for k in range(count):
        span = steps[SPAN_FIXED, k] + steps[SPAN_FLEXED, k] * ratio
        places[0, k] = wavelength * (phase + steps[SHIFT, k])
        places[1, k] = z + steps[HEIGHT, k] * amplitude
        places[2, k] = y + span
        places[3, k] = y - span
    lift = lift_x = lift_y = lift_z = lift_h = lift_r = 0.0
    thrust = thrust_x = thrust_y = thrust_z = thrust_h = thrust_r = 0.0
    for window in range(2):
        begin, end = (0, downs) if window == 0 else (downs, count)
        runs = wake.runs[window]
        for k in range(begin, end):
            gx, gz, gx_x, gx_z, gz_x, gz_z, xr, xl, zr, zl = wind_of_runs(
                places[0, k], places[1, k], places[2, k], places[3, k], runs, wake.core
            )
            weight, height, flexed = steps[WEIGHT, k], steps[HEIGHT, k], steps[SPAN_FLEXED, k]
            lift += weight * gx
            lift_x += weight * gx_x
            lift_y += weight * (xr - xl)
            lift_z += weight * gx_z
            lift_h += weight * height * gx_z
            lift_r += weight * flexed * (xr + xl)
            thrust += weight * gz
            thrust_x += weight * gz_x
            thrust_y += weight * (zr - zl)
            thrust_z += weight * gz_z
            thrust_h += weight * height * gz_z
            thrust_r += weight * flexed * (zr + zl)
        for tail in range(tails.shape[2]):
            side, start, w = tails[window, SIDE, tail], tails[window, START, tail], tails[window, 2, tail]
            strength, source = tails[window, TAIL_STRENGTH, tail], tails[window, SOURCE, tail]
            curved, stretched = tails[window, CURVED, tail], tails[window, STRETCHED, tail]
            spread = tails[window, SPREAD, tail]
            for k in range(begin, end):
                gx, gz, gx_x, gx_z, gz_x, gz_z, xr, xl, zr, zl = _wind_of_tail(
                    places[0, k],
                    places[1, k],
                    places[2, k],
                    places[3, k],
                    side,
                    start,
                    w,
                    source,
                    curved,
                    stretched,
                    spread,
                )
                weight = strength * steps[WEIGHT, k]
                height, flexed = steps[HEIGHT, k], steps[SPAN_FLEXED, k]
                lift += weight * gx
                lift_x += weight * gx_x
                lift_y += weight * (xr - xl)
                lift_z += weight * gx_z
                lift_h += weight * height * gx_z
                lift_r += weight * flexed * (xr + xl)
                thrust += weight * gz
                thrust_x += weight * gz_x
                thrust_y += weight * (zr - zl)
                thrust_z += weight * gz_z
                thrust_h += weight * height * gz_z
                thrust_r += weight * flexed * (zr + zl)
    jacobian[0, 0], jacobian[0, 1], jacobian[0, 2] = wavelength * lift_x, lift_y, lift_z
    jacobian[0, 3], jacobian[0, 4] = lift_h, lift_r
    jacobian[1, 0], jacobian[1, 1], jacobian[1, 2] = wavelength * thrust_x, thrust_y, thrust_z
    jacobian[1, 3], jacobian[1, 4] = thrust_h, thrust_r
    return lift, thrust


@kernel
def fill_endless_force(points, wake, forces):
    """Overwrite an array with the lift and thrust of an endless wake on many followers.

    The interpreter's lock is released meanwhile, so threads may fill slices of one array at the same time.

    Parameters
    ----------
    points : (p, 5) ndarray of float
        Spatial phase, from −¼ to ¾, y, z, amplitude and upstroke span ratio of each.
    wake : EndlessWake
        The wake and the followers' steps.
    forces : (p, 2) ndarray of float
        Overwritten: lift and thrust, positive upstream.
    """
    places, jacobian = np.empty((4, wake.steps.shape[1])), np.empty((2, 5))
    for i in range(points.shape[0]):
        forces[i, 0], forces[i, 1] = endless_force_jacobian(points[i], wake, places, jacobian)
