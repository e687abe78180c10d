"""How far a bird may be off a place before what it saves there is gone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.aero.pose import Pose
from upwash.place.balance import Behind
from upwash.place.compiled.balances import FOUND, RESULTS, SAVING, cheapest_at
from upwash.place.compiled.felt import BY_AMPLITUDE, BY_RATIO
from upwash.place.compiled.jitter import balance_on_average

AXES = ("x", "y", "z", "phase")

FIRST_STEP, GROWTH, FARTHEST = 1e-4, 1.15, (3.0, 3.0, 3.0, 0.5)
"""Places are looked at from a ten-thousandth of a semispan, or wingbeat, on, each a little farther than the last."""

HALVINGS = 30


@dataclass(frozen=True)
class Tolerance:
    """How far a place reaches.

    Attributes
    ----------
    half_width_m : (3, 2) ndarray of float
        How far along x, y and z, backward and forward, the saving of the cheapest stroke falls to half of what it is at
        the place, in m; infinite if it does not within three semispans.
    half_width_phase : (2,) ndarray of float
        The same of the lag, in wingbeats; infinite if it does not within half of one.
    fold_m : float
        The least distance along these axes at which the stroke of the place, followed, balances no more, in m;
        infinite if it does within three semispans.
    """

    half_width_m: NDArray[np.float64]
    half_width_phase: NDArray[np.float64]
    fold_m: float


def tolerance(behind: Behind, pose: Pose) -> Tolerance:
    """Return how far a place reaches at which a bird balances.

    Parameters
    ----------
    behind : Behind
        The follower, behind one bird.
    pose : Pose
        Its place, and the stroke with which it balances there.

    Examples
    --------
    >>> from upwash import load_species
    >>> from upwash.aero.pose import Stroke
    >>> ibis = Behind(load_species("northern-bald-ibis").bird(), "power")
    >>> best = Pose(1.7765, 0.88857, -0.14586, Stroke(0.69001, 0.36837), 0.5)
    >>> bool(np.all(tolerance(ibis, best).half_width_m[0] < 0.01))
    True
    """
    b = behind.bird.semispan_m
    place = np.array([pose.x_m / b, pose.y_m / b, pose.z_m / b, pose.phase])
    half = 0.5 * _saving(behind, place)

    def saves_half(moved: NDArray[np.float64]) -> bool:
        return _saving(behind, moved) > half

    followed = _Followed(behind, place, np.array([pose.stroke.amplitude_m / b, pose.stroke.span_ratio]))
    widths = np.full((len(AXES), 2), np.inf)
    folds = [np.inf]
    for axis in range(len(AXES)):
        for side, sign in enumerate((-1.0, 1.0)):
            widths[axis, side] = _reach(place, axis, sign, saves_half)
            if axis < len(AXES) - 1:
                folds.append(_reach(place, axis, sign, followed.restarted()))
    return Tolerance(widths[:3] * b, widths[3], min(folds) * b)


def _saving(behind: Behind, place: NDArray[np.float64]) -> float:
    """Return the saving of the cheapest stroke at a place; less than any where none balances."""
    results = np.full((1, RESULTS), np.nan)
    nowhere = np.zeros((1, 4))
    of_first = np.array([0, 1]), np.zeros(1, np.int64), nowhere
    cheapest_at(place[None, :], *of_first, behind.bounds, behind.felt, results)
    return float(results[0, SAVING]) if results[0, FOUND] else -np.inf


def _reach(
    place: NDArray[np.float64], axis: int, sign: float, holds: Callable[[NDArray[np.float64]], bool]
) -> float:
    """Return how far along an axis something holds, looked at ever farther and then halved."""

    def at(distance: float) -> bool:
        moved = place.copy()
        moved[axis] += sign * distance
        return holds(moved)

    inner, outer = 0.0, FIRST_STEP
    while at(outer):
        if outer >= FARTHEST[axis]:
            return np.inf
        inner, outer = outer, min(GROWTH * outer, FARTHEST[axis])
    for _ in range(HALVINGS):
        middle = 0.5 * (inner + outer)
        inner, outer = (middle, outer) if at(middle) else (inner, middle)
    return outer


class _Followed:
    """Whether a stroke, followed from place to place, still balances, and has met no fold."""

    def __init__(self, behind: Behind, place: NDArray[np.float64], stroke: NDArray[np.float64]) -> None:
        self.behind, self.place, self.start = behind, place, stroke
        self.still = np.zeros((1, 4))
        self.balance, self.slopes = np.empty(2), np.empty((2, 6))

    def restarted(self) -> Callable[[NDArray[np.float64]], bool]:
        """Return what follows the stroke anew, from where it starts."""
        stroke = self.start.copy()
        self._reaches(self.place, stroke)
        side = self._turns()
        last = [stroke]

        def holds(place: NDArray[np.float64]) -> bool:
            tried = last[0].copy()
            if not self._reaches(place, tried) or self._turns() != side:
                return False
            last[0] = tried
            return True

        return holds

    def _reaches(self, place: NDArray[np.float64], stroke: NDArray[np.float64]) -> bool:
        felt, room = self.behind.felt, self.behind.room(1)
        reached = balance_on_average(place, self.still, stroke, felt, room, self.balance, self.slopes)
        bounds = self.behind.bounds
        return bool(
            reached
            and bounds.least_amplitude <= stroke[0] <= bounds.most_amplitude
            and bounds.least_ratio <= stroke[1] <= bounds.most_ratio
        )

    def _turns(self) -> bool:
        """On which side of a fold the stroke lies: the sign of the determinant of the balances' slopes."""
        by_amplitude, by_ratio = self.slopes[:, BY_AMPLITUDE], self.slopes[:, BY_RATIO]
        return bool(by_amplitude[0] * by_ratio[1] > by_amplitude[1] * by_ratio[0])
