"""The command ``upwash flock``: what it prints, what it takes, and what it refuses."""

import json

import pytest
from click.testing import CliRunner
from upwash import columns as of
from upwash.cli import main
from upwash.sweep import read_sweep

IBIS = "northern-bald-ibis"


def flock(*arguments, code=0):
    result = CliRunner().invoke(main, ["flock", *arguments], prog_name="upwash")
    assert result.exit_code == code, result.output
    return result


def cells(text, beginning):
    """Return the rest of the first line that begins so, cell by cell."""
    lines = [line.split() for line in text.splitlines()]
    return next(line[1:] for line in lines if line and line[0] == beginning)


class TestPrints:
    @pytest.fixture(scope="class")
    @classmethod
    def text(cls):
        return flock(IBIS, "--birds", "4").stdout

    def test_what_was_asked(self, text):
        assert text.splitlines()[0] == (
            "northern-bald-ibis, echelon, least force; the wake of the bird ahead, 1 wavelength; "
            "amplitude at most that of the bird ahead"
        )

    def test_each_bird_from_the_front(self, text):
        assert cells(text, "1")[:5] == ["-", "0.000", "0.000", "+0.000", "0.000"]
        second = "1 1.818 0.880 -0.062 0.500 0.7458 0.3493 95.30 11.41 8.37 18.79 proved"
        assert " ".join(cells(text, "2")) == second
        assert cells(text, "4")[:5] == ["3", "5.438", "2.593", "+0.096", "0.500"]

    def test_what_taking_turns_brings(self, text):
        turns = text.partition("Taking turns")[2]
        assert cells(turns, "4") == ["9.05", "9.95"]

    def test_a_flock_that_ends_early_says_why(self):
        text = flock(IBIS, "--birds", "5", "--shape", "alternating", "--wake", "all-upstream").stdout
        assert (
            "bird 4: no V optimum: expected one outboard, level and astern of bird 3, found a proof" in text
        )
        assert cells(text, "3")[0] == "2"

    def test_what_each_bird_gives_up_when_all_are_improved_together(self):
        text = flock(IBIS, "--birds", "3", "--joint").stdout
        assert cells(text, "bird")[-3:] == ["given", "up", "%"]
        assert float(cells(text, "2")[-1]) > 0.0 > float(cells(text, "3")[-1])
        assert "all birds improved together: mean cost -0.0" in text


class TestJson:
    @pytest.fixture(scope="class")
    @classmethod
    def record(cls):
        result = flock(IBIS, "--birds", "3", "--shape", "vee", "--reading", "lone", "--json")
        return json.loads(result.stdout, parse_constant=pytest.fail)

    def test_holds_the_inputs_once_and_every_bird(self, record):
        assert (record["birds"], record["shape"], record["reading"]) == (3, "vee", "lone")
        assert [one["bird"] for one in record["flock"]] == [1, 2, 3]
        assert {"ahead_amplitude_m", *of.names(of.belonging(of.JOB, of.OPTIMUM))} <= set(record["flock"][2])
        assert not {"mass_kg", "leader_amplitude_m"} & set(record["flock"][2])

    def test_holds_what_taking_turns_brings(self, record):
        assert [one["birds"] for one in record["turns"]] == [2, 3]
        savings = [one["saving_total"] for one in record["flock"]]
        assert record["turns"][1]["saving_mean"] == pytest.approx(sum(savings) / 3)

    def test_is_the_job_of_a_sweep(self, record, tmp_path):
        path = tmp_path / "one.toml"
        path.write_text(
            f'species = "{IBIS}"\nkind = "flock"\n[flock]\nbirds = 3\nshape = "vee"\nreading = "lone"\n'
        )
        (job,) = read_sweep(path).jobs
        assert record["job_id"] == job.job_id

    def test_of_a_flock_improved_together_adds_what_was_given_up(self):
        record = json.loads(
            flock(IBIS, "--birds", "3", "--joint", "--json").stdout, parse_constant=pytest.fail
        )
        assert record["given_up"][0] == 0.0
        assert len(record["given_up"]) == len(record["flock"]) == 3
        assert record["stationarity"] < 1e-6


class TestRefuses:
    @pytest.mark.parametrize(
        ("arguments", "found"),
        [
            (["--birds", "1"], "1"),
            (["--shape", "ring"], "'ring'"),
            (["--wake", "none"], "'none'"),
            (["--reading", "both"], "'both'"),
            (["--wavelengths", "0"], "0"),
        ],
    )
    def test_what_makes_no_flock_in_one_line(self, arguments, found):
        result = flock(IBIS, *arguments, code=2)
        assert found in result.stderr
        assert arguments[0] in result.stderr
        assert result.stdout == ""
        assert len(result.stderr.strip().splitlines()) == 1

    def test_a_bird_that_is_not_there(self):
        assert "northern-bald-ibis" in flock("northern-bald-ibsi", code=2).stderr
