"""What a bird at a given place feels of the wakes of the birds ahead of it, whatever the model: compiled.

Both kinds of wake (one that ends, felt in points by birds that are held in states; and an endless one, felt on the
whole span) answer the same question by `look`: what is missing to balance with a stroke, and how that changes.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.endless import LEAST_PHASE, EndlessWake, endless_force_jacobian
from upwash.aero.compiled.lanes import (
    CENTRE_Y,
    CORE2,
    FIRST_X,
    FIRST_Z,
    LAST_X,
    LAST_Z,
    ROWS,
    SLIDING,
    STEADY,
    wake_force_jacobian,
)
from upwash.kernel import kernel
from upwash.optimum.compiled.problem import Constants, cost_of

# Columns of an array of followers' places, a row for each bird ahead: relative to it, in semispans, and the lag behind.
X, Y, Z, PHASE = range(4)

# Columns of the slopes: of the place, which is moved relative to all birds ahead at once, of the stroke, of the lag.
BY_X, BY_Y, BY_Z, BY_AMPLITUDE, BY_RATIO, BY_PHASE = range(6)


class Felt(NamedTuple):
    """The wakes behind birds that all flap alike, and the follower in them.

    Attributes
    ----------
    is_endless : bool
        Whether the wake is `endless`, or consists of `lanes`.
    wavelength : float
        In semispans.
    own : Constants
        The follower's own force and its cost.
    power : Constants
        The same with its power as the cost.
    lanes : (15, l) ndarray of float
        As from `upwash.aero.lanes.wake_lanes`, each with its whole strength: weight β₀ = 1, β₁ = 0.
    states : (2, l) ndarray of int
        State of the bird ahead and of the follower in each lane.
    stroke_states : int
        Number N of states.
    endless : EndlessWake
        An endless wake; without steps if there is none.
    """

    is_endless: bool
    wavelength: float
    own: Constants
    power: Constants
    lanes: NDArray[np.float64]
    states: NDArray[np.int64]
    stroke_states: int
    endless: EndlessWake


class Room(NamedTuple):
    """Scratch for looking at one place: made once, filled by `settle`.

    Attributes
    ----------
    lanes : (15 k l,) ndarray of float
        Lanes of all birds ahead that have a phase weight, row by row.
    edges : (4, k l) ndarray of float
        The squared radius of each lane's core.
    used : (1,) ndarray of int
        Number of those lanes.
    places : (k, 4) ndarray of float
        The follower's place relative to each bird ahead.
    steps : (4, n) ndarray of float
        Scratch of the endless force.
    point : (6,) ndarray of float
        Scratch.
    slopes, part : (2, 6) ndarray of float
        Slopes of the lift and of the thrust balance; scratch of one bird ahead.
    balance : (2,) ndarray of float
        Lift and thrust in excess, in weights.
    falls : (1,) ndarray of int
        1 once lift was seen to fall where the span ratio rises.
    """

    lanes: NDArray[np.float64]
    edges: NDArray[np.float64]
    used: NDArray[np.int64]
    places: NDArray[np.float64]
    steps: NDArray[np.float64]
    point: NDArray[np.float64]
    slopes: NDArray[np.float64]
    part: NDArray[np.float64]
    balance: NDArray[np.float64]
    falls: NDArray[np.int64]


@kernel
def make_room(felt, birds_ahead):
    """Return scratch for places behind so many birds."""
    lanes = felt.lanes.shape[1] * birds_ahead
    return Room(
        np.empty(ROWS * lanes),
        np.empty((4, lanes)),
        np.zeros(1, np.int64),
        np.empty((birds_ahead, 4)),
        np.empty((4, felt.endless.steps.shape[1])),
        np.empty(6),
        np.empty((2, 6)),
        np.empty((2, 6)),
        np.empty(2),
        np.zeros(1, np.int64),
    )


@kernel
def settle(places, felt, room):
    """Take a place: put it into the room, with the phase weights that hold there.

    Parameters
    ----------
    places : (k, 4) ndarray of float
        Relative to each bird ahead.
    felt : Felt
        The wakes.
    room : Room
        Filled.
    """
    for bird in range(places.shape[0]):
        for i in range(4):
            room.places[bird, i] = places[bird, i]
    if not felt.is_endless:
        _weigh(felt, room)


@kernel
def _weigh(felt, room):
    """Lay out the lanes that last for some of the wingbeat, seen from the first bird ahead."""
    places, count, used = room.places, 0, 0
    for bird in range(places.shape[0]):
        for lane in range(felt.lanes.shape[1]):
            weight, slope = _share(places[bird, PHASE], lane, felt)
            count += 1 if weight > 0.0 or slope > 0.0 else 0
    lanes = room.lanes[: ROWS * count].reshape((ROWS, count))
    for bird in range(places.shape[0]):
        dx, dy, dz = (
            places[0, X] - places[bird, X],
            places[0, Y] - places[bird, Y],
            places[0, Z] - places[bird, Z],
        )
        for lane in range(felt.lanes.shape[1]):
            weight, slope = _share(places[bird, PHASE], lane, felt)
            if not (weight > 0.0 or slope > 0.0):
                continue
            for row in range(ROWS):
                lanes[row, used] = felt.lanes[row, lane]
            lanes[FIRST_X, used] += dx
            lanes[LAST_X, used] += dx
            lanes[FIRST_Z, used] += dz
            lanes[LAST_Z, used] += dz
            lanes[CENTRE_Y, used] += dy
            lanes[STEADY, used] = weight * felt.lanes[STEADY, lane]
            lanes[SLIDING, used] = slope * felt.lanes[STEADY, lane]
            for filament in range(4):
                room.edges[filament, used] = felt.lanes[CORE2, lane]
            used += 1
    room.used[0] = used


@kernel(inline="always")
def _share(phase, lane, felt):
    """Return how long a lane's two states last together, and how that changes with the lag (`phase_weights`)."""
    states = felt.stroke_states
    lag = phase + (felt.states[1, lane] - felt.states[0, lane]) / states
    lag -= np.floor(lag)
    if lag < 1.0 / states:
        return 1.0 / states - lag, -1.0
    if lag >= 1.0 - 1.0 / states:
        return 1.0 / states - (1.0 - lag), 1.0
    return 0.0, 0.0


@kernel
def look(amplitude, ratio, felt, room):
    """Fill in what is in excess of weight and drag with a stroke at the place in the room, and its slopes.

    Parameters
    ----------
    amplitude : float
        In semispans.
    ratio : float
        Upstroke span ratio.
    felt : Felt
        The wakes.
    room : Room
        `balance` and `slopes` are overwritten.
    """
    own, slopes, part, places, point = felt.own, room.slopes, room.part, room.places, room.point
    lift = thrust = 0.0
    point[3], point[4] = amplitude, ratio
    if felt.is_endless:
        slopes[:] = 0.0
        for bird in range(places.shape[0]):
            phase = places[bird, X] / felt.wavelength - places[bird, PHASE]
            point[0] = phase - np.floor(phase - LEAST_PHASE)
            point[1], point[2] = places[bird, Y], places[bird, Z]
            found = endless_force_jacobian(point, felt.endless, room.steps, part)
            lift += found[0]
            thrust += found[1]
            for c in range(2):
                slopes[c, BY_X] += part[c, 0] / felt.wavelength
                slopes[c, BY_PHASE] -= part[c, 0]
                for i in range(1, 5):
                    slopes[c, i] += part[c, i]
    else:
        point[0], point[1], point[2], point[5] = places[0, X], places[0, Y], places[0, Z], 0.0
        lanes = room.lanes[: ROWS * room.used[0]].reshape((ROWS, room.used[0]))
        lift, thrust = wake_force_jacobian(point, lanes, room.edges, slopes)
    thrust_span = own.thrust_fixed + own.thrust_ratio * ratio
    room.balance[0] = own.lift_fixed + own.lift_ratio * ratio + lift - 1.0
    room.balance[1] = amplitude * thrust_span + thrust - own.drag
    slopes[0, BY_RATIO] += own.lift_ratio
    slopes[1, BY_AMPLITUDE] += thrust_span
    slopes[1, BY_RATIO] += amplitude * own.thrust_ratio


@kernel
def cost_of_stroke(amplitude, ratio, own):
    """Return the cost of a stroke over that of the lone bird, and its slopes by amplitude and ratio."""
    thrust_span = own.thrust_fixed + own.thrust_ratio * ratio
    lift, thrust = own.lift_fixed + own.lift_ratio * ratio, amplitude * thrust_span
    cost, by_lift, by_thrust = cost_of(lift, thrust, own)
    by_ratio = by_lift * own.lift_ratio + by_thrust * amplitude * own.thrust_ratio
    return cost, by_thrust * thrust_span, by_ratio
