"""Reading several files of rows as one: sorted by job, each job once, a range of ids at a time.

A job may be found twice, for a run may be killed after it gathered some jobs and before it removed their own
files, and a job that failed may be done again. A failure never counts beside a result that is none; otherwise
that of the file named first counts, for a job's result follows from its inputs.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc

from upwash import columns as of
from upwash.batch.folder import ResultsFolder
from upwash.batch.index import table_files
from upwash.batch.store import Damaged, conformed, metadata_of, noticing, open_table, read_table

JOBS_PER_PIECE = 1000
"""Jobs in a row group of a gathered table, which is read, checked and, if it is damaged, lost as one."""


def merged(
    sources: Sequence[JobFiles | Table], ids: Sequence[str], jobs_per_piece: int = 0
) -> Iterator[pa.Table]:
    """Give the rows of sorted sources, some jobs at a time, sorted, one result a job.

    Parameters
    ----------
    sources : sequence of JobFiles or Table
        Where the rows are; of two equal results of a job the first source's counts.
    ids : sequence of str
        The ids of the jobs, sorted.
    jobs_per_piece : int
        Jobs in a piece, `JOBS_PER_PIECE` if not given.
    """
    count = jobs_per_piece or JOBS_PER_PIECE
    for bound in [*ids[count::count], None]:
        yield Several(sources).below(bound)


def one_result_a_job(tables: Sequence[pa.Table]) -> pa.Table:
    """Join tables; of a job that several hold, the rows of the first count in which it has not failed."""
    tables = [table for table in tables if table.num_rows] or list(tables[:1])
    ids = [table.column("job_id").unique() for table in tables]
    if len({job for some in ids for job in some.to_pylist()}) < sum(map(len, ids)):
        failed = [_failed_jobs(table) for table in tables]
        whole = [without(table, jobs) for table, jobs in zip(tables, failed, strict=True)]
        rest = [only(table, jobs) for table, jobs in zip(tables, failed, strict=True)]
        tables, seen = [], set[str]()
        for table in (*whole, *rest):
            table = without(table, pa.array(sorted(seen), pa.string()))
            seen |= set(table.column("job_id").unique().to_pylist())
            tables.append(table)
    return pa.concat_tables(tables)


def in_order(rows: pa.Table) -> pa.Table:
    """Sort rows by job, and by rank or bird."""
    order = [name for name in ("job_id", "bird", "rank") if name in rows.column_names]
    return rows.sort_by([(name, "ascending") for name in order]).combine_chunks()


def only(table: pa.Table, jobs: pa.Array) -> pa.Table:
    """Return the rows of some jobs."""
    return table.filter(pc.is_in(table.column("job_id"), jobs))


def without(table: pa.Table, jobs: pa.Array) -> pa.Table:
    """Return the rows of all but some jobs."""
    return table.filter(pc.invert(pc.is_in(table.column("job_id"), jobs)))


def _failed_jobs(table: pa.Table) -> pa.Array:
    failed = table.filter(pc.equal(table.column("status"), of.FAILED))
    return failed.column("job_id").unique()


def sources_of(stack: ExitStack, folder: ResultsFolder, schema: pa.Schema) -> list[JobFiles | Table]:
    """Return all that a folder's rows are in, none of it damaged, the newest first; the stack keeps files open."""
    tables = (Table(stack, path, schema) for path in table_files(folder))
    return [JobFiles(folder, folder.job_ids(), schema, strict=True), *tables]


class Several:
    """The rows of several sources, as one."""

    def __init__(self, sources: Sequence[JobFiles | Table]) -> None:
        self.sources = sources

    @property
    def metadata(self) -> list[dict[str, str]]:
        """The metadata of the files read until now."""
        return [one for source in self.sources for one in source.metadata]

    def ids(self) -> Iterable[str]:
        """Return the jobs not yet given."""
        return {job_id for source in self.sources for job_id in source.ids()}

    def below(self, bound: str | None) -> pa.Table:
        """Return the rows not yet given of jobs below a bound, or all of them."""
        return in_order(one_result_a_job([source.below(bound) for source in self.sources]))


class Table:
    """The rows of a file of many jobs, sorted by job in row groups of whole jobs; read a group at a time."""

    def __init__(self, stack: ExitStack, path: Path, schema: pa.Schema) -> None:
        self.path = path
        self.schema = schema
        self.file = stack.enter_context(open_table(path, schema))
        self.metadata = [metadata_of(self.file.schema_arrow)]
        self.groups = iter(range(self.file.num_row_groups))
        self.held = schema.empty_table()

    def ids(self) -> Iterable[str]:
        """Return the jobs in the file."""
        return self.file.read(["job_id"], use_threads=False).column(0).unique().to_pylist()

    def below(self, bound: str | None) -> pa.Table:
        """Return the rows not yet given of jobs below a bound, or all of them."""
        parts = [self.held]
        while bound is None or _all_below(parts[-1], bound):
            number = next(self.groups, None)
            if number is None:
                break
            with noticing(self.path):
                rows = self.file.read_row_group(number, use_threads=False)
            parts.append(conformed(rows.replace_schema_metadata(), self.schema))
        rows = pa.concat_tables(parts)
        count = rows.num_rows if bound is None else pc.sum(pc.less(rows.column("job_id"), bound)).as_py() or 0
        self.held = rows.slice(count)
        return rows.slice(0, count)


def _all_below(rows: pa.Table, bound: str) -> bool:
    """Whether a sorted table has no job at or above a bound."""
    return rows.num_rows == 0 or rows.column("job_id")[-1].as_py() < bound


class JobFiles:
    """The rows of the jobs' own files; unless `strict`, one that is damaged, or gone since, is passed over."""

    def __init__(
        self, folder: ResultsFolder, ids: Iterable[str], schema: pa.Schema, strict: bool = False
    ) -> None:
        self.folder = folder
        self.strict = strict
        self.waiting = deque(sorted(ids))
        self.schema = schema
        self.metadata: list[dict[str, str]] = []
        self.given: list[Path] = []

    def ids(self) -> Iterable[str]:
        """Return the jobs not yet given."""
        return self.waiting

    def below(self, bound: str | None) -> pa.Table:
        """Return the rows not yet given of jobs below a bound, or all of them."""
        tables = [self.schema.empty_table()]
        while self.waiting and (bound is None or self.waiting[0] < bound):
            path = self.folder.job_file(self.waiting.popleft())
            try:
                table = read_table(path, self.schema)
            except (Damaged, FileNotFoundError):
                if self.strict:
                    raise
                continue
            metadata = metadata_of(table.schema)
            if metadata not in self.metadata:
                self.metadata.append(metadata)
            tables.append(conformed(table.replace_schema_metadata(), self.schema))
            self.given.append(path)
        return pa.concat_tables(tables)
