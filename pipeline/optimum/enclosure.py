"""Bounds of the wake force over a box: centred affine forms with a radius.

A quantity over a box is enclosed by value + slopes·δ ± radius, δ the offset from the box's centre.  Every filament,
tip or spanwise, induces a strength times one or two components of a plane vortex,

    (u(p₀, r) − u(p₁, r)) · a / max(r, r_c²),        u(p, r) = p / √(p² + r),        r = a² + c²,

p the distances along the filament from its ends, a and c those across it, all affine in the position.

- u is expanded to first order, with a closed bound of its second derivatives: |u_pp| ≤ 1.155/n², |u_pr| ≤ 1/n³ and
  |u_rr| ≤ 0.75/n⁴, n² the least p² + r in the box.
- Outside the core the plane vortex is the real or imaginary part of 1/ζ, whose remainder of first order is
  δ²/(ζ²(ζ + δ)); inside it is linear.  Across an edge it is the lesser of the two in magnitude, so a convex mix of both
  errs to one side only, and the mix with the least radius is taken.

The forms hold for the two stroke states of the paper: with tips up the force depends on (x, y, z_up, R), with tips down
on (x, y, z_down).
"""

from __future__ import annotations

import math

from numba import njit

from pipeline.aero.induction import FAST
from pipeline.aero.lanes import (
    ALONG_X,
    ALONG_Z,
    CENTRE_Y,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    LAST_X,
    LAST_Z,
    NODE,
    SLIDING,
    STEADY,
)

# Least squared distance to a filament's end that enters a bound, over the squared core radius; nearer than this the
# bound |u| ≤ 1 is the better one anyway.
NEAREST = 1e-6

# Places in a form.
VALUE, BY_X, BY_Y, BY_Z, BY_RATIO, RADIUS = range(6)


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
def _enclose_u(p, p_width, r, r_spread, r_square, per_n, per_nearest):
    """Enclose u over a box: value, slopes by p and by r, radius.

    `r_spread` is the half-range of r's linear part and `r_square` the size of its quadratic part, which is one-sided.
    """
    per_n3 = per_n * per_n * per_n
    by_p, by_r = r * per_n3, -0.5 * p * per_n3
    deviation = r_spread + r_square
    square = per_nearest * per_nearest
    radius = (
        0.5775 * square * p_width * p_width
        + square * per_nearest * p_width * deviation
        + 0.375 * square * square * deviation * deviation
        + 0.5 * abs(by_r) * r_square
    )
    wide = abs(by_p) * p_width + abs(by_r) * r_spread + radius > 1.0
    return (
        0.0 if wide else p * per_n + 0.5 * by_r * r_square,
        0.0 if wide else by_p,
        0.0 if wide else by_r,
        1.0 if wide else radius,
    )


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
def _enclose_vortex(a, c, wa, wc, r, r_low, r_high, core2):
    """Enclose a / max(a² + c², core2): value, slopes by a and c, radius."""
    least = NEAREST * core2
    per_r = 1.0 / (r if r > least else least)
    per_low = 1.0 / (r_low if r_low > least else least)
    per_core = 1.0 / core2
    outer_radius = (wa * wa + wc * wc) * per_r * math.sqrt(per_low)
    a_high = abs(a) + wa
    # By how much the outer branch exceeds the inner within the core, and the inner the outer without.
    within, without = a_high * (per_low - per_core), a_high * (per_core - 1.0 / r_high)
    within, without = (within if within > 0.0 else 0.0), (without if without > 0.0 else 0.0)
    gap_share = 0.5 if abs(a) >= wa else 1.0
    balanced = without / (within + without + 1e-300)
    mixed_radius = balanced * (outer_radius + gap_share * within)
    inner_only, outer_only = gap_share * without, outer_radius + gap_share * within
    mix = balanced if mixed_radius < inner_only else 0.0
    radius = mixed_radius if mixed_radius < inner_only else inner_only
    mix = 1.0 if outer_only < radius else mix
    radius = outer_only if outer_only < radius else radius
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


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
def _enclose_strength(
    p0, p1, px, py, pz, p_width, r, rx, ry, rz, r_square, per_n0, per_n1, near0, near1, wx, wy, wz
):  # fmt: skip
    """Enclose u(p₀, r) − u(p₁, r): value, three slopes, radius, half-range."""
    r_spread = abs(rx) * wx + abs(ry) * wy + abs(rz) * wz
    u0, u0_p, u0_r, u0_radius = _enclose_u(p0, p_width, r, r_spread, r_square, per_n0, near0)
    u1, u1_p, u1_r, u1_radius = _enclose_u(p1, p_width, r, r_spread, r_square, per_n1, near1)
    by_p, by_r, radius = u0_p - u1_p, u0_r - u1_r, u0_radius + u1_radius
    ux, uy, uz = by_p * px + by_r * rx, by_p * py + by_r * ry, by_p * pz + by_r * rz
    return u0 - u1, ux, uy, uz, radius, abs(ux) * wx + abs(uy) * wy + abs(uz) * wz + radius


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
def _multiply(u, ux, uy, uz, u_radius, u_range, k, kx, ky, kz, k_radius, wx, wy, wz):
    """Multiply two forms: value, three slopes, radius."""
    k_range = abs(kx) * wx + abs(ky) * wy + abs(kz) * wz + k_radius
    radius = abs(u) * k_radius + abs(k) * u_radius + u_range * k_range
    return u * k, u * kx + k * ux, u * ky + k * uy, u * kz + k * uz, radius


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
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
        The ring, as for `pipeline.aero.induction.ring_velocity_gradient`.

    Returns
    -------
    tuple of 10 float
        For v_x and then v_z: value, slopes by x, y and z, radius.
    """
    x0, x1, z0, z1 = x - first_x, x - last_x, z - first_z, z - last_z
    yl, yr = y + half_width, y - half_width
    nearest2 = NEAREST * core2
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
    i0l, i0r = 1.0 / math.sqrt(q0 + yl2 + nearest2), 1.0 / math.sqrt(q0 + yr2 + nearest2)
    i1l, i1r = 1.0 / math.sqrt(q1 + yl2 + nearest2), 1.0 / math.sqrt(q1 + yr2 + nearest2)
    m0l, m0r = 1.0 / math.sqrt(q0_low + yl2_low + nearest2), 1.0 / math.sqrt(q0_low + yr2_low + nearest2)
    m1l, m1r = 1.0 / math.sqrt(q1_low + yl2_low + nearest2), 1.0 / math.sqrt(q1_low + yr2_low + nearest2)
    span_square = wx * wx + wz * wz
    # Spanwise filaments: v_x goes with z, v_z with −x, of the vortex in the vertical plane.
    s0, s0x, s0y, s0z, s0_radius, s0_range = _enclose_strength(
        yl, yr, 0.0, 1.0, 0.0, wy, q0, 2.0 * x0, 0.0, 2.0 * z0, span_square, i0l, i0r, m0l, m0r, wx, wy, wz
    )  # fmt: skip
    s1, s1x, s1y, s1z, s1_radius, s1_range = _enclose_strength(
        yl, yr, 0.0, 1.0, 0.0, wy, q1, 2.0 * x1, 0.0, 2.0 * z1, span_square, i1l, i1r, m1l, m1r, wx, wy, wz
    )  # fmt: skip
    k, ka, kc, kr = _enclose_vortex(z0, x0, wz, wx, q0, q0_low, q0_high, core2)
    a0, a0x, a0y, a0z, a0r = _multiply(
        s0, s0x, s0y, s0z, s0_radius, s0_range, k, kc, 0.0, ka, kr, wx, wy, wz
    )
    k, ka, kc, kr = _enclose_vortex(x0, z0, wx, wz, q0, q0_low, q0_high, core2)
    b0, b0x, b0y, b0z, b0r = _multiply(
        s0, s0x, s0y, s0z, s0_radius, s0_range, k, ka, 0.0, kc, kr, wx, wy, wz
    )
    k, ka, kc, kr = _enclose_vortex(z1, x1, wz, wx, q1, q1_low, q1_high, core2)
    a1, a1x, a1y, a1z, a1r = _multiply(
        s1, s1x, s1y, s1z, s1_radius, s1_range, k, kc, 0.0, ka, kr, wx, wy, wz
    )
    k, ka, kc, kr = _enclose_vortex(x1, z1, wx, wz, q1, q1_low, q1_high, core2)
    b1, b1x, b1y, b1z, b1r = _multiply(
        s1, s1x, s1y, s1z, s1_radius, s1_range, k, ka, 0.0, kc, kr, wx, wy, wz
    )
    # Tip filaments: both components go with the spanwise distance.
    d, p0, p1 = az * x0 - ax * z0, ax * x0 + az * z0, ax * x1 + az * z1
    wd, wp = abs(az) * wx + abs(ax) * wz, abs(ax) * wx + abs(az) * wz
    d_low, d_high = max(abs(d) - wd, 0.0), abs(d) + wd
    rl, rr, rx, rz, tip_square = d * d + yl2, d * d + yr2, 2.0 * d * az, -2.0 * d * ax, wd * wd + wy * wy
    sl, slx, sly, slz, sl_radius, sl_range = _enclose_strength(
        p0, p1, ax, 0.0, az, wp, rl, rx, 2.0 * yl, rz, tip_square, i0l, i1l, m0l, m1l, wx, wy, wz
    )  # fmt: skip
    sr, srx, sry, srz, sr_radius, sr_range = _enclose_strength(
        p0, p1, ax, 0.0, az, wp, rr, rx, 2.0 * yr, rz, tip_square, i0r, i1r, m0r, m1r, wx, wy, wz
    )  # fmt: skip
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


@njit(cache=True, fastmath=FAST, nogil=True, error_model="numpy")
def enclose_wake_force(x, y, z, ratio, wx, wy, wz, w_ratio, lanes, first, last, flexes, phase_end, core2, forms):
    """Enclose the wake force of one follower state over a box, at both ends of the phase coordinate.

    Parameters
    ----------
    x, y, z, ratio : float
        Centre of the box: position of the follower's reference point, z that of its wingtips; upstroke span ratio.
    wx, wy, wz, w_ratio : float
        Half-widths of the box.
    lanes : (14, l) ndarray of float
        See `pipeline.aero.lanes.wake_lanes`.
    first, last : int
        The lanes of this follower state.
    flexes : bool
        Whether the half-span is R (tips up) or 1 (tips down).
    phase_end : float
        Greatest phase coordinate; the least is 0.
    core2 : float
        Square of the core radius.
    forms : (2, 2, 6) ndarray of float
        Overwritten, by phase end and by lift and thrust: value, slopes by x, y, z and R, radius.
    """
    for end in range(2):
        for c in range(2):
            for k in range(6):
                forms[end, c, k] = 0.0
    first_x, last_x, first_z, last_z = lanes[FIRST_X], lanes[LAST_X], lanes[FIRST_Z], lanes[LAST_Z]
    centre_y, half_width, node = lanes[CENTRE_Y], lanes[HALF_WIDTH], lanes[NODE]
    along_x, along_z, steady, sliding = lanes[ALONG_X], lanes[ALONG_Z], lanes[STEADY], lanes[SLIDING]
    span, w_span = (ratio, w_ratio) if flexes else (1.0, 0.0)
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
            core2,
        )
        a, b = steady[i], steady[i] + sliding[i] * phase_end
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
    _store_form(forms[0, 0], l0, l0x, l0y, l0z, l0s, l0r, span, wx, wy, wz, w_span)
    _store_form(forms[1, 0], l1, l1x, l1y, l1z, l1s, l1r, span, wx, wy, wz, w_span)
    _store_form(forms[0, 1], t0, t0x, t0y, t0z, t0s, t0r, span, wx, wy, wz, w_span)
    _store_form(forms[1, 1], t1, t1x, t1y, t1z, t1s, t1r, span, wx, wy, wz, w_span)


@njit(cache=True, fastmath=FAST, error_model="numpy")
def _store_form(form, value, by_x, by_y, by_z, by_span, radius, span, wx, wy, wz, w_span):
    """Multiply the mean wind's form by the half-span and store it."""
    reach = abs(by_x) * wx + abs(by_y) * wy + abs(by_z) * wz + abs(by_span) * w_span + radius
    form[VALUE] = span * value
    form[BY_X] = span * by_x
    form[BY_Y] = span * by_y
    form[BY_Z] = span * by_z
    form[BY_RATIO] = span * by_span + value if w_span > 0.0 else 0.0
    form[RADIUS] = span * radius + w_span * reach
