"""Sobol' indices: right where they are known, honest about what failed, refused where they mean nothing."""

import sys

import numpy as np
import pandas as pd
import pytest
from upwash.columns import FAILED, INFEASIBLE, SOLVED
from upwash.errors import UpwashError
from upwash.jobs.pair import Pair
from upwash.report.species_tables import sensitivity_tables
from upwash.species import load_species
from upwash.study.sensitivity import LEAST_POINTS, design_of, sensitivity
from upwash.sweep import read_sweep

POINTS = 128
SWEEP = """\
species = "northern-bald-ibis"
amplitude = "{convention}"
[sample]
method = "{method}"
count = {points}
within = "species"
"""
INPUTS = [
    "mass_kg",
    "semispan_m",
    "speed_m_s",
    "period_s",
    "density_kg_m3",
    "gravity_m_s2",
    "leader_upstroke_span_ratio",
    "stroke_half_angle_deg",
]
WEIGHTS = {"mass_kg": 3.0, "speed_m_s": 2.0, "stroke_half_angle_deg": 1.0}


def sampled(folder, points=POINTS, convention="stroke-angle", method="saltelli"):
    """Return the jobs of a sensitivity sweep, and rows that solve them in a way whose indices are known.

    The saving is a weighted sum of three inputs, each taken from 0 to 1 over its range; y depends on one of
    them and x on none.
    """
    path = folder / "sweep.toml"
    path.write_text(SWEEP.format(points=points, convention=convention, method=method))
    jobs = read_sweep(path).jobs
    rows = pd.DataFrame([{"job_id": job.job_id} | job.inputs() for job in jobs]).reindex(
        columns=Pair.rows.names
    )
    sine = rows["leader_amplitude_m"] / (2.0 * rows["semispan_m"])
    half_angle = np.degrees(np.arcsin(np.minimum(sine, 1.0)))
    inputs = rows.assign(stroke_half_angle_deg=half_angle)
    ranges = load_species("northern-bald-ibis").ranges()
    shares = {
        name: (inputs[name] - ranges[name][0]) / (ranges[name][1] - ranges[name][0]) for name in WEIGHTS
    }
    solved = rows.assign(
        status=SOLVED,
        is_v_optimum=True,
        rank=0,
        saving_total=sum(weight * shares[name] for name, weight in WEIGHTS.items()),
        y_m=rows["semispan_m"] * shares["mass_kg"],
        x_m=rows["speed_m_s"] * rows["period_s"] / 2.0,
        z_m=0.0,
        cost=1.0,
        cost_leader=2.0,
    )
    return solved, [job.job_id for job in jobs]


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    return sampled(tmp_path_factory.mktemp("sensitivity"))


@pytest.fixture(scope="module")
def indices(study):
    return sensitivity(*study).set_index(["output", "input"])


def variances():
    """Return the share of each input in the variance of a sum of evenly spread inputs."""
    total = sum(weight**2 for weight in WEIGHTS.values())
    return {name: WEIGHTS.get(name, 0.0) ** 2 / total for name in INPUTS}


class TestIndices:
    @pytest.mark.parametrize("name", INPUTS)
    def test_of_a_sum_are_the_shares_of_its_terms(self, indices, name):
        row = indices.loc["saving_total", name]
        share = variances()[name]
        assert row["first_order"] == pytest.approx(share, abs=0.1)
        assert row["total"] == pytest.approx(share, abs=0.02 + 0.05 * share)
        assert abs(row["first_order"] - share) <= 2.0 * row["first_order_confidence"] + 1e-12
        assert abs(row["total"] - share) <= 2.0 * row["total_confidence"] + 1e-12

    def test_an_input_without_effect_has_none(self, indices):
        assert indices.loc[("saving_total", "density_kg_m3"), "total"] == pytest.approx(0.0, abs=1e-12)
        assert indices.loc[("y_semispans", "speed_m_s"), "total"] == pytest.approx(0.0, abs=1e-12)
        assert indices.loc[("y_semispans", "mass_kg"), "total"] == pytest.approx(1.0, abs=0.05)

    def test_an_output_that_does_not_vary_has_none(self, indices):
        assert indices.loc["x_wavelengths"][["first_order", "total"]].isna().all().all()
        assert indices.loc["has_v"]["variance"].eq(0.0).all()

    def test_the_same_rows_give_the_same_numbers(self, study, indices):
        again = sensitivity(*study).set_index(["output", "input"])
        pd.testing.assert_frame_equal(again, indices)

    def test_order_of_the_rows_does_not_matter(self, study, indices):
        rows, jobs = study
        shuffled = rows.sample(frac=1.0, random_state=0)
        pd.testing.assert_frame_equal(sensitivity(shuffled, jobs).set_index(["output", "input"]), indices)


class TestWhatFailed:
    def test_is_counted_and_takes_its_whole_point_with_it(self, study):
        rows, jobs = study
        width = len(INPUTS) + 2
        failed = [jobs[0], jobs[1], jobs[5 * width + 3]]
        without_v = [jobs[-1]]
        broken = rows.astype({"is_v_optimum": object, "rank": float})
        broken.loc[broken["job_id"].isin(failed), ["status", "is_v_optimum", "rank"]] = [FAILED, None, None]
        broken.loc[broken["job_id"].isin(without_v), "is_v_optimum"] = False
        found = sensitivity(broken, jobs).set_index(["output", "input"])
        assert (found["samples"] == len(jobs)).all()
        assert (found["samples_failed"] == 3).all()
        assert (found["samples_without_v"] == 1).all()
        saving, best = found.loc["saving_total"], found.loc["best_saving_total"]
        assert (saving["points_usable"] == POINTS - 3).all()
        # A sample without a V has a best optimum all the same.
        assert (best["points_usable"] == POINTS - 2).all()
        assert saving["total"].notna().all()
        assert saving.loc["mass_kg", "total"] == pytest.approx(variances()["mass_kg"], abs=0.1)

    def test_whether_there_is_a_v_is_an_output_of_its_own(self, study):
        rows, jobs = study
        light = rows["mass_kg"] < 1.3
        found = sensitivity(
            rows.assign(
                is_v_optimum=~light,
                status=np.where(light, INFEASIBLE, SOLVED),
            ),
            jobs,
        ).set_index(["output", "input"])
        assert found.loc[("has_v", "mass_kg"), "total"] == pytest.approx(1.0, abs=0.15)
        assert found.loc[("has_v", "speed_m_s"), "total"] == 0.0

    def test_too_few_usable_points_give_no_index_but_the_counts(self, study):
        rows, jobs = study
        width = len(INPUTS) + 2
        kept = set(jobs[: (LEAST_POINTS - 1) * width])
        lost = rows.assign(is_v_optimum=rows["job_id"].isin(kept))
        found = sensitivity(lost, jobs).set_index(["output", "input"]).loc["saving_total"]
        assert found[["first_order", "total"]].isna().all().all()
        assert (found["points_usable"] == LEAST_POINTS - 1).all()

    def test_just_enough_usable_points_do(self, study):
        rows, jobs = study
        kept = set(jobs[: LEAST_POINTS * (len(INPUTS) + 2)])
        lost = rows.assign(is_v_optimum=rows["job_id"].isin(kept))
        found = sensitivity(lost, jobs).set_index(["output", "input"]).loc["saving_total"]
        assert (found["points_usable"] == LEAST_POINTS).all()
        assert found[["first_order", "total"]].notna().all().all()

    def test_the_table_says_what_was_left_out(self, study):
        rows, jobs = study
        lost = rows.assign(is_v_optimum=~rows["job_id"].isin(jobs[:3]))
        text = sensitivity_tables(sensitivity(lost, jobs))[0].markdown()
        assert f"{len(jobs)} samples of {POINTS} points, 0 failed, 3 without a V optimum" in text
        assert "left out, with all samples of their points: saving_total 1 points" in text
        assert "no index, as it does not vary or too few points are usable: " in text


class TestDesign:
    def test_is_found_in_the_inputs(self, study):
        rows, jobs = study
        design = design_of(rows.set_index("job_id").loc[jobs])
        assert design.inputs == INPUTS
        assert design.jobs.shape == (POINTS, len(INPUTS) + 2)
        assert list(design.jobs.ravel()) == jobs

    def test_an_amplitude_that_follows_from_speed_and_period_is_no_input(self, tmp_path):
        rows, jobs = sampled(tmp_path, points=8, convention="strouhal")
        assert design_of(rows.set_index("job_id").loc[jobs]).inputs == INPUTS[:-1]

    @pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
    def test_another_sample_is_refused(self, tmp_path, method):
        with pytest.raises(UpwashError, match="to be one sample with method 'saltelli', found others"):
            sensitivity(*sampled(tmp_path, method=method))

    def test_a_shuffled_design_is_refused(self, study):
        rows, jobs = study
        with pytest.raises(UpwashError, match="to be one sample"):
            sensitivity(rows, [*jobs[1:], jobs[0]])

    def test_a_job_without_a_result_is_missed(self, study):
        rows, jobs = study
        with pytest.raises(UpwashError, match="found 1 without; run the sweep to its end"):
            sensitivity(rows[rows["job_id"] != jobs[7]], jobs)


def test_without_salib_the_message_says_what_to_install(study, monkeypatch):
    monkeypatch.setitem(sys.modules, "SALib.analyze.sobol", None)
    with pytest.raises(UpwashError, match=r"expected SALib, found it not installed; pip install 'upwash\["):
        sensitivity(*study)
