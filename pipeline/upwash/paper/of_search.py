"""What the paper says of its minimum: that it is global, and reached from anywhere."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.optimum.problem import PairProblem
from upwash.paper.claim import Cases, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence
from upwash.paper.single_start import paper_start, solve_from, spread_starts

STARTS = 60
SEED = 0

SAME_COST, SAME_PLACE_M = 0.01, 0.05
"""An end is the V optimum if its cost is within one percent and its position within five centimetres."""

# The bound μ ≥ 0 is the fold of the phase, not a limit that someone chose.
FOLD = "mu_lower"


def _over_global(evidence: Evidence) -> Cases:
    """Cost of the V optimum over that of the best optimum found, less 1, in percent."""
    return {
        objective: 100.0 * (evidence.v(objective)["cost"] / evidence.best(objective)["cost"] - 1.0)
        for objective in OBJECTIVES
    }


def _bounds_met(evidence: Evidence) -> Cases:
    """Number of search bounds that the V optimum lies on."""
    met = {}
    for objective in OBJECTIVES:
        names = str(evidence.v(objective)["active_bounds"] or "").split(",")
        count = float(len([name for name in names if name and name != FOLD]))
        met[objective] = count if evidence.has_v(objective) else np.nan
    return met


@cache
def _ends(bird: Bird, objective: str) -> tuple[pd.DataFrame, float]:
    """Ends of single runs: of those from spread starts, and the cost of the one from the paper's start."""
    problem = PairProblem(bird, objective)
    ends = [solve_from(problem, start) for start in spread_starts(problem, STARTS, SEED)]
    rows = [
        [*(end.point[:3] * bird.semispan_m), end.cost * problem.leader_cost]
        for end in ends
        if end.is_balanced
    ]
    own = solve_from(problem, paper_start(problem))
    cost = own.cost * problem.leader_cost if own.is_balanced else np.inf
    return pd.DataFrame(rows, columns=["x_m", "y_m", "z_m", "cost"]), cost


def _reached(evidence: Evidence) -> Cases:
    """Share of the spread starts from which a single run ends at the V optimum, in percent."""
    shares = {}
    for objective in OBJECTIVES:
        row, (ends, _) = evidence.v(objective), _ends(evidence.bird, objective)
        place = ["x_m", "y_m", "z_m"]
        is_near = (ends[place] - [row[axis] for axis in place]).abs().max(axis=1) < SAME_PLACE_M
        is_as_good = (ends["cost"] / row["cost"] - 1.0).abs() < SAME_COST
        shares[objective] = float(100.0 * (is_near & is_as_good).sum() / STARTS)
    return shares


def _from_paper_start(evidence: Evidence) -> Cases:
    """Cost at which a run from the paper's start ends over that of the V optimum, less 1, in percent."""
    return {
        objective: 100.0 * (_ends(evidence.bird, objective)[1] / evidence.v(objective)["cost"] - 1.0)
        for objective in OBJECTIVES
    }


MEASURES: Measures = {
    "minimum-is-global": _over_global,
    "robust-to-bounds": _bounds_met,
    "robust-to-starts": _reached,
    "printed-start": _from_paper_start,
}
"""Claim -> our value in each case."""

FACTS: Measures = {
    "robust-to-starts": lambda _: {"starts": STARTS},
}
"""Claim -> other numbers of ours that its reason names."""
