"""The net force on a follower over a plane of positions or phases, compiled.

The force is linear in the phase weights, so a plane in which the phase varies is one map for each pair of
stroke states, weighted and added.  `upwash.aero.interaction.net_force` states it for one position.  The
interpreter's lock is released in the loops, so threads may share out the rows of a plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.endless import LEAST_PHASE, fill_endless_force
from upwash.aero.compiled.field_map import add_force
from upwash.aero.endless import endless_wake_of
from upwash.aero.interaction import phase_weights
from upwash.aero.pose import Pose, Stroke
from upwash.aero.span_integral import span_nodes
from upwash.aero.wake import WakeModel, vortex_wake
from upwash.aero.wingbeat import wingbeat_steps

PLANES = {"xy": "y", "xz": "z", "xk": "phase"}
"""Each plane's second coordinate; the first is x."""

COORDINATES = ("x", "y", "z", "phase")


@dataclass(frozen=True)
class ForceMap:
    """Net lift and thrust over a plane.

    Attributes
    ----------
    plane : str
        A key of `PLANES`.
    first : (n,) ndarray of float
        Streamwise position x of the columns, in m.
    second : (m,) ndarray of float
        The other coordinate, of the rows: y or z in m, or the phase.
    lift_n, thrust_n : (m, n) ndarray of float
        Own and wake-induced force together, in N; thrust is positive upstream.
    """

    plane: str
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    lift_n: NDArray[np.float64]
    thrust_n: NDArray[np.float64]


def _weighted_wake_force(
    bird: Bird,
    ahead: Stroke,
    positions: NDArray[np.float64],
    stroke: Stroke,
    weights: NDArray[np.float64],
    model: WakeModel,
) -> NDArray[np.float64]:
    """Return the wake force (p, 2) at positions (p, 3), with the stroke states weighed as given."""
    states, b = model.stroke_states, bird.semispan_m
    wake = vortex_wake(
        ahead.amplitude_m,
        ahead.span_ratio,
        b,
        bird.wavelength_m,
        bird.circulation_m2_s,
        bird.circulation_ratio,
        model,
    )
    force, steps = np.zeros((positions.shape[0], 2)), wingbeat_steps(model)
    circulation = steps.circulation(bird.circulation_ratio)
    for k in range(states):
        half_span = b * ((1.0 - steps.flexed[k]) + steps.flexed[k] * stroke.span_ratio)
        share = weights[wake.state, k]
        # A pair of states that lasts no time costs none.
        felt, share = wake.only(share != 0.0), share[share != 0.0]
        own = bird.circulation_m2_s * circulation[k]
        for node, weight in zip(*span_nodes(model.span_nodes), strict=True):
            add_force(
                positions,
                half_span * node,
                stroke.amplitude_m * steps.height[k],
                bird.density_kg_m3 * own * 2.0 * half_span * weight,
                felt.rings,
                felt.circulation * share,
                felt.core_radius,
                force,
            )
    return force


def _endless_wake_force(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    plane: str,
    first: NDArray[np.float64],
    second: NDArray[np.float64],
    model: WakeModel,
) -> NDArray[np.float64]:
    """Return the force (m, n, 2) of an endless wake over a plane."""
    b = bird.semispan_m
    place = dict(zip(COORDINATES, np.broadcast_arrays(*pose.position_m, pose.phase), strict=True))
    place = {**place, "x": first, PLANES[plane]: second[:, None]}
    points = np.empty((second.size, first.size, 5))
    phase = place["x"] / bird.wavelength_m - place["phase"]
    points[..., 0] = phase - np.floor(phase - LEAST_PHASE)
    points[..., 1], points[..., 2] = place["y"] / b, place["z"] / b
    points[..., 3:] = pose.stroke.amplitude_m / b, pose.stroke.span_ratio
    force = np.empty((second.size * first.size, 2))
    fill_endless_force(points.reshape(-1, 5), endless_wake_of(bird, ahead, model), force)
    return force.reshape(second.size, first.size, 2)


def force_map(
    bird: Bird,
    ahead: Stroke,
    pose: Pose,
    plane: str,
    first: ArrayLike,
    second: ArrayLike,
    model: WakeModel | None = None,
) -> ForceMap:
    """Return a follower's net lift and thrust over a plane through a place.

    Parameters
    ----------
    bird : Bird
        The bird that sets circulation, semispan, speed and air; leader and follower share them.
    ahead : Stroke
        How the leader flaps.
    pose : Pose
        The place, and how the follower flaps; the plane's two coordinates replace those of the place.
    plane : str
        A key of `PLANES`: ``xy``, ``xz`` or ``xk``.
    first, second : array_like of float
        Coordinates of the plane: x in m; y or z in m, or the phase.
    model : WakeModel, optional
        Resolution; the paper's if not given.

    Returns
    -------
    ForceMap
        The forces.

    Raises
    ------
    ValueError
        If there is no such plane.
    """
    if plane not in PLANES:
        raise ValueError(f"plane: expected one of {', '.join(PLANES)}, found {plane!r}")
    model = model or WakeModel()
    if not model.is_endless:
        model.of_points()
    first, second = np.asarray(first, dtype=float), np.asarray(second, dtype=float)
    axis = COORDINATES.index(PLANES[plane])
    if model.is_endless:
        wake = _endless_wake_force(bird, ahead, pose, plane, first, second, model)
    elif plane == "xk":
        positions = np.empty((first.size, 3))
        positions[:] = pose.position_m
        positions[:, 0] = first
        weights = np.array([phase_weights(phase, model.stroke_states) for phase in second])
        wake = np.zeros((second.size, first.size, 2))
        for pair in np.ndindex(weights.shape[1:]):
            alone = np.zeros(weights.shape[1:])
            alone[pair] = 1.0
            force = _weighted_wake_force(bird, ahead, positions, pose.stroke, alone, model)
            wake += weights[:, *pair, None, None] * force
    else:
        positions = np.empty((second.size, first.size, 3))
        positions[:] = pose.position_m
        positions[..., 0] = first
        positions[..., axis] = second[:, None]
        weights = phase_weights(pose.phase, model.stroke_states)
        force = _weighted_wake_force(bird, ahead, positions.reshape(-1, 3), pose.stroke, weights, model)
        wake = force.reshape(second.size, first.size, 2)
    lift, thrust = bird.self_force_n(pose.stroke)
    return ForceMap(plane, first, second, lift + wake[..., 0], thrust + wake[..., 1])
