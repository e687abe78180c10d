"""One follower's problem solved completely: starts, basins, the proof for the whole and for the V.

Random starts find the basins; branch and bound then either clears everything below the best, or meets
something better, which then is the best.  The V optimum is the best *local optimum
of the whole problem* that is outboard, level and astern; the region's own best point may instead lie on one
of its walls, which is then named.

A problem is smooth in phase only between the kinks of its weights, so it may be posed in several pieces, one
between each two kinks.  They are searched and proved one after another with one best solution, and where two
meet an optimum has to be one in both.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.certify import certify
from upwash.optimum.evidence import ON_BOUND, Evidence
from upwash.optimum.means import means_of
from upwash.optimum.problem import PairProblem
from upwash.optimum.proof import Proof
from upwash.optimum.record import V_LABELS, labels
from upwash.optimum.search import SAME_BASIN, Basin, Search
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import PairSolution, describe_optimum
from upwash.optimum.variables import SCALE, VARIABLES

MOST_PROOFS = 8
"""Proofs tried in turn when each spends its budget but meets something better than the last one's best."""

STATIONARY = 1e-6
LEAST_CURVATURE = -1e-6
"""An end of a local solve is an optimum if it is as stationary, and no more concave, than this."""


@dataclass(frozen=True)
class _Region:
    """What a proof says of a region: bound, best point known in it and its piece, boxes."""

    lower_bound: float
    best: Basin | None
    piece: int
    boxes: int


_NOTHING_PROVED = _Region(math.nan, None, 0, 0)


def solve_pieces(
    problems: Sequence[PairProblem],
    settings: SearchSettings,
    *,
    proves_all: bool = True,
) -> PairSolution:
    """Solve one follower's problem that is posed in pieces of phase.

    Parameters
    ----------
    problems : sequence of PairProblem
        The problem in each piece: one that holds all phases but for symmetry, or several that follow one
        another around the wingbeat and differ in nothing but the phase.
    settings : SearchSettings
        How long to search, and how closely to prove; the pieces share the starts.
    proves_all : bool
        Whether the global optimum is proved and the others near it are sought, and not the V optimum alone.

    Returns
    -------
    PairSolution
        The optima of all pieces, best first, and the proof.
    """
    begun = time.perf_counter()
    searches = [means_of(problem).search(problem, settings.seed) for problem in problems]
    share = -(-settings.starts // len(problems))
    problem, v_bounds = problems[0], [one.v_bounds() for one in problems]
    has_v_region = bool(np.all(v_bounds[0][:, 0] <= v_bounds[0][:, 1]))
    in_v: list[Basin | None] = [None] * len(problems)
    for number, search in enumerate(searches):
        search.explore_places(share)
        if has_v_region:
            v_starts = search.random_starts(v_bounds[number], share)
            within = search.descend(v_starts, v_bounds[number])
            search.explore(v_starts)
            in_v[number] = within[0] if within else None
    if proves_all:
        _explore_around_best(searches)

    v_region = _prove(searches, v_bounds, in_v, settings)
    whole = _NOTHING_PROVED
    if proves_all:
        bounds = [one.bounds for one in problems]
        whole = _prove(searches, bounds, [None] * len(problems), settings)
        _explore_around_best(searches)
    optima = _optima(searches)
    v_best = next(
        (one for one in optima if labels(problem.bird, problem.pose(one.basin.point).position_m) == V_LABELS),
        None,
    )
    described = tuple(
        describe_optimum(
            one.search.problem,
            one.basin,
            one.evidence,
            one.search.felt,
            rank=rank,
            starts=sum(search.starts for search in searches),
            is_v_optimum=one is v_best,
        )
        for rank, one in enumerate(optima)
    )
    unit = problem.leader_cost
    v_gap = v_best.basin.cost / v_region.lower_bound - 1.0 if v_best else None
    gap = optima[0].basin.cost / whole.lower_bound - 1.0 if optima and proves_all else None
    v_wall = _walls(v_region, v_best, v_bounds, problems)
    # Off the walls the V optimum is the region's best place.
    region_gap = v_gap
    if v_region.best and (v_wall or not v_best):
        region_gap = v_region.best.cost / v_region.lower_bound - 1.0
    # Where nothing was to be proved of all followers and none was found, no cost is excluded.
    lower_bound = whole.lower_bound * unit if proves_all else None if optima else 0.0
    proof = Proof(
        v_lower_bound=v_region.lower_bound * unit,
        v_region_certified_gap=region_gap,
        v_certified_gap=v_gap,
        global_lower_bound=lower_bound,
        global_certified_gap=gap,
        certificate_boxes=v_region.boxes + whole.boxes,
        v_wall=v_wall,
        feasible=bool(optima),
        tolerance=settings.tolerance,
    )
    status = "solved" if optima else "infeasible"
    return PairSolution(status, described, proof, time.perf_counter() - begun)


def _explore_around_best(searches: Sequence[Search]) -> None:
    """Search around the basins of every piece that cost nearly as little as the best of all."""
    least = min((search.basins[0].cost for search in searches if search.basins), default=math.inf)
    for search in searches:
        search.explore_around_best(least)


@dataclass(frozen=True)
class _Found:
    """A local optimum, the search that found it, and what speaks for it."""

    search: Search
    basin: Basin
    evidence: Evidence


def _optima(searches: Sequence[Search]) -> list[_Found]:
    """Return the basins that are optima of the whole problem, each once, best first."""
    found: list[_Found] = []
    for number, search in enumerate(searches):
        for basin in search.basins:
            evidence = _evidence(search, basin.point)
            end = search.problem.phase_span()
            is_kept = _is_optimum(evidence)
            for bound, other, entry in ((0.0, number - 1, 1.0), (end, (number + 1) % len(searches), 0.0)):
                # Where two pieces of phase meet, an optimum is one in both.
                if is_kept and len(searches) > 1 and abs(basin.point[5] - bound) <= ON_BOUND * SCALE[5]:
                    beyond = basin.point.copy()
                    beyond[5] = entry * searches[other].problem.phase_span()
                    is_kept = _is_optimum(_evidence(searches[other], beyond))
            if is_kept:
                _add(found, _Found(search, basin, evidence))
    return sorted(found, key=lambda one: one.basin.cost)


def _add(found: list[_Found], new: _Found) -> None:
    """Add an optimum, or its hits to those of the same one found from the next piece of phase."""
    for k, known in enumerate(found):
        apart = np.append(
            (new.basin.point[:5] - known.basin.point[:5]) / SCALE[:5],
            _phase_distance(new, known) / SCALE[5],
        )
        if new.search is not known.search and np.max(np.abs(apart)) < SAME_BASIN:
            basin = replace(known.basin, hits=known.basin.hits + new.basin.hits)
            found[k] = replace(known, basin=basin)
            return
    found.append(new)


def _phase_distance(one: _Found, other: _Found) -> float:
    lag = one.search.problem.phase(one.basin.point[5]) - other.search.problem.phase(other.basin.point[5])
    return abs(lag - round(lag))


def _evidence(search: Search, point: NDArray[np.float64]) -> Evidence:
    return means_of(search.problem).examine(search.problem, search.felt, point)


def _is_optimum(evidence: Evidence) -> bool:
    is_convex = evidence.curvature is None or evidence.curvature > LEAST_CURVATURE
    return evidence.stationarity < STATIONARY and is_convex


def _prove(
    searches: Sequence[Search],
    bounds: Sequence[NDArray[np.float64]],
    known: Sequence[Basin | None],
    settings: SearchSettings,
) -> _Region:
    """Prove the best point of a region; whatever better the proof meets is a start for all basins."""
    best: Basin | None = None
    piece = 0
    for number, (search, within, first) in enumerate(zip(searches, bounds, known, strict=True)):
        for basin in [*([first] if first else []), *search.basins]:
            inside = np.all((basin.point >= within[:, 0]) & (basin.point <= within[:, 1]))
            if inside and (best is None or basin.cost < best.cost):
                best, piece = basin, number
    boxes, lower_bound, is_closed = 0, math.inf, True
    for number, (search, within) in enumerate(zip(searches, bounds, strict=True)):
        for _ in range(MOST_PROOFS):
            certificate = certify(
                search.problem,
                within,
                best.cost if best else math.inf,
                settings.tolerance,
                # What is open in one piece of phase is open: the others are worth no work.
                settings.most_boxes if is_closed else 1,
                partial(search.descend, bounds=within),
            )
            boxes += certificate.boxes
            if certificate.found is None:
                break
            best, piece = certificate.found, number
            search.explore(best.point[None, :])
            if certificate.is_closed:
                break
        is_closed = is_closed and certificate.is_closed
        lower_bound = min(lower_bound, certificate.lower_bound)
    return _Region(lower_bound, best, piece, boxes)


def _walls(
    region: _Region,
    v_best: _Found | None,
    v_bounds: Sequence[NDArray[np.float64]],
    problems: Sequence[PairProblem],
) -> str:
    """Name the walls of the V region on which its best point lies, if that is better than the V optimum."""
    best = region.best
    if best is None or (v_best is not None and v_best.basin.cost <= best.cost * (1.0 + 1e-9)):
        return ""
    named = []
    sides = zip(VARIABLES, best.point, v_bounds[region.piece], problems[region.piece].bounds, strict=True)
    for name, value, own, whole in sides:
        for side, word in ((0, "lower"), (1, "upper")):
            if own[side] != whole[side] and abs(value - own[side]) < 1e-9:
                named.append(f"{name}_{word}")
    return ",".join(named)
