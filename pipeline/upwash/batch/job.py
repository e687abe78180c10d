"""Running one job: inputs in, rows out. Never raises: what goes wrong is a row.

The only module of the batch layer that meets the physics and the inputs.
"""

from __future__ import annotations

import errno
import math
import time
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.aero.pose import Pose, Stroke
from upwash.batch import store
from upwash.errors import EnvironmentFault, UpwashError, environment_fault
from upwash.sweep.job import BUILT_IN_SOLVER, NoBird
from upwash.sweep.job import Job as Job
from upwash.sweep.solver import BrokenContract, kept_to_contract, make_importable, own_columns, own_solver

if TYPE_CHECKING:
    from upwash.optimum.flock_solution import FlockSolution

Row = dict[str, Any]
Answer = tuple[str, str, Sequence[Mapping[str, Any]]]
"""What a solver returns: status, what went wrong or "", and rows of the solution's columns."""

UNFIT = f"{BrokenContract.__name__}: "
"""How the error begins of a job whose solver returned what cannot be stored."""

# What the system says when it is at fault. A solver of the user's own may look for a file of one job, or import what
# it lacks; the built-in one does neither, so that whatever the system refuses it is the machine's fault.
MACHINES = {
    getattr(errno, name)
    for name in ("EDQUOT", "EFBIG", "EIO", "EMFILE", "ENFILE", "ENOMEM", "ENOSPC", "EROFS", "ESTALE")
    if hasattr(errno, name)
}

MANY = 50
"""So many jobs done in one batch are stored in one file, and not each in its own."""


NO_BALANCE = "no balance: no position within the bounds balances lift and thrust"
"""Why a pair is infeasible whose bird can be."""


@dataclass(frozen=True)
class Result:
    """How one job ended.

    Parameters
    ----------
    job_id : str
        The job.
    status : str
        The worst status of its rows.
    error : str
        What went wrong, or "".
    seconds : float
        Wall time.
    is_unfit : bool
        Whether it failed since its solver returned what cannot be stored.
    """

    job_id: str
    status: str
    error: str
    seconds: float
    is_unfit: bool = False


@dataclass(frozen=True)
class Bundle:
    """What came of one job, or of several that are stored together, ready to be written.

    Parameters
    ----------
    results : list of Result
        How each of them ended.
    data : bytes
        The Parquet file of their rows, sorted by job.
    """

    results: list[Result]
    data: bytes


def run_job(job: Job) -> list[Row]:
    """Solve a job and return its rows, as `solve` does; what goes wrong is a row too.

    Raises
    ------
    EnvironmentFault
        If the machine is at fault and not the job: the job is as good as not begun.
    """
    try:
        return solve(job)
    except EnvironmentFault:
        raise
    except (OSError, ImportError) as error:
        if job.solver != BUILT_IN_SOLVER and not (isinstance(error, OSError) and error.errno in MACHINES):
            return failed_rows(job, describe(error))
        raise environment_fault(error) from error
    except (Exception, SystemExit) as error:
        return failed_rows(job, describe(error))


def solve(job: Job) -> list[Row]:
    """Solve a job and return its rows: one an optimum, or one a bird of a flock; at least one in any case."""
    status, error, rows = kept_to_contract(solver_of(job)(job))
    rows = [{"status": status, "error": error or None} | row for row in rows or [{}]]
    return [inputs_of(job) | {name: _finite(value) for name, value in row.items()} for row in rows]


def _finite(value: Any) -> Any:
    """Return a value, or None for a number that is not finite; an infinite bound says: nothing there."""
    return None if isinstance(value, float) and not math.isfinite(value) else value


def inputs_of(job: Job) -> Row:
    """Return the columns that say which job a row is of."""
    inputs = of.kept(job.inputs()).items()
    row = {"job_id": job.job_id} | {name: value for name, value in inputs if value is not None}
    return row | {"flock_id": job.job_id} if job.kind == "flock" else row


def failed_rows(job: Job, error: str) -> list[Row]:
    """Return the row of a job that could not be run."""
    return [inputs_of(job) | {"status": of.FAILED, "error": error}]


def encode(solved: Sequence[tuple[Job, list[Row], float]], sweep_text: str) -> Bundle:
    """Make one file of jobs, each with its rows and its wall time in s.

    Rows that do not fit the schema are a failure of their job.
    """
    schema, metadata = schema_of(solved[0][0]), store.provenance(sweep_text)
    options = store.JOB_FILE_OPTIONS if len(solved) == 1 else store.TABLE_OPTIONS
    try:
        data = store.encode(_sorted_rows(solved), schema, metadata, options)
    except (ValueError, TypeError, OverflowError):
        solved = [(job, _fitting(job, rows, schema), seconds) for job, rows, seconds in solved]
        data = store.encode(_sorted_rows(solved), schema, metadata, options)
    return Bundle([_result(*one) for one in solved], data)


def schema_of(job: Job) -> Any:
    """Return the schema of a job's rows: that of its kind and, of a solver that is not ours, its own columns."""
    if job.solver == BUILT_IN_SOLVER:
        return store.ROWS[job.kind]
    try:
        return store.rows_schema(job.kind, own_columns(own_solver(job.solver)))
    except UpwashError:
        # Then the job has failed, which needs none of them.
        return store.ROWS[job.kind]


def _sorted_rows(solved: Sequence[tuple[Job, list[Row], float]]) -> list[Row]:
    return [row for _, rows, _ in sorted(solved, key=lambda one: one[0].job_id) for row in rows]


def _fitting(job: Job, rows: list[Row], schema: Any) -> list[Row]:
    try:
        store.table_of(rows, schema)
    except (ValueError, TypeError, OverflowError) as error:
        return failed_rows(job, f"{UNFIT}{describe(error)}")
    return rows


def _result(job: Job, rows: list[Row], seconds: float) -> Result:
    worst = max(rows, key=lambda row: of.STATUSES.index(row["status"]))
    error = worst["error"] or ""
    return Result(job.job_id, worst["status"], error, seconds, error.startswith(UNFIT))


def run_batch(
    jobs: Sequence[Job], sweep_text: str, budget_s: float, place: str | None = None
) -> tuple[list[Bundle], list[Job]]:
    """Run jobs one after another until the time is up, in a worker.

    Parameters
    ----------
    jobs : sequence of Job
        At least one; the first is always run.
    sweep_text : str
        The sweep's own text, for the files' metadata.
    budget_s : float
        Time after which no further job is begun, in s.
    place : str or None
        Folder in which a solver of the user's own may lie, if not here.

    Returns
    -------
    tuple
        The jobs that were run, one in a bundle, or all in one if they are many; and the jobs that were not.

    Raises
    ------
    EnvironmentFault
        If the machine was at fault at the first job. At a later one, what was finished before it is returned.
    """
    if place is not None:
        make_importable(place)
    solved: list[tuple[Job, list[Row], float]] = []
    start = time.perf_counter()
    for job in jobs:
        begun = time.perf_counter()
        if solved and begun - start > budget_s:
            break
        try:
            rows = run_job(job)
        except EnvironmentFault:
            if not solved:
                raise
            break
        solved.append((job, rows, time.perf_counter() - begun))
    # A file of its own takes longer than so cheap a job.
    bundles = [solved] if len(solved) >= MANY else [[one] for one in solved]
    return [encode(bundle, sweep_text) for bundle in bundles], list(jobs[len(solved) :])


def solver_of(job: Job) -> Callable[[Job], Answer]:
    """Return the function that solves a job.

    No row means that there is no answer, which `status` and `error` then explain.
    """
    if job.solver == BUILT_IN_SOLVER:
        return _solve_flock if job.flock else _solve_pair
    try:
        own = own_solver(job.solver)
        return lambda job: own(by_columns(job))
    except UpwashError as error:
        raise BrokenContract(str(error)) from error


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
    from upwash.optimum.certify import clear_boxes
    from upwash.optimum.search import solve_many

    return "" if is_kept(solve_many) and is_kept(clear_boxes) else COMPILING


def job_of(row: Mapping[str, Any]) -> Job:
    """Return the job that a stored row came from, made of its inputs alone.

    Raises
    ------
    UpwashError
        If they are no inputs of a job.
    """
    try:
        return Job.of(row)
    except (ValueError, KeyError, TypeError) as error:
        found = " ".join(str(error).split())
        raise UpwashError(
            f"job {row.get('job_id')}: expected a job's inputs, found {found}; run it again"
        ) from error


def describe(error: BaseException) -> str:
    """Say on one line what was raised and where."""
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = f" ({Path(last[0].filename).name}, line {last[0].lineno})" if last else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{where}"


def _solve_pair(job: Job) -> Answer:
    from upwash.optimum.pair import solve_pair

    if isinstance(job.bird, NoBird):
        return of.INFEASIBLE, job.bird.why, []
    solution = solve_pair(
        job.bird, job.objective, model=job.model, search=job.search, distance_m=job.distance_m
    )
    if solution.status == of.SOLVED:
        return of.SOLVED, "", solution.rows()
    return solution.status, NO_BALANCE, [solution.of_the_job()]


def _solve_flock(job: Job) -> Answer:
    if isinstance(job.bird, NoBird):
        return of.INFEASIBLE, job.bird.why, []
    return of.SOLVED, "", flock_of(job).rows()


def flock_of(job: Job) -> FlockSolution:
    """Return the flock of a job that is one, of inputs that make a bird."""
    from upwash.optimum.flock import solve_flock

    if isinstance(job.bird, NoBird) or job.flock is None:
        raise ValueError(f"expected the job of a flock, found {job}")
    return solve_flock(
        job.bird,
        job.flock.birds,
        job.objective,
        rules=job.flock.rules,
        model=job.model,
        search=job.search,
        distance_m=job.distance_m,
    )


# What a stored row must be, from its inputs and its solution alone: by the plain statement of the physics,
# not by the compiled one that the search used.


def recompute(rows: Sequence[Row]) -> list[Row]:
    """Return what the forces, powers, savings, costs and labels of one job's solved rows must be.

    Parameters
    ----------
    rows : sequence of dict
        All rows of a pair, or of a flock.

    Returns
    -------
    list of dict
        For each row, column -> value; nothing for a row that has no solution.
    """
    job = job_of(rows[0])
    return [_expected(job, row, rows) if row["status"] == of.SOLVED else {} for row in rows]


def bounds_of(row: Row) -> dict[str, tuple[float, float]]:
    """Return the bounds of a solved row's variables."""
    from upwash.optimum import problem
    from upwash.optimum.endless.problem import DISTANCE

    streamwise = problem.STREAMWISE_REACH * row["speed_m_s"] * row["period_s"]
    spanwise = problem.SPANWISE_REACH * row["semispan_m"]
    alone = row["leader_amplitude_m"]
    ahead = row["ahead_amplitude_m"] if row["kind"] == "flock" else alone
    limit = alone if row.get("reading") == "lone" else ahead
    x = (0.0, streamwise)
    if row["wavelengths"] == math.inf:
        # It is the distance asked for.
        x = (row["distance_m"] or DISTANCE * (row["speed_m_s"] * row["period_s"]),) * 2
    return {
        "x_m": x,
        # A flock's birds may fly on either side of the one ahead.
        "y_m": (-spanwise if row["kind"] == "flock" else 0.0, spanwise),
        "z_m": (-ahead, ahead),
        "amplitude_m": (problem.LEAST_AMPLITUDE * limit, limit),
        "upstroke_span_ratio": problem.SPAN_RATIO_BOUNDS,
        "phase": (0.0, 1.0),
    }


def _expected(job: Job, row: Row, rows: Sequence[Row]) -> Row:
    from upwash.optimum.record import record

    if isinstance(job.bird, NoBird):
        raise ValueError(f"{job.bird.why}: no bird")
    ahead = pose = None
    felt = list(_felt(job, row, rows))
    if felt:
        ahead, pose = felt.pop(0)
    found = vars(record(job.bird, job.objective, ahead, pose, job.model, felt))
    return {name: value for name, value in found.items() if value is not None}


def _felt(job: Job, row: Row, rows: Sequence[Row]) -> Iterator[tuple[Stroke, Pose]]:
    """Give the stroke of each bird whose wake a row's bird feels, that which it follows first, and the pose to it."""

    def stroke(one: Row) -> Stroke:
        return Stroke(one["amplitude_m"], one["upstroke_span_ratio"])

    def in_flock(one: Row) -> Pose:
        return Pose(one["x_flock_m"], one["y_flock_m"], one["z_flock_m"], stroke(one), one["phase_flock"])

    if row.get("bird") == 1:
        return
    bird = "ahead" if job.flock else "leader"
    ahead = Stroke(row[f"{bird}_amplitude_m"], row[f"{bird}_upstroke_span_ratio"])
    yield ahead, Pose(row["x_m"], row["y_m"], row["z_m"], stroke(row), row["phase"])
    if job.flock:
        for number in job.flock.rules.felt_by(row["bird"])[:-1]:
            other = rows[number - 1]
            yield stroke(other), in_flock(row).relative_to(in_flock(other))
