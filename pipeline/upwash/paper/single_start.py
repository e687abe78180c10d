"""What one run of a general-purpose solver finds from one start, which is how the paper searched.

The paper's solver is MATLAB's sequential quadratic programming; here it is SciPy's, with exact derivatives, in the
paper's own variables: the phase κ, with its kink at ½, and not |κ − ½|.  The results of Upwash do not depend on this
module; it exists to ask how far such a run can be trusted.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from upwash.aero.lanes import core_edges
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.problem import PairProblem

MOST_ITERATIONS = 400
BALANCED = 1e-6
"""Largest imbalance, in weights of the bird, of a run that counts as ended at a possible flight."""


@dataclass(frozen=True)
class End:
    """Where a run ended.

    Attributes
    ----------
    point : (6,) ndarray of float
        x, y, z, h and R in scaled variables, and the phase κ.
    cost : float
        Cost over that of the lone bird.
    is_balanced : bool
        Whether lift and thrust balance there.
    """

    point: NDArray[np.float64]
    cost: float
    is_balanced: bool


def paper_start(problem: PairProblem) -> NDArray[np.float64]:
    """Return the paper's start: the leader's own place and stroke, and phase ½."""
    return np.array([0.0, 0.0, 0.0, problem.leader_height, problem.ahead.span_ratio, 0.5])


def spread_starts(problem: PairProblem, count: int, seed: int) -> NDArray[np.float64]:
    """Draw starts evenly over all that the bounds allow.

    Returns
    -------
    (count, 6) ndarray of float
        As `End.point`.
    """
    bounds = _bounds(problem)
    return bounds[:, 0] + np.random.default_rng(seed).random((count, 6)) * (bounds[:, 1] - bounds[:, 0])


def solve_from(problem: PairProblem, start: NDArray[np.float64]) -> End:
    """Run the solver once, from one start.

    Parameters
    ----------
    problem : PairProblem
        The problem; its wake must have two stroke states.
    start : (6,) ndarray of float
        As `End.point`.
    """
    edges = core_edges(problem.lanes)

    def balances(point: NDArray[np.float64]) -> tuple[float, NDArray, NDArray, NDArray]:
        """Return cost, its gradient, what is missing to balance, and that one's Jacobian."""
        residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
        folded = point.copy()
        folded[5] = abs(point[5] - 0.5)
        cost = evaluate(folded, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
        jacobian[:, 5] *= np.sign(point[5] - 0.5)
        return cost, gradient, residual, jacobian

    with warnings.catch_warnings():
        # It says when a step was cut at a bound; where the run ended is looked at below.
        warnings.simplefilter("ignore", RuntimeWarning)
        end = minimize(
            lambda point: balances(point)[:2],
            start,
            jac=True,
            method="SLSQP",
            bounds=_bounds(problem),
            constraints={
                "type": "eq",
                "fun": lambda point: balances(point)[2],
                "jac": lambda point: balances(point)[3],
            },
            options={"maxiter": MOST_ITERATIONS},
        )
    cost, _, residual, _ = balances(end.x)
    return End(end.x, float(cost), bool(np.max(np.abs(residual)) < BALANCED))


def _bounds(problem: PairProblem) -> NDArray[np.float64]:
    bounds = problem.bounds.copy()
    bounds[5] = 0.0, 1.0
    return bounds
