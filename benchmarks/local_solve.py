"""One descent from a random start to a local optimum, for the ibis pair and the paper's first objective.

Peers get the compiled cost, balances and exact derivatives, the same starts and bounds, and the same variables.  They
solve a smooth problem, which this is not: an end that is balanced but from whose neighbourhood one gets lower has
stalled, mostly at a core edge.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from upwash.aero.lanes import core_edges
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Search
from upwash.optimum.variables import SCALE

from benchmarks.contest import Contender, Contest
from benchmarks.wake_force import IBIS

STARTS = 50
BALANCED = 1e-8
MOST_EVALUATIONS = 500
COST_TOLERANCE = 1e-9

# An end has stalled if a start this near to it (in units of SCALE) descends by more than this share of its cost.
NEARBY, DESCENT, TRIES = 1e-4, 1e-6, 10

Solve = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Where a local solve that begins at a point ends."""


class Model:
    """The scaled problem as peers want it: functions of a point."""

    def __init__(self, problem: PairProblem) -> None:
        self.problem = problem
        self.edges = core_edges(problem.lanes)
        self.residual, self.gradient, self.jacobian = np.empty(2), np.empty(6), np.empty((2, 6))

    def fill(self, point: NDArray[np.float64]) -> float:
        """Return the cost; fill in its gradient and the balances with their Jacobian."""
        return evaluate(
            point,
            self.problem.lanes,
            self.edges,
            self.problem.constants,
            self.residual,
            self.gradient,
            self.jacobian,
        )

    def cost(self, point):
        return self.fill(point), self.gradient.copy()

    def balances(self, point):
        self.fill(point)
        return self.residual.copy()

    def slopes(self, point):
        self.fill(point)
        return self.jacobian.copy()


def scipy_slsqp(model: Model) -> Solve:
    """Return SciPy's sequential least squares programming as a local solve."""
    balances = {"type": "eq", "fun": model.balances, "jac": model.slopes}
    options = {"ftol": COST_TOLERANCE, "maxiter": MOST_EVALUATIONS}

    def solve(start):
        bounds = model.problem.bounds
        return minimize(
            model.cost,
            start,
            jac=True,
            method="SLSQP",
            bounds=bounds,
            constraints=balances,
            options=options,
        ).x

    return solve


def nlopt_slsqp(model: Model) -> Solve:
    """Return NLopt's sequential least squares programming as a local solve."""
    import nlopt

    def cost(point, gradient):
        value = model.fill(point)
        if gradient.size:
            gradient[:] = model.gradient
        return value

    def balances(result, point, gradient):
        model.fill(point)
        result[:] = model.residual
        if gradient.size:
            gradient[:] = model.jacobian

    def solve(start):
        solver = nlopt.opt(nlopt.LD_SLSQP, 6)
        solver.set_min_objective(cost)
        solver.add_equality_mconstraint(balances, np.full(2, BALANCED))
        solver.set_lower_bounds(model.problem.bounds[:, 0])
        solver.set_upper_bounds(model.problem.bounds[:, 1])
        solver.set_ftol_rel(COST_TOLERANCE)
        solver.set_maxeval(MOST_EVALUATIONS)
        try:
            return solver.optimize(start)
        except (RuntimeError, ValueError):  # what it raises when rounding stops it, or it fails
            return np.full(6, np.nan)

    return solve


def remark(solve: Solve, starts: NDArray[np.float64], search: Search) -> str:
    """Return how many starts a solver brings to a balance, how many of these stalled, and its median time."""
    model, bounds = Model(search.problem), search.problem.bounds
    random = np.random.default_rng(0)
    solved = stalled = 0
    times = []
    for start in starts:
        begun = time.perf_counter()
        end = solve(start)
        times.append(time.perf_counter() - begun)
        is_within = np.all((end >= bounds[:, 0] - 1e-9) & (end <= bounds[:, 1] + 1e-9))
        if not (is_within and np.max(np.abs(model.balances(end))) < BALANCED):
            continue
        solved += 1
        near = end + NEARBY * SCALE * random.uniform(-1.0, 1.0, (TRIES, 6))
        lower = [
            one.cost
            for one in search.descend(near)
            if np.max(np.abs(one.point - end) / SCALE) < 100.0 * NEARBY
        ]
        stalled += min(lower, default=np.inf) < model.fill(end) * (1.0 - DESCENT)
    return f"{solved} of {len(starts)} balanced, {stalled} stalled; median {1e3 * np.median(times):.3g} ms"


def contest() -> Contest:
    """Return the contest: random starts over the whole problem, one after another."""
    search = Search(PairProblem(IBIS, "force"))
    bounds = search.problem.bounds
    starts = search.random_starts(bounds, STARTS)
    model = Model(search.problem)

    def ours(start):
        found = search.descend(start[None, :])
        return found[0].point if found else np.full(6, np.nan)

    def contender(name, solve):
        def run():
            for start in starts:
                solve(start)

        return Contender(name, run, STARTS, remark=lambda: remark(solve, starts, search))

    contenders = [
        Contender(
            "Upwash",
            lambda: search.descend(starts),
            STARTS,
            remark=lambda: remark(ours, starts, search),
        ),
        contender("SciPy, SLSQP", scipy_slsqp(model)),
    ]
    try:
        contenders.append(contender("NLopt, SLSQP", nlopt_slsqp(model)))
    except ImportError as error:
        contenders.append(Contender("NLopt, SLSQP", missing=f"{error} (make bench installs it)"))
    return Contest("local_solve", "local solve, mean over 50 random starts", contenders)
