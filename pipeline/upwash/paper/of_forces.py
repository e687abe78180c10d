"""What the paper says of the wake's force: in each pair of stroke states, and mapped over planes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.induction import velocity
from upwash.aero.interaction import phase_weights, state_circulation_ratio
from upwash.aero.span_integral import span_nodes
from upwash.aero.wake import WakeModel, stroke_height, stroke_span, vortex_wake
from upwash.paper.claim import Cases, Measure, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence
from upwash.study.field import grid

UP, DOWN = 0, 1
LIKE = {"up–up": (UP, UP), "down–down": (DOWN, DOWN)}
UNLIKE = {"up–down": (UP, DOWN), "down–up": (DOWN, UP)}
"""Pairs of stroke states, the leader's first."""

QUARTER = 0.25
"""Height above and below the leader at which the sign of the lift is asked, in h_L."""

STATIONS = {"at λ/4": 0.25, "at λ/2": 0.5, "at 5λ/8": 0.625, "at 3λ/4": 0.75}

LARGE_BENEFIT = 0.5
"""Share of what the wake gives at the optimum that counts as strongly beneficial."""


def _of_pairs(pairs: dict[str, tuple[int, int]]) -> Measure:
    """Wake-induced thrust in some pairs of stroke states."""

    def measure(evidence: Evidence) -> Cases:
        return {
            f"{objective}, {words}": float(evidence.forces[objective][pair][1])
            for objective in OBJECTIVES
            for words, pair in pairs.items()
        }

    return measure


def _weights(evidence: Evidence) -> Cases:
    return {
        f"{objective}, {words}": float(phase_weights(evidence.v(objective)["phase"])[pair])
        for objective in OBJECTIVES
        for words, pair in LIKE.items()
    }


def _from_downstroke_rings(evidence: Evidence) -> Cases:
    """Share of the wake's lift and thrust at the V optimum that rings of downstrokes give, in percent."""
    bird, model, shares = evidence.bird, WakeModel(), {}
    wake = vortex_wake(
        bird.amplitude_m, bird.upstroke_span_ratio, bird.semispan_m, bird.wavelength_m, bird.circulation_m2_s
    )
    nodes, node_weights = span_nodes(model.span_nodes)
    for objective in OBJECTIVES:
        row = evidence.v(objective)
        weights, force = phase_weights(row["phase"]), np.zeros(2)
        for leader, follower in np.ndindex(weights.shape):
            fixed, flexed = stroke_span(follower / 2)
            half_span = bird.semispan_m * (fixed + flexed * row["upstroke_span_ratio"])
            points = np.empty((nodes.size, 3))
            points[:, 0], points[:, 1] = row["x_m"], row["y_m"] + half_span * nodes
            points[:, 2] = row["z_m"] + row["amplitude_m"] * stroke_height(follower / 2)
            shed = wake.only((wake.state == leader) & ~wake.is_upstroke)
            wind = node_weights @ velocity(points, shed.rings, shed.circulation, shed.core_radius)
            own = bird.circulation_m2_s * state_circulation_ratio(bird, follower, 2)
            force += weights[leader, follower] * bird.density_kg_m3 * own * 2.0 * half_span * wind[[0, 2]]
        shares[f"{objective}, lift"] = float(100.0 * force[0] / row["lift_wake_n"])
        shares[f"{objective}, thrust"] = float(100.0 * force[1] / row["thrust_wake_n"])
    return shares


def _thrust_turns(evidence: Evidence) -> Cases:
    """Where, nearest to λ/2, thrust from the wake turns into drag downstream, in wavelengths."""
    stations = np.linspace(0.3, 0.7, 401)
    places = {}
    for objective in OBJECTIVES:
        height = [evidence.v(objective)["z_m"]]
        _, thrust = evidence.wake_over(objective, "xz", stations * evidence.bird.wavelength_m, height)
        places[objective] = _nearest_fall(stations, thrust[0], 0.5)
    return places


def _lift_turns(evidence: Evidence) -> Cases:
    """Where at x = λ/2, nearest to the leader's height, lift from the wake turns downward below, in h_L."""
    heights = np.linspace(-1.0, 1.0, 401)
    places = {}
    for objective in OBJECTIVES:
        half = [0.5 * evidence.bird.wavelength_m]
        lift, _ = evidence.wake_over(objective, "xz", half, heights * evidence.bird.amplitude_m)
        places[objective] = _nearest_fall(heights, -lift[:, 0], 0.0)
    return places


def _nearest_fall(where: NDArray[np.float64], values: NDArray[np.float64], to: float) -> float:
    """Return where values fall through zero nearest to a place, interpolated; NaN if nowhere."""
    at = np.flatnonzero((values[:-1] > 0.0) & (values[1:] <= 0.0))
    zeros = where[at] + (where[at + 1] - where[at]) * values[at] / (values[at] - values[at + 1])
    return float(zeros[np.argmin(np.abs(zeros - to))]) if at.size else np.nan


def _lift_above_and_below(evidence: Evidence) -> Cases:
    """At x = λ/2, lift a quarter amplitude above the leader, and downward force as far below, in N."""
    away = QUARTER * evidence.bird.amplitude_m
    lift, _ = evidence.wake_over(evidence.mapped, "xz", [0.5 * evidence.bird.wavelength_m], [away, -away])
    return {"up, above": float(lift[0, 0]), "down, below": -float(lift[1, 0])}


def _forward_and_down(evidence: Evidence) -> Cases:
    """At y = 0, the lesser of the wake's forward and downward force, in N; both are so where it is positive."""
    stations = np.array(list(STATIONS.values())) * evidence.bird.wavelength_m
    lift, thrust = evidence.wake_over(evidence.mapped, "xy", stations, [0.0])
    return dict(zip(STATIONS, np.minimum(-lift[0], thrust[0]).tolist(), strict=True))


def _overlap(evidence: Evidence) -> Cases:
    """Points of each map where the wake gives lift and thrust, over those where it gives either."""
    shares = {}
    for plane, ratios in evidence.maps.items():
        lifts, pulls = ratios.lift > ratios.own_lift, ratios.thrust > ratios.own_thrust
        shares[plane] = float((lifts & pulls).sum() / (lifts | pulls).sum())
    return shares


def _overlap_at_the_optimum(evidence: Evidence) -> Cases:
    """What the wake gives of both lift and thrust at the optimum, over the most anywhere in its level plane.

    Of the two that which is the lesser share of what is needed counts; at the optimum, in balance, both are 1.
    """
    ratios = evidence.maps["xy"]
    lifts = (ratios.lift - ratios.own_lift) / (1.0 - ratios.own_lift)
    pulls = (ratios.thrust - ratios.own_thrust) / (1.0 - ratios.own_thrust)
    return {"xy": 1.0 / max(1.0, float(np.minimum(lifts, pulls).max()))}


def _in_path(evidence: Evidence) -> Cases:
    """Share of the points of the plane of distance and phase where the wake pulls much that have κ near x/λ."""
    ratios = evidence.maps["xk"]
    pulls = ratios.thrust - ratios.own_thrust > LARGE_BENEFIT * (1.0 - ratios.own_thrust)
    x_m, phase = grid(evidence.bird, "xk", pulls.shape[0])
    off = (x_m[None, :] / evidence.bird.wavelength_m - phase[:, None] + 0.5) % 1.0 - 0.5
    return {"xk": float((pulls & (np.abs(off) <= QUARTER)).sum() / pulls.sum())}


def _strongly_beneficial(evidence: Evidence) -> Cases:
    """Share of each map in which the wake gives much of both lift and thrust, in percent."""
    shares = {}
    for plane, ratios in evidence.maps.items():
        lifts = ratios.lift - ratios.own_lift > LARGE_BENEFIT * (1.0 - ratios.own_lift)
        pulls = ratios.thrust - ratios.own_thrust > LARGE_BENEFIT * (1.0 - ratios.own_thrust)
        shares[plane] = float(100.0 * np.mean(lifts & pulls))
    return shares


def _lowest(quantity: str) -> Measure:
    def measure(evidence: Evidence) -> Cases:
        return {
            "all maps": 100.0
            * min(float(getattr(ratios, quantity).min()) for ratios in evidence.maps.values())
        }

    return measure


MEASURES: Measures = {
    "like-states-weightless": _weights,
    "like-states-drag": _of_pairs(LIKE),
    "unlike-states-thrust": _of_pairs(UNLIKE),
    "downstroke-wake-dominates": _from_downstroke_rings,
    "thrust-map-minimum": _lowest("thrust"),
    "lift-map-minimum": _lowest("lift"),
    "thrust-varies-more": lambda evidence: {
        plane: float(np.ptp(ratios.thrust) / np.ptp(ratios.lift)) for plane, ratios in evidence.maps.items()
    },
    "benefits-do-not-coincide": _overlap,
    "optimum-in-the-overlap": _overlap_at_the_optimum,
    "favourable-band": _in_path,
    "strong-benefit-is-rare": _strongly_beneficial,
    "behind-the-leader": _forward_and_down,
    "lift-above-and-below": _lift_above_and_below,
    "lift-changes-sign": _lift_turns,
    "thrust-changes-sign": _thrust_turns,
    "optimum-upstream-of-the-change": lambda evidence: {
        objective: place - float(evidence.v(objective)["x_wavelengths"])
        for objective, place in _thrust_turns(evidence).items()
    },
    "balance-at-the-optimum": lambda evidence: {
        f"{objective}, {words}": float(evidence.v(objective)[column])
        for objective in OBJECTIVES
        for words, column in (("lift", "residual_lift"), ("thrust", "residual_thrust"))
    },
}
"""Claim -> our value in each case."""

FACTS: Measures = {
    "like-states-drag": lambda evidence: {
        "share": -100.0 * float(evidence.forces["force"][DOWN, DOWN][1]) / evidence.bird.drag_n
    },
}
"""Claim -> other numbers of ours that its reason names."""
