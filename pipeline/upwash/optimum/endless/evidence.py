"""What speaks for a point behind an endless wake being a local optimum: as of a pair behind a wake that ends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import PHASE, X
from upwash.optimum.compiled.endless_descent import evaluate_endless, fill_endless_hessian, make_room
from upwash.optimum.compiled.endless_edges import edge_distance, edge_pull
from upwash.optimum.compiled.programme import new_balance
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.evidence import ON_EDGE, Evidence, weigh
from upwash.optimum.spacing import touched_walls
from upwash.optimum.steepness import Vicinity
from upwash.optimum.variables import VARIABLE_COUNT

REACH = 1e-3
"""Core edges nearer than this, as s = q/r_c² − 1, are seen from the side on which the point lies."""


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
    felt, place, room = problem.felt, point.copy(), make_room(problem.felt)
    distances, normals = _edge_distances(problem, point)
    # X goes round, or has no range as the sixth variable has none.
    fixed = [PHASE] if problem.phase_lock else [X, PHASE]
    near = np.flatnonzero(np.abs(distances) < REACH)
    side = np.where(distances[near] < ON_EDGE, -1.0, 1.0)
    is_on = np.abs(distances[near]) < ON_EDGE
    on_edge = near[is_on]

    def slopes(sides: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        seen, balance = side.copy(), new_balance()
        seen[is_on] = -sides
        evaluate_endless(place, felt, problem.constants, room, near, seen, len(near), balance)
        balance.jacobian[:, fixed] = 0.0
        return balance.gradient, balance.jacobian

    def hessian(multipliers: NDArray[np.float64], of_edges: NDArray[np.float64]) -> NDArray[np.float64]:
        pins, found = np.zeros(len(distances)), np.empty((VARIABLE_COUNT, VARIABLE_COUNT))
        pins[on_edge] = of_edges
        seen = near, side, len(near)
        work, pinned = np.empty((8, VARIABLE_COUNT)), np.empty(len(on_edge), np.int64)
        fill_endless_hessian(
            place, felt, problem.constants, room, *seen, pins, multipliers, pinned, work, found
        )
        return found

    def pull(edge: int, multipliers: NDArray[np.float64]) -> float:
        return edge_pull(point, felt.wake, felt.stations, edge, multipliers, room.force, room.jacobian)

    normals[:, fixed] = 0.0
    touched = touched_walls(problem.wall_names, problem.walls, point)
    vicinity = Vicinity(on_edge, normals[on_edge], touched, slopes, pull, hessian)
    return weigh(point, problem.bounds, vicinity, unbounded=(X,), fixed=fixed)


def _edge_distances(
    problem: EndlessProblem, point: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances of all core edges and their gradients."""
    count = problem.wake_felt.steps.shape[1] * problem.stations.shape[2]
    distances, normals, felt = np.empty(count), np.empty((count, VARIABLE_COUNT)), problem.felt
    for edge in range(count):
        distances[edge] = edge_distance(point, felt.wake, felt.stations, edge, normals[edge])
    return distances, normals
