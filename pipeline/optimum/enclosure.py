"""Bounds of the wake force over a box: centred affine forms with a radius.

A quantity over a box is enclosed by value + slopes·δ ± radius, δ the offset from the box's centre.  Every filament,
tip or spanwise, induces (u(p₀, r) − u(p₁, r)) ψ(r) times a linear factor, with

    u(p, r) = p / √(p² + r),        ψ(r) = 1 / max(r, r_c²),

p the distances along the filament from its ends (affine in the position) and r the squared distance from its axis
(quadratic).  u is expanded to first order with a closed bound of its second derivatives, |u_pp| ≤ 1.155/n²,
|u_pr| ≤ 1/n³ and |u_rr| ≤ 0.75/n⁴ with n² the least p² + r in the box; ψ is enclosed by its secant between the ends of
the range of r, which mixes the inner and the outer branch where the range holds a core edge.

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
def _enclose_psi(r, r_low, r_high, r_square, core2):
    """Enclose ψ over a range: value, slope by r, radius."""
    outer_low, outer_high = (r_low if r_low > core2 else core2), (r_high if r_high > core2 else core2)
    psi_low, psi_high = 1.0 / outer_low, 1.0 / outer_high
    share = (outer_high - outer_low) / (r_high - r_low) if r_low < core2 else 1.0
    slope = -psi_low * psi_high * share
    slope = 0.0 if r_high <= core2 else slope
    # ψ − slope r: alike at both ends of the range, highest at the core edge, lowest where 1/r touches the secant.
    ends = psi_low - slope * r_low
    highest = psi_low - slope * outer_low
    root = math.sqrt(-slope)
    touches = root * outer_low < 1.0 and root * r_high > 1.0
    lowest = 2.0 * root if touches else ends
    return (
        slope * (r + 0.5 * r_square) + 0.5 * (highest + lowest),
        slope,
        0.5 * (highest - lowest) - 0.5 * slope * r_square,
    )


@njit(cache=True, fastmath=FAST, error_model="numpy", inline="always")
def _enclose_filament(
    p0, p1, px, py, pz, p_width, r, rx, ry, rz, r_low, r_high, r_square, per_n0, per_n1, near0, near1, core2,
    wx, wy, wz,
):  # fmt: skip
    """Enclose (u(p₀, r) − u(p₁, r)) ψ(r): value, three slopes, radius, half-range."""
    r_spread = abs(rx) * wx + abs(ry) * wy + abs(rz) * wz
    u0, u0_p, u0_r, u0_radius = _enclose_u(p0, p_width, r, r_spread, r_square, per_n0, near0)
    u1, u1_p, u1_r, u1_radius = _enclose_u(p1, p_width, r, r_spread, r_square, per_n1, near1)
    u, by_p, by_r, u_radius = u0 - u1, u0_p - u1_p, u0_r - u1_r, u0_radius + u1_radius
    ux, uy, uz = by_p * px + by_r * rx, by_p * py + by_r * ry, by_p * pz + by_r * rz
    psi, slope, psi_radius = _enclose_psi(r, r_low, r_high, r_square, core2)
    u_range = abs(ux) * wx + abs(uy) * wy + abs(uz) * wz + u_radius
    psi_range = abs(slope) * r_spread + psi_radius
    fx, fy, fz = (
        u * slope * rx + psi * ux,
        u * slope * ry + psi * uy,
        u * slope * rz + psi * uz,
    )
    radius = abs(u) * psi_radius + abs(psi) * u_radius + u_range * psi_range
    return u * psi, fx, fy, fz, radius, abs(fx) * wx + abs(fy) * wy + abs(fz) * wz + radius


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
    f0, f0x, f0y, f0z, f0_radius, f0_range = _enclose_filament(
        yl, yr, 0.0, 1.0, 0.0, wy, q0, 2.0 * x0, 0.0, 2.0 * z0, q0_low, q0_high, span_square,
        i0l, i0r, m0l, m0r, core2, wx, wy, wz,
    )  # fmt: skip
    f1, f1x, f1y, f1z, f1_radius, f1_range = _enclose_filament(
        yl, yr, 0.0, 1.0, 0.0, wy, q1, 2.0 * x1, 0.0, 2.0 * z1, q1_low, q1_high, span_square,
        i1l, i1r, m1l, m1r, core2, wx, wy, wz,
    )  # fmt: skip
    d, p0, p1 = az * x0 - ax * z0, ax * x0 + az * z0, ax * x1 + az * z1
    wd, wp = abs(az) * wx + abs(ax) * wz, abs(ax) * wx + abs(az) * wz
    d_low, d_high = max(abs(d) - wd, 0.0), abs(d) + wd
    rx, rz, tip_square = 2.0 * d * az, -2.0 * d * ax, wd * wd + wy * wy
    fl, flx, fly, flz, fl_radius, fl_range = _enclose_filament(
        p0, p1, ax, 0.0, az, wp, d * d + yl2, rx, 2.0 * yl, rz,
        d_low * d_low + yl2_low, d_high * d_high + yl_high * yl_high, tip_square,
        i0l, i1l, m0l, m1l, core2, wx, wy, wz,
    )  # fmt: skip
    fr, frx, fry, frz, fr_radius, fr_range = _enclose_filament(
        p0, p1, ax, 0.0, az, wp, d * d + yr2, rx, 2.0 * yr, rz,
        d_low * d_low + yr2_low, d_high * d_high + yr_high * yr_high, tip_square,
        i0r, i1r, m0r, m1r, core2, wx, wy, wz,
    )  # fmt: skip
    tip = yr * fr - yl * fl
    tip_x, tip_z = yr * frx - yl * flx, yr * frz - yl * flz
    tip_y = yr * fry + fr - yl * fly - fl
    tip_radius = abs(yr) * fr_radius + abs(yl) * fl_radius + wy * (fr_range + fl_range)
    return (
        z0 * f0 - z1 * f1 - az * tip,
        z0 * f0x - z1 * f1x - az * tip_x,
        z0 * f0y - z1 * f1y - az * tip_y,
        z0 * f0z + f0 - z1 * f1z - f1 - az * tip_z,
        abs(z0) * f0_radius + abs(z1) * f1_radius + wz * (f0_range + f1_range) + abs(az) * tip_radius,
        x1 * f1 - x0 * f0 + ax * tip,
        x1 * f1x + f1 - x0 * f0x - f0 + ax * tip_x,
        x1 * f1y - x0 * f0y + ax * tip_y,
        x1 * f1z - x0 * f0z + ax * tip_z,
        abs(x0) * f0_radius + abs(x1) * f1_radius + wx * (f0_range + f1_range) + abs(ax) * tip_radius,
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
