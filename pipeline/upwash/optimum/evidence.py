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

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from upwash.aero.compiled.lanes import HEIGHT, NODE, PHASE, X, Y, Z
from upwash.optimum.compiled.edges import edge_pull
from upwash.optimum.compiled.pair_descent import FeltLanes, fill_hessian
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.compiled.programme import new_balance
from upwash.optimum.core_edge import BOTH, CoreEdge
from upwash.optimum.edges import FILAMENTS, edge_distances
from upwash.optimum.problem import PairProblem
from upwash.optimum.spacing import UNITS, touched_walls
from upwash.optimum.steepness import Held, Vicinity, steepness
from upwash.optimum.variables import SCALE, VARIABLE_COUNT, VARIABLES

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
    point : (6,) ndarray of float
        The point.
    prices : dict
        Bound or wall that the point lies on -> its multiplier: what the cost falls by, per unit, where it gives way.
    vicinity : Vicinity
        The smooth pieces that meet in it.
    held : Held
        What holds it there.
    """

    active_bounds: tuple[str, ...]
    core_edges: tuple[int, ...]
    multiplier_lift: float
    multiplier_thrust: float
    stationarity: float
    curvature: float | None
    point: NDArray[np.float64]
    prices: dict[str, float]
    vicinity: Vicinity
    held: Held


def gather_evidence(problem: PairProblem, felt: FeltLanes, point: NDArray[np.float64]) -> Evidence:
    """Examine a balanced point, trusting nothing of the solve that found it.

    Parameters
    ----------
    problem : PairProblem
        The problem.
    felt : FeltLanes
        Its wake and core edges, see `upwash.optimum.edges.felt_lanes`.
    point : (6,) ndarray of float
        The point, in scaled variables.

    Returns
    -------
    Evidence
        What was found.
    """
    distances, normals = edge_distances(felt, point)
    on_edge = np.flatnonzero(np.abs(distances) < ON_EDGE)
    # The sides are held as they are, for an edge may be nearer than the step of the differences.
    held = np.where(distances[felt.group] < ON_EDGE, np.inf, -1.0)
    none = np.empty(0, np.int64), np.empty(0), 0
    touched = touched_walls(problem.wall_names, problem.walls, point)

    def slopes(sides: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        edges, balance = held.copy(), new_balance()
        for edge, side in zip(on_edge, sides, strict=True):
            edges[felt.group == edge] = np.inf if side > 0.0 else -1.0
        evaluate(point, felt.lanes, edges, problem.constants, *balance)
        return balance.gradient, balance.jacobian

    def hessian(multipliers: NDArray[np.float64], of_edges: NDArray[np.float64]) -> NDArray[np.float64]:
        pins, found = np.zeros(len(distances)), np.empty((VARIABLE_COUNT, VARIABLE_COUNT))
        pins[on_edge] = of_edges
        work, pinned = np.empty((8, VARIABLE_COUNT)), np.empty(len(on_edge), np.int64)
        fill_hessian(point, felt, problem.constants, held, *none, pins, multipliers, pinned, work, found)
        return found

    def pull(edge: int, multipliers: NDArray[np.float64]) -> float:
        return edge_pull(point, felt.lanes, felt.group, edge, multipliers)

    vicinity = Vicinity(on_edge, normals[on_edge], touched, slopes, pull, hessian)
    fixed = [] if problem.phase_span() > 0.0 else [PHASE]
    return weigh(point, problem.bounds, vicinity, fixed=fixed)


def weigh(
    point: NDArray[np.float64],
    bounds: NDArray[np.float64],
    vicinity: Vicinity,
    *,
    unbounded: Sequence[int] = (),
    fixed: Sequence[int] = (),
) -> Evidence:
    """Say what speaks for a point, by the smooth pieces that meet in it.

    Parameters
    ----------
    point : (6,) ndarray of float
        The point, in scaled variables.
    bounds : (6, 2) ndarray of float
        Bounds of the variables.
    vicinity : Vicinity
        The pieces.
    unbounded : sequence of int
        Variables that are never held by a bound.
    fixed : sequence of int
        Variables that have no range.

    Returns
    -------
    Evidence
        What was found.
    """
    on_edge, normals = vicinity.on_edge, vicinity.normals
    gradient, jacobian = vicinity.slopes(np.ones(len(on_edge)))
    at_lower = point - bounds[:, 0] <= ON_BOUND * SCALE
    at_upper = bounds[:, 1] - point <= ON_BOUND * SCALE
    at_lower[[*unbounded, *fixed]] = at_upper[[*unbounded, *fixed]] = False
    bound_rows = np.concatenate([-np.eye(VARIABLE_COUNT)[at_lower], np.eye(VARIABLE_COUNT)[at_upper]])
    # Gradient + jacobianᵀ ν + normalsᵀ λ + boundᵀ ω = 0 in units of SCALE; ω must not be negative.
    columns = np.concatenate([jacobian, normals, bound_rows, vicinity.touched.outward]).T * SCALE[:, None]
    solution, _, independent, _ = np.linalg.lstsq(columns, -gradient * SCALE, rcond=1e-12)
    left = np.max(np.abs(gradient * SCALE + columns @ solution))
    edges = 2 + len(on_edge)
    violation = max(0.0, *(-solution[edges:]), 0.0)
    for multiplier, edge, normal in zip(solution[2:edges], on_edge, normals, strict=True):
        pull = vicinity.pull(int(edge), solution[:2])
        size = float(np.max(np.abs(normal * SCALE)))
        violation = max(violation, -multiplier * size, (multiplier + pull) * size)
    if independent < columns.shape[1]:
        solution, left = _piecewise(vicinity, columns[:, 2:])
        violation = 0.0
    hessian = vicinity.hessian(solution[:2].copy(), solution[2:edges])
    walls = edges + len(bound_rows)
    hessian -= np.tensordot(solution[walls:], vicinity.touched.hessians, axes=1)
    is_held = np.ones(columns.shape[1], dtype=bool)
    is_held[edges:] = solution[edges:] > PRESSED
    held = columns[:, is_held].T
    _, singular, rows = np.linalg.svd(np.concatenate([held, np.eye(VARIABLE_COUNT)[list(fixed)]]))
    free = rows[np.sum(singular > 1e-9 * max(1.0, singular[0])) :]
    curvature = None
    scaled = hessian * np.outer(SCALE, SCALE)
    if len(free):
        curvature = float(np.min(np.linalg.eigvalsh(free @ scaled @ free.T)))

    bound_names = names_of(at_lower, "lower") + names_of(at_upper, "upper")
    return Evidence(
        active_bounds=(*bound_names, *vicinity.touched.names),
        core_edges=tuple(int(edge) for edge in on_edge),
        multiplier_lift=float(solution[0]),
        multiplier_thrust=float(solution[1]),
        stationarity=float(max(left, violation)),
        curvature=curvature,
        point=point,
        prices=dict(zip((*bound_names, *vicinity.touched.names), solution[edges:].tolist(), strict=True)),
        vicinity=vicinity,
        held=Held(
            held,
            solution[is_held],
            free,
            scaled,
            np.array([at_lower, at_upper]).T,
            is_unique=independent == columns.shape[1],
        ),
    )


def names_of(active: NDArray[np.bool_], side: str) -> list[str]:
    """Name the bounds of one side that a point lies on."""
    return [f"{name}_{side}" for name, is_active in zip(VARIABLES, active, strict=True) if is_active]


def _restores(vicinity: Vicinity, balance: int, axis: int, sign: float) -> bool:
    """Whether a force has a slope of a sign along an axis, on both sides of the point, while the stroke is held."""
    sides = np.sign(vicinity.normals[:, axis])
    slopes = [vicinity.slopes(inside)[1][balance, axis] for inside in (sides, -sides)]
    return all(sign * slope > 0.0 for slope in slopes)


def _piecewise(vicinity: Vicinity, normals: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Look for multipliers of the right signs within each smooth piece that meets in a point.

    Parameters
    ----------
    vicinity : Vicinity
        The pieces.
    normals : (6, e + b) ndarray of float
        Outward normals of the core edges and of the active bounds, in units of `SCALE`.

    Returns
    -------
    multipliers : (2 + e + b,) ndarray of float
        Those of the piece inside all edges: of the balances, the edges and the bounds.
    left : float
        What is left of the gradient in the worst piece.
    """
    found, worst = np.empty(0), 0.0
    for sides in product((1.0, -1.0), repeat=len(vicinity.on_edge)):
        gradient, jacobian = vicinity.slopes(np.array(sides))
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
    slope_ahead_per_m: float | None
    slope_behind_per_m: float | None
    slope_inward_per_m: float | None
    slope_outward_per_m: float | None
    slope_below_per_m: float | None
    slope_above_per_m: float | None
    slope_earlier: float | None
    slope_later: float | None
    curvature_ahead_per_m2: float | None
    curvature_behind_per_m2: float | None
    curvature_inward_per_m2: float | None
    curvature_outward_per_m2: float | None
    curvature_below_per_m2: float | None
    curvature_above_per_m2: float | None
    curvature_earlier: float | None
    curvature_later: float | None
    restores_x: bool
    restores_z: bool
    x_min_costs_per_m: float | None
    wingtip_gap_min_costs_per_m: float | None
    distance_min_costs_per_m: float | None
    bearing_max_costs_per_deg: float | None

    @classmethod
    def of(cls, problem: PairProblem, evidence: Evidence, edges: Iterable[CoreEdge]) -> StatedEvidence:
        """State evidence, of which the core edges are named."""
        return cls(
            active_bounds=",".join(evidence.active_bounds),
            core_edges=", ".join(map(str, edges)),
            stationarity=evidence.stationarity,
            curvature=evidence.curvature,
            multiplier_lift=evidence.multiplier_lift,
            multiplier_thrust=evidence.multiplier_thrust,
            **_rise_in_si(problem, evidence),
            restores_x=_restores(evidence.vicinity, 1, X, 1.0),
            restores_z=_restores(evidence.vicinity, 0, Z, -1.0),
            **_prices_in_si(problem, evidence),
        )


SIDES = (("ahead", "behind"), ("inward", "outward"), ("below", "above"), ("earlier", "later"))
"""To which sides x, y, z and the phase are less and more."""


RISES = tuple(
    entry.name for entry in fields(StatedEvidence) if entry.name.startswith(("slope_", "curvature_"))
)
"""Fields of the rise along x, y, z and the phase."""


def _rise_in_si(problem: PairProblem, evidence: Evidence) -> dict[str, float | None]:
    """Return how the cost, as a share of the lone bird's, rises by m and by wingbeat, by the columns of the results."""
    # A bird that keeps its own beat has no phase.
    axes = (X, Y, Z, problem.phase_axis[0])[: len(SIDES) if problem.phase_lock else -1]
    rise = steepness(evidence.vicinity, evidence.held, axes)
    b, found = problem.bird.semispan_m, dict[str, float | None](dict.fromkeys(RISES))
    for axis, sides in enumerate(SIDES[: len(axes)]):
        is_phase = axis == len(SIDES) - 1
        variable, by_phase = problem.phase_axis if is_phase else (axis, 1.0)
        unit = by_phase if is_phase else 1.0 / b
        is_free = problem.distance_is_free and not is_phase and variable == X
        for number, side in enumerate(sides if unit > 0.0 else reversed(sides)):
            # Beyond a plane of symmetry it is as before it.
            is_end = np.isinf(rise.slope[axis, number])
            told = 1 - number if is_end and problem.mirrors(variable, number) else number
            slope, curvature = rise.slope[axis, told], rise.curvature[axis, told]
            # Where the phase makes up for any distance, none costs anything.
            slope = 0.0 if is_free else slope / SCALE[variable] * abs(unit)
            curvature = 0.0 if is_free else curvature / SCALE[variable] ** 2 * unit**2
            per_m, per_m2 = ("", "") if is_phase else ("_per_m", "_per_m2")
            found[f"slope_{side}{per_m}"] = float(slope) if np.isfinite(slope) else None
            found[f"curvature_{side}{per_m2}"] = float(curvature) if np.isfinite(curvature) else None
    return found


def _prices_in_si(problem: PairProblem, evidence: Evidence) -> dict[str, float | None]:
    """Return what each limit of the place costs, as a share of the lone bird's cost, by the columns of the results.

    It is None where there is no such limit, or where no single multiplier is its own.
    """
    spans = problem.bird.semispan_m, problem.distance_asked_m, problem.leader.semispan_m
    prices = problem.spacing.prices(evidence.point[:2], evidence.prices, *spans)
    return {
        f"{name.removesuffix(f'_{unit}')}_costs_per_{unit}": (
            prices.get(name) if evidence.held.is_unique or not prices.get(name) else None
        )
        for name, unit in UNITS.items()
    }


def name_edge(problem: PairProblem, lane: int, filament: int) -> CoreEdge:
    """Name a core edge by a lane and a filament of it."""
    height, node = problem.lanes[HEIGHT, lane], problem.lanes[NODE, lane]
    point = BOTH if filament < 2 else ("left" if node < 0 else "right")
    if filament >= 2 and abs(node) < 1.0:
        point = f"{node:+.3g}"
    state = {0.5: "up", -0.5: "down"}.get(float(height), f"{height:+.3g}")
    return CoreEdge(point, state, FILAMENTS[filament], *problem.ring_parts(int(problem.ring_of_lane[lane])))
