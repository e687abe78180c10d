"""Three dimensions on paper: a parallel projection, so that equal lengths along an axis stay equal."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike, NDArray

from upwash.report.figures.drawing import FAINT


@dataclass(frozen=True)
class View:
    """Where one looks from: the birds' left, turned by an azimuth to the front and raised by an elevation.

    Parameters
    ----------
    azimuth_deg, elevation_deg : float
        Both angles, in degrees; at zero downstream points to the right and up points up.
    """

    azimuth_deg: float
    elevation_deg: float

    def flat(self, points: ArrayLike) -> NDArray[np.float64]:
        """Return where points appear.

        Parameters
        ----------
        points : (..., 3) array_like of float
            Positions: downstream, right, up.

        Returns
        -------
        (..., 2) ndarray of float
            Right and up on paper, in the same unit.
        """
        a, e = math.radians(self.azimuth_deg), math.radians(self.elevation_deg)
        right = (math.cos(a), math.sin(a), 0.0)
        up = (-math.sin(a) * math.sin(e), math.cos(a) * math.sin(e), math.cos(e))
        return np.asarray(points, dtype=float) @ np.array([right, up]).T


def draw_directions(axes: Axes, view: View, origin: ArrayLike, length: float) -> None:
    """Draw three short arrows that say which way is downstream (x), right (y) and up (z)."""
    start = np.asarray(origin, dtype=float)
    for name, direction in zip("xyz", np.eye(3), strict=True):
        ends = view.flat([start, start + length * direction, start + 1.35 * length * direction])
        axes.annotate(
            "",
            ends[1],
            ends[0],
            arrowprops={"arrowstyle": "->", "color": FAINT, "linewidth": 0.8, "shrinkA": 0, "shrinkB": 0},
        )
        axes.text(ends[2, 0], ends[2, 1], name, color=FAINT, ha="center", va="center", fontsize=7)
