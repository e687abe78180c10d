"""The command `upwash evaluate`: tables in, tables out, piece by piece, and one line for what is no table."""

import json
from io import StringIO

import pandas as pd
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from upwash.cli import main

IBIS = "northern-bald-ibis"
TABLE = "ring,x_m,y_m,z_m,phase\n007,1.2,0.904,0,0.5\nNA,1.3,-1.1,0.05,0.45\n9,abc,1,0,0.1\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Return a function that evaluates a file of some content, with options."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("upwash.study.observed.evaluation.Evaluation.optimum", lambda self, bird: None)

    def run(content, *options, name="seen.csv"):
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
        return CliRunner().invoke(main, ["evaluate", IBIS, name, *options])

    return run


def test_every_output_tells_the_same_rows_in_their_order(run):
    as_json = json.loads(run(TABLE, "--json").stdout)
    result = run(TABLE, "--csv", "--output", "told.parquet")
    as_csv = pd.read_csv(StringIO(result.stdout), dtype={"ring": str}, keep_default_na=False)
    as_parquet = pd.read_parquet("told.parquet")
    assert (
        [row["ring"] for row in as_json]
        == list(as_csv["ring"])
        == list(as_parquet["ring"])
        == ["007", "NA", "9"]
    )
    assert [row["outcome"] for row in as_json] == list(as_csv["outcome"]) == list(as_parquet["outcome"])
    assert [row["saving_total"] for row in as_json][:2] == as_parquet["saving_total"].tolist()[:2]
    assert as_json[2]["saving_total"] is None and as_json[2]["outcome"] == "invalid"
    field = pq.read_schema("told.parquet").field("amplitude_m")
    assert field.metadata[b"unit"] == b"m" and field.metadata[b"description"]
    assert "1 rows cannot be used (first: x_m: expected a number, found 'abc')" in result.stderr


def test_parquet_is_read_as_csv_is(run, tmp_path):
    table = pd.DataFrame({"ring": [7, 8], "x_m": [1.2, 1.3], "y_m": [0.904, -1.1], "z_m": [0.0, 0.05]})
    table = table.assign(phase=[0.5, 0.45])
    table.to_parquet(tmp_path / "made.parquet")
    told = json.loads(run((tmp_path / "made.parquet").read_bytes(), "--json", name="seen.parquet").stdout)
    assert [row["ring"] for row in told] == [7, 8]
    assert told[0]["saving_total"] == json.loads(run(TABLE, "--json").stdout)[0]["saving_total"]


def test_a_table_in_pieces_is_told_as_one(run, monkeypatch):
    whole = run(TABLE, "--json", "--output", "whole.parquet")
    monkeypatch.setattr("upwash.study.observed.file.ROWS_AT_ONCE", 1)
    pieces = run(TABLE, "--json", "--output", "pieces.parquet")
    assert (pieces.exit_code, pieces.stdout) == (0, whole.stdout)
    assert pieces.stderr.replace("pieces", "whole") == whole.stderr
    assert pd.read_parquet("pieces.parquet").equals(pd.read_parquet("whole.parquet"))
    assert run(TABLE, "--csv").stdout.count("ring,") == 1


@pytest.mark.parametrize(
    ("content", "name", "words"),
    [
        ("", "seen.csv", "empty file"),
        ("x_m,y_m\n", "seen.csv", "expected a row for each bird, found none"),
        ("x_m,x_m,y_m\n1,1,1\n", "seen.csv", "'x_m' twice"),
        ("x_m,y_m\n1,1\n1,1,1\n", "seen.csv", "as many cells in each line"),
        ("x_m;y_m\n1;1\n", "seen.csv", "separate the columns by commas"),
        ("x_m,y_m\n1,\xe9\n".encode("latin-1"), "seen.csv", "UTF-8"),
        (b"no parquet", "seen.parquet", "expected a Parquet file"),
        ("x_m,y_m\n1,1\n", "seen.xlsx", "expected a table in .csv or .parquet"),
        ("behind,y_m\n1,1\n", "seen.csv", "x_m: expected such a column, found behind, y_m"),
        ("x_m,y_m\n600,1\n", "seen.csv", "centimetres"),
    ],
)
def test_what_is_no_table_is_one_line(run, content, name, words):
    result = run(content, "--csv", name=name)
    assert (result.exit_code, result.stdout) == (2, "")
    assert len(result.stderr.splitlines()) == 1 and words in result.stderr, result.stderr


def test_byte_order_mark_and_spaces_are_no_part_of_names(run):
    result = run("\ufeffx_m, y_m ,z_m,phase\n1.2,0.904,0,0.5\n", "--json")
    assert json.loads(result.stdout)[0]["outcome"] == "saves"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--csv", "--json"], "found both"),
        (["--output", "told.txt"], "ends in .parquet"),
        (["--columns", "behind"], "THEIRS=OURS"),
        (["--columns", "ring=wing"], "expected one of x_m"),
        (["--columns", "no=x_m"], "expected a column of the table"),
        (["--sigma", "-1"], "at least 0"),
    ],
)
def test_wrong_options_are_one_line_and_leave_nothing(run, tmp_path, options, words):
    result = run(TABLE, *options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr and len(result.stderr.splitlines()) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["seen.csv"]


def test_ids_that_stand_twice_are_told_and_kept(run):
    result = run("id,x_m,y_m,z_m,phase\na,1.2,0.9,0,0.5\na,1.3,0.9,0,0.5\n", "--json")
    assert [row["id"] for row in json.loads(result.stdout)] == ["a", "a"]
    assert "id: 2 rows share theirs with another" in result.stderr


FLIGHT = "time,bird,x_m,y_m\n" + "".join(
    f"{time},{bird},{x},{y}\n" for time in (1, 1, 2, 3) for bird, x, y in (("A", 0, 0), ("B", 1.2, 0.9))
).replace("1,A,0,0\n1,B,1.2,0.9\n1,A,0,0\n1,B", "1,A,0,0\n1,B,1.2,0.9\n1,C,2.4,0\n1,D")


class TestLongFlights:
    """More rows of birds at all times than are read at once."""

    def test_those_of_a_time_stay_together_wherever_a_piece_ends(self, run, monkeypatch):
        whole = run(FLIGHT, "--pairs", "--csv")
        assert whole.exit_code == 0 and whole.stdout.count("\n") == 9, whole.stderr
        monkeypatch.setattr("upwash.study.observed.file.ROWS_TOGETHER", 2)
        for rows in (1, 3, 4, 5):
            monkeypatch.setattr("upwash.study.observed.file.ROWS_AT_ONCE", rows)
            assert run(FLIGHT, "--pairs", "--csv").stdout == whole.stdout

    def test_a_time_that_comes_again_is_one_line_and_no_file(self, run, tmp_path, monkeypatch):
        content = FLIGHT + "1,E,3,1\n"
        assert run(content, "--pairs", "--csv").exit_code == 0
        monkeypatch.setattr("upwash.study.observed.file.ROWS_TOGETHER", 2)
        monkeypatch.setattr("upwash.study.observed.file.ROWS_AT_ONCE", 2)
        result = run(content, "--pairs", "--output", "told.parquet")
        assert result.exit_code == 2 and not (tmp_path / "told.parquet").exists()
        assert "found time 1 again after others; sort the table by time" in result.stderr


def test_one_follower_behind_two_leaders_and_one_ahead_of_its_own(run):
    flight = "time,bird,x_m,y_m,phase\n0,A,0,0,0.9\n0,B,0.1,1.8,0.8\n0,C,1.3,0.9,0.5\n"
    rows = json.loads(run(flight, "--pairs", "--json").stdout)
    # Behind two that are nearly abreast it follows the nearer, or feels both.
    assert [row["leader"] for row in rows] == [None, "A", "B"]
    both = json.loads(run(flight, "--pairs", "--wake", "all-upstream", "--json").stdout)
    assert both[2]["saving_total"] != rows[2]["saving_total"] and both[2]["leader"] == "B"
    told = json.loads(run("bird,x_m,y_m\nfirst,-0.5,1\nsecond,1.2,1\n", "--json").stdout)
    assert [row["outcome"] for row in told] == ["invalid", "saves"]
    assert "this bird is ahead of it" in told[0]["reason"]


def test_a_column_of_nothing_or_of_nan_is_as_if_it_were_not_there(run):
    bare = json.loads(run("x_m,y_m\n1.2,0.9\n", "--json").stdout)
    for content in (
        "x_m,y_m,phase\n1.2,0.9,\n",
        "x_m,y_m,phase\n1.2,0.9,NaN\n",
        "x_m,y_m,z_m\n1.2,0.9,nan\n",
    ):
        told = json.loads(run(content, "--json").stdout)
        assert told[0]["saving_total"] == bare[0]["saving_total"]
    nothing = json.loads(run("x_m,y_m\nNaN,0.9\n1.2,0.9\n", "--json").stdout)
    assert [row["outcome"] for row in nothing] == ["invalid", "saves"]
