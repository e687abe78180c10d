"""The velocity of a leader's eight vortex filaments at many points."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from upwash.aero.compiled.rings import FOUR_PI, filament_velocity, fill_velocity
from upwash.aero.induction import velocity
from upwash.aero.wake import CORE_RADIUS_RATIO, vortex_wake

from benchmarks.contest import Contender, Contest

POINTS = 100_000
SEMISPAN_M = 0.6
CORE_M = CORE_RADIUS_RATIO * SEMISPAN_M
BLOCK = 2048


def numpy_plain(points, starts, ends, circulation, core):
    """Return the velocity as one writes it first: arrays of all points by all filaments."""
    along = ends - starts
    from_start, from_end = points[:, None] - starts, points[:, None] - ends
    cross = np.cross(along, from_start)
    cosines = np.sum(
        along
        * (
            from_start / np.linalg.norm(from_start, axis=-1, keepdims=True)
            - from_end / np.linalg.norm(from_end, axis=-1, keepdims=True)
        ),
        axis=-1,
    )
    squared = np.maximum(np.sum(cross**2, axis=-1), core**2 * np.sum(along**2, axis=-1))
    return np.sum((circulation / FOUR_PI * cosines / squared)[..., None] * cross, axis=1)


def numpy_blocked(points, starts, ends, circulation, core):
    """Return the velocity filament by filament and coordinate by coordinate, in blocks that fit the cache."""
    found = np.empty_like(points)
    for first in range(0, points.shape[0], BLOCK):
        x, y, z = points[first : first + BLOCK].T.copy()
        total = np.zeros((3, x.size))
        for (sx, sy, sz), (ex, ey, ez), strength in zip(starts, ends, circulation, strict=True):
            ax, ay, az = ex - sx, ey - sy, ez - sz
            bx, by, bz = x - sx, y - sy, z - sz
            along_start = ax * bx + ay * by + az * bz
            length2 = ax * ax + ay * ay + az * az
            start2 = bx * bx + by * by + bz * bz
            end2 = start2 - 2.0 * along_start + length2
            cx, cy, cz = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
            squared = np.maximum(cx * cx + cy * cy + cz * cz, core * core * length2)
            factor = along_start / np.sqrt(start2) - (along_start - length2) / np.sqrt(end2)
            factor *= strength / FOUR_PI / squared
            total[0] += factor * cx
            total[1] += factor * cy
            total[2] += factor * cz
        found[first : first + BLOCK] = total.T
    return found


@njit(cache=True)
def filament_by_filament(points, starts, ends, circulation, core, found):
    """Fill in the velocity, compiled but as the equation stands."""
    for i in range(points.shape[0]):
        total_x = total_y = total_z = 0.0
        for k in range(starts.shape[0]):
            x, y, z = filament_velocity(
                points[i, 0],
                points[i, 1],
                points[i, 2],
                starts[k, 0],
                starts[k, 1],
                starts[k, 2],
                ends[k, 0],
                ends[k, 1],
                ends[k, 2],
                circulation[k],
                core,
            )
            total_x, total_y, total_z = total_x + x, total_y + y, total_z + z
        found[i, 0], found[i, 1], found[i, 2] = total_x, total_y, total_z


def pterasoftware(points, corners, circulation, work, outside):
    """Return PteraSoftware's compiled kernel as a contender, its cores too thin to matter."""
    name = "PteraSoftware, compiled"
    try:
        from pterasoftware import _aerodynamics_functions as ptera

        kernel = ptera.collapsed_velocities_from_ring_vortices
    except (ImportError, AttributeError) as error:
        return Contender(name, missing=f"{error} (make bench installs it)")
    # Its rings run from the back right by the front right, front left and back left corner.
    front_left, front_right, back_right, back_left = (np.ascontiguousarray(corners[:, k]) for k in range(4))
    cores, events = np.full(circulation.size, 1e-9), np.zeros(4, dtype=np.int64)

    def run(at=points):
        return kernel(at, back_right, front_right, front_left, back_left, -circulation, cores, events)

    return Contender(name, run, work, lambda: run(points[outside]))


def contest() -> Contest:
    """Return the contest: points all about an ibis's wake, of which those outside the cores are compared."""
    wake = vortex_wake(1.04, 0.4, SEMISPAN_M, 3.75, 0.9257)
    up = wake.state == 0
    rings, strengths, corners = wake.rings[up], wake.circulation[up], wake.corners()[up]
    starts, ends = corners.reshape(-1, 3), np.roll(corners, -1, axis=1).reshape(-1, 3)
    circulation = np.repeat(strengths, 4)
    points = np.random.default_rng(0).uniform([-0.5, -2.0, -1.0], [5.0, 2.0, 1.0], (POINTS, 3))
    outside = np.flatnonzero(distance_to_nearest(points, starts, ends) > CORE_M)
    filaments, cores = (starts, ends, circulation, CORE_M), np.full(strengths.size, CORE_M)
    work = POINTS * circulation.size
    found, compiled = np.empty_like(points), np.empty_like(points)

    def run_compiled():
        filament_by_filament(points, *filaments, compiled)
        return compiled

    return Contest(
        "field",
        "filament and point",
        [
            Contender(
                "Upwash",
                lambda: velocity(points, rings, strengths, CORE_M),
                work,
                lambda: velocity(points, rings, strengths, CORE_M)[outside],
            ),
            Contender(
                "Upwash, into an array at hand",
                lambda: fill_velocity(points, rings, strengths, cores, found),
                work,
                lambda: found[outside],
            ),
            Contender(
                "Upwash, filament by filament",
                run_compiled,
                work,
                lambda: compiled[outside],
            ),
            pterasoftware(points, corners, strengths, work, outside),
            Contender(
                "numpy, in blocks",
                lambda: numpy_blocked(points, *filaments),
                work,
                lambda: numpy_blocked(points[outside], *filaments),
            ),
            Contender(
                "numpy, plain",
                lambda: numpy_plain(points, *filaments),
                work,
                lambda: numpy_plain(points[outside], *filaments),
            ),
        ],
    )


def distance_to_nearest(points, starts, ends):
    """Return each point's distance from the nearest line on which a filament lies."""
    nearest = np.full(points.shape[0], math.inf)
    for start, end in zip(starts, ends, strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        nearest = np.minimum(nearest, np.linalg.norm(np.cross(points - start, along), axis=1))
    return nearest
