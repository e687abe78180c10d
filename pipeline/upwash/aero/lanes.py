"""The lanes of a wake: every vortex ring as seen from every span node in every stroke state, laid out as arrays.

`upwash.aero.compiled.lanes` computes the force from them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import (
    ALONG_X,
    ALONG_Z,
    CORE2,
    HEIGHT,
    NODE,
    ROWS,
    SLIDING,
    SPAN_FIXED,
    SPAN_FLEXED,
    STEADY,
)
from upwash.aero.compiled.rings import FOUR_PI
from upwash.aero.span_integral import span_nodes
from upwash.aero.wake import Wake, WakeModel
from upwash.aero.wingbeat import wingbeat_steps


def wake_lanes(
    wake: Wake,
    steady: NDArray[np.float64],
    sliding: NDArray[np.float64],
    follower_circulation: NDArray[np.float64],
    stroke_states: int,
    node_count: int | str,
    span_law: str = "tip",
) -> NDArray[np.float64]:
    """Lay out the lanes for a wake.

    Parameters
    ----------
    wake : Wake
        Rings with their circulation and stroke state, n of them, in the unit of length of the follower's position.
    steady, sliding : (N, N) ndarray of float
        Phase weights β₀ and β₁ of leader state (row) and follower state (column), as from `phase_piece`.
    follower_circulation : (N,) ndarray of float
        Circulation of the follower in each state, times twice the unit of half-span and the density, in the unit
        that turns velocity into the force wanted.
    stroke_states : int
        Number N of stroke states.
    node_count : int
        Number m of span nodes.
    span_law : str
        The follower's half-span through its wingbeat, see `upwash.aero.wake.WakeModel`.

    Returns
    -------
    (15, N m n) ndarray of float
        One column a lane; lanes of one follower state and node are neighbours.
    """
    nodes, weights = span_nodes(node_count)
    steps = wingbeat_steps(WakeModel(stroke_states=stroke_states, span_law=span_law))
    repeats = stroke_states * nodes.size
    lanes = np.empty((ROWS, repeats * wake.circulation.size))
    fill_rings(lanes, wake)
    lane = 0
    for k in range(stroke_states):
        flexed = float(steps.flexed[k])
        for node, weight in zip(nodes, weights, strict=True):
            for circulation, j in zip(wake.circulation, wake.state, strict=True):
                strength = follower_circulation[k] * weight * circulation / FOUR_PI
                lanes[NODE, lane], lanes[HEIGHT, lane] = node, steps.height[k]
                lanes[SPAN_FIXED, lane], lanes[SPAN_FLEXED, lane] = 1.0 - flexed, flexed
                lanes[STEADY, lane], lanes[SLIDING, lane] = strength * steady[j, k], strength * sliding[j, k]
                lane += 1
    return lanes


def fill_rings(lanes: NDArray[np.float64], wake: Wake) -> None:
    """Overwrite where the rings of lanes lie and how wide their cores are, by a wake of as many rings.

    Parameters
    ----------
    lanes : (15, k n) ndarray of float
        From `wake_lanes`.
    wake : Wake
        Its n rings.
    """
    repeats = lanes.shape[1] // wake.circulation.size
    first_x, last_x, first_z, last_z = wake.rings.T[:4]
    length = np.hypot(last_x - first_x, last_z - first_z)
    lanes[:6] = np.tile(wake.rings.T, repeats)
    lanes[ALONG_X] = np.tile((last_x - first_x) / length, repeats)
    lanes[ALONG_Z] = np.tile((last_z - first_z) / length, repeats)
    lanes[CORE2] = np.tile(wake.core_radius**2, repeats)


def core_edges(lanes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the squared distances beyond which the outer branch of the cores holds, filament by filament.

    Parameters
    ----------
    lanes : (15, l) ndarray of float
        From `wake_lanes`.

    Returns
    -------
    (4, l) ndarray of float
        As the compiled force takes them.
    """
    return np.tile(lanes[CORE2], (4, 1))
