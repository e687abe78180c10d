"""What a species file may say of a bird: its quantities, their units, and which values make sense at all."""

from __future__ import annotations

import math
from dataclasses import dataclass

from upwash.aero.checked import REACH, Rule, at_most, below
from upwash.species.allometry import AS_IBIS

HALF_ANGLE_DEG = REACH & at_most(90.0, "the wingtips meet there")
"""What half of a wing's stroke angle must be, in degrees."""

BASES = {
    "measured": "on birds of this species, by the work cited",
    "given": "taken over from the paper that Upwash reproduces",
    "computed": "from other quantities, by the rule or formula cited",
    "assumed": "nobody measured it: a value borrowed or judged",
}
FORMATION_SHAPES = ("V", "echelon", "cluster", "none")


@dataclass(frozen=True)
class Quantity:
    """One value and how it is known.

    Parameters
    ----------
    value, low, high : float
        The value and the range to sample when asking how much it matters, in `unit`.
    unit : str
        SI unit; angles are in degrees.
    source : str
        The original work, or the formula.
    basis : str
        One of `BASES`.
    rule : str
        Name of the rule that filled the value, or "".
    sample : int or None
        How many birds or tracks it rests on, where the source says.
    note : str
        What a reader should know before trusting it, or "".
    """

    value: float
    unit: str
    low: float
    high: float
    basis: str
    source: str
    rule: str = ""
    sample: int | None = None
    note: str = ""


@dataclass(frozen=True)
class Formation:
    """How the species flies together: a shape of `FORMATION_SHAPES`, and how that is known."""

    shape: str
    basis: str
    source: str
    note: str = ""


@dataclass(frozen=True)
class Kind:
    """What a quantity may be.

    Parameters
    ----------
    units : dict
        Unit -> how many of it make one SI unit. The first unit is the SI one.
    rule : Rule
        What a value must be, in the SI unit.
    rules : tuple of str
        Rules that may fill it, by name.
    optional : bool
        Whether a file may leave it out.
    """

    units: dict[str, float]
    rule: Rule = REACH
    rules: tuple[str, ...] = ()
    optional: bool = False

    @property
    def unit(self) -> str:
        """The SI unit."""
        return next(iter(self.units))


# In the order in which files and listings give them.
QUANTITIES = {
    "mass": Kind({"kg": 1.0, "g": 1000.0}),
    "wingspan": Kind({"m": 1.0, "cm": 100.0}),
    "wing_area": Kind({"m2": 1.0, "cm2": 10000.0}, optional=True),
    "speed": Kind({"m/s": 1.0, "km/h": 3.6}, rules=("alerstam-2007",)),
    "wingbeat_frequency": Kind({"Hz": 1.0}, rules=("pennycuick-1996",)),
    "stroke_half_angle": Kind({"deg": 1.0}, HALF_ANGLE_DEG, rules=("nudds-2004",)),
    "upstroke_span_ratio": Kind(
        {"1": 1.0},
        REACH & below(math.pi / 4.0, "from pi/4 on a lone bird makes no thrust"),
        rules=(AS_IBIS,),
    ),
    "air_density": Kind({"kg/m3": 1.0}, rules=(AS_IBIS,)),
    "gravity": Kind({"m/s2": 1.0}, rules=(AS_IBIS,)),
}
