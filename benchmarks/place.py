"""The strokes with which a follower balances at a given place: what `upwash evaluate` asks for, row by row."""

from __future__ import annotations

import numpy as np
from scipy.optimize import root
from upwash.aero.wake import WakeModel
from upwash.place.balance import Behind
from upwash.place.compiled.felt import cost_of_stroke, look, settle
from upwash.place.held import HeldPlaces

from benchmarks.contest import Contender, Contest
from benchmarks.wake_force import IBIS

PLACES = 400
PLACES_OF_PEERS = 40
"""Places: ours, and those of contenders that take much longer."""


def places(count):
    """Return places about a V, in semispans, with the lag."""
    random = np.random.default_rng(0)
    low, high = (0.8, 1.8, -0.3, 0.2), (4.0, 2.6, 0.3, 0.6)
    return random.uniform(low, high, (PLACES, 4))[:count]


def costs(held, count):
    """Return the cost of the cheapest of all strokes that balance at each place."""
    return held.balanced(places(count))[:, 2]


def by_scipy(behind, count):
    """Return the cost of the stroke that SciPy's root finder comes to from the lone bird's, by our compiled forces."""
    felt, room = behind.felt, behind.room(1)
    b, drag = IBIS.semispan_m, behind.felt.own.drag

    def missing(stroke):
        look(*stroke, felt, room)
        return room.balance / [1.0, drag], room.slopes[:, 3:5] / [[1.0], [drag]]

    found = []
    for place in places(count):
        settle(place[None, :], felt, room)
        start = IBIS.amplitude_m / b, IBIS.upstroke_span_ratio
        solution = root(missing, start, jac=True, tol=1e-12)
        found.append(cost_of_stroke(*solution.x, felt.own)[0])
    return np.array(found)


def contest() -> Contest:
    """Return the contest: all strokes within wide bounds against one, found by a library, on one core."""
    behind = Behind(IBIS)
    held, limit = HeldPlaces(behind, ()), HeldPlaces(Behind(IBIS, model=WakeModel.named("limit")), ())
    few = PLACES_OF_PEERS
    return Contest(
        "place",
        "place",
        [
            Contender("Upwash, all strokes", lambda: costs(held, PLACES), PLACES, lambda: costs(held, few)),
            Contender(
                "SciPy's root, one stroke", lambda: by_scipy(behind, few), few, lambda: by_scipy(behind, few)
            ),
            Contender("Upwash, all strokes in the limit", lambda: costs(limit, few), few),
        ],
    )
