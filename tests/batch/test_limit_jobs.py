"""Jobs behind endless wakes: run, gathered, checked, proved again, shown, run again, drawn and flown in a flock."""

import json
import math

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from upwash import columns as of
from upwash.aero.wake import WakeModel

pytestmark = pytest.mark.thorough

JOBS = 3


def rows_of(folder, name="solutions.parquet"):
    return pq.read_table(folder / name).to_pylist()


class TestASweep:
    def test_keeps_its_models_as_they_are_named(self, converged):
        rows = rows_of(converged, "summary.parquet")
        assert len(rows) == JOBS
        limit = WakeModel.named("limit")
        for row in rows:
            assert (row["status"], row["wavelengths"], row["span_nodes"]) == (of.SOLVED, math.inf, None)
            assert (row["stroke_states"], row["stroke_rule"]) == (limit.stroke_states, limit.stroke_rule)
            assert row["model"] == ("limit" if row["span_law"] == "stroke" else "given")

    def test_states_place_and_phase_at_the_distance_asked_for(self, converged):
        for row in rows_of(converged):
            wavelength = row["speed_m_s"] * row["period_s"]
            asked = 0.5 * wavelength if row["distance_m"] is None else row["distance_m"]
            assert row["x_m"] == pytest.approx(asked, rel=1e-12)
            turn = row["x_m"] / wavelength - row["phase"] - row["spatial_phase"]
            assert turn == pytest.approx(round(turn), abs=1e-9)
            assert row["station"] == ("astern" if asked >= row["semispan_m"] else "abreast")

    def test_says_of_force_that_it_has_no_v_optimum_and_of_which_wall(self, converged):
        (force,) = (row for row in rows_of(converged, "summary.parquet") if row["objective"] == "force")
        assert force["x_m"] is None and force["v_wall"] == "y_lower"

    def test_is_told_by_status_and_show(self, bench, converged):
        told = json.loads(bench("status", str(converged), "--json")[0])
        assert told["solved"] == JOBS
        for row in rows_of(converged, "summary.parquet"):
            text = bench("show", str(converged), row["job_id"])[0]
            assert "endless" in text and "exact" in text
            (job, *_) = json.loads(bench("show", str(converged), row["job_id"], "--json")[0])
            assert (job["wavelengths"], job["span_nodes"]) == ("endless", "exact")

    def test_is_in_order_and_proved_again(self, bench, converged):
        said = bench("check", str(converged), "--prove")[1]
        assert f"{JOBS} jobs, all in order and proved again" in said

    def test_is_found_again_by_a_second_run(self, bench, converged):
        (job,) = {row["job_id"] for row in rows_of(converged) if row["distance_m"] is not None}
        assert "agree in" in bench("rerun", str(converged), job)[1]

    @pytest.mark.parametrize("name", ["spatial_phase", "phase", "x_m", "lift_wake_n", "global_lower_bound"])
    def test_with_a_figure_that_is_made_up_is_refused(self, bench, converged, tmp_path, name):
        table = pq.read_table(converged / "solutions.parquet")
        rows = table.to_pylist()
        rows[0][name] += 1e-4
        for path in converged.glob("*.*"):
            (tmp_path / path.name).write_bytes(path.read_bytes())
        pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), tmp_path / "solutions.parquet")
        prove = ["--prove"] if name.endswith("bound") else []
        assert name in bench("check", str(tmp_path), *prove, code=3)[1]


class TestAFlock:
    def test_is_a_chain_in_which_each_flies_at_the_distance_asked_for(self, converged_flock):
        leader, *others = rows_of(converged_flock, "flock.parquet")
        assert (leader["bird"], leader["model"], leader["wavelengths"]) == (1, "limit", math.inf)
        wavelength = leader["speed_m_s"] * leader["period_s"]
        assert [row["x_m"] for row in others] == pytest.approx([0.5 * wavelength] * 2, rel=1e-12)
        assert [row["x_flock_m"] for row in others] == pytest.approx(
            [0.5 * wavelength, wavelength], rel=1e-12
        )
        # In line with the rule, both lag by nearly the time that the wake takes to them.
        assert all(abs(row["spatial_phase"]) < 0.06 for row in others)

    def test_is_in_order_and_proved_again(self, bench, converged_flock):
        assert "all in order and proved again" in bench("check", str(converged_flock), "--prove")[1]

    def test_is_found_again_by_a_second_run(self, bench, converged_flock):
        assert (
            "agree in"
            in bench("rerun", str(converged_flock), rows_of(converged_flock, "flock.parquet")[0]["job_id"])[1]
        )


class TestACommand:
    def test_draws_the_wind_of_an_endless_wake(self, bench):
        options = ("northern-bald-ibis", "--model", "limit", "--objective", "power")
        bench("field", *options, "--output", "wind")
        assert (bench.folder / "wind/northern-bald-ibis-power-xy.png").stat().st_size > 10_000

    def test_moves_a_flock_in_endless_wakes(self, bench):
        options = ("--model", "limit", "--objective", "power", "--tolerance", "0.01", "--birds", "2")
        bench("animate", "northern-bald-ibis", *options, "--output", "flock.gif")
        assert (bench.folder / "flock.gif").read_bytes().startswith(b"GIF")

    def test_that_needs_a_v_says_that_least_force_has_none(self, bench):
        options = ("--model", "limit", "--tolerance", "0.01", "--birds", "2")
        said = bench("animate", "northern-bald-ibis", *options, "--output", "flock.gif", code=2)[1]
        assert "V optimum" in said
        said = bench("field", "northern-bald-ibis", "--model", "limit", "--output", "field.png", code=2)[1]
        assert "outboard, level and astern" in said
