"""Core edges: the surfaces on which the model is continuous but not smooth, and to which optima are often pinned.

A follower's span node lies on a core edge when its distance to a filament equals the core radius.  Several lanes may
share one edge (both wingtips are as far from a spanwise filament, and neighbouring rings share one); they are one
surface here.  An edge's distance is s = r²/r_c² − 1: negative in the core, zero on the edge.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled.edges import edge_distance
from upwash.optimum.compiled.pair_descent import FeltLanes
from upwash.optimum.variables import VARIABLE_COUNT

NO_WALLS = np.empty((0, 7))

FILAMENTS = ("starting", "stopping", "left tip", "right tip")
"""The filaments of a ring, in the order of the first axis of an `edges` array."""


def distinct_edges(
    lanes: NDArray[np.float64], bounds: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Find which filaments and lanes share a core edge.

    Two that are equally far at three points in general position share their edge.

    Parameters
    ----------
    lanes : (15, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    bounds : (6, 2) ndarray of float
        Bounds of the variables.

    Returns
    -------
    group : (4, l) ndarray of int
        Number of the edge of each filament and lane.
    representative : (e, 2) ndarray of int
        A lane and a filament of each edge.
    """
    fractions = np.random.default_rng(0).uniform(0.1, 0.9, size=(3, VARIABLE_COUNT))
    points = bounds[:, 0] + fractions * (bounds[:, 1] - bounds[:, 0])
    scratch = np.empty(VARIABLE_COUNT)
    known: dict[tuple[float, ...], int] = {}
    group = np.empty((4, lanes.shape[1]), dtype=np.int64)
    representative: list[tuple[int, int]] = []
    for lane in range(lanes.shape[1]):
        for filament in range(4):
            distances = (edge_distance(point, lanes, lane, filament, scratch) for point in points)
            key = tuple(round(distance, 9) for distance in distances)
            if key not in known:
                known[key] = len(representative)
                representative.append((lane, filament))
            group[filament, lane] = known[key]
    return group, np.array(representative, dtype=np.int64)


def felt_lanes(
    lanes: NDArray[np.float64], bounds: NDArray[np.float64], walls: NDArray[np.float64] = NO_WALLS
) -> FeltLanes:
    """Return a wake with its core edges, and walls, as the local solve takes it; parameters as for `distinct_edges`."""
    return FeltLanes(lanes, *distinct_edges(lanes, bounds), walls)


def edge_distances(
    felt: FeltLanes, point: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how far a point is from each core edge, negative inside, and the slopes of that.

    Parameters
    ----------
    felt : FeltLanes
        The wake.
    point : (6,) ndarray of float
        The point.

    Returns
    -------
    tuple of (e,) and (e, 6) ndarray of float
        Distances s = r²/r_c² − 1, and their gradients.
    """
    count = len(felt.representative)
    distances, normals = np.empty(count), np.empty((count, VARIABLE_COUNT))
    for number, (lane, filament) in enumerate(felt.representative):
        distances[number] = edge_distance(point, felt.lanes, lane, filament, normals[number])
    return distances, normals
