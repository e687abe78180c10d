"""What flight burns: from mechanical power to fuel, with sources and ranges."""

from __future__ import annotations

from dataclasses import dataclass, field

from upwash.aero.checked import REACH, check_fields, fraction, must_be, not_negative


@dataclass(frozen=True)
class Sourced:
    """A value, the range in which it was found, and where.

    Parameters
    ----------
    value, low, high : float
        The value and its range, in `unit`.
    unit : str
        SI unit.
    source : str
        Where it is from.
    """

    value: float
    low: float
    high: float
    unit: str
    source: str


EFFICIENCY = Sourced(
    0.23,
    0.13,
    0.23,
    "1",
    "Pennycuick 2008, as the R package afpt takes it; Ward et al. 2001 J. Exp. Biol. 204:3311 found 0.13 to 0.23 "
    "in starlings",
)
"""Mechanical work of the flight muscles over the energy of the fuel that they burn."""

ENERGY_DENSITY_J_KG = Sourced(
    4.0e7,
    3.9e7,
    4.0e7,
    "J/kg",
    "Pennycuick 2008, as the R package FlyingR takes it; the low end follows from the range that Pennycuick 1968 "
    "J. Exp. Biol. 49:527 states for a pigeon",
)
"""Energy of the fuel, which is fat, per mass."""

UPKEEP = Sourced(1.1, 1.1, 1.1, "1", "Pennycuick 2008, as the R package afpt takes it")
"""By what circulation and breathing multiply what is burned."""

BASAL_W = Sourced(
    3.79, 3.79, 6.25, "W", "Pennycuick 2008, as the R package afpt takes it: 6.25 for passerines"
)
"""Basal metabolic rate of a bird of 1 kg without fuel that is no passerine, in W."""

BASAL_EXPONENT = 0.723
"""Exponent of the mass without fuel, in kg, in the basal metabolic rate (the same source)."""


@dataclass(frozen=True)
class Fuel:
    """How a bird turns fuel into work.

    Parameters
    ----------
    lean_kg : float
        Mass of the bird without fuel, in kg, for its basal metabolic rate.
    efficiency : float
        Mechanical work over the energy burned for it.
    energy_density_j_kg : float
        Energy of the fuel, in J/kg.
    upkeep : float
        What circulation and breathing multiply the rest by.
    basal_w : float
        Basal metabolic rate of a lean bird of 1 kg, in W.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.

    Examples
    --------
    >>> jackdaw = Fuel(0.215, basal_w=6.25)
    >>> print(f"{jackdaw.chemical_w(2.093):.1f} W are burned for 2.1 W of work")
    12.3 W are burned for 2.1 W of work
    """

    lean_kg: float = field(metadata=must_be(REACH))
    efficiency: float = field(default=EFFICIENCY.value, metadata=must_be(fraction))
    energy_density_j_kg: float = field(default=ENERGY_DENSITY_J_KG.value, metadata=must_be(REACH))
    upkeep: float = field(default=UPKEEP.value, metadata=must_be(REACH))
    basal_w: float = field(default=BASAL_W.value, metadata=must_be(not_negative))

    def __post_init__(self) -> None:
        check_fields(self)

    def chemical_w(self, power_w: float) -> float:
        """Return the power that is burned for a mechanical power, both in W."""
        basal = self.basal_w * self.lean_kg**BASAL_EXPONENT
        return self.upkeep * (power_w / self.efficiency + basal)

    def burned_kg_s(self, power_w: float) -> float:
        """Return the fuel that is burned for a mechanical power in W, in kg/s."""
        return self.chemical_w(power_w) / self.energy_density_j_kg
