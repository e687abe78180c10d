"""The force a leader's wake exerts on a follower, state by state and averaged over a wingbeat.

Leader and follower are each held in N stroke states; state j of the leader lasts for phases [j/N, (j+1)/N), state k of
the follower for [k/N + κ, (k+1)/N + κ).  Their overlap weighs the force of the pair (j, k).  The follower is a lifting
line of its own circulation at which the wake's velocity is taken in a few nodes.  The paper's model is N = 2 with the
two wingtips as nodes.

This module is the plain statement of the model, in SI units; `upwash.aero.lanes` is the same force compiled for the
search, with its Jacobian.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.induction import velocity
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel, stroke_height, stroke_span, vortex_wake


def phase_weights(phase: float, stroke_states: int = 2) -> NDArray[np.float64]:
    """Return the share of a wingbeat that each pair of stroke states lasts (eqn:beta_uniform, eqn:beta_mixed).

    Parameters
    ----------
    phase : float
        Phase κ by which the follower lags the leader, as a fraction of the wingbeat; any real number.
    stroke_states : int
        Number N of stroke states.

    Returns
    -------
    (N, N) ndarray of float
        Element (j, k): the share with the leader in state j and the follower in state k.  The sum is 1.
    """
    index = np.arange(stroke_states)
    lag = (phase + (index[None, :] - index[:, None]) / stroke_states) % 1.0
    return np.maximum(0.0, 1.0 / stroke_states - np.minimum(lag, 1.0 - lag))


def phase_piece(piece: int, stroke_states: int = 2) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the phase weights between kinks, where they are linear: κ = piece/N + t has weights β₀ + β₁ t.

    Parameters
    ----------
    piece : int
        Number of the piece, 0 … N − 1; t runs from 0 to 1/N.  With N = 2, piece 1 has t = μ = |κ − ½| and piece 0
        mirrors it.
    stroke_states : int
        Number N of stroke states.

    Returns
    -------
    tuple of two (N, N) ndarray of float
        β₀ and β₁.
    """
    start = phase_weights(piece / stroke_states, stroke_states)
    end = phase_weights((piece + 1) / stroke_states, stroke_states)
    return start, (end - start) * stroke_states


def span_nodes(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return nodes across the span in [−1, 1] and their trapezoidal weights, which sum to 1 (eqn:integral_approx)."""
    weights = np.full(count, 1.0 / (count - 1))
    weights[[0, -1]] *= 0.5
    return np.linspace(-1.0, 1.0, count), weights


def state_circulation_ratio(bird: Bird, state: int, stroke_states: int) -> float:
    """Circulation of a follower's wing in a stroke state over that of its downstroke; linear in the tip's height."""
    raised = stroke_height(state / stroke_states) + 0.5
    return 1.0 + (bird.circulation_ratio - 1.0) * raised


def state_forces(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    model: WakeModel | None = None,
) -> NDArray[np.float64]:
    """Return the wake-induced lift and thrust for every pair of stroke states (eqn:full_integral).

    Parameters
    ----------
    bird : Bird
        The bird that sets circulation, semispan, speed and air; leader and follower share them.
    ahead : Stroke
        How the leader flaps.
    pose : Pose
        Where the follower flies relative to the leader, and how it flaps; its phase has no say here.
    model : WakeModel, optional
        Resolution; the paper's if not given.

    Returns
    -------
    (N, N, 2) ndarray of float
        Element (j, k): lift and thrust (positive upstream), in N, with the leader in state j and the follower in
        state k.  With N = 2, state 0 is "up" and state 1 is "down".
    """
    model = model or WakeModel()
    states, b = model.stroke_states, bird.semispan_m
    wake = vortex_wake(
        ahead.amplitude_m,
        ahead.span_ratio,
        b,
        bird.wavelength_m,
        bird.circulation_m2_s,
        bird.circulation_ratio,
        states,
        model.wavelengths,
    )
    nodes, weights = span_nodes(model.span_nodes)
    forces = np.empty((states, states, 2))
    for k in range(states):
        fixed, flexed = stroke_span(k / states)
        half_span = b * (fixed + flexed * pose.stroke.span_ratio)
        points = np.empty((nodes.size, 3))
        points[:, 0] = pose.x_m
        points[:, 1] = pose.y_m + half_span * nodes
        points[:, 2] = pose.z_m + pose.stroke.amplitude_m * stroke_height(k / states)
        circulation = bird.circulation_m2_s * state_circulation_ratio(bird, k, states)
        for j in range(states):
            of_state = wake.state == j
            wind = velocity(
                points, wake.rings[of_state], wake.circulation[of_state], model.core_radius_ratio * b
            )
            mean = weights @ wind
            # v × ŷ = (−v_z, 0, v_x): streamwise velocity lifts, upwash pulls forward.
            forces[j, k] = bird.density_kg_m3 * circulation * 2.0 * half_span * mean[[0, 2]]
    return forces


def wake_force(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    model: WakeModel | None = None,
) -> tuple[float, float]:
    """Return the wake-induced lift and thrust in N, averaged over a wingbeat (eqn:total_induced_force).

    Parameters
    ----------
    bird, ahead, pose, model
        As for `state_forces`.

    Returns
    -------
    tuple of float
        Lift and thrust (positive upstream), in N.

    Examples
    --------
    >>> from upwash import Bird, Pose, Stroke
    >>> ibis = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, amplitude_m=1.04, upstroke_span_ratio=0.4)
    >>> lift, thrust = wake_force(ibis, ibis.stroke, Pose(1.8, 0.9, -0.1, Stroke(0.75, 0.35), 0.5))
    >>> round(lift, 2), round(thrust, 2)
    (0.4, 0.53)
    """
    model = model or WakeModel()
    forces = state_forces(bird, ahead, pose, model)
    lift, thrust = np.tensordot(phase_weights(pose.phase, model.stroke_states), forces, axes=2)
    return float(lift), float(thrust)


def net_force(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    model: WakeModel | None = None,
) -> tuple[float, float]:
    """Return a follower's total lift and thrust in N: its own and the wake's (total_follower_force).

    Parameters and result are those of `wake_force`; in balance the result is the bird's weight and its drag.
    """
    lift, thrust = wake_force(bird, ahead, pose, model)
    own_lift, own_thrust = bird.self_force_n(pose.stroke)
    return own_lift + lift, own_thrust + thrust
