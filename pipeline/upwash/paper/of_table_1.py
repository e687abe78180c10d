"""Table 1, figure by figure: the leader's column, the follower's, and the ratios printed beside them.

The table is that of least force.  The follower's figures are held to 1.5 %: around the optimum the cost is so flat
along some directions that more agreement would mean the same solver, not the same physics.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from upwash.aero.bird import Bird
from upwash.paper.claim import Cases, Claim, near
from upwash.paper.evidence import Evidence
from upwash.paper.printed import TABLE_1, Printed, Row

FOLLOWER_TOLERANCE = 0.015

_SLUGS = {
    "x_F": "x",
    "y_F": "y",
    "z_F": "z",
    "R_F": "R",
    "h_F": "h",
    "κ_F": "phase",
    "I_z/T": "lift",
    "I_x/T": "thrust",
}
_WHYS = {
    "x_F": "Ours is the least of any V, proved to 1e-4 of its force; why the paper's differs, its text does not tell.",
    "y_F": "Between the three values that the paper prints.",
    "z_F": "Ours is relative to the leader; z_L = h_L/2 is added to compare.",
    "κ_F": "The kink at ½ holds it exactly there.",
    "h_F": "Force hardly depends on amplitude, so that near its least it says little about h.",
    "I_x/T": "The largest difference of the table; it follows from those of h_F and R_F.",
}


@dataclass(frozen=True)
class _Follower:
    """Our value of one figure of the follower's column."""

    ours: Callable[[Row], float]

    def __call__(self, evidence: Evidence) -> Cases:
        return {"force": float(self.ours(evidence.v("force")))}


def _follower(printed: Printed) -> Claim:
    (value,) = printed.values
    tolerance = FOLLOWER_TOLERANCE * value
    return Claim(
        name=f"table-1-{_SLUGS[printed.symbol]}",
        place="Table 1",
        says=f"{printed.symbol}, {printed.quantity}",
        printed=f"{value:.3f}" if value < 1.0 else f"{value:g}",
        unit=printed.unit,
        accepted=near(value, tolerance),
        measure=_Follower(printed.ours),
        why=_WHYS.get(printed.symbol, "The V optimum of least force is the paper's point."),
    )


def _ratio(
    name: str,
    says: str,
    printed: float,
    ours: Callable[[Row], float],
    why: str = "The figure above over the leader's.",
) -> Claim:
    return Claim(
        name=f"table-1-{name}",
        place="Table 1",
        says=says,
        printed=f"{printed:g}",
        unit="",
        accepted=near(printed, FOLLOWER_TOLERANCE * printed),
        measure=_Follower(ours),
        why=why,
    )


def _leader(
    name: str, place: str, says: str, printed: str, unit: str, ours: Callable[[Bird], float]
) -> Claim:
    decimals = len(printed.partition(".")[2])
    return Claim(
        name=f"table-1-{name}",
        place=place,
        says=says,
        printed=printed,
        unit=unit,
        accepted=near(float(printed), 0.5 * 10.0**-decimals),
        measure=lambda evidence: {"leader": ours(evidence.bird)},
        why="To the printed digits; it follows from the inputs alone.",
    )


def _height_ratio(row: Row) -> float:
    return 1.0 + row["z_m"] / (0.5 * row["leader_amplitude_m"])


CLAIMS = (
    _leader("weight", "Table 1; Results", "W, weight of each bird", "12.74", "N", lambda bird: bird.weight_n),
    _leader("drag", "Table 1; Results", "D, drag of each bird", "2.30", "N", lambda bird: bird.drag_n),
    _leader("leader-h", "Table 1", "h_L, leader's amplitude", "1.04", "m", lambda bird: bird.amplitude_m),
    _leader("leader-z", "Table 1", "z_L = h_L/2", "0.520", "m", lambda bird: 0.5 * bird.amplitude_m),
    *map(_follower, TABLE_1),
    _ratio("z-ratio", "z_F/z_L", 0.88, _height_ratio),
    _ratio(
        "R-ratio", "R_F/R_L", 0.87, lambda row: row["upstroke_span_ratio"] / row["leader_upstroke_span_ratio"]
    ),
    _ratio("h-ratio", "h_F/h_L", 0.72, lambda row: row["amplitude_m"] / row["leader_amplitude_m"]),
    _ratio(
        "lift-ratio",
        "share of the weight that the follower lifts itself",
        0.96,
        lambda row: row["lift_self_n"] / row["weight_n"],
    ),
    _ratio(
        "thrust-ratio",
        "share of the drag that the follower's own thrust meets",
        0.83,
        lambda row: row["thrust_self_n"] / row["drag_n"],
        "1.89 N over 2.30 N is 0.82 and not the 0.83 printed; ours is within 1.5 % of that.",
    ),
)
