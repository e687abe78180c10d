"""What a kind of job is: the contract that `upwash.jobs.pair` and `upwash.jobs.flock` keep.

A kind says all that the rest of the house must know of it: what its own table in a sweep file may hold, how it is
solved, in which file and columns its rows are kept, what they come to, and what must hold of them. Another kind is a
module beside those two, and a line in `upwash.jobs.kinds`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.checked import Rule
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.jobs.bird import NoBird, wavelength_ratio
from upwash.jobs.stored import Complaints
from upwash.optimum.solvable import need_solvable

if TYPE_CHECKING:
    from upwash.aero.bird import Bird
    from upwash.jobs.job import Job
    from upwash.optimum.problem import PairProblem
    from upwash.optimum.proof import Proof

Answer = tuple[str, str, Sequence[of.Row]]
"""What a solver returns: status, what went wrong or "", and rows of the solution's columns."""


class Kind(ABC):
    """What a job asks for; the class says what is true of all jobs of the kind, an object holds one job's own inputs.

    Attributes
    ----------
    name : str
        By which sweeps, plans and rows know it, and the name of its own table in a sweep file.
    file : str
        The file that gathers its rows.
    rows, summary : Schema
        Of its rows, and of its summary, which has one row a job.
    is_one_problem : bool
        Whether a job's rows are the optima of one problem, with one proof; else each row is a problem of its own.
    choices : dict
        Key of its own table -> what it must be: one of some words, or what a rule says.
    usual : dict
        Key of its own table -> what it is if nothing else is said.
    companions : tuple of str
        Keys of its own table that name birds.
    parts : tuple of str
        Parts of the wake's model that may stand in its own table, too.
    later : dict
        Input that came later than the first ids -> the value that is left out of an id, so that no old one changes.
    """

    name: ClassVar[str]
    file: ClassVar[str]
    rows: ClassVar[pa.Schema]
    summary: ClassVar[pa.Schema]
    is_one_problem: ClassVar[bool]
    choices: ClassVar[Mapping[str, Rule | tuple[str, ...]]] = {}
    usual: ClassVar[Mapping[str, Any]] = {}
    companions: ClassVar[tuple[str, ...]] = ()
    parts: ClassVar[tuple[str, ...]] = ()
    later: ClassVar[of.Row] = {}

    phase_lock: bool = True
    """Whether followers beat in step with the birds ahead."""

    # Its own inputs

    @classmethod
    @abstractmethod
    def from_inputs(cls, given: Mapping[str, Any]) -> Self:
        """Return the kind with one job's own inputs, given by column; what is absent is as usual.

        Raises
        ------
        ValueError
            If one is out of range.
        """

    @abstractmethod
    def inputs(self) -> of.Row:
        """Return its own inputs by column."""

    def need_solvable(self, model: WakeModel) -> None:
        """Refuse a model of the wake in which no optimum can be searched and proved.

        Raises
        ------
        ValueError
            If it is one; the message names the input.
        """
        need_solvable(model)

    def wavelength_ratio(self, bird: Bird | NoBird) -> float:
        """Return the greatest wavelength over semispan of the birds that are followed, given the job's bird."""
        return wavelength_ratio(bird)

    def ahead_of(self, bird: Bird) -> Bird:
        """Return the bird that a job's own bird follows; one like it if nothing else is said."""
        return bird

    # Solving

    @abstractmethod
    def solve(self, job: Job, bird: Bird) -> Answer:
        """Solve a job of this kind, whose inputs make a bird."""

    # Files

    @classmethod
    def summary_schema(cls, rows: pa.Schema) -> pa.Schema:
        """Return the schema of the summary of rows, which may have columns of a solver's own."""
        return cls.summary

    @classmethod
    def summarise(cls, rows: pa.Table) -> pa.Table:
        """Return one row for each job, in their order, given all rows of some jobs, in order."""
        if not rows.num_rows:
            return cls.summary_schema(rows.schema).empty_table()
        codes = rows.column("job_id").combine_chunks().dictionary_encode().indices.to_numpy()
        return cls._summary(rows, np.flatnonzero(np.diff(codes, prepend=-1)))

    @classmethod
    @abstractmethod
    def _summary(cls, rows: pa.Table, starts: NDArray[np.intp]) -> pa.Table:
        """Return one row for each job, given where each job's rows begin."""

    # What must hold of stored rows

    @abstractmethod
    def problems(self, job: Job, bird: Bird, rows: Sequence[of.Stored]) -> list[Sequence[PairProblem]]:
        """Pose the problem of each row again, in one piece of phase or several; none for a bird that leads."""

    def kind_of(self, bird: Bird, row: of.Stored) -> Bird:
        """Return the bird of a row as it flies alone, given the job's."""
        return bird

    @abstractmethod
    def felt(
        self, bird: Bird, row: of.Stored, rows: Sequence[of.Stored]
    ) -> Iterator[tuple[Stroke, Pose, Bird]]:
        """Give of each bird whose wake a row's bird feels stroke, relative pose and bird, that which it follows first.

        `bird` is the job's.
        """

    @abstractmethod
    def bounds(self, bird: Bird, row: of.Stored) -> dict[str, tuple[float, float]]:
        """Return the bounds of a solved row's variables, by column; `bird` is the job's."""

    @abstractmethod
    def why_none(self, row: of.Stored, proof: Proof) -> str:
        """Return what the error of a row must say by the proof that nobody is there."""

    @abstractmethod
    def whole(self, job: Job, rows: Sequence[of.Stored]) -> Complaints:
        """Give what does not hold of all rows of a job together."""
