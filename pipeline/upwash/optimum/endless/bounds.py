"""What the bounds of an endless wake's force need to know of it: stations, the far ends, rounding."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled import endless as force
from upwash.aero.compiled import exact_span as span
from upwash.aero.compiled.endless import EndlessWake
from upwash.optimum.compiled import endless_enclosure as bounds
from upwash.optimum.compiled.endless_enclosure import EndlessEnclosure

ROUNDING = 1e-13
"""What rounding may add to the force, as a share of the sum of all its parts."""


REACH = 2
"""Runs and stations within so many wavelengths of a window's middle are near: eight, as many as fill a register."""

FURTHEST = 0.75
"""How far from the middle of its window a step of the follower may be, in wavelengths."""


def endless_enclosure(wake: EndlessWake) -> EndlessEnclosure:
    """Lay out what encloses the force of an endless wake.

    Parameters
    ----------
    wake : EndlessWake
        The wake.
    """
    stations = np.array([_stations(runs) for runs in wake.runs])
    middle, near = REACH * wake.wavelength, stations[0, bounds.STATION_X]
    is_near = (near > -middle - 1e-9) & (near < middle - 1e-9)
    first_x = wake.runs[0, span.FIRST_X]
    is_near_run = (first_x > -middle - 1e-9) & (first_x < middle - 1e-9)
    weight = float(np.sum(np.abs(wake.steps[force.WEIGHT])))
    strength = float(np.max(np.abs(wake.runs[:, span.STRENGTH])))
    far = max(
        _far_run_curvature(wake.runs[window], middle, wake.wavelength)
        + _far_station_curvature(stations[window][:, ~is_near], wake.wavelength)
        + _tail_curvature(wake.tails[window], wake.wavelength)
        for window in range(2)
    )
    # Each run's terms are of the size of the logarithm of a ratio of lengths, or of a width over the core.
    size = weight * strength * wake.runs.shape[2] * 20.0
    return EndlessEnclosure(
        wake._replace(
            runs=np.ascontiguousarray(wake.runs[:, :, is_near_run]),
            tails=np.ascontiguousarray(wake.tails[:, :, :0]),
        ),
        wake._replace(runs=np.ascontiguousarray(wake.runs[:, :, ~is_near_run])),
        np.ascontiguousarray(stations[:, :, is_near]),
        2.0 * weight * far,
        ROUNDING * size,
    )


def _far_run_curvature(runs: NDArray[np.float64], middle: float, wavelength: float) -> float:
    """Bound half of the second derivatives of what the tip filaments of far runs contribute at a wing's end."""
    first, last = runs[span.FIRST_X], runs[span.LAST_X]
    is_far = (first < -middle - 1e-9) | (first > middle - 1e-9)
    nearest = np.maximum(first, -last)[is_far] - FURTHEST * wavelength
    length = (last - first)[is_far] / runs[span.ALONG_X][is_far]
    return float(0.5 * np.sum(runs[span.STRENGTH][is_far] * 2.0 * 3.0 * length / nearest**3))


def _far_station_curvature(stations: NDArray[np.float64], wavelength: float) -> float:
    """Bound half of the second derivatives of what the spanwise filaments at far stations contribute."""
    nearest = np.abs(stations[bounds.STATION_X]) - FURTHEST * wavelength
    return float(0.5 * np.sum(stations[bounds.SIZE] * (3.0 + 2.0 + bounds.COSINE_CURVATURE) / nearest**3))


def edge_stations(wake: EndlessWake) -> NDArray[np.float64]:
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


def _stations(runs: NDArray[np.float64]) -> NDArray[np.float64]:
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


def _tail_curvature(tails: NDArray[np.float64], wavelength: float) -> float:
    """Bound half of the second derivatives of the antiderivative of what is beyond a window, at one end of the wing.

    Its parts are the potential of half-infinite lines of charge, which at a distance D have second derivatives of at
    most 1/D², that of a segment of 2 w, and derivatives of it: the k-th is at most 2 w k! 1.2/D^k.
    """
    total = 0.0
    for tail in tails.T:
        nearest = tail[force.START] - FURTHEST * wavelength
        width = 2.0 * tail[force.TAIL_HALF_WIDTH]
        further = np.sum(np.abs(tail[[force.CURVED, force.STRETCHED, force.SPREAD]]))
        curvature = 1.0 / nearest**2
        curvature += (0.5 + abs(tail[force.SOURCE])) * 5.2 * width / nearest**3
        curvature += further * 145.0 * width / nearest**5
        total += tail[force.TAIL_STRENGTH] * curvature
    return 0.5 * float(total)
