"""What the paper says of its six-bird flock, in both readings of its bound on amplitude and for both costs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from upwash.paper.claim import Accepted, Cases, Claim, at_least, at_most, near
from upwash.paper.evidence import Evidence

PLACE = "Multi-bird flocks; Fig. 6"
REGULAR = 5.0
"""Largest departure of a link from the mean that counts as regular, in percent."""

Values = NDArray[np.float64]


def _each(column: str, of: Callable[[Values], float]) -> Callable[[Evidence], Cases]:
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
    pair = {f"pair, {one}": -reduction for one, reduction in evidence.of_v("amplitude_reduction").items()}
    return {**pair, **_each("amplitude_m", _largest_growth)(evidence)}


def _height_variation(evidence: Evidence) -> Cases:
    """Range of the links' heights, in percent of the first bird's amplitude."""
    amplitude = evidence.bird.amplitude_m
    return _each("z_m", lambda values: 100.0 * np.ptp(values[1:]) / amplitude)(evidence)


def _claim(
    name: str,
    says: str,
    printed: str,
    unit: str,
    accepted: Accepted,
    measure: Callable[[Evidence], Cases],
    why: str,
) -> Claim:
    return Claim(name, PLACE, says, printed, unit, accepted, measure, why, needs="flocks")


CLAIMS = (
    _claim(
        "flock-regular",
        "spacing from bird to bird is highly regular seen from above",
        "highly regular",
        "%",
        at_most(REGULAR),
        _spacing,
        "Largest departure of any link, along or across, from the mean.",
    ),
    _claim(
        "flock-antiphase",
        "each bird flaps in antiphase to the one ahead",
        "0.5",
        "",
        near(0.0, 0.005),
        _each("phase", lambda values: np.max(np.abs(values[1:] - 0.5))),
        "Largest departure of a link's phase from ½.",
    ),
    _claim(
        "flock-second-is-best-by-cost",
        "benefits are largest for bird 2: its cost is the lowest",
        "2",
        "bird",
        near(2.0, 0.0),
        _each("cost", _best_bird),
        "With least force. With least power bird 3 does better than bird 2, in either reading.",
    ),
    _claim(
        "flock-second-is-best-by-power",
        "benefits are largest for bird 2: its total power is the lowest",
        "2",
        "bird",
        near(2.0, 0.0),
        _each("power_total_w", _best_bird),
        "Even with least force later birds spend less: they give up lift for thrust, which is worth more power.",
    ),
    _claim(
        "flock-substantial",
        "birds behind the second keep substantial savings",
        "substantial gains",
        "of bird 2's",
        at_least(0.5),
        _each("saving_total", _later_over_second),
        "Least saving of birds 3 to 6 over bird 2's; with least force read `lone` every other bird saves less than "
        "half.",
    ),
    _claim(
        "flock-saturates",
        "savings saturate rapidly, with low variation",
        "low variation",
        "%",
        at_most(1.0),
        _each("power_total_w", _spread),
        "Range of power of birds 3 to 6 over the leader's; with least force read `lone` the flock zig-zags between two "
        "kinds of optimum.",
    ),
    _claim(
        "flock-no-decay",
        "savings do not decay monotonically down the flock",
        "not monotonically",
        "rises",
        at_least(1.0),
        _each("saving_total", _rises),
        "How often a bird saves more of its power than the one ahead.",
    ),
    _claim(
        "flock-height",
        "heights vary from link to link",
        "some variation",
        "%",
        at_least(1.0),
        _height_variation,
        "Range of the links' heights over h_L.",
    ),
    Claim(
        "amplitude-bound",
        "Optimization, bound 4",
        "no follower wants more amplitude than the bird ahead",
        "cannot be optimal",
        "",
        at_most(-1e-6),
        _growth,
        "So it is in the pair. In the flock birds 4 to 6 rest on the bound (`immediate`) or flap further than the bird "
        "ahead once they may (`lone`): a greater h costs more, yet can buy a better balance.",
        needs="flocks",
    ),
)
