"""The local solve behind a wake that ends: how its core edges are looked at from a side of choice."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import CORE2
from upwash.kernel import kernel
from upwash.optimum.compiled.descent import descent
from upwash.optimum.compiled.edges import edge_distance, edge_pull
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.compiled.walls import NEVER_CROSSED, wall_value
from upwash.optimum.variables import VARIABLE_COUNT


class FeltLanes(NamedTuple):
    """A wake that ends as the follower feels it, and its core edges.

    Attributes
    ----------
    lanes : (15, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    group : (4, l) ndarray of int
        Number of the edge of each filament and lane.
    representative : (e, 2) ndarray of int
        A lane and a filament of each edge.
    walls : (w, 7) ndarray of float
        Limits of the place, see `upwash.optimum.compiled.walls`; they are numbered on after the edges.
    """

    lanes: NDArray[np.float64]
    group: NDArray[np.int64]
    representative: NDArray[np.int64]
    walls: NDArray[np.float64]


@kernel
def _make_edges(felt):
    edges = np.empty(felt.group.shape)
    for filament in range(edges.shape[0]):
        for lane in range(edges.shape[1]):
            edges[filament, lane] = felt.lanes[CORE2, lane]
    return edges


@kernel(allocates=False)
def _look_from(felt, edges, edge, side):
    """Continue the outer branch of an edge's filaments past it, or the inner, or neither."""
    for filament in range(felt.group.shape[0]):
        for lane in range(felt.group.shape[1]):
            if felt.group[filament, lane] == edge:
                if side == 0.0:
                    edges[filament, lane] = felt.lanes[CORE2, lane]
                else:
                    edges[filament, lane] = -1.0 if side > 0.0 else np.inf


@kernel(allocates=False)
def _evaluate(point, felt, constants, edges, near, side, count, balance):
    return evaluate(point, felt.lanes, edges, constants, balance.residual, balance.gradient, balance.jacobian)


@kernel(allocates=False)
def _count_edges(felt):
    return felt.representative.shape[0]


@kernel(allocates=False)
def _count_walls(felt):
    return felt.walls.shape[0]


@kernel(allocates=False)
def _edge_distance(point, felt, edge, gradient):
    edges = felt.representative.shape[0]
    if edge >= edges:
        return wall_value(point, felt.walls, edge - edges, gradient)
    return edge_distance(
        point, felt.lanes, felt.representative[edge, 0], felt.representative[edge, 1], gradient
    )


@kernel(allocates=False)
def _edge_pull(point, felt, edge, multipliers, edges):
    if edge >= felt.representative.shape[0]:
        return NEVER_CROSSED
    return edge_pull(point, felt.lanes, felt.group, edge, multipliers)


solve_local, solve_many, fill_hessian = descent(
    _make_edges,
    _look_from,
    _evaluate,
    _count_edges,
    _count_walls,
    _edge_distance,
    _edge_pull,
    varied=VARIABLE_COUNT,
    most_steps=400,
    keeps_sides=False,
)
