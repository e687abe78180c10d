"""The wind along a whole span in closed form: the integral of a wake's velocity over a straight wing.

A ring is a closed rectangle, tilted in the vertical plane.  Its velocity has an antiderivative G over y in closed
form, so that the integral from one wingtip to the other is the difference of G at the two.  With x₀, z₀ and x₁, z₁ the
point as seen from the ring's two stations, y_l = y + w and y_r = y − w as seen from its sides, q = x² + z², p along the
tip filaments and d across them in their vertical plane, n the distance to a corner, and (a_x, a_z) their direction,

    S = (n_l − n_r) / max(q, r_c²)                           at each station
    T = A(p₀, y_r) − A(p₁, y_r) − A(p₀, y_l) + A(p₁, y_l)
    A(p, e) = −asinh(p/√m) + p (u − v)/r_c²,      r = e² + d²,  m = max(r, r_c²),  u = √(p² + r),  v = √(p² + m)
    G_x = z₀ S₀ − z₁ S₁ − a_z T
    G_z = x₁ S₁ − x₀ S₀ + a_x T

in units of circulation over 4π.  A Rosenhead–Moore core adds r_c² to each of q, r and n² and needs no maximum.
This is the plain statement; `upwash.aero.compiled.exact_span` is the same, compiled and with its slopes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def span_nodes(count: int | str) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return nodes across the span in [−1, 1] and their trapezoidal weights, which sum to 1 (eqn:integral_approx).

    Raises
    ------
    ValueError
        If the span is to be taken exactly, in no nodes.
    """
    if isinstance(count, str):
        raise ValueError(f"span_nodes: expected a number of points across the span, found {count!r}")
    weights = np.full(count, 1.0 / (count - 1))
    weights[[0, -1]] *= 0.5
    return np.linspace(-1.0, 1.0, count), weights


def span_antiderivative(
    x: ArrayLike,
    y: ArrayLike,
    z: ArrayLike,
    rings: NDArray[np.float64],
    circulation: NDArray[np.float64],
    core_radius: float | NDArray[np.float64],
    core: str = "rankine",
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the antiderivative over y of the streamwise and of the vertical velocity of rings.

    Parameters
    ----------
    x, y, z : array_like of float
        Points that broadcast together, in m.
    rings : (n, 6) ndarray of float
        Tilted rectangles as in `upwash.aero.wake.Wake`, in m.
    circulation : (n,) ndarray of float
        Circulation of each ring, in m²/s.
    core_radius : float or (n,) ndarray of float
        Radius of the cores of all filaments, or of each ring's, in m.
    core : str
        ``rankine`` or ``rosenhead-moore``.

    Returns
    -------
    tuple of two ndarray of float
        G_x and G_z, in m²/s; where they vanish is of no meaning.
    """
    x, y, z = (np.asarray(each, dtype=float)[..., None] for each in (x, y, z))
    first_x, last_x, first_z, last_z, centre_y, half_width = rings.T
    core2 = core_radius * core_radius
    softening, least = (0.0, core2) if core == "rankine" else (core2, 0.0)
    run = np.hypot(last_x - first_x, last_z - first_z)
    ax, az = (last_x - first_x) / run, (last_z - first_z) / run
    x0, x1, z0, z1 = x - first_x, x - last_x, z - first_z, z - last_z
    left, right = y - centre_y + half_width, y - centre_y - half_width
    p0, p1, d = ax * x0 + az * z0, ax * x1 + az * z1, az * x0 - ax * z0

    def station(dx: NDArray[np.float64], dz: NDArray[np.float64]) -> NDArray[np.float64]:
        q = dx * dx + dz * dz + softening
        return (np.sqrt(q + left * left) - np.sqrt(q + right * right)) / np.maximum(q, least)

    def corner(p: NDArray[np.float64], e: NDArray[np.float64]) -> NDArray[np.float64]:
        r = e * e + d * d + softening
        m = np.maximum(r, least)
        # u − v as (r − m)/(u + v), which keeps its digits however long the filament is.
        u, v = np.sqrt(p * p + r), np.sqrt(p * p + m)
        return -np.arcsinh(p / np.sqrt(m)) + p * (r - m) / ((u + v) * core2)

    s0, s1 = station(x0, z0), station(x1, z1)
    t = corner(p0, right) - corner(p1, right) - corner(p0, left) + corner(p1, left)
    strength = circulation / (4.0 * math.pi)
    return (
        np.sum(strength * (z0 * s0 - z1 * s1 - az * t), axis=-1),
        np.sum(strength * (x1 * s1 - x0 * s0 + ax * t), axis=-1),
    )


def ring_velocity(
    points: ArrayLike,
    rings: NDArray[np.float64],
    circulation: NDArray[np.float64],
    core_radius: float | NDArray[np.float64],
    core: str = "rankine",
) -> NDArray[np.float64]:
    """Return the velocity of rings at points, for either core: the slope of the antiderivative, and v_y.

    For the Rankine core it is `upwash.aero.induction.velocity` up to rounding.

    Parameters
    ----------
    points : (..., 3) array_like of float
        Points, in m.
    rings, circulation, core_radius, core
        As for `span_antiderivative`.

    Returns
    -------
    (..., 3) ndarray of float
        Velocity, in m/s.
    """
    x, y, z = np.moveaxis(np.asarray(points, dtype=float), -1, 0)[..., None]
    first_x, last_x, first_z, last_z, centre_y, half_width = rings.T
    core2 = core_radius * core_radius
    softening, least = (0.0, core2) if core == "rankine" else (core2, 0.0)
    run = np.hypot(last_x - first_x, last_z - first_z)
    ax, az = (last_x - first_x) / run, (last_z - first_z) / run
    x0, x1, z0, z1 = x - first_x, x - last_x, z - first_z, z - last_z
    left, right = y - centre_y + half_width, y - centre_y - half_width
    p0, p1, d = ax * x0 + az * z0, ax * x1 + az * z1, az * x0 - ax * z0
    q0, q1 = x0 * x0 + z0 * z0 + softening, x1 * x1 + z1 * z1 + softening
    with np.errstate(invalid="ignore", divide="ignore"):

        def over_distance(along: NDArray[np.float64], distance2: NDArray[np.float64]) -> NDArray[np.float64]:
            return np.where(distance2 > 0.0, along / np.sqrt(distance2), 0.0)

        s0 = (over_distance(left, q0 + left**2) - over_distance(right, q0 + right**2)) / np.maximum(q0, least)
        s1 = (over_distance(left, q1 + left**2) - over_distance(right, q1 + right**2)) / np.maximum(q1, least)
        tips = [
            (over_distance(p0, q0 + side**2) - over_distance(p1, q1 + side**2))
            / np.maximum(side**2 + d * d + softening, least)
            for side in (left, right)
        ]
    strength = circulation / (4.0 * math.pi)
    tip = right * tips[1] - left * tips[0]
    return np.stack(
        [
            np.sum(strength * (z0 * s0 - z1 * s1 - az * tip), axis=-1),
            np.sum(strength * d * (tips[1] - tips[0]), axis=-1),
            np.sum(strength * (x1 * s1 - x0 * s0 + ax * tip), axis=-1),
        ],
        axis=-1,
    )
