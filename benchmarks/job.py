"""A whole job for the ibis: every optimum with its evidence, and the proofs; then its parts, one by one."""

from __future__ import annotations

import numpy as np
from upwash.optimum.certify import certify
from upwash.optimum.evidence import gather_evidence
from upwash.optimum.pair import solve_pair
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Search
from upwash.optimum.settings import SearchSettings

from benchmarks.contest import Contender, Contest
from benchmarks.local_solve import Model, scipy_slsqp
from benchmarks.wake_force import IBIS

TOLERANCE = 1e-4
STARTS_WITHOUT_PROOF = 300
"""With so many starts, of which 2 to 3 % end in the global optimum, one job in 1500 misses it."""


class Parts:
    """What a job does, one part at a time."""

    def __init__(self, objective: str) -> None:
        self.search = Search(PairProblem(IBIS, objective))
        self.problem = self.search.problem
        self.costs = [
            optimum.cost / optimum.cost_leader
            for solution in [solve_pair(IBIS, objective)]
            for optimum in (solution.global_optimum, solution.v_optimum)
        ]
        self.basins = self.explore().basins

    def explore(self):
        """Solve from a job's starts: in each kind of place, in the V region, around the best."""
        search, v_bounds = Search(self.problem), self.problem.v_bounds()
        search.explore_places(SearchSettings.starts)
        in_v = search.random_starts(v_bounds, SearchSettings.starts)
        search.descend(in_v, v_bounds)
        search.explore(in_v)
        search.explore_around_best()
        return search

    def prove(self, bounds, incumbent):
        """Prove an optimum that is known."""
        return certify(self.problem, bounds, incumbent, TOLERANCE)

    def examine(self):
        """Gather the evidence of every basin."""
        for basin in self.basins:
            gather_evidence(self.problem, self.search.felt, basin.point)


def contest() -> Contest:
    """Return the contest; ratios are to the whole job for the paper's first objective."""
    contenders = []
    for objective in ("force", "power"):
        parts = Parts(objective)
        best, best_in_v = parts.costs
        for name, run in (
            ("whole job", lambda objective=objective: solve_pair(IBIS, objective)),
            ("search", parts.explore),
            ("proof of the V optimum", lambda p=parts, cost=best_in_v: p.prove(p.problem.v_bounds(), cost)),
            ("proof of the global optimum", lambda p=parts, cost=best: p.prove(p.problem.bounds, cost)),
            ("evidence of every basin", parts.examine),
        ):
            contenders.append(Contender(f"Upwash, {objective}: {name}", run))
    contenders.append(
        Contender(f"SciPy, force: {STARTS_WITHOUT_PROOF} random starts, no proof", multistart())
    )
    return Contest("job", "job", contenders)


def multistart():
    """Return what one would do without Upwash: as many random starts as find the best nearly always."""
    problem = PairProblem(IBIS, "force")
    solve = scipy_slsqp(Model(problem))
    starts = Search(problem).random_starts(problem.bounds, STARTS_WITHOUT_PROOF)
    return lambda: np.array([solve(start) for start in starts])
