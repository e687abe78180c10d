"""What speaks for a point behind an endless wake being a local optimum: as of a pair behind a wake that ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import PHASE, X
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.evidence import Evidence
from upwash.optimum.sided_evidence import ENDLESS, gather_sided_evidence


def gather_endless_evidence(problem: EndlessProblem, point: NDArray[np.float64]) -> Evidence:
    """Examine a balanced point, trusting nothing of the solve that found it.

    Parameters
    ----------
    problem : EndlessProblem
        The problem.
    point : (6,) ndarray of float
        The point, in scaled variables.

    Returns
    -------
    Evidence
        What was found; core edges are numbered step by step and, in each, station by station of its window.
    """
    # X goes round, or has no range as the sixth variable has none.
    fixed = [PHASE] if problem.phase_lock else [X, PHASE]
    return gather_sided_evidence(problem, point, ENDLESS, unbounded=(X,), fixed=fixed)
