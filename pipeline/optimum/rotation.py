"""Taking turns: what a bird saves, and how much further it gets, when a flock rotates the lead.

A flock flies as far as its most burdened bird, and that is the first: it saves nothing, so a flock that never
changes its order gets no further than a lone bird.  If its birds change places often and evenly, each spends
the mean power of all places.  On a given store of energy and at the same speed, range goes with 1/power.
"""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.optimum.flock_solution import FlockSolution


@dataclass(frozen=True)
class Turns:
    """A flock of one size that takes turns.

    Attributes
    ----------
    birds : int
        Its size.
    saving_total_mean : float
        Share of a lone bird's total power that each bird saves.
    cost_mean : float
        Mean of the cost that was minimised, over a lone bird's.
    range_gained : float
        How much further each bird gets than alone, as a share of the range alone.
    """

    birds: int
    saving_total_mean: float
    cost_mean: float
    range_gained: float


def take_turns(flock: FlockSolution) -> list[Turns]:
    """Return what taking turns brings, for the flock and for each smaller one: its first birds.

    Parameters
    ----------
    flock : FlockSolution
        A flock; a bird that has no place is left out.

    Returns
    -------
    list of Turns
        From two birds up to all.
    """
    found = []
    saving, cost = 0.0, 1.0
    for birds, one in enumerate(flock.placed[1:], start=2):
        assert one.optimum is not None
        saving += one.optimum.saving_total
        cost += one.optimum.cost / one.optimum.cost_leader
        mean = saving / birds
        found.append(Turns(birds, mean, cost / birds, 1.0 / (1.0 - mean) - 1.0))
    return found
