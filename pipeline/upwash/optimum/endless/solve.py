"""One follower behind an endless wake, solved completely: starts, basins, the proof for the whole and for the V.

A wingbeat in steps leaves ripples on the cost: small optima, each held by a step of the wing on the core of a spanwise
filament, that vanish as the steps are made finer.  They are optima of the model as it is posed and are told as such,
but one that leaves the V when the steps are made finer is held there by the steps, and is no V optimum.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import HEIGHT
from upwash.optimum.certify import DEPTH, SEARCH_EVERY, UNREACHABLE_COST, Certificate
from upwash.optimum.compiled.endless_boxes import clear_endless_boxes
from upwash.optimum.compiled.relaxation import Limits
from upwash.optimum.core_edge import BOTH, TURN, CoreEdge
from upwash.optimum.endless.evidence import gather_endless_evidence
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import SHARE, EndlessSearch
from upwash.optimum.evidence import Evidence, StatedEvidence
from upwash.optimum.pieces import LEAST_CURVATURE, MOST_PROOFS, STATIONARY
from upwash.optimum.proof import Proof
from upwash.optimum.record import V_LABELS, labels
from upwash.optimum.search import Basin
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import Optimum, PairSolution, record_in
from upwash.optimum.variables import VARIABLE_COUNT, VARIABLES

FINER = 4
"""How many times as many steps a V optimum must stand."""

LOOSER = 1.01
"""By how much the limit of the amplitude is then raised: a stroke just below it may be just above it in finer steps."""

SAME_COST = 1e-10
"""Costs that differ by no more than this share are one."""


def solve_endless_pair(problem: EndlessProblem, settings: SearchSettings) -> PairSolution:
    """Solve one follower's problem behind an endless wake.

    Parameters
    ----------
    problem : EndlessProblem
        The problem.
    settings : SearchSettings
        How long to search, and how closely to prove.

    Returns
    -------
    PairSolution
        The optima, best first, and the proof.
    """
    begun = time.perf_counter()
    search = EndlessSearch(problem, settings.seed)
    share, v_bounds = max(1, round(SHARE * settings.starts)), problem.v_bounds()
    search.explore_places(share)
    in_v: list[Basin] = []
    if np.all(v_bounds[:, 0] <= v_bounds[:, 1]):
        in_v = search.descend(search.random_starts(v_bounds, share), v_bounds)
        search.explore(np.array([basin.point for basin in in_v]).reshape(-1, VARIABLE_COUNT))
    search.explore_around_best()
    whole = _prove(search, problem.bounds, [], settings)
    v_region = _prove(search, v_bounds, in_v, settings, whole)
    optima = _optima(search)
    v_best = next(
        (one for one in optima if _is_in_v(problem, one[0]) and stays_in_v(problem, one[0].point)), None
    )
    unit = problem.leader_cost
    v_wall = _walls(v_region, v_best[0] if v_best else None, v_bounds, problem.bounds)
    v_gap = v_best[0].cost / v_region.lower_bound - 1.0 if v_best else None
    # Where the V optimum is the region's best place, both have one gap, to the last digit.
    region_gap = v_gap
    if v_region.best and not (v_best and _is_as_good(v_best[0], v_region.best)):
        region_gap = v_region.best.cost / v_region.lower_bound - 1.0
    proof = Proof(
        v_lower_bound=v_region.lower_bound * unit,
        v_region_certified_gap=region_gap,
        v_certified_gap=v_gap,
        global_lower_bound=whole.lower_bound * unit,
        global_certified_gap=optima[0][0].cost / whole.lower_bound - 1.0 if optima else None,
        certificate_boxes=whole.boxes + v_region.boxes,
        v_wall=v_wall,
        feasible=bool(optima),
        tolerance=settings.tolerance,
    )
    described = tuple(
        _described(search, basin, evidence, rank, v_best is not None and basin is v_best[0])
        for rank, (basin, evidence) in enumerate(optima)
    )
    status = "solved" if optima else "infeasible"
    return PairSolution(status, described, proof, time.perf_counter() - begun)


@dataclass(frozen=True)
class _Region:
    """What a proof says of a region: bound, best point known in it, boxes."""

    lower_bound: float
    best: Basin | None
    boxes: int


def _prove(
    search: EndlessSearch,
    bounds: NDArray[np.float64],
    known: list[Basin],
    settings: SearchSettings,
    whole: _Region | None = None,
) -> _Region:
    """Prove the best point of a region; whatever better the proof meets is a start for all basins.

    Where the best of the whole lies in the region, its proof is the region's.
    """
    is_empty = bool(np.any(bounds[:, 0] > bounds[:, 1]))
    inside = [
        basin
        for basin in [*known, *search.basins]
        if not is_empty and np.all((basin.point >= bounds[:, 0])[1:] & (basin.point <= bounds[:, 1])[1:])
    ]
    best = min(inside, key=lambda basin: basin.cost, default=None)
    if whole and whole.best and best and best.cost <= whole.best.cost * (1.0 + SAME_COST):
        return _Region(whole.lower_bound, best, 0)
    boxes = 0
    for _ in range(MOST_PROOFS):
        certificate = certify_endless(
            search.problem,
            bounds,
            best.cost if best else math.inf,
            settings.tolerance,
            settings.most_boxes,
            partial(search.descend, bounds=bounds),
        )
        boxes += certificate.boxes
        if certificate.found is None:
            break
        best = certificate.found
        search.keep(best)
        search.explore(best.point[None, :])
        if certificate.is_closed:
            break
    return _Region(certificate.lower_bound, best, boxes)


def certify_endless(
    problem: EndlessProblem,
    bounds: NDArray[np.float64],
    incumbent: float,
    tolerance: float,
    budget: int = SearchSettings.most_boxes,
    descend: Callable[[NDArray[np.float64]], list[Basin]] | None = None,
) -> Certificate:
    """Prove that no feasible point within bounds costs less than an incumbent by more than a tolerance.

    Parameters
    ----------
    problem : EndlessProblem
        The problem.
    bounds, incumbent, tolerance, budget, descend
        As for `upwash.optimum.certify.certify`.
    """
    if np.any(bounds[:, 0] > bounds[:, 1]):
        return Certificate(np.inf, 0, True, None)
    x, y, z, h, ratio, nothing = problem.proof_bounds(bounds)
    lows, highs = np.empty((DEPTH, VARIABLE_COUNT)), np.empty((DEPTH, VARIABLE_COUNT))
    multipliers, floors = np.zeros((DEPTH, 2)), np.full(DEPTH, -np.inf)
    fars = np.full((DEPTH, 3, 7), np.inf)
    lows[0] = x[0], y[0], z[0] + 0.5 * h[0], z[0] - 0.5 * h[1], ratio[0], nothing[0]
    highs[0] = x[1], y[1], z[1] + 0.5 * h[1], z[1] - 0.5 * h[0], ratio[1], nothing[1]
    limits, centre = Limits(*z, *h), np.empty(VARIABLE_COUNT)
    best, threshold = incumbent, min(incumbent / (1.0 + tolerance), UNREACHABLE_COST)
    found: Basin | None = None
    height, boxes, left_open = 1, 0, np.inf
    while height > 0 and boxes < budget:
        height, examined, given_up = clear_endless_boxes(
            lows,
            highs,
            multipliers,
            floors,
            fars,
            height,
            limits,
            threshold,
            min(SEARCH_EVERY, budget - boxes),
            problem.enclosure,
            problem.constants,
            problem.walls,
            centre,
        )
        boxes, left_open = boxes + examined, min(left_open, given_up)
        if descend and height > 0 and not np.isnan(centre[0]):
            better = next(
                (one for one in descend(centre[None, :]) if one.cost < best * (1.0 - SAME_COST)), None
            )
            if better is not None:
                found, best, threshold = better, better.cost, better.cost / (1.0 + tolerance)
    left_open = min(left_open, np.min(floors[:height], initial=np.inf))
    is_closed = bool(left_open >= threshold)
    lower_bound = np.inf if is_closed and not np.isfinite(best) else min(left_open, threshold)
    return Certificate(float(lower_bound), boxes, is_closed, found)


def _optima(search: EndlessSearch) -> list[tuple[Basin, Evidence]]:
    """Return the basins that are optima, best first, with what speaks for them."""
    found = []
    for basin in search.basins:
        evidence = gather_endless_evidence(search.problem, basin.point)
        is_convex = evidence.curvature is None or evidence.curvature > LEAST_CURVATURE
        if evidence.stationarity < STATIONARY and is_convex:
            found.append((basin, evidence))
    return found


def _is_in_v(problem: EndlessProblem, basin: Basin) -> bool:
    return labels(problem.bird, problem.pose(basin.point).position_m) == V_LABELS


def stays_in_v(problem: EndlessProblem, point: NDArray[np.float64]) -> bool:
    """Whether an optimum of the V stays in it when the wingbeat is told in finer steps."""
    steps = replace(problem.model, stroke_states=FINER * problem.model.stroke_states)
    limit = min(LOOSER * problem.amplitude_limit_m, 2.0 * problem.bird.semispan_m)
    fine = replace(problem, model=steps, amplitude_limit_m=limit)
    found = EndlessSearch(fine).descend(point[None, :])
    return any(_is_in_v(problem, moved) for moved in found)


def _is_as_good(basin: Basin, best: Basin) -> bool:
    return basin.cost <= best.cost * (1.0 + 1e-9)


def _walls(
    region: _Region,
    v_best: Basin | None,
    v_bounds: NDArray[np.float64],
    bounds: NDArray[np.float64],
) -> str:
    """Name the walls of the V region on which its best point lies, if that is better than the V optimum."""
    best = region.best
    if best is None or (v_best is not None and _is_as_good(v_best, best)):
        return ""
    named = []
    for name, value, own, whole in zip(VARIABLES, best.point, v_bounds, bounds, strict=True):
        for side, word in ((0, "lower"), (1, "upper")):
            if own[side] != whole[side] and abs(value - own[side]) < 1e-9:
                named.append(f"{name}_{word}")
    return ",".join(named)


def _described(
    search: EndlessSearch, basin: Basin, evidence: Evidence, rank: int, is_v_optimum: bool
) -> Optimum:
    """Turn a basin into an optimum in SI units."""
    problem = search.problem
    pose = problem.pose(basin.point)
    follows = record_in(problem, pose)
    return Optimum(
        **{entry.name: getattr(follows, entry.name) for entry in fields(follows)},
        pose=pose,
        rank=rank,
        hits=basin.hits,
        starts=search.starts,
        is_v_optimum=is_v_optimum,
        is_global_optimum=rank == 0,
        **vars(endless_stated(problem, evidence)),
    )


def endless_stated(problem: EndlessProblem, evidence: Evidence) -> StatedEvidence:
    """State the evidence at a point."""
    return StatedEvidence.of(problem, evidence, (_edge_name(problem, edge) for edge in evidence.core_edges))


def _edge_name(problem: EndlessProblem, edge: int) -> CoreEdge:
    """Name a core edge: how high the wing is on which stroke, and which spanwise filament of the wake it meets."""
    step, station = divmod(edge, problem.stations.shape[2])
    is_down = step < problem.wake_felt.downstroke_steps
    height = problem.wake_felt.steps[HEIGHT, step]
    x, z = problem.stations[0 if is_down else 1, :2, station]
    x = x / problem.wavelength - (0.0 if is_down else 0.5)
    state = f"{height:+.3g} {'down' if is_down else 'up'}"
    return CoreEdge(BOTH, state, TURN, "upstroke" if z > 0.0 else "downstroke", f"{x:+.3g}")
