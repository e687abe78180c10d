"""The command speed: how fast a bird does best alone, behind another, and in flocks."""

import json
from io import StringIO

import pandas as pd
import pytest
from click.testing import CliRunner
from report import studies
from upwash.cli import main
from upwash.report.figures import journeys
from upwash.report.figures.drawing import as_bytes
from upwash.study.best_speed import SPEEDS

IBIS = "northern-bald-ibis"


def speed(*options):
    return CliRunner().invoke(main, ["speed", IBIS, "--tolerance", "1e-2", *options])


def test_json_and_csv_hold_the_declared_columns():
    result = speed("--birds", "1,2", "--json")
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)
    assert [list(row) for row in rows] == 8 * [[column.name for column in SPEEDS]]
    alone, follower, pair, turning = rows[4:]
    assert [row["who"] for row in rows[4:]] == ["alone", "follower", "flock", "flock"]
    # What the paper reports: the least power of a follower lies at a lower speed than a lone bird's.
    assert follower["speed_m_s"] < turning["speed_m_s"] < alone["speed_m_s"] == pair["speed_m_s"]
    assert alone["range_ratio"] == pair["range_ratio"] == 1.0
    assert turning["range_ratio"] == pytest.approx(1.095, abs=1e-3)
    assert all(row["proved"] for row in rows)
    kept = pd.read_csv(StringIO(speed("--birds", "1", "--csv").stdout))
    assert kept["speed_m_s"].tolist() == [rows[0]["speed_m_s"], rows[4]["speed_m_s"]]


def test_text_says_what_holds_a_speed():
    result = speed("--birds", "1", "--objective", "aerodynamic_power")
    assert result.exit_code == 0, result.stderr
    assert "alone, held at" in result.stdout


def test_body_drag_that_counts_twice_is_warned_of():
    result = speed("--birds", "1", "--amplitude", "drag")
    assert result.exit_code == 0, result.stderr
    assert "take --objective aerodynamic_power" in result.stderr
    assert (
        "Warning"
        not in speed("--birds", "1", "--amplitude", "drag", "--objective", "aerodynamic_power").stderr
    )


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--birds", "0"), "'0'"),
        (("--birds", "2,many"), "'many'"),
        (("--birds", "2000"), "at most 1000"),
        (("--birds", ""), "with commas between"),
        (("--set", "speed_m_s=12"), "what is sought"),
        (("--set", "mass_kg=1000"), "mass_kg"),
        (("--json", "--csv"), "leave one out"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(options, words):
    result = speed(*options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


def test_figures_of_speeds_and_of_a_flight_have_their_panels_and_are_the_same_each_time():
    speeds, flight = journeys.draw_speeds(studies.speed_frame()), journeys.draw_flight(studies.flight_frame())
    assert [axes.get_xlabel() for axes in speeds.axes] == 2 * ["birds that take turns"]
    assert [axes.get_ylabel() for axes in flight.axes] == ["kg", "W", "m/s", "m"]
    # Alone, and in the flock.
    assert [len(axes.lines) for axes in flight.axes] == 4 * [2]
    again = journeys.draw_speeds(studies.speed_frame())
    assert as_bytes(again, ".png") == as_bytes(speeds, ".png")
