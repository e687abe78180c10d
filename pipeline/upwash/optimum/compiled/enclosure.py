"""Bounds of the wake force over a box: centred affine forms with a radius.

A quantity over a box is enclosed by value + slopes·δ ± radius, δ the offset from the box's centre.  Every filament,
tip or spanwise, induces a strength times one or two components of a plane vortex,

    (u₀ − u₁) · a / max(a² + c², r_c²),

u the cosine between the filament and the line from one of its ends, a and c the distances across it, all affine in the
position but the cosines.

- u = p/n, with p along the filament and n the distance from its end, is expanded to first order; its second derivative
  along any unit vector is at most 2/√3 / n² (the largest eigenvalue of its Hessian, over all angles).  Where a box
  holds or nearly holds the end that says nothing, and −1 ≤ u ≤ 1 is the bound.
- Outside the core the plane vortex is the real or imaginary part of 1/ζ, whose remainder of first order is
  δ²/(ζ²(ζ + δ)); inside it is linear.  Across an edge it is the lesser of the two in magnitude, so a convex mix of both
  errs to one side only, and the mix with the least radius is taken.

The forms hold for the two stroke states of the paper: with tips up the force depends on (x, y, z_up, R), with tips down
on (x, y, z_down).

What rounding may add is part of them: boxes are taken wider by `ROUNDING` of the coordinates, which covers where points
and filaments lie, and radii by `ROUNDING` of the largest force that the lanes can exert, which covers what is computed
from there.
"""

from __future__ import annotations

import math

from upwash.aero.compiled.lanes import (
    ALONG_X,
    ALONG_Z,
    CENTRE_Y,
    CORE2,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    LAST_X,
    LAST_Z,
    NODE,
    SLIDING,
    STEADY,
)
from upwash.aero.compiled.rings import END_FLOOR, FAST
from upwash.kernel import kernel
from upwash.optimum.variables import VARIABLE_COUNT

ROUNDING = 64.0 * 2.0**-52
"""Share of a quantity that rounding may take from it: no sum or product here is of more than sixty-four roundings."""

DEEP = 1e-2
"""Share of the squared core radius: a box that holds a point nearer to a filament is bounded by the inner branch."""

HALF_CURVATURE = 1.0 / math.sqrt(3.0)
"""Half of the greatest second derivative of a cosine, times the squared distance."""

# Places in a form.
VALUE, BY_X, BY_Y, BY_Z, BY_RATIO, RADIUS = range(VARIABLE_COUNT)


@kernel(fastmath=FAST, allocates=False)
def _enclose_strength(
    p0, x0, y0, z0, per_n0, near0, p1, x1, y1, z1, per_n1, near1, ax, ay, az, wx, wy, wz, square
):  # fmt: skip
    """Enclose the difference of the cosines at both ends: value, three slopes, radius, half-range.

    For each end: projection on the filament's direction (ax, ay, az), position from the end, reciprocal distance at the
    centre and greatest in the box.  `square` is the squared half-diagonal of the box.
    """
    u0, u1 = p0 * per_n0, p1 * per_n1
    c0, c1 = u0 * per_n0 * per_n0, u1 * per_n1 * per_n1
    change = per_n0 - per_n1
    ux, uy, uz = (
        ax * change - c0 * x0 + c1 * x1,
        ay * change - c0 * y0 + c1 * y1,
        az * change - c0 * z0 + c1 * z1,
    )
    radius = HALF_CURVATURE * square * (near0 * near0 + near1 * near1)
    spread = abs(ux) * wx + abs(uy) * wy + abs(uz) * wz + radius
    # Each cosine lies between −1 and 1; near an end that says more.
    wide = spread > 2.0
    return (
        0.0 if wide else u0 - u1,
        0.0 if wide else ux,
        0.0 if wide else uy,
        0.0 if wide else uz,
        2.0 if wide else radius,
        2.0 if wide else spread,
    )


@kernel(fastmath=FAST, allocates=False)
def _enclose_vortex(a, c, wa, wc, r, r_low, r_high, core2):
    """Enclose a / max(a² + c², core2): value, slopes by a and c, radius."""
    per_core = 1.0 / core2
    # Deep in the core the outer branch is steep and says nothing.
    is_deep = r_low < DEEP * core2
    per_r, per_low = 1.0 / (core2 if is_deep else r), 1.0 / (core2 if is_deep else r_low)
    outer_radius = (wa * wa + wc * wc) * per_r * math.sqrt(per_low)
    a_high = abs(a) + wa
    # By how much the outer branch exceeds the inner within the core, and the inner the outer without.
    within, without = a_high * (per_low - per_core), a_high * (per_core - 1.0 / r_high)
    within, without = (within if within > 0.0 else 0.0), (without if without > 0.0 else 0.0)
    gap_share = 0.5 if abs(a) >= wa else 1.0
    balanced = without / (within + without + 1e-300)
    mixed_radius = balanced * outer_radius + gap_share * balanced * within
    inner_only, outer_only = gap_share * without, outer_radius + gap_share * within
    mixed_is_better = mixed_radius < inner_only and not is_deep
    mix = balanced if mixed_is_better else 0.0
    radius = mixed_radius if mixed_is_better else inner_only
    outer_is_best = outer_only < radius and not is_deep
    mix = 1.0 if outer_is_best else mix
    radius = outer_only if outer_is_best else radius
    one_sided = mix * within if mix * within > (1.0 - mix) * without else (1.0 - mix) * without
    shift = 0.5 * one_sided if gap_share < 1.0 else 0.0
    shift = shift if a > 0.0 else -shift
    inner, outer = (1.0 - mix) * per_core, mix * per_r
    return (
        (inner + outer) * a - shift,
        inner + outer * (c * c - a * a) * per_r,
        -2.0 * outer * a * c * per_r,
        radius,
    )


@kernel(fastmath=FAST, allocates=False)
def _multiply(u, ux, uy, uz, u_radius, u_range, k, kx, ky, kz, k_radius, wx, wy, wz):
    """Multiply two forms: value, three slopes, radius."""
    k_range = abs(kx) * wx + abs(ky) * wy + abs(kz) * wz + k_radius
    radius = abs(u) * k_radius + abs(k) * u_radius + u_range * k_range
    return u * k, u * kx + k * ux, u * ky + k * uy, u * kz + k * uz, radius


@kernel(fastmath=FAST, inline="always")
def enclose_ring(
    x, y, z, wx, wy, wz, first_x, last_x, first_z, last_z, half_width, ax, az, core2
):  # fmt: skip
    """Enclose v_x and v_z of a tilted rectangle of unit circulation over 4π, for points in a box.

    Parameters
    ----------
    x, y, z : float
        Centre of the box, y relative to the ring's centreline.
    wx, wy, wz : float
        Half-widths of the box.
    first_x, last_x, first_z, last_z, half_width, ax, az, core2 : float
        The ring, as for `upwash.aero.compiled.rings.ring_velocity_gradient`.

    Returns
    -------
    tuple of 10 float
        For v_x and then v_z: value, slopes by x, y and z, radius.
    """
    x0, x1, z0, z1 = x - first_x, x - last_x, z - first_z, z - last_z
    yl, yr = y + half_width, y - half_width
    floor = END_FLOOR * core2
    # Ranges of the coordinates: least and greatest magnitude.
    x0_low, x1_low = max(abs(x0) - wx, 0.0), max(abs(x1) - wx, 0.0)
    z0_low, z1_low = max(abs(z0) - wz, 0.0), max(abs(z1) - wz, 0.0)
    yl_low, yr_low = max(abs(yl) - wy, 0.0), max(abs(yr) - wy, 0.0)
    x0_high, x1_high = abs(x0) + wx, abs(x1) + wx
    z0_high, z1_high = abs(z0) + wz, abs(z1) + wz
    yl_high, yr_high = abs(yl) + wy, abs(yr) + wy
    q0, q1 = x0 * x0 + z0 * z0, x1 * x1 + z1 * z1
    q0_low, q1_low = x0_low * x0_low + z0_low * z0_low, x1_low * x1_low + z1_low * z1_low
    q0_high, q1_high = x0_high * x0_high + z0_high * z0_high, x1_high * x1_high + z1_high * z1_high
    yl2, yr2, yl2_low, yr2_low = yl * yl, yr * yr, yl_low * yl_low, yr_low * yr_low
    i0l, i0r = 1.0 / math.sqrt(q0 + yl2 + floor), 1.0 / math.sqrt(q0 + yr2 + floor)
    i1l, i1r = 1.0 / math.sqrt(q1 + yl2 + floor), 1.0 / math.sqrt(q1 + yr2 + floor)
    m0l, m0r = 1.0 / math.sqrt(q0_low + yl2_low + floor), 1.0 / math.sqrt(q0_low + yr2_low + floor)
    m1l, m1r = 1.0 / math.sqrt(q1_low + yl2_low + floor), 1.0 / math.sqrt(q1_low + yr2_low + floor)
    square = wx * wx + wy * wy + wz * wz
    # Spanwise filaments: v_x goes with z, v_z with −x, of the vortex in the vertical plane.
    s0, s0x, s0y, s0z, s0_radius, s0_range = _enclose_strength(
        yl, x0, yl, z0, i0l, m0l, yr, x0, yr, z0, i0r, m0r, 0.0, 1.0, 0.0, wx, wy, wz, square
    )
    s1, s1x, s1y, s1z, s1_radius, s1_range = _enclose_strength(
        yl, x1, yl, z1, i1l, m1l, yr, x1, yr, z1, i1r, m1r, 0.0, 1.0, 0.0, wx, wy, wz, square
    )
    k, ka, kc, kr = _enclose_vortex(z0, x0, wz, wx, q0, q0_low, q0_high, core2)
    a0, a0x, a0y, a0z, a0r = _multiply(s0, s0x, s0y, s0z, s0_radius, s0_range, k, kc, 0.0, ka, kr, wx, wy, wz)
    k, ka, kc, kr = _enclose_vortex(x0, z0, wx, wz, q0, q0_low, q0_high, core2)
    b0, b0x, b0y, b0z, b0r = _multiply(s0, s0x, s0y, s0z, s0_radius, s0_range, k, ka, 0.0, kc, kr, wx, wy, wz)
    k, ka, kc, kr = _enclose_vortex(z1, x1, wz, wx, q1, q1_low, q1_high, core2)
    a1, a1x, a1y, a1z, a1r = _multiply(s1, s1x, s1y, s1z, s1_radius, s1_range, k, kc, 0.0, ka, kr, wx, wy, wz)
    k, ka, kc, kr = _enclose_vortex(x1, z1, wx, wz, q1, q1_low, q1_high, core2)
    b1, b1x, b1y, b1z, b1r = _multiply(s1, s1x, s1y, s1z, s1_radius, s1_range, k, ka, 0.0, kc, kr, wx, wy, wz)
    # Tip filaments: both components go with the spanwise distance.
    d, p0, p1 = az * x0 - ax * z0, ax * x0 + az * z0, ax * x1 + az * z1
    wd = abs(az) * wx + abs(ax) * wz + ROUNDING * (abs(az * x0) + abs(ax * z0))
    d_low, d_high = max(abs(d) - wd, 0.0), abs(d) + wd
    rl, rr = d * d + yl2, d * d + yr2
    sl, slx, sly, slz, sl_radius, sl_range = _enclose_strength(
        p0, x0, yl, z0, i0l, m0l, p1, x1, yl, z1, i1l, m1l, ax, 0.0, az, wx, wy, wz, square
    )
    sr, srx, sry, srz, sr_radius, sr_range = _enclose_strength(
        p0, x0, yr, z0, i0r, m0r, p1, x1, yr, z1, i1r, m1r, ax, 0.0, az, wx, wy, wz, square
    )
    k, ka, kc, kr = _enclose_vortex(
        yl, d, wy, wd, rl, d_low * d_low + yl2_low, d_high * d_high + yl_high * yl_high, core2
    )
    tl, tlx, tly, tlz, tlr = _multiply(
        sl, slx, sly, slz, sl_radius, sl_range, k, kc * az, ka, -kc * ax, kr, wx, wy, wz
    )
    k, ka, kc, kr = _enclose_vortex(
        yr, d, wy, wd, rr, d_low * d_low + yr2_low, d_high * d_high + yr_high * yr_high, core2
    )
    tr, trx, try_, trz, trr = _multiply(
        sr, srx, sry, srz, sr_radius, sr_range, k, kc * az, ka, -kc * ax, kr, wx, wy, wz
    )
    tip, tip_x, tip_y, tip_z, tip_radius = tr - tl, trx - tlx, try_ - tly, trz - tlz, tlr + trr
    return (
        a0 - a1 - az * tip,
        a0x - a1x - az * tip_x,
        a0y - a1y - az * tip_y,
        a0z - a1z - az * tip_z,
        a0r + a1r + abs(az) * tip_radius,
        b1 - b0 + ax * tip,
        b1x - b0x + ax * tip_x,
        b1y - b0y + ax * tip_y,
        b1z - b0z + ax * tip_z,
        b0r + b1r + abs(ax) * tip_radius,
    )


@kernel(fastmath=FAST, allocates=False)
def enclose_wake_force(x, y, z, ratio, wx, wy, wz, w_ratio, lanes, first, last, flexes, phase_end, forms):
    """Enclose the wake force of one follower state over a box, at both ends of the phase coordinate.

    Parameters
    ----------
    x, y, z, ratio : float
        Centre of the box: position of the follower's reference point, z that of its wingtips; upstroke span ratio.
    wx, wy, wz, w_ratio : float
        Half-widths of the box.
    lanes : (15, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    first, last : int
        The lanes of this follower state.
    flexes : bool
        Whether the half-span is R (tips up) or 1 (tips down).
    phase_end : float
        Greatest phase coordinate; the least is 0.
    forms : (2, 2, 6) ndarray of float
        Overwritten, by phase end and by lift and thrust: value, slopes by x, y, z and R, radius.
    """
    forms[:] = 0.0
    first_x, last_x, first_z, last_z = lanes[FIRST_X], lanes[LAST_X], lanes[FIRST_Z], lanes[LAST_Z]
    centre_y, half_width, node = lanes[CENTRE_Y], lanes[HALF_WIDTH], lanes[NODE]
    along_x, along_z, core2 = lanes[ALONG_X], lanes[ALONG_Z], lanes[CORE2]
    steady, sliding = lanes[STEADY], lanes[SLIDING]
    span, w_span = (ratio, w_ratio) if flexes else (1.0, 0.0)
    wx, wy, wz = wx + ROUNDING * abs(x), wy + ROUNDING * (abs(y) + 1.0), wz + ROUNDING * abs(z)
    strength = 0.0
    l0 = l0x = l0y = l0z = l0s = l0r = l1 = l1x = l1y = l1z = l1s = l1r = 0.0
    t0 = t0x = t0y = t0z = t0s = t0r = t1 = t1x = t1y = t1z = t1s = t1r = 0.0
    for i in range(first, last):
        vx, vx_x, vx_y, vx_z, vx_radius, vz, vz_x, vz_y, vz_z, vz_radius = enclose_ring(
            x,
            y + node[i] * span - centre_y[i],
            z,
            wx,
            wy + abs(node[i]) * w_span,
            wz,
            first_x[i],
            last_x[i],
            first_z[i],
            last_z[i],
            half_width[i],
            along_x[i],
            along_z[i],
            core2[i],
        )
        a, b = steady[i], steady[i] + sliding[i] * phase_end
        strength += (abs(steady[i]) + abs(sliding[i]) * phase_end) / math.sqrt(core2[i])
        l0 += a * vx
        l0x += a * vx_x
        l0y += a * vx_y
        l0z += a * vx_z
        l0s += a * node[i] * vx_y
        l0r += abs(a) * vx_radius
        l1 += b * vx
        l1x += b * vx_x
        l1y += b * vx_y
        l1z += b * vx_z
        l1s += b * node[i] * vx_y
        l1r += abs(b) * vx_radius
        t0 += a * vz
        t0x += a * vz_x
        t0y += a * vz_y
        t0z += a * vz_z
        t0s += a * node[i] * vz_y
        t0r += abs(a) * vz_radius
        t1 += b * vz
        t1x += b * vz_x
        t1y += b * vz_y
        t1z += b * vz_z
        t1s += b * node[i] * vz_y
        t1r += abs(b) * vz_radius
    # Four filaments, each of at most twice the greatest velocity of its core.
    rounding = ROUNDING * (1.0 + (last - first) / 64.0) * strength * 8.0
    _store_form(forms[0, 0], l0, l0x, l0y, l0z, l0s, l0r, span, wx, wy, wz, w_span, rounding)
    _store_form(forms[1, 0], l1, l1x, l1y, l1z, l1s, l1r, span, wx, wy, wz, w_span, rounding)
    _store_form(forms[0, 1], t0, t0x, t0y, t0z, t0s, t0r, span, wx, wy, wz, w_span, rounding)
    _store_form(forms[1, 1], t1, t1x, t1y, t1z, t1s, t1r, span, wx, wy, wz, w_span, rounding)


@kernel(fastmath=FAST, allocates=False)
def _store_form(form, value, by_x, by_y, by_z, by_span, radius, span, wx, wy, wz, w_span, rounding):
    """Multiply the mean wind's form by the half-span and store it."""
    reach = abs(by_x) * wx + abs(by_y) * wy + abs(by_z) * wz + abs(by_span) * w_span + radius
    form[VALUE] = span * value
    form[BY_X] = span * by_x
    form[BY_Y] = span * by_y
    form[BY_Z] = span * by_z
    form[BY_RATIO] = span * by_span + value if w_span > 0.0 else 0.0
    form[RADIUS] = (1.0 + ROUNDING) * (span * radius + w_span * reach) + rounding
