"""The quadratic programme of one step of a local solve: what it holds, how it is posed, what its solution promises.

The balances enter by a steep quadratic about the present multipliers, so that the programme can be solved even where
their linearisations cannot be met; core edges in reach are inequalities.  Steps are in units of `SCALE`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.kernel import kernel
from upwash.optimum.compiled.quadratic import MOST_INEQUALITIES
from upwash.optimum.variables import SCALE, VARIABLE_COUNT

EQUALITY_WEIGHT = 1e5
EDGE_WEIGHT = 1e2
LEAST_CURVATURE = 1e-7


class Balance(NamedTuple):
    """What an evaluation fills in.

    Attributes
    ----------
    residual : (2,) ndarray of float
        What lift and thrust exceed weight and drag by, in weights.
    gradient : (6,) ndarray of float
        Gradient of the cost.
    jacobian : (2, 6) ndarray of float
        Jacobian of the residual.
    """

    residual: NDArray[np.float64]
    gradient: NDArray[np.float64]
    jacobian: NDArray[np.float64]


class Reach(NamedTuple):
    """Core edges in reach, m of them at most; how many there are is told beside it.

    Attributes
    ----------
    near : (m,) ndarray of int
        Their numbers.
    side : (m,) ndarray of float
        The side that the step keeps to, 1 outside and −1 inside.
    distance : (m,) ndarray of float
        How far they are, positive outside.
    slopes, levels : (m, 6) and (m,) ndarray of float
        As inequalities: slopes · step ≥ level.
    is_active : (m,) ndarray of bool
        Which of them the step ends on.
    pulls : (m,) ndarray of float
        Their multipliers.
    is_flipped : (m,) ndarray of bool
        Whose side was changed for this step.
    """

    near: NDArray[np.int64]
    side: NDArray[np.float64]
    distance: NDArray[np.float64]
    slopes: NDArray[np.float64]
    levels: NDArray[np.float64]
    is_active: NDArray[np.bool_]
    pulls: NDArray[np.float64]
    is_flipped: NDArray[np.bool_]


class Programme(NamedTuple):
    """The programme and its solution.

    Attributes
    ----------
    hessian, convex, factor : (6, 6) ndarray of float
        Hessian of the Lagrangian; what is minimised, made convex; scratch.
    linear, lower, upper : (6,) ndarray of float
        Linear term and bounds of the step.
    step : (6,) ndarray of float
        The step.
    at_bound : (6,) ndarray of int
        −1 where it ends at the lower bound, 1 at the upper, 0 between.
    multipliers : (2,) ndarray of float
        Multipliers of the balances where it ends.
    pinned : (m,) ndarray of int
        Scratch.
    work, room, chosen : (8, 6), (40, 10) ndarray of float and (2, 10) ndarray of int
        Scratch.
    """

    hessian: NDArray[np.float64]
    convex: NDArray[np.float64]
    factor: NDArray[np.float64]
    linear: NDArray[np.float64]
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]
    step: NDArray[np.float64]
    at_bound: NDArray[np.int64]
    multipliers: NDArray[np.float64]
    pinned: NDArray[np.int64]
    work: NDArray[np.float64]
    room: NDArray[np.float64]
    chosen: NDArray[np.int64]


@kernel
def new_balance():
    """Return an empty balance."""
    return Balance(np.empty(2), np.empty(VARIABLE_COUNT), np.empty((2, VARIABLE_COUNT)))


@kernel
def new_reach():
    """Return an empty list of edges."""
    return Reach(
        np.empty(MOST_INEQUALITIES, np.int64),
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES),
        np.empty((MOST_INEQUALITIES, VARIABLE_COUNT)),
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES, np.bool_),
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES, np.bool_),
    )


@kernel
def new_programme():
    """Return an empty programme."""
    return Programme(
        np.empty((VARIABLE_COUNT, VARIABLE_COUNT)),
        np.empty((VARIABLE_COUNT, VARIABLE_COUNT)),
        np.empty((VARIABLE_COUNT, VARIABLE_COUNT)),
        np.empty(VARIABLE_COUNT),
        np.empty(VARIABLE_COUNT),
        np.empty(VARIABLE_COUNT),
        np.empty(VARIABLE_COUNT),
        np.zeros(VARIABLE_COUNT, np.int64),
        np.empty(2),
        np.empty(MOST_INEQUALITIES, np.int64),
        np.empty((8, VARIABLE_COUNT)),
        np.empty((40, 10)),
        np.empty((2, MOST_INEQUALITIES), np.int64),
    )


@kernel(allocates=False)
def _is_positive_definite(matrix, shift, factor):
    for j in range(VARIABLE_COUNT):
        diagonal = matrix[j, j] + shift
        for k in range(j):
            diagonal -= factor[j, k] * factor[j, k]
        if not diagonal > LEAST_CURVATURE:
            return False
        root = math.sqrt(diagonal)
        factor[j, j] = root
        for i in range(j + 1, VARIABLE_COUNT):
            entry = matrix[i, j]
            for k in range(j):
                entry -= factor[i, k] * factor[j, k]
            factor[i, j] = entry / root
    return True


@kernel(allocates=False)
def _convexify(matrix, factor):
    """Add to the diagonal the least multiple of 1, within a tenth, that makes the matrix positive definite."""
    if _is_positive_definite(matrix, 0.0, factor):
        return
    too_little, enough = 0.0, 1e-4
    while not _is_positive_definite(matrix, enough, factor) and enough < 1e6:
        too_little, enough = enough, 8.0 * enough
    for _ in range(5):
        middle = math.sqrt(max(too_little, 1e-5) * enough)
        if _is_positive_definite(matrix, middle, factor):
            enough = middle
        else:
            too_little = middle
    for i in range(VARIABLE_COUNT):
        matrix[i, i] += enough


@kernel(allocates=False)
def pose(balance, multipliers, pins, reach, count, programme):
    """Fill in the linear term and the convex matrix from the balance and the Hessian within a pattern of sides."""
    gradient, residual, jacobian, hessian = (
        balance.gradient,
        balance.residual,
        balance.jacobian,
        programme.hessian,
    )
    linear, lower, upper, near, slopes = (
        programme.linear,
        programme.lower,
        programme.upper,
        reach.near,
        reach.slopes,
    )
    for i in range(VARIABLE_COUNT):
        linear[i] = gradient[i] * SCALE[i]
        for c in range(2):
            linear[i] += (multipliers[c] + EQUALITY_WEIGHT * residual[c]) * jacobian[c, i] * SCALE[i]
        for k in range(count):
            if pins[near[k]] != 0.0:
                linear[i] -= EDGE_WEIGHT * reach.levels[k] * slopes[k, i]
    # A variable resting on its bound takes no part in the curvature that must be positive.
    for i in range(VARIABLE_COUNT):
        if programme.at_bound[i] != 0 and (lower[i] == 0.0 or upper[i] == 0.0):
            for j in range(VARIABLE_COUNT):
                hessian[i, j] = 0.0
                hessian[j, i] = 0.0
    for i in range(VARIABLE_COUNT):
        for j in range(VARIABLE_COUNT):
            # Curvature across the balances and across a pinned edge is free to add.
            curvature = hessian[i, j]
            for c in range(2):
                curvature += EQUALITY_WEIGHT * jacobian[c, i] * jacobian[c, j]
            curvature *= SCALE[i] * SCALE[j]
            for k in range(count):
                if pins[near[k]] != 0.0:
                    curvature += EDGE_WEIGHT * slopes[k, i] * slopes[k, j]
            programme.convex[i, j] = curvature
    _convexify(programme.convex, programme.factor)


@kernel(allocates=False)
def tell_multipliers(balance, multipliers, programme):
    """Fill in the multipliers of the balances where the step ends, by what is left of each there."""
    for c in range(2):
        programme.multipliers[c] = multipliers[c] + EQUALITY_WEIGHT * balance.residual[c]
        for i in range(VARIABLE_COUNT):
            programme.multipliers[c] += (
                EQUALITY_WEIGHT * balance.jacobian[c, i] * SCALE[i] * programme.step[i]
            )


@kernel(allocates=False)
def promise(balance, cost, programme):
    """Return the length of the step, and what the model says of where it ends: the cost and the imbalance left."""
    step, size, predicted, left = programme.step, 0.0, cost, 0.0
    for i in range(VARIABLE_COUNT):
        size = max(size, abs(step[i]))
        predicted += balance.gradient[i] * SCALE[i] * step[i]
        for j in range(VARIABLE_COUNT):
            predicted += 0.5 * programme.hessian[i, j] * SCALE[i] * SCALE[j] * step[i] * step[j]
    for c in range(2):
        value = balance.residual[c]
        for i in range(VARIABLE_COUNT):
            value += balance.jacobian[c, i] * SCALE[i] * step[i]
        left += abs(value)
    return size, predicted, left


@kernel(allocates=False)
def least_step(rows, right, n, gram, step):
    """Fill in the least step for which n rows take the values on the right."""
    for a in range(n):
        for b in range(n):
            total = 0.0
            for i in range(VARIABLE_COUNT):
                total += rows[a, i] * rows[b, i]
            gram[a, b] = total
        gram[a, a] = gram[a, a] * (1.0 + 1e-10) + 1e-12
    for j in range(n):
        for k in range(j):
            gram[j, j] -= gram[j, k] * gram[j, k]
        gram[j, j] = math.sqrt(max(gram[j, j], 1e-14))
        for i in range(j + 1, n):
            for k in range(j):
                gram[i, j] -= gram[i, k] * gram[j, k]
            gram[i, j] /= gram[j, j]
    for i in range(n):
        for k in range(i):
            right[i] -= gram[i, k] * right[k]
        right[i] /= gram[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            right[i] -= gram[k, i] * right[k]
        right[i] /= gram[i, i]
    for i in range(VARIABLE_COUNT):
        step[i] = 0.0
        for a in range(n):
            step[i] += rows[a, i] * right[a]


@kernel(allocates=False)
def move_to_balance(point, bounds, balance, first):
    """Move a point by the least step that balances it, but for the variables before the first; tell if there is one."""
    residual, jacobian = balance.residual, balance.jacobian
    lift2 = thrust2 = both = 0.0
    for i in range(first, VARIABLE_COUNT):
        if bounds[i, 0] < point[i] < bounds[i, 1]:
            by_lift, by_thrust = jacobian[0, i] * SCALE[i], jacobian[1, i] * SCALE[i]
            lift2 += by_lift * by_lift
            thrust2 += by_thrust * by_thrust
            both += by_lift * by_thrust
    determinant = lift2 * thrust2 - both * both
    if not determinant > 0.0:
        return False
    lift = (thrust2 * residual[0] - both * residual[1]) / determinant
    thrust = (lift2 * residual[1] - both * residual[0]) / determinant
    for i in range(first, VARIABLE_COUNT):
        if bounds[i, 0] < point[i] < bounds[i, 1]:
            step = SCALE[i] * SCALE[i] * (jacobian[0, i] * lift + jacobian[1, i] * thrust)
            point[i] = min(max(point[i] - step, bounds[i, 0]), bounds[i, 1])
    return True
