"""What the paper says of the best airspeed of a group, from the pair solved at several airspeeds.

Lower means by more than the interpolation between the solved airspeeds can err, a hundredth.
"""

from __future__ import annotations

from upwash.paper.claim import Cases, Measure, Measures
from upwash.paper.evidence import Evidence
from upwash.study.airspeed import best_speed


def _speeds(evidence: Evidence, per_metre: bool) -> dict[str, tuple[float, float]]:
    """Return the best airspeed of the follower and that of the lone bird, in m/s, for each label."""
    assert evidence.speeds is not None
    speeds = {}
    for words, label in (("V optimum", "is_v_optimum"), ("global optimum", "is_global_optimum")):
        rows = evidence.speeds[evidence.speeds[label].eq(True)].sort_values("speed_m_s")
        speed = rows["speed_m_s"].to_numpy(float)
        unit = speed if per_metre else 1.0
        own, alone = (
            best_speed(speed, rows[column].to_numpy(float) / unit)
            for column in ("power_total_w", "leader_power_total_w")
        )
        speeds[words] = own, alone
    return speeds


def _over_alone(per_metre: bool) -> Measure:
    """Best airspeed of the follower over that of the lone bird."""
    return lambda evidence: {
        words: own / alone for words, (own, alone) in _speeds(evidence, per_metre).items()
    }


def _in_m_s(per_metre: bool) -> Measure:
    """Best airspeeds of the lone bird and of one in a V, and the slowest that was solved, in m/s."""

    def measure(evidence: Evidence) -> Cases:
        assert evidence.speeds is not None
        own, alone = _speeds(evidence, per_metre)["V optimum"]
        return {"V": own, "alone": alone, "slowest": float(evidence.speeds["speed_m_s"].min())}

    return measure


MEASURES: Measures = {
    "group-speed-of-least-power": _over_alone(per_metre=False),
    "group-speed-of-least-energy": _over_alone(per_metre=True),
}
"""Claim -> our value in each case."""

FACTS: Measures = {
    "group-speed-of-least-power": _in_m_s(per_metre=False),
    "group-speed-of-least-energy": _in_m_s(per_metre=True),
}
"""Claim -> other numbers of ours that its reason names."""
