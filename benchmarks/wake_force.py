"""The wake's mean force on a follower, with its Jacobian: what a search asks for at each step."""

from __future__ import annotations

import numpy as np
from numba import njit
from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import wake_force_jacobian
from upwash.aero.interaction import phase_piece, phase_weights, wake_force
from upwash.aero.lanes import core_edges, wake_lanes
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import CORE_RADIUS_RATIO, vortex_wake

from benchmarks.contest import Contender, Contest
from benchmarks.field import numpy_plain

IBIS = Bird(
    mass_kg=1.3,
    semispan_m=0.6,
    speed_m_s=15.0,
    period_s=0.25,
    density_kg_m3=1.29,
    gravity_m_s2=9.8,
    amplitude_m=1.04,
    upstroke_span_ratio=0.4,
)
CORE_M = CORE_RADIUS_RATIO * IBIS.semispan_m
CALLS = 1000
STEP = 1e-6

# x, y, z and amplitude in m, upstroke span ratio, |phase − 1/2|: an ordinary place outboard of the wake.
PLACE = np.array([1.7, 0.9, -0.05, 0.75, 0.35, 0.1])


@njit(cache=True)
def forces_along_a_path(place, lanes, edges, jacobian, calls):
    """Call the force with its Jacobian many times, each a little further, as a compiled search does."""
    point = place.copy()
    total = 0.0
    for _ in range(calls):
        point[0] += 1e-9
        lift, thrust = wake_force_jacobian(point, lanes, edges, jacobian)
        total += lift + thrust
    return total


def numpy_force():
    """Return a function of a place that gives lift and thrust, with no loop over filaments or points."""
    wake = vortex_wake(
        IBIS.amplitude_m,
        IBIS.upstroke_span_ratio,
        IBIS.semispan_m,
        IBIS.wavelength_m,
        IBIS.circulation_m2_s,
    )
    corners = wake.corners()
    starts, ends = corners.reshape(2, 8, 3), np.roll(corners, -1, axis=1).reshape(2, 8, 3)
    b = IBIS.semispan_m

    def force(place):
        x, y, z, amplitude, ratio, mu = place
        spans = np.array([b * ratio, b])
        heights = z + np.array([0.5, -0.5]) * amplitude
        tips = np.array([[x, y + side * spans[k], heights[k]] for k in (0, 1) for side in (1.0, -1.0)])
        wind = np.array(
            [numpy_plain(tips, starts[j], ends[j], IBIS.circulation_m2_s, CORE_M) for j in (0, 1)]
        )
        mean = wind.reshape(2, 2, 2, 3).mean(axis=2)
        weights = phase_weights(0.5 + mu) * IBIS.density_kg_m3 * IBIS.circulation_m2_s * 2.0 * spans
        lift, _, thrust = np.tensordot(weights, mean, axes=2)
        return np.array([lift, thrust])

    return force


def with_differences(force):
    """Return a function of a place that gives lift, thrust and their Jacobian by central differences."""

    def found(place):
        slopes = [
            (force(place + STEP * axis) - force(place - STEP * axis)) / (2.0 * STEP) for axis in np.eye(6)
        ]
        return np.column_stack([force(place), *slopes])

    return found


def plain_force(place):
    """Return lift and thrust from the plain statement of the model."""
    x, y, z, amplitude, ratio, mu = place
    return np.array(wake_force(IBIS, IBIS.stroke, Pose(x, y, z, Stroke(amplitude, ratio), 0.5 + mu)))


def contest() -> Contest:
    """Return the contest: value and Jacobian, 2 × 2 stroke states, 2 wingtips, 8 filaments."""
    # Lengths in semispans, as the search has them; velocities and forces stay in m/s and N.
    b = IBIS.semispan_m
    wake = vortex_wake(
        IBIS.amplitude_m / b,
        IBIS.upstroke_span_ratio,
        1.0,
        IBIS.wavelength_m / b,
        IBIS.circulation_m2_s / b,
    )
    wing = np.full(2, IBIS.density_kg_m3 * IBIS.circulation_m2_s * 2.0 * b)
    lanes = wake_lanes(wake, *phase_piece(1), wing, 2, 2)
    edges = core_edges(lanes)
    units = np.array([b, b, b, b, 1.0, 1.0])
    place, jacobian = PLACE / units, np.empty((2, 6))

    def ours():
        force = wake_force_jacobian(place, lanes, edges, jacobian)
        return np.column_stack([force, jacobian / units])

    by_numpy, by_model = with_differences(numpy_force()), with_differences(plain_force)
    return Contest(
        "wake_force",
        "value and Jacobian",
        [
            Contender(
                "Upwash, in a compiled loop",
                lambda: forces_along_a_path(place, lanes, edges, jacobian, CALLS),
                CALLS,
                ours,
            ),
            Contender(
                "Upwash, called from Python",
                lambda: wake_force_jacobian(place, lanes, edges, jacobian),
                1,
                ours,
            ),
            Contender(
                "Upwash's plain model, central differences",
                lambda: by_model(PLACE),
                1,
                lambda: by_model(PLACE),
            ),
            Contender("numpy, central differences", lambda: by_numpy(PLACE), 1, lambda: by_numpy(PLACE)),
        ],
    )
