"""Running one job: inputs in, rows out. Never raises: what goes wrong is a row.

The only module of the batch layer that meets the physics and the inputs.
"""

from __future__ import annotations

import os
import threading
import time
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from pipeline.batch import columns as of
from pipeline.batch import store
from pipeline.sweep.job import BUILT_IN_SOLVER, INPUTS
from pipeline.sweep.job import Job as Job

Row = dict[str, Any]

# A worker whose parent is gone has nobody to give its results to; it looks this often.
PARENT_CHECK_S = 0.5


@dataclass(frozen=True)
class Result:
    """What came of one job, ready to be written.

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
    data : bytes
        The job's Parquet file.
    """

    job_id: str
    status: str
    error: str
    seconds: float
    data: bytes


def run_job(job: Job) -> list[Row]:
    """Solve a job and return its rows: one an optimum, or one a bird of a flock; at least one in any case."""
    try:
        status, error, rows = solver_of(job)(job)
        rows = [{"status": status, "error": error or None} | row for row in rows or [{}]]
    except (Exception, SystemExit) as error:
        rows = [{"status": of.FAILED, "error": describe(error)}]
    return [inputs_of(job) | row for row in rows]


def inputs_of(job: Job) -> Row:
    """Return the columns that say which job a row is of."""
    row = {"job_id": job.job_id} | {name: value for name, value in job.inputs().items() if value is not None}
    return row | {"flock_id": job.job_id} if job.kind == "flock" else row


def failed_rows(job: Job, error: str) -> list[Row]:
    """Return the row of a job that could not be run."""
    return [inputs_of(job) | {"status": of.FAILED, "error": error}]


def encode(job: Job, rows: list[Row], seconds: float, sweep_text: str) -> Result:
    """Make a job's file of its rows; rows that do not fit the schema are a failure of the job."""
    schema, metadata = store.ROWS[job.kind], store.provenance(sweep_text)
    try:
        data = store.encode(rows, schema, metadata)
    except (ValueError, TypeError, OverflowError) as error:
        rows = failed_rows(job, describe(error))
        data = store.encode(rows, schema, metadata)
    worst = max(rows, key=lambda row: of.STATUSES.index(row["status"]))
    return Result(job.job_id, worst["status"], worst["error"] or "", seconds, data)


def run_batch(
    jobs: Sequence[Job], sweep_text: str, budget_s: float, parent: int | None
) -> tuple[list[Result], list[Job]]:
    """Run jobs one after another until the time is up, in a worker.

    Parameters
    ----------
    jobs : sequence of Job
        At least one; the first is always run.
    sweep_text : str
        The sweep's own text, for the files' metadata.
    budget_s : float
        Time after which no further job is begun, in s.
    parent : int or None
        Process that this one must not outlive, if it is a child of it.

    Returns
    -------
    tuple
        Results of the jobs that were run, and the jobs that were not.
    """
    if parent is not None:
        _die_with(parent)
    results: list[Result] = []
    start = time.perf_counter()
    for number, job in enumerate(jobs):
        begun = time.perf_counter()
        if number and begun - start > budget_s:
            return results, list(jobs[number:])
        rows = run_job(job)
        results.append(encode(job, rows, time.perf_counter() - begun, sweep_text))
    return results, []


def solver_of(job: Job) -> Callable[[Job], tuple[str, str, list[Row]]]:
    """Return the function that solves a job: Job -> (status, error or "", rows of the solution's columns).

    No row means that there is no answer, which `status` and `error` then explain.
    """
    if job.solver == BUILT_IN_SOLVER:
        return _solve_pair if job.kind == "pair" else _solve_flock
    module, _, function = job.solver.partition(":")
    return getattr(import_module(module), function)


def job_of(row: Mapping[str, Any]) -> Job:
    """Return the job that a stored row came from, made of its inputs alone."""
    return Job(**{name: row[name] for name in INPUTS if row.get(name) is not None})


def describe(error: BaseException) -> str:
    """Say on one line what was raised and where."""
    last = traceback.extract_tb(error.__traceback__)[-1:]
    where = f" ({Path(last[0].filename).name}, line {last[0].lineno})" if last else ""
    return f"{type(error).__name__}: {' '.join(str(error).split())}{where}"


def _solve_pair(job: Job) -> tuple[str, str, list[Row]]:
    from pipeline.optimum import solve_pair

    bird = _bird(job)
    if isinstance(bird, str):
        return of.INFEASIBLE, bird, []
    solution = solve_pair(bird, job.objective, model=_model(job), seed=job.seed, tolerance=job.tolerance)
    error = "" if solution.status == of.SOLVED else "no position balances lift and thrust within the bounds"
    return solution.status, error, solution.rows()


def _solve_flock(job: Job) -> tuple[str, str, list[Row]]:
    from pipeline.optimum import solve_flock

    bird = _bird(job)
    if isinstance(bird, str):
        return of.INFEASIBLE, bird, []
    solution = solve_flock(
        bird,
        job.birds,
        job.objective,
        reading=job.reading,
        shape=job.shape,
        wake=job.wake,
        seed=job.seed,
        tolerance=job.tolerance,
    )
    return of.SOLVED, "", solution.rows()


def _bird(job: Job) -> Any:
    """Return the job's bird, or the line that says why there is no such bird."""
    from pipeline.aero.bird import Bird

    try:
        return Bird(
            mass_kg=job.mass_kg,
            semispan_m=job.semispan_m,
            speed_m_s=job.speed_m_s,
            period_s=job.period_s,
            density_kg_m3=job.density_kg_m3,
            gravity_m_s2=job.gravity_m_s2,
            amplitude_m=job.leader_amplitude_m,
            upstroke_span_ratio=job.leader_upstroke_span_ratio,
            circulation_ratio=job.circulation_ratio,
        )
    except ValueError as error:
        return str(error)


def _model(job: Job) -> Any:
    from pipeline.aero.wake import WakeModel

    return WakeModel(
        core_radius_ratio=job.core_radius_ratio, stroke_states=job.stroke_states, span_nodes=job.span_nodes
    )


_watching = False


def _die_with(parent: int) -> None:
    """End this process soon after its parent has ended, however that came about."""
    global _watching
    if _watching:
        return
    _watching = True

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()
