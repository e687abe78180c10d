"""What a run would do, and why, without doing it."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from time import monotonic
from typing import TYPE_CHECKING

from upwash import columns as of
from upwash.batch.estimate import MOST_TRIALS, estimate
from upwash.batch.folder import ResultsFolder, Shard
from upwash.batch.index import Known, read_index
from upwash.batch.listing import inputs_in, label_by
from upwash.batch.progress import duration
from upwash.batch.selection import in_shard, is_to_run

if TYPE_CHECKING:
    from upwash.jobs.job import Job
    from upwash.sweep import Sweep

TELL_EVERY_S = 5.0

FEW_CHANGES = 3
"""A job that differs from an earlier one in more inputs than this is a new one."""

MANY = 2000
"""Earlier results of one bird and objective among which a changed job is looked for."""


@dataclass(frozen=True)
class Foreseen:
    """One job: what it is, whether it would run, and why."""

    job_id: str
    label: str
    runs: bool
    reason: str


@dataclass(frozen=True)
class Foresight:
    """What a run would do.

    Parameters
    ----------
    jobs : int
        How many there are.
    to_run : int
        How many would run.
    seconds : float or None
        How long that would take, if it is known.
    workers : int
        With how many workers.
    judged_by : str
        What the time was measured by, or why it is not known.
    from_experience : bool
        Whether it was measured by jobs of this folder.
    """

    jobs: int
    to_run: int
    seconds: float | None
    workers: int
    judged_by: str
    from_experience: bool

    def words(self) -> str:
        """Return the whole in one line."""
        count = f"{self.to_run} of {self.jobs} jobs would run"
        if self.seconds is None:
            return f"{count}; how long that takes is not known: {self.judged_by}"
        if not self.to_run:
            return count
        seconds = self.seconds * self.workers / self.to_run
        each = f"{seconds:.2g} s" if seconds < 100 else duration(seconds)
        workers = f"{self.workers} worker" + ("s" if self.workers > 1 else "")
        return f"{count}, about {duration(self.seconds)} with {workers} ({each} a job, {self.judged_by})"


def foresee(
    sweep: Sweep,
    folder: ResultsFolder,
    shard: Shard,
    retry_failed: bool,
    workers: int,
    show: Callable[[Foreseen], None],
    tell: Callable[[str], None] = lambda line: None,
) -> Foresight:
    """Say of each job of a sweep whether a run would do it, and why; nothing is written.

    Parameters
    ----------
    sweep : Sweep
        The sweep, whose jobs are made one after another and not kept.
    folder : ResultsFolder
        Where results would go.
    shard : Shard
        The part of the jobs that is looked at.
    retry_failed : bool
        Whether failed jobs would be done again.
    workers : int
        How many would work.
    show : callable
        Takes what is foreseen of each job, in the order of the sweep.
    tell : callable
        Takes a line every few seconds, on what takes a moment.
    """
    known = read_index(folder, verify=True) if folder.path.is_dir() else {}
    earlier = None
    if known:
        named = {job.job_id for job in sweep.stream() if job.job_id in known}
        earlier = _Earlier(folder, known.keys() - named)
    label = label_by(sweep.varied)
    trials = _Trials()
    jobs, told = 0, monotonic()
    for job in sweep.stream():
        if not in_shard(job.job_id, shard):
            continue
        jobs += 1
        runs = is_to_run(known.get(job.job_id), retry_failed)
        if runs:
            trials.offer(job)
        reason = _reason(job, known.get(job.job_id), retry_failed, earlier)
        show(Foreseen(job.job_id, label(job.inputs()), runs, reason))
        if jobs % 1000 == 0 and monotonic() - told > TELL_EVERY_S:
            told = monotonic()
            tell(f"{jobs} jobs listed")
    each = estimate(trials.jobs, folder, tell)
    seconds = None if each.seconds is None else trials.offered * each.seconds / workers
    return Foresight(jobs, trials.offered, seconds, workers, each.by, each.is_experience)


class _Trials:
    """A few of the jobs that would run, each as likely as any other, to be solved for an estimate."""

    def __init__(self) -> None:
        self.jobs: list[Job] = []
        self.offered = 0
        self._random = random.Random(0)

    def offer(self, job: Job) -> None:
        """Take one more job, perhaps in the place of another."""
        self.offered += 1
        if len(self.jobs) < MOST_TRIALS:
            self.jobs.append(job)
        elif (place := self._random.randrange(self.offered)) < MOST_TRIALS:
            self.jobs[place] = job


def _reason(job: Job, known: Known | None, retry_failed: bool, earlier: _Earlier | None) -> str:
    if known is None:
        return (earlier and earlier.change_to(job)) or "new"
    if known.status == of.FAILED:
        return f"failed before: {known.cause}" + ("" if retry_failed else "; --retry-failed does it again")
    return f"done: {known.status}"


class _Earlier:
    """Results that the sweep no longer names: what a job may have changed from."""

    def __init__(self, folder: ResultsFolder, job_ids: Iterable[str]) -> None:
        self.rows: dict[tuple[str, str], list[of.Stored]] = {}
        for row in inputs_in(folder, set(job_ids)):
            self.rows.setdefault((row["species"], row["objective"]), []).append(row)

    def change_to(self, job: Job) -> str:
        """Say what is different from the nearest earlier job, or "" if none is near."""
        inputs = job.inputs()
        near: list[str] | None = None
        for row in self.rows.get((job.species, job.objective), [])[:MANY]:
            changed = [
                f"{name} {row[name]} -> {value}" for name, value in inputs.items() if row.get(name) != value
            ]
            if near is None or len(changed) < len(near):
                near = changed
        if near is None or len(near) > FEW_CHANGES:
            return ""
        return "changed: " + (", ".join(near) or "the model's version")
