"""Species side by side: what is compared, how sure it is, what it is set against, and its files."""

import json
import re
from contextlib import chdir

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from upwash import load_species
from upwash.cli import main
from upwash.columns import FAILED, SOLVED
from upwash.jobs.flock import Flock
from upwash.jobs.pair import Pair
from upwash.report.species_tables import MARK, comparison_tables, overview_table
from upwash.study.comparison import compare, compare_objectives
from upwash.study.intervals import LEAST_SAMPLES, intervals, outside_of_samples
from upwash.study.mechanism import STATEMENTS, count_species, mechanism
from upwash.study.observations import (
    ABOVE,
    AGREES,
    BELOW,
    NEAR,
    NOT_COMPARED,
    compare_with_observations,
    read_observations,
)
from upwash.study.quantities import optima_of_jobs
from upwash.study.studies import study_of

SPECIES = ("northern-bald-ibis", "mute-swan", "dunlin")
SWEEP = f"""\
species = {list(SPECIES)}
objective = ["force", "power"]
amplitude = ["stroke-angle", "strouhal"]
"""
TABLES = ("comparison", "objectives", "mechanism", "mechanism-counts", "observations")


def upwash(*arguments):
    result = CliRunner().invoke(main, arguments, prog_name="upwash")
    assert result.exit_code == 0, result.output
    return result


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return the results folder of a sweep over three species, run and gathered as a user does it."""
    folder = tmp_path_factory.mktemp("comparison")
    (folder / "birds.toml").write_text(SWEEP)
    with chdir(folder):
        upwash("run", "./birds.toml")
        said = upwash("aggregate", "results/birds").stderr
    assert "tables without intervals" in said
    return folder / "results" / "birds"


@pytest.fixture(scope="module")
def rows(results):
    return pd.read_parquet(results / "solutions.parquet")


@pytest.fixture(scope="module")
def compared(rows):
    return compare(rows).set_index(["species", "objective", "amplitude_convention"])


def rows_of(rows, species, objective="force", convention="stroke-angle"):
    """Return all rows of one job."""
    same = (rows["species"] == species) & (rows["objective"] == objective)
    return rows[same & (rows["amplitude_convention"] == convention)]


def resampled(rows, count, **changes):
    """Return copies of some jobs as samples would be; each change takes a column and the sample's number."""
    samples = []
    for number in range(count):
        sample = rows.assign(job_id=rows["job_id"] + f"-{number}")
        changed = {name: change(sample[name], number) for name, change in changes.items()}
        samples.append(sample.assign(**changed))
    return pd.concat(samples, ignore_index=True)


def without_v(rows):
    """Return rows of which no optimum is in a V."""
    kept = rows[~rows["is_v_optimum"].eq(True)]
    return kept.assign(v_wall="x_lower,y_lower", v_certified_gap=None)


class TestOneRowAProblem:
    def test_every_species_objective_and_convention_is_there(self, compared):
        assert len(compared) == len(SPECIES) * 4
        assert compared["has_v"].sum() == len(SPECIES) * 4 - 2

    def test_every_solution_balances(self, rows):
        solved = rows[rows["status"] == SOLVED]
        assert solved[["residual_lift", "residual_thrust"]].abs().max().max() <= 1e-9

    def test_an_amplitude_beyond_the_wingspan_is_a_row_that_says_so(self, compared):
        for objective in ("force", "power"):
            row = compared.loc["dunlin", objective, "strouhal"]
            assert (row["status"], row["has_v"]) == ("infeasible", False)
            assert "amplitude_m: expected at most twice the semispan" in row["remark"]
            assert row["amplitude_number"] > 2.0
            assert np.isnan(row["saving_total"])

    def test_no_v_optimum_is_a_row_that_says_so_and_names_the_wall(self, rows):
        swan = rows_of(rows, "mute-swan")
        row = compare(without_v(swan)).iloc[0]
        assert not row["has_v"]
        assert row["remark"].startswith(
            "no V optimum; a follower in the V does best as close behind its leader"
        )
        assert "as close to its leader's side as still counts as outboard" in row["remark"]
        assert np.isnan(row["x_semispans"]) and np.isnan(row["v_gap"])
        best = swan.sort_values("rank").iloc[0]
        assert row["best_y_semispans"] == best["y_m"] / best["semispan_m"]

    def test_a_proof_left_open_is_remarked(self, rows):
        open_proof = rows_of(rows, "mute-swan").assign(global_certified_gap=0.02)
        assert "best optimum proved to 2 % only" in compare(open_proof).iloc[0]["remark"]

    @pytest.mark.parametrize(("gap", "is_marked"), [(0.02, True), (5e-5, False)])
    def test_a_v_optimum_that_is_not_proved_the_best_is_marked_and_the_mark_explained(
        self, rows, gap, is_marked
    ):
        compared = compare(rows_of(rows, "mute-swan").assign(v_certified_gap=gap))
        assert ("V optimum proved to 2 % only" in compared.iloc[0]["remark"]) == is_marked
        for table in (overview_table(compared), *comparison_tables(compared)):
            *_, line = (line for line in table.text().splitlines() if "mute-swan" in line)
            assert (MARK in line) == is_marked
            assert any(note.startswith(MARK) for note in table.notes) == is_marked

    def test_a_failed_job_says_why(self, rows):
        one = rows_of(rows, "dunlin", "force", "strouhal").assign(status=FAILED, error="ValueError: broken")
        assert compare(one).iloc[0]["remark"] == "ValueError: broken"


class TestQuantities:
    def test_positions_are_in_semispans_wavelengths_and_amplitudes(self, rows, compared):
        for species in SPECIES:
            v = rows_of(rows, species).query("is_v_optimum == True").iloc[0]
            row, bird = compared.loc[species, "force", "stroke-angle"], load_species(species).bird()
            assert row["x_wavelengths"] * bird.wavelength_m == pytest.approx(v["x_m"], rel=1e-12)
            assert row["x_semispans"] * bird.semispan_m == pytest.approx(v["x_m"], rel=1e-12)
            assert row["y_semispans"] * bird.semispan_m == pytest.approx(v["y_m"], rel=1e-12)
            assert row["z_semispans"] * bird.semispan_m == pytest.approx(v["z_m"], rel=1e-12)
            assert row["z_amplitudes"] * bird.amplitude_m == pytest.approx(v["z_m"], rel=1e-12)
            overlap = 2.0 * bird.semispan_m - v["y_m"]
            assert row["tip_spacing_semispans"] * bird.semispan_m == pytest.approx(-overlap, rel=1e-12)

    def test_a_wingtip_retraces_its_leaders_path_when_its_lag_is_the_distance(self, rows):
        one = rows_of(rows, "mute-swan").copy()
        wavelength = one["speed_m_s"] * one["period_s"]
        for lag, path_phase in ((0.3, 0.0), (0.8, -0.5), (0.4, 0.1), (0.1, -0.2)):
            moved = one.assign(x_m=0.3 * wavelength, phase=lag)
            assert optima_of_jobs(moved)["path_phase"].iloc[0] == pytest.approx(path_phase, abs=1e-12)

    def test_groups_are_those_of_the_species(self, compared):
        for species in SPECIES:
            expected = load_species(species).groups("stroke-angle")
            row = compared.loc[species, "power", "stroke-angle"]
            for name in ("weight_number", "wavelength_number", "amplitude_number"):
                assert row[name] == pytest.approx(expected[name], rel=1e-12)

    def test_shares_and_changes_follow_from_powers_and_strokes(self, rows, compared):
        v = rows_of(rows, "mute-swan", "power").query("is_v_optimum == True").iloc[0]
        row = compared.loc["mute-swan", "power", "stroke-angle"]
        saved = {part: v[f"leader_power_{part}_w"] - v[f"power_{part}_w"] for part in ("induced", "profile")}
        assert row["profile_share"] == pytest.approx(saved["profile"] / sum(saved.values()), rel=1e-9)
        assert row["amplitude_reduction"] == pytest.approx(1.0 - v["amplitude_m"] / v["leader_amplitude_m"])
        assert row["saving_cost"] == pytest.approx(row["saving_total"], rel=1e-12)

    def test_the_gap_is_to_the_best_of_the_job(self, rows, compared, results):
        summary = pd.read_parquet(results / "summary.parquet").set_index("job_id")["v_gap"].dropna()
        assert optima_of_jobs(rows)["v_gap"].dropna().to_dict() == pytest.approx(summary.to_dict())
        solved = compared[compared["has_v"]]
        assert (solved["v_gap_bound"] >= solved["v_gap"]).all()

    def test_optima_in_a_v_of_equal_cost_may_save_differently(self, rows):
        swan = rows_of(rows, "mute-swan")
        v = swan[swan["is_v_optimum"].eq(True)]
        twin = v.assign(rank=90, is_v_optimum=False, cost=v["cost"] * 1.0009, saving_total=0.5)
        dearer = v.assign(rank=91, is_v_optimum=False, cost=v["cost"] * 1.0011, saving_total=0.9)
        stacked = v.assign(rank=92, is_v_optimum=False, tier="stacked", saving_total=0.7)
        row = compare(pd.concat([swan, twin, dearer, stacked])).iloc[0]
        assert row["v_alike"] == compare(swan).iloc[0]["v_alike"] + 1
        assert row["v_alike_saving_high"] == 0.5
        assert row["v_alike_saving_low"] <= row["saving_total"]

    def test_the_ibis_is_the_same_bird_under_both_conventions(self, compared):
        both = [compared.loc["northern-bald-ibis", "force", one] for one in ("stroke-angle", "strouhal")]
        assert both[0]["saving_total"] == pytest.approx(both[1]["saving_total"], rel=1e-9)


class TestObjectives:
    def test_a_change_is_by_power_less_by_force(self, rows, compared):
        changes = compare_objectives(rows).set_index(["species", "amplitude_convention"])
        change = changes.loc["mute-swan", "strouhal"]
        force, power = (compared.loc["mute-swan", one, "strouhal"] for one in ("force", "power"))
        for name in ("x_semispans", "saving_total", "amplitude_reduction"):
            assert change[f"{name}_change"] == pytest.approx(power[name] - force[name], rel=1e-12)
        assert len(changes) == len(SPECIES) * 2

    def test_its_interval_is_over_pairs_of_the_same_bird(self, rows):
        def moved(x, number):
            return x + number / 10.0

        swan = rows[(rows["species"] == "mute-swan") & (rows["amplitude_convention"] == "strouhal")]
        samples = resampled(swan, 20, mass_kg=moved, x_m=moved)
        change = compare_objectives(swan, samples).iloc[0]
        # Each bird moves by its own distance, the same for both objectives: the change stays what it is.
        assert change["x_semispans_change_low"] == pytest.approx(change["x_semispans_change"], rel=1e-9)
        assert change["x_semispans_change_high"] == pytest.approx(change["x_semispans_change"], rel=1e-9)


SAMPLES = 21


@pytest.fixture(scope="module")
def samples(rows):
    """Return samples of the swan whose savings are 0.00, 0.01, … 0.20."""
    return resampled(
        rows_of(rows, "mute-swan"),
        SAMPLES,
        saving_total=lambda _, number: number / 100.0,
        mass_kg=lambda mass, number: mass * (0.9 + number / 100.0),
    )


class TestIntervals:
    def test_ends_leave_a_twentieth_of_the_samples_on_either_side(self, samples):
        found = intervals(optima_of_jobs(samples)).iloc[0]
        assert (found["saving_total_low"], found["saving_total_high"]) == pytest.approx((0.01, 0.19))
        assert (found["samples"], found["samples_failed"], found["samples_without_v"]) == (SAMPLES, 0, 0)

    def test_a_sample_that_failed_or_has_no_v_is_counted_and_in_no_interval(self, samples):
        jobs = sorted(samples["job_id"].unique(), key=lambda job: int(job.rpartition("-")[2]))
        is_failed = samples["job_id"].isin(jobs[:2])
        lost = samples[~is_failed | (samples["rank"] == 0)].copy()
        lost.loc[lost["job_id"].isin(jobs[:2]), "status"] = FAILED
        lost.loc[lost["job_id"].isin(jobs[:2]), "is_v_optimum"] = None
        lost = lost[~(lost["job_id"].isin(jobs[-3:]) & lost["is_v_optimum"].eq(True))]
        found = intervals(optima_of_jobs(lost)).iloc[0]
        assert (found["samples"], found["samples_failed"], found["samples_without_v"]) == (SAMPLES, 2, 3)
        assert found["saving_total_low"] >= 0.02
        assert found["saving_total_high"] <= 0.17

    def test_too_few_samples_give_none(self, rows):
        few = resampled(rows_of(rows, "mute-swan"), LEAST_SAMPLES - 1)
        found = intervals(optima_of_jobs(few)).iloc[0]
        assert np.isnan(found["saving_total_low"])
        assert found["samples"] == LEAST_SAMPLES - 1

    def test_stand_beside_the_birds_own_values(self, rows, samples):
        row = compare(rows_of(rows, "mute-swan"), samples).iloc[0]
        assert row["saving_total_low"] < row["saving_total_high"]
        assert row["samples"] == SAMPLES

    def test_a_bird_that_has_changed_since_is_found_out(self, rows, samples):
        swan = optima_of_jobs(rows_of(rows, "mute-swan"))
        assert outside_of_samples(swan, optima_of_jobs(samples)) == set()
        heavier = swan.assign(mass_kg=1.3 * swan["mass_kg"])
        assert outside_of_samples(heavier, optima_of_jobs(samples)) == {"mute-swan"}


class TestMechanism:
    def test_counts_the_species_and_names_the_exceptions(self, rows):
        weak = rows.copy()
        # A swan that flaps as far as its leader.
        is_swan = weak["species"] == "mute-swan"
        weak.loc[is_swan, "amplitude_m"] = weak.loc[is_swan, "leader_amplitude_m"]
        counts = count_species(mechanism(weak))
        assert len(counts) == 4 * len(STATEMENTS)
        of_amplitude = counts[counts["statement"] == STATEMENTS["amplitude_over_flexion"][0]]
        assert set(of_amplitude["exceptions"]) == {"mute-swan"}
        for _, row in of_amplitude.iterrows():
            by_strouhal = row["amplitude_convention"] == "strouhal"
            assert (row["holds"], row["fails"], row["without_v"]) == (1 if by_strouhal else 2, 1, by_strouhal)

    def test_asks_the_ibis_as_the_paper_does(self, rows):
        answers = mechanism(rows_of(rows, "northern-bald-ibis")).iloc[0]
        assert answers[list(STATEMENTS)].eq(True).all()

    def test_no_v_optimum_is_no_answer(self, rows):
        answers = mechanism(without_v(rows_of(rows, "mute-swan"))).iloc[0]
        assert not answers["has_v"]
        assert answers[list(STATEMENTS)].isna().all()

    def test_what_the_samples_do_not_settle_is_named(self, rows):
        swan = rows_of(rows, "mute-swan")

        def sometimes(amplitude, number):
            return swan["leader_amplitude_m"] if number % 2 else amplitude

        samples = resampled(swan, 10, amplitude_m=sometimes)
        answers = mechanism(swan, samples)
        assert answers["amplitude_over_flexion_share"].iloc[0] == 0.5
        assert count_species(answers)["undecided"].iloc[0] == "mute-swan"


class TestObservations:
    BASE = {"study": "Someone 2020", "metric": "m", "basis": "measured", "read": "original", "note": ""}
    BASE |= {"this_model": False, "label": "Someone 2020"}

    def verdict(self, rows, samples=None, **observation):
        """Compare one made-up observation of the swan with its force-optimal V."""
        one = (
            {"value": np.nan, "low": np.nan, "high": np.nan, "species": "mute-swan"} | self.BASE | observation
        )
        swan = rows_of(rows, "mute-swan")
        (found,) = compare_with_observations(swan, samples, pd.DataFrame([one])).to_dict("records")
        return found

    def place(self, rows):
        v = rows_of(rows, "mute-swan").query("is_v_optimum == True").iloc[0]
        return v, v["semispan_m"]

    def test_every_published_row_is_kept_compared_or_not(self, rows):
        found = compare_with_observations(rows)
        published = read_observations()
        for _, one in published.iterrows():
            kept = found[(found["study"] == one["study"]) & (found["quantity"] == one["quantity"])]
            assert len(kept)
        assert found["verdict"].isin([AGREES, NEAR, ABOVE, BELOW, NOT_COMPARED]).all()
        assert (found[found["verdict"] == NOT_COMPARED]["remark"] != "").all()

    def test_agreement_and_disagreement_both_occur_for_the_ibis(self, rows):
        found = compare_with_observations(rows)
        ibis = found[(found["species"] == "northern-bald-ibis") & (found["basis"] == "measured")]
        verdicts = set(ibis.groupby(["quantity", "observed"], dropna=False)["verdict"].first())
        assert {AGREES, NEAR, ABOVE, BELOW} <= verdicts

    def test_a_heart_rate_is_compared_with_nothing(self, rows):
        found = compare_with_observations(rows)
        heart = found[found["quantity"] == "heart_rate_reduction"]
        assert (heart["verdict"] == NOT_COMPARED).all()
        assert heart["remark"].str.startswith("nothing in the model is the same: heart rate").all()

    @pytest.mark.parametrize(
        ("quantity", "unit", "compare_with", "value"),
        [
            ("distance_behind", "m", "x_m", lambda v, b: v["x_m"]),
            ("distance_behind", "wingspans", "x_m", lambda v, b: v["x_m"] / (2.0 * b)),
            ("distance_behind", "wavelengths", "x_m", lambda v, b: v["x_m"] / v["speed_m_s"] / v["period_s"]),
            ("lateral_distance", "semispans", "y_m", lambda v, b: v["y_m"] / b),
            ("wingtip_spacing", "m", "y_m", lambda v, b: v["y_m"] - 2.0 * b),
            ("vertical_distance", "m", "z_m", lambda v, b: v["z_m"]),
            ("total_power_saving", "%", "saving_total", lambda v, b: 100.0 * v["saving_total"]),
        ],
    )
    def test_ours_is_in_the_units_of_the_publication(self, rows, quantity, unit, compare_with, value):
        expected = value(*self.place(rows))
        found = self.verdict(
            rows,
            quantity=quantity,
            unit=unit,
            compare=compare_with,
            low=expected - 1e-3,
            high=expected + 1e-3,
        )
        assert found["ours"] == pytest.approx(expected, rel=1e-9)
        assert (found["verdict"], found["difference"]) == (AGREES, 0.0)

    def test_one_end_alone_leaves_the_other_open(self, rows):
        saving = {"quantity": "total_power_saving", "unit": "%", "compare": "saving_total"}
        assert self.verdict(rows, high=2.0, **saving)["verdict"] == ABOVE
        assert self.verdict(rows, low=2.0, **saving)["verdict"] == AGREES
        assert self.verdict(rows, low=90.0, **saving)["verdict"] == BELOW

    def test_near_is_within_a_core_radius_and_for_lengths_alone(self, rows):
        v, b = self.place(rows)
        core = v["core_radius_ratio"] * b
        place = {"quantity": "distance_behind", "unit": "m", "compare": "x_m"}
        assert self.verdict(rows, value=v["x_m"] - 0.99 * core, **place)["verdict"] == NEAR
        assert self.verdict(rows, value=v["x_m"] - 1.01 * core, **place)["verdict"] == ABOVE
        in_wingspans = place | {"unit": "wingspans", "value": (v["x_m"] + 0.99 * core) / (2.0 * b)}
        assert self.verdict(rows, **in_wingspans)["verdict"] == NEAR
        saving = {"quantity": "total_power_saving", "unit": "%", "compare": "saving_total"}
        assert self.verdict(rows, value=100.0 * v["saving_total"] - 1e-3, **saving)["verdict"] == ABOVE

    def test_the_interval_of_ours_may_reach_the_published_value(self, rows):
        v, _ = self.place(rows)
        samples = resampled(
            rows_of(rows, "mute-swan"), 20, saving_total=lambda saving, number: saving + number / 100.0
        )
        saving = {"quantity": "total_power_saving", "unit": "%", "compare": "saving_total"}
        wanted = 100.0 * v["saving_total"] + 10.0
        assert self.verdict(rows, value=wanted, **saving)["verdict"] == BELOW
        found = self.verdict(rows, samples, value=wanted, **saving)
        assert found["verdict"] == AGREES
        assert found["ours_low"] < wanted < found["ours_high"]

    def test_a_species_that_was_not_solved_is_said_to_be_missing(self, rows):
        found = self.verdict(
            rows, species="great-auk", quantity="distance_behind", unit="m", compare="x_m", value=1.0
        )
        assert (found["verdict"], found["remark"]) == (NOT_COMPARED, "no such species in the sweep")


class TestFiles:
    @pytest.mark.parametrize("name", TABLES)
    def test_parquet_and_csv_hold_the_same_and_units_are_kept(self, results, name):
        table = pq.read_table(results / "tables" / f"{name}.parquet")
        assert all(field.metadata[b"description"] for field in table.schema)
        assert table.schema.metadata[b"sweep"].decode() == SWEEP
        frame = pd.read_csv(results / "tables" / f"{name}.csv", keep_default_na=False, na_values=[""])
        assert list(frame.columns) == table.column_names
        for field in table.schema:
            if field.type == "double":
                stored = table.column(field.name).to_pandas().astype(float)
                assert np.array_equal(stored, frame[field.name].astype(float), equal_nan=True)

    def test_markdown_lists_every_species_under_every_problem(self, results):
        text = (results / "tables" / "comparison.md").read_text()
        assert text.count("**V optima by ") == 4
        for species in SPECIES:
            assert (
                len(re.findall(rf"\| {species}(?: {MARK})? \|", text)) == 1 + 4 + 2
            )  # overview, problems, groups
        assert "at most twice the semispan (0.36 m" in text

    def test_samples_beside_give_intervals_once_they_are_there(self, results, rows):
        beside = results.parent / "uncertainty"
        samples = resampled(rows, LEAST_SAMPLES)
        (beside / "jobs").mkdir(parents=True)
        (beside / "plan.json").write_text(json.dumps({"sweep": "u", "kind": "pair", "text": "", "jobs": ""}))
        import pyarrow as pa

        table = pa.Table.from_pandas(samples, Pair.rows, preserve_index=False).replace_schema_metadata(
            pq.read_schema(results / "solutions.parquet").metadata
        )
        pq.write_table(table, beside / "solutions.parquet", write_page_checksum=True)
        said = upwash("aggregate", str(results)).stderr
        assert "tables without intervals" not in said
        compared = pd.read_parquet(results / "tables" / "comparison.parquet")
        assert compared[compared["has_v"]]["saving_total_low"].notna().all()
        assert "[" in (results / "tables" / "comparison.md").read_text()

    def test_verdicts_are_counted_and_the_papers_own_numbers_are_no_observations(self, results):
        text = (results / "tables" / "observations.md").read_text()
        counts = [line.strip("| ").split(" | ") for line in text.partition("\n\n**")[0].splitlines()[2:]]
        header, measured, own = counts[0], [], []
        for row in counts[2:]:
            (measured if row[0] == "measured" else own if "paper" in row[0] else []).append(row)
        assert header[3:] == [AGREES, NEAR, ABOVE, BELOW]
        observed = pd.read_parquet(results / "tables" / "observations.parquet")
        compared = observed[observed["verdict"] != NOT_COMPARED]
        is_own = compared["study"].str.startswith("Pomerenk")
        for rows, theirs in ((measured, compared["basis"] == "measured"), (own, is_own)):
            assert sum(int(count) for row in rows for count in row[3:]) == theirs.sum() > 0

    def test_damage_beside_is_said_and_does_not_stop_the_gathering(self, results):
        (results.parent / "uncertainty" / "solutions.parquet").write_bytes(b"PAR1 not really")
        said = upwash("aggregate", str(results)).stderr
        assert "no tables: " in said and "solutions.parquet" in said


class TestWhichStudy:
    @pytest.mark.parametrize(
        ("text", "study"),
        [
            ('species = "all"', "comparison"),
            ('species = "all"\n[grid]\nmass_kg = [1.0]', ""),
            ('species = "all"\nsolver = "a:b"', ""),
            ('species = "all"\n[sample]\nmethod = "sobol"\ncount = 8\nwithin = "species"', "uncertainty"),
            ('[sample]\nmethod = "sobol"\ncount = 8\n[sample.ranges]\nmass_kg = [1.0, 2.0]', ""),
            ('[[block]]\n[block.sample]\nmethod = "saltelli"\nwithin = "species"', "sensitivity"),
        ],
    )
    def test_is_read_from_the_sweeps_own_text(self, text, study):
        from upwash.batch.folder import Plan

        assert study_of(Plan("s", Pair, text, [])) == study
        assert study_of(Plan("s", Flock, text, [])) == ""
