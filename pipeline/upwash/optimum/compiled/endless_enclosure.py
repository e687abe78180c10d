"""Bounds of an endless wake's force over a box: its value and slopes at the centre, and how far it may leave them.

The force is a weighted sum over the follower's steps of an antiderivative G at the wing's two ends, with one derivative
that is Lipschitz everywhere but at the core edges of the spanwise filaments.  So over a box

    |G(c + δ) − G(c) − ∇G(c)·δ| ≤ ½ M |δ|²,     and also ≤ 2 L |δ|,

with M the greatest second derivative and L the greatest slope of G in the box.  Both are sums over the filaments, each
bounded by its least distance from the box, and the lesser of the two is taken filament by filament:

- A tip filament contributes the potential of a line of charge.  Across it, at a distance ρ, its second derivatives are
  at most 1.0887/ρ² for each end, inside the core 1/r_c²; along it at most 1/u², with u the distance from the end, and
  inside the core 2/max(u², r_c²); and of each piece dl of it, at a distance u, all of them are at most 2 dl/u³ outside
  and 3 dl/u³ inside the core.
- The spanwise filaments of two runs that meet at a station cancel but for the strips where one of them is wider.  They
  contribute k N, with k = ζ̄/max(|ζ|², r_c²) the plane vortex about the station and N a difference of distances to the
  corners; |k| ≤ m^−½, |k′| ≤ 1/m, |k″| ≤ 2 m^−3/2 with m = max(|ζ|², r_c²), and N, N′, N″ are bounded by the strips'
  width and by the corners' least distance.  Where the box crosses the core's edge the slope of k jumps by 2/r_c².
- Filaments more than two wavelengths from the middle of the window, and what is beyond it, lie so far away that one
  bound serves every box.

The force's value, slopes, images and tails are those of the force itself, from the same kernel.  What is far bends so
little that its form over a box serves the smaller boxes within as well.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import (
    HEIGHT,
    SPAN_FLEXED,
    WEIGHT,
    EndlessWake,
    endless_force_jacobian,
)
from upwash.aero.compiled.exact_span import (
    ALONG_X,
    ALONG_Z,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    LAST_X,
    ON_EDGE,
    STRENGTH,
)
from upwash.aero.compiled.rings import FAST
from upwash.kernel import kernel


class EndlessEnclosure(NamedTuple):
    """What the bounds of an endless wake's force take from it, beside the wake.

    Attributes
    ----------
    near : EndlessWake
        Its near runs alone, without what is beyond the window; its weights are not negative.
    far : EndlessWake
        All else of it.
    stations : (2, 8, n) ndarray of float
        The near stations, of the window of the follower's downstroke and of its upstroke.
    far_curvature : float
        Half of the greatest second derivative of the force of all that is not near.
    rounding : float
        What rounding may add to the force.
    """

    near: EndlessWake
    far: EndlessWake
    stations: NDArray[np.float64]
    far_curvature: float
    rounding: float


ACROSS = 1.0887
"""Greatest second derivative across a line of charge, for one of its ends, times the squared distance: t (2 − t²)."""

COSINE_CURVATURE = 2.0 / math.sqrt(3.0)
"""Greatest second derivative of a cosine, times the squared distance."""

# Rows of an array of stations; each column is one, where two runs meet or the window ends.
STATION_X, STATION_Z = 0, 1
WIDE, NARROW = 2, 3  # half-widths of the wider run and of the other, 0 where there is none
STRONG, WEAK = 4, 5  # their circulations
SIZE = 6  # width of the strips that do not cancel, times their circulation
INNER = 7  # distance of the strips from the middle

# What an enclosure holds of lift and of thrust.
VALUE, BY_X, BY_Y, BY_UP, BY_DOWN, BY_RATIO, RADIUS = range(7)


@kernel(fastmath=FAST, inline="always")
def _filament_radius(y, we, d_low, gap, to_first, to_last, length, wp, across, core2, soft):
    """Bound what one tip filament of unit circulation adds to the remainder."""
    y_low = abs(y) - we
    y_low = y_low if y_low > 0.0 else 0.0
    r_low = y_low * y_low + d_low * d_low + soft
    is_out = r_low > core2
    m = r_low if is_out else core2
    first, last = to_first * to_first + r_low, to_last * to_last + r_low
    first, last = (first if first > core2 else core2), (last if last > core2 else core2)
    beyond = gap * gap + r_low
    along, charge = (1.0 if is_out else 2.0), (2.0 if is_out else 3.0)
    per_u2 = 1.0 / first + 1.0 / last
    near = 2.0 * ACROSS * across * across / m + per_u2 * wp * (2.0 * across + along * wp)
    far = charge * length / (math.sqrt(beyond) * beyond) * (wp * wp + across * across)
    bent = 0.5 * (near if near < far else far)
    steep = 4.0 * across / math.sqrt(m) + 2.0 * along * wp * math.sqrt(2.0 * per_u2)
    return bent if bent < steep else steep


@kernel(fastmath=FAST)
def tip_radius(x, z, right, left, wx, wz, we, runs, core2, soft):
    """Bound what the tip filaments of all runs add to the remainder at both ends of the wing together.

    Parameters
    ----------
    x, z, right, left : float
        Centre of the box: station and height of the wing, and y of its ends.
    wx, wz, we : float
        Half-widths of the box.
    runs : (9, n) ndarray of float
        See `upwash.aero.compiled.exact_span`.
    core2, soft : float
        `Core.least` and `Core.softening`.

    Returns
    -------
    tuple of 2 float
        For v_x and for v_z.
    """
    by_x = by_z = 0.0
    for i in range(runs.shape[1]):
        ax, az, w = runs[ALONG_X, i], abs(runs[ALONG_Z, i]), runs[HALF_WIDTH, i]
        x0, z0 = x - runs[FIRST_X, i], z - runs[FIRST_Z, i]
        length = (runs[LAST_X, i] - runs[FIRST_X, i]) / ax
        d, p0 = runs[ALONG_Z, i] * x0 - ax * z0, ax * x0 + runs[ALONG_Z, i] * z0
        p1 = p0 - length
        wd, wp = az * wx + ax * wz, ax * wx + az * wz
        d_low, gap = abs(d) - wd, (p1 if p1 > -p0 else -p0) - wp
        d_low, gap = (d_low if d_low > 0.0 else 0.0), (gap if gap > 0.0 else 0.0)
        to_first, to_last = abs(p0) - wp, abs(p1) - wp
        to_first, to_last = (to_first if to_first > 0.0 else 0.0), (to_last if to_last > 0.0 else 0.0)
        across = math.sqrt(wd * wd + we * we)
        a = _filament_radius(right + w, we, d_low, gap, to_first, to_last, length, wp, across, core2, soft)
        b = _filament_radius(right - w, we, d_low, gap, to_first, to_last, length, wp, across, core2, soft)
        c = _filament_radius(left + w, we, d_low, gap, to_first, to_last, length, wp, across, core2, soft)
        d = _filament_radius(left - w, we, d_low, gap, to_first, to_last, length, wp, across, core2, soft)
        total = runs[STRENGTH, i] * (a + b + c + d)
        by_x += az * total
        by_z += ax * total
    return by_x, by_z


@kernel(fastmath=FAST, inline="always")
def _strip_slopes(y, we, q_low, off, wide, narrow, inner, strong, weak, size):
    """Bound the first and the second derivatives of what lies along the span, at one end of the wing."""
    y_wide, y_narrow = abs(y - wide) - we, abs(y - narrow) - we
    y_wide, y_narrow = (y_wide if y_wide > 0.0 else 0.0), (y_narrow if y_narrow > 0.0 else 0.0)
    y_strip = (y - wide if y - wide > inner - y else inner - y) - we
    y_strip = y_strip if y_strip > 0.0 else 0.0
    n2 = q_low + y_strip * y_strip
    slope, by_strip = 2.0 * (strong + weak), size / math.sqrt(n2)
    slope = by_strip if by_strip < slope else slope
    # The slope of a cosine is the sine over the distance, and the sine is small far aside.
    by_strip = size * off / n2
    slope = by_strip if by_strip < slope else slope
    curve = 2.0 * strong / math.sqrt(q_low + y_wide * y_wide)
    curve += 2.0 * weak / math.sqrt(q_low + y_narrow * y_narrow)
    by_strip = COSINE_CURVATURE * size / n2
    return slope, (by_strip if by_strip < curve else curve)


@kernel(fastmath=FAST)
def station_radius(x, z, right, left, wx, wz, we, stations, core2, soft):
    """Bound what the spanwise filaments at all stations add to the remainder at both ends of the wing together.

    Parameters
    ----------
    x, z, right, left, wx, wz, we, core2, soft
        As for `tip_radius`.
    stations : (8, n) ndarray of float
        Rows as named above.

    Returns
    -------
    float
        For v_x and for v_z alike.
    """
    total = 0.0
    aside2 = wx * wx + wz * wz
    whole2 = aside2 + we * we
    aside, whole = math.sqrt(aside2), math.sqrt(whole2)
    edge, bend, rim = math.sqrt(core2), (3.0 if soft > 0.0 else 2.0), ON_EDGE - 1.0
    length, inside = right - left + 2.0 * we, left - we
    right, left = abs(right), abs(left)
    for i in range(stations.shape[1]):
        x0, z0 = abs(x - stations[STATION_X, i]), abs(z - stations[STATION_Z, i])
        x_low, z_low = x0 - wx, z0 - wz
        x_low, z_low = (x_low if x_low > 0.0 else 0.0), (z_low if z_low > 0.0 else 0.0)
        q_low = x_low * x_low + z_low * z_low + soft
        q_high = (x0 + wx) * (x0 + wx) + (z0 + wz) * (z0 + wz)
        m = q_low if q_low > core2 else core2
        wide, narrow, inner = stations[WIDE, i], stations[NARROW, i], stations[INNER, i]
        strong, weak, size = stations[STRONG, i], stations[WEAK, i], stations[SIZE, i]
        per_m = 1.0 / m
        root = math.sqrt(per_m)
        off2 = q_high + soft
        off = math.sqrt(off2)
        # Both ends of a wing that is beyond the strips see them almost alike: N is twice the integral of q/n³ there.
        one, gap = size, inside - wide
        if gap > 0.0:
            n2 = q_low + gap * gap
            apart = 0.5 * length * size * off2 / (n2 * math.sqrt(n2))
            one = apart if apart < size else size
        straight = 0.0 if q_high < core2 else 0.5 * bend * per_m * root * one * aside2
        # Where the box crosses the core's edge the slope jumps there; on the edge it is that from inside.
        beyond = aside - abs(math.sqrt(x0 * x0 + z0 * z0) - edge) + rim * edge
        crosses = q_low < core2 * (1.0 + 2.0 * rim) and q_high > core2 and beyond > 0.0
        straight += 2.0 * per_m * one * beyond if crosses else 0.0
        steep = 2.0 * per_m * one * aside
        # Where a corner may lie in the box the curve is infinite, or infinity times nought; the other bound holds.
        slope, curve = _strip_slopes(right, we, q_low, off, wide, narrow, inner, strong, weak, size)
        bent_right = straight + per_m * slope * aside * whole + 0.5 * root * curve * whole2
        steep_right = steep + 2.0 * root * slope * whole
        slope, curve = _strip_slopes(left, we, q_low, off, wide, narrow, inner, strong, weak, size)
        bent_left = straight + per_m * slope * aside * whole + 0.5 * root * curve * whole2
        steep_left = steep + 2.0 * root * slope * whole
        if gap > 0.0:
            bent, sharp = bent_right + bent_left, steep_right + steep_left
            total += bent if bent < sharp else sharp
        else:
            total += bent_right if bent_right < steep_right else steep_right
            total += bent_left if bent_left < steep_left else steep_left
    return total


@kernel
def enclose_near_force(point, widths, enclosure, places, jacobian, forms):
    """Enclose the force of the near runs over a box.

    Parameters
    ----------
    point : (5,) ndarray of float
        Centre of the box, in spatial phase, y, z, amplitude and upstroke span ratio.
    widths : (5,) ndarray of float
        Half-widths of the box in X = λΦ, y, the heights of the raised and of the lowered tip, and the span ratio.
    enclosure : EndlessEnclosure
        The wake.
    places, jacobian : ndarray of float
        Scratch, see `upwash.aero.compiled.endless.endless_force_jacobian`.
    forms : (2, 7) ndarray of float
        Overwritten, for lift and for thrust: value, slopes by the five variables of the box, radius.
    """
    wake, stations_of = enclosure.near, enclosure.stations
    steps, count, downs = wake.steps, wake.steps.shape[1], wake.downstroke_steps
    core2, soft = wake.core.least, wake.core.softening
    _centre_form(point, wake, places, jacobian, forms)
    wx, wy, w_up, w_down, w_ratio = widths[0], widths[1], widths[2], widths[3], widths[4]
    lift_radius = thrust_radius = 0.0
    for window in range(2):
        begin, end = (0, downs) if window == 0 else (downs, count)
        runs, stations = wake.runs[window], stations_of[window]
        for k in range(begin, end):
            raised, weight = 0.5 + steps[HEIGHT, k], steps[WEIGHT, k]
            wz, we = raised * w_up + (1.0 - raised) * w_down, wy + steps[SPAN_FLEXED, k] * w_ratio
            x, z, right, left = places[0, k], places[1, k], places[2, k], places[3, k]
            tip_x, tip_z = tip_radius(x, z, right, left, wx, wz, we, runs, core2, soft)
            spanwise = station_radius(x, z, right, left, wx, wz, we, stations, core2, soft)
            lift_radius += weight * (tip_x + spanwise)
            thrust_radius += weight * (tip_z + spanwise)
    forms[0, RADIUS] = lift_radius + enclosure.rounding
    forms[1, RADIUS] = thrust_radius + enclosure.rounding


@kernel
def enclose_far_force(point, widths, enclosure, places, jacobian, forms):
    """Enclose the force of all but the near runs over a box; as `enclose_near_force`."""
    _centre_form(point, enclosure.far, places, jacobian, forms)
    w_z = widths[2] if widths[2] > widths[3] else widths[3]
    w_y = widths[1] + widths[4]
    radius = enclosure.far_curvature * (widths[0] * widths[0] + w_z * w_z + w_y * w_y)
    forms[0, RADIUS] = forms[1, RADIUS] = radius + enclosure.rounding


@kernel
def _centre_form(point, wake, places, jacobian, forms):
    """Fill in value and slopes at the centre of a box."""
    lift, thrust = endless_force_jacobian(point, wake, places, jacobian)
    forms[0, VALUE], forms[1, VALUE] = lift, thrust
    for c in range(2):
        form = forms[c]
        form[BY_X], form[BY_Y] = jacobian[c, 0] / wake.wavelength, jacobian[c, 1]
        form[BY_UP] = 0.5 * jacobian[c, 2] + jacobian[c, 3]
        form[BY_DOWN] = 0.5 * jacobian[c, 2] - jacobian[c, 3]
        form[BY_RATIO] = jacobian[c, 4]
