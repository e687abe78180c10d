"""Running one job: inputs in, rows out. What goes wrong is a row too."""

from __future__ import annotations

import errno
import math
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pyarrow as pa

from upwash import columns as of
from upwash.errors import EnvironmentFault, UpwashError, environment_fault
from upwash.jobs.bird import NoBird
from upwash.jobs.job import BUILT_IN_SOLVER, Job
from upwash.jobs.kind import Answer
from upwash.jobs.own_solver import BrokenContract, kept_to_contract, own_columns, own_solver
from upwash.jobs.schema import table_of, with_own

# What the system says when it is at fault. A solver of the user's own may look for a file of one job, or import what
# it lacks; the built-in one does neither, so that whatever the system refuses it is the machine's fault.
MACHINES = {
    getattr(errno, name)
    for name in ("EDQUOT", "EFBIG", "EIO", "EMFILE", "ENFILE", "ENOMEM", "ENOSPC", "EROFS", "ESTALE")
    if hasattr(errno, name)
}


@dataclass(frozen=True)
class Ended:
    """How one job ended.

    Parameters
    ----------
    job : Job
        The job.
    rows : list of dict
        What is to be stored of it, at least one row.
    seconds : float
        Wall time, in s.
    is_unfit : bool
        Whether it failed since its solver returned what cannot be stored.
    """

    job: Job
    rows: list[of.Row]
    seconds: float = 0.0
    is_unfit: bool = False

    @property
    def status(self) -> str:
        """The worst status of its rows."""
        return str(self._worst["status"])

    @property
    def error(self) -> str:
        """What went wrong, or ""."""
        return str(self._worst["error"] or "")

    @property
    def _worst(self) -> of.Row:
        return max(self.rows, key=lambda row: of.STATUSES.index(str(row["status"])))

    def fitting(self, schema: pa.Schema) -> Ended:
        """Return the same if the rows fit a schema, and else that they do not, which is a failure of the job."""
        try:
            table_of(self.rows, schema)
        except (ValueError, TypeError, OverflowError) as error:
            why = f"{BrokenContract.__name__}: {describe(error)}"
            return Ended(self.job, failed_rows(self.job, why), self.seconds, is_unfit=True)
        return self


def run_job(job: Job) -> Ended:
    """Solve a job; what goes wrong is a row as well.

    Raises
    ------
    EnvironmentFault
        If the machine is at fault and not the job: the job is as good as not begun.
    """
    begun = time.perf_counter()
    try:
        rows, is_unfit = solve(job), False
    except EnvironmentFault:
        raise
    except (OSError, ImportError) as error:
        if job.solver == BUILT_IN_SOLVER or (isinstance(error, OSError) and error.errno in MACHINES):
            raise environment_fault(error) from error
        rows, is_unfit = failed_rows(job, describe(error)), False
    except (Exception, SystemExit) as error:
        rows, is_unfit = failed_rows(job, describe(error)), isinstance(error, BrokenContract)
    return Ended(job, rows, time.perf_counter() - begun, is_unfit)


def solve(job: Job) -> list[of.Row]:
    """Solve a job and return its rows: one an optimum, or one a bird of a flock; at least one in any case."""
    status, error, rows = kept_to_contract(solver_of(job)(job))
    shared: of.Row = {**inputs_of(job), "status": status, "error": error or None}
    return [shared | {name: _finite(value) for name, value in row.items()} for row in rows or [{}]]


def _finite(value: of.Cell) -> of.Cell:
    """Return a value, or None for a number that is not finite; an infinite bound says: nothing there."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inputs_of(job: Job) -> of.Row:
    """Return the columns that say which job a row is of."""
    inputs = of.kept(job.inputs()).items()
    ids: of.Row = {name: job.job_id for name in IDS if name in job.kind.rows.names}
    return ids | {name: value for name, value in inputs if value is not None}


IDS = ("job_id", "flock_id")
"""Columns that hold a job's id."""


def failed_rows(job: Job, error: str) -> list[of.Row]:
    """Return the row of a job that could not be run."""
    return [inputs_of(job) | {"status": of.FAILED, "error": error}]


def solver_of(job: Job) -> Callable[[Job], Answer]:
    """Return the function that solves a job.

    No row means that there is no answer, which `status` and `error` then explain.
    """
    if job.solver == BUILT_IN_SOLVER:
        return _built_in
    try:
        own = own_solver(job.solver)
        return lambda job: own(by_columns(job))
    except UpwashError as error:
        raise BrokenContract(str(error)) from error


def _built_in(job: Job) -> Answer:
    if isinstance(job.bird, NoBird):
        return of.INFEASIBLE, job.bird.why, []
    return job.kind.solve(job, job.bird)


def schema_of_rows(job: Job) -> pa.Schema:
    """Return the schema of a job's rows: that of its kind and, of a solver that is not ours, its own columns."""
    if job.solver == BUILT_IN_SOLVER:
        return job.kind.rows
    try:
        return with_own(job.kind.rows, own_columns(own_solver(job.solver)))
    except UpwashError:
        # Then the job has failed, which needs none of them.
        return job.kind.rows


def by_columns(job: Job) -> SimpleNamespace:
    """Return a job as a user's own solver is given it: an attribute for its id and for each input column."""
    return SimpleNamespace(job_id=job.job_id, **job.inputs())


def compiling(job: Job) -> str:
    """Return what to tell before this machine compiles the built-in solver, or "" if it has: that takes a while.

    All other kernels are parts of the search's and the proof's, or small.
    """
    if job.solver != BUILT_IN_SOLVER:
        return ""
    from upwash.kernel import COMPILING, is_kept
    from upwash.optimum.compiled.boxes import clear_boxes
    from upwash.optimum.compiled.pair_descent import solve_many

    return "" if is_kept(solve_many) and is_kept(clear_boxes) else COMPILING


def describe(error: BaseException) -> str:
    """Say on one line what was raised and where."""
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = f" ({Path(last[0].filename).name}, line {last[0].lineno})" if last else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{where}"
