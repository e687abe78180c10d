"""Results that were forged: one column, or several that fit one another, in a gathered folder with a summary to match.

The alterations of single columns are made from the schema, so that a new column that nothing checks fails here.
"""

import json
import math
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from conftest import Bench
from upwash import columns as of
from upwash.batch.check import check, of_rows
from upwash.batch.folder import Plan, ResultsFolder
from upwash.jobs.kinds import KINDS

pytestmark = pytest.mark.thorough

SCHEMAS = {"pair": of.SOLUTIONS_COLUMNS, "flock": of.FLOCK_COLUMNS}
SUMMARIES = {"pair": of.PAIR_SUMMARY, "flock": of.FLOCK_SUMMARY}
MADE_UP = {of.FLOAT: 1.0, of.INTEGER: 1, of.TEXT: "made up", of.TRUTH: True}


def write(folder, source, rows, kind):
    """Write a gathered folder of some rows, provenance and all, with the summary that follows from them."""
    folder.mkdir(exist_ok=True)
    table = pq.read_table(source / KINDS[kind].file)
    new = pa.Table.from_pylist(rows, schema=table.schema)
    pq.write_table(new, folder / KINDS[kind].file)
    metadata = pq.read_schema(source / "summary.parquet").metadata
    try:
        summary = KINDS[kind].summarise(new.replace_schema_metadata())
        pq.write_table(summary.replace_schema_metadata(metadata), folder / "summary.parquet")
    except (pa.ArrowException, ValueError):
        # Some rows are so wrong that no summary can be made of them.
        (folder / "summary.parquet").write_bytes((source / "summary.parquet").read_bytes())
    plan = ResultsFolder(source).plan()
    ids = sorted({row["job_id"] for row in rows} - {None})
    ResultsFolder(folder).write_plan(Plan(plan.sweep, KINDS[kind], plan.text, ids))
    return ResultsFolder(folder)


def rows_in(source, kind):
    return pq.read_table(source / KINDS[kind].file).to_pylist()


@pytest.fixture(scope="session", params=["pair", "neighbour", "all-upstream", "limit", "limit flock"])
def little(request, reproduced, flocks, converged, converged_flock, tmp_path_factory):
    """One job: a pair's without its dear optima, or a flock; its folder, its kind, a row to alter."""
    folder = tmp_path_factory.mktemp("little")
    if request.param == "limit flock":
        write(folder, converged_flock, rows_in(converged_flock, "flock"), "flock")
        return folder, "flock", 1
    if request.param == "limit":
        rows = [row for row in rows_in(converged, "pair") if row["distance_m"] is not None]
        last = next(number for number, row in enumerate(rows) if row["is_v_optimum"])
        write(folder, converged, rows[: last + 2], "pair")
        return folder, "pair", last
    if request.param == "pair":
        rows = [row for row in rows_in(reproduced, "pair") if row["objective"] == "force"]
        last = next(number for number, row in enumerate(rows) if row["is_v_optimum"])
        write(folder, reproduced, rows[: last + 2], "pair")
        return folder, "pair", last
    rows = [row for row in rows_in(flocks, "flock") if row["wake"] == request.param]
    write(folder, flocks, rows, "flock")
    return folder, "flock", 2


def alterations(column, value):
    """Give other values of a column, each of which makes a false row of a true one."""
    if column.verified == of.RANGE:
        # What is possible is all that can be told.
        return [column.least - 1]
    others = [] if value is None else [None]
    if value is None:
        return [MADE_UP[column.type]]
    if column.type == of.TRUTH:
        return [*others, not value]
    if column.type == of.TEXT:
        return [*others, f"{value}x", *([""] if value else [])]
    if column.type == of.INTEGER:
        return [*others, value + 1, value - 1]
    if math.isinf(value):
        return [*others, 1.0, -value, float("nan")]
    return [*others, 1.001 * value + 0.001, value - 1e-5 * abs(value) - 1e-6, -value - 1.0, float("nan")]


def is_refused(rows, folder, source, kind, prove=False):
    """Whether a check refuses the rows of a job, for themselves or in a folder whose summary was made to match."""
    if len({row["job_id"] for row in rows}) == 1 and of_rows(rows, ""):
        return True
    return bool(check(write(folder, source, rows, kind), prove).findings)


class TestOneColumn:
    def test_the_untouched_results_are_in_order(self, little):
        folder, _, _ = little
        assert check(ResultsFolder(folder), prove=True).findings == []

    @pytest.mark.parametrize("name", of.names(of.FLOCK_COLUMNS))
    def test_of_a_row_or_of_all_rows_of_a_job(self, little, tmp_path, name):
        source, kind, number = little
        column = next((one for one in SCHEMAS[kind] if one.name == name), None)
        if column is None:
            # A pair has no such column.
            assert kind == "pair" and of.column(name).belongs in (of.FLOCK, of.BIRD)
            return
        assert column.verified in of.VERIFIED
        rows = rows_in(source, kind)
        passed = []
        for value in alterations(column, rows[number][name]):
            some = [row | {name: value} if k == number else row for k, row in enumerate(rows)]
            forged = [some]
            if column.belongs in (of.OUTCOME, of.PROBLEM, of.SEARCH, of.FLOCK, of.JOB, of.EFFORT, of.PROOF):
                forged.append([row | {name: value} for row in rows])
            for changed in forged:
                if not is_refused(changed, tmp_path, source, kind):
                    passed.append((name, value, changed is some))
        assert not passed

    @pytest.mark.parametrize("kind", SUMMARIES)
    def test_of_the_summary_alone(self, reproduced, flocks, tmp_path, kind):
        source = {"pair": reproduced, "flock": flocks}[kind]
        rows = pq.read_table(source / "summary.parquet").to_pylist()
        for column in of.belonging(SUMMARIES[kind]):
            for value in alterations(column, rows[0][column.name]):
                folder = write(tmp_path / "forged", source, rows_in(source, kind), kind)
                schema = pq.read_schema(source / "summary.parquet")
                changed = [rows[0] | {column.name: value}, *rows[1:]]
                pq.write_table(
                    pa.Table.from_pylist(changed, schema=schema), tmp_path / "forged" / "summary.parquet"
                )
                assert check(folder).findings, (column.name, value)


@pytest.fixture(scope="session")
def job(reproduced):
    """All optima of the paper's pair for force."""
    return [row for row in rows_in(reproduced, "pair") if row["objective"] == "force"]


def is_in_v(row):
    return (row["placement"], row["tier"], row["station"]) == ("outboard", "level", "astern")


def promoted(rows):
    """Rank rows anew, as if they were all, with the gaps that follow from them."""
    in_v = next((number for number, row in enumerate(rows) if is_in_v(row)), None)
    best = {"v": None if in_v is None else rows[in_v], "global": rows[0]}
    gaps = {
        f"{region}_certified_gap": row and row["cost"] / row[f"{region}_lower_bound"] - 1.0
        for region, row in best.items()
    }
    gaps["v_region_certified_gap"] = gaps["v_certified_gap"]
    return [
        row
        | {"rank": number, "is_v_optimum": number == in_v, "is_global_optimum": number == 0}
        | {name: gap for name, gap in gaps.items() if name in row}
        for number, row in enumerate(rows)
    ]


def lowered(rows, region, tolerance=1e-4):
    """Make a region's bound and gap fit its best row, as a search would have left them that found no better."""
    label = f"is_{region}_optimum"
    cost = next(row["cost"] for row in rows if row[label])
    more = {f"{region}_lower_bound": cost / (1.0 + tolerance), f"{region}_certified_gap": tolerance}
    if region == "v":
        more["v_region_certified_gap"] = tolerance
    return [row | {name: value for name, value in more.items() if name in row} for row in rows]


def infeasible(rows):
    """Replace a job by the row of one that has no answer."""
    kept = (of.OUTCOME, of.PROBLEM, of.SEARCH, of.EFFORT, of.PROOF)
    row = dict.fromkeys(rows[0]) | {
        name: rows[0][name] for name in of.names(of.belonging(*kept)) if name in rows[0]
    }
    row |= {name: None for name in row if name.endswith(("_lower_bound", "_certified_gap"))}
    error = "no balance: no position within the bounds balances lift and thrust"
    return [row | {"status": of.INFEASIBLE, "error": error, "feasible": False, "v_wall": ""}]


class TestSeveralColumns:
    """Forgeries whose columns fit one another."""

    def found(self, tmp_path, reproduced, rows, prove=False):
        return {
            one.column for one in check(write(tmp_path / "forged", reproduced, rows, "pair"), prove).findings
        }

    def test_an_optimum_listed_twice(self, job, reproduced, tmp_path):
        assert "rank" in self.found(tmp_path, reproduced, promoted([*job[:3], job[2], *job[3:]]))

    def test_an_optimum_listed_again_a_little_beside_itself(self, job, reproduced, tmp_path):
        beside = job[2] | {"x_m": job[2]["x_m"] + 1e-9}
        assert "rank" in self.found(tmp_path, reproduced, promoted([*job[:3], beside, *job[3:]]))

    @pytest.mark.parametrize("dropped", ["is_global_optimum", "is_v_optimum"])
    def test_the_best_dropped_and_the_next_promoted(self, job, reproduced, tmp_path, dropped):
        left = [row for row in job if not row[dropped]]
        ranked = [row | {"rank": number} for number, row in enumerate(left)]
        assert self.found(tmp_path, reproduced, ranked)
        fitted = promoted(left)
        # Their gaps are open now, which may be; and with bounds that were made to fit too, nothing shows.
        region = dropped.split("_")[1]
        for rows in (fitted, lowered(fitted, region)):
            assert self.found(tmp_path, reproduced, rows) == set()
            assert self.found(tmp_path, reproduced, rows, prove=True) & {f"{region}_lower_bound", dropped}

    def test_all_in_the_v_dropped(self, job, reproduced, tmp_path):
        rows = promoted([row for row in job if not is_in_v(row)])
        nothing = {"v_lower_bound": None, "v_certified_gap": None, "v_region_certified_gap": None}
        rows = [row | {name: value for name, value in nothing.items() if name in row} for row in rows]
        assert self.found(tmp_path, reproduced, rows) == set()
        assert self.found(tmp_path, reproduced, rows, prove=True) == {"v_lower_bound"}

    @pytest.mark.parametrize("region", ["v", "global"])
    def test_a_bound_and_its_gap(self, job, reproduced, tmp_path, region):
        # A bound that no search would have left: it is true, but the proof does better.
        rows = lowered(job, region, 1e-2)
        assert self.found(tmp_path, reproduced, rows) == set()
        assert self.found(tmp_path, reproduced, rows, prove=True) == {f"{region}_certified_gap"}
        # Nor is one above the cost.
        assert self.found(tmp_path, reproduced, lowered(job, region, -1e-6))

    def test_a_bound_in_one_row(self, job, reproduced, tmp_path):
        rows = [*job[:-1], job[-1] | {"v_lower_bound": 1.0}]
        assert self.found(tmp_path, reproduced, rows) == {"v_lower_bound"}

    def test_a_solved_job_said_to_be_infeasible(self, job, reproduced, tmp_path):
        assert self.found(tmp_path, reproduced, infeasible(job)) == set()
        found = self.found(tmp_path, reproduced, infeasible(job), prove=True)
        assert found == {"v_lower_bound", "global_lower_bound"}

    def test_a_solved_job_said_to_have_a_bird_that_cannot_be(self, job, reproduced, tmp_path):
        (row,) = infeasible(job)
        rows = [row | {"error": "amplitude_m: expected at most twice the semispan, found 9"}]
        assert self.found(tmp_path, reproduced, rows) == {"error"}

    def test_what_only_a_new_search_could_tell(self, job, reproduced, tmp_path):
        # The documentation names this as not checked.
        assert self.found(tmp_path, reproduced, job[:-1], prove=True) == set()


class TestProvenance:
    """What a file says of where it comes from must be there, and must be possible."""

    @pytest.mark.parametrize("name", ["solutions.parquet", "summary.parquet"])
    @pytest.mark.parametrize(
        ("key", "value"),
        [("schema_version", None), ("schema_version", "1"), ("schema_version", "99")]
        + [("code_version", None), ("code_version", "99.0.0"), ("code_version", "mine")]
        + [("code_version", "0.1.0+nonsense"), ("sweep", None), ("sweep", "another")]
        + [("package_versions", None), ("package_versions", "{}"), ("package_versions", "[1]")]
        + [("package_versions", "no JSON")],
    )
    def test_altered_or_dropped(self, reproduced, tmp_path, name, key, value):
        folder = write(tmp_path / "forged", reproduced, rows_in(reproduced, "pair"), "pair")
        table = pq.read_table(folder.path / name)
        metadata = {k.decode(): v.decode() for k, v in table.schema.metadata.items()} | {key: value}
        kept = {k: v for k, v in metadata.items() if v is not None}
        pq.write_table(table.replace_schema_metadata(kept), folder.path / name)
        (found, *_) = check(folder).findings
        assert found.where == str(folder.path / name)
        assert (
            key in (found.column, found.message.replace(" ", "_")) or key.replace("_", " ") in found.message
        )

    def test_all_dropped(self, reproduced, tmp_path):
        folder = write(tmp_path / "forged", reproduced, rows_in(reproduced, "pair"), "pair")
        for name in ("solutions.parquet", "summary.parquet"):
            pq.write_table(pq.read_table(folder.path / name).replace_schema_metadata(), folder.path / name)
        assert "found none" in str(check(folder).findings[0])

    def test_several_versions_that_took_part(self, reproduced, tmp_path):
        folder = write(tmp_path / "forged", reproduced, rows_in(reproduced, "pair"), "pair")
        for name in ("solutions.parquet", "summary.parquet"):
            table = pq.read_table(folder.path / name)
            both = table.schema.metadata | {b"code_version": b"0.1.0, 0.1.0+1642bf8, 0.1.0+1642bf8-dirty"}
            pq.write_table(table.replace_schema_metadata(both), folder.path / name)
        assert check(folder).findings == []


class TestFailedJobs:
    def test_they_are_counted_and_said_by_exit_code_1(self, bench):
        bench.sweep("failing_or_infeasible", 3)
        bench.run(code=1)
        for gathered in (False, True):
            if gathered:
                bench("aggregate", "results/sweep")
            out, said = bench("check", "results/sweep", "--json", code=1)
            assert "3 jobs, 1 failed" in said
            assert (json.loads(out)["jobs"], json.loads(out)["failed"]) == (3, 1)

    def test_where_all_failed_nothing_is_said_to_be_in_order(self, bench):
        bench.sweep("exiting", 2)
        bench.run(code=1)
        _, said = bench("check", "results/sweep", code=1)
        assert "2 jobs, 2 failed" in said and "in order" not in said

    def test_a_finding_outweighs_them(self, bench):
        bench.sweep("failing_or_infeasible", 3)
        bench.run(code=1)
        bench.job_files()[0].unlink()
        assert "found none" in bench("check", "results/sweep", code=3)[1]


REFERENCE = Path(__file__).parents[2] / "results" / "reference"

PAIRS = """\
[[block]]
species = "dunlin"
[[block]]
species = "northern-bald-ibis"
[block.grid]
upstroke_span_ratio = [0.4, 0.7]
"""
FLOCK = """\
kind = "flock"
species = "northern-bald-ibis"
[flock]
birds = 5
shape = "alternating"
wake = "all-upstream"
"""


@pytest.fixture(scope="session")
def small(tmp_path_factory, logs):
    """Fresh results: a wall of the V that is better than its optimum, an answer, none, and a flock that ends early."""
    bench = Bench(tmp_path_factory.mktemp("small"), logs)
    for name, text in (("pairs", PAIRS), ("flock", FLOCK)):
        (bench.folder / f"{name}.toml").write_text(text)
        bench("run", f"./{name}.toml")
        bench("aggregate", f"results/{name}")
    return bench.folder / "results"


class TestProofs:
    """What is proved is proved again, from what is kept of it."""

    def test_of_the_kept_reference(self, bench):
        assert "2 jobs, all in order and proved again" in bench("check", str(REFERENCE), "--prove")[1]

    @pytest.mark.parametrize(("name", "jobs"), [("pairs", 3), ("flock", 1)])
    def test_of_a_fresh_sweep(self, bench, small, name, jobs):
        assert (
            f"{jobs} jobs, all in order and proved again" in bench("check", str(small / name), "--prove")[1]
        )

    def test_of_flocks(self, bench, flocks):
        assert "all in order and proved again" in bench("check", str(flocks), "--prove")[1]

    def test_a_summary_alone_with_a_bound_that_is_too_high(self, bench, tmp_path):
        table = pq.read_table(REFERENCE / "summary.parquet")
        rows = table.to_pylist()
        # The global optimum's cost is not in it, so that nothing but a proof can tell.
        rows[0]["global_lower_bound"] *= 1.0 + 1e-3
        rows[0]["v_gap"] = (1.0 + rows[0]["v_gap"]) / (1.0 + 1e-3) - 1.0
        pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), tmp_path / "summary.parquet")
        bench("check", str(tmp_path))
        assert "global_lower_bound" in bench("check", str(tmp_path), "--prove", code=3)[1]

    def test_the_wall_that_is_named_is_where_the_best_place_in_the_v_lies(self, small, tmp_path):
        rows = rows_in(small / "pairs", "pair")
        named = {row["v_wall"] for row in rows if row["species"] == "dunlin"}
        assert named == {"y_lower"}
        for wall in ("x_lower", "z_upper", "x_lower,y_lower"):
            changed = [row | {"v_wall": wall} if row["v_wall"] else row for row in rows]
            folder = write(tmp_path / "forged", small / "pairs", changed, "pair")
            assert check(folder).findings == []
            assert {one.column for one in check(folder, prove=True).findings} == {"v_wall"}

    def test_a_job_without_an_answer(self, small, tmp_path):
        rows = rows_in(small / "pairs", "pair")
        (number,) = (number for number, row in enumerate(rows) if row["status"] == of.INFEASIBLE)
        kept = (of.OUTCOME, of.PROBLEM, of.SEARCH, of.EFFORT, of.PROOF, of.JOB, of.OPTIMUM)
        missed = []
        for column in of.belonging(*kept):
            for value in alterations(column, rows[number][column.name]):
                changed = [rows[number] | {column.name: value}]
                prove = column.verified == of.PROVED
                if not is_refused(changed, tmp_path, small / "pairs", "pair", prove):
                    missed.append((column.name, value))
        assert not missed

    def test_a_bird_of_a_flock_said_to_have_no_place(self, flocks, tmp_path):
        rows = [row for row in rows_in(flocks, "flock") if row["wake"] == "neighbour"]
        kept = (of.OUTCOME, of.PROBLEM, of.SEARCH, of.FLOCK, of.EFFORT, of.PROOF)
        lost = dict.fromkeys(rows[3]) | {name: rows[3][name] for name in of.names(of.belonging(*kept))}
        lost |= {name: rows[3][name] for name in rows[3] if name.startswith("ahead_")}
        lost |= {name: rows[3][name] for name in ("flock_id", "bird", "leader")}
        lost |= {name: None for name in lost if name.endswith(("_lower_bound", "_certified_gap"))}
        error = (
            "no V optimum: expected one outboard, level and astern of bird 2, "
            "found a proof that lift and thrust balance at no such place"
        )
        lost |= {"status": of.INFEASIBLE, "error": error, "feasible": True}
        folder = write(tmp_path / "forged", flocks, [*rows[:3], lost], "flock")
        assert check(folder).findings == []
        assert {one.column for one in check(folder, prove=True).findings} == {"v_lower_bound"}
