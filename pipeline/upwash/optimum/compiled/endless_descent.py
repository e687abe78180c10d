"""The local solve behind an endless wake.

The force on a whole span has no core edges but those of the spanwise filaments, each of which matters in few of the
steps; optima are pinned to them all the same.  So the solve is that of a pair behind one wavelength; an edge is looked
at from a side of choice by what continuing a branch past it changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import EndlessWake, endless_force_jacobian
from upwash.aero.compiled.lanes import PHASE, X
from upwash.kernel import kernel
from upwash.optimum.compiled import endless_edges as edges
from upwash.optimum.compiled.descent import descent
from upwash.optimum.compiled.endless_edges import edge_force
from upwash.optimum.compiled.problem import add_own_flight
from upwash.optimum.compiled.walls import NEVER_CROSSED, wall_value
from upwash.optimum.variables import VARIABLE_COUNT

_distance, _pull = edges.edge_distance, edges.edge_pull


class FeltEndless(NamedTuple):
    """An endless wake as the follower feels it, and its core edges.

    Attributes
    ----------
    wake : EndlessWake
        The wake, in semispans and weights.
    stations : (2, 6, m) ndarray of float
        See `upwash.optimum.compiled.endless_edges`; none of a core without an edge.
    walls : (w, 7) ndarray of float
        Limits of the place, see `upwash.optimum.compiled.walls`; they are numbered on after the edges.
    """

    wake: EndlessWake
    stations: NDArray[np.float64]
    walls: NDArray[np.float64]


class EndlessRoom(NamedTuple):
    """Scratch for an evaluation.

    Attributes
    ----------
    places : (4, n) ndarray of float
        See `upwash.aero.compiled.endless.endless_force_jacobian`.
    force, jacobian : (2,) and (2, 6) ndarray of float
        Of core edges.
    """

    places: NDArray[np.float64]
    force: NDArray[np.float64]
    jacobian: NDArray[np.float64]


@kernel
def make_room(felt):
    """Return scratch for evaluations."""
    return EndlessRoom(np.empty((4, felt.wake.steps.shape[1])), np.empty(2), np.empty((2, VARIABLE_COUNT)))


@kernel(allocates=False)
def _count_edges(felt):
    return felt.wake.steps.shape[1] * felt.stations.shape[2]


@kernel(allocates=False)
def evaluate_endless(point, felt, constants, room, near, side, count, balance):
    """Return the scaled cost of a point; fill in its gradient and the balances with their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        X = λΦ, y, z, h, R, and a sixth that means nothing.
    felt : FeltEndless
        The wake.
    constants : Constants
        `PairProblem.constants`.
    room : EndlessRoom
        Scratch.
    near : (c,) ndarray of int
        Numbers of core edges.
    side : (c,) ndarray of float
        The side from which each is seen: 1 outside, −1 inside.
    count : int
        How many of them count.
    balance : Balance
        Overwritten.

    Returns
    -------
    float
        The cost.
    """
    wake, residual, jacobian = felt.wake, balance.residual, balance.jacobian
    jacobian[0, PHASE] = jacobian[1, PHASE] = 0.0
    x = point[X]
    point[X] = x / wake.wavelength
    residual[0], residual[1] = endless_force_jacobian(point, wake, room.places, jacobian)
    point[X] = x
    jacobian[0, X] /= wake.wavelength
    jacobian[1, X] /= wake.wavelength
    room.force[0] = room.force[1] = 0.0
    edges = _count_edges(felt)
    for k in range(count):
        if near[k] < edges:
            edge_force(point, wake, felt.stations, near[k], 1 if side[k] > 0.0 else -1, room.force, jacobian)
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
    return felt.wake.steps.shape[1] * felt.stations.shape[2]


@kernel(allocates=False)
def _count_walls(felt):
    return felt.walls.shape[0]


@kernel(allocates=False)
def edge_distance(point, felt, edge, gradient):
    """Return how far a point is from a core edge, or from a wall after those, and fill in the gradient."""
    edges = count_edges(felt)
    if edge >= edges:
        return wall_value(point, felt.walls, edge - edges, gradient)
    return _distance(point, felt.wake, felt.stations, edge, gradient)


@kernel(allocates=False)
def edge_pull(point, felt, edge, multipliers, room):
    """Return what a step adds to the Lagrangian through the filaments of a core edge, by the inner branch."""
    if edge >= count_edges(felt):
        return NEVER_CROSSED
    return _pull(point, felt.wake, felt.stations, edge, multipliers, room.force, room.jacobian)


solve_endless, solve_many_endless, fill_endless_hessian = descent(
    make_room,
    _look_from,
    evaluate_endless,
    count_edges,
    _count_walls,
    edge_distance,
    edge_pull,
    varied=PHASE,
    most_steps=200,
    keeps_sides=True,
)
