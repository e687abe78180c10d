"""The command robust: what is left of the best saving while a bird drifts."""

import json

import pandas as pd
import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.study.robustness import ROBUSTNESS

IBIS = "northern-bald-ibis"


def robust(*options):
    return CliRunner().invoke(main, ["robust", IBIS, "--tolerance", "1e-2", *options])


@pytest.mark.thorough
def test_json_and_csv_hold_the_declared_columns():
    result = robust("--sigma", "0.05,0.1", "--json")
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)
    assert [list(row) for row in rows] == 2 * [[column.name for column in ROBUSTNESS]]
    assert [row["sigma_m"] for row in rows] == pytest.approx([0.03, 0.06])
    assert [row["region"] for row in rows] == 2 * ["V"]
    assert rows[0]["saving_still"] > rows[0]["robust_saving_held"] > rows[0]["saving_held"] > 0.0
    from io import StringIO

    kept = pd.read_csv(StringIO(robust("--sigma-m", "0.03", "--csv").stdout))
    assert kept["saving_held"][0] == rows[0]["saving_held"]


def test_text_says_how_far_the_place_reaches():
    result = robust("--sigma", "0.05")
    assert result.exit_code == 0, result.stderr
    assert "saves 16.6 % of its power" in result.stdout
    assert "0.97 cm nearer or 0.82 cm farther" in result.stdout


@pytest.mark.thorough
def test_a_cost_without_v_says_so():
    result = robust("--model", "limit", "--objective", "force", "--sigma", "0.05")
    assert result.exit_code == 0, result.stderr
    assert "no V optimum" in result.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--sigma", "far"), "'far'"),
        (("--sigma", "0.1,-1"), "'-1'"),
        (("--sigma", "nan"), "'nan'"),
        (("--sigma", "2"), "from 0 to 1"),
        (("--sigma-m", "0.7"), "from 0 to 0.6"),
        (("--sigma", "0.1", "--sigma-m", "0.1"), "leave one out"),
        (("--sigma-phase", "-1"), "--sigma-phase"),
        (("--json", "--csv"), "leave one out"),
    ],
)
def test_what_is_no_deviation_is_refused_in_one_line(options, words):
    result = robust(*options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1
