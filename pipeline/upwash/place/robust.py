"""What is left of a saving while a bird drifts about its place, and the place that leaves most.

A place jitters with independent normal errors.  Either the bird flaps always alike, with one stroke that balances in
the mean, or it trims its stroke anew at each place.  The first is smooth in place and stroke even where the wake is
not, so the place that leaves most is found by a library's step programme with our exact slopes, from the best of a grid
of starts, one piece of phase after another, and is held to its own mean balance.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.aero.pose import Pose, Stroke
from upwash.optimum.problem import ASTERN, LEVEL, OUTBOARD
from upwash.place.balance import Behind
from upwash.place.compiled.balances import FOUND, RESULTS, SAVING, cheapest_at
from upwash.place.compiled.felt import cost_of_stroke
from upwash.place.compiled.jitter import balance_on_average, look_on_average
from upwash.place.survey import normal_draws

DRAWS, RETRIMMED_DRAWS, FEW_DRAWS = 4096, 1024, 256
"""Places that stand for a jitter; for the mean of strokes that are trimmed anew; and with which starts are compared.
They are powers of two, as they are spread evenly, and so are the first of them."""

STARTS = (
    (0.3, 0.15),
    (0.6, 0.30),
    (0.9, 0.35),
    (1.2, 0.40),
    (1.5, 0.45),
    (1.8, 0.60),
)
"""Strokes from which one that balances in the mean is sought: amplitude in semispans, and upstroke span ratio."""

ASIDE, PHASES, BEHIND_PER_WAVE = 11, 8, 8
"""Starts to the side, in phase, and along a wavelength, where the best place is sought."""

MOST_ASIDE, MOST_HIGH = 2.5, 0.8
"""How far to the side it is sought, and how far above or below, in semispans."""

STARTS_KEPT = 3
"""The best starts from which it is sought with all draws."""

PLACE, STROKE = [0, 1, 2, 5], [3, 4]
"""Where a point (x, y, z, h, R, lag) holds place and stroke."""


@dataclass(frozen=True)
class Spread:
    """How far a place jitters: standard deviations.

    Attributes
    ----------
    x_m, y_m, z_m : float
        Of the place, in m.
    phase : float
        Of the lag, in wingbeats.
    """

    x_m: float
    y_m: float
    z_m: float
    phase: float = 0.0

    @classmethod
    def of_place(cls, sigma_m: float, phase: float = 0.0) -> Spread:
        """Return the same deviation in x, y and z."""
        return cls(sigma_m, sigma_m, sigma_m, phase)


@dataclass(frozen=True)
class Remaining:
    """What is left at a place that jitters.

    Attributes
    ----------
    pose : Pose or None
        The middle of the place, with the one stroke that balances in the mean; None if none does.
    saving_held : float
        Saving of power with that stroke; NaN if there is none.
    saving_retrimmed : float
        Mean saving of power of the cheapest stroke at each place, where one balances.
    balanced_share : float
        Share of the places at which one does.
    """

    pose: Pose | None
    saving_held: float
    saving_retrimmed: float
    balanced_share: float


class Jittering:
    """A follower whose place jitters.

    Parameters
    ----------
    behind : Behind
        The follower, behind one bird.
    spread : Spread
        How far.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = Behind(load_species("northern-bald-ibis").bird(), "power")
    >>> best = Pose(1.7765, 0.88857, -0.14586, Stroke(0.69001, 0.36837), 0.5)
    >>> still = Jittering(ibis, Spread(0.0, 0.0, 0.0)).remaining(best)
    >>> drifting = Jittering(ibis, Spread.of_place(0.03)).remaining(best)
    >>> print(f"{still.saving_held:.1%} at rest, {drifting.saving_held:.1%} while it drifts by 3 cm")
    16.6% at rest, 4.2% while it drifts by 3 cm
    """

    def __init__(self, behind: Behind, spread: Spread) -> None:
        self.behind, self.spread = behind, spread
        self.room = behind.room(1)
        b = behind.bird.semispan_m
        self.unit = np.array([b, b, b, 1.0])
        self.deviations = np.array([spread.x_m, spread.y_m, spread.z_m, spread.phase]) / self.unit
        self.draws = normal_draws(DRAWS) * self.deviations
        self.few = self.draws[:FEW_DRAWS]
        self.balance, self.slopes = np.empty(2), np.empty((2, 6))

    def remaining(self, pose: Pose) -> Remaining:
        """Return what is left at the place of a pose; its stroke has no say."""
        held, saving = self.held(pose)
        results = self._retrimmed(np.array([*pose.position_m, pose.phase]) / self.unit)
        balances = results[:, FOUND] > 0.0
        return Remaining(
            held,
            np.nan if saving is None else saving,
            float(np.mean(results[balances, SAVING])) if np.any(balances) else np.nan,
            float(np.mean(balances)),
        )

    def held(self, pose: Pose) -> tuple[Pose | None, float | None]:
        """Return a pose's place with the cheapest stroke that balances in the mean, and its saving; None if none."""
        place = np.array([*pose.position_m, pose.phase]) / self.unit
        stroke = self._cheapest(place)
        return (None, None) if stroke is None else (self._pose(place, stroke), self._saving(*stroke))

    def best(self, known: Iterable[Pose] = (), in_v: bool = False) -> Remaining | None:
        """Return what is left at the place that leaves most to a bird with one stroke; None if no place is found.

        Parameters
        ----------
        known : iterable of Pose
            Places from which it is sought as well, such as the still optimum.
        in_v : bool
            Whether it is sought outboard, level and astern alone.
        """
        least, chosen = np.inf, None
        ranges = self._ranges(in_v)
        for piece, start in self._starts(known, ranges):
            found = self._descend(start, np.array([*ranges, piece]))
            if found is not None and found[0] < least:
                least, chosen = found
        if chosen is None:
            return None
        return self.remaining(self._pose(chosen[PLACE], chosen[STROKE]))

    def _saving(self, amplitude: float, ratio: float) -> float:
        return 1.0 - float(cost_of_stroke(amplitude, ratio, self.behind.felt.power)[0])

    def _cost(self, amplitude: float, ratio: float) -> float:
        return float(cost_of_stroke(amplitude, ratio, self.behind.felt.own)[0])

    def _retrimmed(self, place: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return what is found where the place is moved by each of some draws."""
        results = np.full((RETRIMMED_DRAWS, RESULTS), np.nan)
        cheapest_at(
            place[None, :],
            np.array([0, 1]),
            np.zeros(RETRIMMED_DRAWS, np.int64),
            self.draws[:RETRIMMED_DRAWS],
            self.behind.bounds,
            self.behind.felt,
            results,
        )
        return results

    def _cheapest(self, place: NDArray[np.float64]) -> NDArray[np.float64] | None:
        """Return the cheapest stroke that balances in the mean at a place, in semispans and as a ratio."""
        found: list[NDArray[np.float64]] = []
        for start in STARTS:
            stroke = np.array(start)
            if self._balances(place, self.few, stroke) and self._balances(place, self.draws, stroke):
                found.append(stroke)
        return min(found, key=lambda stroke: self._cost(*stroke), default=None)

    def _balances(
        self, place: NDArray[np.float64], draws: NDArray[np.float64], stroke: NDArray[np.float64]
    ) -> bool:
        """Move a stroke to one that balances in the mean; return whether there is one within bounds."""
        reached = balance_on_average(
            place, draws, stroke, self.behind.felt, self.room, self.balance, self.slopes
        )
        bounds = self.behind.bounds
        return bool(
            reached
            and bounds.least_amplitude <= stroke[0] <= bounds.most_amplitude
            and bounds.least_ratio <= stroke[1] <= bounds.most_ratio
        )

    def _ranges(self, in_v: bool) -> list[tuple[float, float]]:
        """Return the ranges of x, y, z, h and R in which the best place is sought."""
        felt, bounds, bird = self.behind.felt, self.behind.bounds, self.behind.bird
        length = 1.0 if felt.is_endless else float(self.behind.model.wavelengths)
        high = LEVEL * bird.amplitude_m / bird.semispan_m if in_v else MOST_HIGH
        return [
            (ASTERN if in_v else 0.0, felt.wavelength * length),
            (OUTBOARD if in_v else 0.0, MOST_ASIDE),
            (-high, high),
            (bounds.least_amplitude, bounds.most_amplitude),
            (bounds.least_ratio, bounds.most_ratio),
        ]

    def _starts(
        self, known: Iterable[Pose], ranges: list[tuple[float, float]]
    ) -> list[tuple[tuple[float, float], NDArray[np.float64]]]:
        """Return the best starts, each with the piece of phase that it lies in, as (x, y, z, h, R, lag)."""
        places = [np.array([*pose.position_m, pose.phase]) / self.unit for pose in known]
        (ahead, reach), (inner, outer) = ranges[:2]
        # Behind an endless wake the distance is the one that is known, or any.
        streamwise = [places[0][0] if places else 0.5 * (ahead + reach)]
        if not self.behind.felt.is_endless:
            count = BEHIND_PER_WAVE * int(self.behind.model.wavelengths)
            streamwise = [ahead + (k + 0.5) * (reach - ahead) / count for k in range(count)]
        places += [
            np.array([x, y, 0.0, (lag + 0.5) / PHASES])
            for x in streamwise
            for y in np.linspace(inner, outer, ASIDE)
            for lag in range(PHASES)
        ]
        starts = []
        for place in places:
            stroke = np.array(STARTS[2])
            if self._balances(place, self.few, stroke):
                starts.append((self._cost(*stroke), *place[:3], *stroke, place[3]))
        starts.sort()
        return [(self._piece(start[-1]), np.array(start[1:])) for start in starts[:STARTS_KEPT]]

    def _piece(self, lag: float) -> tuple[float, float]:
        """Return the range of lags in which the phase weights have no kink and a lag lies."""
        if self.behind.felt.is_endless:
            return lag - 0.5, lag + 0.5
        states = self.behind.model.stroke_states
        first = np.floor(lag * states) / states
        # At its end the lag is the next piece's.
        return float(first), float(np.nextafter(first + 1.0 / states, 0.0))

    def _descend(
        self, start: NDArray[np.float64], ranges: NDArray[np.float64]
    ) -> tuple[float, NDArray[np.float64]] | None:
        """Return the cost and the point where the descent from a start ends, if it balances in the mean there."""
        from scipy.optimize import minimize

        felt, scale = self.behind.felt, np.array([1.0, 1.0 / self.behind.felt.own.drag])
        if felt.is_endless:
            ranges[0] = start[0]
        seen: list[NDArray[np.float64]] = []

        def look(point: NDArray[np.float64]) -> None:
            # Values and slopes are asked for one after the other.
            if not seen or not np.array_equal(seen[0], point):
                place, stroke = np.ascontiguousarray(point[PLACE]), point[STROKE]
                look_on_average(place, self.draws, *stroke, felt, self.room, self.balance, self.slopes)
                seen[:] = [point.copy()]

        def missing(point: NDArray[np.float64]) -> NDArray[np.float64]:
            look(point)
            return self.balance * scale

        def missing_slopes(point: NDArray[np.float64]) -> NDArray[np.float64]:
            look(point)
            return self.slopes * scale[:, None]

        def cost(point: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
            value, by_amplitude, by_ratio = cost_of_stroke(*point[STROKE], felt.own)
            return float(value), np.array([0.0, 0.0, 0.0, by_amplitude, by_ratio, 0.0])

        result = minimize(
            cost,
            np.clip(start, *ranges.T),
            jac=True,
            method="SLSQP",
            bounds=ranges,
            constraints={"type": "eq", "fun": missing, "jac": missing_slopes},
            options={"maxiter": 200, "ftol": 1e-12},
        )
        # The library's word is not taken for it.
        point = np.clip(result.x, *ranges.T)
        stroke = point[STROKE]
        if not self._balances(np.ascontiguousarray(point[PLACE]), self.draws, stroke):
            return None
        point[STROKE] = stroke
        return self._cost(*stroke), point

    def _pose(self, place: NDArray[np.float64], stroke: NDArray[np.float64]) -> Pose:
        x, y, z, lag = (float(value) for value in place * self.unit)
        b = self.behind.bird.semispan_m
        return Pose(x, y, z, Stroke(float(stroke[0]) * b, float(stroke[1])), lag % 1.0)
