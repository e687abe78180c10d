"""What a species file may say of a bird: its quantities, their units, and which values make sense at all."""

from __future__ import annotations

import math
from dataclasses import dataclass

from upwash.species.allometry import AS_IBIS

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
    below : float
        Values lie between 0 and this, both excluded unless `below_included`.
    below_included : bool
        Whether `below` itself is allowed.
    why : str
        Why there is a `below`, or "".
    rules : tuple of str
        Rules that may fill it, by name.
    optional : bool
        Whether a file may leave it out.
    """

    units: dict[str, float]
    below: float = math.inf
    below_included: bool = False
    why: str = ""
    rules: tuple[str, ...] = ()
    optional: bool = False

    @property
    def unit(self) -> str:
        """The SI unit."""
        return next(iter(self.units))

    @property
    def expected(self) -> str:
        """What a value must be, in words."""
        if self.below == math.inf:
            return "a positive, finite number"
        end = "at most" if self.below_included else "below"
        return f"a number above 0 and {end} {self.below:.4g} ({self.why})"

    def allows(self, value: float) -> bool:
        """Whether an SI value makes sense."""
        return 0.0 < value < self.below or (self.below_included and value == self.below)


# In the order in which files and listings give them.
QUANTITIES = {
    "mass": Kind({"kg": 1.0, "g": 1000.0}),
    "wingspan": Kind({"m": 1.0, "cm": 100.0}),
    "wing_area": Kind({"m2": 1.0, "cm2": 10000.0}, optional=True),
    "speed": Kind({"m/s": 1.0, "km/h": 3.6}, rules=("alerstam-2007",)),
    "wingbeat_frequency": Kind({"Hz": 1.0}, rules=("pennycuick-1996",)),
    "stroke_half_angle": Kind(
        {"deg": 1.0},
        below=90.0,
        below_included=True,
        why="the wingtips meet there",
        rules=("nudds-2004",),
    ),
    "upstroke_span_ratio": Kind(
        {"1": 1.0}, below=math.pi / 4.0, why="from pi/4 on a lone bird makes no thrust", rules=(AS_IBIS,)
    ),
    "air_density": Kind({"kg/m3": 1.0}, rules=(AS_IBIS,)),
    "gravity": Kind({"m/s2": 1.0}, rules=(AS_IBIS,)),
}
