"""The dimensionless groups on which a force-optimal pair depends, and the limits within which birds lie.

Two birds with equal groups have the same solution in semispans and weights.  A group far outside its limits
is almost always a unit slip: grams taken for kilograms, centimetres for metres.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True)
class Group:
    """A dimensionless group and its limits.

    Parameters
    ----------
    symbol : str
        The group in the symbols of the nomenclature.
    usual : tuple of float
        Where flapping birds in cruising flight lie; outside it, a warning.
    possible : tuple of float
        Where no bird, or no solution, can be outside; outside it, an error.
    reason : str
        Why these limits.
    look_at : str
        The quantities to look at when a limit is broken.
    inputs : tuple of str
        The bird's inputs that it is made of; none if a bird does not tell it.
    """

    symbol: str
    usual: tuple[float, float]
    possible: tuple[float, float]
    reason: str
    look_at: str
    inputs: tuple[str, ...] = ()


GROUPS = {
    "weight_number": Group(
        symbol="W/(rho b^2 U^2)",
        usual=(0.03, 0.4),
        # A lift coefficient of 2 over an aspect ratio of 4 makes 1.
        possible=(0.003, 1.0),
        reason="twice lift coefficient over aspect ratio: usual for 0.2 to 1.2 over 13 to 6",
        look_at="mass, wingspan and speed",
        inputs=("mass_kg", "gravity_m_s2", "density_kg_m3", "semispan_m", "speed_m_s"),
    ),
    "wavelength_number": Group(
        symbol="lambda/b",
        usual=(2.0, 15.0),
        possible=(0.5, 100.0),
        reason="a cruising bird advances one to seven wingspans in a wingbeat",
        look_at="speed, wingbeat_frequency and wingspan",
        inputs=("speed_m_s", "period_s", "semispan_m"),
    ),
    "amplitude_number": Group(
        symbol="h/b",
        usual=(0.3, 1.8),
        possible=(0.05, 2.0),
        reason="it is twice the sine of the half-angle: usual for 9 to 64 degrees, at most 2",
        look_at="stroke_half_angle",
        inputs=("amplitude_m", "semispan_m", "stroke_half_angle_deg"),
    ),
    "upstroke_span_ratio": Group(
        symbol="R",
        usual=(0.2, 0.7),
        possible=(0.0, math.pi / 4.0),
        reason="on the upstroke a wing is neither folded nor outstretched; from pi/4 on it makes no thrust",
        look_at="upstroke_span_ratio",
    ),
    "strouhal": Group(
        symbol="f h/U",
        usual=(0.1, 0.5),
        possible=(0.01, 3.0),
        reason="cruising birds lie at 0.2 to 0.4, or somewhat below (Taylor et al. 2003 Nature 425:707)",
        look_at="wingbeat_frequency, stroke_half_angle and speed",
        inputs=("amplitude_m", "speed_m_s", "period_s", "semispan_m", "stroke_half_angle_deg"),
    ),
    "aspect_ratio": Group(
        symbol="B^2/S",
        usual=(4.0, 20.0),
        possible=(1.0, 50.0),
        reason="from a pheasant's wing to an albatross's",
        look_at="wing_area and wingspan",
    ),
}


def groups_of(inputs: Mapping[str, float]) -> dict[str, float]:
    """Return the groups that a bird's inputs tell, with or without its amplitude.

    Parameters
    ----------
    inputs : mapping
        The fields of `upwash.aero.bird.Bird`, in SI units.
    """
    semispan, wavelength = inputs["semispan_m"], inputs["speed_m_s"] * inputs["period_s"]
    weight = inputs["mass_kg"] * inputs["gravity_m_s2"]
    groups = {
        "weight_number": weight / (inputs["density_kg_m3"] * semispan**2 * inputs["speed_m_s"] ** 2),
        "wavelength_number": wavelength / semispan,
    }
    if "amplitude_m" in inputs:
        groups["amplitude_number"] = inputs["amplitude_m"] / semispan
        groups["upstroke_span_ratio"] = inputs["upstroke_span_ratio"]
        groups["strouhal"] = inputs["amplitude_m"] / wavelength
    return groups


def outside(groups: Mapping[str, float], limits: str) -> list[str]:
    """Say which of a bird's groups lie outside their limits, and why that is odd.

    Parameters
    ----------
    groups : dict
        Values by name, as in `GROUPS`.
    limits : str
        Which limits: ``usual`` or ``possible``.

    Returns
    -------
    list of str
        One sentence a group.
    """
    sentences = []
    for name, value in groups.items():
        group = GROUPS[name]
        low, high = getattr(group, limits)
        if not low <= value <= high:
            sentences.append(
                f"{group.symbol}: expected {low:.3g} to {high:.3g} ({group.reason}), found {value:.3g}; "
                f"look at the values and units of {group.look_at}"
            )
    return sentences
