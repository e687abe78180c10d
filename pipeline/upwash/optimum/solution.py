"""What a search returns: optima in SI units with their forces, powers, savings, labels and evidence."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

from upwash.aero.pose import Pose
from upwash.columns import Row
from upwash.optimum.evidence import Evidence, StatedEvidence
from upwash.optimum.means import stated
from upwash.optimum.problem import PairProblem
from upwash.optimum.proof import Proof
from upwash.optimum.record import Record, record

if TYPE_CHECKING:
    import pandas as pd

    from upwash.optimum.search import Basin


@dataclass(frozen=True)
class Optimum(Record, StatedEvidence):
    """One local optimum: its pose, what follows from it, what holds there, and what the search says of it.

    But for the pose the fields are the columns of the results of the same names.
    """

    pose: Pose
    rank: int
    hits: int
    starts: int
    is_v_optimum: bool
    is_global_optimum: bool

    def columns(self) -> Row:
        """Return the fields that are columns of the results."""
        return {entry.name: getattr(self, entry.name) for entry in fields(self) if entry.name != "pose"}


@dataclass(frozen=True)
class PairSolution:
    """All optima of one follower, best first, and the proof.

    Attributes
    ----------
    status : str
        ``solved``, or ``infeasible`` when no follower within the bounds can balance.
    optima : tuple of Optimum
        Best first.
    proof : Proof
        What was shown of the best.
    solve_time_s : float
        Wall time, in s.
    """

    status: str
    optima: tuple[Optimum, ...]
    proof: Proof
    solve_time_s: float

    @property
    def global_optimum(self) -> Optimum | None:
        """The best optimum of all, if there is one."""
        return self.optima[0] if self.optima else None

    @property
    def v_optimum(self) -> Optimum | None:
        """The best optimum that is outboard, level and astern, if there is one."""
        return next((optimum for optimum in self.optima if optimum.is_v_optimum), None)

    def rows(self) -> list[Row]:
        """Return one dictionary per optimum, by the columns of the results."""
        return [optimum.columns() | self.of_the_job() for optimum in self.optima]

    def of_the_job(self) -> Row:
        """Return what is the same in every row: the proof and the time, by the columns of the results."""
        return self.proof.columns() | {"solve_time_s": self.solve_time_s}

    def frame(self) -> pd.DataFrame:
        """Return the rows as a pandas DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.rows())


def record_in(problem: PairProblem, pose: Pose) -> Record:
    """Return what follows from a pose in a problem."""
    return record(
        problem.bird,
        problem.objective,
        problem.ahead,
        pose,
        problem.model,
        problem.others(pose),
        leader=problem.leader,
        phase_lock=problem.phase_lock,
    )


def describe_optimum(
    problem: PairProblem,
    basin: Basin,
    evidence: Evidence,
    felt: Any,
    *,
    rank: int,
    starts: int,
    is_v_optimum: bool,
) -> Optimum:
    """Turn a basin into an optimum in SI units.

    Parameters
    ----------
    problem : PairProblem
        The problem.
    basin : Basin
        The local optimum in scaled variables.
    evidence : Evidence
        What holds there.
    felt : NamedTuple
        Its wake and core edges.
    rank, starts : int
        Its place among the optima of the job; starts of the search.
    is_v_optimum : bool
        Whether it is the best of those in a V.
    """
    pose = problem.pose(basin.point)
    found = record_in(problem, pose)
    return Optimum(
        **vars(found),
        pose=pose,
        rank=rank,
        hits=basin.hits,
        starts=starts,
        is_v_optimum=is_v_optimum,
        is_global_optimum=rank == 0,
        **vars(stated(problem, felt, evidence)),
    )
