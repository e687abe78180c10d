"""Running a sweep's jobs on workers: streaming, resuming, and surviving whatever kills a worker, or us.

Workers solve and encode; this process alone writes, so that one lock and one journal suffice, and workers on
other machines need no common disk.
"""

from __future__ import annotations

import os
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import IO, TYPE_CHECKING, Any, TextIO

from joblib import Parallel, delayed

from upwash import columns as of
from upwash.batch.bundle import Bundle, encode, run_batch
from upwash.batch.folder import OF_OWN, Plan, ResultsFolder, Shard
from upwash.batch.gather import Gathering
from upwash.batch.index import Known, read_index
from upwash.batch.journal import Stretch, journal_line, open_journal
from upwash.batch.progress import Progress
from upwash.batch.recovery import verified_index
from upwash.batch.selection import in_shard, is_to_run
from upwash.batch.signals import signals_held, stopping_on_signals
from upwash.batch.store import sync, write_atomic
from upwash.batch.workers import LOKY, stop, workers
from upwash.errors import UpwashError
from upwash.jobs.job import BUILT_IN_SOLVER
from upwash.jobs.own_solver import own_columns, own_solver
from upwash.jobs.run import Ended, compiling, failed_rows

if TYPE_CHECKING:
    from upwash.jobs.job import Job

BATCH_S = 0.25
"""A batch of cheap jobs lasts about so long: long against the cost of handing it over, short to lose."""

MAX_BATCH = 1000

MAX_FLYING = 5000
"""With more jobs handed out whose results are not stored, no more are until all are: results take memory."""

FLUSH_S = 0.05
"""Results that took longer are put on the disk at once; that takes milliseconds."""

KILLED = (
    "WorkerKilled: the worker was killed twice, the second time with no other job at work; out of memory?"
)


@dataclass(frozen=True)
class Options:
    """How to run.

    Parameters
    ----------
    workers : int
        Worker processes of the loky backend.
    backend : str
        ``loky`` or ``dask``.
    scheduler : str
        Address of the dask scheduler.
    shard : Shard
        Part of the sweep to do.
    retry_failed, fail_fast : bool
        Whether to do failed jobs again, and whether to stop at the first failure.
    """

    workers: int = 2
    backend: str = "loky"
    scheduler: str = ""
    shard: Shard = Shard()
    retry_failed: bool = False
    fail_fast: bool = False


@dataclass
class Tally:
    """What a run has come to: its jobs done before, done now, and failed."""

    jobs: int
    kept: int
    done: int = 0
    failed: int = 0

    @property
    def left(self) -> int:
        """Jobs that have no result yet."""
        return self.jobs - self.kept - self.done


def run_sweep(
    jobs: Sequence[Job], plan: Plan, folder: ResultsFolder, options: Options, stream: TextIO
) -> Tally:
    """Run a sweep's jobs that have no result yet.

    Parameters
    ----------
    jobs : sequence of Job
        All jobs of the sweep.
    plan : Plan
        The same, by id.
    folder : ResultsFolder
        Where results go, and where finished jobs are known from.
    options : Options
        How to run.
    stream : text stream
        Where progress goes.

    Returns
    -------
    Tally
        The number of jobs done and failed, of this shard.

    Raises
    ------
    UpwashError
        If the folder is in use or cannot be written, or there are no workers. What was finished is kept.
    KeyboardInterrupt
        If the user, or the system, asks to stop; `Interrupted` carries the tally.
    """
    folder.create()
    with ExitStack() as stack:
        stack.enter_context(stopping_on_signals())
        stack.enter_context(folder.locked(options.shard))
        plan = with_own_columns(plan, folder, jobs)
        folder.write_plan(plan)
        known = _index(folder, options.shard, lambda line: print(line, file=stream))
        jobs = [job for job in jobs if in_shard(job.job_id, options.shard)]
        to_do = [job for job in jobs if is_to_run(known.get(job.job_id), options.retry_failed)]
        kept = len(jobs) - len(to_do)
        tally = Tally(len(jobs), kept, failed=_failed(jobs, known) if not options.retry_failed else 0)
        if to_do:
            journal = stack.enter_context(open_journal(folder, options.shard, len(to_do)))
            progress = Progress(len(jobs), kept, stream)
            if kept:
                progress.tell(f"{folder}: {kept} of {len(jobs)} jobs are done, {len(to_do)} left to do")
            stack.callback(progress.close)
            gathering = Gathering(folder, options.shard, plan.rows, plan.text)
            run = _Run(folder, gathering, journal, progress, tally, options)
            try:
                run.all(to_do)
            except _FirstFailure:
                pass
            except KeyboardInterrupt as interrupt:
                raise Interrupted(tally) from interrupt
    return tally


def with_own_columns(plan: Plan, folder: ResultsFolder, jobs: Sequence[Job]) -> Plan:
    """Return a plan with the columns that the jobs' solver declares, and those that it declared before.

    Raises
    ------
    UpwashError
        If it declares a column otherwise than before.
    """
    before = folder.plan()
    columns = {column.name: column for column in before.columns} if before else {}
    for solver in {job.solver for job in jobs} - {BUILT_IN_SOLVER}:
        for column in own_columns(own_solver(solver), solver):
            kept = columns.setdefault(column.name, column)
            if [getattr(kept, name) for name in OF_OWN] != [getattr(column, name) for name in OF_OWN]:
                remedy = "give it another name, or take another folder by --results"
                raise UpwashError(
                    f"{folder}: expected column {column.name!r} as it was declared before ({kept.unit}, "
                    f"{kept.type}: {kept.description}), found it otherwise; {remedy}"
                )
    return replace(plan, columns=tuple(columns.values()))


class Interrupted(KeyboardInterrupt):
    """A run was asked to stop; `tally` says how far it came."""

    def __init__(self, tally: Tally) -> None:
        super().__init__()
        self.tally = tally


class _FirstFailure(Exception):
    """A job failed, and the user wants to stop there."""


def _index(folder: ResultsFolder, shard: Shard, tell: Callable[[str], None]) -> dict[str, Known]:
    # Shards share the folder while they run: whoever has it alone, an unsharded run or `aggregate`, fixes it.
    return read_index(folder) if shard.count > 1 else verified_index(folder, tell)


def _failed(jobs: Sequence[Job], known: dict[str, Known]) -> int:
    found = (known.get(job.job_id) for job in jobs)
    return sum(one is not None and one.status == of.FAILED for one in found)


class _Run:
    """One run: hands out batches, takes in results, and finds the job that kills its worker."""

    def __init__(
        self,
        folder: ResultsFolder,
        gathering: Gathering,
        journal: IO[str],
        progress: Progress,
        tally: Tally,
        options: Options,
    ) -> None:
        self.folder = folder
        self.gathering = gathering
        self.journal = journal
        self.progress = progress
        self.tally = tally
        self.options = options
        self.queue: deque[Job] = deque()
        # Jobs that were in flight when a worker was killed.
        self.suspects: deque[Job] = deque()
        self.is_alone = False
        self.is_on_trial = False
        self.is_stopping = False
        # Batches handed out and not come back, by the id of their first job, oldest first.
        self.flying: dict[str, list[Job]] = {}
        # Jobs in batches handed out, and in those that came back.
        self.handed = self.stored = 0
        self.batch_size = 1

    def all(self, jobs: Sequence[Job]) -> None:
        """Run jobs until each has a result."""
        self.queue.extend(jobs)
        first_of_all = compiling(jobs[0]) if self.options.backend == LOKY else ""
        self.is_on_trial = jobs[0].solver != BUILT_IN_SOLVER
        with workers(self.options.backend, self.options.scheduler) as killed:
            while self.queue or self.suspects:
                self.is_alone, self.is_stopping = bool(self.suspects), False
                try:
                    if self.is_alone:
                        self.alone(self.suspects.popleft())
                    elif first_of_all:
                        # Workers that begin together would all compile the same.
                        self.progress.tell(first_of_all)
                        first_of_all = ""
                        self.alone(self.queue.popleft())
                        self.progress.restart()
                        self.is_on_trial = False
                    elif self.is_on_trial:
                        # A solver that does not keep to its contract would fail in every job.
                        self.alone(self.queue.popleft())
                        self.is_on_trial = False
                    else:
                        self.stream(self.batches())
                except killed as death:
                    self.after_a_death(death)

    def alone(self, job: Job) -> None:
        """Run one job with nothing beside it, so that a worker's death names its culprit."""
        self.stream([self.task([job])])

    def stream(self, tasks: Iterable[Any]) -> None:
        """Run tasks on one pool of workers, taking results as they finish."""
        # joblib would run one worker's jobs in this very process. Two of which one waits are as fast, and
        # leave us alive if it dies.
        pool = Parallel(
            n_jobs=max(2, self.options.workers),
            pre_dispatch=1 if self.options.workers == 1 else "2 * n_jobs",
            batch_size=1,
            return_as="generator_unordered",
        )
        outputs = None
        try:
            with signals_held():
                outputs = pool(tasks)
            for bundles, left in outputs:
                self.take(bundles, left)
        except BaseException:
            self.is_stopping = True
            if outputs is not None:
                stop(pool, outputs)
            raise

    def task(self, batch: list[Job]) -> Any:
        """Hand out a batch: return what a worker is to do with it."""
        self.flying[batch[0].job_id] = batch
        self.handed += len(batch)
        # Workers of dask may be on other machines, and what they find is in a folder of their own.
        place = os.getcwd() if self.options.backend == LOKY else None
        return delayed(run_batch)(batch, self.gathering.sweep_text, BATCH_S, place)

    def batches(self) -> Iterator[Any]:
        """Hand out batches; called from joblib's threads, one at a time."""
        while self.queue and not self.is_stopping and self.handed - self.stored < MAX_FLYING:
            # Towards the end batches get shorter, so that the workers finish together.
            fair = -(-len(self.queue) // (2 * self.options.workers))
            batch = [self.queue.popleft() for _ in range(min(self.batch_size, fair))]
            yield self.task(batch)

    def take(self, bundles: list[Bundle], left: list[Job]) -> None:
        """Store the results of a batch, and put back what it did not get to."""
        for bundle in bundles:
            self.keep(bundle)
        sync(self.folder.jobs)
        results = [result for bundle in bundles for result in bundle.results]
        seconds = sum(result.seconds for result in results)
        self.note(Stretch(time.time(), len(results), seconds))
        del self.flying[results[0].job_id]
        self.stored += len(results) + len(left)
        self.queue.extend(left)
        mean = seconds / len(results)
        fitting = len(results) if left else int(BATCH_S / max(mean, BATCH_S / MAX_BATCH))
        self.batch_size = max(1, min(2 * self.batch_size, fitting))
        self.progress.show()

    def keep(self, bundle: Bundle) -> None:
        """Store what came of one job, or of several; gather if there are many files now."""
        results = bundle.results
        if self.is_on_trial and results[0].is_unfit:
            remedy = "correct the solver; no result was stored"
            raise UpwashError(f"solver, job {results[0].job_id}: {results[0].error}; {remedy}")
        # A job's own file that a power cut tears is noticed, and if it was cheap it is soon redone.
        if len(results) == 1:
            path, flush = self.folder.job_file(results[0].job_id), results[0].seconds > FLUSH_S
        else:
            path, flush = self.folder.new_part(len(results), self.options.shard), True
        write_atomic(path, bundle.data, flush=flush)
        self.gathering.added(len(results))
        for result in results:
            self.tally.done += 1
            self.tally.failed += result.status == of.FAILED
            self.progress.finished(result.job_id, result.status, result.error)
        if self.options.fail_fast and any(result.status == of.FAILED for result in results):
            raise _FirstFailure

    def note(self, done: Stretch) -> None:
        """Tell the journal, by which the rate is known."""
        try:
            self.journal.write(journal_line(done))
        except OSError as error:
            raise self.folder.cannot("write there", error) from error

    def after_a_death(self, death: BaseException) -> None:
        """Sort out what was in flight when a worker was killed.

        A job gets one retry, alone. So a job that was alone, or that dask has tried on several workers, is
        the culprit; of several, each may be.
        """
        named = getattr(death, "jobs", None)
        flying = list(self.flying.values())
        self.flying.clear()
        self.handed = self.stored = 0
        suspects: list[Job] = []
        others: list[Job] = []
        for batch in flying:
            is_suspect = named is None or batch[0].job_id == named[0].job_id
            (suspects if is_suspect else others).extend(batch)
        self.queue.extendleft(reversed(others))
        if len(suspects) == 1 and (self.is_alone or named):
            self.keep(
                encode([Ended(suspects[0], failed_rows(suspects[0], KILLED))], self.gathering.sweep_text)
            )
        else:
            self.suspects.extend(suspects)
