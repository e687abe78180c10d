"""How steeply the least cost rises where a follower is held off an optimum along one axis, all else being free.

Hold x, y, z or the phase a distance d off the optimum and let place, stroke and phase else be the best there: the cost
is then v(d) = v(0) + slope · |d| + ½ curvature · d² + ….  Both are told for each side, d < 0 and d > 0.

At an optimum held by core edges and bounds to fewer directions than there are axes, an axis may be one along which
the follower cannot move without leaving an edge or a bound that holds it; then the cost rises at once, by the slope.
Along all other axes the slope is 0, and the curvature is that of the Lagrangian within edges and bounds.  Neither is
told by moving the follower: slopes follow from multipliers, and curvatures from the Hessian, so no step decides them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.spacing import Touched
from upwash.optimum.variables import SCALE

WITHIN = 1e-3
"""Length of the part of an axis that is free, the whole being 1, below which the axis counts as held: a follower moved
along it by a thousandth of a semispan would have to move by a whole one to stay with what holds it."""

LEAST_PART = 1e-7
"""What takes the follower along an axis by less than this of its own length does not."""

FLAT = 1e-9
"""Curvature, per unit of `SCALE` squared, below which a direction counts as flat."""


class Steepness(NamedTuple):
    """How the least cost rises, in units of the scaled problem.

    Attributes
    ----------
    slope, curvature : (a, 2) ndarray of float
        For each axis on the side where its variable is less, and where it is more.  The slope is infinite where the
        variable cannot go, at its own bound; the curvature is NaN wherever the axis is held.
    """

    slope: NDArray[np.float64]
    curvature: NDArray[np.float64]


@dataclass(frozen=True)
class Vicinity:
    """The smooth pieces that meet in a point, and what is asked of them.

    Attributes
    ----------
    on_edge : (e,) ndarray of int
        Numbers of the core edges that the point lies on.
    normals : (e, 6) ndarray of float
        Gradients of their distances.
    touched : Touched
        Walls that it lies on.
    slopes : callable
        Sides, 1 inside and −1 outside for each of those edges -> gradient of the cost and Jacobian of the balances.
    pull : callable
        Edge and multipliers of the balances -> what the edge adds to the Lagrangian.
    hessian : callable
        Multipliers of the balances and of those edges -> Hessian of the Lagrangian, seen from inside of them.
    """

    on_edge: NDArray[np.int64]
    normals: NDArray[np.float64]
    touched: Touched
    slopes: Callable[[NDArray[np.float64]], tuple[NDArray[np.float64], NDArray[np.float64]]]
    pull: Callable[[int, NDArray[np.float64]], float]
    hessian: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


class Held(NamedTuple):
    """What holds an optimum, in units of `SCALE`.

    Attributes
    ----------
    rows : (2 + e + b, v) ndarray of float
        Gradients of the two balances, of the distances of core edges, and outward normals of the bounds pressed on.
    multipliers : (2 + e + b,) ndarray of float
        Their multipliers.
    free : (f, v) ndarray of float
        An orthonormal basis of the directions that they leave.
    hessian : (v, v) ndarray of float
        Hessian of the Lagrangian.
    at_end : (v, 2) ndarray of bool
        Which variables are at their lower, or their upper bound.
    is_unique : bool
        Whether there are no more surfaces than variables, so that the multipliers are the only ones.
    """

    rows: NDArray[np.float64]
    multipliers: NDArray[np.float64]
    free: NDArray[np.float64]
    hessian: NDArray[np.float64]
    at_end: NDArray[np.bool_]
    is_unique: bool


def steepness(vicinity: Vicinity, held: Held, axes: Sequence[int]) -> Steepness:
    """Return how the least cost rises along some axes, on both sides.

    Parameters
    ----------
    vicinity : Vicinity
        The smooth pieces that meet in the optimum.
    held : Held
        What holds it.
    axes : sequence of int
        Numbers of variables.
    """
    slope, curvature = np.zeros((len(axes), 2)), np.full((len(axes), 2), np.nan)
    scaled, directions = np.linalg.eigh(held.free @ held.hessian @ held.free.T)
    is_flat = scaled <= FLAT
    for number, axis in enumerate(axes):
        along = directions.T @ held.free[:, axis]
        if np.linalg.norm(along) <= WITHIN:
            slopes = _slopes if held.is_unique else _slopes_of_pieces
            slope[number] = slopes(vicinity, held, axis)
        elif np.any(np.abs(along[is_flat]) > LEAST_PART):
            curvature[number] = 0.0
        else:
            curvature[number] = 1.0 / np.sum(along[~is_flat] ** 2 / scaled[~is_flat])
    at_end = held.at_end[[*axes]]
    return Steepness(np.where(at_end, np.inf, slope), np.where(at_end, np.nan, curvature))


def _slopes(vicinity: Vicinity, held: Held, axis: int) -> tuple[float, float]:
    """Return the slopes along an axis that is held, on both sides.

    The axis is a sum of what holds the optimum, so that moving along it is leaving some of that.  What is left is left
    at the price of its multiplier, which on the two sides of a core edge differs by the edge's pull; and as prices add
    up, it is cheapest to leave one alone.
    """
    direction = np.zeros(held.rows.shape[1])
    direction[axis] = 1.0
    parts = np.asarray(np.linalg.lstsq(held.rows.T, direction, rcond=1e-12)[0], float)
    # Each way of leaving something: how far along the axis that takes the follower, and what it costs.
    ways = [(-part, price) for part, price in zip(parts[2:], held.multipliers[2:], strict=True)]
    for number, edge in enumerate(vicinity.on_edge, start=2):
        # Outside of an edge the balances have other slopes, too.
        beyond = vicinity.pull(int(edge), parts[:2])
        price = held.multipliers[number] + vicinity.pull(int(edge), held.multipliers[:2])
        ways.append((parts[number] + beyond, -price))

    def least(side: float) -> float:
        return min((price / (side * far) for far, price in ways if side * far > LEAST_PART), default=np.inf)

    return least(-1.0), least(1.0)


def _slopes_of_pieces(vicinity: Vicinity, held: Held, axis: int) -> tuple[float, float]:
    """Return the same where multipliers are not unique: the least that a linear programme of any piece gives."""
    from scipy.optimize import linprog

    variables, edges = held.rows.shape[1], len(vicinity.on_edge)
    normals, least = vicinity.normals * SCALE, [np.inf, np.inf]
    outward = vicinity.touched.outward * SCALE
    ends = [(None if not low else 0.0, None if not high else 0.0) for low, high in held.at_end.tolist()]
    for inside in product((1.0, -1.0), repeat=edges):
        gradient, jacobian = vicinity.slopes(np.array(inside))
        kept = np.concatenate([np.array(inside)[:, None] * normals, outward])
        for number, side in enumerate((-1.0, 1.0)):
            if held.at_end[axis, number]:
                continue
            bounds = [(side, side) if variable == axis else ends[variable] for variable in range(variables)]
            found = linprog(
                gradient * SCALE,
                A_ub=kept if len(kept) else None,
                b_ub=np.zeros(len(kept)) if len(kept) else None,
                A_eq=jacobian * SCALE,
                b_eq=np.zeros(2),
                bounds=bounds,
            )
            if found.status == 0:
                least[number] = min(least[number], float(found.fun))
    return least[0], least[1]
