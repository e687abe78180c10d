"""How far a sweep has come: counts, rate, time left, failures by cause."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import dataclass

from upwash import columns as of
from upwash.batch.folder import ResultsFolder
from upwash.batch.index import Known, read_index
from upwash.batch.journal import Journals, read_journals

RECENT_S = 600.0
"""The rate is that of so long."""


@dataclass(frozen=True)
class Status:
    """How far a sweep has come.

    Parameters
    ----------
    results, sweep : str
        The folder, and the name of its sweep.
    jobs, solved, infeasible, failed, left : int
        Jobs of the sweep, in all and by how they ended.
    others : int
        Results in the folder that the sweep does not name.
    is_running : bool
        Whether someone is working on it.
    jobs_per_s, seconds_left : float or None
        Rate of the present run, and what it has still to go, if it is running and has done something.
    causes : dict
        What kept jobs from being solved -> how many of them.
    """

    results: str
    sweep: str
    jobs: int
    solved: int
    infeasible: int
    failed: int
    left: int
    others: int
    is_running: bool
    jobs_per_s: float | None
    seconds_left: float | None
    causes: dict[str, int]


def status_of(folder: ResultsFolder) -> Status:
    """Return how far the sweep of a results folder has come.

    Raises
    ------
    UpwashError
        If the folder holds no results.
    """
    folder.require()
    known = read_index(folder)
    plan = folder.plan()
    ids = plan.jobs if plan else list(known)
    ended = [known[job_id] for job_id in ids if job_id in known]
    counts = Counter(one.status for one in ended)
    left = len(ids) - len(ended)
    is_running = folder.in_use()
    rate = _rate(read_journals(folder)) if is_running else None
    return Status(
        results=str(folder),
        sweep=plan.sweep if plan else "",
        jobs=len(ids),
        solved=counts[of.SOLVED],
        infeasible=counts[of.INFEASIBLE],
        failed=counts[of.FAILED],
        left=left,
        others=len(known.keys() - set(ids)),
        is_running=is_running,
        jobs_per_s=rate,
        seconds_left=left / rate if rate else None,
        causes=dict(Counter(_cause(one) for one in ended if one.status != of.SOLVED).most_common()),
    )


def _cause(known: Known) -> str:
    """Return what kept a job from being solved; that there is no answer is told apart from a failure."""
    return known.cause if known.status == of.FAILED else f"{known.status}: {known.cause}"


def _rate(journals: Journals) -> float | None:
    """Return the jobs a second of the present run, of late."""
    now, begun = time.time(), max(journals.begun, default=0.0)
    since = max(begun, now - RECENT_S)
    recent = [entry for entry in journals.done if entry.time >= since]
    if not recent:
        since = begun
        recent = [entry for entry in journals.done if entry.time >= since]
    jobs = sum(entry.jobs for entry in recent)
    return jobs / max(now - since, 1e-3) if jobs else None
