"""Cost and balances of a follower at a point of the scaled problem, with their slopes; compiled."""

from __future__ import annotations

import math

from upwash.aero.compiled.lanes import wake_force_jacobian
from upwash.kernel import kernel

# Positions in the array of constants that the compiled functions take.
LIFT_FIXED, LIFT_RATIO, THRUST_FIXED, THRUST_RATIO, DRAG = range(5)
COST_FORCE, COST_LIFT2, COST_THRUST, COST_FIXED, CORE2 = range(5, 10)


@kernel
def evaluate(point, lanes, edges, constants, residual, gradient, jacobian):
    """Return the scaled cost of a point; fill in its gradient and the balances with their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    lanes, edges : ndarray of float
        See `upwash.aero.compiled.lanes.wake_force_jacobian`.
    constants : (10,) ndarray of float
        `PairProblem.constants`.
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
    wake_lift, wake_thrust = wake_force_jacobian(point, lanes, constants[CORE2], edges, jacobian)
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
def cost_of(lift, thrust, constants):
    """Return the scaled cost of self-generated lift and thrust (in weights) and its derivatives by the two."""
    force = math.sqrt(lift * lift + thrust * thrust)
    cost = (
        constants[COST_FORCE] * force
        + constants[COST_LIFT2] * lift * lift
        + constants[COST_THRUST] * thrust
        + constants[COST_FIXED]
    )
    by_lift = constants[COST_FORCE] * lift / force + 2.0 * constants[COST_LIFT2] * lift
    by_thrust = constants[COST_FORCE] * thrust / force + constants[COST_THRUST]
    return cost, by_lift, by_thrust
