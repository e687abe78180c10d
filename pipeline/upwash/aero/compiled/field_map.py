"""The wake's force at many positions, for one span node in one stroke state: compiled."""

from __future__ import annotations

import numpy as np

from upwash.aero.compiled.rings import fill_velocity
from upwash.kernel import kernel

# Positions taken at a time: their coordinates and velocities stay in the second-level cache.
BLOCK = 4096


@kernel
def add_force(positions, aside, above, per_velocity, rings, circulation, core_radius, force):
    """Add to each position's lift and thrust what the wake's velocity at one span node gives in one state."""
    points, wind = np.empty((BLOCK, 3)), np.empty((BLOCK, 3))
    for first in range(0, positions.shape[0], BLOCK):
        part = positions[first : first + BLOCK]
        size = part.shape[0]
        for i in range(size):
            points[i, 0] = part[i, 0]
            points[i, 1] = part[i, 1] + aside
            points[i, 2] = part[i, 2] + above
        fill_velocity(points[:size], rings, circulation, core_radius, wind[:size])
        for i in range(size):
            force[first + i, 0] += per_velocity * wind[i, 0]
            force[first + i, 1] += per_velocity * wind[i, 2]
