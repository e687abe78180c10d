"""Velocity that vortex rings with Rankine cores induce at points, and its gradient.

The filaments' formula stands with the compiled loops, in `upwash.aero.compiled.rings`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from upwash.aero.compiled.rings import add_velocity_gradient, fill_velocity


def velocity(
    points: ArrayLike, rings: ArrayLike, circulation: ArrayLike, core_radius: ArrayLike
) -> NDArray[np.float64]:
    """Return the velocity that vortex rings induce at any number of points: the sum over their filaments.

    Parameters
    ----------
    points : (..., 3) array_like of float
        Points, in m.
    rings : (n, 6) array_like of float
        Tilted rectangles as in `upwash.aero.wake.Wake`, in m.
    circulation : (n,) array_like of float
        Circulation of each ring, in m²/s.
    core_radius : float or (n,) array_like of float
        Radius of the cores of all filaments, or of each ring's, in m.

    Returns
    -------
    (..., 3) ndarray of float
        Velocity, in m/s.
    """
    points = np.asarray(points, dtype=float)
    flat = np.require(points.reshape(-1, 3), requirements=["C", "W"])
    found = np.empty_like(flat)
    fill_velocity(flat, *_arrays(rings, circulation, core_radius), found)
    return found.reshape(points.shape)


def velocity_gradient(
    points: ArrayLike, rings: ArrayLike, circulation: ArrayLike, core_radius: ArrayLike
) -> NDArray[np.float64]:
    """Return the exact gradient of `velocity`; on a core edge, that from inside the core.

    Parameters
    ----------
    points, rings, circulation, core_radius
        As for `velocity`.

    Returns
    -------
    (..., 3, 3) ndarray of float
        Derivative of velocity component i along coordinate j, in 1/s.
    """
    points = np.asarray(points, dtype=float)
    flat = np.array(points.reshape(-1, 3))
    found = np.zeros((flat.shape[0], 9))
    add_velocity_gradient(flat, *_arrays(rings, circulation, core_radius), found)
    return found.reshape((*points.shape, 3))


def _arrays(
    rings: ArrayLike, circulation: ArrayLike, core_radius: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return rings as the compiled loops take them."""
    strengths = np.array(circulation, dtype=float)
    return np.array(rings, dtype=float), strengths, np.full(strengths.shape, core_radius, dtype=float)
