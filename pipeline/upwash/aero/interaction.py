"""The force a leader's wake exerts on a follower, state by state and averaged over a wingbeat.

Leader and follower are each held in N stroke states; state j of the leader lasts for phases [j/N, (j+1)/N), state k of
the follower for [k/N + κ, (k+1)/N + κ).  Their overlap weighs the force of the pair (j, k).  The follower is a lifting
line of its own circulation at which the wake's velocity is taken in a few nodes.  The paper's model is N = 2 with the
two wingtips as nodes.

This module is the plain statement of the model, in SI units; `upwash.aero.compiled.lanes` is the same force for the
search, compiled and with its Jacobian.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.endless import endless_wind, endless_window
from upwash.aero.induction import velocity
from upwash.aero.pose import Pose, Stroke
from upwash.aero.span_integral import ring_velocity, span_antiderivative, span_nodes
from upwash.aero.wake import Wake, WakeModel, stroke_height, vortex_wake, wake_at_phases
from upwash.aero.wingbeat import wingbeat_steps


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


def mean_phase_weights(stroke_states: int = 2) -> NDArray[np.float64]:
    """Return the same shares on average over all phases, as of birds that each keep their own beat: all alike."""
    return np.full((stroke_states, stroke_states), 1.0 / stroke_states**2)


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


def state_circulation_ratio(bird: Bird, state: int, stroke_states: int) -> float:
    """Circulation of a follower's wing in a stroke state over that of its downstroke; linear in the tip's height."""
    raised = stroke_height(state / stroke_states) + 0.5
    return 1.0 + (bird.circulation_ratio - 1.0) * raised


def state_forces(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    model: WakeModel | None = None,
    *,
    leader: Bird | None = None,
) -> NDArray[np.float64]:
    """Return the wake-induced lift and thrust for every pair of stroke states (eqn:full_integral).

    Parameters
    ----------
    bird : Bird
        The follower, which sets circulation and span of the wing that feels the wake.
    ahead : Stroke
        How the leader flaps.
    pose : Pose
        Where the follower flies relative to the leader, and how it flaps; its phase has no say here.
    model : WakeModel, optional
        Resolution; the paper's if not given.
    leader : Bird, optional
        The bird that sheds the wake: its circulation, semispan, wavelength and core; like the follower if not given.

    Returns
    -------
    (N, N, 2) ndarray of float
        Element (j, k): lift and thrust (positive upstream), in N, with the leader in state j and the follower in
        state k.  With N = 2, state 0 is "up" and state 1 is "down".
    """
    model = model or WakeModel()
    if model.stroke_rule != "held" or model.is_endless:
        raise ValueError(
            "model: expected birds that are held in stroke states behind a wake that ends, "
            f"found stroke_rule {model.stroke_rule!r} and wavelengths {model.wavelengths!r}"
        )
    states, b = model.stroke_states, bird.semispan_m
    wake = vortex_wake(*shed_by(leader or bird, ahead), model)
    steps = wingbeat_steps(model)
    circulation = bird.circulation_m2_s * steps.circulation(bird.circulation_ratio)
    forces = np.empty((states, states, 2))
    for k in range(states):
        half_span = b * ((1.0 - steps.flexed[k]) + steps.flexed[k] * pose.stroke.span_ratio)
        height = pose.stroke.amplitude_m * steps.height[k]
        for j in range(states):
            mean = _mean_wind(pose, half_span, height, wake.only(wake.state == j), model)
            # v × ŷ = (−v_z, 0, v_x): streamwise velocity lifts, upwash pulls forward.
            forces[j, k] = bird.density_kg_m3 * circulation[k] * 2.0 * half_span * mean
    return forces


def shed_by(leader: Bird, ahead: Stroke) -> tuple[float, float, float, float, float, float]:
    """Return amplitude, span ratio, semispan, wavelength, circulation and its ratio, as wakes are made of them."""
    return (
        ahead.amplitude_m,
        ahead.span_ratio,
        leader.semispan_m,
        leader.wavelength_m,
        leader.circulation_m2_s,
        leader.circulation_ratio,
    )


def _mean_wind(
    pose: Pose,
    half_span: float,
    height: float,
    wake: Wake,
    model: WakeModel,
) -> NDArray[np.float64]:
    """Return v_x and v_z of a wake, averaged over a span that is raised by a height."""
    x, y, z = pose.position_m
    felt = wake.rings, wake.circulation, wake.core_radius
    if not isinstance(model.span_nodes, int):
        ends = [
            np.array(span_antiderivative(x, y + side, z + height, *felt, model.core))
            for side in (half_span, -half_span)
        ]
        return (ends[0] - ends[1]) / (2.0 * half_span)
    nodes, weights = span_nodes(model.span_nodes)
    points = np.empty((nodes.size, 3))
    points[:, 0] = x
    points[:, 1] = y + half_span * nodes
    points[:, 2] = z + height
    if model.core == "rankine":
        wind = velocity(points, *felt)
    else:
        wind = ring_velocity(points, *felt, model.core)
    return (weights @ wind)[[0, 2]]


def _gauss_force(
    bird: Bird, ahead: Stroke, pose: Pose, model: WakeModel, leader: Bird, phase_lock: bool
) -> NDArray[np.float64]:
    """Return lift and thrust behind a wake that ends, both birds being followed through the wingbeat."""
    steps, b = wingbeat_steps(model, phase_lock), bird.semispan_m
    wake = wake_at_phases(list(steps.phase + pose.phase + steps.lag), *shed_by(leader, ahead), model)
    half_span = b * ((1.0 - steps.flexed) + steps.flexed * pose.stroke.span_ratio)
    per_wind = bird.density_kg_m3 * bird.circulation_m2_s * steps.circulation(bird.circulation_ratio)
    force = np.zeros(2)
    for k in range(steps.phase.size):
        mean = _mean_wind(
            pose,
            half_span[k],
            pose.stroke.amplitude_m * steps.height[k],
            wake.only(wake.state == k),
            model,
        )
        force += steps.weight[k] * per_wind[k] * 2.0 * half_span[k] * mean
    return force


def _endless_force(
    bird: Bird, ahead: Stroke, pose: Pose, model: WakeModel, leader: Bird, phase_lock: bool
) -> NDArray[np.float64]:
    """Return lift and thrust behind an endless wake, which goes by the spatial phase x/λ − κ."""
    steps, b = wingbeat_steps(model, phase_lock), bird.semispan_m
    shed = shed_by(leader, ahead)
    windows = endless_window(True, *shed), endless_window(False, *shed)
    half_span = b * ((1.0 - steps.flexed) + steps.flexed * pose.stroke.span_ratio)
    wind = endless_wind(
        windows,
        pose.x_m / leader.wavelength_m - pose.phase if phase_lock else 0.0,
        (pose.y_m, pose.z_m),
        pose.stroke.amplitude_m,
        half_span,
        leader.wavelength_m,
        model.core_radius_ratio * leader.semispan_m,
        model,
        steps,
    )
    per_wind = bird.density_kg_m3 * bird.circulation_m2_s * steps.circulation(bird.circulation_ratio)
    return np.asarray((steps.weight * per_wind * 2.0 * half_span) @ wind)


def wake_force(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    model: WakeModel | None = None,
    *,
    leader: Bird | None = None,
    phase_lock: bool = True,
) -> tuple[float, float]:
    """Return the wake-induced lift and thrust in N, averaged over a wingbeat (eqn:total_induced_force).

    Parameters
    ----------
    bird, ahead, pose, model, leader
        As for `state_forces`.
    phase_lock : bool
        Whether the follower beats in step with its leader; else the force is averaged over all its phases.

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
    model, leader = model or WakeModel(), leader or bird
    if model.is_endless:
        lift, thrust = _endless_force(bird, ahead, pose, model, leader, phase_lock)
    elif model.stroke_rule == "gauss":
        lift, thrust = _gauss_force(bird, ahead, pose, model, leader, phase_lock)
    else:
        forces, states = state_forces(bird, ahead, pose, model, leader=leader), model.stroke_states
        weights = phase_weights(pose.phase, states) if phase_lock else mean_phase_weights(states)
        lift, thrust = np.tensordot(weights, forces, axes=2)
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
