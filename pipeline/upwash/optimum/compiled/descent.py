"""One local solve: sequential quadratic programming over the pieces of a continuous, piecewise smooth problem.

Within a pattern of sides (each point of the wing inside or outside each core) the problem is smooth, and every core
edge in reach is an inequality that keeps the step on its side.  Where the step stops at an edge, the Lagrangian's slope
beyond it tells whether the edge is a valley, to which the solution is pinned, or a ridge to be crossed: then the side
is flipped and the step solved again.  Steps are exact second-order: derivatives are analytic and the Hessian comes from
differences of gradients within the pattern.  A trust region and an exact penalty make it converge from anywhere.

The solve is written once: `descent` makes it for a kind of wake from the kernels that ask that wake.  Everything here
is compiled and releases the interpreter's lock; nothing is allocated within the iteration.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from upwash.kernel import kernel
from upwash.optimum.compiled.programme import (
    Balance,
    least_step,
    move_to_balance,
    new_balance,
    new_programme,
    new_reach,
    pose,
    promise,
    tell_multipliers,
)
from upwash.optimum.compiled.quadratic import MOST_INEQUALITIES, solve_quadratic
from upwash.optimum.variables import SCALE, VARIABLE_COUNT

MOST_FLIPS = 6
"""Programmes solved for one step, each with another side of some core edge."""

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

# What one step says of the solve: that it goes on, or what it ends with.
GOES_ON = -1

NONE = np.int64(0)
"""No edges.  A plain 0 would have what it is passed to compiled once more, for a literal."""


def descent(
    make_room: Any,
    look_from: Any,
    evaluate: Any,
    count_edges: Any,
    count_walls: Any,
    edge_distance: Any,
    edge_pull: Any,
    *,
    varied: int,
    most_steps: int,
    keeps_sides: bool,
) -> tuple[Any, Any, Any]:
    """Return the local solve of one kind of wake, that of many starts, and the Hessian that it goes by.

    Parameters
    ----------
    make_room : kernel
        (felt) -> room: scratch, in which no edge is looked at from a side of choice.
    look_from : kernel
        (felt, room, edge, side): from now on the edge is seen from outside (1), from inside (−1), or as it lies (0).
    evaluate : kernel
        (point, felt, constants, room, near, side, count, balance) -> cost: the balance is filled in, as seen from the
        sides of the first `count` edges of `near`; none stands for all as they lie.
    count_edges : kernel
        (felt) -> number of core edges.
    count_walls : kernel
        (felt) -> number of walls that the place may not cross; they are numbered on after the core edges.
    edge_distance : kernel
        (point, felt, edge, gradient) -> s = r²/r_c² − 1; the gradient is filled in.
    edge_pull : kernel
        (point, felt, edge, multipliers, room) -> what the edge adds to the Lagrangian there.
    varied : int
        How many of the variables have a range, the first ones.
    most_steps : int
        Steps after which a solve is given up.
    keeps_sides : bool
        Whether a step is given up if its programme was not solved, and corrected as seen from the sides that it keeps
        to: where edges lie close together.  Otherwise it is taken as it is, and corrected as seen from where it starts.

    Returns
    -------
    tuple of three kernels
        `solve`, `solve_many` and `fill_hessian`, see there.
    """

    @kernel(allocates=False)
    def fill_hessian(
        point, felt, constants, room, near, side, count, pins, multipliers, pinned, work, hessian
    ):
        """Fill in the Hessian of the Lagrangian within a pattern of sides.

        Parameters
        ----------
        point : (6,) ndarray of float
            The point.
        felt, constants, room, near, side, count
            As `evaluate` takes them.
        pins : (e,) ndarray of float
            Multipliers of the distances of core edges; 0 for an edge to which the point is not pinned.
        multipliers : (2,) ndarray of float
            Multipliers of the two balances.
        pinned : (p,) ndarray of int
            Scratch, for as many edges as there are pins.
        work : (8, 6) ndarray of float
            Scratch.
        hessian : (6, 6) ndarray of float
            Overwritten.
        """
        balance, moved, here, normal = Balance(work[0, :2], work[1], work[2:4]), work[4], work[5], work[6]
        pinned_count = 0
        for edge in range(pins.size):
            if pins[edge] != 0.0:
                pinned[pinned_count] = edge
                pinned_count += 1
        for i in range(VARIABLE_COUNT):
            moved[i] = point[i]
        for k in range(-1, varied):
            if k >= 0:
                moved[k] = point[k] + DIFFERENCE
            evaluate(moved, felt, constants, room, near, side, count, balance)
            gradient, jacobian = balance.gradient, balance.jacobian
            for i in range(VARIABLE_COUNT):
                gradient[i] = gradient[i] + multipliers[0] * jacobian[0, i] + multipliers[1] * jacobian[1, i]
            for e in range(pinned_count):
                edge_distance(moved, felt, pinned[e], normal)
                for i in range(VARIABLE_COUNT):
                    gradient[i] += pins[pinned[e]] * normal[i]
            if k < 0:
                for i in range(VARIABLE_COUNT):
                    here[i] = gradient[i]
            else:
                moved[k] = point[k]
                for i in range(VARIABLE_COUNT):
                    hessian[k, i] = (gradient[i] - here[i]) / DIFFERENCE
        for k in range(varied, VARIABLE_COUNT):
            for i in range(VARIABLE_COUNT):
                hessian[k, i] = hessian[i, k] = 0.0
        for i in range(VARIABLE_COUNT):
            for j in range(i):
                mean = 0.5 * (hessian[i, j] + hessian[j, i])
                hessian[i, j] = mean
                hessian[j, i] = mean

    @kernel(allocates=False)
    def find_edges(point, felt, trust, gradient, reach):
        """List the core edges in reach of the trust region, the nearest if there are too many; return their number."""
        near, side, distance, slopes = reach.near, reach.side, reach.distance, reach.slopes
        count, kept = int(NONE), int(NONE)
        edges, walls = count_edges(felt), count_walls(felt)
        for number in range(edges + walls):
            # Walls come first, and no edge takes the place of one.
            edge = edges + number if number < walls else number - walls
            s = edge_distance(point, felt, edge, gradient)
            within = 0.0
            for i in range(VARIABLE_COUNT):
                within += abs(gradient[i]) * SCALE[i] * trust
            if abs(s) > within:
                continue
            place = count
            if count == MOST_INEQUALITIES:
                place = kept
                for k in range(kept + 1, count):
                    if abs(distance[k]) > abs(distance[place]):
                        place = k
                if abs(distance[place]) <= abs(s):
                    continue
            else:
                count += 1
            near[place], distance[place] = edge, s
            side[place] = 1.0 if s > 0.0 or number < walls else -1.0
            if number < walls:
                kept = count
            for i in range(VARIABLE_COUNT):
                slopes[place, i] = gradient[i]
        return count

    @kernel(allocates=False)
    def keep_sides(point, felt, room, multipliers, pins, pinned_side, reach, count):
        """Make inequalities of the edges in reach, and look at each from the side on which the point lies."""
        near, side = reach.near, reach.side
        for k in range(count):
            reach.is_flipped[k] = False
            if pins[near[k]] != 0.0 and side[k] != pinned_side[near[k]]:
                # The same pin has another multiplier when told from the other side.
                pins[near[k]] += side[k] * edge_pull(point, felt, near[k], multipliers, room)
            look_from(felt, room, near[k], side[k])
            for i in range(VARIABLE_COUNT):
                reach.slopes[k, i] *= SCALE[i] * side[k]
            # A wall that rounding has crossed is not crossed further.
            reach.levels[k] = min(-side[k] * reach.distance[k], 0.0)

    @kernel(allocates=False)
    def find_step(point, felt, constants, room, multipliers, pins, reach, count, programme, balance):
        """Solve for the step, crossing the edges beyond which it pays to go; return whether that went, and the cost.

        The balance is left as seen from the sides that the step keeps to.
        """
        near, side, work = reach.near, reach.side, programme.work
        cost, solved = 0.0, False
        for _ in range(MOST_FLIPS):
            cost = evaluate(point, felt, constants, room, near, side, count, balance)
            fill_hessian(
                point,
                felt,
                constants,
                room,
                near,
                side,
                count,
                pins,
                multipliers,
                programme.pinned,
                work,
                programme.hessian,
            )
            pose(balance, multipliers, pins, reach, count, programme)
            solved = solve_quadratic(
                programme.convex,
                programme.linear,
                programme.lower,
                programme.upper,
                reach.slopes,
                reach.levels,
                count,
                programme.step,
                programme.at_bound,
                reach.is_active,
                reach.pulls,
                programme.room,
                programme.chosen,
            )
            tell_multipliers(balance, multipliers, programme)
            if not solved:
                break
            crossed = False
            for k in range(count):
                if not reach.is_active[k] or reach.is_flipped[k]:
                    continue
                pull = edge_pull(point, felt, near[k], programme.multipliers, room)
                if pull + reach.pulls[k] > 1e-12:
                    crossed = True
                    reach.is_flipped[k] = True
                    side[k], reach.levels[k] = -side[k], -reach.levels[k]
                    for i in range(VARIABLE_COUNT):
                        reach.slopes[k, i] = -reach.slopes[k, i]
                    look_from(felt, room, near[k], side[k])
            if not crossed:
                break
        for k in range(count):
            look_from(felt, room, near[k], 0.0)
        return solved, cost

    @kernel(allocates=False)
    def correct(trial, felt, residual, jacobian, reach, count, programme, bounds):
        """Move the trial point by the least step that restores the linearised balances and active core edges."""
        room, at_bound = programme.room, programme.at_bound
        rows, right, normal, step = room[0:10], room[20], room[21, 0:VARIABLE_COUNT], room[22]
        n = residual.size
        for c in range(2):
            right[c] = -residual[c]
            for i in range(VARIABLE_COUNT):
                rows[c, i] = jacobian[c, i] * SCALE[i] if at_bound[i] == 0 else 0.0
        for k in range(count):
            if reach.is_active[k] and n < VARIABLE_COUNT:
                right[n] = -edge_distance(trial, felt, reach.near[k], normal) * reach.side[k]
                for i in range(VARIABLE_COUNT):
                    rows[n, i] = reach.slopes[k, i] if at_bound[i] == 0 else 0.0
                n += 1
        least_step(rows, right, n, room[10:20], step)
        for i in range(VARIABLE_COUNT):
            trial[i] = min(max(trial[i] + SCALE[i] * step[i], bounds[i, 0]), bounds[i, 1])

    @kernel(allocates=False)
    def take_step(
        point,
        trial,
        felt,
        constants,
        room,
        bounds,
        multipliers,
        reach,
        count,
        programme,
        balance,
        ahead,
        cost,
        solved,
        state,
    ):
        """Take the step if it keeps what it promises, and judge by it how far the next may go.

        `cost` is the model's at the point, `state` holds the trust region and the penalty of an imbalance.  Returned is
        what the solve ends with, or `GOES_ON`.
        """
        trust, penalty, near, side = state[0], state[1], reach.near, reach.side
        new = programme.multipliers
        largest = max(abs(new[0]), abs(new[1]))
        is_trusted = largest < TRUSTED_MULTIPLIER
        size, predicted, left = promise(balance, cost, programme)
        # On an edge the cost is that from inside, which the model's is not if the step keeps outside.
        merit = evaluate(point, felt, constants, room, near, side, NONE, ahead)
        if not keeps_sides:
            for i in range(VARIABLE_COUNT):
                balance.jacobian[0, i], balance.jacobian[1, i] = ahead.jacobian[0, i], ahead.jacobian[1, i]
        imbalance = abs(ahead.residual[0]) + abs(ahead.residual[1])
        # The penalty is raised until the promise honours what the step does for the balances.
        penalty = max(0.5 * penalty, 1.0)
        if is_trusted:
            penalty = max(penalty, 2.0 * largest)
        restored = imbalance - left
        if restored > BALANCED:
            penalty = max(penalty, min(1.5 * (predicted - merit) / restored, MOST_PENALTY))
        state[1] = penalty
        merit += penalty * imbalance
        promised = merit - (predicted + penalty * left)
        if size < CONVERGED_STEP:
            # No step from a programme that could not be solved says nothing.
            if not solved:
                return STALLED
            multipliers[0], multipliers[1] = new[0], new[1]
            if imbalance >= BALANCED and is_trusted and trust > 1e-8:
                return GOES_ON
            return SOLVED if imbalance < BALANCED else UNBALANCED
        for i in range(VARIABLE_COUNT):
            trial[i] = min(max(point[i] + SCALE[i] * programme.step[i], bounds[i, 0]), bounds[i, 1])
        trial_cost = evaluate(trial, felt, constants, room, near, side, NONE, ahead)
        trial_merit = trial_cost + penalty * (abs(ahead.residual[0]) + abs(ahead.residual[1]))
        if merit - trial_merit < 0.1 * promised:
            # Second-order correction: back onto the balances and the active edges from where the step landed.
            correct(trial, felt, ahead.residual, balance.jacobian, reach, count, programme, bounds)
            trial_cost = evaluate(trial, felt, constants, room, near, side, NONE, ahead)
            trial_merit = trial_cost + penalty * (abs(ahead.residual[0]) + abs(ahead.residual[1]))
        gained = merit - trial_merit
        if is_trusted:
            multipliers[0], multipliers[1] = new[0], new[1]
        if gained > 0.05 * promised or (size < 1e-5 and gained > -1e-13):
            for i in range(VARIABLE_COUNT):
                point[i] = trial[i]
            if gained > 0.7 * promised and size > 0.9 * trust:
                state[0] = min(2.0 * trust, 1.0)
            return GOES_ON
        state[0] = 0.3 * min(size, trust)
        return STALLED if state[0] < (1e-11 if imbalance < 1e-6 else 1e-5) else GOES_ON

    @kernel(allocates=False)
    def settle(point, felt, constants, room, bounds, near, side, balance):
        """Evaluate a balanced point; where the drag is small, move it first, by least steps, to what is promised."""
        cost = evaluate(point, felt, constants, room, near, side, NONE, balance)
        residual = balance.residual
        for taken in range(MOST_SETTLING):
            unbalanced = abs(residual[0]) + abs(residual[1]) > BALANCED
            if unbalanced or abs(residual[1]) <= PROMISED * constants.drag:
                break
            # Far astern a last digit of x alone may be too much; the others then settle what it leaves.
            if not move_to_balance(point, bounds, balance, 0 if taken < MOST_SETTLING // 2 else 1):
                break
            cost = evaluate(point, felt, constants, room, near, side, NONE, balance)
        return cost

    @kernel
    def solve(start, felt, constants, bounds, point, multipliers, pins):
        """Descend from a start to a local optimum.

        Parameters
        ----------
        start : (6,) ndarray of float
            Where to start; moved into the bounds if outside.
        felt : NamedTuple
            The wake, as the kernels that ask it take it.
        constants : Constants
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
        taken : int
            Steps taken.
        """
        room, reach, programme = make_room(felt), new_reach(), new_programme()
        balance, ahead, trial = new_balance(), new_balance(), np.empty(VARIABLE_COUNT)
        pinned_side, state = np.zeros(pins.size), np.array([0.5, 1.0])
        for i in range(VARIABLE_COUNT):
            point[i] = min(max(start[i], bounds[i, 0]), bounds[i, 1])
        multipliers[:] = 0.0
        pins[:] = 0.0
        status = GOES_ON
        taken = 0
        while status == GOES_ON and taken < most_steps:
            taken += 1
            trust = state[0]
            count = find_edges(point, felt, trust, programme.work[7], reach)
            keep_sides(point, felt, room, multipliers, pins, pinned_side, reach, count)
            for i in range(VARIABLE_COUNT):
                programme.lower[i] = max((bounds[i, 0] - point[i]) / SCALE[i], -trust)
                programme.upper[i] = min((bounds[i, 1] - point[i]) / SCALE[i], trust)
                programme.step[i] = 0.0
            solved, model_cost = find_step(
                point, felt, constants, room, multipliers, pins, reach, count, programme, balance
            )
            if keeps_sides and not solved:
                # Too many edges meet within reach: fewer do within a smaller one.
                state[0] *= 0.3
                status = STALLED if state[0] < 1e-11 else GOES_ON
                continue
            is_trusted = (
                max(abs(programme.multipliers[0]), abs(programme.multipliers[1])) < TRUSTED_MULTIPLIER
            )
            pins[:] = 0.0
            for k in range(count):
                if reach.is_active[k] and is_trusted:
                    pins[reach.near[k]] = -reach.side[k] * reach.pulls[k]
                    pinned_side[reach.near[k]] = reach.side[k]
            status = take_step(
                point,
                trial,
                felt,
                constants,
                room,
                bounds,
                multipliers,
                reach,
                count,
                programme,
                balance,
                ahead,
                model_cost,
                solved,
                state,
            )
        cost = settle(point, felt, constants, room, bounds, reach.near, reach.side, balance)
        if abs(balance.residual[0]) + abs(balance.residual[1]) > BALANCED:
            status = UNBALANCED
        return (STALLED if status == GOES_ON else status), cost, taken

    @kernel
    def solve_many(starts, felt, constants, bounds, points, costs, multipliers, pins, status):
        """Solve from every start; all results are written into the arrays given.

        Parameters
        ----------
        starts : (n, 6) ndarray of float
            Starts.
        felt, constants, bounds
            As for `solve`.
        points, costs, multipliers, pins, status : ndarray
            Overwritten: (n, 6), (n,), (n, 2), (n, e) and (n,), one row a start.

        Returns
        -------
        int
            Steps taken in all.
        """
        steps = 0
        for k in range(starts.shape[0]):
            status[k], costs[k], taken = solve(
                starts[k], felt, constants, bounds, points[k], multipliers[k], pins[k]
            )
            steps += taken
        return steps

    return solve, solve_many, fill_hessian
