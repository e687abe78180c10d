"""One local solve: sequential quadratic programming over the pieces of a continuous, piecewise smooth problem.

Within a pattern of sides (each span node inside or outside each core) the problem is smooth, and every core edge in
reach is an inequality that keeps the step on its side.  Where the step stops at an edge, the Lagrangian's slope beyond
it tells whether the edge is a valley, to which the solution is pinned, or a ridge to be crossed: then the side is
flipped and the step solved again.  Steps are exact second-order: derivatives are analytic and the Hessian comes from
differences of gradients within the pattern.  A trust region and an exact penalty make it converge from anywhere.

Everything here is compiled and releases the interpreter's lock; nothing is allocated within the iteration.
"""

from __future__ import annotations

import math

import numpy as np

from upwash.kernel import kernel
from upwash.optimum.compiled.edges import edge_distance, edge_pull
from upwash.optimum.compiled.problem import CORE2, DRAG, evaluate
from upwash.optimum.compiled.quadratic import MOST_INEQUALITIES, solve_quadratic

SCALE = np.array([0.3, 0.3, 0.3, 0.3, 0.1, 0.25])
"""Lengths over which the six variables matter alike, in scaled variables; the trust region is a box of this shape."""

MOST_ITERATIONS = 400
EQUALITY_WEIGHT = 1e5
EDGE_WEIGHT = 1e2
LEAST_CURVATURE = 1e-7
TRUSTED_MULTIPLIER = 1e2
MOST_PENALTY = 1e3
DIFFERENCE = 1e-6
CONVERGED_STEP = 1e-10
BALANCED = 1e-11
"""Largest sum of the two imbalances, in weights, at which a solve may end."""

PROMISED, MOST_SETTLING = 1e-10, 8
"""Largest imbalance of thrust over the drag, and most steps to it where a small drag asks for more than `BALANCED`."""


# What a local solve ends with.
SOLVED, UNBALANCED, STALLED = range(3)


@kernel
def _lagrangian_gradient(
    point, lanes, edges, constants, multipliers, representative, edge_multipliers, work, found
):
    residual, gradient, jacobian = work[0, :2], work[1], work[2:4]
    evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
    for i in range(6):
        found[i] = gradient[i] + multipliers[0] * jacobian[0, i] + multipliers[1] * jacobian[1, i]
    for edge in range(representative.shape[0]):
        if edge_multipliers[edge] != 0.0:
            lane, filament = representative[edge, 0], representative[edge, 1]
            edge_distance(point, lanes, constants[CORE2], lane, filament, gradient)
            for i in range(6):
                found[i] += edge_multipliers[edge] * gradient[i]


@kernel
def lagrangian_hessian(
    point, lanes, edges, constants, multipliers, representative, edge_multipliers, work, hessian
):
    """Fill in the Hessian of the Lagrangian within the pattern of sides that `edges` states.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    lanes, edges, constants : ndarray of float
        See `upwash.optimum.compiled.problem.evaluate`.
    multipliers : (2,) ndarray of float
        Multipliers of the two balances.
    representative : (e, 2) ndarray of int
        See `upwash.optimum.edges.distinct_edges`.
    edge_multipliers : (e,) ndarray of float
        Multipliers of the distances of core edges; 0 for an edge to which the point is not pinned.
    work : (8, 6) ndarray of float
        Scratch.
    hessian : (6, 6) ndarray of float
        Overwritten.
    """
    there, here, moved = work[4], work[5], work[6]
    _lagrangian_gradient(
        point, lanes, edges, constants, multipliers, representative, edge_multipliers, work, here
    )
    for i in range(6):
        moved[i] = point[i]
    for i in range(6):
        moved[i] = point[i] + DIFFERENCE
        _lagrangian_gradient(
            moved, lanes, edges, constants, multipliers, representative, edge_multipliers, work, there
        )
        moved[i] = point[i]
        for j in range(6):
            hessian[i, j] = (there[j] - here[j]) / DIFFERENCE
    for i in range(6):
        for j in range(i):
            mean = 0.5 * (hessian[i, j] + hessian[j, i])
            hessian[i, j] = mean
            hessian[j, i] = mean


@kernel
def _set_side(edges, group, edge, value):
    for filament in range(group.shape[0]):
        for lane in range(group.shape[1]):
            if group[filament, lane] == edge:
                edges[filament, lane] = value


@kernel
def _is_positive_definite(matrix, shift, factor):
    for j in range(6):
        diagonal = matrix[j, j] + shift
        for k in range(j):
            diagonal -= factor[j, k] * factor[j, k]
        if not diagonal > LEAST_CURVATURE:
            return False
        root = math.sqrt(diagonal)
        factor[j, j] = root
        for i in range(j + 1, 6):
            entry = matrix[i, j]
            for k in range(j):
                entry -= factor[i, k] * factor[j, k]
            factor[i, j] = entry / root
    return True


@kernel
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
    for i in range(6):
        matrix[i, i] += enough


@kernel
def solve_local(start, lanes, group, representative, constants, bounds, point, multipliers, pins):
    """Descend from a start to a local optimum.

    Parameters
    ----------
    start : (6,) ndarray of float
        x, y, z, h, R, t; moved into the bounds if outside.
    lanes : (14, l) ndarray of float
        See `upwash.aero.lanes.wake_lanes`.
    group, representative : ndarray of int
        See `upwash.optimum.edges.distinct_edges`.
    constants : (10,) ndarray of float
        `PairProblem.constants`.
    bounds : (6, 2) ndarray of float
        Bounds of the variables.
    point : (6,) ndarray of float
        Overwritten: where the solve ended.
    multipliers : (2,) ndarray of float
        Overwritten: multipliers of the lift and the thrust balance.
    pins : (e,) ndarray of float
        Overwritten: multipliers of the core edges to which the point is pinned, 0 for the others.

    Returns
    -------
    status : int
        `SOLVED`, `UNBALANCED` (no balance found) or `STALLED`.
    cost : float
        Scaled cost.
    iterations : int
        Steps taken.
    """
    core2 = constants[CORE2]
    edge_count = representative.shape[0]
    edges = np.full((4, lanes.shape[1]), core2)
    work, qp_work = np.empty((8, 6)), np.empty((40, 10))
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    trial, trial_residual, scratch_gradient, scratch_jacobian = (
        np.empty(6),
        np.empty(2),
        np.empty(6),
        np.empty((2, 6)),
    )
    hessian, convex, factor = np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6))
    linear, lower, upper, step, correction = (
        np.empty(6),
        np.empty(6),
        np.empty(6),
        np.empty(6),
        np.empty(6),
    )
    at_bound = np.zeros(6, np.int64)
    near = np.empty(MOST_INEQUALITIES, np.int64)
    side = np.empty(MOST_INEQUALITIES)
    flipped = np.empty(MOST_INEQUALITIES, np.bool_)
    distance = np.empty(MOST_INEQUALITIES)
    slopes, levels = np.empty((MOST_INEQUALITIES, 6)), np.empty(MOST_INEQUALITIES)
    is_active, edge_multipliers = np.empty(MOST_INEQUALITIES, np.bool_), np.empty(MOST_INEQUALITIES)
    edge_gradient = np.empty(6)
    pinned_side = np.zeros(edge_count)
    new_multipliers = np.empty(2)

    for i in range(6):
        point[i] = min(max(start[i], bounds[i, 0]), bounds[i, 1])
    multipliers[:] = 0.0
    pins[:] = 0.0
    trust, penalty = 0.5, 1.0
    cost = evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
    status = STALLED
    iteration = 0
    while iteration < MOST_ITERATIONS:
        iteration += 1
        # Core edges in reach of the trust region, the nearest first when there are too many.
        count = int(
            np.int64(0)
        )  # a plain 0 would have what it is passed to compiled once more, for a literal
        for edge in range(edge_count):
            s = edge_distance(
                point, lanes, core2, representative[edge, 0], representative[edge, 1], edge_gradient
            )
            reach = 0.0
            for i in range(6):
                reach += abs(edge_gradient[i]) * SCALE[i] * trust
            if abs(s) > reach:
                continue
            place = count
            if count == MOST_INEQUALITIES:
                place = 0
                for k in range(1, count):
                    if abs(distance[k]) > abs(distance[place]):
                        place = k
                if abs(distance[place]) <= abs(s):
                    continue
            else:
                count += 1
            near[place], distance[place] = edge, s
            side[place] = 1.0 if s > 0.0 else -1.0
            for i in range(6):
                slopes[place, i] = edge_gradient[i]
        for k in range(count):
            flipped[k] = False
            if pins[near[k]] != 0.0 and side[k] != pinned_side[near[k]]:
                # The same pin has another multiplier when told from the other side.
                pins[near[k]] += side[k] * edge_pull(point, lanes, core2, group, near[k], multipliers)
            _set_side(edges, group, near[k], -1.0 if side[k] > 0.0 else np.inf)
            for i in range(6):
                slopes[k, i] *= SCALE[i] * side[k]
            levels[k] = -side[k] * distance[k]
        for i in range(6):
            lower[i] = max((bounds[i, 0] - point[i]) / SCALE[i], -trust)
            upper[i] = min((bounds[i, 1] - point[i]) / SCALE[i], trust)
            step[i] = 0.0
        model_cost = cost
        solved = False
        for _ in range(6):
            model_cost = evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
            lagrangian_hessian(
                point, lanes, edges, constants, multipliers, representative, pins, work, hessian
            )
            # Stabilised step: the balances enter by a steep quadratic about the present multipliers, so the programme
            # is feasible even where their linearisations are not.
            for i in range(6):
                linear[i] = gradient[i] * SCALE[i]
                for c in range(2):
                    linear[i] += (multipliers[c] + EQUALITY_WEIGHT * residual[c]) * jacobian[c, i] * SCALE[i]
                for k in range(count):
                    if pins[near[k]] != 0.0:
                        linear[i] -= EDGE_WEIGHT * levels[k] * slopes[k, i]
            # A variable resting on its bound takes no part in the curvature that must be positive.
            for i in range(6):
                if at_bound[i] != 0 and (lower[i] == 0.0 or upper[i] == 0.0):
                    for j in range(6):
                        hessian[i, j] = 0.0
                        hessian[j, i] = 0.0
            for i in range(6):
                for j in range(6):
                    # Curvature across the balances and across a pinned edge is free to add.
                    curvature = hessian[i, j]
                    for c in range(2):
                        curvature += EQUALITY_WEIGHT * jacobian[c, i] * jacobian[c, j]
                    curvature *= SCALE[i] * SCALE[j]
                    for k in range(count):
                        if pins[near[k]] != 0.0:
                            curvature += EDGE_WEIGHT * slopes[k, i] * slopes[k, j]
                    convex[i, j] = curvature
            _convexify(convex, factor)
            solved = solve_quadratic(
                convex,
                linear,
                lower,
                upper,
                slopes,
                levels,
                count,
                step,
                at_bound,
                is_active,
                edge_multipliers,
                qp_work,
            )
            for c in range(2):
                new_multipliers[c] = multipliers[c] + EQUALITY_WEIGHT * residual[c]
                for i in range(6):
                    new_multipliers[c] += EQUALITY_WEIGHT * jacobian[c, i] * SCALE[i] * step[i]
            crossed = False
            if solved:
                for k in range(count):
                    if not is_active[k] or flipped[k]:
                        continue
                    pull = edge_pull(point, lanes, core2, group, near[k], new_multipliers)
                    if pull + edge_multipliers[k] > 1e-12:
                        flipped[k] = True
                        crossed = True
                        side[k] = -side[k]
                        levels[k] = -levels[k]
                        for i in range(6):
                            slopes[k, i] = -slopes[k, i]
                        _set_side(edges, group, near[k], -1.0 if side[k] > 0.0 else np.inf)
            if not crossed:
                break
        largest = max(abs(new_multipliers[0]), abs(new_multipliers[1]))
        for edge in range(edge_count):
            pins[edge] = 0.0
        for k in range(count):
            if is_active[k] and largest < TRUSTED_MULTIPLIER:
                pins[near[k]] = -side[k] * edge_multipliers[k]
                pinned_side[near[k]] = side[k]
        # What the model promises; the penalty is raised until the promise honours what the step does for the balances.
        size, predicted, left = 0.0, model_cost, 0.0
        for i in range(6):
            size = max(size, abs(step[i]))
            predicted += gradient[i] * SCALE[i] * step[i]
            for j in range(6):
                predicted += 0.5 * hessian[i, j] * SCALE[i] * SCALE[j] * step[i] * step[j]
        for c in range(2):
            value = residual[c]
            for i in range(6):
                value += jacobian[c, i] * SCALE[i] * step[i]
            left += abs(value)
        for k in range(count):
            _set_side(edges, group, near[k], core2)
        merit = evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
        imbalance = abs(residual[0]) + abs(residual[1])
        penalty = max(0.5 * penalty, 1.0)
        if largest < TRUSTED_MULTIPLIER:
            penalty = max(penalty, 2.0 * largest)
        restored = imbalance - left
        if restored > BALANCED:
            penalty = max(penalty, min(1.5 * (predicted - merit) / restored, MOST_PENALTY))
        merit += penalty * imbalance
        predicted += penalty * left
        if size < CONVERGED_STEP:
            # No step from a programme that could not be solved says nothing.
            if not solved:
                break
            status = SOLVED if imbalance < BALANCED else UNBALANCED
            if imbalance >= BALANCED and largest < TRUSTED_MULTIPLIER and trust > 1e-8:
                multipliers[0], multipliers[1] = new_multipliers[0], new_multipliers[1]
                continue
            multipliers[0], multipliers[1] = new_multipliers[0], new_multipliers[1]
            break
        for i in range(6):
            trial[i] = min(max(point[i] + SCALE[i] * step[i], bounds[i, 0]), bounds[i, 1])
        trial_cost = evaluate(
            trial, lanes, edges, constants, trial_residual, scratch_gradient, scratch_jacobian
        )
        trial_merit = trial_cost + penalty * (abs(trial_residual[0]) + abs(trial_residual[1]))
        promised = merit - predicted
        if merit - trial_merit < 0.1 * promised:
            # Second-order correction: back onto the balances and the active edges from where the step landed.
            _correct(
                trial,
                trial_residual,
                jacobian,
                lanes,
                core2,
                representative,
                near,
                is_active,
                count,
                at_bound,
                slopes,
                side,
                bounds,
                qp_work,
                edge_gradient,
                correction,
            )
            trial_cost = evaluate(
                trial, lanes, edges, constants, trial_residual, scratch_gradient, scratch_jacobian
            )
            trial_merit = trial_cost + penalty * (abs(trial_residual[0]) + abs(trial_residual[1]))
        gained = merit - trial_merit
        if largest < TRUSTED_MULTIPLIER:
            multipliers[0], multipliers[1] = new_multipliers[0], new_multipliers[1]
        if gained > 0.05 * promised or (size < 1e-5 and gained > -1e-13):
            for i in range(6):
                point[i] = trial[i]
            cost = trial_cost
            if gained > 0.7 * promised and size > 0.9 * trust:
                trust = min(2.0 * trust, 1.0)
        else:
            trust = 0.3 * min(size, trust)
            if trust < (1e-11 if imbalance < 1e-6 else 1e-5):
                break
    cost = _settle(point, lanes, edges, constants, bounds, residual, gradient, jacobian)
    if abs(residual[0]) + abs(residual[1]) > BALANCED:
        status = UNBALANCED
    return status, cost, iteration


@kernel
def _settle(point, lanes, edges, constants, bounds, residual, gradient, jacobian):
    """Evaluate a balanced point; where the drag is small, move it first, by least steps, to the balance promised."""
    cost = evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
    for taken in range(MOST_SETTLING):
        unbalanced = abs(residual[0]) + abs(residual[1]) > BALANCED
        if unbalanced or abs(residual[1]) <= PROMISED * constants[DRAG]:
            break
        # Far astern a last digit of x alone may be too much; the others then settle what it leaves.
        first = 0 if taken < MOST_SETTLING // 2 else 1
        lift2 = thrust2 = both = 0.0
        for i in range(first, 6):
            if bounds[i, 0] < point[i] < bounds[i, 1]:
                by_lift, by_thrust = jacobian[0, i] * SCALE[i], jacobian[1, i] * SCALE[i]
                lift2 += by_lift * by_lift
                thrust2 += by_thrust * by_thrust
                both += by_lift * by_thrust
        determinant = lift2 * thrust2 - both * both
        if not determinant > 0.0:
            break
        lift = (thrust2 * residual[0] - both * residual[1]) / determinant
        thrust = (lift2 * residual[1] - both * residual[0]) / determinant
        for i in range(first, 6):
            if bounds[i, 0] < point[i] < bounds[i, 1]:
                step = SCALE[i] * SCALE[i] * (jacobian[0, i] * lift + jacobian[1, i] * thrust)
                point[i] = min(max(point[i] - step, bounds[i, 0]), bounds[i, 1])
        cost = evaluate(point, lanes, edges, constants, residual, gradient, jacobian)
    return cost


@kernel
def _correct(
    trial,
    residual,
    jacobian,
    lanes,
    core2,
    representative,
    near,
    is_active,
    count,
    at_bound,
    slopes,
    side,
    bounds,
    work,
    edge_gradient,
    correction,
):
    """Move the trial point by the least step that restores the linearised balances and active core edges."""
    rows, gram, right = work[0:10], work[10:20], work[20]
    n = 2
    for c in range(2):
        right[c] = -residual[c]
        for i in range(6):
            rows[c, i] = jacobian[c, i] * SCALE[i] if at_bound[i] == 0 else 0.0
    for k in range(count):
        if is_active[k] and n < 6:
            edge = near[k]
            s = edge_distance(
                trial, lanes, core2, representative[edge, 0], representative[edge, 1], edge_gradient
            )
            right[n] = -s * side[k]
            for i in range(6):
                rows[n, i] = slopes[k, i] if at_bound[i] == 0 else 0.0
            n += 1
    for a in range(n):
        for b in range(n):
            total = 0.0
            for i in range(6):
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
    for i in range(6):
        correction[i] = 0.0
        for a in range(n):
            correction[i] += rows[a, i] * right[a]
        trial[i] = min(max(trial[i] + SCALE[i] * correction[i], bounds[i, 0]), bounds[i, 1])


@kernel
def solve_many(
    starts, lanes, group, representative, constants, bounds, points, costs, multipliers, pins, status
):
    """Solve from every start; all results are written into the arrays given.

    Parameters
    ----------
    starts : (n, 6) ndarray of float
        Starts.
    lanes, group, representative, constants, bounds
        See `upwash.optimum.compiled.descent.solve_local`.
    points, costs, multipliers, pins, status : ndarray
        Overwritten: (n, 6), (n,), (n, 2), (n, e) and (n,), one row a start.

    Returns
    -------
    int
        Steps taken in all.
    """
    steps = 0
    for k in range(starts.shape[0]):
        status[k], costs[k], taken = solve_local(
            starts[k],
            lanes,
            group,
            representative,
            constants,
            bounds,
            points[k],
            multipliers[k],
            pins[k],
        )
        steps += taken
    return steps
