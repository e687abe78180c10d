"""A local solve behind an endless wake: sequential quadratic programming over the pieces of a piecewise smooth problem.

The force on a whole span has no core edges but those of the spanwise filaments, each of which matters in few of the
steps; optima are pinned to them all the same.  So the solve is that of a pair behind one wavelength
(`upwash.optimum.compiled.descent`): every core edge in reach is an inequality that keeps the step on its side, and
where the step stops at an edge the slope beyond tells whether it is a valley or a ridge.
"""

from __future__ import annotations

import math

import numpy as np

from upwash.aero.compiled.endless import endless_force_jacobian
from upwash.kernel import kernel
from upwash.optimum.compiled.descent import (
    BALANCED,
    CONVERGED_STEP,
    DIFFERENCE,
    EDGE_WEIGHT,
    EQUALITY_WEIGHT,
    MOST_PENALTY,
    SCALE,
    SOLVED,
    STALLED,
    TRUSTED_MULTIPLIER,
    UNBALANCED,
    _convexify,
)
from upwash.optimum.compiled.endless_edges import edge_distance, edge_force, edge_pull
from upwash.optimum.compiled.problem import DRAG, LIFT_FIXED, LIFT_RATIO, THRUST_FIXED, THRUST_RATIO, cost_of
from upwash.optimum.compiled.quadratic import MOST_INEQUALITIES, solve_quadratic

MOST_STEPS = 200


@kernel
def evaluate_endless(point, wake, constants, places, residual, gradient, jacobian):
    """Return the scaled cost of a point; fill in its gradient and the balances with their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        X = λΦ, y, z, h, R, and a sixth that means nothing.
    wake : EndlessWake
        The wake, in semispans and weights.
    constants : (10,) ndarray of float
        `PairProblem.constants`.
    places : (4, n) ndarray of float
        Scratch.
    residual : (2,) ndarray of float
        Overwritten: lift and thrust, own and the wake's, less weight and drag; in weights.
    gradient : (6,) ndarray of float
        Overwritten: gradient of the cost.
    jacobian : (2, 6) ndarray of float
        Overwritten: Jacobian of the residual.

    Returns
    -------
    float
        The cost.
    """
    jacobian[0, 5] = jacobian[1, 5] = 0.0
    x = point[0]
    point[0] = x / wake.wavelength
    wake_lift, wake_thrust = endless_force_jacobian(point, wake, places, jacobian)
    point[0] = x
    jacobian[0, 0] /= wake.wavelength
    jacobian[1, 0] /= wake.wavelength
    amplitude, ratio = point[3], point[4]
    lift = constants[LIFT_FIXED] + constants[LIFT_RATIO] * ratio
    thrust_span = constants[THRUST_FIXED] + constants[THRUST_RATIO] * ratio
    thrust = amplitude * thrust_span
    residual[0] = lift + wake_lift - 1.0
    residual[1] = thrust + wake_thrust - constants[DRAG]
    jacobian[0, 4] += constants[LIFT_RATIO]
    jacobian[1, 3] += thrust_span
    jacobian[1, 4] += amplitude * constants[THRUST_RATIO]
    cost, by_lift, by_thrust = cost_of(lift, thrust, constants)
    gradient[:] = 0.0
    gradient[3] = by_thrust * thrust_span
    gradient[4] = by_lift * constants[LIFT_RATIO] + by_thrust * amplitude * constants[THRUST_RATIO]
    return cost


@kernel
def evaluate_on_sides(
    point, wake, constants, stations, near, side, count, places, force, residual, gradient, jacobian
):
    """As `evaluate_endless`, each of the first `count` edges of `near` being seen from its side.

    Parameters
    ----------
    stations : (2, 6, m) ndarray of float
        See `upwash.optimum.compiled.endless_edges`.
    near : (c,) ndarray of int
        Numbers of core edges.
    side : (c,) ndarray of float
        1 outside, −1 inside.
    count : int
        How many of them count.
    force : (2,) ndarray of float
        Scratch.
    """
    cost = evaluate_endless(point, wake, constants, places, residual, gradient, jacobian)
    force[0] = force[1] = 0.0
    for k in range(count):
        edge_force(point, wake, stations, near[k], 1 if side[k] > 0.0 else -1, force, jacobian)
    residual[0] += force[0]
    residual[1] += force[1]
    return cost


@kernel
def lagrangian_hessian_endless(
    point, wake, constants, stations, near, side, edge_multipliers, count, multipliers, places, work, hessian
):
    """Fill in the Hessian of the Lagrangian within a pattern of sides, from differences of its gradient.

    Parameters
    ----------
    point, wake, constants, stations, near, side, count, places
        As for `evaluate_on_sides`.
    edge_multipliers : (c,) ndarray of float
        Multipliers of the distances of the edges; 0 for an edge to which the point is not pinned.
    multipliers : (2,) ndarray of float
        Multipliers of the two balances.
    work : (8, 6) ndarray of float
        Scratch.
    hessian : (6, 6) ndarray of float
        Overwritten.
    """
    residual, gradient, jacobian, here, moved, force = (
        work[0, :2],
        work[1],
        work[2:4],
        work[4],
        work[5],
        work[6, :2],
    )
    for i in range(6):
        moved[i] = point[i]
    for k in range(6):
        if k > 0:
            moved[k - 1] = point[k - 1] + DIFFERENCE
        evaluate_on_sides(
            moved, wake, constants, stations, near, side, count, places, force, residual, gradient, jacobian
        )
        for i in range(6):
            gradient[i] += multipliers[0] * jacobian[0, i] + multipliers[1] * jacobian[1, i]
        for e in range(count):
            if edge_multipliers[e] != 0.0:
                edge_distance(moved, wake, stations, near[e], work[7])
                for i in range(6):
                    gradient[i] += edge_multipliers[e] * work[7, i]
        for i in range(6):
            if k == 0:
                here[i] = gradient[i]
            else:
                hessian[k - 1, i] = (gradient[i] - here[i]) / DIFFERENCE
        if k > 0:
            moved[k - 1] = point[k - 1]
    for i in range(6):
        hessian[5, i] = 0.0
        hessian[i, 5] = 0.0
    for i in range(6):
        for j in range(i):
            mean = 0.5 * (hessian[i, j] + hessian[j, i])
            hessian[i, j] = mean
            hessian[j, i] = mean


@kernel
def _edges_in_reach(point, wake, stations, trust, near, side, distance, slopes, gradient):
    """List the core edges in reach of the trust region, the nearest if there are too many; return their number."""
    count = int(np.int64(0))  # a plain 0 would have what it is passed to compiled once more, for a literal
    for edge in range(wake.steps.shape[1] * stations.shape[2]):
        s = edge_distance(point, wake, stations, edge, gradient)
        reach = 0.0
        for i in range(6):
            reach += abs(gradient[i]) * SCALE[i] * trust
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
            slopes[place, i] = gradient[i]
    return count


@kernel
def solve_endless(start, wake, constants, stations, bounds, point, multipliers):
    """Descend from a start to a local optimum.

    Parameters
    ----------
    start : (6,) ndarray of float
        X, y, z, h, R, 0; moved into the bounds if outside.
    wake : EndlessWake
        The wake.
    constants : (10,) ndarray of float
        `PairProblem.constants`.
    stations : (2, 6, m) ndarray of float
        See `upwash.optimum.compiled.endless_edges`; none of a core without an edge.
    bounds : (6, 2) ndarray of float
        Bounds of the variables, the last from 0 to 0.
    point : (6,) ndarray of float
        Overwritten: where the solve ended.
    multipliers : (2,) ndarray of float
        Overwritten: multipliers of the lift and the thrust balance.

    Returns
    -------
    status : int
        `SOLVED`, `UNBALANCED` or `STALLED`, as of `upwash.optimum.compiled.descent.solve_local`.
    cost : float
        Scaled cost.
    steps : int
        Steps taken.
    """
    places, force = np.empty((4, wake.steps.shape[1])), np.empty(2)
    work, programme = np.empty((8, 6)), np.empty((40, 10))
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    trial_residual, other_gradient, other_jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    hessian, convex, factor = np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 6))
    linear, lower, upper = np.empty(6), np.empty(6), np.empty(6)
    step, trial, new_multipliers = np.empty(6), np.empty(6), np.empty(2)
    at_bound = np.zeros(6, np.int64)
    near = np.empty(MOST_INEQUALITIES, np.int64)
    side, distance, edge_multipliers = (
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES),
    )
    flipped, is_active = np.empty(MOST_INEQUALITIES, np.bool_), np.empty(MOST_INEQUALITIES, np.bool_)
    slopes, levels, pulls = (
        np.empty((MOST_INEQUALITIES, 6)),
        np.empty(MOST_INEQUALITIES),
        np.empty(MOST_INEQUALITIES),
    )
    edge_count = wake.steps.shape[1] * stations.shape[2]
    pins, pinned_side = np.zeros(edge_count), np.zeros(edge_count)
    for i in range(6):
        point[i] = min(max(start[i], bounds[i, 0]), bounds[i, 1])
    multipliers[:] = 0.0
    trust, penalty = 0.5, 1.0
    status, iteration = STALLED, 0
    cost = evaluate_endless(point, wake, constants, places, residual, gradient, jacobian)
    while iteration < MOST_STEPS:
        iteration += 1
        count = _edges_in_reach(point, wake, stations, trust, near, side, distance, slopes, work[7])
        for k in range(count):
            flipped[k] = False
            if pins[near[k]] != 0.0 and side[k] != pinned_side[near[k]]:
                # The same pin has another multiplier when told from the other side.
                pull = edge_pull(point, wake, stations, near[k], multipliers, force, other_jacobian)
                pins[near[k]] += side[k] * pull
            edge_multipliers[k] = pins[near[k]]
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
            model_cost = evaluate_on_sides(
                point,
                wake,
                constants,
                stations,
                near,
                side,
                count,
                places,
                force,
                residual,
                gradient,
                jacobian,
            )
            lagrangian_hessian_endless(
                point,
                wake,
                constants,
                stations,
                near,
                side,
                edge_multipliers,
                count,
                multipliers,
                places,
                work,
                hessian,
            )
            # Stabilised step: the balances enter by a steep quadratic about the present multipliers, so the programme
            # is feasible even where their linearisations are not.
            for i in range(6):
                linear[i] = gradient[i] * SCALE[i]
                for c in range(2):
                    linear[i] += (multipliers[c] + EQUALITY_WEIGHT * residual[c]) * jacobian[c, i] * SCALE[i]
                for k in range(count):
                    if edge_multipliers[k] != 0.0:
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
                        if edge_multipliers[k] != 0.0:
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
                pulls,
                programme,
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
                    pull = edge_pull(point, wake, stations, near[k], new_multipliers, force, other_jacobian)
                    if pull + pulls[k] > 1e-12:
                        flipped[k] = True
                        crossed = True
                        side[k] = -side[k]
                        levels[k] = -levels[k]
                        for i in range(6):
                            slopes[k, i] = -slopes[k, i]
            if not crossed:
                break
        if not solved:
            # Too many edges meet within reach: fewer do within a smaller one.
            trust *= 0.3
            if trust < 1e-11:
                break
            continue
        largest = max(abs(new_multipliers[0]), abs(new_multipliers[1]))
        for edge in range(edge_count):
            pins[edge] = 0.0
        for k in range(count):
            if is_active[k] and largest < TRUSTED_MULTIPLIER:
                pins[near[k]] = -side[k] * pulls[k]
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
        merit = evaluate_endless(point, wake, constants, places, residual, gradient, other_jacobian)
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
            status = SOLVED if imbalance < BALANCED else UNBALANCED
            multipliers[0], multipliers[1] = new_multipliers[0], new_multipliers[1]
            if imbalance >= BALANCED and largest < TRUSTED_MULTIPLIER and trust > 1e-8:
                continue
            break
        for i in range(6):
            trial[i] = min(max(point[i] + SCALE[i] * step[i], bounds[i, 0]), bounds[i, 1])
        trial_cost = evaluate_endless(
            trial, wake, constants, places, trial_residual, other_gradient, other_jacobian
        )
        trial_merit = trial_cost + penalty * (abs(trial_residual[0]) + abs(trial_residual[1]))
        promised = merit - predicted
        if merit - trial_merit < 0.1 * promised:
            # Second-order correction: back onto the balances and the active edges from where the step landed.
            _correct(
                trial,
                trial_residual,
                jacobian,
                wake,
                stations,
                near,
                is_active,
                count,
                at_bound,
                slopes,
                side,
                bounds,
                programme,
            )
            trial_cost = evaluate_endless(
                trial, wake, constants, places, trial_residual, other_gradient, other_jacobian
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
    cost = evaluate_endless(point, wake, constants, places, residual, gradient, jacobian)
    if abs(residual[0]) + abs(residual[1]) > BALANCED:
        status = UNBALANCED
    return status, cost, iteration


@kernel
def _correct(
    trial, residual, jacobian, wake, stations, near, is_active, count, at_bound, slopes, side, bounds, work
):
    """Move the trial point by the least step that restores the linearised balances and active core edges."""
    rows, right = work[0:10], work[20]
    n = 2
    for c in range(2):
        right[c] = -residual[c]
        for i in range(6):
            rows[c, i] = jacobian[c, i] * SCALE[i] if at_bound[i] == 0 else 0.0
    for k in range(count):
        if is_active[k] and n < 6:
            right[n] = -edge_distance(trial, wake, stations, near[k], work[21, 0:6]) * side[k]
            for i in range(6):
                rows[n, i] = slopes[k, i] if at_bound[i] == 0 else 0.0
            n += 1
    least_step(rows, right, n, work[10:20], work[22])
    for i in range(6):
        trial[i] = min(max(trial[i] + SCALE[i] * work[22, i], bounds[i, 0]), bounds[i, 1])


@kernel
def least_step(rows, right, n, gram, step):
    """Fill in the least step for which n rows take the values on the right."""
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
        step[i] = 0.0
        for a in range(n):
            step[i] += rows[a, i] * right[a]


@kernel
def solve_many_endless(starts, wake, constants, stations, bounds, points, costs, multipliers, status):
    """Solve from every start; all results are written into the arrays given.

    Parameters
    ----------
    starts : (n, 6) ndarray of float
        Starts.
    wake, constants, stations, bounds
        As for `solve_endless`.
    points, costs, multipliers, status : ndarray
        Overwritten: (n, 6), (n,), (n, 2) and (n,), one row a start.

    Returns
    -------
    int
        Steps taken in all.
    """
    steps = 0
    for k in range(starts.shape[0]):
        status[k], costs[k], taken = solve_endless(
            starts[k], wake, constants, stations, bounds, points[k], multipliers[k]
        )
        steps += taken
    return steps
