"""The airspeed at which flight costs least, from a pair solved at several airspeeds."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def best_speed(speed_m_s: NDArray[np.float64], cost: NDArray[np.float64]) -> float:
    """Return the airspeed of least cost, by a parabola through the least value and its neighbours.

    Parameters
    ----------
    speed_m_s : (n,) ndarray of float
        Airspeeds in increasing order, in m/s.
    cost : (n,) ndarray of float
        What flight costs at each.

    Returns
    -------
    float
        The airspeed in m/s; at an end of the range it is that end, beyond which nothing is known.
    """
    least = int(np.argmin(cost))
    if least in (0, cost.size - 1):
        return float(speed_m_s[least])
    near = slice(least - 1, least + 2)
    # About the middle one, so that the fit is well conditioned.
    curvature, slope, _ = np.polyfit(speed_m_s[near] - speed_m_s[least], cost[near], 2)
    return float(speed_m_s[least] - slope / (2.0 * curvature))
