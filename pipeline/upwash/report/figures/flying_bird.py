"""A bird in the air, in three dimensions: outlines of its body, tail and two wings at any moment of a wingbeat."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Edge = tuple[tuple[float, ...], ...]

BODY_ABOVE: Edge = (
    *((-0.50, 0.0), (-0.41, 0.022), (-0.36, 0.042), (-0.29, 0.034), (-0.2, 0.062)),
    *((0.0, 0.085), (0.2, 0.055), (0.3, 0.045), (0.47, 0.1), (0.5, 0.05)),
)
"""Half of a body from above, bill to tail, in semispans: downstream, aside."""

BODY_SIDE: Edge = (
    *((-0.52, 0.025), (-0.43, 0.052), (-0.385, 0.085), (-0.335, 0.08), (-0.28, 0.05), (-0.15, 0.075)),
    *((0.03, 0.08), (0.25, 0.045), (0.5, 0.05), (0.5, 0.02), (0.25, -0.02), (0.05, -0.085)),
    *((-0.15, -0.075), (-0.27, -0.01), (-0.34, 0.022), (-0.42, 0.032)),
)
"""A body from the side: downstream, up."""

WING: Edge = (
    *((-0.19, 0.0, 0.03), (-0.25, -0.05, 0.28), (-0.28, -0.09, 0.5), (-0.19, 0.0, 0.74), (0.0, 0.2, 1.0)),
    *((0.06, 0.2, 0.93), (0.07, 0.1, 0.68), (0.1, 0.0, 0.42), (0.13, 0.0, 0.2), (0.15, 0.0, 0.03)),
)
"""A wing, along its leading edge to the tip and back: downstream when outstretched and what flexing adds to that, in
semispans, and the share of the half-span."""

ARCH = 0.7
"""Power of the share of the half-span with which a wing rises: below 1 its arm moves more than its hand."""

ROUNDINGS = 2


def flying_bird(half_span: float, tip: float, flexed: float, semispan: float) -> list[NDArray[np.float64]]:
    """Return a bird's outlines around its reference point, in the order in which they are seen from its left.

    Parameters
    ----------
    half_span : float
        How far aside its wingtips are, in m.
    tip : float
        Height of its wingtips in m.
    flexed : float
        How far its wings are flexed: 0 outstretched, 1 as on the upstroke.
    semispan : float
        Half of its outstretched wings' span, in m, which sets the size of all else.

    Returns
    -------
    list of (n, 3) ndarray of float
        Right wing, body from above, body from the side, left wing: downstream, right, up, in m.

    Examples
    --------
    >>> right, *_, left = flying_bird(0.6, 0.3, 0.0, 0.6)
    >>> bool(right[:, 1].max() > 0.5 and left[:, 1].min() < -0.5)
    True
    """
    edge = np.array(WING)
    wing = np.stack(
        [semispan * (edge[:, 0] + flexed * edge[:, 1]), half_span * edge[:, 2], tip * edge[:, 2] ** ARCH],
        axis=-1,
    )
    above = np.array([*BODY_ABOVE, *((x, -y) for x, y in BODY_ABOVE[:0:-1])])
    side = np.array(BODY_SIDE)
    flat = np.zeros(len(above)), np.zeros(len(side))
    parts = [
        wing,
        semispan * np.column_stack([above, flat[0]]),
        semispan * np.column_stack([side[:, 0], flat[1], side[:, 1]]),
        wing * (1.0, -1.0, 1.0),
    ]
    return [_rounded(part) for part in parts]


def _rounded(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cut the corners of a closed outline, each time by a quarter of both sides (Chaikin's way)."""
    for _ in range(ROUNDINGS):
        after = np.roll(corners, -1, axis=0)
        corners = np.stack([0.75 * corners + 0.25 * after, 0.25 * corners + 0.75 * after], axis=1).reshape(
            -1, 3
        )
    return corners
