"""Showing, repeating and comparing stored results."""

import json
from collections import Counter

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from upwash import columns as of
from upwash.batch.compare import excess


def copied(reproduced, folder, change=lambda row: None):
    """Copy a summary, with each row changed."""
    folder.mkdir()
    table = pq.read_table(reproduced / "summary.parquet")
    rows = table.to_pylist()
    for row in rows:
        change(row)
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), folder / "summary.parquet")
    return str(folder)


class TestDiff:
    def test_a_result_agrees_with_itself(self, bench, reproduced, tmp_path):
        out, said = bench("diff", str(reproduced), copied(reproduced, tmp_path / "same"))
        assert out == "" and said.endswith("agree in 2 rows\n")

    def test_jobs_are_the_same_by_their_inputs_and_not_by_their_ids(self, bench, reproduced, tmp_path):
        def renamed(row):
            row["job_id"], row["seed"] = "0" * 16, 5

        out, _ = bench("diff", str(reproduced), copied(reproduced, tmp_path / "renamed", renamed), code=3)
        # The seed is an input of the solver, not of the physics: it differs, and is said to.
        assert [line.split(":")[0] for line in out.splitlines()] == ["seed"]

    def test_each_column_has_a_tolerance_of_its_own(self, bench, reproduced, tmp_path):
        def slightly(row):
            row["x_m"] += 5e-7
            row["solve_time_s"] *= 10
            row["hits"] += 3

        bench("diff", str(reproduced), copied(reproduced, tmp_path / "slightly", slightly))

        def more(row):
            row["x_m"] += 5e-6
            row["placement"] = "inboard"

        out, said = bench("diff", str(reproduced), copied(reproduced, tmp_path / "more", more), code=3)
        assert [line.split(":")[0] for line in out.splitlines()] == ["x_m", "placement"]
        assert "2 of 2 rows" in out and "allowed 1e-06 relative, 1e-06 absolute" in out
        assert len(said.splitlines()) == 1 and said.startswith("Error: ")

    def test_jobs_that_only_one_has_are_listed(self, bench, reproduced, tmp_path):
        def heavier(row):
            row["mass_kg"] += 0.1 * (row["objective"] == "power")

        other = copied(reproduced, tmp_path / "other", heavier)
        out, _ = bench("diff", str(reproduced), other, code=3)
        assert out.splitlines()[0].startswith(f"only in {reproduced}: 1 jobs")
        assert out.splitlines()[1].startswith(f"only in {other}: 1 jobs")
        found = json.loads(bench("diff", str(reproduced), other, "--json", code=3)[0])
        assert (found[0]["rows"], len(found[0]["only_first"]), found[0]["differences"]) == (1, 1, [])

    def test_results_that_are_not_gathered_cannot_be_compared(self, bench, reproduced):
        bench.sweep("trivial", 2)
        bench.run()
        _, said = bench("diff", str(reproduced), "results/sweep", code=2)
        assert "upwash aggregate results/sweep" in said and len(said.splitlines()) == 1

    def test_jobs_that_were_done_since_are_not_passed_over(self, bench):
        bench.sweep("trivial", 2)
        bench.run()
        bench("aggregate", "results/sweep")
        bench("diff", "results/sweep", "results/sweep")
        bench.sweep("trivial", 3)
        bench.run()
        _, said = bench("diff", "results/sweep", "results/sweep", code=2)
        assert "found 1 not gathered yet" in said and len(said.splitlines()) == 1

    @pytest.mark.parametrize("column", of.COLUMNS, ids=of.names(of.COLUMNS))
    def test_absence_and_presence_never_agree(self, column):
        value = {of.FLOAT: 1.0, of.INTEGER: 1, of.TEXT: "a", of.TRUTH: True}[column.type]
        assert excess([None, value, None], [value, value, None], column).tolist() == [float("inf"), 0.0, 0.0]


class TestShow:
    def test_a_job_by_the_beginning_of_its_id(self, bench, reproduced):
        out, _ = bench("show", str(reproduced), "20f1")
        lines = {line.split()[0]: line.split()[1:] for line in out.splitlines()}
        assert lines["mass_kg"] == ["1.3", "kg"]
        assert lines["objective"] == ["force"]
        rows = json.loads(bench("show", str(reproduced), "20f1", "--json")[0])
        assert [row["rank"] for row in rows] == list(range(len(rows)))
        assert len([line for line in out.splitlines() if line.endswith(("astern", "abreast"))]) == len(rows)

    def test_each_cell_is_what_json_says(self, bench, reproduced):
        out, _ = bench("show", str(reproduced), "20f1")
        rows = json.loads(bench("show", str(reproduced), "20f1", "--json")[0])
        lines = [line.split() for line in out.splitlines()]
        start = next(number for number, line in enumerate(lines) if line[0] == "rank")
        names, cells = lines[start], lines[start + 1 :]
        assert {"is_v_optimum", "x_m", "placement"} <= set(names) and len(cells) == len(rows)
        for line, row in zip(cells, rows, strict=True):
            for name, cell in zip(names, line, strict=True):
                value = row[name]
                if isinstance(value, bool):
                    assert cell == ("yes" if value else "no"), name
                elif isinstance(value, float):
                    assert float(cell) == pytest.approx(value, rel=1e-5), name
                else:
                    assert cell == ("-" if value is None else str(value)), name

    def test_a_job_that_has_only_its_own_file(self, bench):
        bench.sweep("failing_when_heavy", 2)
        bench.run(code=1)
        failed = [path.stem for path in bench.job_files()]
        shown = "".join(bench("show", "results/sweep", job)[0] for job in failed)
        assert "ZeroDivisionError: a bird too heavy" in shown

    @pytest.mark.parametrize("beginning", ["", "zz", "20f1cc3353d94ba4x", "../plan"])
    def test_no_such_job(self, bench, reproduced, beginning):
        _, said = bench("show", str(reproduced), beginning, code=2)
        assert len(said.splitlines()) == 1 and "expected one job whose id begins with" in said

    def test_a_beginning_that_several_share(self, bench):
        bench.sweep("trivial", 30)
        bench.run()
        # Of thirty ids some two begin with the same of sixteen digits.
        ((shared, _), *_) = Counter(path.stem[0] for path in bench.job_files()).most_common()
        _, said = bench("show", "results/sweep", shared, code=2)
        assert "give more of its id" in said


class TestRerun:
    def test_a_stored_job_repeats_from_its_own_inputs_alone(self, bench, reproduced):
        before = {path: path.stat().st_mtime_ns for path in reproduced.rglob("*")}
        out, said = bench("rerun", str(reproduced), "20f1")
        assert out == "" and "agree in" in said
        assert before == {path: path.stat().st_mtime_ns for path in reproduced.rglob("*")}

    def test_a_result_that_does_not_repeat_is_exit_3(self, bench):
        bench.sweep("failing_when_heavy", 2)
        bench.run(code=1)
        failed = next(path.stem for path in bench.job_files() if "Zero" in str(pq.read_table(path)["error"]))
        bench("rerun", "results/sweep", failed)
        bench.fix()
        out, _ = bench("rerun", "results/sweep", failed, code=3)
        assert {"status", "error", "cost"} <= {line.split(":")[0] for line in out.splitlines()}
