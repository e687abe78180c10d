"""How long a job takes, measured: by those done in this folder, or by a few solved on the spot."""

from __future__ import annotations

import random
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from upwash.batch.folder import SUMMARY, ResultsFolder
from upwash.batch.journal import read_journals

if TYPE_CHECKING:
    from upwash.jobs.job import Job

TRIAL_S = 2.0
"""After so long no further job is solved on the spot."""

MOST_TRIALS = 20


@dataclass(frozen=True)
class Estimate:
    """How long a job takes.

    Parameters
    ----------
    seconds : float or None
        Mean time of a job on one worker; None if that is not known.
    by : str
        What it was measured by, or why it was not.
    is_experience : bool
        Whether it was measured by jobs that this folder holds.
    """

    seconds: float | None
    by: str
    is_experience: bool = False


def estimate(jobs: Sequence[Job], folder: ResultsFolder, tell: Callable[[str], None]) -> Estimate:
    """Return how long a job takes.

    Parameters
    ----------
    jobs : sequence of Job
        Those to be done, or some of them.
    folder : ResultsFolder
        Where others may have been done before.
    tell : callable
        Takes a line on what takes a moment.
    """
    if not jobs:
        return Estimate(0.0, "nothing to do")
    seconds, count = _experience(folder)
    if count:
        return Estimate(seconds / count, f"by the {count} done so far", is_experience=True)
    from upwash.jobs.job import BUILT_IN_SOLVER
    from upwash.jobs.run import compiling, run_job

    if jobs[0].solver != BUILT_IN_SOLVER:
        return Estimate(None, "no job of it was done here before")
    if compiling(jobs[0]):
        return Estimate(None, "the search is not compiled on this machine yet; the first run does it")
    tell(f"solving some of the jobs for {TRIAL_S:.0f} s to see how long they take")
    begun, done = time.perf_counter(), 0
    for job in random.Random(0).sample(jobs, min(MOST_TRIALS, len(jobs))):
        run_job(job)
        done += 1
        if time.perf_counter() - begun > TRIAL_S:
            break
    return Estimate((time.perf_counter() - begun) / done, f"by {done} solved just now on this machine")


def _experience(folder: ResultsFolder) -> tuple[float, int]:
    """Return the time that the jobs done in this folder took in all, and their number."""
    if done := read_journals(folder).done:
        return sum(entry.seconds for entry in done), sum(entry.jobs for entry in done)
    summary = folder.path / SUMMARY
    if not summary.exists() or "solve_time_s" not in folder.kind().summary.names:
        return 0.0, 0
    import pyarrow.parquet as pq

    seconds = pq.read_table(summary, columns=["solve_time_s"]).column(0).drop_null().to_pylist()
    return sum(seconds), len(seconds)
