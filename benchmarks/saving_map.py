"""The least cost at each place of a plane, over height, phase and stroke: what `upwash map` asks for."""

from __future__ import annotations

import numpy as np
from upwash.aero.wake import WakeModel
from upwash.place.balance import Behind
from upwash.place.held import HeldPlaces
from upwash.place.least import least_over

from benchmarks.contest import Contender, Contest
from benchmarks.wake_force import IBIS

SIZE, SIZE_OF_PEERS = 40, 3
HEIGHTS, PHASES = 41, 33
"""Of a grid that stands for brute force."""


def plane(size):
    """Return places from above, in m."""
    places = np.zeros((size, size, 4))
    places[..., 0], places[..., 1] = np.linspace(0.2, 5.6, size), np.linspace(0.0, 1.8, size)[:, None]
    return places


def mapped(behind, size, free=("z", "phase")):
    """Return the least cost at each place."""
    return least_over(behind, plane(size), free).cost


def by_grid(behind, size):
    """Return the least cost at each place over a grid, all strokes that balance being found at each of its points."""
    held, half = HeldPlaces(behind, ()), 0.5 * IBIS.amplitude_m / IBIS.semispan_m
    grid = np.meshgrid(np.linspace(-half, half, HEIGHTS), np.linspace(0.0, 0.5, PHASES))
    found = []
    for x, y, _, _ in plane(size).reshape(-1, 4) / IBIS.semispan_m:
        at = np.column_stack(
            [np.full(grid[0].size, x), np.full(grid[0].size, y), *(one.ravel() for one in grid)]
        )
        found.append(np.min(held.balanced(at)[:, 2]))
    return np.array(found)


def contest() -> Contest:
    """Return the contest, on one core."""
    behind, limit = Behind(IBIS), Behind(IBIS, model=WakeModel.named("limit"))
    few = SIZE_OF_PEERS
    return Contest(
        "saving_map",
        "place",
        [
            Contender("Upwash", lambda: mapped(behind, SIZE), SIZE**2, lambda: mapped(behind, few)),
            Contender(
                f"grid of {HEIGHTS} heights and {PHASES} phases",
                lambda: by_grid(behind, few),
                few**2,
                lambda: by_grid(behind, few),
            ),
            Contender("Upwash in the limit, height alone", lambda: mapped(limit, few, ("z",)), few**2),
        ],
    )
