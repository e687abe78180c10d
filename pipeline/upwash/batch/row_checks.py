"""What must hold of the rows of one job: each by itself, and all of them together.

Nothing here believes what a solver said of itself: what follows from the stored inputs and places is computed anew.
`upwash.columns` says of each column which of these checks answers for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from upwash import columns as of
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.job import BUILT_IN_SOLVER, job_of
from upwash.jobs.kinds import KINDS
from upwash.jobs.pair import Pair
from upwash.jobs.stored import AGREEMENT, Complaints, beyond_spacing, is_v_formation, unlike
from upwash.jobs.verify import bounds_of, evidence_of, makes_a_bird, recompute, walls, why_infeasible

RESIDUAL_LIMIT = 1e-9
"""Largest imbalance of lift or thrust, over weight or drag."""

EXAMINED = of.Agreement(relative=1e-6, absolute=1e-8)
"""How closely stored evidence must agree with what is found anew at a place that was rounded to be stored."""

GAP_ROUNDING = 1e-6
"""Share of the tolerance by which rounding may make the gap of a proof that closed less."""

RISES = of.Agreement(relative=5e-6, absolute=5e-7)
"""The same of slopes and curvatures, which are quotients of differences."""

BOUND_SLACK = 1e-9
"""How far beyond a bound a variable may lie, over the width between its bounds: rounding."""

NOTHING_FOUND = of.names(of.belonging(of.JOB, of.OPTIMUM))
DERIVED = of.names(column for column in of.COLUMNS if column.verified == of.DERIVED)
ASKED = {
    name: of.names(column for column in columns if column.verified == of.IDENTITY)
    for name, columns in ((Pair.name, of.SUMMARY_COLUMNS), (Flock.name, of.FLOCK_COLUMNS))
}


def identity(rows: Sequence[of.Stored]) -> Complaints:
    """All rows are of one job, whose id follows from its inputs and the model's version."""
    first, asked = rows[0], ASKED.get(rows[0]["kind"], ())
    for row in rows:
        if row["status"] not in of.STATUSES:
            yield "status", f"expected one of {', '.join(of.STATUSES)}, found {row['status']!r}"
        for name in asked:
            if name in row and row[name] != first[name]:
                yield name, f"expected {first[name]!r} as in the job's first row, found {row[name]!r}"
        if row.get("flock_id", row["job_id"]) != row["job_id"]:
            yield "flock_id", f"expected the job's id, found {row['flock_id']!r}"
    for name in asked:
        if name in first and first[name] is None and of.column(name).absent == of.NEVER:
            yield name, "expected an input of the job, found none"
    try:
        job = job_of(first)
    except UpwashError as error:
        yield "job_id", f"expected the id of a job, found one of none: {error}"
        return
    if first["job_id"] != job.job_id:
        yield "job_id", f"expected {job.job_id} by its inputs and this model's version, found another"
    inputs = job.inputs()
    for name in DERIVED:
        for row in rows:
            if row[name] != inputs[name]:
                yield name, f"expected {inputs[name]!r} by the job's inputs, found {row[name]!r}"


def outcome(rows: Sequence[of.Stored]) -> Complaints:
    """A solved row has a solution and no error; any other has an error, and nothing was found in it."""
    for number, row in enumerate(rows):
        if row["status"] == of.SOLVED:
            if row["error"] is not None:
                yield "error", f"expected none in a solved row, found {row['error']!r}"
            has_none = row.get("rank", 0) is None and "optima_found" in row
            for column in of.COLUMNS if not has_none else ():
                if row.get(column.name, "") is None and not (
                    _may_lack(row, column) or _is_older(row, column)
                ):
                    yield column.name, "expected a value in a solved row, found none"
                if (
                    _leads(row)
                    and column.absent not in (of.NEVER, of.UNASKED)
                    and row.get(column.name) is not None
                ):
                    yield column.name, f"expected none of a bird that leads, found {row[column.name]!r}"
            continue
        if not row["error"]:
            yield "error", f"expected to learn why the row is {row['status']}, found nothing"
        for name in NOTHING_FOUND:
            if row.get(name) is not None:
                yield name, f"expected no solution in a row that is {row['status']}, found {row[name]!r}"
        is_last = number == len(rows) - 1
        if not is_last or (number and _is_one_problem(row)):
            yield "status", f"expected nothing beside a row that is {row['status']}, found other rows"
        if row["status"] == of.INFEASIBLE and row["solver"] == BUILT_IN_SOLVER and "birds_placed" not in row:
            expected = why_infeasible(row)
            if expected is None:
                yield "feasible", "expected a proof, or the lack of one, stated with it, found nothing"
            elif row["error"] != expected:
                yield "error", f"expected {expected!r} by inputs and proof, found {row['error']!r}"


def _is_older(row: of.Stored, column: of.Column) -> bool:
    """Whether a row lacks a column since it was written before there was one: then it lacks all that came with it."""
    came = (one.name for one in of.COLUMNS if one.since == column.since and one.verified == of.EVIDENCE)
    return column.since > of.OLDEST_READ and all(row.get(name) is None for name in came)


def _is_one_problem(row: of.Stored) -> bool:
    return KINDS[row["kind"]].is_one_problem


def _leads(row: of.Stored) -> bool:
    return row.get("bird") == 1


def _may_lack(row: of.Stored, column: of.Column) -> bool:
    is_own = row["solver"] != BUILT_IN_SOLVER
    return {
        of.NEVER: False,
        of.LEADING: _leads(row),
        of.UNREPORTED: _leads(row) or is_own,
        of.UNASKED: True,
        of.SOMETIMES: True,
    }[column.absent]


def numbers(rows: Sequence[of.Stored]) -> Complaints:
    """Every number is finite, and possible."""
    for row in rows:
        for name, value in row.items():
            if isinstance(value, float) and not math.isfinite(value) and value not in WORDS.get(name, ()):
                yield name, f"expected a finite number, found {value}"
            elif (least := LEAST.get(name)) is not None and value is not None and value < least:
                yield name, f"expected at least {least:g}, found {value}"


WORDS = {column.name: column.words for column in of.COLUMNS if column.words}
LEAST = {column.name: column.least for column in of.COLUMNS if column.least is not None}


def residuals(rows: Sequence[of.Stored]) -> Complaints:
    """Lift and thrust balance."""
    for row in rows:
        for name in ("residual_lift", "residual_thrust"):
            if abs(row.get(name) or 0.0) > RESIDUAL_LIMIT:
                yield name, f"expected at most {RESIDUAL_LIMIT:g}, found {row[name]:.3g}"


def bounds(rows: Sequence[of.Stored]) -> Complaints:
    """Every variable lies within its bounds."""
    for row, bounds in zip(rows, bounds_of(rows), strict=True):
        for name, (low, high) in bounds.items():
            slack = BOUND_SLACK * (high - low)
            if row[name] is not None and not low - slack <= row[name] <= high + slack:
                yield name, f"expected {low:.6g} to {high:.6g}, found {row[name]:.9g}"
        yield from beyond_spacing(row)


def recomputed(rows: Sequence[of.Stored]) -> Complaints:
    """Forces, powers, savings, costs and labels are what the inputs and the solution make them."""
    for row, expected in zip(rows, recompute(rows), strict=True):
        yield from unlike(row, expected, AGREEMENT, "by recomputation")


def examined(rows: Sequence[of.Stored]) -> Complaints:
    """Each place is an optimum, and the evidence for it is what is found there."""
    for row, expected in zip(rows, evidence_of(rows), strict=True):
        stated = {name: value for name, value in expected.items() if _is_stated(row, name)}
        for agreement, is_rise in ((EXAMINED, False), (RISES, True)):
            some = {
                name: value
                for name, value in stated.items()
                if (of.column(name).agreement == of.RISE) == is_rise
            }
            yield from unlike(row, some, agreement, "at the place that is stored")


def _is_stated(row: of.Stored, name: str) -> bool:
    if row[name] is not None:
        return True
    return row["solver"] == BUILT_IN_SOLVER and not _is_older(row, of.column(name))


def proofs(rows: Sequence[of.Stored]) -> Complaints:
    """The proof is one, no cost is below its bounds, and each gap is that between a cost and its bound."""
    if _is_one_problem(rows[0]):
        for name in of.names(of.belonging(of.PROOF, of.EFFORT)):
            if any(row[name] != rows[0][name] for row in rows):
                yield name, "expected the same in all rows of a job, found several values"
    for row in rows:
        if "v_wall" in row and row["status"] != of.FAILED and not _leads(row):
            yield from _bounded(row, "v", is_v_formation(row))
            yield from _bounded(row, "global", row["rank"] is not None)
            yield from _in_the_v(row, rows)
            # A flock's bird may have optima, and none in the V.
            is_told = row["solver"] == BUILT_IN_SOLVER and (
                _is_one_problem(row) or row["status"] == of.SOLVED
            )
            # Where the inputs make no bird there is nothing to prove.
            expected = row["status"] == of.SOLVED if makes_a_bird(row) else None
            if is_told and row["feasible"] is not expected:
                yield (
                    "feasible",
                    f"expected {expected} in a row that is {row['status']}, found {row['feasible']}",
                )


def _bounded(row: of.Stored, region: str, is_covered: bool) -> Complaints:
    """A region's bound is below the cost of an optimum in it, and the best one's gap is the one between them."""
    bound, gap = row[f"{region}_lower_bound"], row[f"{region}_certified_gap"]
    if bound is None:
        # A flock's bird with several ahead is proved in its V region alone.
        if is_covered and row["solver"] == BUILT_IN_SOLVER and (region == "v" or _is_one_problem(row)):
            yield f"{region}_lower_bound", "expected a bound, as there is such a follower, found none"
        if gap is not None:
            yield f"{region}_certified_gap", f"expected none without a bound, found {gap}"
        return
    if is_covered and row["cost"] < bound * (1.0 - AGREEMENT.relative):
        yield "cost", f"expected no less than the proved bound {bound:.12g}, found {row['cost']:.12g}"
    if row[f"is_{region}_optimum"]:
        expected = row["cost"] / bound - 1.0 if bound else math.inf
        if gap is None or not abs(expected - gap) <= AGREEMENT.absolute:
            yield f"{region}_certified_gap", f"expected cost over bound less 1, {expected:.3g}, found {gap}"


def _in_the_v(row: of.Stored, rows: Sequence[of.Stored]) -> Complaints:
    """The best place in the V is the V optimum, or costs less and lies on a wall that is named or is held by steps."""
    best, own, wall = row["v_region_certified_gap"], row["v_certified_gap"], row["v_wall"]
    if row["solver"] != BUILT_IN_SOLVER and wall is None:
        return
    if not wall and best != own and not _is_held_by_steps(row, rows):
        yield (
            "v_region_certified_gap",
            f"expected v_certified_gap, {own}, as no v_wall is named, found {best}",
        )
    if wall and (best is None or best < -AGREEMENT.absolute or (own is not None and best >= own)):
        yield "v_region_certified_gap", f"expected less than v_certified_gap, {own}, on a wall, found {best}"
    if wall and not set(wall.split(",")) <= set(walls()):
        yield "v_wall", f"expected some of {', '.join(walls())}, found {wall!r}"


def _is_held_by_steps(row: of.Stored, rows: Sequence[of.Stored]) -> bool:
    """Whether the best place in the V is an optimum that finer steps of the wingbeat would not leave there.

    Of a flock's bird no optimum is kept but the V optimum; a proof that closed left just the gap that was asked for.
    """
    best, own, bound = row["v_region_certified_gap"], row["v_certified_gap"], row["v_lower_bound"]
    if row["wavelengths"] != math.inf or best is None or not bound or (own is not None and best > own):
        return False
    if not _is_one_problem(row):
        return bool(best > row["tolerance"] * (1.0 - GAP_ROUNDING))
    others = (one for one in rows if is_v_formation(one) and not one["is_v_optimum"])
    return any(abs(one["cost"] / bound - 1.0 - best) <= AGREEMENT.absolute for one in others)


def numbered(rows: Sequence[of.Stored]) -> Complaints:
    """A flock's birds are numbered from 1; all are there, or the last has no place."""
    # A flock whose first bird cannot be has no birds.
    if "bird" not in rows[0] or (rows[0]["bird"] is None and rows[0]["status"] != of.SOLVED):
        return
    for number, row in enumerate(rows, start=1):
        if row["bird"] != number:
            yield "bird", f"expected {number}, found {row['bird']}"
    if len(rows) > rows[0]["birds"] or (len(rows) < rows[0]["birds"] and rows[-1]["status"] == of.SOLVED):
        yield "bird", f"expected {rows[0]['birds']} birds, or a last one without a place, found {len(rows)}"


def together(rows: Sequence[of.Stored]) -> Complaints:
    """All rows of a job fit together, as its kind says."""
    job = job_of(rows[0])
    yield from job.kind.whole(job, rows)


Check = Callable[[Sequence[of.Stored]], Complaints]
ASKED_FOR: tuple[Check, ...] = (identity,)
FORM: tuple[Check, ...] = (outcome, numbers, numbered)
BOUNDS: tuple[Check, ...] = (bounds,)
CONTENT: tuple[Check, ...] = (residuals, proofs, recomputed, examined)
WHOLE: tuple[Check, ...] = (together,)
