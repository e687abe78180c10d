"""Making one results folder of several, of one sweep each: of shards that wrote each a folder of its own."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from itertools import combinations

import pyarrow as pa
import pyarrow.compute as pc

from upwash import columns as of
from upwash.batch.compare import compare
from upwash.batch.folder import PLAN, Plan, ResultsFolder, Shard
from upwash.batch.gather import JOBS_PER_GROUP
from upwash.batch.index import Known, known_of, note
from upwash.batch.merging import Several, in_order, one_result_a_job, only, sources_of
from upwash.batch.store import (
    Damaged,
    TableWriter,
    cannot_write,
    merged_provenance,
    sync,
    temporary,
)
from upwash.errors import UpwashError

SHOWN = 3


@dataclass(frozen=True)
class Merged:
    """What a merged folder holds.

    Parameters
    ----------
    jobs : int
        Jobs of the sweep.
    found : int
        Those of them that have a result.
    failed : int
        Those of these that failed.
    others : int
        Results of jobs that the sweep does not name.
    twice : int
        Jobs of which several folders had a result.
    by_folder : dict of str to int
        Folder -> number of jobs of which it had a result.
    """

    jobs: int
    found: int
    failed: int
    others: int
    twice: int
    by_folder: dict[str, int]

    @property
    def left(self) -> int:
        """Jobs that have no result yet."""
        return self.jobs - self.found


def merge(out: ResultsFolder, parts: Sequence[ResultsFolder]) -> Merged:
    """Make one results folder of several, as if one run had written it.

    Parameters
    ----------
    out : ResultsFolder
        A folder that is not there yet, or is empty. It appears when all is in it.
    parts : sequence of ResultsFolder
        Folders of the same sweep, gathered or not. They stay as they are.

    Raises
    ------
    UpwashError
        If there is something at `out`; the parts are not of one sweep, are being written to or damaged, or do not
        agree on a job's result; or nothing can be written.
    """
    if out.path.exists() and not (out.path.is_dir() and not any(out.path.iterdir())):
        remedy = "give the name of a new one: nothing is overwritten"
        raise UpwashError(
            f"{out}: expected no such folder yet, or an empty one, found something there; {remedy}"
        )
    plan = _one_plan(parts)
    try:
        out.path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = ResultsFolder(temporary(out.path))
        unfinished.create()
        try:
            merged_ = _write(unfinished, parts, plan)
            os.rename(unfinished.path, out.path)
            sync(out.path.parent)
        finally:
            shutil.rmtree(unfinished.path, ignore_errors=True)
    except OSError as error:
        raise cannot_write(out.path, error) from error
    return merged_


def _one_plan(parts: Sequence[ResultsFolder]) -> Plan:
    """Return the plan that all parts share, or say what differs."""
    for one, second in combinations(parts, 2):
        if one.path.resolve() == second.path.resolve():
            raise UpwashError(f"{second}: expected each folder once, found it twice; name it once")
    plans = []
    for part in parts:
        part.require()
        if part.in_use():
            raise UpwashError(
                f"{part}: expected nobody to write there, found another 'upwash' at work; wait for it"
            )
        if (plan := part.plan()) is None:
            remedy = "merge folders that 'upwash run' has made"
            raise UpwashError(
                f"{part}: expected {PLAN}, which says of which sweep it is, found none; {remedy}"
            )
        plans.append(plan)
    first, columns = plans[0], dict[str, of.Column]()
    for part, plan in zip(parts, plans, strict=True):
        if plan.kind != first.kind:
            raise UpwashError(
                f"{part}: expected a {first.kind.name} sweep as in {parts[0]}, found a {plan.kind.name} one; "
                "merge like with like"
            )
        if differing := set(plan.jobs) ^ set(first.jobs):
            only_here = sorted(differing.intersection(plan.jobs))
            shown = ", ".join(sorted(differing)[:SHOWN]) + (", ..." if len(differing) > SHOWN else "")
            found = f"{len(only_here)} that it has not and {len(differing) - len(only_here)} that only it has"
            remedy = "run one sweep file, by one version of Upwash, for all parts"
            raise UpwashError(f"{part}: expected the jobs of {parts[0]}, found {found} ({shown}); {remedy}")
        for column in plan.columns:
            kept = columns.setdefault(column.name, column)
            if kept != column:
                found = f"found it as {column.unit or 'text'}: {column.description}"
                raise UpwashError(
                    f"{part}: expected column {column.name!r} as in {parts[0]}, {found}; merge results of one solver"
                )
    return replace(first, columns=tuple(columns.values()))


def _write(out: ResultsFolder, parts: Sequence[ResultsFolder], plan: Plan) -> Merged:
    """Write the rows of all parts as one, and the plan; return what there is."""
    schema, known, by_folder = plan.rows, dict[str, Known](), dict[str, int]()
    with ExitStack() as files:
        sources = []
        for part in parts:
            with _whole(part):
                sources.append(Several(sources_of(files, part, schema)))
                by_folder[str(part)] = len(set(sources[-1].ids()))
        ids = sorted({job_id for source in sources for job_id in source.ids()})
        path = out.new_part(len(ids), Shard())
        writer = TableWriter(path, schema)
        for bound in [*ids[JOBS_PER_GROUP::JOBS_PER_GROUP], None]:
            tables = []
            for part, source in zip(parts, sources, strict=True):
                with _whole(part):
                    tables.append(source.below(bound))
            _agree(parts, tables)
            rows = in_order(one_result_a_job(tables))
            writer.write(rows)
            note(known, known_of(rows))
        metadata = [one for source in sources for one in source.metadata]
        writer.close(merged_provenance(metadata, plan.text) if metadata else {})
    out.write_plan(plan)
    sync(out.parts)
    named = [known[job_id] for job_id in plan.jobs if job_id in known]
    return Merged(
        jobs=len(plan.jobs),
        found=len(named),
        failed=sum(one.status == of.FAILED for one in named),
        others=len(known) - len(named),
        twice=sum(by_folder.values()) - len(known),
        by_folder=by_folder,
    )


@contextmanager
def _whole(part: ResultsFolder) -> Iterator[None]:
    """Say in which part a file is damaged."""
    try:
        yield
    except Damaged as error:
        remedy = f"'upwash aggregate {part}' sets what is damaged aside"
        raise UpwashError(f"{part}: expected whole files, found a damaged one ({error}); {remedy}") from error


def _agree(parts: Sequence[ResultsFolder], tables: Sequence[pa.Table]) -> None:
    """Refuse two results of one job that do not agree; a failure is none."""
    ended = [_not_failed(table) for table in tables]
    for (first, one), (second, other) in combinations(zip(parts, ended, strict=True), 2):
        both = set(one.column("job_id").to_pylist()) & set(other.column("job_id").to_pylist())
        if not both:
            continue
        jobs = pa.array(sorted(both), pa.string())
        comparison = compare(only(one, jobs), only(other, jobs))
        if comparison.agrees:
            continue
        remedy = "'upwash rerun' tells which of them is repeated today"
        if comparison.differences:
            found = comparison.differences[0]
            values = f"{found.column} {found.first!r} and {found.second!r}"
            job_id = found.job_id
        else:
            job_id, values = (*comparison.only_first, *comparison.only_second)[0], "other rows"
        raise UpwashError(
            f"{first}, {second}: expected one result of job {job_id}, found two that differ: {values}; {remedy}"
        )


def _not_failed(table: pa.Table) -> pa.Table:
    failed = table.filter(pc.equal(table.column("status"), of.FAILED)).column("job_id").unique()
    return table.filter(pc.invert(pc.is_in(table.column("job_id"), failed)))
