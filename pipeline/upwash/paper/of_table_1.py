"""Table 1, figure by figure: the leader's column, the follower's, and the ratios printed beside them.

The table is that of least force.  The leader's figures follow from the inputs and are held to the printed digits, the
follower's to 1.5 %: around the optimum the cost is so flat along some directions that more agreement would mean the
same solver, not the same physics.
"""

from __future__ import annotations

from collections.abc import Callable

from upwash.aero.bird import Bird
from upwash.paper.claim import Measure, Measures
from upwash.paper.printed import TABLE_1
from upwash.study.rows import Row


def _leader(ours: Callable[[Bird], float]) -> Measure:
    return lambda evidence: {"leader": ours(evidence.bird)}


def _follower(ours: Callable[[Row], float]) -> Measure:
    return lambda evidence: {"force": float(ours(evidence.v("force")))}


def _ratio(column: str, over: str) -> Measure:
    return _follower(lambda row: row[column] / row[over])


MEASURES: Measures = {
    "table-1-weight": _leader(lambda bird: bird.weight_n),
    "table-1-drag": _leader(lambda bird: bird.drag_n),
    "table-1-leader-h": _leader(lambda bird: bird.amplitude_m),
    "table-1-leader-z": _leader(lambda bird: 0.5 * bird.amplitude_m),
    **{name: _follower(figure.ours) for name, figure in TABLE_1.items()},
    "table-1-z-ratio": _follower(lambda row: 1.0 + row["z_m"] / (0.5 * row["leader_amplitude_m"])),
    "table-1-R-ratio": _ratio("upstroke_span_ratio", "leader_upstroke_span_ratio"),
    "table-1-h-ratio": _ratio("amplitude_m", "leader_amplitude_m"),
    "table-1-lift-ratio": _ratio("lift_self_n", "weight_n"),
    "table-1-thrust-ratio": _ratio("thrust_self_n", "drag_n"),
}
"""Claim -> our value in each case."""
