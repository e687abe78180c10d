"""What was found and proved, verified from what is kept of it: the evidence at a place, and the proof of a bound.

Nothing of the search is taken for granted. A place is examined as the search examined it; a bound is proved again by
branch and bound with that bound as the cost to be exceeded, and while that goes on, something that costs less is looked
for where it could be.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.aero.pose import Pose
from upwash.optimum.certify import certify
from upwash.optimum.endless.evidence import gather_endless_evidence
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.endless.solve import certify_endless, endless_stated
from upwash.optimum.endless.solve import stays_in_v as endless_stays_in_v
from upwash.optimum.evidence import StatedEvidence
from upwash.optimum.means import means_of, stated
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import SAME_BASIN
from upwash.optimum.variables import SCALE, VARIABLES

SAME_PIECE = 1e-9
"""How far outside a piece of phase a phase may lie that was rounded, in wingbeats."""

CHEAPER = 1e-8
"""A follower that costs less than is claimed by more than this share refutes the claim."""

SLACK = 1e-9
"""By how much a bound may exceed the one that is proved again, as a share: rounding."""

GAP_ROUNDING = 1e-6
"""Share of the tolerance by which a gap may exceed it that was closed to it."""

STARTS = 60
"""Starts where a follower is looked for that is said not to be there, or to be on a wall."""


PIECES_KEPT = 32
"""Pieces of problems whose core edges are kept in memory: the optima of a job have them in common."""


@dataclass(frozen=True)
class Refuted:
    """What speaks against a claim: a follower that costs less, or a proof that does not close again.

    Attributes
    ----------
    cost : float or None
        What it costs, in the unit of the cost; None if none was found, and nothing could be proved either; infinite
        if more can be proved than is claimed.
    """

    cost: float | None


def point_in(problem: PairProblem, pose: Pose) -> NDArray[np.float64] | None:
    """Return a pose in scaled variables, or None if its phase is not in the problem's piece."""
    if isinstance(problem, EndlessProblem):
        return problem.point(pose)
    coordinate, end = problem.coordinate(pose.phase), problem.phase_span()
    if not -SAME_PIECE <= coordinate <= end + SAME_PIECE:
        return None
    lengths = np.array([*pose.position_m, pose.stroke.amplitude_m]) / problem.bird.semispan_m
    return np.array([*lengths, pose.stroke.span_ratio, min(max(coordinate, 0.0), end)])


def examine(problems: Sequence[PairProblem], pose: Pose) -> list[StatedEvidence]:
    """Return the evidence for an optimum at a pose.

    Parameters
    ----------
    problems : sequence of PairProblem
        The problem, in each piece of phase.
    pose : Pose
        Where and how the follower flies, to the right of the bird ahead.

    Returns
    -------
    list of StatedEvidence
        One for each piece in which the pose lies: two where two pieces meet.
    """
    found = []
    for problem in problems:
        point = point_in(problem, pose)
        if point is None:
            continue
        if isinstance(problem, EndlessProblem):
            found.append(endless_stated(problem, gather_endless_evidence(problem, point)))
            continue
        felt = _felt(problem)
        evidence = means_of(problem).examine(problem, felt, point)
        found.append(stated(problem, felt, evidence))
    return found


@lru_cache(PIECES_KEPT)
def _felt(problem: PairProblem) -> Any:
    return means_of(problem).search(problem).felt


def alike(problem: PairProblem, poses: Sequence[Pose]) -> list[tuple[int, int]]:
    """Return which poses are one and the same optimum, as pairs of their numbers."""
    points = [point_in(problem, pose) for pose in poses]
    return [
        (first, second)
        for (first, one), (second, other) in combinations(enumerate(points), 2)
        if one is not None and other is not None and np.max(np.abs(one - other) / SCALE) < SAME_BASIN
    ]


def refute_bound(
    problems: Sequence[PairProblem],
    bound: float | None,
    best: float | None,
    tolerance: float,
    *,
    in_v: bool,
) -> Refuted | None:
    """Prove a lower bound again, and look for something better than the best that is claimed.

    Parameters
    ----------
    problems : sequence of PairProblem
        The problem, in each piece of phase.
    bound : float or None
        What is claimed to be less than any cost, in its unit; None if it is claimed that no follower balances.
    best : float or None
        The least cost that is claimed to be reached; None if no follower was found.
    tolerance : float
        Gap between the two to which a proof was asked for. Where it was not reached, it is tried for again.
    in_v : bool
        Whether the claims are of the V region alone.

    Returns
    -------
    Refuted or None
        What speaks against it, or None if the proof closed and nothing better was met.
    """
    unit = problems[0].leader_cost
    gap = best / bound - 1.0 if best is not None and bound else 0.0
    attempts = [(best if best is not None else bound, max(gap, 0.0) + SLACK, True)]
    if bound is not None and (best is None or gap > tolerance * (1.0 + GAP_ROUNDING)):
        attempts.append((best, tolerance, False))
    for problem in problems:
        region = problem.v_bounds() if in_v else problem.bounds
        search, prove = _means(problem)
        descend = partial(search.descend, bounds=region)
        if bound is None:
            is_empty = bool(np.any(region[:, 0] > region[:, 1]))
            if not is_empty and (met := descend(search.random_starts(region, STARTS))):
                return Refuted(met[0].cost * unit)
        for incumbent, margin, must_close in attempts:
            cost = np.inf if incumbent is None else incumbent / unit
            proof = prove(problem, region, cost, margin, descend=descend)
            if proof.found is not None and proof.found.cost < cost * (1.0 - CHEAPER):
                return Refuted(proof.found.cost * unit)
            if must_close != proof.is_closed:
                return Refuted(None if must_close else math.inf)
    return None


def _means(problem: PairProblem) -> tuple[Any, Any]:
    """Return what searches a problem, and what proves a bound of it."""
    if isinstance(problem, EndlessProblem):
        return EndlessSearch(problem), certify_endless
    return means_of(problem).search(problem), certify


def stays_in_v(problem: PairProblem, pose: Pose) -> bool:
    """Whether an optimum of the V is held there by more than the steps of the wingbeat."""
    return not isinstance(problem, EndlessProblem) or endless_stays_in_v(problem, problem.point(pose))


def best_on_wall(problems: Sequence[PairProblem], wall: str) -> float:
    """Return the least cost met on a wall of the V region, in its unit; infinite if none is.

    Parameters
    ----------
    problems : sequence of PairProblem
        The problem, in each piece of phase.
    wall : str
        One wall or several, comma separated, as ``y_lower``.
    """
    best = math.inf
    for problem in problems:
        face = problem.v_bounds()
        for name in wall.split(","):
            variable, _, side = name.rpartition("_")
            face[VARIABLES.index(variable)] = face[VARIABLES.index(variable), int(side == "upper")]
        search, _ = _means(problem)
        costs = [basin.cost for basin in search.descend(search.random_starts(face, STARTS), face)]
        best = min([best, *costs])
    return best * problems[0].leader_cost
