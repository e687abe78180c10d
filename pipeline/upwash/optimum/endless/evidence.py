"""What speaks for a point behind an endless wake being a local optimum: as of a pair behind a wake that ends."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from upwash.optimum.compiled.descent import SCALE
from upwash.optimum.compiled.endless_descent import evaluate_on_sides, lagrangian_hessian_endless
from upwash.optimum.compiled.endless_edges import edge_distance, edge_pull
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.evidence import ON_BOUND, ON_EDGE, PRESSED, Evidence
from upwash.optimum.problem import VARIABLES

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
    wake, stations = problem.wake_felt, problem.stations
    distances, normals = _edge_distances(problem, point)
    near = np.flatnonzero(np.abs(distances) < REACH)
    side = np.where(distances[near] < ON_EDGE, -1.0, 1.0)
    on_edge = np.abs(distances[near]) < ON_EDGE
    gradient, jacobian = _slopes(problem, point, near, side)
    at_lower = point - problem.bounds[:, 0] <= ON_BOUND * SCALE
    at_upper = problem.bounds[:, 1] - point <= ON_BOUND * SCALE
    # X goes round, and the sixth variable has no range: neither is ever held by a bound.
    at_lower[[0, 5]] = at_upper[[0, 5]] = False
    bound_rows = np.concatenate([-np.eye(6)[at_lower], np.eye(6)[at_upper]])
    edge_rows = normals[near[on_edge]]
    columns = np.concatenate([jacobian, edge_rows, bound_rows]).T * SCALE[:, None]
    solution, _, independent, _ = np.linalg.lstsq(columns, -gradient * SCALE, rcond=1e-12)
    left = float(np.max(np.abs(gradient * SCALE + columns @ solution)))
    edges = 2 + len(edge_rows)
    violation = max(0.0, *(-solution[edges:]), 0.0)
    for multiplier, edge, normal in zip(solution[2:edges], near[on_edge], edge_rows, strict=True):
        pull = edge_pull(point, wake, stations, edge, solution[:2], np.empty(2), np.empty((2, 6)))
        size = float(np.max(np.abs(normal * SCALE)))
        violation = max(violation, -multiplier * size, (multiplier + pull) * size)
    if independent < columns.shape[1]:
        solution, left = _piecewise(problem, point, near, side, on_edge, columns[:, 2:])
        violation = 0.0
    multipliers = np.zeros(len(near))
    multipliers[on_edge] = solution[2:edges]
    hessian = np.empty((6, 6))
    lagrangian_hessian_endless(
        point.copy(),
        wake,
        problem.constants,
        stations,
        near,
        side,
        multipliers,
        len(near),
        solution[:2].copy(),
        np.empty((4, wake.steps.shape[1])),
        np.empty((8, 6)),
        hessian,
    )
    is_held = np.ones(columns.shape[1], dtype=bool)
    is_held[edges:] = solution[edges:] > PRESSED
    # The sixth variable is not free.
    held = np.concatenate([columns[:, is_held].T, np.eye(6)[5:]])
    _, singular, rows = np.linalg.svd(held)
    free = rows[np.sum(singular > 1e-9 * max(1.0, singular[0])) :]
    scaled = hessian * np.outer(SCALE, SCALE)
    curvature = float(np.min(np.linalg.eigvalsh(free @ scaled @ free.T))) if len(free) else None
    names = [f"{name}_lower" for name, active in zip(VARIABLES, at_lower, strict=True) if active]
    names += [f"{name}_upper" for name, active in zip(VARIABLES, at_upper, strict=True) if active]
    return Evidence(
        active_bounds=tuple(names),
        core_edges=tuple(int(edge) for edge in near[on_edge]),
        multiplier_lift=float(solution[0]),
        multiplier_thrust=float(solution[1]),
        stationarity=max(left, float(violation)),
        curvature=curvature,
    )


def _edge_distances(
    problem: EndlessProblem, point: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances of all core edges and their gradients."""
    count = problem.wake_felt.steps.shape[1] * problem.stations.shape[2]
    distances, normals = np.empty(count), np.empty((count, 6))
    for edge in range(count):
        distances[edge] = edge_distance(point, problem.wake_felt, problem.stations, edge, normals[edge])
    return distances, normals


def _slopes(
    problem: EndlessProblem, point: NDArray[np.float64], near: NDArray[np.int64], side: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the gradient of the cost and the Jacobian of the balances, seen from a side of each near edge."""
    gradient, jacobian, places = (
        np.empty(6),
        np.empty((2, 6)),
        np.empty((4, problem.wake_felt.steps.shape[1])),
    )
    evaluate_on_sides(
        point.copy(),
        problem.wake_felt,
        problem.constants,
        problem.stations,
        near,
        side,
        len(near),
        places,
        np.empty(2),
        np.empty(2),
        gradient,
        jacobian,
    )
    return gradient, jacobian


def _piecewise(
    problem: EndlessProblem,
    point: NDArray[np.float64],
    near: NDArray[np.int64],
    side: NDArray[np.float64],
    on_edge: NDArray[np.bool_],
    normals: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Look for multipliers of the right signs within each smooth piece that meets in a point.

    Returns
    -------
    multipliers : ndarray of float
        Those of the piece inside all edges: of the balances, the edges and the bounds.
    left : float
        What is left of the gradient in the worst piece.
    """
    found, worst = np.empty(0), 0.0
    for sides in product((1.0, -1.0), repeat=int(np.count_nonzero(on_edge))):
        seen = side.copy()
        seen[on_edge] = -np.array(sides)
        gradient, jacobian = _slopes(problem, point, near, seen)
        balances = jacobian.T * SCALE[:, None]
        outward = normals * np.append(sides, np.ones(normals.shape[1] - len(sides)))
        columns = np.hstack([balances, -balances, outward])
        solution, _ = nnls(columns, -gradient * SCALE)
        worst = max(worst, float(np.max(np.abs(gradient * SCALE + columns @ solution))))
        if not found.size:
            found = np.concatenate([solution[:2] - solution[2:4], solution[4:]])
    return found, worst
