"""The paper against itself: what its own printed figures say of one another, and of its model.

Here ours are not optima of ours but what the paper's formulas make of the paper's figures.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from upwash.aero.interaction import net_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS, induced_power_w
from upwash.paper.claim import Cases, Measures
from upwash.paper.evidence import Evidence
from upwash.paper.printed import PRINTED_VARIOUSLY, TABLE_1

_TABLE = {name.removeprefix("table-1-"): figure.values[0] for name, figure in TABLE_1.items()}
_VARIOUS = {name: figure.values for name, figure in PRINTED_VARIOUSLY.items()}

HEIGHT_OF_LEADER_M = 0.520
"""z_L as Table 1 prints it."""

# Half of the last printed digit of x, y, z - z_L, h, R and the phase.
ROUNDING = (0.005, 0.0005, 0.001, 0.0005, 0.0005, 0.0005)


def _corners() -> np.ndarray:
    """Corners of the box of values that round to Table 1, x, y, z, h, R and phase, and its centre."""
    centre = [_TABLE[name] for name in ("x", "y", "z", "h", "R", "phase")]
    centre[2] -= HEIGHT_OF_LEADER_M
    signs = np.array([*product((-1.0, 1.0), repeat=6), (0.0,) * 6])
    return np.array(centre) + signs * np.array(ROUNDING)


def _balance_of_table_1(evidence: Evidence) -> Cases:
    """Largest net force over what is needed that the rounding of Table 1 allows."""
    bird = evidence.bird
    poses = [Pose(x, y, z, Stroke(h, r), k) for x, y, z, h, r, k in _corners()]
    forces = np.array([net_force(bird, bird.stroke, pose, evidence.model) for pose in poses])
    lift, thrust = np.max(forces / [bird.weight_n, bird.drag_n], axis=0)
    return {"lift": float(lift), "thrust": float(thrust)}


def _cost_of_table_1(evidence: Evidence) -> Cases:
    """Force of a stroke that rounds to Table 1, at most, over what is proved of any V, less 1, in percent."""
    bird, cost = evidence.bird, COST_FUNCTIONS["force"]
    row = evidence.v("force") if evidence.has_v("force") else evidence.best("force")
    costs = [
        cost.value(bird, bird.lift_n(corner[4]), bird.thrust_n(corner[3], corner[4])) for corner in _corners()
    ]
    return {"force": 100.0 * (max(costs) / float(row["v_lower_bound"]) - 1.0)}


def _force_of_table_1(evidence: Evidence) -> Cases:
    """Forces that the paper's formulas make of its own h_F and R_F, over those it prints, less 1, in percent."""
    bird = evidence.bird
    lift, thrust = bird.lift_n(_TABLE["R"]), bird.thrust_n(_TABLE["h"], _TABLE["R"])
    return {
        "lift": 100.0 * (lift / _TABLE["lift"] - 1.0),
        "thrust": 100.0 * (thrust / _TABLE["thrust"] - 1.0),
    }


def _saving_of_table_1(evidence: Evidence) -> Cases:
    """Savings that follow from Table 1's own h_F and R_F less each one printed, in points."""
    bird = evidence.bird
    induced = 1.0 - induced_power_w(bird, bird.lift_n(_TABLE["R"])) / induced_power_w(bird, bird.weight_n)
    profile = 1.0 - bird.thrust_n(_TABLE["h"], _TABLE["R"]) / bird.drag_n
    return {
        f"{part} {printed:g} %": 100.0 * saving - printed
        for part, saving in (("induced", induced), ("profile", profile))
        for printed in _VARIOUS[part]
    }


MEASURES: Measures = {
    "print-y": lambda evidence: {"spread": float(np.ptp(_VARIOUS["y"]))},
    "print-savings": _saving_of_table_1,
    "print-forces": _force_of_table_1,
    "print-balance": _balance_of_table_1,
    "print-attainable": _cost_of_table_1,
}
"""Claim -> our value in each case."""
