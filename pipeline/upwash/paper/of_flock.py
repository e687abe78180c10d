"""What the paper says of its six-bird flock, in both readings of its bound on amplitude and for both costs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from upwash.paper.claim import Cases, Measure, Measures
from upwash.paper.evidence import Evidence

Values = NDArray[np.float64]


def _each(column: str, of: Callable[[Values], float]) -> Measure:
    """Measure each flock by one column, one value a bird."""

    def measure(evidence: Evidence) -> Cases:
        return {case: float(of(values)) for case, values in evidence.flock_cases(column).items()}

    return measure


def _irregularity(values: Values) -> float:
    """Largest departure of the links from their mean, in percent of it."""
    links = values[1:]
    return 100.0 * float(np.max(np.abs(links / np.mean(links) - 1.0)))


def _spacing(evidence: Evidence) -> Cases:
    across, along = _each("y_m", _irregularity)(evidence), _each("x_m", _irregularity)(evidence)
    return {case: max(along[case], across[case]) for case in along}


def _best_bird(values: Values) -> float:
    return float(np.argmin(values) + 1)


def _rises(saving: Values) -> float:
    """How often a bird saves more than the one ahead, from bird 3 on."""
    return float(np.sum(np.diff(saving[1:]) > 1e-6))


def _later_over_second(saving: Values) -> float:
    """Least saving of birds 3 to 6 over that of bird 2."""
    return float(np.min(saving[2:]) / saving[1])


def _spread(power: Values) -> float:
    """Range of total power of birds 3 to 6, in percent of the first bird's."""
    return 100.0 * float(np.ptp(power[2:]) / power[0])


def _largest_growth(amplitude: Values) -> float:
    """Largest amplitude of a follower over that of the bird ahead, less 1."""
    return float(np.max(amplitude[1:] / amplitude[:-1] - 1.0))


def _growth(evidence: Evidence) -> Cases:
    """Largest amplitude of a follower over that of the bird ahead, less 1, in the pair and in the flocks."""
    pair = {
        f"pair, {objective}": -reduction
        for objective, reduction in evidence.of_v("amplitude_reduction").items()
    }
    return {**pair, **_each("amplitude_m", _largest_growth)(evidence)}


def _height_variation(evidence: Evidence) -> Cases:
    """Range of the links' heights, in percent of the first bird's amplitude."""
    amplitude = evidence.bird.amplitude_m
    return _each("z_m", lambda values: 100.0 * np.ptp(values[1:]) / amplitude)(evidence)


MEASURES: Measures = {
    "flock-regular": _spacing,
    "flock-antiphase": _each("phase", lambda values: np.max(np.abs(values[1:] - 0.5))),
    "flock-second-is-best-by-cost": _each("cost", _best_bird),
    "flock-second-is-best-by-power": _each("power_total_w", _best_bird),
    "flock-substantial": _each("saving_total", _later_over_second),
    "flock-saturates": _each("power_total_w", _spread),
    "flock-no-decay": _each("saving_total", _rises),
    "flock-height": _height_variation,
    "amplitude-bound": _growth,
}
"""Claim -> our value in each case."""
