"""One job's search, complete: starts, basins, the proof for the whole and for the V, and what the proof turns up.

Random starts find the basins; branch and bound then either clears everything below the best, or meets something better,
which becomes a start and the proof begins again.  The V optimum is the best *local optimum of the whole problem* that is
outboard, level and astern; the region's own best point may instead lie on one of its walls, which is then named.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.aero.bird import Bird
from pipeline.aero.wake import WakeModel
from pipeline.optimum.certify import MOST_BOXES, certify
from pipeline.optimum.evidence import Evidence, gather_evidence
from pipeline.optimum.problem import VARIABLES, PairProblem
from pipeline.optimum.search import Basin, Search
from pipeline.optimum.solution import V_LABELS, PairSolution, Proof, describe_optimum, labels

STARTS = 120
V_STARTS = 60
MOST_PROOFS = 8
"""Proofs tried in turn when each meets something better than the last one's best."""

STATIONARY = 1e-6
LEAST_CURVATURE = -1e-6
"""An end of a local solve counts as an optimum if it is as stationary, and no more concave, than this."""


@dataclass(frozen=True)
class _Region:
    """What a proof says of a region: bound, cost of the best point known in it, that point, boxes, closure."""

    lower_bound: float
    best: Basin | None
    boxes: int
    is_closed: bool


def solve_pair(
    bird: Bird,
    objective: str = "force",
    *,
    leader_amplitude_m: float | None = None,
    leader_upstroke_span_ratio: float | None = None,
    amplitude_limit_m: float | None = None,
    model: WakeModel | None = None,
    seed: int = 0,
    tolerance: float = 1e-4,
    starts: int = STARTS,
    most_boxes: int = MOST_BOXES,
) -> PairSolution:
    """Find where and how a follower should fly behind a leader, with all other optima, and prove the best.

    Parameters
    ----------
    bird : Bird
        The bird; in a flock the first one, which sets weight, drag and circulation.
    objective : str
        Name of a cost function.
    leader_amplitude_m, leader_upstroke_span_ratio : float, optional
        Stroke of the bird immediately ahead; the bird's own if not given.
    amplitude_limit_m : float, optional
        Largest amplitude of the follower; that of the bird immediately ahead if not given.
    model : WakeModel, optional
        Resolution of the wake; must have two stroke states.
    seed : int
        Seed of the random starts.
    tolerance : float
        Gap to which the best is to be proved.
    starts : int
        Random starts over the whole problem; half as many are added within the V region.
    most_boxes : int
        Budget of boxes of each proof.

    Returns
    -------
    PairSolution
        The optima, best first, and the proof.

    Raises
    ------
    ValueError
        If an input is out of range; the message names it.
    """
    begun = time.perf_counter()
    model = model or WakeModel()
    if model.stroke_states != 2:
        raise ValueError(
            f"stroke_states: expected 2, the states in which optima can be searched and proved, "
            f"found {model.stroke_states}"
        )
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: expected a number between 0 and 1, found {tolerance!r}")
    problem = PairProblem(
        bird, objective, leader_amplitude_m, leader_upstroke_span_ratio, amplitude_limit_m, model
    )
    search = Search(problem)
    v_bounds = problem.v_bounds()
    has_v_region = bool(np.all(v_bounds[:, 0] <= v_bounds[:, 1]))
    search.explore(search.random_starts(problem.bounds, starts, seed))
    wall: Basin | None = None
    if has_v_region:
        v_starts = search.random_starts(v_bounds, max(1, starts // 2), seed + 1)
        within = search.descend(v_starts, v_bounds)
        search.explore(v_starts)
        wall = within[0] if within else None

    v_region = _prove(search, v_bounds, wall, tolerance, most_boxes)
    whole = _prove(search, problem.bounds, None, tolerance, most_boxes)
    evidence = {
        id(basin): gather_evidence(problem, search.group, search.representative, basin.point)
        for basin in search.basins
    }
    optima = [basin for basin in search.basins if _is_optimum(evidence[id(basin)])]
    v_best = next((basin for basin in optima if labels(problem, *basin.point[:3]) == V_LABELS), None)
    described = tuple(
        describe_optimum(
            problem,
            basin,
            evidence[id(basin)],
            [tuple(search.representative[edge]) for edge in evidence[id(basin)].core_edges],
            rank=rank,
            starts=search.starts,
            is_v_optimum=basin is v_best,
        )
        for rank, basin in enumerate(optima)
    )
    unit = problem.leader_cost
    proof = Proof(
        v_lower_bound=v_region.lower_bound * unit,
        v_certified_gap=v_best.cost / v_region.lower_bound - 1.0 if v_best else None,
        global_lower_bound=whole.lower_bound * unit,
        global_certified_gap=optima[0].cost / whole.lower_bound - 1.0 if optima else None,
        certificate_boxes=v_region.boxes + whole.boxes,
        v_wall=_walls(v_region.best, v_best, v_bounds, problem.bounds),
        feasible=bool(optima),
        is_closed=v_region.is_closed and whole.is_closed,
    )
    status = "solved" if optima else "infeasible"
    return PairSolution(status, described, proof, time.perf_counter() - begun)


def _is_optimum(evidence: Evidence) -> bool:
    is_convex = evidence.curvature is None or evidence.curvature > LEAST_CURVATURE
    return evidence.stationarity < STATIONARY and is_convex


def _prove(
    search: Search,
    bounds: NDArray[np.float64],
    best_on_wall: Basin | None,
    tolerance: float,
    most_boxes: int,
) -> _Region:
    """Prove the best point of a region; whatever better the proof meets is a start for all basins."""
    best = best_on_wall
    for basin in search.basins:
        inside = np.all((basin.point >= bounds[:, 0]) & (basin.point <= bounds[:, 1]))
        if inside and (best is None or basin.cost < best.cost):
            best = basin
    boxes = 0
    for _ in range(MOST_PROOFS):
        certificate = certify(
            search.problem,
            search.group,
            search.representative,
            bounds,
            best.cost if best else math.inf,
            tolerance,
            most_boxes,
        )
        boxes += certificate.boxes
        if certificate.found is None:
            break
        starts = certificate.found[None, :]
        search.explore(starts)
        improved = search.descend(starts, bounds)
        if not improved or (best is not None and improved[0].cost >= best.cost):
            break
        best = improved[0]
        if certificate.is_closed:
            break
    return _Region(certificate.lower_bound, best, boxes, certificate.is_closed)


def _walls(
    region_best: Basin | None,
    v_best: Basin | None,
    v_bounds: NDArray[np.float64],
    bounds: NDArray[np.float64],
) -> str:
    """Name the walls of the V region on which its best point lies, if that is better than the V optimum."""
    if region_best is None or (v_best is not None and v_best.cost <= region_best.cost * (1.0 + 1e-9)):
        return ""
    named = []
    for name, value, own, whole in zip(VARIABLES, region_best.point, v_bounds, bounds, strict=True):
        for side, word in ((0, "lower"), (1, "upper")):
            if own[side] != whole[side] and abs(value - own[side]) < 1e-9:
                named.append(f"{name}_{word}")
    return ",".join(named)
