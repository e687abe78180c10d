"""Cost and balances of a follower at a point of the scaled problem, with their slopes; compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

from upwash.aero.compiled.lanes import AMPLITUDE, SPAN_RATIO, wake_force_jacobian
from upwash.kernel import kernel


class Constants(NamedTuple):
    """What cost and balances take beside the wake, forces in weights and costs in those of the lone leader.

    Attributes
    ----------
    lift_fixed, lift_ratio : float
        The follower's own lift, by its upstroke span ratio R: lift_fixed + lift_ratio · R.
    thrust_fixed, thrust_ratio : float
        Its own thrust per amplitude in semispans, likewise.
    drag : float
        The drag that thrust balances.
    cost_force, cost_lift2, cost_thrust, cost_fixed : float
        What the cost counts of the magnitude of the own force, of the square of its lift, of its thrust, and at all.
    """

    lift_fixed: float
    lift_ratio: float
    thrust_fixed: float
    thrust_ratio: float
    drag: float
    cost_force: float
    cost_lift2: float
    cost_thrust: float
    cost_fixed: float


@kernel(allocates=False)
def evaluate(point, lanes, edges, constants, residual, gradient, jacobian):
    """Return the scaled cost of a point; fill in its gradient and the balances with their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, h, R, t.
    lanes, edges : ndarray of float
        See `upwash.aero.compiled.lanes.wake_force_jacobian`.
    constants : Constants
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
    lift, thrust = wake_force_jacobian(point, lanes, edges, jacobian)
    residual[0], residual[1] = lift, thrust
    return add_own_flight(point, constants, residual, gradient, jacobian)


@kernel(allocates=False)
def add_own_flight(point, constants, residual, gradient, jacobian):
    """Make balances of the force of the wake, which the residual and its slopes hold; return the cost of the own.

    Parameters
    ----------
    point, constants, gradient
        As for `evaluate`.
    residual, jacobian : (2,) and (2, 6) ndarray of float
        Changed in place.

    Returns
    -------
    float
        The cost.
    """
    amplitude, ratio = point[AMPLITUDE], point[SPAN_RATIO]
    lift = constants.lift_fixed + constants.lift_ratio * ratio
    thrust_span = constants.thrust_fixed + constants.thrust_ratio * ratio
    thrust = amplitude * thrust_span
    residual[0] = lift + residual[0] - 1.0
    residual[1] = thrust + residual[1] - constants.drag
    jacobian[0, SPAN_RATIO] += constants.lift_ratio
    jacobian[1, AMPLITUDE] += thrust_span
    jacobian[1, SPAN_RATIO] += amplitude * constants.thrust_ratio
    cost, by_lift, by_thrust = cost_of(lift, thrust, constants)
    gradient[:] = 0.0
    gradient[AMPLITUDE] = by_thrust * thrust_span
    gradient[SPAN_RATIO] = by_lift * constants.lift_ratio + by_thrust * amplitude * constants.thrust_ratio
    return cost


@kernel(allocates=False)
def cost_of(lift, thrust, constants):
    """Return the scaled cost of self-generated lift and thrust (in weights) and its derivatives by the two."""
    force = math.sqrt(lift * lift + thrust * thrust)
    cost = (
        constants.cost_force * force
        + constants.cost_lift2 * lift * lift
        + constants.cost_thrust * thrust
        + constants.cost_fixed
    )
    by_lift = constants.cost_force * lift / force + 2.0 * constants.cost_lift2 * lift
    by_thrust = constants.cost_force * thrust / force + constants.cost_thrust
    return cost, by_lift, by_thrust
