"""The force of a wake that begins at the leader and ends, on a follower's whole span, with its Jacobian: compiled.

The follower's wingbeat is told in parts: a step of its own, in a state of the wake that the leader then shows.  The
force on a follower at (x, y, z) with amplitude h, upstroke span ratio R and phase coordinate t is

    F = Σ_parts (β₀ + β₁ t) ∫_{y−s}^{y+s} V(x − D t, η, z + c h) dη,      s = a + d R,

with c the height of the step's tip and s its half-span; lift comes from V_x and thrust from V_z.  Where the birds are
held in states the wake stands still (D = 0) and t enters through the weights.  Where they are followed through the
wingbeat the weights are constant (β₁ = 0) and the wake is carried downstream with t: its runs stand still in a frame
that moves with them (D = λ), in which the two cuts, at the leader and where the wake ends, slide along their runs.

A long wake is laid out in several parts of one step, each a few wavelengths of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.exact_span import (
    ALONG_X,
    ALONG_Z,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    LAST_X,
    LAST_Z,
    ON_EDGE,
    STRENGTH,
    Core,
    wind_of_runs,
)
from upwash.kernel import kernel

# Rows of an array of parts; each column is one.
HEIGHT, SPAN_FIXED, SPAN_FLEXED = 0, 1, 2  # c, a, d of the follower's step
STEADY, SLIDING = 3, 4  # β₀ and β₁, times the force per ∫ v dy
ON_DOWNSTROKE = 5  # 1 for a step of the downstroke, 0 for one of the upstroke

# Columns of an array of cuts: the run of a part that is cut at the leader, and that which is where the wake ends.
AT_LEADER, AT_END = 0, 1
NO_CUT = -1


class CutWake(NamedTuple):
    """A wake that ends, and the parts of the follower's wingbeat in it.

    Attributes
    ----------
    core : Core
        The filaments' core.
    drift : float
        D, how far downstream the wake is carried by one wingbeat.
    length : float
        Length of the wake.
    parts : (6, p) ndarray of float
        Parts of the wingbeat.
    runs : (p, 9, r) ndarray of float
        The wake of each part, see `upwash.aero.compiled.exact_span`, at t = 0.
    cuts : (p, 2) ndarray of int
        Runs whose ends slide; `NO_CUT` where none does.
    whole : (p,) ndarray of int
        Parts of one number hold the wake of one state or step together.
    """

    core: Core
    drift: float
    length: float
    parts: NDArray[np.float64]
    runs: NDArray[np.float64]
    cuts: NDArray[np.int64]
    whole: NDArray[np.int64]


@kernel(allocates=False)
def slide_cuts(wake, part, t, runs):
    """Move the cuts of a part to where they are at a phase coordinate, in the frame of the runs.

    Parameters
    ----------
    wake : CutWake
        The wake.
    part : int
        Number of the part.
    t : float
        Phase coordinate.
    runs : (9, r) ndarray of float
        The part's runs; changed in place.
    """
    at_leader, at_end = wake.cuts[part, AT_LEADER], wake.cuts[part, AT_END]
    if at_leader != NO_CUT:
        x = -wake.drift * t
        rise = runs[ALONG_Z, at_leader] / runs[ALONG_X, at_leader]
        runs[FIRST_X, at_leader] = x
        runs[FIRST_Z, at_leader] = runs[LAST_Z, at_leader] - (runs[LAST_X, at_leader] - x) * rise
    if at_end != NO_CUT:
        x = wake.length - wake.drift * t
        rise = runs[ALONG_Z, at_end] / runs[ALONG_X, at_end]
        runs[LAST_X, at_end] = x
        runs[LAST_Z, at_end] = runs[FIRST_Z, at_end] + (x - runs[FIRST_X, at_end]) * rise


@kernel(allocates=False)
def _turned(p, d2, e, w, core):
    """Return ∂A/∂p at the right less that at the left side of a run, for one end of the wing."""
    least, soft, total = core.least, core.softening, 0.0
    for side in range(2):
        y = e - w if side == 0 else e + w
        r = d2 + y * y + soft
        slope = 0.0
        if r > least:
            slope = -1.0 / math.sqrt(p * p + r)
        else:
            # A corner itself is told a millionth of a core beside it.
            u, v = math.sqrt(p * p + r + 1e-24 * least), math.sqrt(p * p + least)
            slope = -1.0 / v + core.per_radius2 * ((u - v) + p * p * (1.0 / u - 1.0 / v))
        total += slope if side == 0 else -slope
    return total


@kernel(allocates=False)
def _wind_of_slide(x, z, ax, az, e, w, core):
    """Return by how much the antiderivative at one end of the wing changes as a cut is drawn back along its run.

    Parameters
    ----------
    x, z : float
        The wing as seen from the cut.
    ax, az : float
        Direction of the run, from its first to its last station; the first is the cut, and is moved along it.
    e, w : float
        The wing's end by y, and half the run's width.
    core : Core
        The filaments' core.
    """
    q, p, d = x * x + z * z + core.softening, ax * x + az * z, az * x - ax * z
    yl, yr = e + w, e - w
    tiny = 1e-24 * core.least
    nl, nr = math.sqrt(q + yl * yl + tiny), math.sqrt(q + yr * yr + tiny)
    g = 1.0 / (q if q > core.least else core.least)
    by_q = g * g if q > ON_EDGE * core.least else 0.0
    n = nl - nr
    t = g * (1.0 / nl - 1.0 / nr) - 2.0 * by_q * n
    along = g * n - _turned(p, d * d, e, w, core)
    return -az * along - z * p * t, ax * along + x * p * t


@kernel(allocates=False)
def wind_of_cut(x, z, right, left, runs, run, which, core):
    """Return by how much the integrals of v_x and v_z along a wing change as a cut slides downstream by a length of x.

    Parameters
    ----------
    x, z, right, left : float
        Station and height of the wing's line, and its ends by y.
    runs : (9, r) ndarray of float
        The runs.
    run, which : int
        Which of them is cut, and at which of its ends: `AT_LEADER`, the first, or `AT_END`, the last.
    core : Core
        The filaments' core.
    """
    ax, az, w = runs[ALONG_X, run], runs[ALONG_Z, run], runs[HALF_WIDTH, run]
    at_x, at_z = (
        (runs[FIRST_X, run], runs[FIRST_Z, run])
        if which == AT_LEADER
        else (runs[LAST_X, run], runs[LAST_Z, run])
    )
    right_x, right_z = _wind_of_slide(x - at_x, z - at_z, ax, az, right, w, core)
    left_x, left_z = _wind_of_slide(x - at_x, z - at_z, ax, az, left, w, core)
    # The last station has the other sign, and the length along the run is 1/a_x of that along x.
    strength = (1.0 if which == AT_LEADER else -1.0) * runs[STRENGTH, run] / ax
    return strength * (right_x - left_x), strength * (right_z - left_z)


@kernel(allocates=False)
def cut_wake_force(point, wake, runs, jacobian):
    """Return the lift and thrust of a wake that ends and fill in their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, amplitude, upstroke span ratio, phase coordinate.
    wake : CutWake
        The wake and the parts of the follower's wingbeat.
    runs : (p, 9, r) ndarray of float
        A copy of the wake's runs, whose cuts are moved.
    jacobian : (2, 6) ndarray of float
        Overwritten: derivatives of lift (row 0) and thrust (row 1) by the six variables.

    Returns
    -------
    tuple of float
        Lift and thrust, positive upstream.
    """
    x, y, z, amplitude, ratio, t = point[0], point[1], point[2], point[3], point[4], point[5]
    parts, drift, core = wake.parts, wake.drift, wake.core
    x -= drift * t
    lift = lift_x = lift_y = lift_z = lift_h = lift_r = lift_t = 0.0
    thrust = thrust_x = thrust_y = thrust_z = thrust_h = thrust_r = thrust_t = 0.0
    for part in range(parts.shape[1]):
        height, flexed = parts[HEIGHT, part], parts[SPAN_FLEXED, part]
        span = parts[SPAN_FIXED, part] + flexed * ratio
        up, right, left, own = z + height * amplitude, y + span, y - span, runs[part]
        slides_x = slides_z = 0.0
        if drift != 0.0:
            slide_cuts(wake, part, t, own)
            for which in range(2):
                if wake.cuts[part, which] != NO_CUT:
                    cut_x, cut_z = wind_of_cut(x, up, right, left, own, wake.cuts[part, which], which, core)
                    slides_x += cut_x
                    slides_z += cut_z
        gx, gz, gx_x, gx_z, gz_x, gz_z, xr, xl, zr, zl = wind_of_runs(x, up, right, left, own, core)
        weight = parts[STEADY, part] + parts[SLIDING, part] * t
        lift += weight * gx
        lift_x += weight * gx_x
        lift_y += weight * (xr - xl)
        lift_z += weight * gx_z
        lift_h += weight * height * gx_z
        lift_r += weight * flexed * (xr + xl)
        lift_t += parts[SLIDING, part] * gx - weight * drift * (gx_x + slides_x)
        thrust += weight * gz
        thrust_x += weight * gz_x
        thrust_y += weight * (zr - zl)
        thrust_z += weight * gz_z
        thrust_h += weight * height * gz_z
        thrust_r += weight * flexed * (zr + zl)
        thrust_t += parts[SLIDING, part] * gz - weight * drift * (gz_x + slides_z)
    jacobian[0, 0], jacobian[0, 1], jacobian[0, 2] = lift_x, lift_y, lift_z
    jacobian[0, 3], jacobian[0, 4], jacobian[0, 5] = lift_h, lift_r, lift_t
    jacobian[1, 0], jacobian[1, 1], jacobian[1, 2] = thrust_x, thrust_y, thrust_z
    jacobian[1, 3], jacobian[1, 4], jacobian[1, 5] = thrust_h, thrust_r, thrust_t
    return lift, thrust
