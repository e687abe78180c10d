"""The local solve behind a wake that ends and is felt on the whole span: how its core edges are seen from a side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.cut_wake import CutWake, cut_wake_force
from upwash.kernel import kernel
from upwash.optimum.compiled import cut_edges as edges
from upwash.optimum.compiled.cut_edges import edge_force
from upwash.optimum.compiled.descent import descent
from upwash.optimum.compiled.problem import add_own_flight
from upwash.optimum.compiled.walls import NEVER_CROSSED, wall_value
from upwash.optimum.variables import VARIABLE_COUNT

_distance = edges.edge_distance


class FeltCutWake(NamedTuple):
    """A wake that ends as the follower's whole span feels it, and its core edges.

    Attributes
    ----------
    wake : CutWake
        The wake, in semispans and weights.
    stations : (14, m) ndarray of float
        See `upwash.optimum.compiled.cut_edges`; none of a core without an edge.
    edges : (e + 1,) ndarray of int
        Where the stations of each edge begin, and where the last end.
    walls : (w, 7) ndarray of float
        Limits of the place, see `upwash.optimum.compiled.walls`; they are numbered on after the edges.
    """

    wake: CutWake
    stations: NDArray[np.float64]
    edges: NDArray[np.int64]
    walls: NDArray[np.float64]


class CutRoom(NamedTuple):
    """Scratch for an evaluation.

    Attributes
    ----------
    runs : (p, 9, r) ndarray of float
        Runs of the wake, their cuts moved.
    force, jacobian : (2,) and (2, 6) ndarray of float
        Of core edges.
    """

    runs: NDArray[np.float64]
    force: NDArray[np.float64]
    jacobian: NDArray[np.float64]


@kernel
def make_room(felt):
    """Return scratch for evaluations."""
    return CutRoom(felt.wake.runs.copy(), np.empty(2), np.empty((2, VARIABLE_COUNT)))


@kernel(allocates=False)
def evaluate_cut(point, felt, constants, room, near, side, count, balance):
    """Return the scaled cost of a point; fill in its gradient and the balances with their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    felt : FeltCutWake
        The wake.
    constants, near, side, count, balance
        As for `upwash.optimum.compiled.endless_descent.evaluate_endless`.
    room : CutRoom
        Scratch.

    Returns
    -------
    float
        The cost.
    """
    residual, jacobian, core2 = balance.residual, balance.jacobian, felt.wake.core.least
    residual[0], residual[1] = cut_wake_force(point, felt.wake, room.runs, jacobian)
    room.force[0] = room.force[1] = 0.0
    for k in range(count):
        # A wall of the place exerts nothing.
        if near[k] < felt.edges.size - 1:
            first, beyond = felt.edges[near[k]], felt.edges[near[k] + 1]
            from_side = 1 if side[k] > 0.0 else -1
            edge_force(point, core2, felt.stations, first, beyond, from_side, room.force, jacobian)
    cost = add_own_flight(point, constants, residual, balance.gradient, jacobian)
    residual[0] += room.force[0]
    residual[1] += room.force[1]
    return cost


@kernel(allocates=False)
def _look_from(felt, room, edge, side):
    """Do nothing: an evaluation is told of each edge from which side it is seen."""


@kernel(allocates=False)
def count_edges(felt):
    """Return the number of core edges."""
    return felt.edges.size - 1


@kernel(allocates=False)
def _count_walls(felt):
    return felt.walls.shape[0]


@kernel(allocates=False)
def edge_distance(point, felt, edge, gradient):
    """Return how far a point is from a core edge, or from a wall after those, and fill in the gradient."""
    if edge >= felt.edges.size - 1:
        return wall_value(point, felt.walls, edge - felt.edges.size + 1, gradient)
    return _distance(point, felt.wake.core.least, felt.stations, felt.edges[edge], gradient)


@kernel(allocates=False)
def edge_pull(point, felt, edge, multipliers, room):
    """Return what is added to the Lagrangian through the filaments of a core edge, by the inner branch."""
    if edge >= felt.edges.size - 1:
        return NEVER_CROSSED
    force, first, beyond = room.force, felt.edges[edge], felt.edges[edge + 1]
    force[0] = force[1] = 0.0
    edge_force(point, felt.wake.core.least, felt.stations, first, beyond, 0, force, room.jacobian)
    return multipliers[0] * force[0] + multipliers[1] * force[1]


solve_cut, solve_many_cut, fill_cut_hessian = descent(
    make_room,
    _look_from,
    evaluate_cut,
    count_edges,
    _count_walls,
    edge_distance,
    edge_pull,
    varied=VARIABLE_COUNT,
    most_steps=400,
    keeps_sides=True,
)
