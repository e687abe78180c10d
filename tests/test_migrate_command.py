"""The command migrate: a bird alone and a flock on the same fuel, kept as they fly, flown on, and refused."""

import json
from io import StringIO

import pandas as pd
import pytest
from click.testing import CliRunner
from upwash import load_species
from upwash.cli import main
from upwash.study.migration import MIGRATION

IBIS = "northern-bald-ibis"
QUICK = ("--tolerance", "1e-2", "--fuel", "0.1", "--speed", "held")


def migrate(*options):
    return CliRunner().invoke(main, ["migrate", IBIS, *options])


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A pair's flight, as it is printed and as it is kept."""
    path = tmp_path_factory.mktemp("flight") / "kept.json"
    result = migrate("--birds", "2", *QUICK, "--json", "--keep", str(path))
    assert result.exit_code == 0, result.stderr
    return json.loads(result.stdout), path


@pytest.mark.thorough
def test_json_and_csv_hold_the_declared_columns(pair):
    rows, _ = pair
    assert {tuple(row) for row in rows} == {tuple(column.name for column in MIGRATION)}
    result = migrate("--birds", "1", *QUICK, "--csv")
    kept = pd.read_csv(StringIO(result.stdout))
    alone = [row for row in rows if row["birds"] == 1]
    assert kept["distance_m"].tolist() == pytest.approx([row["distance_m"] for row in alone], rel=1e-12)


@pytest.mark.thorough
def test_a_pair_flies_further_than_a_bird_alone_and_every_step_balances(pair):
    rows, _ = pair
    alone, flock = ([row for row in rows if row["birds"] == birds] for birds in (1, 2))
    assert flock[-1]["distance_m"] > 1.05 * alone[-1]["distance_m"]
    assert flock[-1]["ended"] == alone[-1]["ended"] == "the fuel is spent"
    assert flock[-1]["mass_kg"] == pytest.approx(0.9 * 1.3, rel=1e-12)
    assert all(row["residual"] < 1e-8 for row in rows)
    assert [row["proof"] for row in flock].count("proved") == 11
    assert flock[0]["proof"] == flock[-1]["proof"] == "proved"
    assert all(row["speed_m_s"] == 15.0 for row in rows)
    assert 0.0 < flock[-1]["error_m"] < 1e-3 * flock[-1]["distance_m"]


@pytest.mark.thorough
def test_a_flight_that_was_killed_goes_on_to_the_same_end(pair, tmp_path):
    rows, path = pair
    content = json.loads(path.read_text())
    flown = content["flights"]["2"]
    # As it is kept after four tenths, and nothing proved.
    flown["steps"], flown["ended"], flown["proofs"] = flown["steps"][:5], "", {}
    cut = tmp_path / "cut.json"
    cut.write_text(json.dumps(content))
    result = migrate("--birds", "2", *QUICK, "--json", "--keep", str(cut))
    assert result.exit_code == 0, result.stderr
    again = json.loads(result.stdout)
    assert len(again) == len(rows)
    for row, other in zip(rows, again, strict=True):
        for column in MIGRATION:
            if isinstance(row[column.name], float) and column.name not in ("error_m", "residual"):
                agree = pytest.approx(row[column.name], rel=1e-7, abs=1e-6)
                assert other[column.name] == agree, column.name


@pytest.mark.thorough
def test_a_kept_flight_of_other_inputs_is_refused(pair):
    _, path = pair
    before = path.read_bytes()
    result = migrate("--birds", "2", *QUICK, "--wind", "3", "--keep", str(path))
    assert (result.exit_code, result.stdout) == (2, "")
    assert "other wind" in result.stderr
    assert path.read_bytes() == before


def test_a_tailwind_moves_ground_and_nothing_else_where_the_speed_is_held():
    still, windy = (
        json.loads(migrate("--birds", "1", *QUICK, "--wind", wind, "--json").stdout)[-1]
        for wind in ("0", "5")
    )
    assert windy["time_s"] == pytest.approx(still["time_s"], rel=1e-12)
    assert windy["distance_m"] == pytest.approx(still["distance_m"] * 20.0 / 15.0, rel=1e-9)
    assert windy["energy_j_m"] == pytest.approx(still["energy_j_m"], rel=1e-9)


@pytest.mark.thorough
def test_a_flock_without_a_v_says_so_in_its_row():
    # So slow and so heavy a wake leaves the third row no place in the V.
    result = migrate("--birds", "6", *QUICK, "--set", "speed_m_s=8", "--json")
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)
    assert rows[-1]["birds"] == 6
    assert "no V optimum" in rows[-1]["ended"]
    assert rows[-1]["distance_m"] == 0.0


def test_higher_up_the_air_is_thinner_and_a_profile_is_followed(tmp_path):
    table = tmp_path / "way.csv"
    table.write_text("distance_m,altitude_m\n0,0\n50000,1500\n")
    result = migrate("--birds", "1", *QUICK, "--profile", str(table), "--json")
    assert result.exit_code == 0, result.stderr
    rows = json.loads(result.stdout)
    assert rows[0]["density_kg_m3"] == pytest.approx(1.225, abs=1e-4)
    assert rows[-1]["altitude_m"] == 1500.0
    air = load_species(IBIS).bird(altitude_m=1500.0).density_kg_m3
    assert rows[-1]["density_kg_m3"] == pytest.approx(air, rel=1e-12)
    level = json.loads(migrate("--birds", "1", *QUICK, "--altitude", "1500", "--json").stdout)
    assert rows[-1]["distance_m"] < level[-1]["distance_m"]


def test_text_tells_both_ranges():
    result = migrate("--birds", "1", "--fuel", "0.1")
    assert result.exit_code == 0, result.stderr
    assert "Alone it flies" in result.stdout and "the fuel is spent" in result.stdout


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--fuel", "1"), "from 0 to below 1"),
        (("--fuel", "nan"), "from 0 to below 1"),
        (("--altitude", "12000"), "tropopause"),
        (("--altitude", "10000", "--set", "mass_kg=9"), "W/(rho b^2 U^2)"),
        (("--wind", "-99"), "headwind slower than the bird"),
        (("--wind", "-40", "--speed", "held"), "headwind slower than the bird"),
        (("--wind", "inf"), "-100 to 100"),
        (("--efficiency", "2"), "between 0 and 1"),
        (("--altitude", "0", "--profile", "way.csv"), "leave one out"),
        (("--altitude", "0", "--set", "density_kg_m3=1"), "leave one out"),
        (("--profile", "nowhere.csv"), "no such file"),
        (("--json", "--csv"), "leave one out"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(options, words):
    result = migrate("--birds", "1", *options)
    assert (result.exit_code, result.stdout) == (2, ""), result.stdout
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "line 1: expected columns"),
        ("distance_m,high_m\n0,0\n", "expected columns"),
        ("distance_m,altitude_m\n", "at least one altitude"),
        ("distance_m,altitude_m\n0,up\n", "two numbers"),
        ("distance_m,altitude_m\n5,0\n", "0 at take-off"),
        ("distance_m,altitude_m\n0,0\n0,5\n", "distances that grow"),
        ("distance_m,altitude_m\n0,-5\n", "not negative"),
        ("distance_m,altitude_m\n0,12000\n", "tropopause"),
    ],
)
def test_a_table_of_altitudes_that_is_none_is_refused_in_one_line(tmp_path, text, words):
    table = tmp_path / "way.csv"
    table.write_text(text)
    result = migrate("--birds", "1", "--profile", str(table))
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"inputs": {}, "flights": {"1": {}}}'])
def test_a_kept_flight_that_is_none_is_refused_and_left_alone(tmp_path, text):
    path = tmp_path / "kept.json"
    path.write_text(text)
    result = migrate("--birds", "1", *QUICK, "--keep", str(path))
    assert (result.exit_code, result.stdout) == (2, "")
    assert "no such" in result.stderr
    assert path.read_text() == text
