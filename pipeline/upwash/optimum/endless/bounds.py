"""What the bounds of an endless wake's force need to know of it: stations, the far ends, rounding."""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled import endless as force
from upwash.aero.compiled import exact_span as span
from upwash.aero.compiled.endless import EndlessWake
from upwash.optimum.compiled.endless_enclosure import EndlessEnclosure

ROUNDING = 1e-13
"""What rounding may add to the force, as a share of the sum of all its parts."""


def endless_enclosure(wake: EndlessWake) -> EndlessEnclosure:
    """Lay out what encloses the force of an endless wake.

    Parameters
    ----------
    wake : EndlessWake
        The wake.
    """
    stations = np.array([_stations(runs) for runs in wake.runs])
    weight = float(np.sum(np.abs(wake.steps[force.WEIGHT])))
    strength = float(np.max(np.abs(wake.runs[:, span.STRENGTH])))
    far = max(_tail_curvature(tails, wake.wavelength) for tails in wake.tails)
    # Each run's terms are of the size of the logarithm of a ratio of lengths, or of a width over the core.
    size = weight * strength * wake.runs.shape[2] * 20.0
    return EndlessEnclosure(wake, stations, 2.0 * weight * far, ROUNDING * size)


def edge_stations(wake: EndlessWake) -> np.ndarray:
    """Return the stations of both windows with the runs that begin and end there; none of a core without an edge.

    Returns
    -------
    (2, 6, m) ndarray of float
        Rows as in `upwash.optimum.compiled.endless_edges`.
    """
    if wake.core.least == 0.0:
        return np.empty((2, 6, 0))
    windows = []
    for runs in wake.runs:
        at: dict[float, list[float]] = {}
        for first_x, last_x, first_z, last_z, half_width, _, _, strength, _ in runs.T:
            at.setdefault(round(first_x, 9), [first_x, first_z, 0.0, 0.0, 0.0, 0.0])[2:4] = (
                half_width,
                strength,
            )
            at.setdefault(round(last_x, 9), [last_x, last_z, 0.0, 0.0, 0.0, 0.0])[4:6] = half_width, strength
        windows.append(np.array([at[x] for x in sorted(at)]).T)
    return np.array(windows)


def _stations(runs: np.ndarray) -> np.ndarray:
    """Return where runs begin and end, and what of their spanwise filaments is left there."""
    ends: dict[float, list[tuple[float, float, float]]] = {}
    for first_x, last_x, first_z, last_z, half_width, _, _, strength, _ in runs.T:
        for x, z in ((first_x, first_z), (last_x, last_z)):
            ends.setdefault(round(x, 9), []).append((half_width, strength, z))
    columns = []
    for x, meeting in sorted(ends.items()):
        meeting = sorted([*meeting, *([(0.0, 0.0, meeting[0][2])] if len(meeting) == 1 else [])])
        (narrow, weak, z), (wide, strong, _) = meeting
        # The shared circulation leaves two strips, the rest a whole filament.
        size = 2.0 * min(weak, strong) * (wide - narrow) + 2.0 * abs(strong - weak) * (
            wide if strong > weak else narrow
        )
        columns.append([x, z, wide, narrow, strong, weak, size, narrow if weak == strong else 0.0])
    return np.array(columns).T


def _tail_curvature(tails: np.ndarray, wavelength: float) -> float:
    """Bound half of the second derivatives of the antiderivative of what is beyond a window, at one end of the wing.

    Its parts are the potential of half-infinite lines of charge, which at a distance D have second derivatives of at
    most 1/D², that of a segment of 2 w, and derivatives of it: the k-th is at most 2 w k! 1.2/D^k.
    """
    total = 0.0
    for tail in tails.T:
        nearest = tail[force.START] - 0.75 * wavelength
        width = 2.0 * tail[force.TAIL_HALF_WIDTH]
        further = np.sum(np.abs(tail[[force.CURVED, force.STRETCHED, force.SPREAD]]))
        curvature = 1.0 / nearest**2
        curvature += (0.5 + abs(tail[force.SOURCE])) * 5.2 * width / nearest**3
        curvature += further * 145.0 * width / nearest**5
        total += tail[force.TAIL_STRENGTH] * curvature
    return 0.5 * float(total)
