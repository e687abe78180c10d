"""Gathering all finished jobs into tables, in an order and in pieces that do not depend on how they were run.

Rows are sorted by job and rank and written in row groups of whole jobs. What was gathered before is merged
with what was done since, a range of ids at a time, so that memory does not grow with the sweep.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from pathlib import Path

import pyarrow as pa

from upwash.batch.folder import RETIRED, SUMMARY, Plan, ResultsFolder
from upwash.batch.journal import journals_of
from upwash.batch.merging import merged, only, sources_of, without
from upwash.batch.recovery import verified_index
from upwash.batch.store import TableWriter, merged_provenance, replacing, sync
from upwash.errors import UpwashError


@dataclass(frozen=True)
class Gathered:
    """What was gathered: jobs of the sweep, those that have no result yet, and jobs that it does not name."""

    jobs: int
    missing: int
    retired: int


def aggregate(folder: ResultsFolder, tell: Callable[[str], None]) -> Gathered:
    """Gather all finished jobs of a results folder, and then remove the files that held them until now.

    Whatever interrupts this, no row is lost: the tables are in place before another file goes.

    Raises
    ------
    UpwashError
        If there are no results, someone else is writing, or the folder cannot be written.
    """
    folder.require()
    with folder.locked():
        ids = sorted(verified_index(folder, tell))
        if not ids:
            raise UpwashError(f"{folder}: expected finished jobs, found none; run the sweep first")
        plan = folder.plan() or Plan("", folder.kind(), "", ids)
        gathered = [*map(folder.job_file, folder.job_ids()), *folder.part_files()]
        _write_tables(folder, plan, ids)
        sync(folder.path)
        for path in (*gathered, *journals_of(folder)):
            path.unlink()
        with suppress(OSError):
            folder.parts.rmdir()
        named = set(plan.jobs)
        found = len(named.intersection(ids))
        return Gathered(found, len(named) - found, len(ids) - found)


def _write_tables(folder: ResultsFolder, plan: Plan, ids: list[str]) -> None:
    schema, named = plan.rows, pa.array(plan.jobs, pa.string())
    current_path, retired_path = folder.path / plan.kind.file, folder.path / RETIRED
    with ExitStack() as files, ExitStack() as finished:
        sources = sources_of(files, folder, schema)
        were_retired = set(sources[-1].ids()) if retired_path.exists() else set()
        has_retired = bool(were_retired) or not set(ids) <= set(plan.jobs)
        # What is named again stays among the retired rows, too, so that it is in a file at every moment.
        never_retired = pa.array([job_id for job_id in plan.jobs if job_id not in were_retired], pa.string())
        # Put in place in the reverse order: a row that is retired is there before it is gone here.
        summaries = _open(finished, folder.path / SUMMARY, plan.kind.summary_schema(schema))
        current = _open(finished, current_path, schema)
        retired = _open(finished, retired_path, schema) if has_retired else None
        for rows in merged(sources, ids):
            of_the_sweep = only(rows, named)
            current.write(of_the_sweep)
            summaries.write(plan.kind.summarise(of_the_sweep))
            if retired:
                retired.write(without(rows, never_retired))
        metadata = merged_provenance([one for source in sources for one in source.metadata], plan.text)
        for writer in filter(None, (current, summaries, retired)):
            writer.close(metadata)


def _open(stack: ExitStack, path: Path, schema: pa.Schema) -> TableWriter:
    return TableWriter(stack.enter_context(replacing(path)), schema)
