"""Bounds of the force of a wake that ends, felt on the whole span, over a box; and branch and bound with them.

As behind an endless wake (`endless_enclosure`) the force over a box is its value and slopes at the centre and a
radius, filament by filament.  Boxes are in X = x − D t, the place in the frame of the runs, so that the phase changes
the cuts alone.  A cut that slides by s along its tip filaments adds ∫₀ˢ f dl to their antiderivative, f being what a
unit of length contributes there.  The slope of f is at most M = 1/u², with u the distance from the cut (inside the
core 2/max(u², r_c²)), so that over a displacement q of the wing and s of the cut

    |∫₀ˢ f dl − s f(0)| ≤ M (s |q| + ½ s²).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.cut_wake import (
    AT_LEADER,
    HEIGHT,
    NO_CUT,
    SLIDING,
    SPAN_FIXED,
    SPAN_FLEXED,
    STEADY,
    CutWake,
    slide_cuts,
    wind_of_cut,
)
from upwash.aero.compiled.exact_span import (
    ALONG_X,
    ALONG_Z,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    LAST_X,
    LAST_Z,
    STRENGTH,
    wind_of_runs,
)
from upwash.kernel import kernel
from upwash.optimum.compiled.clearing import clearing
from upwash.optimum.compiled.enclosure import BY_RATIO, BY_X, BY_Y, BY_Z, RADIUS, ROUNDING, VALUE
from upwash.optimum.compiled.endless_enclosure import station_radius, tip_radius
from upwash.optimum.compiled.relaxation import MARGIN
from upwash.optimum.compiled.walls import cut_by_walls


class CutEnclosure(NamedTuple):
    """What the bounds of the force take from a wake that ends, beside the wake.

    Attributes
    ----------
    wake : CutWake
        The wake.
    carried : (p, 8, m) ndarray of float
        Of each part of the wingbeat the stations that stand still in the frame of the runs, see `endless_enclosure`.
    cut : (p, 8, 2) ndarray of float
        Its stations that slide along their runs.
    rounding : float
        What rounding may add to the force.
    least_x, greatest_x : float
        Range of x = X + D t.
    walls : (w, 7) ndarray of float
        Limits of the place, see `upwash.optimum.compiled.walls`.
    """

    wake: CutWake
    carried: NDArray[np.float64]
    cut: NDArray[np.float64]
    rounding: float
    least_x: float
    greatest_x: float
    walls: NDArray[np.float64]


@kernel(allocates=False)
def cut_radius(x, z, right, left, wx, wz, we, slide, runs, run, which, core):
    """Bound what the sliding of a cut adds to the remainder, at both ends of the wing together.

    Parameters
    ----------
    x, z, right, left : float
        Centre of the box: station and height of the wing, and y of its ends.
    wx, wz, we : float
        Half-widths of the box, in the frame of the runs.
    slide : float
        By how much the cut slides to either side, along x.
    runs, run, which, core
        As for `upwash.aero.compiled.cut_wake.wind_of_cut`.

    Returns
    -------
    tuple of 2 float
        For v_x and for v_z.
    """
    ax, az, w = runs[ALONG_X, run], runs[ALONG_Z, run], runs[HALF_WIDTH, run]
    at_x, at_z = (
        (runs[FIRST_X, run], runs[FIRST_Z, run])
        if which == AT_LEADER
        else (runs[LAST_X, run], runs[LAST_Z, run])
    )
    p, d = ax * (x - at_x) + az * (z - at_z), az * (x - at_x) - ax * (z - at_z)
    wp, wd, along = ax * wx + abs(az) * wz, abs(az) * wx + ax * wz, slide / ax
    d_low, gap = max(abs(d) - wd, 0.0), max(abs(p) - wp - along, 0.0)
    moved, total = math.sqrt(wp * wp + wd * wd + we * we), 0.0
    for corner in range(4):
        y = (right if corner < 2 else left) + (w if corner % 2 == 0 else -w)
        y_low = max(abs(y) - we, 0.0)
        r_low = y_low * y_low + d_low * d_low + core.softening
        u2 = max(gap * gap + r_low, core.least)
        total += (1.0 if r_low > core.least else 2.0) / u2
    total *= runs[STRENGTH, run] * along * (moved + 0.5 * along)
    return abs(az) * total, ax * total


@kernel
def _make_room(felt):
    return felt.wake.runs.copy()


@kernel(allocates=False)
def enclose_cut_force(low, high, widths, felt, phase_end, room, forms, by_phase, reach):
    """Enclose the force of a wake that ends over a box, at both ends of the phase coordinate.

    Parameters
    ----------
    low, high : (6,) ndarray of float
        The box, in (X, y, z_up, z_down, R, t).
    widths : (6,) ndarray of float
        Its half-widths, rounded up.
    felt : CutEnclosure
        The wake.
    phase_end : float
        Greatest phase coordinate; the least is 0.
    room : (p, 9, r) ndarray of float
        A copy of the wake's runs.
    forms : (2, 2, 2, 6) ndarray of float
        Overwritten: the whole force, whose slope by the height of the lowered tip alone is in the second.
    by_phase : (2,) ndarray of float
        Overwritten: slopes of lift and thrust by the phase coordinate, but for that of the weights.
    reach : (6,) ndarray of float
        Overwritten: how far each variable reaches into the radii.
    """
    wake, core = felt.wake, felt.wake.core
    parts, drift, core2, soft = wake.parts, wake.drift, wake.core.least, wake.core.softening
    t, y = 0.5 * (low[5] + high[5]), 0.5 * (low[1] + high[1])
    x = 0.5 * (low[0] + high[0])
    up, down, ratio = 0.5 * (low[2] + high[2]), 0.5 * (low[3] + high[3]), 0.5 * (low[4] + high[4])
    slide = drift * widths[5]
    wx, slid, whole = widths[0], 0.0, 0.0
    forms[:] = 0.0
    by_phase[0] = by_phase[1] = 0.0
    for i in range(5):
        reach[i] = 1.0
    for part in range(parts.shape[1]):
        raised, flexed = 0.5 + parts[HEIGHT, part], parts[SPAN_FLEXED, part]
        z = raised * up + (1.0 - raised) * down
        wz = raised * widths[2] + (1.0 - raised) * widths[3] + ROUNDING * (abs(up) + abs(down))
        span = parts[SPAN_FIXED, part] + flexed * ratio
        we = widths[1] + flexed * widths[4] + ROUNDING * (abs(y) + 1.0)
        right, left, runs = y + span, y - span, room[part]
        slides_x = slides_z = slid_x = slid_z = turned = 0.0
        if drift != 0.0:
            slide_cuts(wake, part, t, runs)
            for which in range(2):
                run = wake.cuts[part, which]
                if run != NO_CUT:
                    by_x, by_z = wind_of_cut(x, z, right, left, runs, run, which, core)
                    slides_x += by_x
                    slides_z += by_z
                    by_x, by_z = cut_radius(x, z, right, left, wx, wz, we, slide, runs, run, which, core)
                    slid_x += by_x
                    slid_z += by_z
                    turned = slide * abs(runs[ALONG_Z, run]) / runs[ALONG_X, run]
        gx, gz, gx_x, gx_z, gz_x, gz_z, xr, xl, zr, zl = wind_of_runs(x, z, right, left, runs, core)
        tip_x, tip_z = tip_radius(x, z, right, left, wx, wz, we, runs, core2, soft)
        spanwise = station_radius(x, z, right, left, wx, wz, we, felt.carried[part], core2, soft)
        if drift != 0.0:
            # Beside the box's ranges the cuts move, along x and up and down.
            stations = felt.cut[part]
            for which in range(2):
                run = wake.cuts[part, which]
                if run != NO_CUT:
                    stations[0, which] = runs[FIRST_X if which == AT_LEADER else LAST_X, run]
                    stations[1, which] = runs[FIRST_Z if which == AT_LEADER else LAST_Z, run]
            of_cuts = station_radius(x, z, right, left, wx + slide, wz + turned, we, stations, core2, soft)
            spanwise += of_cuts
            slid += parts[STEADY, part] * (of_cuts + slid_z)
        radius_x, radius_z = tip_x + spanwise + slid_x, tip_z + spanwise + slid_z
        whole += parts[STEADY, part] * radius_z
        for end in range(2):
            weight = parts[STEADY, part] + (parts[SLIDING, part] * phase_end if end == 1 else 0.0)
            size = abs(weight)
            lift, thrust = forms[0, end, 0], forms[0, end, 1]
            lift[VALUE] += weight * gx
            lift[BY_X] += weight * gx_x
            lift[BY_Y] += weight * (xr - xl)
            lift[BY_Z] += weight * raised * gx_z
            lift[BY_RATIO] += weight * flexed * (xr + xl)
            lift[RADIUS] += size * radius_x
            thrust[VALUE] += weight * gz
            thrust[BY_X] += weight * gz_x
            thrust[BY_Y] += weight * (zr - zl)
            thrust[BY_Z] += weight * raised * gz_z
            thrust[BY_RATIO] += weight * flexed * (zr + zl)
            thrust[RADIUS] += size * radius_z
            forms[1, end, 0, BY_Z] += weight * (1.0 - raised) * gx_z
            forms[1, end, 1, BY_Z] += weight * (1.0 - raised) * gz_z
        by_phase[0] -= parts[STEADY, part] * drift * slides_x
        by_phase[1] -= parts[STEADY, part] * drift * slides_z
    # The phase widens the radii by its share in the cuts' alone.
    reach[5] = drift * slid / whole if slid > 0.0 else 0.0
    for end in range(2):
        for c in range(2):
            forms[0, end, c, RADIUS] += felt.rounding


@kernel(allocates=False)
def _stay_within(low, high, felt):
    """Shrink X and t to where x = X + D t is in its range and keeps the walls; return whether anything is left."""
    drift = felt.wake.drift
    if drift == 0.0:
        return cut_by_walls(low, high, felt.walls)
    first, last = low[0], high[0]
    low[0], high[0] = first + drift * low[5], last + drift * high[5]
    if not cut_by_walls(low, high, felt.walls):
        return False
    low[0], high[0] = max(first, low[0] - drift * high[5]), min(last, high[0] - drift * low[5])
    low[0] = max(low[0], felt.least_x - drift * high[5] - MARGIN)
    high[0] = min(high[0], felt.greatest_x - drift * low[5] + MARGIN)
    low[5] = max(low[5], (felt.least_x - high[0] - MARGIN) / drift)
    high[5] = min(high[5], (felt.greatest_x - low[0] + MARGIN) / drift)
    return low[0] <= high[0] and low[5] <= high[5]


@kernel(allocates=False)
def _place(centre, felt):
    """Turn X of a box's centre into x."""
    centre[0] += felt.wake.drift * centre[5]


examine_cut, clear_cut_boxes = clearing(
    _make_room, enclose_cut_force, _stay_within, _place, radius_weight=30.0, worth_repeating=0.5
)
