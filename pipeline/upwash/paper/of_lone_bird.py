"""What the paper says of a bird flying alone, and of the cost it minimises: its equations, taken at their word."""

from __future__ import annotations

from dataclasses import replace
from math import log2

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.induction import velocity
from upwash.aero.interaction import state_forces
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import vortex_wake
from upwash.paper.claim import Cases, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence
from upwash.study.rows import pose_of

# Another pair of R and Γ_up/Γ_down with the same product.
OTHER_RATIO = 0.5

UP, DOWN = 0, 1
"""Stroke states."""

SMALL_CHANGE = 1e-4

VANISHING = 1e-8
"""An upstroke span ratio as good as 0."""


def _circulation_exponents(evidence: Evidence) -> Cases:
    """Exponent of the circulation in each quantity, less the one claimed."""
    bird = evidence.bird
    claimed = {"mass_kg": 1.0, "density_kg_m3": -1.0, "semispan_m": -1.0, "speed_m_s": -1.0}
    words = {
        "mass_kg": "weight",
        "density_kg_m3": "air density",
        "semispan_m": "wingspan",
        "speed_m_s": "airspeed",
    }
    doubled = {name: replace(bird, **{name: 2.0 * getattr(bird, name)}) for name in claimed}
    return {
        words[name]: log2(other.circulation_m2_s / bird.circulation_m2_s) - claimed[name]
        for name, other in doubled.items()
    }


def _passive_upstroke(evidence: Evidence) -> Cases:
    """What is left of the upstroke as R goes to 0: of its lift, over all lift; of its wake, over that at R_L."""
    bird, row = evidence.bird, evidence.v("force")
    point = np.array([[row["x_m"], row["y_m"], row["z_m"]]])

    def wind(ratio: float) -> float:
        wake = vortex_wake(bird.amplitude_m, ratio, bird.semispan_m, bird.wavelength_m, bird.circulation_m2_s)
        shed = wake.only(wake.is_upstroke & (wake.state == 0))
        return float(np.linalg.norm(velocity(point, shed.rings, shed.circulation, shed.core_radius)))

    return {
        "lift": float(1.0 - bird.lift_n(0.0) / bird.lift_n(VANISHING)),
        "wake": wind(VANISHING) / wind(bird.upstroke_span_ratio),
    }


def _same_product(evidence: Evidence) -> Cases:
    """Change in percent when R and the upstroke's circulation change and their product does not."""
    bird, row = evidence.bird, evidence.v("force")
    other = replace(
        bird,
        upstroke_span_ratio=OTHER_RATIO,
        circulation_ratio=bird.circulation_ratio * bird.upstroke_span_ratio / OTHER_RATIO,
    )

    def wake_force(bird: Bird) -> NDArray[np.float64]:
        # Leader up, follower down: the upstroke's ring is the nearer one.
        return state_forces(bird, bird.stroke, pose_of(row))[UP, DOWN]

    lift, thrust = abs(wake_force(other) / wake_force(bird) - 1.0)
    return {
        "lone bird": 100.0 * abs(other.drag_n / bird.drag_n - 1.0),
        "lift from the wake": float(100.0 * lift),
        "thrust from the wake": float(100.0 * thrust),
    }


def _cost_by_amplitude(evidence: Evidence) -> Cases:
    """Relative slope of the cost in the amplitude, at the leader's stroke."""
    bird = evidence.bird
    lift = bird.lift_n(bird.upstroke_span_ratio)

    def cost(objective: str, factor: float) -> float:
        thrust = bird.thrust_n(factor * bird.amplitude_m, bird.upstroke_span_ratio)
        return COST_FUNCTIONS[objective].value(bird, lift, thrust)

    return {
        objective: (cost(objective, 1.0 + SMALL_CHANGE) / cost(objective, 1.0) - 1.0) / SMALL_CHANGE
        for objective in OBJECTIVES
    }


MEASURES: Measures = {
    "circulation-scaling": _circulation_exponents,
    "passive-upstroke": _passive_upstroke,
    "product-of-R-and-circulation": _same_product,
    "cost-against-amplitude": _cost_by_amplitude,
}
"""Claim -> our value in each case."""
