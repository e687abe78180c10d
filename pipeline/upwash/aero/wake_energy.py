"""The energy that the rings of a wake carry: what the air still moves with when a bird has flown by.

A wingbeat leaves one wavelength of an endless chain of rings.  Its kinetic energy is Neumann's double integral over
their filaments, those of all images included,

    E = ρ/(8π) Σ Γᵢ Γⱼ ∬ dlᵢ · dlⱼ / r,

i over the rings of one wavelength and j over all.  Filaments are thin: r is never less than δ, at which a line has the
energy of a core that it stands for.  In a straight pair that is exact, ρ Γ²/(2π) [ln(2w/r_c) + ¼] a metre for
Rankine cores.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.pose import Stroke
from upwash.aero.wake import WakeModel, wake_at_phases

IMAGES = 10
"""Wavelengths of images on each side: the energy is then known to 3e-5."""

_SHARE, _WEIGHT = np.polynomial.legendre.leggauss(16)
"""Gauss–Legendre points along a tip filament, for those that are not parallel to it."""

_LEAST_DISTANCE = {"rankine": math.exp(-0.25), "rosenhead-moore": math.exp(0.5)}
"""Core -> δ over its radius."""


@lru_cache(maxsize=256)
def wake_power_w(bird: Bird, stroke: Stroke, model: WakeModel | None = None) -> float:
    """Return the energy per time of the rings that a bird leaves, in W.

    Parameters
    ----------
    bird : Bird
        Its circulation, semispan and wavelength.
    stroke : Stroke
        How it flaps.
    model : WakeModel, optional
        Whose core; the paper's if not given.

    Returns
    -------
    float
        Kinetic energy of one wavelength of the endless chain, over the period.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> round(wake_power_w(ibis, ibis.stroke), 2)
    6.16
    """
    model = model or WakeModel()
    least = model.core_radius_ratio * bird.semispan_m * _LEAST_DISTANCE[model.core]
    wake = wake_at_phases(
        [0.0],
        stroke.amplitude_m,
        stroke.span_ratio,
        bird.semispan_m,
        bird.wavelength_m,
        bird.circulation_m2_s,
        bird.circulation_ratio,
    )
    shifts = bird.wavelength_m * np.arange(-IMAGES, IMAGES + 1, dtype=np.float64)
    integral = 0.0
    for i, ring in enumerate(wake.rings):
        for j, other in enumerate(wake.rings[: i + 1]):
            # Each pair counts twice: one in the other's field, and the other in the one's.
            strength = wake.circulation[i] * wake.circulation[j] * (1.0 if i == j else 2.0)
            integral += strength * (
                _spanwise(ring, other, shifts, least) + _along(ring, other, shifts, least)
            )
    return float(bird.density_kg_m3 / (8.0 * math.pi) * integral / bird.period_s)


def _parallel(
    length: float, other: float, offset: NDArray[np.float64], distance2: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ∬ ds ds'/r of two parallel segments, from 0 to a length and from an offset on."""
    ends = np.array([length - offset, -offset - other, -offset, length - offset - other])
    primitive = ends * np.arcsinh(ends / np.sqrt(distance2)) - np.sqrt(ends * ends + distance2)
    return np.asarray(primitive[0] + primitive[1] - primitive[2] - primitive[3])


def _spanwise(
    ring: NDArray[np.float64], other: NDArray[np.float64], shifts: NDArray[np.float64], least: float
) -> float:
    """Return the integral over the starting and stopping vortices of a ring and of all images of another."""
    behind = ring[:2, None, None] - other[None, :2, None] - shifts
    above = ring[2:4, None, None] - other[None, 2:4, None]
    distance2 = np.maximum(behind**2 + above**2, least * least)
    offset = np.full_like(distance2, ring[5] - other[5])
    pairs = _parallel(2.0 * ring[5], 2.0 * other[5], offset, distance2).sum(axis=2)
    return float(pairs[0, 0] + pairs[1, 1] - pairs[0, 1] - pairs[1, 0])


def _along(
    ring: NDArray[np.float64], other: NDArray[np.float64], shifts: NDArray[np.float64], least: float
) -> float:
    """Return the same over the tip vortices; with starting and stopping vortices they share no energy."""
    run, run_other = (np.array([one[1] - one[0], one[3] - one[2]]) for one in (ring, other))
    length, length_other = math.hypot(*run), math.hypot(*run_other)
    ax, az = run_other / length_other
    aside = np.array([ring[5] - other[5], ring[5] + other[5]])
    if np.array_equal(ring, other):
        # Parallel, and nearest where they meet end to end.
        offset = np.array([ax * shifts, ax * shifts])
        distance2 = np.maximum((az * shifts) ** 2 + aside[:, None] ** 2, least * least)
        near, far = _parallel(length, length, offset, distance2).sum(axis=1)
    else:
        share = 0.5 * (_SHARE[:, None] + 1.0)
        x, z = ring[0] + share * run[0] - other[0] - shifts, ring[2] + share * run[1] - other[2]
        p, across = ax * x + az * z, az * x - ax * z
        r = np.sqrt(np.maximum(across**2 + aside[:, None, None] ** 2, least * least))
        seen = np.arcsinh(p / r) - np.arcsinh((p - length_other) / r)
        near, far = 0.5 * length * (_WEIGHT @ seen.sum(axis=2).T)
    return 2.0 * float(near - far) * float(run @ run_other) / (length * length_other)
