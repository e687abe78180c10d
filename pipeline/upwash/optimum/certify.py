"""A proof that nothing is better: branch and bound on the follower's problem.

Boxes live in (x, y, z_up, z_down, R, t), with z_up and z_down the heights of the raised and the lowered wingtips, so
that the force with tips up does not see z_down and the reverse; states in between see a mix of both.  A box is cleared
when for some multipliers ν

    C + ν · (lift residual, thrust residual) > threshold

throughout it; then no point of the box both balances and costs as little as the threshold.  Boxes that stay open are
searched for better solutions, and what is left when the budget is spent is reported as open, with the bound reached.

Every way of clearing a box keeps one margin, `MARGIN`: cleared is what holds no point that keeps the bounds and both
balances to within the margin and costs as little as the threshold less the margin.  The sums are ordinary floating
point; what their rounding may add is part of the radii, see `upwash.optimum.compiled.relaxation.relax`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled.relaxation import MARGIN, Limits
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Basin
from upwash.optimum.settings import SearchSettings
from upwash.optimum.variables import VARIABLE_COUNT

Descend = Callable[[NDArray[np.float64]], list[Basin]]
"""Starts -> the solutions that local solves from them reach, best first."""

DEPTH = 600
UNREACHABLE_COST = 1e6

SEARCH_EVERY = 4000
"""After each so many boxes a local solve is tried from the centre of a narrow one that is open."""


@dataclass(frozen=True)
class Certificate:
    """What a branch and bound has shown of one box.

    Attributes
    ----------
    lower_bound : float
        No feasible point of the box costs less (in costs of the lone leader); infinite if none is feasible.
    boxes : int
        Boxes examined.
    is_closed : bool
        Whether every box was cleared at the asked tolerance.
    found : Basin or None
        A better solution met on the way, if any.
    """

    lower_bound: float
    boxes: int
    is_closed: bool
    found: Basin | None


def certify(
    problem: PairProblem,
    bounds: NDArray[np.float64],
    incumbent: float,
    tolerance: float,
    budget: int = SearchSettings.most_boxes,
    descend: Descend | None = None,
) -> Certificate:
    """Prove that no feasible point within bounds costs less than an incumbent by more than a tolerance.

    Parameters
    ----------
    problem : PairProblem
        The problem, in one piece of phase.
    bounds : (6, 2) ndarray of float
        Bounds in (x, y, z, h, R, t): the problem's, or those of its V part.
    incumbent : float
        Cost of the best solution known, in costs of the lone leader; infinite if none is known.
    tolerance : float
        By how much the incumbent may exceed the bound, as a share of the bound.
    budget : int
        Most boxes to examine.
    descend : callable, optional
        Starts -> the solutions that local solves within the bounds reach, best first.  With it open boxes are searched
        for better solutions, which then are to be undercut.

    Returns
    -------
    Certificate
        What was shown.
    """
    (x, y, z, h, ratio, phase) = bounds
    if np.any(bounds[:, 0] > bounds[:, 1]):
        return Certificate(np.inf, 0, True, None)
    lows, highs = np.empty((DEPTH, VARIABLE_COUNT)), np.empty((DEPTH, VARIABLE_COUNT))
    multipliers, floors = np.zeros((DEPTH, 2)), np.full(DEPTH, -np.inf)
    lows[0] = x[0], y[0], z[0] + 0.5 * h[0], z[0] - 0.5 * h[1], ratio[0], phase[0]
    highs[0] = x[1], y[1], z[1] + 0.5 * h[1], z[1] - 0.5 * h[0], ratio[1], phase[1]
    lows[0, 2:4] -= MARGIN
    highs[0, 2:4] += MARGIN
    limits, centre = Limits(*z, *h), np.empty(VARIABLE_COUNT)
    # Where phases are averaged none slides, and any end will do.
    phase_end = problem.phase_span() or 1.0
    clear, felt, before = problem.clearing(bounds)
    lows[0, 0] -= before
    # With no incumbent a box is cleared only where no balance is possible.
    best, threshold = incumbent, min(incumbent / (1.0 + tolerance), UNREACHABLE_COST)
    found: Basin | None = None
    height, boxes, left_open = 1, 0, np.inf
    while height > 0 and boxes < budget:
        height, examined, given_up = clear(
            lows,
            highs,
            multipliers,
            floors,
            height,
            limits,
            threshold,
            min(SEARCH_EVERY, budget - boxes),
            *felt,
            problem.constants,
            phase_end,
            problem.walls,
            centre,
        )
        boxes, left_open = boxes + examined, min(left_open, given_up)
        if descend and height > 0 and not np.isnan(centre[0]):
            better = next((one for one in descend(centre[None, :]) if one.cost < best), None)
            if better is not None:
                found, best, threshold = better, better.cost, better.cost / (1.0 + tolerance)
    left_open = min(left_open, np.min(floors[:height], initial=np.inf))
    # What stayed open before a better solution lowered the threshold may lie above it now.
    is_closed = bool(left_open >= threshold)
    lower_bound = np.inf if is_closed and not np.isfinite(best) else min(left_open, threshold)
    return Certificate(float(lower_bound), boxes, is_closed, found)
