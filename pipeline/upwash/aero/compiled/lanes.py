"""The wake force and its Jacobian, compiled: what the search evaluates millions of times.

Every vortex ring as seen from every span node in every stroke state is a *lane*; all lanes run the same arithmetic and
are added up with their weights, so the number of states, nodes and rings are lengths of arrays and the compiler fills
its vector registers with lanes.

The force on a follower at (x, y, z) with amplitude h, upstroke span ratio R and phase coordinate t is

    F = Σ_lanes w · s(R) · (β₀ + β₁ t) · v(x, y + η s(R), z + c h),      s(R) = a + d R,

with v the velocity of the lane's ring, η the node, c the height of the tip and s the half-span in the lane's state.
The two components of v that matter are v_x (lift) and v_z (thrust).
"""

from __future__ import annotations

from upwash.aero.compiled.rings import FAST, ring_velocity_gradient
from upwash.kernel import kernel

# Rows of the array of lanes.
FIRST_X, LAST_X, FIRST_Z, LAST_Z, CENTRE_Y, HALF_WIDTH = range(6)  # the ring
ALONG_X, ALONG_Z = 6, 7  # unit vector of its tip filaments
NODE, SPAN_FIXED, SPAN_FLEXED, HEIGHT = range(8, 12)  # the follower's node: η, a, d, c
STEADY, SLIDING = 12, 13  # β₀ and β₁, times the circulations, the node's weight and the unit of force
CORE2 = 14  # square of the radius of the ring's cores
ROWS = 15

# The variables of the force, in order.
X, Y, Z, AMPLITUDE, SPAN_RATIO, PHASE = range(6)


@kernel(fastmath=FAST, allocates=False)
def wake_force_jacobian(point, lanes, edges, jacobian):
    """Return the wake-induced lift and thrust and fill in their Jacobian.

    Parameters
    ----------
    point : (6,) ndarray of float
        x, y, z, amplitude, upstroke span ratio, phase coordinate.
    lanes : (15, l) ndarray of float
        From `wake_lanes`.
    edges : (4, l) ndarray of float
        For the starting, stopping, left and right filament of each lane's ring, the squared distance beyond which
        the outer branch of the core is taken: row `CORE2` of the lanes for the Rankine core, another value to continue
        a branch.
    jacobian : (2, 6) ndarray of float
        Overwritten: derivatives of lift (row 0) and thrust (row 1) by the six variables; where a node lies on a core
        edge, those from inside.

    Returns
    -------
    tuple of float
        Lift and thrust, positive upstream.
    """
    x, y, z, amplitude, ratio, phase = point[0], point[1], point[2], point[3], point[4], point[5]
    lift = lift_x = lift_y = lift_z = lift_h = lift_r = lift_t = 0.0
    thrust = thrust_x = thrust_y = thrust_z = thrust_h = thrust_r = thrust_t = 0.0
    first_x, last_x, first_z, last_z = lanes[FIRST_X], lanes[LAST_X], lanes[FIRST_Z], lanes[LAST_Z]
    centre_y, half_width, node, fixed = lanes[CENTRE_Y], lanes[HALF_WIDTH], lanes[NODE], lanes[SPAN_FIXED]
    flexed, height, steady, sliding = lanes[SPAN_FLEXED], lanes[HEIGHT], lanes[STEADY], lanes[SLIDING]
    along_x, along_z, core2 = lanes[ALONG_X], lanes[ALONG_Z], lanes[CORE2]
    edge_first, edge_last, edge_left, edge_right = edges[0], edges[1], edges[2], edges[3]
    for i in range(lanes.shape[1]):
        span = fixed[i] + flexed[i] * ratio
        beta = steady[i] + sliding[i] * phase
        weight = span * beta
        vx, _, vz, vx_x, vx_y, vx_z, _, _, _, vz_x, vz_y, vz_z = ring_velocity_gradient(
            x,
            y + node[i] * span - centre_y[i],
            z + height[i] * amplitude,
            first_x[i],
            last_x[i],
            first_z[i],
            last_z[i],
            half_width[i],
            along_x[i],
            along_z[i],
            core2[i],
            edge_first[i],
            edge_last[i],
            edge_left[i],
            edge_right[i],
        )
        lift += weight * vx
        lift_x += weight * vx_x
        lift_y += weight * vx_y
        lift_z += weight * vx_z
        lift_h += weight * height[i] * vx_z
        lift_r += flexed[i] * beta * (vx + span * node[i] * vx_y)
        lift_t += span * sliding[i] * vx
        thrust += weight * vz
        thrust_x += weight * vz_x
        thrust_y += weight * vz_y
        thrust_z += weight * vz_z
        thrust_h += weight * height[i] * vz_z
        thrust_r += flexed[i] * beta * (vz + span * node[i] * vz_y)
        thrust_t += span * sliding[i] * vz
    jacobian[0, 0], jacobian[0, 1], jacobian[0, 2] = lift_x, lift_y, lift_z
    jacobian[0, 3], jacobian[0, 4], jacobian[0, 5] = lift_h, lift_r, lift_t
    jacobian[1, 0], jacobian[1, 1], jacobian[1, 2] = thrust_x, thrust_y, thrust_z
    jacobian[1, 3], jacobian[1, 4], jacobian[1, 5] = thrust_h, thrust_r, thrust_t
    return lift, thrust
