"""What a run would do, and why, without doing it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.batch.folder import SUMMARY, ResultsFolder, Shard
from upwash.batch.index import Known, read_index, table_files
from upwash.batch.progress import duration
from upwash.batch.selection import in_shard, is_to_run

if TYPE_CHECKING:
    from upwash.batch.job import Job

TYPICAL_S = {"pair": 0.5, "flock": 3.0}
"""Time that a job takes on an ordinary core, for a first estimate."""

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
    seconds : float
        How long that would take.
    from_experience : bool
        Whether that is judged by jobs of this folder, and not by a typical job.
    """

    jobs: list[Foreseen]
    to_run: int
    seconds: float
    from_experience: bool

    def words(self) -> str:
        """Return the whole in one line."""
        judged = "by the jobs done so far" if self.from_experience else "by a typical job"
        return f"{self.to_run} of {len(self.jobs)} jobs would run, about {duration(self.seconds)} ({judged})"


def foresee(
    jobs: Sequence[Job], folder: ResultsFolder, shard: Shard, retry_failed: bool, workers: int
) -> Foresight:
    """Say of each job of a sweep whether a run would do it, and why; nothing is written."""
    jobs = [job for job in jobs if in_shard(job.job_id, shard)]
    known = read_index(folder, verify=True) if folder.path.is_dir() else {}
    earlier = _Earlier(folder, known.keys() - {job.job_id for job in jobs}) if known else None
    label = _labels(jobs)
    foreseen = []
    for job in jobs:
        runs = is_to_run(known.get(job.job_id), retry_failed)
        reason = _reason(job, known.get(job.job_id), retry_failed, earlier)
        foreseen.append(Foreseen(job.job_id, label(job), runs, reason))
    to_run = sum(one.runs for one in foreseen)
    seconds = _experience(folder)
    each = seconds if seconds is not None else TYPICAL_S[jobs[0].kind] if jobs else 0.0
    return Foresight(foreseen, to_run, to_run * each / workers, seconds is not None)


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
        for row in _inputs(folder, set(job_ids)):
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


def _inputs(folder: ResultsFolder, job_ids: set[str]) -> Iterable[dict[str, Any]]:
    from upwash.batch.store import ROWS, Damaged, open_table

    asked = of.belonging(of.OUTCOME, of.PROBLEM, of.SEARCH, of.FLOCK)
    names = [name for name in of.names(asked) if name in ROWS[folder.kind()].names]
    paths = [*table_files(folder), *(folder.job_file(job_id) for job_id in job_ids & folder.job_ids())]
    for path in paths if job_ids else ():
        try:
            with open_table(path, ROWS[folder.kind()]) as file:
                rows = file.read(columns=names, use_threads=False).to_pylist()
        except Damaged:
            continue
        first = {row["job_id"]: row for row in reversed(rows) if row["job_id"] in job_ids}
        yield from first.values()


def _labels(jobs: Sequence[Job]) -> Any:
    """Return a function that names a job by species, objective and whatever else varies in the sweep."""
    columns = [job.inputs() for job in jobs]
    varied = [name for name in (columns[0] if columns else ()) if len({row[name] for row in columns}) > 1]
    varied = [name for name in varied if name not in ("species", "objective")]
    return lambda job: " ".join(
        [job.species, job.objective, *(f"{name}={_short(getattr(job, name))}" for name in varied)]
    )


def _short(value: Any) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def _experience(folder: ResultsFolder) -> float | None:
    """Return the mean time of the jobs done in this folder, if there are any."""
    done = folder.read_journals().done
    if done:
        return sum(entry.seconds for entry in done) / sum(entry.jobs for entry in done)
    summary = folder.path / SUMMARY
    seconds = []
    if summary.exists() and folder.kind() == "pair":
        import pyarrow.parquet as pq

        seconds = pq.read_table(summary, columns=["solve_time_s"]).column(0).drop_null().to_pylist()
    return sum(seconds) / len(seconds) if seconds else None
