"""Local solves that each have bounds of their own: compiled."""

from __future__ import annotations

from typing import Any

import numpy as np

from upwash.kernel import kernel
from upwash.optimum.compiled.endless_descent import solve_endless
from upwash.optimum.compiled.pair_descent import solve_local


def _descents(solve: Any) -> Any:
    """Return the solves from many starts of one kind of wake."""

    @kernel
    def descend_each(starts, bounds, felt, constants, edges, points, costs, status):
        """Solve from each start within its own bounds.

        Parameters
        ----------
        starts : (n, 6) ndarray of float
            Starts.
        bounds : (n, 6, 2) ndarray of float
            The bounds of each; a variable that is held has a range of no width.
        felt, constants
            As for the local solve.
        edges : int
            Number of core edges.
        points, costs, status : (n, 6), (n,) and (n,) ndarray
            Overwritten: where each solve ended, at what cost, and with what.
        """
        multipliers, pins = np.empty(2), np.empty(edges)
        for k in range(starts.shape[0]):
            status[k], costs[k], _ = solve(
                starts[k], felt, constants, bounds[k], points[k], multipliers, pins
            )

    return descend_each


descend_each_pair, descend_each_endless = _descents(solve_local), _descents(solve_endless)
