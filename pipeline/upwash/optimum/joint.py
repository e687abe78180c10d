"""The flock as a whole: all birds' variables improved together, for the sum of their costs.

In a chain each bird does the best for itself and leaves to those behind it the wake that results.  Here every
bird may give up something for the birds behind.  The search starts from the chain and goes downhill, so what
it finds is a local optimum near the chain: within a pattern of sides of the core edges the problem is smooth
and sequential quadratic programming solves it; then the edges that the point lies on are crossed one by one,
where the slope beyond them says that it pays.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize, nnls

from upwash.aero.compiled.lanes import CORE2
from upwash.optimum.edges import felt_lanes
from upwash.optimum.evidence import ON_BOUND, ON_EDGE, gather_evidence
from upwash.optimum.flock_solution import FlockSolution, Member, on_side
from upwash.optimum.joint_problem import Edges, Evaluation, JointProblem, Sides
from upwash.optimum.search import Basin
from upwash.optimum.solution import describe_optimum
from upwash.optimum.solvable import adds_up
from upwash.optimum.variables import SCALE, VARIABLE_COUNT

WIDEST_BOX, LEAST_BOX, NARROWER = 0.3, 1e-3, 0.3
"""Half-width, in units of `SCALE`, of the box within which one pattern is solved: at first, at last, and the
factor by which it shrinks when nothing in it is better."""

MOST_ROUNDS = 60
BALANCED, PLAINLY_BALANCED = 1e-10, 1e-9
"""Largest imbalance: over weight in the search, over weight or drag by the plain statement of the model."""

WORTHWHILE = 1e-9
"""Least gain, in costs of the lone bird, that is taken for one."""

STATIONARY = 1e-6
"""What of the gradient may be left, per unit of `SCALE`, beyond an edge that need not be crossed."""


@dataclass(frozen=True)
class JointSolution:
    """A flock improved as a whole, beside the chain that it came from.

    Attributes
    ----------
    chain, flock : FlockSolution
        Before and after; the same if nothing better was found.
    stationarity : float
        What is left of the gradient of the total cost, per unit of `SCALE`, in the pattern of sides where the
        search ended or in the worst of those one edge away: 0 at a local optimum.
    """

    chain: FlockSolution
    flock: FlockSolution
    stationarity: float

    @property
    def given_up(self) -> list[float]:
        """What each follower pays more than in the chain, over a lone bird's cost; negative: it gains."""
        pairs = zip(self.chain.placed, self.flock.placed, strict=True)
        return [
            (after.optimum.cost - before.optimum.cost) / before.optimum.cost_leader
            for before, after in pairs
            if before.optimum and after.optimum
        ]

    @property
    def gained(self) -> float:
        """What the flock saves over the chain, per bird with the first one, over the cost of a lone bird."""
        return 0.0 - sum(self.given_up) / len(self.chain.placed)


def improve_together(chain: FlockSolution) -> JointSolution:
    """Improve the total cost of a flock in the variables of all its birds.

    Parameters
    ----------
    chain : FlockSolution
        A flock as `upwash.optimum.flock.solve_flock` builds it; a bird that has no place is left out.

    Returns
    -------
    JointSolution
        The improved flock: forces, costs and residuals are recomputed by the plain statement of the model,
        and a flock that is not better by that measure is not taken.

    Raises
    ------
    ValueError
        If the birds are not alike, or do not beat in step, or the wakes are not added up in the flock's model.
    """
    if len(set(chain.kinds)) > 1 or not chain.phase_lock:
        raise ValueError(
            "chain: expected birds that are alike and beat in step, as they are improved together, found others"
        )
    if not adds_up(chain.model):
        raise ValueError(f"model: expected two held states and points of the span, found {chain.model}")
    placed = replace(chain, members=chain.placed)
    if len(placed.members) < 2:
        return JointSolution(placed, placed, 0.0)
    problem = JointProblem(placed)
    point, box = problem.start, WIDEST_BOX
    total = float(np.sum(problem.evaluate(point).costs))
    for _ in range(MOST_ROUNDS):
        for sides in _patterns(problem, point):
            trial = _descend(problem, point, sides, box)
            found = problem.evaluate(trial)
            trial_total = float(np.sum(found.costs))
            if np.max(np.abs(found.residual)) < BALANCED and trial_total < total - WORTHWHILE:
                point, total = trial, trial_total
                break
        else:
            box *= NARROWER
            if box < LEAST_BOX:
                break
    left = max(_slope_left(problem, point, sides) for sides in _neighbours(problem, point))
    improved = _describe(problem, point, left)
    is_better = improved.total_cost() < placed.total_cost() and improved.worst_residual() <= PLAINLY_BALANCED
    return JointSolution(placed, improved if is_better else placed, left)


def _neighbours(problem: JointProblem, point: NDArray[np.float64]) -> Iterator[Sides]:
    """Give the pattern of sides at a point, and then those beyond one of the edges that it lies on."""
    distances = problem.distances(point)
    here = [np.where(one <= 0.0, 1.0, -1.0) for one in distances]
    yield here
    for number, distance in enumerate(distances):
        for edge in np.flatnonzero(np.abs(distance) < ON_EDGE):
            beyond = [one.copy() for one in here]
            beyond[number][edge] *= -1.0
            yield beyond


def _patterns(problem: JointProblem, point: NDArray[np.float64]) -> Iterator[Sides]:
    """Give the pattern at a point, and those beyond an edge where the total cost still falls."""
    for k, sides in enumerate(_neighbours(problem, point)):
        if k == 0 or _slope_left(problem, point, sides) > STATIONARY:
            yield sides


def _near(problem: JointProblem, point: NDArray[np.float64], box: float) -> Edges:
    """Return the core edges that a point may reach within a box."""
    near = []
    for follower, distances in zip(problem.followers, problem.distances(point), strict=True):
        # A distance is r²/r_c² − 1.  All variables together move a node by some four times what x does.
        most = 4.0 * box * SCALE[0] / np.sqrt(np.min(follower.problem.lanes[CORE2]))
        near.append(np.flatnonzero(np.abs(distances) < most * (2.0 + most)))
    return near


def _descend(
    problem: JointProblem, point: NDArray[np.float64], sides: Sides, box: float
) -> NDArray[np.float64]:
    """Minimise the total cost within a pattern and a box around a point."""
    n, near = len(problem.followers), _near(problem, point, box)
    known: dict[bytes, Evaluation] = {}

    def evaluate(scaled: NDArray[np.float64]) -> Evaluation:
        key = scaled.tobytes()
        if key not in known:
            known.clear()
            known[key] = problem.evaluate(scaled.reshape(n, VARIABLE_COUNT) * SCALE, sides, near)
        return known[key]

    def inequalities(scaled: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([evaluate(scaled).distance, problem.coupling @ scaled - problem.least])

    start = point / SCALE
    low = np.maximum(problem.bounds[..., 0] / SCALE, start - box).ravel()
    high = np.minimum(problem.bounds[..., 1] / SCALE, start + box).ravel()
    result = minimize(
        lambda scaled: float(np.sum(evaluate(scaled).costs)),
        np.clip(start.ravel(), low, high),
        jac=lambda scaled: evaluate(scaled).gradient,
        bounds=np.stack([low, high], axis=1),
        constraints=[
            {
                "type": "eq",
                "fun": lambda scaled: evaluate(scaled).residual,
                "jac": lambda scaled: evaluate(scaled).residual_slopes,
            },
            {
                "type": "ineq",
                "fun": inequalities,
                "jac": lambda scaled: np.vstack([evaluate(scaled).distance_slopes, problem.coupling]),
            },
        ],
        method="SLSQP",
        options={"maxiter": 200, "ftol": 1e-13},
    )
    return np.clip(result.x, low, high).reshape(n, VARIABLE_COUNT) * SCALE


def _slope_left(problem: JointProblem, point: NDArray[np.float64], sides: Sides) -> float:
    """Return what is left of the gradient in a pattern after the best multipliers of the right signs."""
    near = [np.flatnonzero(np.abs(one) < ON_EDGE) for one in problem.distances(point)]
    found = problem.evaluate(point, sides, near)
    scaled = (point / SCALE).ravel()
    at_low = scaled - (problem.bounds[..., 0] / SCALE).ravel() <= ON_BOUND
    at_high = (problem.bounds[..., 1] / SCALE).ravel() - scaled <= ON_BOUND
    at_coupling = problem.coupling @ scaled - problem.least <= ON_BOUND
    every = np.eye(scaled.size)
    inward = np.vstack([found.distance_slopes, every[at_low], -every[at_high], problem.coupling[at_coupling]])
    # gradient + balancesᵀ ν − inwardᵀ ω = 0 with ω ≥ 0; ν of either sign is the difference of two.
    columns = np.vstack([found.residual_slopes, -found.residual_slopes, -inward]).T
    multipliers, _ = nnls(columns, -found.gradient)
    return float(np.max(np.abs(found.gradient + columns @ multipliers)))


def _describe(problem: JointProblem, point: NDArray[np.float64], left: float) -> FlockSolution:
    """Turn the variables of all birds into a flock."""
    places, members = problem.places(point), [problem.flock.members[0]]
    for follower, own in zip(problem.followers, point, strict=True):
        place = places[follower.number - 1]
        posed, _ = follower.pose(places, place.pose.relative_to(places[follower.leader - 1].pose).phase % 1.0)
        felt = felt_lanes(posed.lanes, posed.bounds, posed.walls)
        evidence = gather_evidence(posed, felt, own)
        optimum = describe_optimum(
            posed,
            Basin(own, 0.0, np.zeros(2), 1),
            replace(evidence, stationarity=left),
            felt,
            rank=0,
            starts=1,
            is_v_optimum=False,
        )
        members.append(Member(follower.number, follower.leader, place, on_side(optimum, follower.side)))
    return replace(problem.flock, members=tuple(members))
