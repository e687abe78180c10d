"""What must hold of a results folder: of the rows of each job, of the tables together, and of where they come from."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

import pyarrow as pa

from upwash import columns as of
from upwash.batch.folder import SUMMARY, ResultsFolder
from upwash.batch.provenance import misstated
from upwash.batch.row_checks import ASKED_FOR, BOUNDS, CONTENT, FORM, WHOLE
from upwash.batch.store import Damaged, brought_up, metadata_of, noticing, open_table
from upwash.errors import UpwashError
from upwash.jobs.kind import Kind
from upwash.jobs.verify import disproved


@dataclass(frozen=True)
class Finding:
    """Something that does not hold.

    Parameters
    ----------
    where : str
        Job, or file.
    column : str
        Column, or "".
    message : str
        What was expected, and what was found.
    """

    where: str
    column: str
    message: str

    def __str__(self) -> str:
        column = f", {self.column}" if self.column else ""
        return f"{self.where}{column}: {self.message}"


@dataclass
class Checked:
    """What came of a check.

    Parameters
    ----------
    jobs : set of str
        Ids of the jobs looked at.
    failed : set of str
        Those of them that failed, which is no fault of the results.
    findings : list of Finding
        What does not hold.
    """

    jobs: set[str] = field(default_factory=set)
    failed: set[str] = field(default_factory=set)
    findings: list[Finding] = field(default_factory=list)

    def add(self, where: str, complaints: Iterable[tuple[str, str]], place: str = "") -> None:
        """Add what does not hold somewhere."""
        told = f" ({place})" if place else ""
        self.findings += [Finding(where, name, f"{message}{told}") for name, message in complaints]


def check(folder: ResultsFolder, prove: bool = False) -> Checked:
    """Check everything in a results folder but what its sweep no longer names.

    Parameters
    ----------
    folder : ResultsFolder
        The folder.
    prove : bool
        Whether to repeat the proofs, from the stored rows alone.

    Raises
    ------
    UpwashError
        If the folder holds no results.
    """
    folder.require()
    kind, plan, checked = folder.kind(), folder.plan(), Checked()
    reader = _Reader(checked, plan.text if plan else None)
    gathered = folder.path / kind.file
    if gathered.exists():
        _check_gathered(folder, gathered, kind, reader, prove)
    for path in (*folder.part_files(), *map(folder.job_file, sorted(folder.job_ids()))):
        for table in reader.pieces(path, kind.rows):
            for _, rows in groupby(table.to_pylist(), key=lambda row: row["job_id"]):
                _check_job(list(rows), str(path), checked, prove)
    if not checked.jobs and not checked.findings:
        for table in reader.pieces(folder.path / SUMMARY, kind.summary):
            for row in table.to_pylist():
                _check_job([row], SUMMARY, checked, prove, all_optima=False)
    for job_id in plan.jobs if plan else ():
        if job_id not in checked.jobs:
            checked.add(f"job {job_id}", [("status", "expected a result, found none; run the sweep")])
    return checked


def _check_gathered(
    folder: ResultsFolder, path: Path, kind: type[Kind], reader: _Reader, prove: bool
) -> None:
    """Check the gathered rows and, beside them, the summary."""
    checked = reader.checked
    summaries = pa.concat_tables(
        [kind.summary.empty_table(), *reader.pieces(folder.path / SUMMARY, kind.summary)],
        promote_options="default",
    )
    place, last = 0, ""
    for table in reader.pieces(path, kind.rows):
        before, jobs = len(checked.findings), 0
        for job_id, rows in groupby(table.to_pylist(), key=lambda row: row["job_id"]):
            if job_id is None or job_id <= last:
                found = "expected once, in the order of the ids, found again or too late"
                checked.add(f"job {job_id}", [("job_id", found)])
            last, jobs = job_id or last, jobs + 1
            _check_job(list(rows), path.name, checked, prove)
        # Rows that are wrong may have no summary.
        if len(checked.findings) == before:
            checked.findings += _unlike(kind.summarise(table), summaries.slice(place, jobs))
        place += jobs
    if summaries.num_rows > place:
        found = f"found {summaries.num_rows} rows, expected {place}"
        checked.add(SUMMARY, [("job_id", f"{found}; gather anew by 'upwash aggregate'")])


@dataclass(frozen=True)
class _Reader:
    """Reads files; what is wrong with one is a finding."""

    checked: Checked
    sweep: str | None

    def pieces(self, path: Path, schema: pa.Schema) -> Iterator[pa.Table]:
        """Give a table row group by row group, after a look at where it says that it comes from."""
        if not path.exists():
            self.checked.add(str(path), [("", "expected this file, found none; run 'upwash aggregate'")])
            return
        try:
            with open_table(path, schema) as file:
                self.checked.add(str(path), misstated(metadata_of(file.schema_arrow), self.sweep))
                for number in range(file.num_row_groups):
                    with noticing(path):
                        table = file.read_row_group(number, use_threads=False)
                    yield brought_up(table, schema).replace_schema_metadata()
        except (Damaged, UpwashError) as error:
            self.checked.add(str(path), [("", str(error).removeprefix(f"{path}: "))])


def _check_job(
    rows: list[of.Stored], place: str, checked: Checked, prove: bool, all_optima: bool = True
) -> None:
    job_id = rows[0]["job_id"]
    found = of_rows(rows, place, all_optima)
    if prove and not found:
        checked.add(f"job {job_id}", disproved(rows), place)
    checked.findings += found
    checked.jobs.add(job_id)
    if any(row["status"] == of.FAILED for row in rows):
        checked.failed.add(job_id)


def _unlike(expected: pa.Table, found: pa.Table) -> list[Finding]:
    """Compare a piece of the summary with what its rows come to."""
    if expected.equals(found):
        return []
    for one, other in zip(expected.to_pylist(), found.to_pylist(), strict=False):
        for name in expected.column_names:
            if one[name] != other[name]:
                where = f"job {one['job_id']}"
                message = f"{SUMMARY}: expected {one[name]!r} from its rows, found {other[name]!r}"
                return [Finding(where, name, f"{message}; gather anew by 'upwash aggregate'")]
    missing = expected.column("job_id")[found.num_rows].as_py()
    return [Finding(f"job {missing}", "job_id", f"expected a row in {SUMMARY}, found none")]


def of_rows(rows: Sequence[of.Stored], place: str, all_optima: bool = True) -> list[Finding]:
    """Check the rows of one job.

    Parameters
    ----------
    rows : sequence of mapping
        All of them, in order.
    place : str
        Where they stand, for the findings.
    all_optima : bool
        Whether these are all of the job's optima, and not its summary.
    """
    checked = Checked()
    where = f"job {rows[0]['job_id']}"
    whole = WHOLE if all_optima else ()
    # What is of another job, absent, not finite or out of its bounds cannot be computed with.
    for some in (ASKED_FOR, FORM, BOUNDS, (*CONTENT, *whole)):
        for one in some:
            try:
                checked.add(where, list(one(rows)), place)
            except ValueError as error:
                found = f"expected a pose that a bird can have, found one that it cannot: {error}"
                checked.add(where, [("", found)], place)
        if checked.findings:
            break
    return checked.findings
