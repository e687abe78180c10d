"""What a run would do, and why, without doing it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.batch.estimate import estimate
from upwash.batch.folder import ResultsFolder, Shard
from upwash.batch.index import Known, read_index
from upwash.batch.listing import inputs_in, labels
from upwash.batch.progress import duration
from upwash.batch.selection import in_shard, is_to_run

if TYPE_CHECKING:
    from upwash.batch.job import Job

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
    jobs : list of Foreseen
        In the order of the sweep.
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

    jobs: list[Foreseen]
    to_run: int
    seconds: float | None
    workers: int
    judged_by: str
    from_experience: bool

    def words(self) -> str:
        """Return the whole in one line."""
        count = f"{self.to_run} of {len(self.jobs)} jobs would run"
        if self.seconds is None:
            return f"{count}; how long that takes is not known: {self.judged_by}"
        if not self.to_run:
            return count
        seconds = self.seconds * self.workers / self.to_run
        each = f"{seconds:.2g} s" if seconds < 100 else duration(seconds)
        workers = f"{self.workers} worker" + ("s" if self.workers > 1 else "")
        return f"{count}, about {duration(self.seconds)} with {workers} ({each} a job, {self.judged_by})"


def foresee(
    jobs: Sequence[Job],
    folder: ResultsFolder,
    shard: Shard,
    retry_failed: bool,
    workers: int,
    tell: Callable[[str], None] = lambda line: None,
) -> Foresight:
    """Say of each job of a sweep whether a run would do it, and why; nothing is written."""
    jobs = [job for job in jobs if in_shard(job.job_id, shard)]
    known = read_index(folder, verify=True) if folder.path.is_dir() else {}
    earlier = _Earlier(folder, known.keys() - {job.job_id for job in jobs}) if known else None
    label = labels([job.inputs() for job in jobs])
    foreseen = []
    for job in jobs:
        runs = is_to_run(known.get(job.job_id), retry_failed)
        reason = _reason(job, known.get(job.job_id), retry_failed, earlier)
        foreseen.append(Foreseen(job.job_id, label(job.inputs()), runs, reason))
    to_run = [job for job, one in zip(jobs, foreseen, strict=True) if one.runs]
    each = estimate(to_run, folder, tell)
    seconds = None if each.seconds is None else len(to_run) * each.seconds / workers
    return Foresight(foreseen, len(to_run), seconds, workers, each.by, each.is_experience)


def _reason(job: Job, known: Known | None, retry_failed: bool, earlier: _Earlier | None) -> str:
    if known is None:
        return (earlier and earlier.change_to(job)) or "new"
    if known.status == of.FAILED:
        return f"failed before: {known.cause}" + ("" if retry_failed else "; --retry-failed does it again")
    return f"done: {known.status}"


class _Earlier:
    """Results that the sweep no longer names: what a job may have changed from."""

    def __init__(self, folder: ResultsFolder, job_ids: Iterable[str]) -> None:
        self.rows: dict[tuple[str, str], list[dict[str, Any]]] = {}
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
