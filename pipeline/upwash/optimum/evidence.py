"""What speaks for a point being a local optimum: bounds, core edges, multipliers, stationarity, curvature.

At a core edge the gradient jumps, and a point pinned there is stationary if zero lies between the gradients
of the two sides (in the generalised gradient): the multiplier of the edge, told from inside, must lie between
0 and minus the edge's pull.

Where more surfaces meet than there are variables, as when a follower flaps just as far as the bird ahead and
two core edges cross on that bound, multipliers are not unique and an edge may even be a ridge that the bound
keeps shut.  There the point is stationary if it is so within each of the smooth pieces that meet in it.

A bound may also be reached without being pressed on: straight behind the leader everything is level to port and
starboard, by symmetry, and whether the follower gains by moving aside is told by the curvature alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from upwash.aero.compiled.lanes import HEIGHT, NODE
from upwash.optimum.compiled.descent import SCALE, lagrangian_hessian
from upwash.optimum.compiled.edges import edge_distance, edge_pull
from upwash.optimum.compiled.problem import CORE2, evaluate
from upwash.optimum.core_edge import BOTH, CoreEdge
from upwash.optimum.edges import FILAMENTS
from upwash.optimum.problem import VARIABLES, PairProblem

ON_EDGE = 1e-7
"""Largest distance from a core edge, as s = r²/r_c² − 1, of a point that lies on it."""

ON_BOUND = 1e-9
"""Largest distance from a bound, in units of the variable's scale, of a point that lies on it."""


PRESSED = 1e-8
"""Least multiplier, per unit of `SCALE`, of a bound that holds the point; a lesser one leaves its variable free."""


@dataclass(frozen=True)
class Evidence:
    """What holds at a point.

    Attributes
    ----------
    active_bounds : tuple of str
        Variables at a bound, as ``h_upper``.
    core_edges : tuple of int
        Numbers of the core edges that the point lies on.
    multiplier_lift, multiplier_thrust : float
        Multipliers of the two balances, cost and residuals as in the scaled problem.
    stationarity : float
        What is left of the generalised gradient of the Lagrangian, per unit of `SCALE`; 0 at an optimum.
    curvature : float or None
        Least curvature of the Lagrangian along the directions that balances, edges and the bounds pressed on
        leave free, per unit of `SCALE` squared; None if none is left.
    """

    active_bounds: tuple[str, ...]
    core_edges: tuple[int, ...]
    multiplier_lift: float
    multiplier_thrust: float
    stationarity: float
    curvature: float | None


def gather_evidence(
    problem: PairProblem,
    group: NDArray[np.int64],
    representative: NDArray[np.int64],
    point: NDArray[np.float64],
) -> Evidence:
    """Examine a balanced point, trusting nothing of the solve that found it.

    Parameters
    ----------
    problem : PairProblem
        The problem.
    group, representative : ndarray of int
        Its core edges, see `upwash.optimum.edges.distinct_edges`.
    point : (6,) ndarray of float
        The point, in scaled variables.

    Returns
    -------
    Evidence
        What was found.
    """
    core2, lanes = problem.constants[CORE2], problem.lanes
    distances, normals = np.empty(len(representative)), np.empty((len(representative), 6))
    for number, (lane, filament) in enumerate(representative):
        distances[number] = edge_distance(point, lanes, core2, lane, filament, normals[number])
    on_edge = np.flatnonzero(np.abs(distances) < ON_EDGE)
    # The sides are held as they are, for an edge may be nearer than the step of the differences below.
    edges = np.where(distances[group] < ON_EDGE, np.inf, -1.0)
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    evaluate(point, lanes, edges, problem.constants, residual, gradient, jacobian)

    at_lower = point - problem.bounds[:, 0] <= ON_BOUND * SCALE
    at_upper = problem.bounds[:, 1] - point <= ON_BOUND * SCALE
    bound_rows = np.concatenate([-np.eye(6)[at_lower], np.eye(6)[at_upper]])
    normals = normals[on_edge]
    # Gradient + jacobianᵀ ν + normalsᵀ λ + boundᵀ ω = 0 in units of SCALE; ω must not be negative.
    columns = np.concatenate([jacobian, normals, bound_rows]).T * SCALE[:, None]
    solution, _, independent, _ = np.linalg.lstsq(columns, -gradient * SCALE, rcond=1e-12)
    left = np.max(np.abs(gradient * SCALE + columns @ solution))
    edge_multipliers = solution[2 : 2 + len(on_edge)]
    violation = max(0.0, *(-solution[2 + len(on_edge) :]), 0.0)
    for multiplier, edge, normal in zip(edge_multipliers, on_edge, normals, strict=True):
        pull = edge_pull(point, lanes, core2, group, int(edge), solution[:2])
        size = float(np.max(np.abs(normal * SCALE)))
        violation = max(violation, -multiplier * size, (multiplier + pull) * size)
    if independent < columns.shape[1]:
        solution, left = _piecewise(problem, group, point, on_edge, columns[:, 2:])
        edge_multipliers, violation = solution[2 : 2 + len(on_edge)], 0.0
    multipliers = solution[:2]

    all_multipliers = np.zeros(len(representative))
    all_multipliers[on_edge] = edge_multipliers
    hessian = np.empty((6, 6))
    lagrangian_hessian(
        point,
        lanes,
        edges,
        problem.constants,
        multipliers,
        representative,
        all_multipliers,
        np.empty((8, 6)),
        hessian,
    )
    is_held = np.ones(columns.shape[1], dtype=bool)
    is_held[2 + len(on_edge) :] = solution[2 + len(on_edge) :] > PRESSED
    _, singular, rows = np.linalg.svd(columns[:, is_held].T)
    free = rows[np.sum(singular > 1e-9 * max(1.0, singular[0])) :]
    curvature = None
    if len(free):
        scaled = hessian * np.outer(SCALE, SCALE)
        curvature = float(np.min(np.linalg.eigvalsh(free @ scaled @ free.T)))
    names = [f"{name}_lower" for name, active in zip(VARIABLES, at_lower, strict=True) if active]
    names += [f"{name}_upper" for name, active in zip(VARIABLES, at_upper, strict=True) if active]
    return Evidence(
        active_bounds=tuple(names),
        core_edges=tuple(int(edge) for edge in on_edge),
        multiplier_lift=float(multipliers[0]),
        multiplier_thrust=float(multipliers[1]),
        stationarity=float(max(left, violation)),
        curvature=curvature,
    )


def _piecewise(
    problem: PairProblem,
    group: NDArray[np.int64],
    point: NDArray[np.float64],
    on_edge: NDArray[np.intp],
    normals: NDArray[np.float64],
) -> tuple[NDArray[np.float64], float]:
    """Look for multipliers of the right signs within each smooth piece that meets in a point.

    Parameters
    ----------
    problem, group, point
        As for `gather_evidence`.
    on_edge : (e,) ndarray of int
        Core edges that the point lies on.
    normals : (6, e + b) ndarray of float
        Outward normals of those edges and of the active bounds, in units of `SCALE`.

    Returns
    -------
    multipliers : (2 + e + b,) ndarray of float
        Those of the piece inside all edges: of the balances, the edges and the bounds.
    left : float
        What is left of the gradient in the worst piece.
    """
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    found, worst = np.empty(0), 0.0
    for sides in product((1.0, -1.0), repeat=len(on_edge)):
        edges = np.full(group.shape, problem.constants[CORE2])
        for edge, side in zip(on_edge, sides, strict=True):
            edges[group == edge] = np.inf if side > 0.0 else -1.0
        evaluate(point, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
        balances = jacobian.T * SCALE[:, None]
        outward = normals * np.append(sides, np.ones(normals.shape[1] - len(sides)))
        # The balances' multipliers have either sign: each is the difference of two that are not negative.
        columns = np.hstack([balances, -balances, outward])
        solution, _ = nnls(columns, -gradient * SCALE)
        worst = max(worst, float(np.max(np.abs(gradient * SCALE + columns @ solution))))
        if not found.size:
            found = np.concatenate([solution[:2] - solution[2:4], solution[4:]])
    return found, worst


@dataclass(frozen=True)
class StatedEvidence:
    """Evidence as it is stated: bounds and core edges by their names; the fields are the columns of the results."""

    active_bounds: str
    core_edges: str
    stationarity: float
    curvature: float | None
    multiplier_lift: float
    multiplier_thrust: float

    @classmethod
    def of(cls, evidence: Evidence, edges: Iterable[CoreEdge]) -> StatedEvidence:
        """State evidence, of which the core edges are named."""
        return cls(
            active_bounds=",".join(evidence.active_bounds),
            core_edges=", ".join(map(str, edges)),
            stationarity=evidence.stationarity,
            curvature=evidence.curvature,
            multiplier_lift=evidence.multiplier_lift,
            multiplier_thrust=evidence.multiplier_thrust,
        )


def stated(problem: PairProblem, representative: NDArray[np.int64], evidence: Evidence) -> StatedEvidence:
    """State the evidence at a point; parameters as for `gather_evidence`."""
    edges = (name_edge(problem, *representative[edge]) for edge in evidence.core_edges)
    return StatedEvidence.of(evidence, edges)


def name_edge(problem: PairProblem, lane: int, filament: int) -> CoreEdge:
    """Name a core edge by a lane and a filament of it."""
    height, node = problem.lanes[HEIGHT, lane], problem.lanes[NODE, lane]
    point = BOTH if filament < 2 else ("left" if node < 0 else "right")
    if filament >= 2 and abs(node) < 1.0:
        point = f"{node:+.3g}"
    state = {0.5: "up", -0.5: "down"}.get(float(height), f"{height:+.3g}")
    return CoreEdge(point, state, FILAMENTS[filament], *problem.ring_parts(int(problem.ring_of_lane[lane])))
