"""The wind along a whole span in closed form: what runs of a wake blow between two points of a wing's line, compiled.

A run is what one half stroke leaves in the wake: a closed rectangle of vortex filaments, tilted in the vertical plane.
The wind that it induces, integrated along the span (y), is the difference of an antiderivative at the wing's two ends,
in closed form; `upwash.aero.span_integral` states the formulas.  Here they are summed over the runs of a
window of the wake, and the runs fill the vector registers.

The antiderivative is once differentiable wherever the wing's end is, the core edge of a tip filament included; at the
core edge of a spanwise filament its gradient jumps, and that from inside is given.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from upwash.aero.compiled.rings import FAST
from upwash.kernel import kernel

# Rows of an array of runs; each column is a run, centred on the plane y = 0, the downstrokes' first.
FIRST_X, LAST_X, FIRST_Z, LAST_Z = range(4)  # stations of the starting and of the stopping vortex
HALF_WIDTH = 4  # half the length of the spanwise filaments
ALONG_X, ALONG_Z = 5, 6  # unit vector from the first to the last station
STRENGTH = 7  # circulation, in the unit of circulation
IS_DOWNSTROKE = 8  # 1 for the runs of a downstroke, 0 for those of an upstroke


ON_EDGE = 1.0 + 1e-9
"""Squared distance of a spanwise filament, in squared core radii, up to which slopes are those from inside its core: a
point on the edge is told from inside however its distance is rounded."""


class Core(NamedTuple):
    """The core of the filaments, by squared lengths.

    Attributes
    ----------
    least : float
        Least squared distance that divides: the squared radius of a Rankine core, 0 for a Rosenhead–Moore core.
    softening : float
        What is added to each squared distance: 0 for a Rankine core, the squared radius for a Rosenhead–Moore core.
    per_radius2 : float
        One over the squared radius.
    """

    least: float
    softening: float
    per_radius2: float


@kernel(fastmath=FAST, inline="always")
def _end_outside(sign, p0, p1, d2, q0, q1, e, w):
    """What one end of the wing contributes to a run's sums, all of it outside the cores of the tip filaments.

    `sign` is 1 for the end where the antiderivative counts and −1 for the other.  The result: N, the difference of the
    distances to the corners, at both stations; their slopes D over x or z and E over y; the argument of the logarithm
    in T as a fraction; what T has beside the logarithm; slopes of T along p, across (over d) and over y.
    """
    yl, yr = e + w, e - w
    yl2, yr2 = yl * yl, yr * yr
    n0l, n0r = math.sqrt(q0 + yl2), math.sqrt(q0 + yr2)
    n1l, n1r = math.sqrt(q1 + yl2), math.sqrt(q1 + yr2)
    # One division gives all six reciprocals: of the distances to the corners and of those to the tip filaments.
    rl, rr = yl2 + d2, yr2 + d2
    n0, n1, r = n0l * n0r, n1l * n1r, rl * rr
    per_n0, per_n1, per_r = n1 * r, n0 * r, n0 * n1
    per_all = 1.0 / (n0 * per_n0)
    per_n0, per_n1, per_r = per_all * per_n0, per_all * per_n1, per_all * per_r
    i0l, i0r, i1l, i1r = per_n0 * n0r, per_n0 * n0l, per_n1 * n1r, per_n1 * n1l
    fl, fr = (p0 * i0l - p1 * i1l) * per_r * rr, (p0 * i0r - p1 * i1r) * per_r * rl
    # (p₀ + n₀l)(p₁ + n₁r) / (p₁ + n₁l)(p₀ + n₀r), each factor written so that it does not cancel where p < 0.
    top = (p0 + n0l if p0 > 0.0 else n0r - p0) * (p1 + n1r if p1 > 0.0 else n1l - p1)
    low = (p1 + n1l if p1 > 0.0 else n1r - p1) * (p0 + n0r if p0 > 0.0 else n0l - p0)
    # Where p < 0, (p + n) = r / (n − p): r is left over unless both stations have it, or none.
    is_beside = p0 > 0.0 and p1 <= 0.0
    top *= rr if is_beside else 1.0
    low *= rl if is_beside else 1.0
    return (
        sign * (n0l - n0r),
        sign * (n1l - n1r),
        sign * (i0l - i0r),
        sign * (i1l - i1r),
        yl * i0l - yr * i0r,
        yl * i1l - yr * i1r,
        top if sign > 0.0 else low,
        low if sign > 0.0 else top,
        0.0,
        sign * (i0l - i0r + i1r - i1l),
        sign * (fr - fl),
        yr * fr - yl * fl,
    )


@kernel(fastmath=FAST, inline="always")
def _end_anywhere(sign, p0, p1, d2, q0, q1, e, w, least, per_radius2):
    """As `_end_outside`, inside the Rankine cores of the tip filaments or outside."""
    yl, yr = e + w, e - w
    yl2, yr2 = yl * yl, yr * yr
    rl, rr = yl2 + d2, yr2 + d2
    ml, mr = (rl if rl > least else least), (rr if rr > least else least)
    tiny = 1e-24 * least  # keeps 0/0 from being formed at a corner
    c0l, c0r, c1l, c1r = q0 + yl2 + tiny, q0 + yr2 + tiny, q1 + yl2 + tiny, q1 + yr2 + tiny
    n0l, n0r, n1l, n1r = math.sqrt(c0l), math.sqrt(c0r), math.sqrt(c1l), math.sqrt(c1r)
    v0l, v0r = math.sqrt(c0l + (ml - rl)), math.sqrt(c0r + (mr - rr))
    v1l, v1r = math.sqrt(c1l + (ml - rl)), math.sqrt(c1r + (mr - rr))
    n0, n1, v0, v1, m = n0l * n0r, n1l * n1r, v0l * v0r, v1l * v1r, ml * mr
    per_n, per_v = 1.0 / (n0 * n1), 1.0 / (v0 * v1 * m)
    per_n0, per_n1 = per_n * n1, per_n * n0
    per_v0, per_v1, per_m = per_v * (v1 * m), per_v * (v0 * m), per_v * (v0 * v1)
    i0l, i0r, i1l, i1r = per_n0 * n0r, per_n0 * n0l, per_n1 * n1r, per_n1 * n1l
    j0l, j0r, j1l, j1r = per_v0 * v0r, per_v0 * v0l, per_v1 * v1r, per_v1 * v1l
    fl, fr = (p0 * i0l - p1 * i1l) * per_m * mr, (p0 * i0r - p1 * i1r) * per_m * ml
    top = (p0 + v0l if p0 > 0.0 else v0r - p0) * (p1 + v1r if p1 > 0.0 else v1l - p1)
    low = (p1 + v1l if p1 > 0.0 else v1r - p1) * (p0 + v0r if p0 > 0.0 else v0l - p0)
    is_beside = p0 > 0.0 and p1 <= 0.0
    top *= mr if is_beside else 1.0
    low *= ml if is_beside else 1.0
    # What the core takes from the distances and adds to their reciprocals; nothing outside.
    l0, r0, l1, r1 = n0l - v0l, n0r - v0r, n1l - v1l, n1r - v1r
    beside = (p0 * (r0 - l0) - p1 * (r1 - l1)) * per_radius2
    along = (j0l - j0r + j1r - j1l) + per_radius2 * (
        (r0 - l0 - r1 + l1) + (p0 * p0 * ((i0r - j0r) - (i0l - j0l)) - p1 * p1 * ((i1r - j1r) - (i1l - j1l)))
    )
    return (
        sign * (n0l - n0r),
        sign * (n1l - n1r),
        sign * (i0l - i0r),
        sign * (i1l - i1r),
        yl * i0l - yr * i0r,
        yl * i1l - yr * i1r,
        top if sign > 0.0 else low,
        low if sign > 0.0 else top,
        sign * beside,
        sign * along,
        sign * (fr - fl),
        yr * fr - yl * fl,
    )


@kernel(fastmath=FAST, inline="always")
def _combine(strength, ax, az, x0, x1, z0, z1, g0, g1, g0q, g1q, d, right, left, beside):
    """Put together both ends of the wing: the ten numbers of `add_runs` but for the logarithm."""
    n0, n1, b0, b1 = right[0] + left[0], right[1] + left[1], right[2] + left[2], right[3] + left[3]
    along, across = right[9] + left[9], d * (right[10] + left[10])
    s0, s1 = g0 * n0, g1 * n1
    # Slopes of N / max(q, core²) are x or z times this.
    t0, t1 = g0 * b0 - 2.0 * g0q * n0, g1 * b1 - 2.0 * g1q * n1
    tx, tz = ax * along + az * across, az * along - ax * across
    return (
        strength * (z0 * s0 - z1 * s1 - az * beside),
        strength * (x1 * s1 - x0 * s0 + ax * beside),
        strength * (z0 * x0 * t0 - z1 * x1 * t1 - az * tx),
        strength * (s0 + z0 * z0 * t0 - s1 - z1 * z1 * t1 - az * tz),
        strength * (s1 + x1 * x1 * t1 - s0 - x0 * x0 * t0 + ax * tx),
        strength * (x1 * z1 * t1 - x0 * z0 * t0 + ax * tz),
        strength * (z0 * g0 * right[4] - z1 * g1 * right[5] - az * right[11]),
        strength * (z0 * g0 * left[4] - z1 * g1 * left[5] - az * left[11]),
        strength * (x1 * g1 * right[5] - x0 * g0 * right[4] + ax * right[11]),
        strength * (x1 * g1 * left[5] - x0 * g0 * left[4] + ax * left[11]),
    )


@kernel(fastmath=FAST, allocates=False)
def wind_of_runs(x, z, right, left, runs, core):
    """Integrate the wind of all runs along a wing, with its slopes.

    Parameters
    ----------
    x, z : float
        Station and height of the wing's line.
    right, left : float
        Its ends, by y.
    runs : (9, n) ndarray of float
        The wake; rows as named above.
    core : Core
        The filaments' core.

    Returns
    -------
    tuple of 10 float
        The integrals of v_x and v_z over y from `left` to `right`, for a unit of circulation over 4π; their slopes
        over x and z (v_x by x, v_x by z, v_z by x, v_z by z); v_x at the right and at the left end, v_z at both.
    """
    least, soft, per_radius2, edge = core.least, core.softening, core.per_radius2, ON_EDGE * core.least
    count = runs.shape[1]
    gx = gz = gx_x = gx_z = gz_x = gz_z = xr = xl = zr = zl = 0.0
    down_top = down_low = up_top = up_low = 1.0
    # No tip filament is nearer than it is aside; only where one may be within its core are all looked at.
    nearest = np.inf
    for i in (0, count - 1):
        for e in (right, left):
            aside = abs(e) - runs[HALF_WIDTH, i]
            nearest = min(nearest, aside * aside)
    if nearest + soft <= least:
        nearest = np.inf
        for i in range(count):
            d = runs[ALONG_Z, i] * (x - runs[FIRST_X, i]) - runs[ALONG_X, i] * (z - runs[FIRST_Z, i])
            a, b = abs(abs(right) - runs[HALF_WIDTH, i]), abs(abs(left) - runs[HALF_WIDTH, i])
            a = a if a < b else b
            r = d * d + a * a
            nearest = r if r < nearest else nearest
    if nearest + soft > least:
        for i in range(count):
            ax, az, w = runs[ALONG_X, i], runs[ALONG_Z, i], runs[HALF_WIDTH, i]
            x0, x1, z0, z1 = (
                x - runs[FIRST_X, i],
                x - runs[LAST_X, i],
                z - runs[FIRST_Z, i],
                z - runs[LAST_Z, i],
            )
            q0, q1 = x0 * x0 + z0 * z0 + soft, x1 * x1 + z1 * z1 + soft
            d, p0, p1 = az * x0 - ax * z0, ax * x0 + az * z0, ax * x1 + az * z1
            d2 = d * d + soft
            g0, g1 = 1.0 / (q0 if q0 > least else least), 1.0 / (q1 if q1 > least else least)
            g0q, g1q = (g0 * g0 if q0 > edge else 0.0), (g1 * g1 if q1 > edge else 0.0)
            on_right = _end_outside(1.0, p0, p1, d2, q0, q1, right, w)
            on_left = _end_outside(-1.0, p0, p1, d2, q0, q1, left, w)
            part = _combine(
                runs[STRENGTH, i], ax, az, x0, x1, z0, z1, g0, g1, g0q, g1q, d, on_right, on_left, 0.0
            )  # fmt: skip
            top, low = on_right[6] * on_left[6], on_right[7] * on_left[7]
            down = runs[IS_DOWNSTROKE, i] > 0.5
            down_top *= top if down else 1.0
            down_low *= low if down else 1.0
            up_top *= 1.0 if down else top
            up_low *= 1.0 if down else low
            gx += part[0]
            gz += part[1]
            gx_x += part[2]
            gx_z += part[3]
            gz_x += part[4]
            gz_z += part[5]
            xr += part[6]
            xl += part[7]
            zr += part[8]
            zl += part[9]
    else:
        for i in range(count):
            ax, az, w = runs[ALONG_X, i], runs[ALONG_Z, i], runs[HALF_WIDTH, i]
            x0, x1, z0, z1 = (
                x - runs[FIRST_X, i],
                x - runs[LAST_X, i],
                z - runs[FIRST_Z, i],
                z - runs[LAST_Z, i],
            )
            q0, q1 = x0 * x0 + z0 * z0 + soft, x1 * x1 + z1 * z1 + soft
            d, p0, p1 = az * x0 - ax * z0, ax * x0 + az * z0, ax * x1 + az * z1
            d2 = d * d + soft
            g0, g1 = 1.0 / (q0 if q0 > least else least), 1.0 / (q1 if q1 > least else least)
            g0q, g1q = (g0 * g0 if q0 > edge else 0.0), (g1 * g1 if q1 > edge else 0.0)
            on_right = _end_anywhere(1.0, p0, p1, d2, q0, q1, right, w, least, per_radius2)
            on_left = _end_anywhere(-1.0, p0, p1, d2, q0, q1, left, w, least, per_radius2)
            beside = on_right[8] + on_left[8]
            part = _combine(
                runs[STRENGTH, i], ax, az, x0, x1, z0, z1, g0, g1, g0q, g1q, d, on_right, on_left, beside
            )  # fmt: skip
            top, low = on_right[6] * on_left[6], on_right[7] * on_left[7]
            down = runs[IS_DOWNSTROKE, i] > 0.5
            down_top *= top if down else 1.0
            down_low *= low if down else 1.0
            up_top *= 1.0 if down else top
            up_low *= 1.0 if down else low
            gx += part[0]
            gz += part[1]
            gx_x += part[2]
            gx_z += part[3]
            gz_x += part[4]
            gz_z += part[5]
            xr += part[6]
            xl += part[7]
            zr += part[8]
            zl += part[9]
    # The runs of a kind lie alike and share one logarithm.
    last = count - 1
    down, up = (
        runs[STRENGTH, 0] * math.log(down_top / down_low),
        runs[STRENGTH, last] * math.log(up_top / up_low),
    )
    gx -= runs[ALONG_Z, 0] * down + runs[ALONG_Z, last] * up
    gz += runs[ALONG_X, 0] * down + runs[ALONG_X, last] * up
    return gx, gz, gx_x, gx_z, gz_x, gz_z, xr, xl, zr, zl
