"""What the paper says of power saved, and of what the bird changes in its stroke to save it.

Savings and reductions are held to a percentage point: Table 1's 1.5 % in thrust is 1.2 points of the drag.
"""

from __future__ import annotations

from upwash.paper.claim import Cases, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence


def _reductions(evidence: Evidence) -> Cases:
    """Reduction of the amplitude less that of the upstroke span ratio, in points."""
    return {
        objective: 100.0 * float(row["amplitude_reduction"] - row["span_ratio_reduction"])
        for objective, row in ((objective, evidence.v(objective)) for objective in OBJECTIVES)
    }


def _flexion_added(evidence: Evidence) -> Cases:
    """Part of its span by which the follower draws in its wings on the upstroke, less the leader's."""
    rows = {objective: evidence.v(objective) for objective in OBJECTIVES}
    return {
        objective: float(row["leader_upstroke_span_ratio"] - row["upstroke_span_ratio"])
        for objective, row in rows.items()
    }


MEASURES: Measures = {
    "leader-power": lambda evidence: {"leader": float(evidence.v(evidence.mapped)["leader_power_total_w"])},
    "follower-power": lambda evidence: evidence.of_v("power_total_w"),
    "saving-total": lambda evidence: evidence.of_v("saving_total", 100.0),
    "saving-induced": lambda evidence: evidence.of_v("saving_induced", 100.0),
    "saving-profile": lambda evidence: evidence.of_v("saving_profile", 100.0),
    "saving-as-observed": lambda evidence: evidence.of_v("saving_total", 100.0),
    "both-powers-fall": lambda evidence: {
        f"{objective}, {part}": 100.0 * float(evidence.v(objective)[f"saving_{part}"])
        for objective in OBJECTIVES
        for part in ("induced", "profile")
    },
    "profile-dominates": lambda evidence: evidence.of_v("profile_share"),
    "amplitude-reduction": lambda evidence: evidence.of_v("amplitude_reduction", 100.0),
    "span-ratio-reduction": lambda evidence: evidence.of_v("span_ratio_reduction", 100.0),
    "amplitude-before-flexion": _reductions,
    "flexion-reduced": _flexion_added,
}
"""Claim -> our value in each case."""
