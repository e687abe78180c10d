"""What a flock is once it is solved: where and how each bird flies, and what it spends."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from upwash.aero.bird import Bird
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.columns import Row
from upwash.optimum.core_edge import other_side
from upwash.optimum.flock_wake import Place
from upwash.optimum.proof import Proof
from upwash.optimum.record import record
from upwash.optimum.settings import FlockRules
from upwash.optimum.solution import Optimum

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Member:
    """One bird of a flock.

    Attributes
    ----------
    number, leader : int
        Its number, 1 the first, and that of the bird it follows, 0 for none.
    place : Place or None
        Where and how it flies; None if there is nowhere.
    optimum : Optimum or None
        Its V optimum, relative to the bird it follows; None for the first bird, and where there is none.
    proof : Proof or None
        What was shown of its problem; None for the first bird.
    solve_time_s : float
        Wall time of its solution, in s.
    error : str
        Why it has no place, or "".
    """

    number: int
    leader: int
    place: Place | None
    optimum: Optimum | None = None
    proof: Proof | None = None
    solve_time_s: float = 0.0
    error: str = ""


@dataclass(frozen=True)
class FlockSolution:
    """A flock, bird by bird from the front.

    Attributes
    ----------
    kinds : tuple of Bird
        The birds as they fly alone, those without a place included.
    objective : str
        What was least for each bird.
    rules : FlockRules
        How the flock is built.
    model : WakeModel
        Resolution of the wakes.
    members : tuple of Member
        The birds, the first one included.  If there is no place for one, it is the last.
    phase_lock : bool
        Whether all beat in step.
    """

    kinds: tuple[Bird, ...]
    objective: str
    rules: FlockRules
    model: WakeModel
    members: tuple[Member, ...]
    phase_lock: bool = True

    @property
    def bird(self) -> Bird:
        """The first bird."""
        return self.kinds[0]

    @property
    def placed(self) -> tuple[Member, ...]:
        """The birds that have a place."""
        return tuple(one for one in self.members if one.place is not None)

    def total_cost(self) -> float:
        """Sum of the costs of the birds that have a place, the first one included."""
        alone = COST_FUNCTIONS[self.objective].value(self.bird, self.bird.weight_n, self.bird.drag_n)
        return alone + sum(one.optimum.cost for one in self.placed if one.optimum)

    def worst_residual(self) -> float:
        """Largest imbalance of any bird, over weight or drag."""
        optima = [one.optimum for one in self.placed if one.optimum]
        return max(
            (abs(value) for one in optima for value in (one.residual_lift, one.residual_thrust)), default=0.0
        )

    def rows(self) -> list[Row]:
        """Return one dictionary per bird, by the columns of the results."""
        return [self._row(one) for one in self.members]

    def frame(self) -> pd.DataFrame:
        """Return the rows as a pandas DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.rows())

    def _row(self, one: Member) -> Row:
        row: Row = {"status": "solved", "error": None, "bird": one.number}
        row["leader"] = one.leader or None
        ahead = self.members[one.leader - 1].place if one.leader else None
        if ahead is not None:
            row["ahead_amplitude_m"] = ahead.pose.stroke.amplitude_m
            row["ahead_upstroke_span_ratio"] = ahead.pose.stroke.span_ratio
        if one.proof is not None:
            row |= one.proof.columns() | {"solve_time_s": one.solve_time_s}
        if one.place is None:
            return row | {"status": "infeasible", "error": one.error}
        row |= {f"{axis}_flock_m": getattr(one.place.pose, f"{axis}_m") for axis in "xyz"}
        row["phase_flock"] = one.place.pose.phase if self.phase_lock else None
        alone = record(self.bird, self.objective, None, None, self.model)
        return row | (one.optimum.columns() if one.optimum else vars(alone))


def on_side(optimum: Optimum, side: float) -> Optimum:
    """Return an optimum to the right of the bird ahead as it is on a side: 1 right, −1 left."""
    if side > 0.0:
        return optimum
    pose = optimum.pose.mirrored()
    return replace(optimum, pose=pose, y_m=pose.y_m, core_edges=other_side(optimum.core_edges))
