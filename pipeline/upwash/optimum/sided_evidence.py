"""What speaks for a point being a local optimum where a core edge is seen from a side by what that changes.

So it is of a wake that is felt on the whole span, which has no core edges but those of the spanwise filaments.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.compiled import cut_descent, endless_descent
from upwash.optimum.compiled.programme import new_balance
from upwash.optimum.evidence import ON_EDGE, Evidence, weigh
from upwash.optimum.spacing import touched_walls
from upwash.optimum.steepness import Vicinity
from upwash.optimum.variables import VARIABLE_COUNT

REACH = 1e-3
"""Core edges nearer than this, as s = q/r_c² − 1, are seen from the side on which the point lies."""


class Asked(NamedTuple):
    """What is asked of a kind of wake: the kernels of its local solve, see `upwash.optimum.compiled.descent`."""

    make_room: Callable[..., Any]
    evaluate: Callable[..., Any]
    count_edges: Callable[..., int]
    edge_distance: Callable[..., float]
    edge_pull: Callable[..., float]
    fill_hessian: Callable[..., None]


ENDLESS = Asked(
    endless_descent.make_room,
    endless_descent.evaluate_endless,
    endless_descent.count_edges,
    endless_descent.edge_distance,
    endless_descent.edge_pull,
    endless_descent.fill_endless_hessian,
)

CUT = Asked(
    cut_descent.make_room,
    cut_descent.evaluate_cut,
    cut_descent.count_edges,
    cut_descent.edge_distance,
    cut_descent.edge_pull,
    cut_descent.fill_cut_hessian,
)


def gather_sided_evidence(
    problem: Any,
    point: NDArray[np.float64],
    asked: Asked,
    *,
    unbounded: Sequence[int] = (),
    fixed: Sequence[int] = (),
) -> Evidence:
    """Examine a balanced point, trusting nothing of the solve that found it.

    Parameters
    ----------
    problem : CutProblem or EndlessProblem
        The problem.
    point : (6,) ndarray of float
        The point, in scaled variables.
    asked : Asked
        What is asked of its wake.
    unbounded, fixed : sequence of int
        As for `upwash.optimum.evidence.weigh`.

    Returns
    -------
    Evidence
        What was found.
    """
    felt, place, room = problem.felt, point.copy(), asked.make_room(problem.felt)
    distances, normals = _edge_distances(felt, point, asked)
    near = np.flatnonzero(np.abs(distances) < REACH)
    side = np.where(distances[near] < ON_EDGE, -1.0, 1.0)
    is_on = np.abs(distances[near]) < ON_EDGE
    on_edge = near[is_on]

    def slopes(sides: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        seen, balance = side.copy(), new_balance()
        seen[is_on] = -sides
        asked.evaluate(place, felt, problem.constants, room, near, seen, len(near), balance)
        balance.jacobian[:, fixed] = 0.0
        return balance.gradient, balance.jacobian

    def hessian(multipliers: NDArray[np.float64], of_edges: NDArray[np.float64]) -> NDArray[np.float64]:
        pins, found = np.zeros(len(distances)), np.empty((VARIABLE_COUNT, VARIABLE_COUNT))
        pins[on_edge] = of_edges
        seen = near, side, len(near)
        work, pinned = np.empty((8, VARIABLE_COUNT)), np.empty(len(on_edge), np.int64)
        asked.fill_hessian(
            place, felt, problem.constants, room, *seen, pins, multipliers, pinned, work, found
        )
        return found

    def pull(edge: int, multipliers: NDArray[np.float64]) -> float:
        return asked.edge_pull(point, felt, edge, multipliers, room)

    normals[:, fixed] = 0.0
    touched = touched_walls(problem.wall_names, problem.walls, point)
    vicinity = Vicinity(on_edge, normals[on_edge], touched, slopes, pull, hessian)
    return weigh(point, problem.bounds, vicinity, unbounded=unbounded, fixed=fixed)


def _edge_distances(
    felt: Any, point: NDArray[np.float64], asked: Asked
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances of all core edges and their gradients."""
    count = asked.count_edges(felt)
    distances, normals = np.empty(count), np.empty((count, VARIABLE_COUNT))
    for edge in range(count):
        distances[edge] = asked.edge_distance(point, felt, edge, normals[edge])
    return distances, normals
