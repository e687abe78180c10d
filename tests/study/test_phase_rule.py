"""The phase rule: what is best and worst, how it is judged, and that both of ibises' rules come out in the limit."""

import json
from dataclasses import replace
from io import StringIO

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from report.studies import phase_frames
from upwash import WakeModel, load_species, solve_pair
from upwash.cli import main
from upwash.optimum.settings import SearchSettings
from upwash.report.phase_answer import phase_answer
from upwash.study.phase_rule import (
    CURVE,
    IN_LINE,
    NEAR_IN_LINE,
    NEAR_IN_V,
    NEAR_WORST,
    RULE,
    V,
    judge_rules,
    phase_curve,
    phase_rule,
    wrapped,
)
from upwash.study.sources import read_phase

IBIS = load_species("northern-bald-ibis").bird()
LIMIT = WakeModel.named("limit")
# y and z of the V optimum of least power, in m, by span law.
IN_V = {"stroke": (1.0846, 0.0), "tip": (0.8253, -0.0185)}


@pytest.fixture(scope="module")
def rules():
    """The rule of the ibis by each span law, at two distances, and all phases that were tried."""
    curves = {
        law: phase_curve(
            IBIS, "power", replace(LIMIT, span_law=law), {V: place, IN_LINE: (0.0, 0.0)}, (0.3, 0.8), 24
        )
        for law, place in IN_V.items()
    }
    return {law: (phase_rule(curve), curve) for law, curve in curves.items()}


CORES = [(core, radius) for core in ("rankine", "rosenhead-moore") for radius in (0.05, 0.1, 0.2, 0.3)]


@pytest.mark.thorough
@pytest.mark.parametrize("law", ["stroke", "tip"])
@pytest.mark.parametrize(("core", "radius"), CORES)
def test_both_observed_rules_come_out_of_every_core(core, radius, law):
    """The V's place is found by descents; the proof that nothing is better is not asked for."""
    model = replace(LIMIT, core=core, core_radius_ratio=radius, span_law=law)
    model = model.resolving(IBIS.wavelength_m / IBIS.semispan_m)
    in_v = solve_pair(IBIS, "power", model=model, search=SearchSettings(starts=60, most_boxes=1)).v_optimum
    places = {V: (in_v.y_m, in_v.z_m), IN_LINE: (0.0, 0.0)}
    rule = phase_rule(phase_curve(IBIS, "power", model, places, (0.5,), 24))
    judged = judge_rules(rule)
    assert judged["limit"].tolist() == [NEAR_IN_V, NEAR_IN_LINE, NEAR_WORST, 0.0]
    assert judged["holds"].all(), judged


@pytest.mark.thorough
class TestIbis:
    @pytest.mark.parametrize("law", IN_V)
    def test_both_observed_rules_come_out(self, rules, law):
        judged = judge_rules(rules[law][0])
        assert len(judged) == 4
        assert judged["holds"].all(), judged
        assert rules[law][0]["as_observed"].all()

    @pytest.mark.parametrize("law", IN_V)
    def test_phase_moves_one_wingbeat_a_wavelength(self, rules, law):
        for _, at in rules[law][0].groupby("formation"):
            near, far = at["phase_best"]
            assert wrapped(far - near - 0.5) == pytest.approx(0.0, abs=1e-3)
            assert at["saving_best"].to_numpy() == pytest.approx(at["saving_best"].iloc[0], abs=1e-6)

    def test_in_line_in_phase_it_cannot_fly(self, rules):
        for rule, _ in rules.values():
            line = rule[rule["formation"] == IN_LINE]
            assert (line["share_without_balance"] > 0.05).all()
            assert line["saving_worst"].isna().all()
            assert (rule.loc[rule["formation"] == V, "share_without_balance"] == 0.0).all()

    def test_what_a_v_saves_is_what_its_optimum_saves(self, rules):
        for law, saved in (("stroke", 0.0406), ("tip", 0.0441)):
            assert rules[law][0]["saving_best"].max() == pytest.approx(saved, abs=2e-4)

    @pytest.mark.parametrize("law", IN_V)
    def test_what_is_kept_of_it_is_found_again(self, rules, law):
        kept = read_phase()
        kept = phase_rule(kept[(kept["model"] == "limit") & (kept["span_law"] == law)])
        for formation, fresh in rules[law][0].groupby("formation"):
            before = kept[kept["formation"] == formation]
            for column in ("spatial_phase_best", "saving_best", "spatial_phase_worst"):
                # The span of phases in which it cannot fly is known to one of those that are tried.
                near = 0.03 if column == "spatial_phase_worst" else 2e-3
                apart = [wrapped(now - then) for now in fresh[column] for then in before[column]]
                assert np.abs(apart).max() < near, column

    def test_the_papers_model_cannot_say_it(self):
        curve = phase_curve(IBIS, "power", WakeModel(), {V: (0.8886, -0.1459), IN_LINE: (0.0, 0.0)})
        judged = judge_rules(phase_rule(curve)).set_index("rule")["holds"]
        assert not judged["in a V in phase"] and not judged["in line in antiphase"]
        assert not judged["in line always at a cost"]

    def test_every_phase_balances_or_says_what_it_lacks(self, rules):
        for _, curve in rules.values():
            flies = curve["saving_cost"].notna()
            assert (flies == (curve["missing"] == "")).all()
            assert (flies == curve["amplitude_m"].notna()).all()
            assert list(curve.columns) == [column.name for column in CURVE]


@pytest.mark.parametrize("law", IN_V)
def test_a_named_model_keeps_its_name_where_a_long_wave_needs_more_steps(law):
    bird = replace(IBIS, period_s=2.0 * IBIS.period_s)
    model = LIMIT.resolving(bird.wavelength_m / bird.semispan_m)
    assert model.stroke_states > LIMIT.stroke_states
    curve = phase_curve(bird, "power", replace(model, span_law=law), {V: IN_V["stroke"]}, (0.3,), 1)
    assert set(curve["model"]) == {"limit"} and set(curve["span_law"]) == {law}


class TestRule:
    def rule(self, saving):
        """Return the rule of a formation whose saving is a function of the spatial phase; NaN where it cannot fly."""
        rows = [
            dict.fromkeys([column.name for column in CURVE], 0.0)
            | {
                "model": "limit",
                "formation": V,
                "span_law": "tip",
                "phase": phase,
                "spatial_phase": wrapped(-phase),
            }
            | {"saving_cost": saving(wrapped(-phase))}
            for phase in np.arange(16) / 16
        ]
        (row,) = phase_rule(pd.DataFrame(rows)).to_dict("records")
        return row

    def test_best_worst_and_harmonic_of_a_cosine(self):
        row = self.rule(lambda at: 0.02 + 0.03 * np.cos(2.0 * np.pi * (at - 0.25)))
        assert (row["spatial_phase_best"], row["harmonic_phase"]) == pytest.approx((0.25, 0.25))
        assert row["spatial_phase_worst"] == pytest.approx(-0.25)
        assert (row["saving_best"], row["saving_worst"]) == pytest.approx((0.05, -0.01))
        assert row["harmonic_size"] == pytest.approx(0.03)

    def test_a_second_harmonic_moves_the_best_and_not_the_first(self):
        row = self.rule(lambda at: np.cos(2.0 * np.pi * at) - 2.0 * np.cos(4.0 * np.pi * at))
        assert abs(row["spatial_phase_best"]) > 0.1
        assert row["harmonic_phase"] == pytest.approx(0.0, abs=1e-9)

    def test_where_it_cannot_fly_the_middle_of_that_is_the_worst(self):
        row = self.rule(lambda at: np.nan if abs(at) < 0.2 else 0.0)
        assert row["spatial_phase_worst"] == pytest.approx(0.0, abs=1e-9)
        assert np.isnan(row["saving_worst"])
        assert row["share_without_balance"] == pytest.approx(7 / 16)

    def test_a_bird_that_cannot_fly_at_all_keeps_no_rule(self):
        row = self.rule(lambda at: np.nan)
        assert np.isnan(row["phase_best"])
        assert row["as_observed"] is False or not row["as_observed"]


class TestJudging:
    @pytest.mark.parametrize(
        ("formation", "column", "at", "beyond"),
        [
            (V, "spatial_phase_best", NEAR_IN_V, NEAR_IN_V + 1e-6),
            (V, "spatial_phase_best", -NEAR_IN_V, -NEAR_IN_V - 1e-6),
            (IN_LINE, "spatial_phase_best", 0.5 - NEAR_IN_LINE + 1e-9, 0.5 - NEAR_IN_LINE - 1e-6),
            (IN_LINE, "spatial_phase_worst", NEAR_WORST, NEAR_WORST + 1e-6),
            (IN_LINE, "saving_best", 0.0, 1e-6),
        ],
    )
    def test_is_as_near_as_it_says(self, formation, column, at, beyond):
        good = {"formation": formation, "spatial_phase_best": 0.0 if formation == V else 0.5}
        good |= {"spatial_phase_worst": 0.0, "saving_best": -0.01}
        assert judge_rules(pd.DataFrame([good | {column: at}]))["holds"].all()
        assert not judge_rules(pd.DataFrame([good | {column: beyond}]))["holds"].all()
        # The one furthest from the rule counts.
        assert not judge_rules(pd.DataFrame([good, good | {column: beyond}]))["holds"].all()


class TestCommand:
    @pytest.fixture
    def phase(self, monkeypatch):
        asked = []

        def stand_in(bird, objective, models, search):
            asked.append((objective, [(model.name(6.25), model.span_law) for model in models]))
            return phase_frames()

        monkeypatch.setattr("upwash.study.phase_rule.phase_rules", stand_in)

        def run(*arguments):
            result = CliRunner().invoke(main, ["phase", "northern-bald-ibis", *arguments])
            assert result.exit_code == 0, result.output
            return result.stdout, asked[-1]

        return run

    def test_is_of_least_power_in_the_limit_by_both_laws(self, phase):
        text, asked = phase()
        assert asked == ("power", [("limit", "stroke"), ("given", "tip")])
        assert "best phase against distance, least power" in text
        assert "in a V in phase" in text and "cannot fly" in text

    @pytest.mark.parametrize(
        ("arguments", "models"),
        [
            (["--model", "paper"], [("paper", "tip")]),
            (["--set", "model=paper"], [("paper", "tip")]),
            (["--set", "span_law=tip"], [("given", "tip")]),
            (["--set", "span_law = stroke"], [("limit", "stroke")]),
        ],
    )
    def test_another_wake(self, phase, arguments, models):
        assert phase(*arguments)[1] == ("power", models)

    @pytest.mark.parametrize("objective", ["force", "power"])
    def test_without_a_v_optimum_it_says_so(self, objective):
        rule, _ = phase_frames()
        without = f"least {objective} has no V optimum"
        in_line = rule[rule["formation"] == IN_LINE]
        assert without in phase_answer("ibis", objective, in_line)
        assert without not in phase_answer("ibis", objective, rule)

    def test_json_and_csv_are_the_rows(self, phase):
        rows = json.loads(phase("--json")[0], parse_constant=pytest.fail)
        assert [list(row) for row in rows] == [[column.name for column in RULE]] * 2
        assert rows[1]["saving_worst"] is None
        frame = pd.read_csv(StringIO(phase("--csv", "--all")[0]))
        assert list(frame.columns) == [column.name for column in CURVE]
        assert len(frame) == 24

    def test_both_at_once_are_refused(self):
        result = CliRunner().invoke(main, ["phase", "northern-bald-ibis", "--json", "--csv"])
        assert (result.exit_code, result.stdout) == (2, "")
        assert len(result.stderr.splitlines()) == 1
