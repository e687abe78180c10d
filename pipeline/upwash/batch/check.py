"""What must hold of results: of each row, of the rows of a job, and of the tables together.

Nothing here believes what a solver said of itself: forces, powers, costs and labels are computed anew.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path

import pyarrow as pa

from upwash import columns as of
from upwash.batch.folder import SUMMARY, ResultsFolder
from upwash.batch.job import Row, bounds_of, job_of, recompute
from upwash.batch.store import GATHERED, ROWS, SUMMARIES, Damaged, noticing, open_table
from upwash.batch.summary import summary_of
from upwash.errors import UpwashError
from upwash.sweep.job import BUILT_IN_SOLVER

RESIDUAL_LIMIT = 1e-9
"""Largest imbalance of lift or thrust, over weight or drag."""

RECOMPUTED = of.Agreement(relative=1e-9, absolute=1e-9)
"""How closely a stored value must agree with its recomputation, which sums in another order."""

BOUND_SLACK = 1e-9
"""How far beyond a bound a variable may lie, over the width between its bounds: rounding."""


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


Complaints = Iterator[tuple[str, str]]


def check(folder: ResultsFolder) -> tuple[int, list[Finding]]:
    """Check everything in a results folder but what its sweep no longer names.

    Returns
    -------
    tuple
        Number of jobs looked at, and what does not hold.

    Raises
    ------
    UpwashError
        If the folder holds no results.
    """
    folder.require()
    kind, findings = folder.kind(), list[Finding]()
    gathered = folder.path / GATHERED[kind]
    seen = set(_check_gathered(folder, gathered, kind, findings)) if gathered.exists() else set()
    for path in (*folder.part_files(), *map(folder.job_file, sorted(folder.job_ids()))):
        for table in _pieces(path, ROWS[kind], findings):
            for job_id, rows in groupby(table.to_pylist(), key=lambda row: row["job_id"]):
                findings += of_rows(list(rows), str(path))
                seen.add(job_id)
    if not seen and not findings:
        for table in _pieces(folder.path / SUMMARY, SUMMARIES[kind], findings):
            for row in table.to_pylist():
                findings += of_rows([row], SUMMARY, all_optima=False)
                seen.add(row["job_id"])
    plan = folder.plan()
    for job_id in plan.jobs if plan else ():
        if job_id not in seen:
            findings.append(
                Finding(f"job {job_id}", "status", "expected a result, found none; run the sweep")
            )
    return len(seen), findings


def _check_gathered(folder: ResultsFolder, path: Path, kind: str, findings: list[Finding]) -> Iterator[str]:
    """Check the gathered rows and, beside them, the summary; give each job's id."""
    summaries = pa.concat_tables(
        [SUMMARIES[kind].empty_table(), *_pieces(folder.path / SUMMARY, SUMMARIES[kind], findings)],
        promote_options="default",
    )
    place, last = 0, ""
    for table in _pieces(path, ROWS[kind], findings):
        for job_id, rows in groupby(table.to_pylist(), key=lambda row: row["job_id"]):
            if job_id <= last:
                found = "expected once, in the order of the ids, found again or too late"
                findings.append(Finding(f"job {job_id}", "job_id", found))
            last = job_id
            findings += of_rows(list(rows), path.name)
            yield job_id
        expected = summary_of(table, kind)
        findings += _unlike(expected, summaries.slice(place, expected.num_rows))
        place += expected.num_rows
    if summaries.num_rows > place:
        found = f"found {summaries.num_rows} rows, expected {place}"
        findings.append(Finding(SUMMARY, "job_id", f"{found}; gather anew by 'upwash aggregate'"))


def _pieces(path: Path, schema: pa.Schema, findings: list[Finding]) -> Iterator[pa.Table]:
    """Give a table row group by row group; a damaged one is a finding."""
    if not path.exists():
        findings.append(Finding(str(path), "", "expected this file, found none; run 'upwash aggregate'"))
        return
    try:
        with open_table(path, schema) as file:
            for number in range(file.num_row_groups):
                with noticing(path):
                    table = file.read_row_group(number, use_threads=False)
                yield table.replace_schema_metadata()
    except (Damaged, UpwashError) as error:
        findings.append(Finding(str(path), "", str(error).removeprefix(f"{path}: ")))


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


def of_rows(rows: Sequence[Row], place: str, all_optima: bool = True) -> list[Finding]:
    """Check the rows of one job.

    Parameters
    ----------
    rows : sequence of dict
        All of them, in order.
    place : str
        Where they stand, for the findings.
    all_optima : bool
        Whether these are all of the job's optima, and not its summary.
    """
    where = f"job {rows[0]['job_id']}"

    def findings(checks: Iterable[Check]) -> list[Finding]:
        return [Finding(where, name, f"{message} ({place})") for one in checks for name, message in one(rows)]

    # What is absent or not finite cannot be computed with.
    wrong = findings(FORM)
    if wrong or rows[0]["cost"] is None:
        return wrong
    whole = (ranks if rows[0]["kind"] == "pair" else chain,) if all_optima else ()
    return findings((*CONTENT, *whole))


def identity(rows: Sequence[Row]) -> Complaints:
    """The id follows from the inputs and the model's version."""
    for row in rows:
        if row["job_id"] != rows[0]["job_id"] or row["status"] not in of.STATUSES:
            yield "status", f"expected one of {', '.join(of.STATUSES)}, found {row['status']!r}"
    for row in rows:
        expected = job_of(row).job_id
        if row["job_id"] != expected:
            yield "job_id", f"expected {expected} by its inputs and this model's version, found another"
            break


def outcome(rows: Sequence[Row]) -> Complaints:
    """A solved row has a solution and no error; any other has an error and no solution."""
    for row in rows:
        if row["status"] == of.SOLVED:
            if row["error"] is not None:
                yield "error", f"expected none in a solved row, found {row['error']!r}"
            has_none = row["rank"] is None and "optima_found" in row
            for column in of.COLUMNS if not has_none else ():
                if row.get(column.name, "") is None and not _may_lack(row, column):
                    yield column.name, "expected a value in a solved row, found none"
        else:
            if not row["error"]:
                yield "error", f"expected to learn why the row is {row['status']}, found nothing"
            if row["x_m"] is not None:
                yield "x_m", f"expected no solution in a row that is {row['status']}, found one"


def _may_lack(row: Row, column: of.Column) -> bool:
    leads, is_own = row.get("bird") == 1, row["solver"] != BUILT_IN_SOLVER
    return {
        of.NEVER: False,
        of.LEADING: leads,
        of.UNREPORTED: leads or is_own,
        of.SOMETIMES: True,
    }[column.absent]


def numbers(rows: Sequence[Row]) -> Complaints:
    """Every number is finite."""
    for row in rows:
        for name, value in row.items():
            if isinstance(value, float) and not math.isfinite(value):
                yield name, f"expected a finite number, found {value}"


def residuals(rows: Sequence[Row]) -> Complaints:
    """Lift and thrust balance."""
    for row in rows:
        for name in ("residual_lift", "residual_thrust"):
            if abs(row[name] or 0.0) > RESIDUAL_LIMIT:
                yield name, f"expected at most {RESIDUAL_LIMIT:g}, found {row[name]:.3g}"


def bounds(rows: Sequence[Row]) -> Complaints:
    """Every variable lies within its bounds."""
    for row in rows:
        if row["x_m"] is None:
            continue
        for name, (low, high) in bounds_of(row).items():
            slack = BOUND_SLACK * (high - low)
            if not low - slack <= row[name] <= high + slack:
                yield name, f"expected {low:.6g} to {high:.6g}, found {row[name]:.9g}"


def certificates(rows: Sequence[Row]) -> Complaints:
    """No cost is below its proved bound, and each gap is that between the two."""
    for row in rows:
        region, own = row["v_region_certified_gap"], row["v_certified_gap"]
        if own is not None and (
            region is None
            or region > own
            or (region != own and not row["v_wall"])
            or region < -RECOMPUTED.absolute
        ):
            yield (
                "v_region_certified_gap",
                f"expected v_certified_gap, {own}, or less if v_wall is named, found {region}",
            )
        for proof, label in (("v", "is_v_optimum"), ("global", "is_global_optimum")):
            bound, gap = row[f"{proof}_lower_bound"], row[f"{proof}_certified_gap"]
            if bound is None or not row[label]:
                continue
            if row["cost"] < bound * (1.0 - RECOMPUTED.relative):
                yield "cost", f"expected no less than the proved bound {bound:.12g}, found {row['cost']:.12g}"
            if gap is None or abs(row["cost"] / bound - 1.0 - gap) > RECOMPUTED.absolute:
                expected = row["cost"] / bound - 1.0
                yield (
                    f"{proof}_certified_gap",
                    f"expected cost over bound less 1, {expected:.3g}, found {gap}",
                )


def ranks(rows: Sequence[Row]) -> Complaints:
    """Optima are ranked by cost; the first is the global one, the best of the V formations the V optimum."""
    best_v = next((row["rank"] for row in rows if _is_v_formation(row)), None)
    for number, row in enumerate(rows):
        if row["rank"] != number:
            yield "rank", f"expected {number}, found {row['rank']}"
        if number and row["cost"] < rows[number - 1]["cost"]:
            yield "cost", f"expected no less than that of rank {number - 1}, found {row['cost']:.12g}"
        for name, expected in (("is_global_optimum", number == 0), ("is_v_optimum", number == best_v)):
            if row[name] is not expected:
                yield name, f"expected {expected} at rank {number}, found {row[name]}"


def chain(rows: Sequence[Row]) -> Complaints:
    """A flock's birds are numbered from 1, and each stands where it follows its leader."""
    places = {row["bird"]: row for row in rows}
    for number, row in enumerate(rows, start=1):
        if row["bird"] != number:
            yield "bird", f"expected {number}, found {row['bird']}"
        leader = places.get(row["leader"])
        if leader is None or number == 1:
            continue
        for name in ("amplitude_m", "upstroke_span_ratio"):
            if row[f"ahead_{name}"] != leader[name]:
                expected = f"expected {leader[name]!r}, what bird {row['leader']} does"
                yield f"ahead_{name}", f"{expected}, found {row[f'ahead_{name}']!r}"
        if row["status"] != of.SOLVED:
            continue
        for axis in "xyz":
            name, expected = f"{axis}_flock_m", leader[f"{axis}_flock_m"] + row[f"{axis}_m"]
            if abs(row[name] - expected) > RECOMPUTED.absolute:
                yield name, f"expected {expected:.9g} from its leader's place, found {row[name]:.9g}"
        lag = row["phase_flock"] - leader["phase_flock"] - row["phase"]
        if abs(lag - round(lag)) > RECOMPUTED.absolute:
            yield (
                "phase_flock",
                f"expected its leader's plus {row['phase']:.9g}, found {row['phase_flock']:.9g}",
            )


def recomputed(rows: Sequence[Row]) -> Complaints:
    """Forces, powers, savings, costs and labels are what the inputs and the solution make them."""
    try:
        follows = recompute(rows)
    except ValueError as error:
        yield "", f"expected a pose that a bird can have, found one that it cannot: {error}"
        return
    for row, expected in zip(rows, follows, strict=True):
        for name, value in expected.items():
            if isinstance(value, str):
                if row[name] != value:
                    yield name, f"expected {value} by recomputation, found {row[name]!r}"
            elif not RECOMPUTED.holds(row[name], value):
                yield name, f"expected {value:.12g} by recomputation, found {row[name]:.12g}"


def _is_v_formation(row: Row) -> bool:
    return (row["placement"], row["tier"], row["station"]) == ("outboard", "level", "astern")


Check = Callable[[Sequence[Row]], Complaints]
FORM: tuple[Check, ...] = (identity, outcome, numbers)
CONTENT: tuple[Check, ...] = (residuals, bounds, certificates, recomputed)
