"""The paper against itself: what its own printed figures say of one another, and of its model.

Here ours are not optima of ours but what the paper's formulas make of the paper's figures.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from upwash.aero.interaction import net_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS, induced_power_w
from upwash.paper.claim import Cases, Claim, at_least, at_most, near
from upwash.paper.evidence import Evidence
from upwash.paper.printed import PRINTED_VARIOUSLY, TABLE_1

_TABLE = {one.symbol: one.values[0] for one in TABLE_1}
_VARIOUS = {one.symbol: one.values for one in PRINTED_VARIOUSLY}

HEIGHT_OF_LEADER_M = 0.520
"""z_L as Table 1 prints it."""

# Half of the last printed digit of x, y, z - z_L, h, R and the phase.
ROUNDING = (0.005, 0.0005, 0.001, 0.0005, 0.0005, 0.0005)


def _corners() -> np.ndarray:
    """Corners of the box of values that round to Table 1, x, y, z, h, R and phase, and its centre."""
    table = _TABLE
    centre = [
        table["x_F"],
        table["y_F"],
        table["z_F"] - HEIGHT_OF_LEADER_M,
        table["h_F"],
        table["R_F"],
        table["κ_F"],
    ]
    signs = np.array([*product((-1.0, 1.0), repeat=6), (0.0,) * 6])
    return np.array(centre) + signs * np.array(ROUNDING)


def _balance_of_table_1(evidence: Evidence) -> Cases:
    """Largest net force over what is needed that the rounding of Table 1 allows."""
    bird = evidence.bird
    poses = [Pose(x, y, z, Stroke(h, r), k) for x, y, z, h, r, k in _corners()]
    forces = np.array([net_force(bird, bird.stroke, pose) for pose in poses])
    lift, thrust = np.max(forces / [bird.weight_n, bird.drag_n], axis=0)
    return {"lift": float(lift), "thrust": float(thrust)}


def _cost_of_table_1(evidence: Evidence) -> Cases:
    """Force of a stroke that rounds to Table 1, at most, over what is proved of any V, less 1, in percent."""
    bird, cost = evidence.bird, COST_FUNCTIONS["force"]
    costs = [cost.value(bird, bird.lift_n(one[4]), bird.thrust_n(one[3], one[4])) for one in _corners()]
    return {"force": 100.0 * (max(costs) / float(evidence.v("force")["v_lower_bound"]) - 1.0)}


def _force_of_table_1(evidence: Evidence) -> Cases:
    """Forces that the paper's formulas make of its own h_F and R_F, over those it prints, less 1, in percent."""
    bird = evidence.bird
    lift, thrust = bird.lift_n(_TABLE["R_F"]), bird.thrust_n(_TABLE["h_F"], _TABLE["R_F"])
    return {
        "lift": 100.0 * (lift / _TABLE["I_z/T"] - 1.0),
        "thrust": 100.0 * (thrust / _TABLE["I_x/T"] - 1.0),
    }


def _saving_of_table_1(evidence: Evidence) -> Cases:
    """Savings that follow from Table 1's own h_F and R_F less each one printed, in points."""
    bird = evidence.bird
    induced = 1.0 - induced_power_w(bird, bird.lift_n(_TABLE["R_F"])) / induced_power_w(bird, bird.weight_n)
    profile = 1.0 - bird.thrust_n(_TABLE["h_F"], _TABLE["R_F"]) / bird.drag_n
    ours = {"P_ind": ("induced", 100.0 * induced), "P_pro": ("profile", 100.0 * profile)}
    return {
        f"{words} {printed:g} %": value - printed
        for symbol, (words, value) in ours.items()
        for printed in _VARIOUS[symbol]
    }


CLAIMS = (
    Claim(
        "print-y",
        "Table 1 (0.882); Optimal spanwise spacing (0.877, 0.886)",
        "the y_F of Table 1 is that of the text",
        "0.882, 0.877 and 0.886",
        "m",
        at_most(0.001),
        lambda evidence: {"spread": float(np.ptp(_VARIOUS["y_F"]))},
        "One number is printed three times with three values; ours lies among them.",
    ),
    Claim(
        "print-savings",
        "Power reduction (9 and 18 %); Discussion (8 and 17 %)",
        "the printed savings are those of Table 1's own stroke",
        "9 and 8; 18 and 17",
        "points",
        near(0.0, 0.5),
        _saving_of_table_1,
        "Table 1's h_F and R_F give 8.8 and 17.8 %: 9 and 18 are rounded, 8 and 17 cut off.",
    ),
    Claim(
        "print-forces",
        "Table 1",
        "the printed forces are those of the printed stroke",
        "12.17 and 1.89 N",
        "%",
        near(0.0, 0.5),
        _force_of_table_1,
        "By the impulse formulas.",
    ),
    Claim(
        "print-balance",
        "Table 1; Fig. 4",
        "Table 1's point balances lift and thrust",
        "F_z/W = F_x/D = 1",
        "",
        at_least(1.0),
        _balance_of_table_1,
        "Net force over what is needed, the largest that the rounding of Table 1's digits allows: the point as printed "
        "falls a little short of both.",
    ),
    Claim(
        "print-attainable",
        "Table 1",
        "some V formation can fly with Table 1's stroke",
        "the optimum",
        "%",
        at_least(0.0),
        _cost_of_table_1,
        "Its force is below what is proved to be the least of any V in the model as stated: the paper's code differs "
        "from its text, or its solver ended short of balance.",
    ),
)
