"""The command ``upwash optimum``: what it prints, what it takes, and what it refuses."""

import json

import pytest
from click.testing import CliRunner
from upwash import columns as of
from upwash.cli import main
from upwash.errors import UpwashError
from upwash.jobs.pair import Pair
from upwash.study.limit_ranges import SAMPLES
from upwash.sweep import read_sweep
from upwash.sweep.single import jobs_within_ranges, single_job

IBIS = "northern-bald-ibis"


def optimum(*arguments):
    return CliRunner().invoke(main, ["optimum", *arguments], prog_name="upwash")


def job(*settings, species=IBIS, amplitude="stroke-angle", objective="force", seed=0, tolerance=1e-4):
    return single_job(Pair, species, settings, amplitude, objective=objective, seed=seed, tolerance=tolerance)


class TestPrints:
    @pytest.fixture(scope="class")
    @classmethod
    def text(cls):
        """Everything about the paper's pair, for its first objective."""
        result = optimum(IBIS, "--all")
        assert result.exit_code == 0
        assert result.stderr.startswith("solved in ")
        return result.stdout

    @pytest.fixture(scope="class")
    @classmethod
    def record(cls):
        """The same pair for the paper's second objective, as JSON."""
        result = optimum(IBIS, "--objective", "power", "--json")
        assert result.exit_code == 0
        return json.loads(result.stdout, parse_constant=pytest.fail)

    @staticmethod
    def line(text, beginning):
        return next(
            line.removeprefix(beginning).split() for line in text.splitlines() if line.startswith(beginning)
        )

    def test_both_optima_in_si_units_and_the_birds_own(self, text):
        assert self.line(text, "quantity ") == ["unit", "V", "optimum", "global", "optimum"]
        assert self.line(text, "x, downstream of the leader")[:2] == ["m", "1.8178"]
        assert "wavelengths" in text and "semispans" in text and "amplitudes h_L" in text
        assert self.line(text, "placement") == ["outboard", "inboard"]

    def test_gap_proof_and_savings(self, text):
        assert self.line(text, "cost above the best's") == ["%", "0.30", "0.00"]
        assert self.line(text, "proof") == ["proved", "to", "1.0e-4"] * 2
        assert self.line(text, "imbalance of lift or thrust") == ["below", "1.0e-9"] * 2
        assert self.line(text, "saving of total power")[:2] == ["%", "11.41"]

    def test_every_optimum_with_its_evidence(self, text):
        head = self.line(text, "rank ")
        assert {"hits", "bounds", "edges", "stationarity", "placement", "tier", "station", "κ"} <= set(head)
        table = text[text.index("rank ") :].split("\n\n")[0].splitlines()[1:]
        assert [row.split()[0] for row in table] == [str(number) for number in range(len(table))]
        assert len(table) >= 10
        assert sum(row.split()[1] == "V" for row in table) == 1
        assert "left wingtip down on right tip of upstroke ring (leader up)" in text

    def test_json_is_the_columns_of_the_results(self, record):
        whose = of.OUTCOME, of.PROBLEM, of.AHEAD, of.AHEAD_STROKE, of.SEARCH, of.EFFORT, of.PROOF
        of_the_job = of.names(of.belonging(*whose))
        assert list(record) == [*of_the_job, "optima"]
        of_an_optimum = of.names(of.belonging(of.JOB, of.OPTIMUM))
        assert all(tuple(one) == of_an_optimum for one in record["optima"])
        assert [one["rank"] for one in record["optima"]] == list(range(len(record["optima"])))
        assert record["job_id"] == job(objective="power").job_id

    def test_json_holds_both_optima(self, record):
        (v,) = (one for one in record["optima"] if one["is_v_optimum"])
        best = record["optima"][0]
        assert best["is_global_optimum"] and not v["is_global_optimum"]
        assert v["cost"] / best["cost"] - 1 == pytest.approx(0.0351, abs=1e-4)
        assert record["global_certified_gap"] <= 1e-4 * (1 + 1e-6)

    def test_that_no_follower_can_fly_is_a_result(self):
        # A follower's span ratio is 0.5 at most, and the wake does not carry what it then lacks in lift.
        result = optimum(IBIS, "--set", "upstroke_span_ratio=0.75")
        assert result.exit_code == 0
        assert result.stdout.startswith(f"{IBIS}, least force: no optimum: no position within the bounds")
        assert "(this is proved)" in result.stdout


class TestTakes:
    def test_the_job_is_that_of_a_sweep(self, tmp_path):
        sweep = tmp_path / "sweep.toml"
        lines = ['species = "mute-swan"', 'amplitude = "strouhal"', "seed = 3", "[fixed]", "speed_m_s = 14"]
        sweep.write_text("\n".join([*lines, "span_nodes = 5"]), encoding="utf-8")
        same = job("speed_m_s=14", "span_nodes=5", species="mute-swan", amplitude="strouhal", seed=3)
        assert read_sweep(sweep).jobs == [same]
        assert read_sweep(sweep).jobs[0].job_id == same.job_id

    def test_a_path_is_a_species(self, tmp_path):
        from upwash.species.library import LIBRARY_FOLDER

        path = tmp_path / "my-bird.toml"
        path.write_text((LIBRARY_FOLDER / f"{IBIS}.toml").read_text(encoding="utf-8"), encoding="utf-8")
        assert job(species=str(path)).species == "my-bird"

    def test_an_amplitude_that_is_set_is_no_conventions(self):
        assert job("amplitude_m=0.9").amplitude_convention == "given"
        assert job("amplitude_m=0.9").bird.amplitude_m == 0.9


class TestRefuses:
    @pytest.mark.parametrize(
        ("setting", "words"),
        [
            ("speed", "NAME=VALUE"),
            ("speed=12", "did you mean 'speed_m_s'"),
            ("stroke_states=1", "stroke_states: expected a whole number"),
            ("speed_m_s=", "positive, finite number"),
            ("speed_m_s=fast", "'fast'"),
            ("mass_kg=-1", "'-1'"),
            ("mass_kg=nan", "'nan'"),
            ("mass_kg=inf", "'inf'"),
            ("span_nodes=2.5", "whole number"),
            ("span_nodes=1", "at least 2"),
            ("upstroke_span_ratio=1", "strictly between 0 and 1"),
            ("upstroke_span_ratio=0.9", "makes thrust"),
            ("amplitude_m=1.3", "at most the wingspan"),
            ("stroke_half_angle_deg=91", "at most 90"),
        ],
    )
    def test_an_input_that_makes_no_bird(self, setting, words):
        with pytest.raises(UpwashError, match=words.replace("(", r"\(")) as raised:
            job(setting)
        assert "expected " in str(raised.value) and "found " in str(raised.value)

    def test_an_input_twice(self):
        with pytest.raises(UpwashError, match="speed_m_s: expected each input once"):
            job("speed_m_s=12", "speed_m_s=13")

    @pytest.mark.parametrize("tolerance", [0.0, 1.0, -1e-4, float("nan")])
    def test_a_tolerance_that_is_no_fraction(self, tolerance):
        with pytest.raises(UpwashError, match="between 0 and 1"):
            job(tolerance=tolerance)

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (["--objective", "speed"], "cost_of_transport"),
            (["--amplitude", "large"], "strouhal"),
            (["--seed", "-1"], "--seed"),
            (["--tolerance", "small"], "--tolerance"),
            (["--set", "speed=12"], "speed_m_s"),
            (["--set"], "--set"),
        ],
    )
    def test_an_option_in_one_line_with_exit_2(self, options, words):
        result = optimum(IBIS, *options)
        assert (result.exit_code, result.stdout) == (2, "")
        assert len(result.stderr.splitlines()) == 1
        assert words in result.stderr


class TestLimit:
    """Behind an endless wake a saving is told for both span laws, with the interval of the species' own ranges."""

    @pytest.fixture(scope="class")
    @classmethod
    def record(cls):
        result = optimum(IBIS, "--model", "limit", "--objective", "power", "--json")
        assert result.exit_code == 0
        return json.loads(result.stdout, parse_constant=pytest.fail)

    def test_the_bird_itself_is_as_it_was_solved(self, record):
        best = record["optima"][0]
        own = {one["span_law"]: one["saving_total"] for one in record["ranges"]}
        assert own["stroke"] == pytest.approx(best["saving_total"], abs=1e-6)
        assert own["tip"] > own["stroke"] + 1e-3

    def test_the_interval_is_of_other_birds(self, record):
        for one in record["ranges"]:
            assert one["samples"] == SAMPLES
            assert 0.0 < one["saving_total_low"] < one["saving_total_high"] < 0.2

    def test_least_force_has_no_v_and_says_so_with_what_the_best_of_all_saves(self):
        printed = optimum(IBIS, "--model", "limit").stdout
        assert "There is no V optimum, outboard, level and astern" in printed
        assert "How sure that is: saving at the global optimum" in printed
        assert "\nstroke " in printed and "\ntip " in printed and "force saved" in printed

    def test_the_papers_model_has_no_such_table(self):
        result = optimum(IBIS, "--tolerance", "1e-2", "--json")
        assert "ranges" not in json.loads(result.stdout)

    def test_what_is_set_is_not_sampled(self):
        asked = {
            "species": IBIS,
            "amplitude": "stroke-angle",
            "objective": "power",
            "seed": 0,
            "tolerance": 1e-4,
        }
        jobs = jobs_within_ranges(
            4, 1, kind=Pair, settings=["speed_m_s=14", "amplitude_m=1.0"], model="limit", **asked
        )
        assert list(jobs) == ["stroke", "tip"]
        for law, of_law in jobs.items():
            assert len(of_law) == 5
            assert {one.model.span_law for one in of_law} == {law}
            assert {(one.bird.speed_m_s, one.bird.amplitude_m) for one in of_law} == {(14.0, 1.0)}
            assert len({one.bird.mass_kg for one in of_law}) == 5
        assert [one.bird for one in jobs["stroke"]] == [one.bird for one in jobs["tip"]]
