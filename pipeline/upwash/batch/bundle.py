"""Jobs in a worker: run one after another, and made files of, ready to be written."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

from upwash import columns as of
from upwash.batch import store
from upwash.errors import EnvironmentFault
from upwash.jobs.job import Job
from upwash.jobs.own_solver import make_importable
from upwash.jobs.run import Ended, run_job, schema_of_rows

MANY = 50
"""So many jobs done in one batch are stored in one file, and not each in its own."""


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


def encode(ended: Sequence[Ended], sweep_text: str) -> Bundle:
    """Make one file of jobs; rows that do not fit the schema are a failure of their job."""
    schema, metadata = schema_of_rows(ended[0].job), store.provenance(sweep_text)
    options = store.JOB_FILE_OPTIONS if len(ended) == 1 else store.TABLE_OPTIONS
    try:
        data = store.encode(_sorted_rows(ended), schema, metadata, options)
    except (ValueError, TypeError, OverflowError):
        ended = [one.fitting(schema) for one in ended]
        data = store.encode(_sorted_rows(ended), schema, metadata, options)
    results = [Result(one.job.job_id, one.status, one.error, one.seconds, one.is_unfit) for one in ended]
    return Bundle(results, data)


def _sorted_rows(ended: Sequence[Ended]) -> list[of.Row]:
    return [row for one in sorted(ended, key=lambda one: one.job.job_id) for row in one.rows]


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
    ended: list[Ended] = []
    start = time.perf_counter()
    for job in jobs:
        if ended and time.perf_counter() - start > budget_s:
            break
        try:
            ended.append(run_job(job))
        except EnvironmentFault:
            if not ended:
                raise
            break
    # A file of its own takes longer than so cheap a job.
    bundles = [ended] if len(ended) >= MANY else [[one] for one in ended]
    return [encode(bundle, sweep_text) for bundle in bundles], list(jobs[len(ended) :])
