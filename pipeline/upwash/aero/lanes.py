"""The lanes of a wake: every vortex ring as seen from every span node in every stroke state, laid out as arrays.

`upwash.aero.compiled.lanes` computes the force from them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from upwash.aero.compiled.lanes import FIRST_X, FIRST_Z, LAST_X, LAST_Z
from upwash.aero.compiled.rings import FOUR_PI
from upwash.aero.span_integral import span_nodes
from upwash.aero.wake import Wake, stroke_height, stroke_span


def wake_lanes(
    wake: Wake,
    steady: NDArray[np.float64],
    sliding: NDArray[np.float64],
    follower_circulation: NDArray[np.float64],
    stroke_states: int,
    node_count: int | str,
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

    Returns
    -------
    (14, N m n) ndarray of float
        One column a lane; lanes of one follower state and node are neighbours.
    """
    nodes, weights = span_nodes(node_count)
    columns = []
    for k in range(stroke_states):
        fixed, flexed = stroke_span(k / stroke_states)
        for node, weight in zip(nodes, weights, strict=True):
            for ring, circulation, j in zip(wake.rings, wake.circulation, wake.state, strict=True):
                along = np.array([ring[LAST_X] - ring[FIRST_X], ring[LAST_Z] - ring[FIRST_Z]])
                strength = follower_circulation[k] * weight * circulation / FOUR_PI
                columns.append(
                    [
                        *ring,
                        *(along / np.linalg.norm(along)),
                        node,
                        fixed,
                        flexed,
                        stroke_height(k / stroke_states),
                        strength * steady[j, k],
                        strength * sliding[j, k],
                    ]
                )
    return np.ascontiguousarray(np.array(columns).T)
