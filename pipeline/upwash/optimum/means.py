"""How a follower's problem behind a wake that ends is searched and examined, by how the wake is felt."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import PHASE
from upwash.optimum.compiled.cut_descent import FeltCutWake, solve_many_cut
from upwash.optimum.core_edge import CoreEdge
from upwash.optimum.cut_problem import CutProblem
from upwash.optimum.evidence import Evidence, StatedEvidence, gather_evidence, name_edge
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Search
from upwash.optimum.sided_evidence import CUT, gather_sided_evidence


class CutSearch(Search):
    """The basins of one problem whose wake is felt on the whole span, as far as they have been found."""

    problem: CutProblem
    solve_many = staticmethod(solve_many_cut)

    def wake_felt(self) -> FeltCutWake:
        """Return the wake as the local solve takes it."""
        return self.problem.felt

    @property
    def edge_count(self) -> int:
        """Number of core edges."""
        return len(self.felt.edges) - 1


class Means(NamedTuple):
    """What is done with a problem.

    Attributes
    ----------
    search : callable
        Problem and seed -> its search.
    examine : callable
        Problem, wake felt and point -> what speaks for it.
    name_edge : callable
        Problem, wake felt and number of a core edge -> its name.
    """

    search: Callable[..., Search]
    examine: Callable[[Any, Any, NDArray[np.float64]], Evidence]
    name_edge: Callable[[Any, Any, int], CoreEdge]


IN_POINTS = Means(
    Search, gather_evidence, lambda problem, felt, edge: name_edge(problem, *felt.representative[edge])
)
ON_SPAN = Means(
    CutSearch,
    lambda problem, felt, point: gather_sided_evidence(
        problem, point, CUT, fixed=[] if problem.phase_lock else [PHASE]
    ),
    lambda problem, felt, edge: problem.edge_named(edge),
)


def means_of(problem: PairProblem) -> Means:
    """Return what searches and examines a problem behind a wake that ends."""
    return ON_SPAN if isinstance(problem, CutProblem) else IN_POINTS


def stated(problem: PairProblem, felt: Any, evidence: Evidence) -> StatedEvidence:
    """State the evidence at a point.

    Parameters
    ----------
    problem : PairProblem
        The problem.
    felt : NamedTuple
        Its wake and core edges.
    evidence : Evidence
        What holds there.
    """
    name = means_of(problem).name_edge
    return StatedEvidence.of(problem, evidence, (name(problem, felt, edge) for edge in evidence.core_edges))
