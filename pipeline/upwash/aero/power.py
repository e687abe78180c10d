"""What flight costs: induced, profile and parasite power, and the cost functions an optimisation may minimise.

Every cost function is a sum, with weights that are not negative, of four parts: the magnitude of the
self-generated force and the three powers.  Each part is convex in (lift, thrust) and, where neither is negative,
rises with both, so each cost function does too; the proof of an optimum rests on that.  A new one is one line in
`COST_FUNCTIONS`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from upwash.aero.bird import Bird

INDUCED_POWER_FACTOR = 1.2
"""k of the induced power, dimensionless (Pennycuick 2008)."""

BODY_AREA_M2 = 0.00813
"""Body frontal area of a 1 kg bird, in m² (Pennycuick 2008)."""

BODY_AREA_EXPONENT = 0.666
"""Exponent of mass, in kg, in the body frontal area (Pennycuick 2008)."""

BODY_DRAG_COEFFICIENT = 1.0
"""Drag coefficient of the body on its frontal area, dimensionless (the paper's value)."""


def induced_power_w(bird: Bird, lift_n: float) -> float:
    """Power to make lift, in W, for a time-averaged self-generated lift in N (induced_power)."""
    wingspan = 2.0 * bird.semispan_m
    return (
        2.0 * INDUCED_POWER_FACTOR * lift_n**2 / (wingspan**2 * math.pi * bird.density_kg_m3 * bird.speed_m_s)
    )


def profile_power_w(bird: Bird, thrust_n: float) -> float:
    """Power to make thrust, in W, for a time-averaged self-generated thrust in N (profile_power)."""
    return thrust_n * bird.speed_m_s


def body_area_m2(mass_kg: float) -> float:
    """Frontal area S_b of the body of a bird of a mass in kg, in m²."""
    return BODY_AREA_M2 * mass_kg**BODY_AREA_EXPONENT


def parasite_power_w(bird: Bird) -> float:
    """Power against the drag of the body, in W (parasite_power)."""
    area = body_area_m2(bird.mass_kg)
    return 0.5 * bird.density_kg_m3 * bird.speed_m_s**3 * area * BODY_DRAG_COEFFICIENT


def total_power_w(bird: Bird, lift_n: float, thrust_n: float) -> float:
    """Total mechanical power, in W, for self-generated lift and thrust in N."""
    return induced_power_w(bird, lift_n) + profile_power_w(bird, thrust_n) + parasite_power_w(bird)


@dataclass(frozen=True)
class CostFunction:
    """A cost as a weighted sum of force and powers; no weight is negative.

    Parameters
    ----------
    unit : str
        Unit of the cost.
    force, induced, profile, parasite : float
        Weights of the magnitude of the self-generated force (in N) and of the three powers (in W).
    per_metre : bool
        Whether the sum is divided by the airspeed: power becomes energy per distance.
    """

    unit: str
    force: float = 0.0
    induced: float = 0.0
    profile: float = 0.0
    parasite: float = 0.0
    per_metre: bool = False

    def __post_init__(self) -> None:
        if min(self.force, self.induced, self.profile, self.parasite) < 0.0:
            raise ValueError(f"weights of a cost function: expected none below 0, found {self}")

    def value(self, bird: Bird, lift_n: float, thrust_n: float) -> float:
        """Cost of making a time-averaged lift and thrust (both in N), in this function's unit."""
        total = (
            self.force * math.hypot(lift_n, thrust_n)
            + self.induced * induced_power_w(bird, lift_n)
            + self.profile * profile_power_w(bird, thrust_n)
            + self.parasite * parasite_power_w(bird)
        )
        return total / bird.speed_m_s if self.per_metre else total


COST_FUNCTIONS: dict[str, CostFunction] = {
    # The magnitude of the time-averaged force; the paper prints that of the impulse, T times as large (objective_fn).
    "force": CostFunction("N", force=1.0),
    "power": CostFunction("W", induced=1.0, profile=1.0, parasite=1.0),
    "cost_of_transport": CostFunction("J/m", induced=1.0, profile=1.0, parasite=1.0, per_metre=True),
    # Thrust times speed pays for all drag, the body's too: without parasite power nothing is counted twice.
    "aerodynamic_power": CostFunction("W", induced=1.0, profile=1.0),
}
