"""A results folder: what is in it, and who may write to it.

::

    plan.json            the sweep's text and its jobs' ids, in order
    jobs/<id>.parquet    one a job, until they are gathered
    parts/<n>-….parquet  the rows of n jobs, gathered while a run goes on
    solutions.parquet    the gathered rows of this sweep's jobs (flock.parquet for flocks)
    retired.parquet      gathered rows of jobs that the sweep no longer names, should it name them again
    summary.parquet      one row a job
    journal-1-of-1.csv   when a run began and how fast it went: for estimates alone
    corrupt/             files that were found damaged
    .lock                held by whoever writes

What is done is what the Parquet files hold, and nothing else says so. A job may be in several of them for a
moment, or after a run was killed; whoever reads takes one result (`upwash.batch.merging`).
"""

from __future__ import annotations

import fcntl
import itertools
import json
import os
import re
import shutil
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from secrets import token_hex

import pyarrow as pa

from upwash.batch.store import write_atomic
from upwash.columns import Column
from upwash.errors import UpwashError
from upwash.jobs.kind import Kind
from upwash.jobs.kinds import KINDS
from upwash.jobs.pair import Pair
from upwash.jobs.schema import with_own

JOB_ID = re.compile(r"[0-9a-f]{16}")
PART = re.compile(r"(\d+)-(\d+-of-\d+)-[0-9a-f]{8}\.parquet")
# `in_use` tries the lock too, for a moment; a run that meets it waits so long before it gives up.
LOCK_PATIENCE_S = 1.0

OF_OWN = ("name", "unit", "description", "type")
"""What is said of a column that the sweep's own solver declares."""

PLAN, RETIRED, SUMMARY = "plan.json", "retired.parquet", "summary.parquet"


@dataclass(frozen=True)
class Plan:
    """The sweep that a results folder is for.

    Parameters
    ----------
    sweep, text : str
        Name, and the file's own text.
    kind : type of Kind
        What its jobs are.
    jobs : list of str
        Ids, in the order of the file.
    columns : tuple of Column
        Those that the sweep's own solver declares.
    """

    sweep: str
    kind: type[Kind]
    text: str
    jobs: list[str]
    columns: tuple[Column, ...] = ()

    @property
    def rows(self) -> pa.Schema:
        """The schema of its rows, with the columns of a solver's own at the end."""
        return with_own(self.kind.rows, self.columns)


@dataclass(frozen=True)
class Shard:
    """Part `number` (from 1) of `count` of a sweep's jobs."""

    number: int = 1
    count: int = 1

    def __str__(self) -> str:
        return f"{self.number}-of-{self.count}"


class ResultsFolder:
    """A results folder by its path; nothing is read or written until asked for."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        self.jobs = self.path / "jobs"
        self.parts = self.path / "parts"
        self.corrupt = self.path / "corrupt"

    def __str__(self) -> str:
        return str(self.path)

    def job_file(self, job_id: str) -> Path:
        """Return the path of a job's own file."""
        return self.jobs / f"{job_id}.parquet"

    def create(self) -> None:
        """Make the folder if there is none."""
        try:
            self.jobs.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise self.cannot("make the results folder", error) from error

    def cannot(self, do_what: str, error: OSError) -> UpwashError:
        """Build the one line that says why the folder cannot be used."""
        remedy = "fix that, or take another folder by --results"
        return UpwashError(f"{self.path}: expected to {do_what}, found: {error.strerror}; {remedy}")

    def require(self) -> None:
        """Complain if there are no results here."""
        try:
            is_folder, found = (
                self.path.is_dir(),
                "something else" if self.path.exists() else "no such folder",
            )
        except OSError as error:
            is_folder, found = False, str(error.strerror)
        if not is_folder:
            remedy = "'upwash run SWEEP' makes one"
            raise UpwashError(f"{str(self.path)!r}: expected a results folder, found {found}; {remedy}")
        names = (PLAN, SUMMARY, *(kind.file for kind in KINDS.values()))
        if not any((self.path / name).exists() for name in names):
            remedy = "'upwash run SWEEP' makes one"
            raise UpwashError(f"{self.path}: expected a results folder, found no results in it; {remedy}")

    # Who may write

    @contextmanager
    def locked(self, shard: Shard | None = None) -> Iterator[None]:
        """Hold the folder: alone or, for a shard of a sweep, beside other shards.

        The system releases the lock when the process ends, however it ends.

        Raises
        ------
        UpwashError
            If someone else holds it.
        """
        with ExitStack() as stack:
            together = shard is not None and shard.count > 1
            self._lock(stack, ".lock", fcntl.LOCK_SH if together else fcntl.LOCK_EX)
            if together:
                self._lock(stack, f".lock-{shard}", fcntl.LOCK_EX)
            yield

    def _lock(self, stack: ExitStack, name: str, how: int) -> None:
        try:
            file = stack.enter_context((self.path / name).open("a"))
        except OSError as error:
            raise self.cannot("write there", error) from error
        deadline = time.monotonic() + LOCK_PATIENCE_S
        while True:
            try:
                return fcntl.flock(file, how | fcntl.LOCK_NB)
            except BlockingIOError as error:
                if time.monotonic() > deadline:
                    found = "another 'upwash' at work; wait for it to end, or stop it"
                    raise UpwashError(
                        f"{self.path}: expected nobody else to write there, found {found}"
                    ) from error
                time.sleep(LOCK_PATIENCE_S / 20)
            except OSError as error:
                raise self.cannot("lock it", error) from error

    def in_use(self) -> bool:
        """Whether someone is writing at the moment."""
        try:
            with open(self.path / ".lock") as file:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except FileNotFoundError:
            return False
        except OSError:
            return True
        return False

    # The plan

    def write_plan(self, plan: Plan) -> None:
        """Store which jobs belong here."""
        columns = [[getattr(column, name) for name in OF_OWN] for column in plan.columns]
        content = {**vars(plan), "kind": plan.kind.name, "jobs": " ".join(plan.jobs), "columns": columns}
        text = json.dumps(content, indent=0)
        path = self.path / PLAN
        # Shards of one sweep all write it at once, and the same.
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            write_atomic(path, text.encode())

    def plan(self) -> Plan | None:
        """Return which jobs belong here, if that is known."""
        path = self.path / PLAN
        try:
            content = json.loads(path.read_text(encoding="utf-8"))
            columns = tuple(Column(*column) for column in content.get("columns", ()))
            kind = KINDS[content["kind"]]
            return Plan(content["sweep"], kind, content["text"], content["jobs"].split(), columns)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise self.cannot(f"read {PLAN}", error) from error
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            remedy = "delete it and run the sweep again: no finished job will be redone"
            raise UpwashError(
                f"{path}: expected the plan of a sweep, found a damaged file; {remedy}"
            ) from error

    def kind(self) -> type[Kind]:
        """Return the kind of sweep."""
        plan = self.plan()
        if plan:
            return plan.kind
        return next((kind for kind in KINDS.values() if (self.path / kind.file).exists()), Pair)

    def schema(self) -> pa.Schema:
        """Return the schema of the rows, with the columns of a solver's own at the end."""
        plan = self.plan()
        return plan.rows if plan else self.kind().rows

    def gathered(self) -> Path:
        """Return the file that gathers the rows of the sweep's jobs."""
        return self.path / self.kind().file

    # The files of jobs, and of some jobs together

    def job_ids(self) -> set[str]:
        """Return the jobs that have a file of their own."""
        try:
            names = os.listdir(self.jobs)
        except FileNotFoundError:
            return set()
        except OSError as error:
            raise self.cannot("read its jobs", error) from error
        ids = (name.removesuffix(".parquet") for name in names if name.endswith(".parquet"))
        return {job_id for job_id in ids if JOB_ID.fullmatch(job_id)}

    def part_files(self) -> list[Path]:
        """Return the files of jobs that were gathered while a run went on, largest first."""
        found = [path for path in self.parts.glob("*.parquet") if PART.fullmatch(path.name)]
        return sorted(found, key=lambda path: (-jobs_in(path), path.name))

    def new_part(self, jobs: int, shard: Shard) -> Path:
        """Return a free place for a file of so many jobs, and make its folder."""
        try:
            self.parts.mkdir(exist_ok=True)
        except OSError as error:
            raise self.cannot("write there", error) from error
        return self.parts / f"{jobs}-{shard}-{token_hex(4)}.parquet"

    def set_aside(self, path: Path) -> Path:
        """Move a damaged file out of the way, beside any that were moved before."""
        target = self._free_place(path)
        os.replace(path, target)
        return target

    def copy_aside(self, path: Path) -> Path:
        """Keep a copy of a file of which a part is damaged."""
        return Path(shutil.copy2(path, self._free_place(path)))

    def _free_place(self, path: Path) -> Path:
        self.corrupt.mkdir(exist_ok=True)
        names = (f"{path.name}.{number}" if number else path.name for number in itertools.count())
        return next(self.corrupt / name for name in names if not (self.corrupt / name).exists())


def jobs_in(part: Path) -> int:
    """Return how many jobs a part holds, by its name."""
    return int(part.name.partition("-")[0])


def shard_of(part: Path) -> str:
    """Return which shard wrote a part, by its name."""
    return part.name.partition("-")[2].rpartition("-")[0]
