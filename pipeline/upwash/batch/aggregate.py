"""Gathering job files into tables, in an order and in pieces that do not depend on how the jobs were run.

Rows are sorted by job and rank and written in row groups of whole jobs. What was gathered before is merged
with the job files since, a range of ids at a time, so that memory does not grow with the sweep.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc

from upwash.batch.folder import RETIRED, SUMMARY, Plan, ResultsFolder
from upwash.batch.index import Index
from upwash.batch.mend import verified_index
from upwash.batch.store import (
    GATHERED,
    ROWS,
    SUMMARIES,
    TableWriter,
    merged_provenance,
    metadata_of,
    open_table,
    read_table,
    replacing,
    sync,
)
from upwash.batch.summary import summary_of
from upwash.errors import UpwashError

JOBS_PER_PIECE = 1000


@dataclass(frozen=True)
class Gathered:
    """What was gathered: jobs of the sweep, those that have no result yet, and jobs that it does not name."""

    jobs: int
    missing: int
    retired: int


def aggregate(folder: ResultsFolder, tell: Callable[[str], None]) -> Gathered:
    """Gather all finished jobs of a results folder, and then remove their own files.

    Whatever interrupts this, no row is lost: the tables are in place before a job file goes.

    Raises
    ------
    UpwashError
        If there are no results, someone else is writing, or the folder cannot be written.
    """
    folder.require()
    with folder.locked():
        index = verified_index(folder, tell)
        ids = sorted(index.jobs)
        if not ids:
            raise UpwashError(f"{folder}: expected finished jobs, found none; run the sweep first")
        plan = folder.plan() or Plan("", folder.kind(), "", ids)
        _write_tables(folder, plan, index, ids)
        sync(folder.path)
        for job_id in index.single:
            folder.job_file(job_id).unlink()
        for path in folder.journals():
            path.unlink()
        named = set(plan.jobs)
        found = len(named & index.jobs.keys())
        return Gathered(found, len(named) - found, len(ids) - found)


def _write_tables(folder: ResultsFolder, plan: Plan, index: Index, ids: list[str]) -> None:
    schema, named = ROWS[plan.kind], pa.array(plan.jobs, pa.string())
    tables = folder.path / GATHERED[plan.kind], folder.path / RETIRED
    has_retired = tables[1].exists() or not set(ids) <= set(plan.jobs)
    with ExitStack() as files, ExitStack() as finished:
        singles = _Singles(folder, sorted(index.single), schema)
        gathered, retired = (_Gathered(files, path, schema) for path in tables)
        # Put in place in the reverse order: a row that is retired is there before it is gone here.
        summaries = _open(finished, folder.path / SUMMARY, SUMMARIES[plan.kind])
        current = _open(finished, tables[0], schema)
        others = _open(finished, tables[1], schema) if has_retired else None
        for bound in [*ids[JOBS_PER_PIECE::JOBS_PER_PIECE], None]:
            latest = _merged(singles.below(bound), gathered.below(bound))
            before = retired.below(bound)
            every = _merged(latest, before)
            rows = every.filter(pc.is_in(every.column("job_id"), named))
            current.write(rows)
            summaries.write(summary_of(rows, plan.kind))
            if others:
                # What is named again stays among the retired rows too, where it no longer counts.
                others.write(_merged(_without(latest, named), before))
        metadata = merged_provenance(singles.metadata + gathered.metadata + retired.metadata, plan.text)
        for writer in filter(None, (current, summaries, others)):
            writer.close(metadata)


def _open(stack: ExitStack, path: Path, schema: pa.Schema) -> TableWriter:
    return TableWriter(stack.enter_context(replacing(path)), schema)


def _without(table: pa.Table, jobs: pa.Array) -> pa.Table:
    return table.filter(pc.invert(pc.is_in(table.column("job_id"), jobs)))


def _merged(first: pa.Table, second: pa.Table) -> pa.Table:
    """Return the rows of two tables, sorted; those of a job that is in both are the first's."""
    rows = pa.concat_tables([first, _without(second, first.column("job_id").unique())])
    order = [("job_id", "ascending"), ("bird" if "bird" in rows.column_names else "rank", "ascending")]
    return rows.sort_by(order).combine_chunks()


def _all_below(rows: pa.Table, bound: str) -> bool:
    """Whether a sorted table has no job at or above a bound."""
    return rows.num_rows == 0 or rows.column("job_id")[-1].as_py() < bound


class _Gathered:
    """The rows of a gathered table, a range of ids at a time; of none, if there is no such file."""

    def __init__(self, stack: ExitStack, path: Path, schema: pa.Schema) -> None:
        self.file = stack.enter_context(open_table(path, schema)) if path.exists() else None
        self.metadata = [metadata_of(self.file.schema_arrow)] if self.file else []
        self.groups = iter(range(self.file.num_row_groups if self.file else 0))
        self.held = schema.empty_table()

    def below(self, bound: str | None) -> pa.Table:
        """Return the rows not yet given of jobs below a bound, or all of them."""
        parts = [self.held]
        while self.file and (bound is None or _all_below(parts[-1], bound)):
            number = next(self.groups, None)
            if number is None:
                break
            parts.append(self.file.read_row_group(number, use_threads=False).replace_schema_metadata())
        rows = pa.concat_tables(parts)
        count = rows.num_rows if bound is None else pc.sum(pc.less(rows.column("job_id"), bound)).as_py() or 0
        self.held = rows.slice(count)
        return rows.slice(0, count)


class _Singles:
    """The rows of the jobs' own files, a range of ids at a time."""

    def __init__(self, folder: ResultsFolder, ids: list[str], schema: pa.Schema) -> None:
        self.folder = folder
        self.ids = deque(ids)
        self.schema = schema
        self.metadata: list[dict[str, str]] = []

    def below(self, bound: str | None) -> pa.Table:
        """Return the rows not yet given of jobs below a bound, or all of them."""
        tables = [self.schema.empty_table()]
        while self.ids and (bound is None or self.ids[0] < bound):
            table = read_table(self.folder.job_file(self.ids.popleft()), self.schema)
            metadata = metadata_of(table.schema)
            if metadata not in self.metadata:
                self.metadata.append(metadata)
            tables.append(table.replace_schema_metadata())
        return pa.concat_tables(tables)
