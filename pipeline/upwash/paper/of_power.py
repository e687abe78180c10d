"""What the paper says of power saved, and of what the bird changes in its stroke to save it."""

from __future__ import annotations

from upwash.paper.claim import Cases, Claim, at_least, at_most, between, near
from upwash.paper.evidence import OBJECTIVES, Evidence

A_POINT = 1.0
"""Tolerance of a saving, in percentage points: Table 1's 1.5 % in thrust is 1.2 points of the drag."""


def _reductions(evidence: Evidence) -> Cases:
    """Reduction of the amplitude less that of the upstroke span ratio, in points."""
    return {
        objective: 100.0 * float(row["amplitude_reduction"] - row["span_ratio_reduction"])
        for objective, row in ((one, evidence.v(one)) for one in OBJECTIVES)
    }


def _flexion_added(evidence: Evidence) -> Cases:
    """Part of its span by which the follower draws in its wings on the upstroke, less the leader's."""
    rows = {objective: evidence.v(objective) for objective in OBJECTIVES}
    return {
        one: float(row["leader_upstroke_span_ratio"] - row["upstroke_span_ratio"])
        for one, row in rows.items()
    }


CLAIMS = (
    Claim(
        "leader-power",
        "Power reduction via formation flight",
        "P_L, total power of the leader",
        "60",
        "W",
        near(60.0, 0.5),
        lambda evidence: {"leader": float(evidence.v("force")["leader_power_total_w"])},
        "Induced, profile and parasite power of the lone bird.",
    ),
    Claim(
        "follower-power",
        "Power reduction via formation flight",
        "P_F, total power of the follower",
        "53",
        "W",
        near(53.0, 0.5),
        lambda evidence: evidence.of_v("power_total_w"),
        "With least force; minimising power itself gives {power:.1f} W.",
    ),
    Claim(
        "saving-total",
        "Abstract; Power reduction; Discussion",
        "the follower's total power is 11 % less",
        "11",
        "%",
        near(11.0, A_POINT),
        lambda evidence: evidence.of_v("saving_total", 100.0),
        "With least force; minimising power itself saves {power:.1f} %.",
    ),
    Claim(
        "saving-induced",
        "Power reduction (9 %); Discussion (8 %)",
        "its induced power is 8 or 9 % less",
        "8 and 9",
        "%",
        between(8.0, 9.0, A_POINT),
        lambda evidence: evidence.of_v("saving_induced", 100.0),
        "With least force; with least power {power:.1f} %.",
    ),
    Claim(
        "saving-profile",
        "Power reduction (18 %); Discussion (17 %)",
        "its profile power is 17 or 18 % less",
        "17 and 18",
        "%",
        between(17.0, 18.0, A_POINT),
        lambda evidence: evidence.of_v("saving_profile", 100.0),
        "With least force; with least power {power:.1f} %.",
    ),
    Claim(
        "saving-as-observed",
        "Power reduction; Discussion",
        "the saving is within the 10 to 15 % reported of geese and pelicans",
        "10 to 15",
        "%",
        between(10.0, 15.0),
        lambda evidence: evidence.of_v("saving_total", 100.0),
        "With least force; least power saves more than was reported. Reported numbers are of other species, and of "
        "metabolism.",
    ),
    Claim(
        "both-powers-fall",
        "Power reduction; Abstract",
        "both induced and profile power fall",
        "both channels",
        "%",
        at_least(0.0),
        lambda evidence: {
            f"{objective}, {part}": 100.0 * float(evidence.v(objective)[f"saving_{part}"])
            for objective in OBJECTIVES
            for part in ("induced", "profile")
        },
        "Saving of each.",
    ),
    Claim(
        "profile-dominates",
        "Abstract; Power reduction; Discussion",
        "most of the power saved is profile power",
        "dominated",
        "share",
        at_least(0.5),
        lambda evidence: evidence.of_v("profile_share"),
        "Profile power saved over all power saved; profile power also falls by the larger fraction of itself.",
    ),
    Claim(
        "amplitude-reduction",
        "Power reduction; Table 1",
        "the follower flaps 28 % less far",
        "28",
        "%",
        near(28.0, A_POINT),
        lambda evidence: evidence.of_v("amplitude_reduction", 100.0),
        "With least force; with least power {power:.0f} %.",
    ),
    Claim(
        "span-ratio-reduction",
        "Power reduction; Table 1",
        "its upstroke span ratio is 13 % less",
        "13",
        "%",
        near(13.0, A_POINT),
        lambda evidence: evidence.of_v("span_ratio_reduction", 100.0),
        "With least force; with least power {power:.0f} %.",
    ),
    Claim(
        "amplitude-before-flexion",
        "Abstract; Power reduction; Discussion",
        "the amplitude is reduced more than the upstroke span ratio",
        "28 against 13",
        "points",
        at_least(0.0),
        _reductions,
        "Reduction of h less that of R.",
    ),
    Claim(
        "flexion-reduced",
        "Abstract; Discussion",
        "the follower flexes its wings less on the upstroke",
        "reduced upstroke flexion",
        "of the span",
        at_most(0.0),
        _flexion_added,
        "R is the span that is left: a lesser R is a wing flexed more, by {force:.2f} of its span with least force. It "
        "lowers lift and raises thrust, so that the amplitude can fall further.",
    ),
)
