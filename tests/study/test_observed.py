"""Tables of observed birds: what is read of them, who follows whom, and what comes out row by row."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import renew_observed
from upwash import Pose, SearchSettings, Stroke, WakeModel, evaluate, load_species, solve_pair, wake_force
from upwash.errors import UpwashError
from upwash.study.observed.table import Reading
from upwash.study.observed.tally import EvaluationTally, rayleigh
from upwash.study.told import EVALUATION, OUTCOMES

SPECIES = load_species("northern-bald-ibis")
IBIS = SPECIES.bird()
LIMIT = WakeModel.named("limit")
MODELS = {"paper": WakeModel(), "limit": LIMIT}


def told(table, bird=IBIS, **options):
    """Evaluate a table that is given by its columns, without searching the optimum."""
    return evaluate(bird, pd.DataFrame(table), **{"finds_optimum": False} | options)


def seen(**columns):
    """Return one bird beside its leader, with other columns."""
    return {"x_m": [1.2], "y_m": [0.9], "z_m": [0.0], "phase": [0.3]} | columns


class TestOptima:
    @pytest.mark.parametrize("model", ["paper", pytest.param("limit", marks=pytest.mark.thorough)])
    @pytest.mark.parametrize("objective", ["force", "power"])
    @pytest.mark.parametrize("species", ["northern-bald-ibis", "common-eider"])
    def test_each_optimum_gives_back_its_cost_and_its_stroke(self, species, objective, model):
        bird = load_species(species).bird()
        solution = solve_pair(bird, objective, model=MODELS[model], search=SearchSettings(tolerance=1e-2))
        optima = solution.optima[:12]
        table = {name: [getattr(one, name) for one in optima] for name in ("x_m", "y_m", "z_m", "phase")}
        found = told(table, bird, model=MODELS[model], objective=objective, bounds="paper")
        cost = np.array([one.cost for one in optima])
        # Another balance at the same place may cost less; none costs more.
        assert np.all(found["cost"] <= cost * (1.0 + 1e-8))
        is_own = found["cost"].to_numpy() > cost * (1.0 - 1e-6)
        assert found["cost"][is_own].to_numpy() == pytest.approx(cost[is_own], rel=1e-8)
        for name in ("amplitude_m", "upstroke_span_ratio"):
            expected = np.array([getattr(one, name) for one in optima])
            assert found[name][is_own].to_numpy() == pytest.approx(expected[is_own], abs=1e-6)
        assert np.count_nonzero(is_own) >= len(optima) - 2

    def test_the_papers_v_optimum_is_a_knifes_edge(self):
        best = solve_pair(IBIS, "power", search=SearchSettings(tolerance=1e-2)).v_optimum
        place = {"y_m": [best.y_m] * 3, "z_m": [best.z_m] * 3, "phase": [best.phase] * 3}
        found = evaluate(IBIS, pd.DataFrame({"x_m": best.x_m + np.array([0.0, 0.01, -0.01])} | place))
        assert found["saving_total"][0] == pytest.approx(0.166, abs=1e-3)
        assert found["saving_total"][1:].min() == pytest.approx(0.04, abs=0.005)
        assert found["share_of_attainable"][0] == pytest.approx(1.0, abs=1e-6)
        assert found["distance_to_optimum_m"].to_numpy() == pytest.approx([0.0, 0.01, 0.01], abs=1e-6)

    def test_along_an_endless_wake_the_distance_goes_by_the_spatial_phase(self):
        wavelength = IBIS.wavelength_m
        table = {"x_m": [1.0, 1.0 + wavelength, 1.5], "y_m": [1.1] * 3, "z_m": [0.0] * 3}
        table["phase"] = [(x / wavelength) % 1.0 for x in table["x_m"]]
        found = evaluate(IBIS, pd.DataFrame(table), model=LIMIT)
        assert found["spatial_phase"].to_numpy() == pytest.approx(0.0, abs=1e-12)
        assert found["saving_total"].to_numpy() == pytest.approx(found["saving_total"][0], abs=1e-9)
        assert np.ptp(found["distance_to_optimum_m"]) < 1e-9


class TestRows:
    def test_columns_are_those_declared_and_others_are_passed_through(self):
        found = told(seen(bird=["Amy"], note=["first"]))
        names = [column.name for column in EVALUATION if column.name != "leader"]
        assert list(found) == ["bird", "note", *names]
        assert found["bird"][0] == "Amy"

    def test_a_stroke_balances_by_the_plain_statement(self):
        found = told(seen(), model=LIMIT).iloc[0]
        pose = Pose(1.2, 0.9, 0.0, Stroke(found["amplitude_m"], found["upstroke_span_ratio"]), 0.3)
        own, wake = IBIS.self_force_n(pose.stroke), wake_force(IBIS, IBIS.stroke, pose, LIMIT)
        assert own[0] + wake[0] == pytest.approx(IBIS.weight_n, rel=1e-10)
        assert own[1] + wake[1] == pytest.approx(IBIS.drag_n, rel=1e-10)
        assert found["saving_induced"] == pytest.approx(1.0 - (own[0] / IBIS.weight_n) ** 2, abs=1e-12)
        assert found["saving_profile"] == pytest.approx(1.0 - own[1] / IBIS.drag_n, abs=1e-12)

    def test_a_bird_on_the_left_is_mirrored(self):
        right, left = told(seen()), told(seen(y_m=[-0.9]))
        assert right["saving_total"][0] == left["saving_total"][0]
        assert left["y_m"][0] == -0.9

    def test_what_is_missing_is_optimised(self):
        table = {"x_m": [1.2, 1.2], "y_m": [0.904] * 2, "z_m": [0.0, None], "phase": [None, 0.5]}
        found = told(table)
        assert found["saving_total"][0] == found["saving_best_phase"][0] == pytest.approx(0.003, abs=5e-4)
        assert found["saving_worst_phase"][0] < found["saving_mean_phase"][0] < found["saving_best_phase"][0]
        assert found["saving_mean_phase"].isna()[1] and found["saving_mean_height"].isna()[0]
        assert abs(found["z_m"][1]) <= 0.5 * IBIS.amplitude_m + 1e-12
        assert found["saving_worst_height"][1] < found["saving_mean_height"][1] < found["saving_total"][1]

    def test_outcomes(self):
        table = {"x_m": [1.2, 1.2, 1.875, -0.4], "y_m": [0.904, 0.904, 0.0, 0.9], "z_m": 0.0}
        table["phase"] = [0.5, 0.0, 0.5, 0.0]
        assert list(told(table)["outcome"]) == ["saves", "pays", "saves", "invalid"]
        found = told(table, model=LIMIT)
        assert list(found["outcome"]) == ["saves", "saves", "no-balance", "invalid"]
        assert found["reason"][2].startswith("short of thrust, by 11 %")
        assert "ahead of it" in found["reason"][3]
        assert found["saving_total"].isna().tolist() == [False, False, True, True]
        assert set(found["outcome"]) <= set(OUTCOMES)

    def test_a_bird_that_pays_needs_more_than_the_papers_bounds_allow(self):
        table = seen(y_m=[0.904], phase=[0.0])
        assert told(table)["outside_paper_bounds"][0]
        assert told(table)["amplitude_to_alone"][0] > 1.0
        assert told(table, bounds="paper")["outcome"][0] == "no-balance"

    def test_mass_speed_and_period_of_a_row_are_those_of_its_birds(self):
        table = {"x_m": [1.2] * 4, "y_m": [0.9] * 4, "z_m": 0.0, "phase": 0.3}
        table |= {"mass_kg": [None, 1.6, None, None], "speed_m_s": [None, None, 13.0, None]}
        table |= {"period_s": [None, None, None, 0.22]}
        found = told(table, SPECIES)
        for row, changed in enumerate([{}, {"mass_kg": 1.6}, {"speed_m_s": 13.0}, {"period_s": 0.22}]):
            alone = told(seen(), SPECIES.bird(**changed))
            assert found["saving_total"][row] == pytest.approx(alone["saving_total"][0], abs=1e-12)
        assert found["saving_total"].nunique() == 4

    def test_errors_give_an_interval(self):
        found = told(seen(), sigma_m=0.05)
        assert found["saving_total_low"][0] < found["saving_total"][0] < found["saving_total_high"][0]
        in_semispans = told(seen(), sigma=0.05 / IBIS.semispan_m)
        assert in_semispans["saving_total_low"][0] == pytest.approx(found["saving_total_low"][0], abs=1e-12)
        by_column = told(seen(sigma_x_m=[0.05], sigma_y_m=[0.05], sigma_z_m=[0.05]))
        assert by_column["saving_total_low"][0] == pytest.approx(found["saving_total_low"][0], abs=1e-12)
        with_phase = told(seen(), sigma_m=0.05, sigma_phase=0.1)
        assert with_phase["saving_total_low"][0] != found["saving_total_low"][0]

    def test_flags(self):
        table = {"x_m": [1.2, 4.0], "y_m": [0.9, 1.3], "z_m": [0.0, 0.0], "phase": [0.3, 0.3]}
        found = told(table)
        assert found["wings_overlap"].tolist() == [True, False]
        assert found["beyond_wake"].tolist() == [False, True]
        assert not told(table, model=LIMIT)["beyond_wake"].any()


class TestReading:
    def test_other_names_and_units(self):
        table = {"behind_cm": [120.0], "right": [0.9], "up_mm": [50.0], "lag": [0.3], "mass_g": [1300.0]}
        reading = Reading(
            {"behind_cm": "x_m", "right": "y_m", "up_mm": "z_m", "lag": "phase", "mass_g": "mass_kg"}
        )
        found = told(table, reading=reading)
        plain = told(seen(z_m=[0.05], mass_kg=[1.3]))
        assert found["saving_total"][0] == pytest.approx(plain["saving_total"][0], abs=1e-12)
        assert found["behind_cm"][0] == 120.0

    @pytest.mark.parametrize(
        ("reading", "phase"),
        [
            (Reading(phase_unit="deg"), 108.0),
            (Reading(phase_unit="rad"), 0.6 * np.pi),
            (Reading(phase_unit="beats"), 7.3),
            (Reading(phase_sign="lead"), 0.7),
            # The follower's own phase when the leader begins its downstroke.
            (Reading(phase_at="downstroke-start"), 0.7),
            (Reading(phase_at="upstroke-start"), 0.2),
        ],
    )
    def test_phases(self, reading, phase):
        assert told(seen(phase=[phase]), reading=reading)["phase"][0] == pytest.approx(0.3, abs=1e-12)

    @pytest.mark.parametrize(
        ("table", "words"),
        [
            ({"x": [1.0], "y_m": [1.0]}, ["x_m: expected such a column", "found x, y_m"]),
            ({"x_m;y_m": ["1;1"]}, ["separate the columns by commas"]),
            (seen(x_m=[600.0]), ["expected metres relative to the leader", "centimetres", "--pairs"]),
            (seen(phase=[108.0]), ["--phase-unit deg"]),
            (seen(phase=[3.1]), ["--phase-unit rad"]),
        ],
    )
    def test_a_table_that_cannot_be_read_is_one_line(self, table, words):
        with pytest.raises(UpwashError) as error:
            told(table)
        assert "\n" not in str(error.value)
        assert all(word in str(error.value) for word in words), str(error.value)

    @pytest.mark.parametrize(
        ("columns", "words"),
        [
            ({"x_m": ["abc"]}, "x_m: expected a number, found 'abc'"),
            ({"y_m": [None]}, "y_m: expected a number, found none"),
            ({"x_m": [float("inf")]}, "x_m: expected a finite number"),
            ({"z_m": ["high"]}, "z_m: expected a number, found 'high'"),
            ({"x_m": [0.0], "y_m": [0.0], "z_m": [0.0]}, "another place than the leader's own"),
            ({"mass_kg": [-1.0]}, "mass_kg: expected a number above 0"),
            ({"mass_kg": [1300.0]}, "mass_kg"),
            ({"speed_m_s": [0.0]}, "speed_m_s: expected a number above 0"),
            ({"sigma_x_m": [-0.1]}, "sigma_x_m: expected a number that is not negative"),
        ],
    )
    def test_a_row_that_cannot_be_used_says_so_and_keeps_its_place(self, columns, words):
        good = seen(phase=[0.5], mass_kg=[None], speed_m_s=[None], sigma_x_m=[None])
        bad = good | columns
        table = {name: [*good[name], *bad[name], *good[name]] for name in good} | {"id": [7, 7, 8]}
        found = told(table, SPECIES)
        assert list(found["id"]) == [7, 7, 8]
        assert list(found["outcome"]) == ["saves", "invalid", "saves"]
        assert words in found["reason"][1]

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            ({"sigma": 0.1, "sigma_m": 0.1}, "found both"),
            ({"sigma": -1.0}, "at least 0"),
            ({"wake": "all-upstream"}, "--pairs"),
            ({"heading_deg": 30.0}, "--pairs"),
            ({"bounds": "narrow"}, "bounds: expected one of paper, wide"),
            ({"objective": "joy"}, "objective: expected one of"),
            ({"model": replace(LIMIT, span_nodes=5)}, "span_nodes"),
        ],
    )
    def test_a_wrong_option_is_one_line(self, options, words):
        with pytest.raises(UpwashError, match=words):
            told(seen(), **options)

    def test_an_empty_table_gives_an_empty_one(self):
        assert len(told({"x_m": [], "y_m": []})) == 0


class TestPairs:
    TABLE = pd.DataFrame(
        {
            "time": [0, 0, 0, 1, 1],
            "bird": ["A", "B", "C", "A", "B"],
            "x_m": [0.0, 1.2, 2.4, 10.0, 11.2],
            "y_m": [0.0, 0.9, 1.9, 5.0, 4.1],
            "z_m": [100.0, 100.0, 100.1, 90.0, 90.0],
            "phase": [0.9, 0.6, 0.2, 0.1, 0.8],
        }
    )

    def test_each_bird_follows_the_nearest_ahead(self):
        found = told(self.TABLE, pairs=True)
        assert list(found["leader"]) == [None, "A", "B", None, "A"]
        assert list(found["outcome"])[0] == "leads" and found["reason"][0] == "no bird ahead"
        assert found["x_m"].to_numpy()[[1, 2, 4]] == pytest.approx([1.2, 1.2, 1.2])
        assert found["y_m"].to_numpy()[[1, 2, 4]] == pytest.approx([0.9, 1.0, -0.9])
        assert found["z_m"].to_numpy()[[1, 2, 4]] == pytest.approx([0.0, 0.1, 0.0], abs=1e-12)
        # Whose own phase is less far lags.
        assert found["phase"].to_numpy()[[1, 2, 4]] == pytest.approx([0.3, 0.4, 0.3])
        alone = told({"x_m": [1.2], "y_m": [0.9], "z_m": [0.0], "phase": [0.3]})
        assert found["saving_total"][1] == pytest.approx(alone["saving_total"][0], abs=1e-9)
        assert found["saving_total"][4] == pytest.approx(alone["saving_total"][0], abs=1e-9)

    @pytest.mark.parametrize("heading", [0.0, 37.0, 250.0])
    def test_a_compass_bearing_turns_the_table(self, heading):
        angle = np.radians(heading)
        behind, right = self.TABLE["x_m"], self.TABLE["y_m"]
        turned = self.TABLE.assign(
            x_m=-behind * np.sin(angle) + right * np.cos(angle),
            y_m=-behind * np.cos(angle) - right * np.sin(angle),
        )
        plain = told(self.TABLE, pairs=True)
        for found in (
            told(turned, pairs=True, heading_deg=heading),
            told(turned.assign(heading_deg=heading + np.array([-3.0, 0.0, 3.0, -2.0, 2.0])), pairs=True),
        ):
            assert list(found["leader"]) == list(plain["leader"])
            for name in ("x_m", "y_m", "saving_total"):
                assert found[name].to_numpy() == pytest.approx(plain[name].to_numpy(), nan_ok=True, abs=1e-9)

    @pytest.mark.parametrize("model", MODELS)
    def test_all_wakes_upstream_add_up(self, model):
        found = told(self.TABLE, pairs=True, wake="all-upstream", model=MODELS[model])
        row = found.iloc[2]
        stroke = Stroke(row["amplitude_m"], row["upstroke_span_ratio"])
        force = np.array(IBIS.self_force_n(stroke))
        for x, y, z, phase in ((1.2, 1.0, 0.1, 0.4), (2.4, 1.9, 0.1, 0.7)):
            force += wake_force(IBIS, IBIS.stroke, Pose(x, y, z, stroke, phase), MODELS[model])
        assert force == pytest.approx([IBIS.weight_n, IBIS.drag_n], rel=1e-10)
        near = told(self.TABLE, pairs=True, model=MODELS[model])
        assert near["saving_total"][2] != row["saving_total"]
        assert near["saving_total"][1] == found["saving_total"][1]

    def test_several_wakes_need_phases(self):
        found = told(self.TABLE.drop(columns="phase"), pairs=True, wake="all-upstream")
        assert found["outcome"][1] == "saves" and found["outcome"][2] == "invalid"
        assert "phase of each bird ahead" in found["reason"][2]

    def test_broken_rows_are_told_and_lead_nobody(self):
        table = self.TABLE.copy()
        table.loc[1, "x_m"] = np.nan
        table = pd.concat([table, table.iloc[[4]]], ignore_index=True)
        found = told(table, pairs=True)
        assert list(found["outcome"]) == [
            "leads",
            "invalid",
            found["outcome"][2],
            "leads",
            "invalid",
            "invalid",
        ]
        assert found["leader"][2] == "A"
        assert "more than once" in found["reason"][4] and "more than once" in found["reason"][5]

    def test_two_birds_abreast_both_lead(self):
        table = {"time": [0, 0], "bird": [1, 2], "x_m": [0.0, 0.0], "y_m": [0.0, 2.0]}
        assert list(told(table, pairs=True)["outcome"]) == ["leads", "leads"]

    def test_a_table_without_birds_is_one_line(self):
        with pytest.raises(UpwashError, match="time: expected such a column, found x_m, y_m, z_m, phase"):
            told(seen(), pairs=True)


def test_the_made_ibises_of_the_page_are_those_of_the_script():
    page = renew_observed.PAGE.read_text(encoding="utf-8")
    assert renew_observed.TITLE + renew_observed.made_text() + "```" in page


class TestTally:
    def test_pieces_come_to_the_same_as_the_whole(self):
        table = {"x_m": [1.2, 1.3, -1.0, 1.2], "y_m": [0.9, 1.0, 1.0, 0.904], "z_m": 0.0}
        found = evaluate(
            IBIS, pd.DataFrame(table | {"phase": [0.3, 0.4, 0.1, None], "id": ["a", "b", "b", "c"]})
        )
        tally = EvaluationTally()
        tally.add(found.iloc[:2])
        tally.add(found.iloc[2:])
        assert tally.rows == 4 and tally.outcomes["invalid"] == 1
        assert tally.median_saving() == pytest.approx(found["saving_total"].median())
        assert tally.ids_twice() == 2
        assert tally.phase_statistics()[0] == 2

    def test_rayleighs_test_agrees_with_its_table(self):
        # Zar (2010), examples 26.1 and 27.1: eight directions, r = 0.82522, p between 0.001 and 0.002.
        count, mean, length, p = rayleigh(np.array([45, 55, 81, 96, 110, 117, 132, 154]) / 360.0)
        assert (count, round(360.0 * mean)) == (8, 99)
        assert length == pytest.approx(0.82522, abs=1e-5)
        assert 0.001 < p < 0.002

    def test_phases_at_random_have_no_preferred_one(self):
        assert rayleigh(np.arange(20) / 20.0)[3] == pytest.approx(1.0)


def test_the_walk_of_the_page_takes_at_most_eight_commands():
    page = renew_observed.PAGE.read_text(encoding="utf-8")
    walk = page.partition("## From a bird of one's own to a figure")[2].partition("\n## ")[0]
    assert 4 <= walk.count("\n$ upwash ") <= 8
    assert all(f"\n$ upwash {name} " in walk for name in ("species new", "species check", "evaluate", "map"))
