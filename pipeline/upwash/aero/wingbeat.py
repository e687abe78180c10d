"""A follower's wingbeat in steps: when each is, how much it counts, and how the wing is held.

Phase ψ is 0 at the end of the upstroke and ½ at the end of the downstroke; the downstroke has 0 < ψ ≤ ½.

A follower that keeps its own beat meets the leader's wake in every phase: each of its steps is then taken at several
lags behind the leader, staggered from step to step, so that together they cover the wavelength closely.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.aero.wake import WakeModel, stroke_height

LAGS = 8
"""Lags at which each step of a bird that keeps its own beat is taken: the mean over all is met to a hundredth."""

_STAGGER = 0.5 * (math.sqrt(5.0) - 1.0)
"""By how much the lags move from one step to the next, in spacings of theirs: golden, so that they never line up."""


@dataclass(frozen=True)
class Steps:
    """The steps of a wingbeat.

    Attributes
    ----------
    phase : (n,) ndarray of float
        Phase ψ, in [0, 1).
    weight : (n,) ndarray of float
        Share of the wingbeat; they sum to 1.
    height : (n,) ndarray of float
        Height of the wingtip over the tip-to-tip amplitude, ½ to −½.
    flexed : (n,) ndarray of float
        How far the wing is flexed as on the upstroke, 0 to 1: the half-span is 1 − flexed + flexed · R, in semispans.
    is_downstroke : (n,) ndarray of bool
        Whether the step belongs to the downstroke.
    lag : (n,) ndarray of float
        By how much more than its place says it lags behind the leader, in wingbeats: 0 where the phase is locked.
    """

    phase: NDArray[np.float64]
    weight: NDArray[np.float64]
    height: NDArray[np.float64]
    flexed: NDArray[np.float64]
    is_downstroke: NDArray[np.bool_]
    lag: NDArray[np.float64]

    @property
    def phase_in_stroke(self) -> NDArray[np.float64]:
        """Phase ψ, in (0, 1]: an upstroke begins at ½ and ends at 1."""
        return np.where(self.phase == 0.0, 1.0, self.phase)

    def circulation(self, circulation_ratio: float) -> NDArray[np.float64]:
        """Return the wing's circulation in each step over that of its downstroke."""
        return 1.0 + (circulation_ratio - 1.0) * self.flexed


def wingbeat_steps(model: WakeModel, phase_lock: bool = True) -> Steps:
    """Return the steps of a model.

    Parameters
    ----------
    model : WakeModel
        Its number of stroke states, its stroke rule and its span law.
    phase_lock : bool
        Whether the follower beats in step with its leader; else each step is there at several lags.

    Returns
    -------
    Steps
        In the order of phase.
    """
    count = model.stroke_states
    if model.stroke_rule == "gauss":
        nodes, weights = np.polynomial.legendre.leggauss(count // 2)
        phase = np.concatenate([0.25 * (nodes + 1.0), 0.25 * (nodes + 3.0)])
        weight = 0.25 * np.concatenate([weights, weights])
    else:
        phase, weight = np.arange(count) / count, np.full(count, 1.0 / count)
    height = np.array([stroke_height(each) for each in phase])
    is_downstroke = (phase > 0.0) & (phase <= 0.5)
    flexed = height + 0.5 if model.span_law == "tip" else np.where(is_downstroke, 0.0, 1.0)
    steps = Steps(phase, weight, height, flexed, is_downstroke, np.zeros(count))
    return steps if phase_lock else _at_all_lags(steps)


def _at_all_lags(steps: Steps) -> Steps:
    """Return each step at several lags, from −¾ to ¼, which share its weight."""
    shift = _STAGGER * np.arange(steps.phase.size) % 1.0
    lag = 0.25 - (np.arange(LAGS) + shift[:, None]) / LAGS
    each = {name: np.repeat(values, LAGS) for name, values in vars(steps).items()}
    return Steps(**each | {"weight": each["weight"] / LAGS, "lag": lag.ravel()})
