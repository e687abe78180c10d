"""A check that cannot fail is none: each promise is broken here, and the check must name job and column."""

import json

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from upwash import columns as of
from upwash.batch.check import of_rows
from upwash.batch.folder import ResultsFolder
from upwash.batch.lookup import rows_of
from upwash.jobs.flock import Flock
from upwash.jobs.pair import Pair
from upwash.jobs.schema import table_of

RECOMPUTED = [
    *("weight_n", "drag_n", "lift_self_n", "thrust_self_n", "lift_wake_n", "thrust_wake_n"),
    *("power_induced_w", "power_profile_w", "power_parasite_w", "power_total_w"),
    *("leader_power_induced_w", "leader_power_profile_w", "leader_power_parasite_w", "leader_power_total_w"),
    *("power_wake_w", "leader_power_wake_w"),
    *("saving_induced", "saving_profile", "saving_total", "cost", "cost_leader"),
]
SOLUTION = ["x_m", "y_m", "z_m", "amplitude_m", "upstroke_span_ratio"]
IDENTITY = of.names(column for column in of.COLUMNS if column.verified in (of.IDENTITY, of.DERIVED))
INPUTS = [
    c.name for c in of.belonging(of.PROBLEM, of.SEARCH) if c.type == of.FLOAT and c.absent != of.UNASKED
]


@pytest.fixture
def rows(reproduced):
    """The optima of the paper's pair, for force."""
    return rows_of(ResultsFolder(reproduced), "20f1")


def tampered(reproduced, folder, change, name="solutions.parquet"):
    """Copy results, with the rows of one table changed."""
    for path in reproduced.glob("*.*"):
        (folder / path.name).write_bytes(path.read_bytes())
    table = pq.read_table(reproduced / name)
    rows = table.to_pylist()
    rows = change(rows) or rows
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), folder / name)
    return folder


def v_optimum(rows):
    """Return the row of the V optimum."""
    return next(row for row in rows if row["is_v_optimum"])


def columns_found(rows):
    return {finding.column for finding in of_rows(rows, "here")}


def test_the_papers_results_are_in_order(bench, reproduced):
    out, said = bench("check", str(reproduced))
    assert (out, said) == ("", f"{reproduced}: 2 jobs, all in order\n")


class TestRows:
    def test_true_rows_pass(self, rows):
        assert of_rows(rows, "here") == []

    @pytest.mark.parametrize("name", RECOMPUTED)
    @pytest.mark.parametrize("number", [0, -1])
    def test_a_figure_that_does_not_follow_from_the_solution(self, rows, name, number):
        rows[number][name] += 1e-7 * max(abs(rows[number][name]), 1.0)
        assert name in columns_found(rows)

    @pytest.mark.parametrize("name", SOLUTION)
    def test_a_solution_moved_a_little_no_longer_makes_its_forces(self, rows, name):
        rows[2][name] *= 1 + 1e-6
        assert {"lift_wake_n", "thrust_wake_n"} <= columns_found(rows)

    def test_a_phase_moved_a_little_no_longer_makes_its_forces(self, rows):
        rows[2]["phase"] += 1e-6
        assert {"lift_wake_n", "thrust_wake_n"} <= columns_found(rows)

    @pytest.mark.parametrize("name", INPUTS)
    def test_an_input_that_is_not_the_ids(self, rows, name):
        for row in rows:
            row[name] *= 1 + 1e-15
        # A number of wavelengths that is not whole is none.
        assert columns_found(rows) - {"model"} == {"job_id"}

    @pytest.mark.parametrize("name", ["residual_lift", "residual_thrust"])
    def test_an_imbalance(self, rows, name):
        rows[1][name] = 1.1e-9
        assert name in columns_found(rows)

    @pytest.mark.parametrize(
        ("name", "value"),
        [("x_m", -0.01), ("x_m", 5.7), ("y_m", -0.01), ("y_m", 2.5), ("z_m", 1.1), ("z_m", -1.1)]
        + [("amplitude_m", 0.2), ("amplitude_m", 1.04), ("phase", 1.1)]
        + [("upstroke_span_ratio", 0.29), ("upstroke_span_ratio", 0.51)],
    )
    def test_a_variable_out_of_its_bounds(self, rows, name, value):
        rows[0][name] = value
        assert name in columns_found(rows)

    @pytest.mark.parametrize("name", ["cost", "x_m", "stationarity"])
    @pytest.mark.parametrize("value", [float("nan"), float("inf")])
    def test_a_number_that_is_none(self, rows, name, value):
        rows[0][name] = value
        assert name in columns_found(rows)

    @pytest.mark.parametrize("name", ["x_m", "cost", "rank", "placement"])
    def test_a_value_that_is_missing(self, rows, name):
        rows[0][name] = None
        assert name in columns_found(rows)

    @pytest.mark.parametrize(
        ("name", "value"), [("placement", "inboard"), ("tier", "stacked"), ("station", "abreast")]
    )
    def test_a_wrong_label(self, rows, name, value):
        v_optimum(rows)[name] = value
        assert name in columns_found(rows) or "is_v_optimum" in columns_found(rows)
        for row in rows:
            row["is_v_optimum"] = False
        assert name in columns_found(rows) or "is_v_optimum" in columns_found(rows)

    def test_another_optimum_is_called_the_v_optimum(self, rows):
        v_optimum(rows)["is_v_optimum"], rows[-1]["is_v_optimum"] = False, True
        assert "is_v_optimum" in columns_found(rows)

    def test_no_optimum_is_called_the_global_one(self, rows):
        rows[0]["is_global_optimum"] = False
        assert "is_global_optimum" in columns_found(rows)

    def test_optima_out_of_order(self, rows):
        assert {"rank", "cost"} <= columns_found([rows[1], rows[0], *rows[2:]])

    def test_an_optimum_is_missing(self, rows):
        assert "rank" in columns_found([rows[0], *rows[2:]])

    @pytest.mark.parametrize("proof", ["v", "global"])
    def test_a_bound_above_the_cost_it_bounds(self, rows, proof):
        for row in rows:
            row[f"{proof}_lower_bound"] *= 1.001
        assert "cost" in columns_found(rows)

    @pytest.mark.parametrize("proof", ["v", "global"])
    def test_a_gap_that_is_not_that_to_the_bound(self, rows, proof):
        for row in rows:
            row[f"{proof}_certified_gap"] *= 0.5
        assert f"{proof}_certified_gap" in columns_found(rows)

    def test_an_error_in_a_solved_row_and_a_solution_in_a_failed_one(self, rows):
        rows[0]["error"] = "something"
        assert "error" in columns_found(rows)
        rows[0]["status"] = "failed"
        assert "x_m" in columns_found(rows)
        rows[0]["status"] = "fine"
        assert "status" in columns_found(rows)


class TestFlocks:
    @pytest.fixture(params=["neighbour", "all-upstream"])
    def birds(self, flocks, request):
        """Every bird of one flock."""
        table = pq.read_table(flocks / "flock.parquet").to_pylist()
        return [row for row in table if row["wake"] == request.param]

    def test_true_flocks_pass(self, bench, flocks, birds):
        assert [row["bird"] for row in birds] == [1, 2, 3, 4]
        assert of_rows(birds, "here") == []
        assert "2 jobs, all in order" in bench("check", str(flocks))[1]

    @pytest.mark.parametrize(
        "name", ["lift_wake_n", "thrust_wake_n", "power_total_w", "saving_total", "cost"]
    )
    def test_a_figure_that_does_not_follow_from_the_flock(self, birds, name):
        birds[3][name] += 1e-7 * max(abs(birds[3][name]), 1.0)
        assert name in columns_found(birds)

    @pytest.mark.parametrize("name", ["x_flock_m", "y_flock_m", "z_flock_m", "phase_flock"])
    def test_a_bird_that_is_not_where_it_follows_its_leader(self, birds, name):
        birds[3][name] += 1e-6
        assert name in columns_found(birds)

    def test_a_bird_that_is_missing(self, birds):
        assert "bird" in columns_found([*birds[:1], *birds[2:]])

    def test_a_stroke_ahead_that_was_changed_no_longer_makes_the_forces_behind(self, birds):
        # Bird 4 follows bird 2, and feels bird 1 if it feels all.
        birds[1]["amplitude_m"] *= 1 + 1e-6
        assert columns_found(birds)

    def test_the_first_bird_flies_as_if_alone(self, birds):
        birds[0]["lift_wake_n"] = 1e-6
        assert "lift_wake_n" in columns_found(birds)

    def test_a_flock_repeats_from_its_stored_inputs(self, bench, flocks, birds):
        assert "agree in 4 rows" in bench("rerun", str(flocks), birds[0]["job_id"])[1]

    def test_the_summary_is_of_the_birds_placed(self, flocks, birds):
        summary = pq.read_table(flocks / "summary.parquet").to_pylist()
        (own,) = [row for row in summary if row["job_id"] == birds[0]["flock_id"]]
        assert own["birds_placed"] == 4
        assert own["cost_mean"] == pytest.approx(sum(row["cost"] for row in birds) / 4, rel=1e-15)
        assert own["saving_total_mean"] == pytest.approx(
            sum(row["saving_total"] for row in birds) / 4, rel=1e-15
        )

    def test_a_flock_that_ends_early_says_so_and_keeps_its_birds(self, birds):
        kept = (*IDENTITY, *of.names(of.belonging(of.PROOF, of.EFFORT)))
        kept += ("bird", "leader", "ahead_amplitude_m", "ahead_upstroke_span_ratio")
        lost = dict.fromkeys(birds[3]) | {name: birds[3][name] for name in kept if name in birds[3]}
        error = "no V optimum: expected one outboard, level and astern of bird 2, found none"
        lost |= dict.fromkeys(("v_certified_gap", "v_region_certified_gap"))
        lost |= {"status": "infeasible", "error": error}
        ended = [*birds[:3], lost]
        assert of_rows(ended, "here") == []
        (row,) = Flock.summarise(table_of(ended, Flock.rows)).to_pylist()
        assert (row["status"], row["error"], row["birds_placed"]) == (
            "infeasible",
            error,
            3,
        )


class TestTables:
    def refused(self, bench, folder, *words):
        out, said = bench("check", str(folder), code=3)
        assert out == ""
        assert all(word in said for word in words), said
        return said

    def test_the_job_and_the_column_are_named_and_the_exit_code_is_3(self, bench, reproduced, tmp_path):
        def change(rows):
            rows[5]["lift_wake_n"] += 1e-6

        folder = tampered(reproduced, tmp_path, change)
        job = pq.read_table(folder / "solutions.parquet").to_pylist()[5]["job_id"]
        self.refused(bench, folder, f"Error: {folder}: job {job}, lift_wake_n: expected ", "by recomputation")
        found = json.loads(bench("check", str(folder), "--json", code=3)[0])
        assert [(one["where"], one["column"]) for one in found["findings"]] == [(f"job {job}", "lift_wake_n")]

    def test_a_job_that_is_there_twice(self, bench, reproduced, tmp_path):
        self.refused(bench, tampered(reproduced, tmp_path, lambda rows: rows + rows[:1]), "job_id", "once")

    def test_a_job_without_a_result(self, bench, reproduced, tmp_path):
        first = pq.read_table(reproduced / "summary.parquet").column("job_id")[0].as_py()

        def change(rows):
            return [row for row in rows if row["job_id"] != first]

        self.refused(bench, tampered(reproduced, tmp_path, change), f"job {first}, status", "found none")

    def test_a_summary_that_is_not_that_of_its_rows(self, bench, reproduced, tmp_path):
        def change(rows):
            rows[1]["v_gap"] *= 1.5

        self.refused(
            bench, tampered(reproduced, tmp_path, change, "summary.parquet"), "v_gap", "from its rows"
        )

    @pytest.mark.parametrize("change", [lambda rows: rows[:1], lambda rows: rows + rows[-1:]])
    def test_a_summary_that_is_too_short_or_too_long(self, bench, reproduced, tmp_path, change):
        self.refused(bench, tampered(reproduced, tmp_path, change, "summary.parquet"), "summary.parquet")

    def test_units_that_were_changed(self, bench, reproduced, tmp_path):
        folder = tampered(reproduced, tmp_path, lambda rows: None)
        table = pq.read_table(folder / "solutions.parquet")
        place = table.schema.get_field_index("power_total_w")
        field = table.schema.field(place).with_metadata({"unit": "hp", "description": "horses"})
        pq.write_table(table.cast(table.schema.set(place, field)), folder / "solutions.parquet")
        self.refused(bench, folder, "solutions.parquet", "columns")

    def test_another_schema_version(self, bench, reproduced, tmp_path):
        folder = tampered(reproduced, tmp_path, lambda rows: None)
        table = pq.read_table(folder / "solutions.parquet").drop_columns(["phase"])
        old = table.replace_schema_metadata({**table.schema.metadata, b"schema_version": b"0"})
        pq.write_table(old, folder / "solutions.parquet")
        self.refused(bench, folder, "expected schema version", "found 0")

    def test_a_file_with_a_flipped_bit(self, bench, reproduced, tmp_path):
        folder = tampered(reproduced, tmp_path, lambda rows: None)
        whole = reproduced / "solutions.parquet"
        data = bytearray(whole.read_bytes())
        with pq.ParquetFile(whole) as file:
            data[file.metadata.row_group(0).column(20).data_page_offset + 25] ^= 1
        (folder / "solutions.parquet").write_bytes(data)
        self.refused(bench, folder, "solutions.parquet")

    def test_a_summary_alone_is_checked_row_by_row(self, bench, reproduced, tmp_path):
        (tmp_path / "summary.parquet").write_bytes((reproduced / "summary.parquet").read_bytes())
        bench("check", str(tmp_path))

        def change(rows):
            rows[0]["thrust_self_n"] *= 1 + 1e-8

        folder = tmp_path / "tampered"
        folder.mkdir()
        tampered(reproduced, folder, change, "summary.parquet")
        (folder / "solutions.parquet").unlink()
        (folder / "plan.json").unlink()
        self.refused(bench, folder, "thrust_self_n")

    def test_results_that_are_not_gathered_yet(self, bench):
        bench.sweep("infeasible", 2)
        bench.run()
        bench("check", "results/sweep")
        bench.job_files()[0].unlink()
        self.refused(bench, "results/sweep", "status", "found none")


def test_failed_and_infeasible_jobs_are_in_order(bench):
    bench.sweep("infeasible", 2)
    bench.run()
    bench("aggregate", "results/sweep")
    assert "2 jobs, all in order" in bench("check", "results/sweep")[1]
    assert Pair.summary.names[-1] == "optima_found"


def test_inputs_that_make_no_bird_have_nothing_to_prove(bench):
    """A dunlin would have to flap through more than 90° to reach the ibis's Strouhal number."""
    (bench.folder / "sweep.toml").write_text(
        'species = "dunlin"\nobjective = "force"\namplitude = "strouhal"\n'
    )
    bench.run()
    bench("aggregate", "results/sweep")
    assert "1 jobs, all in order" in bench("check", "results/sweep", "--prove")[1].replace(
        "1 job,", "1 jobs,"
    )
