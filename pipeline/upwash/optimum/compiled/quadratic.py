"""A small dense quadratic programme: strictly convex, bounds and a few inequalities, solved from a feasible point.

The step of the local solve.  A primal active-set method: at most six variables and ten inequalities, all arrays given,
nothing allocated.
"""

from __future__ import annotations

import math

from upwash.kernel import kernel
from upwash.optimum.variables import VARIABLE_COUNT

MOST_INEQUALITIES = 10
MOST_CHANGES = 60
TOLERANCE = 1e-12

MANY_CHANGES, NEGLIGIBLE = 30, 1e-8
"""After so many changes a direction that is as short as this, and leads nowhere, is taken for none.

Where constraints are linearly dependent their multipliers are ambiguous: one would be released and met again for ever.
"""


@kernel(allocates=False)
def _cholesky(matrix, n):
    """Factorise the leading n × n block in place (lower triangle); return whether it is positive definite."""
    for j in range(n):
        diagonal = matrix[j, j]
        for k in range(j):
            diagonal -= matrix[j, k] * matrix[j, k]
        if not diagonal > 0.0:
            return False
        root = math.sqrt(diagonal)
        matrix[j, j] = root
        for i in range(j + 1, n):
            entry = matrix[i, j]
            for k in range(j):
                entry -= matrix[i, k] * matrix[j, k]
            matrix[i, j] = entry / root
    return True


@kernel(allocates=False)
def _cholesky_solve(factor, n, vector):
    """Overwrite the vector by the solution of the factorised system."""
    for i in range(n):
        for k in range(i):
            vector[i] -= factor[i, k] * vector[k]
        vector[i] /= factor[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            vector[i] -= factor[k, i] * vector[k]
        vector[i] /= factor[i, i]


@kernel(allocates=False)
def solve_quadratic(
    hessian, linear, lower, upper, slopes, levels, count, step, at_bound, is_active, multipliers, work, chosen
):
    """Minimise linear·p + ½ p·hessian·p with lower ≤ p ≤ upper and slopes p ≥ levels.

    Parameters
    ----------
    hessian : (6, 6) ndarray of float
        Symmetric, positive definite.
    linear, lower, upper : (6,) ndarray of float
        Linear term and bounds.
    slopes : (m, 6) ndarray of float
        Rows of the inequalities; the first `count` count.
    levels : (m,) ndarray of float
        Their right-hand sides.
    count : int
        Number of inequalities.
    step : (6,) ndarray of float
        A feasible point on entry, the minimiser on return.
    at_bound : (6,) ndarray of int
        Overwritten: −1 at the lower bound, 1 at the upper, 0 free.
    is_active : (m,) ndarray of bool
        Overwritten: which inequalities hold with equality.
    multipliers : (m,) ndarray of float
        Overwritten: their multipliers, none negative on success.
    work, chosen : (40, 10) ndarray of float and (2, 10) ndarray of int
        Scratch.

    Returns
    -------
    bool
        Whether the minimiser was reached within the permitted number of changes of the active set.
    """
    factor, schur, reduced = work[0:6], work[6:16], work[16:26]
    gradient, direction, right, free_gradient = work[26], work[27], work[28], work[29]
    free, active = chosen[0], chosen[1]
    for i in range(VARIABLE_COUNT):
        at_bound[i] = 0
        if step[i] <= lower[i]:
            step[i], at_bound[i] = lower[i], -1
        elif step[i] >= upper[i]:
            step[i], at_bound[i] = upper[i], 1
    for k in range(count):
        is_active[k] = False
        multipliers[k] = 0.0
    for change_count in range(MOST_CHANGES):
        free_count, active_count = 0, 0
        for i in range(VARIABLE_COUNT):
            gradient[i] = linear[i]
            for j in range(VARIABLE_COUNT):
                gradient[i] += hessian[i, j] * step[j]
            if at_bound[i] == 0:
                free[free_count] = i
                free_count += 1
        for k in range(count):
            multipliers[k] = 0.0
            if is_active[k]:
                active[active_count] = k
                active_count += 1
        for i in range(VARIABLE_COUNT):
            direction[i] = 0.0
        if free_count > 0:
            for i in range(free_count):
                for j in range(free_count):
                    factor[i, j] = hessian[free[i], free[j]]
                free_gradient[i] = gradient[free[i]]
            if not _cholesky(factor, free_count):
                return False
            _cholesky_solve(factor, free_count, free_gradient)
            # Multipliers of the active inequalities from their Schur complement.
            for a in range(active_count):
                for i in range(free_count):
                    reduced[a, i] = slopes[active[a], free[i]]
                _cholesky_solve(factor, free_count, reduced[a])
            for a in range(active_count):
                k = active[a]
                right[a] = levels[k]
                for i in range(VARIABLE_COUNT):
                    right[a] -= slopes[k, i] * step[i]
                for i in range(free_count):
                    right[a] += slopes[k, free[i]] * free_gradient[i]
                for other in range(active_count):
                    schur[a, other] = 0.0
                    for i in range(free_count):
                        schur[a, other] += slopes[k, free[i]] * reduced[other, i]
                schur[a, a] = schur[a, a] * (1.0 + 1e-10) + 1e-14
            if active_count > 0:
                if not _cholesky(schur, active_count):
                    return False
                _cholesky_solve(schur, active_count, right)
            for i in range(free_count):
                total = -free_gradient[i]
                for a in range(active_count):
                    total += right[a] * reduced[a, i]
                direction[free[i]] = total
            for a in range(active_count):
                multipliers[active[a]] = right[a]
        # How far the direction can be followed.
        length, blocking, side = 1.0, -1, 0
        for i in range(VARIABLE_COUNT):
            if at_bound[i] == 0:
                if direction[i] < 0.0 and step[i] + direction[i] < lower[i]:
                    reach = (lower[i] - step[i]) / direction[i]
                    if reach < length:
                        length, blocking, side = reach, i, -1
                elif direction[i] > 0.0 and step[i] + direction[i] > upper[i]:
                    reach = (upper[i] - step[i]) / direction[i]
                    if reach < length:
                        length, blocking, side = reach, i, 1
        for k in range(count):
            if not is_active[k]:
                change, value = 0.0, -levels[k]
                for i in range(VARIABLE_COUNT):
                    change += slopes[k, i] * direction[i]
                    value += slopes[k, i] * step[i]
                if change < 0.0 and value + change < -TOLERANCE:
                    reach = max(value, 0.0) / -change
                    if reach < length:
                        length, blocking, side = reach, k, 2
        for i in range(VARIABLE_COUNT):
            if at_bound[i] == 0:
                step[i] += length * direction[i]
        longest = 0.0
        for i in range(VARIABLE_COUNT):
            longest = max(longest, abs(direction[i]))
        if blocking >= 0 and not (change_count >= MANY_CHANGES and longest < NEGLIGIBLE):
            if side == 2:
                is_active[blocking] = True
            else:
                at_bound[blocking] = side
                step[blocking] = lower[blocking] if side == -1 else upper[blocking]
            continue
        # At the minimiser of the active set: release the constraint that pulls hardest, if any does.
        worst, released, kind = -1e-11, -1, 0
        for i in range(VARIABLE_COUNT):
            if at_bound[i] != 0 and lower[i] < upper[i]:
                slope = linear[i]
                for j in range(VARIABLE_COUNT):
                    slope += hessian[i, j] * step[j]
                for a in range(active_count):
                    slope -= multipliers[active[a]] * slopes[active[a], i]
                pull = -slope * at_bound[i]
                if pull < worst:
                    worst, released, kind = pull, i, 1
        for a in range(active_count):
            if multipliers[active[a]] < worst:
                worst, released, kind = multipliers[active[a]], active[a], 2
        if released < 0:
            return True
        if kind == 1:
            at_bound[released] = 0
        else:
            is_active[released] = False
    return False
