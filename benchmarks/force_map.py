"""The net force on a follower over a plane of places: what `upwash field` and the figures ask for."""

from __future__ import annotations

import numpy as np
from upwash.aero.field_map import force_map
from upwash.aero.interaction import net_force
from upwash.aero.pose import Pose, Stroke

from benchmarks.contest import Contender, Contest
from benchmarks.wake_force import IBIS, PLACE, numpy_force

SIZE = 1000
SIDE_OF_PEERS = 20
"""Places along a side: ours, and those of contenders that take thousands of times longer."""


def places(size):
    """Return the coordinates of a plane: downstream and to the side, in m."""
    return np.linspace(0.0, 5.6, size), np.linspace(0.0, 1.8, size)


def compiled(size):
    """Return lift and thrust over a plane from the compiled map."""
    x, y, z, amplitude, ratio, mu = PLACE
    pose = Pose(x, y, z, Stroke(amplitude, ratio), 0.5 + mu)
    found = force_map(IBIS, IBIS.stroke, pose, "xy", *places(size))
    return np.stack([found.lift_n, found.thrust_n])


def by_place(force):
    """Return lift and thrust over a small plane from a function of one place."""
    first, second = places(SIDE_OF_PEERS)
    found = np.array([[force((x, y, *PLACE[2:])) for x in first] for y in second])
    return np.moveaxis(found, -1, 0)


def plain(place):
    """Return lift and thrust from the plain statement of the model."""
    x, y, z, amplitude, ratio, mu = place
    return np.array(net_force(IBIS, IBIS.stroke, Pose(x, y, z, Stroke(amplitude, ratio), 0.5 + mu)))


def contest() -> Contest:
    """Return the contest: 2 × 2 stroke states, 2 wingtips and 8 filaments at each place, on one core."""
    wake = numpy_force()
    own = np.array([IBIS.lift_n(PLACE[4]), IBIS.thrust_n(PLACE[3], PLACE[4])])

    def by_numpy(place):
        return own + wake(np.array(place))

    few = SIDE_OF_PEERS**2
    return Contest(
        "force_map",
        "place",
        [
            Contender("Upwash", lambda: compiled(SIZE), SIZE**2, lambda: compiled(SIDE_OF_PEERS)),
            Contender("Upwash's plain model", lambda: by_place(plain), few, lambda: by_place(plain)),
            Contender("numpy, place by place", lambda: by_place(by_numpy), few, lambda: by_place(by_numpy)),
        ],
    )
