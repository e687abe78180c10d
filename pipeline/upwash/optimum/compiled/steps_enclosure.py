"""Bounds of the wake force over a box where the stroke has more than two states.

The tips of a state in between are as high as a mix of the raised and the lowered tip, and its half-span is a mix of the
two: the form of each state, in (x, y, z, half-span), becomes one in the variables of the box.
"""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled.lanes import HEIGHT, SPAN_FIXED, SPAN_FLEXED
from upwash.kernel import kernel
from upwash.optimum.compiled.enclosure import (
    BY_RATIO,
    BY_X,
    BY_Y,
    BY_Z,
    RADIUS,
    ROUNDING,
    VALUE,
    enclose_wake_force,
)

FLEXES = np.bool_(True)
"""Every step has a span of its own.  A plain True would have what it is passed to compiled once more, for a literal."""


@kernel(allocates=False)
def enclose_steps(low, high, widths, lanes, first_lanes, phase_end, forms):
    """Enclose the wake force of all of the follower's states over a box, at both ends of the phase coordinate.

    Parameters
    ----------
    low, high : (6,) ndarray of float
        The box, in (x, y, z_up, z_down, R, t).
    widths : (6,) ndarray of float
        Its half-widths, rounded up.
    lanes : (15, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    first_lanes : (N + 1,) ndarray of int
        Where the lanes of each state begin, and where the last end.
    phase_end : float
        Greatest phase coordinate; the least is 0.
    forms : (3, 2, 2, 6) ndarray of float
        Overwritten: the sum of all states, whose slope by the height of the lowered tip alone is in the second; the
        third is scratch.
    """
    forms[:] = 0.0
    up, down = 0.5 * (low[2] + high[2]), 0.5 * (low[3] + high[3])
    ratio, own = 0.5 * (low[4] + high[4]), forms[2]
    for state in range(first_lanes.size - 1):
        first, last = first_lanes[state], first_lanes[state + 1]
        if first == last:
            continue
        raised, flexed = 0.5 + lanes[HEIGHT, first], lanes[SPAN_FLEXED, first]
        enclose_wake_force(
            0.5 * (low[0] + high[0]),
            0.5 * (low[1] + high[1]),
            raised * up + (1.0 - raised) * down,
            lanes[SPAN_FIXED, first] + flexed * ratio,
            widths[0],
            widths[1],
            raised * widths[2] + (1.0 - raised) * widths[3] + ROUNDING * (abs(up) + abs(down)),
            flexed * widths[4],
            lanes,
            first,
            last,
            FLEXES,
            phase_end,
            own,
        )
        for end in range(2):
            for c in range(2):
                total, part = forms[0, end, c], own[end, c]
                total[VALUE] += part[VALUE]
                total[BY_X] += part[BY_X]
                total[BY_Y] += part[BY_Y]
                total[BY_Z] += raised * part[BY_Z]
                total[BY_RATIO] += flexed * part[BY_RATIO]
                total[RADIUS] += part[RADIUS]
                forms[1, end, c, BY_Z] += (1.0 - raised) * part[BY_Z]
