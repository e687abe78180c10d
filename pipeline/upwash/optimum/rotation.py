"""Taking turns: what a bird saves, and how much further it gets, when a flock rotates the lead.

A flock flies as far as its most burdened bird, and that is the first: it saves nothing, so a flock that never
changes its order gets no further than a lone bird.  If its birds change places often and evenly, each spends
the mean power of all places.  On a given store of energy and at the same speed, range goes with 1/power.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Turns:
    """A flock of one size that takes turns.

    Attributes
    ----------
    birds : int
        Its size.
    saving_mean : float
        Share of a lone bird's power that each bird saves.
    range_gained : float
        How much further each bird gets than alone, as a share of the range alone.
    """

    birds: int
    saving_mean: float
    range_gained: float


def take_turns(savings: Sequence[float]) -> list[Turns]:
    """Return what taking turns brings to a flock, and to each smaller one: its first birds.

    Parameters
    ----------
    savings : sequence of float
        Share of a lone bird's power that is saved in each place, from the first, where it is 0.

    Returns
    -------
    list of Turns
        From two birds up to all.
    """
    means = [sum(savings[:birds]) / birds for birds in range(2, len(savings) + 1)]
    return [Turns(birds, mean, 1.0 / (1.0 - mean) - 1.0) for birds, mean in enumerate(means, start=2)]
