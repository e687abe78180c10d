"""Rules that fill in what nobody has measured on a species, each with its source and its trust.

A species file names the rule that filled a value.  Where it states the value as well, the two must agree.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

# The rules below were fitted to, or are quoted in, standard air; a species' own air does not enter them.
STANDARD_GRAVITY_M_S2 = 9.81
STANDARD_DENSITY_KG_M3 = 1.225

# Name of the rule that takes over the northern bald ibis's value; it needs the ibis's file, not a formula.
AS_IBIS = "as-ibis"


@dataclass(frozen=True)
class Rule:
    """An allometric formula for one quantity.

    Parameters
    ----------
    needs : tuple of str
        Quantities that the formula takes, in the order of its arguments.
    formula : callable
        SI values (angles in degrees) of `needs` in, the quantity's value out.
    words : str
        The formula, for a reader.
    source : str
        The work that it comes from.
    spread : float
        Half-width of the range about the value, as a fraction of it.
    """

    needs: tuple[str, ...]
    formula: Callable[..., float]
    words: str
    source: str
    spread: float


def pennycuick_frequency_hz(mass_kg: float, wingspan_m: float, wing_area_m2: float) -> float:
    """Wingbeat frequency in cruising flight, in Hz, fitted to 47 species."""
    return (
        mass_kg ** (3 / 8)
        * STANDARD_GRAVITY_M_S2 ** (1 / 2)
        * wingspan_m ** (-23 / 24)
        * wing_area_m2 ** (-1 / 3)
        * STANDARD_DENSITY_KG_M3 ** (-3 / 8)
    )


def nudds_half_angle_deg(wingspan_m: float) -> float:
    """Half of the wing's stroke angle in cruising flight, in degrees."""
    return 33.5 * wingspan_m**-0.24


def alerstam_speed_m_s(mass_kg: float, wing_area_m2: float) -> float:
    """Equivalent airspeed of migrating birds, in m/s, from wing loading; fitted to 138 species."""
    return 4.3 * (mass_kg * STANDARD_GRAVITY_M_S2 / wing_area_m2) ** 0.31


RULES = {
    # Against the library's five birds of known frequency this formula is 10 % low to 30 % high.
    "pennycuick-1996": Rule(
        needs=("mass", "wingspan", "wing_area"),
        formula=pennycuick_frequency_hz,
        words="M^(3/8) g^(1/2) B^(-23/24) S^(-1/3) rho^(-3/8), with g = 9.81 m/s2 and rho = 1.225 kg/m3",
        source="Pennycuick 1996 J. Exp. Biol. 199:1613",
        spread=0.25,
    ),
    # The source gives no scatter; the spread is a judgement, the same as the frequency's.
    "nudds-2004": Rule(
        needs=("wingspan",),
        formula=nudds_half_angle_deg,
        words="33.5 B^-0.24",
        source="Nudds, Taylor & Thomas 2004 Proc. R. Soc. B 271:2071",
        spread=0.25,
    ),
    # Tracks of one species scatter by 10 to 20 % (standard deviation), and lineage matters beside loading.
    "alerstam-2007": Rule(
        needs=("mass", "wing_area"),
        formula=alerstam_speed_m_s,
        words="4.3 (M g/S)^0.31",
        source="Alerstam et al. 2007 PLoS Biol. 5:e197, Table 1",
        spread=0.15,
    ),
}
