"""The command `upwash map`: files, rows, words, and one line for what does not fit."""

import json
from io import StringIO

import pandas as pd
import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.study.saving_map import MAP

IBIS = "northern-bald-ibis"
SMALL = ("--size", "4", "--x-m", "0.6,2.8", "--y-m", "0.5,1.3", "--tolerance", "1e-2")
SEEN = "bird,x_m,y_m\nA,1.2,0.9\nB,1.0,-1.1\nC,-1.0,1.0\n"


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Return a function that maps in a folder that holds a table of birds."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "seen.csv").write_text(SEEN)
    return lambda *options: CliRunner().invoke(main, ["map", IBIS, *options])


@pytest.mark.thorough
def test_every_output_tells_the_same_places(run, tmp_path):
    result = run(*SMALL, "--csv", "--observed", "seen.csv")
    assert result.exit_code == 0, result.stderr
    as_csv = pd.read_csv(StringIO(result.stdout))
    assert list(as_csv) == [column.name for column in MAP] and len(as_csv) == 16
    stem = tmp_path / "results" / "map" / f"{IBIS}-power-xy-paper"
    as_parquet = pd.read_parquet(f"{stem}.parquet")
    as_json = json.loads(run(*SMALL, "--json").stdout)
    for name in ("saving_total", "outcome", "x_m"):
        assert list(as_csv[name]) == list(as_parquet[name]) == [row[name] for row in as_json]
    assert (stem.parent / f"{stem.name}.pdf").read_bytes().startswith(b"%PDF")
    assert (stem.parent / f"{stem.name}.png").read_bytes().startswith(b"\x89PNG")
    assert (
        "saves on" in result.stderr and "V optimum within the paper's bounds: 1.78 m behind" in result.stderr
    )


def test_what_evaluate_wrote_is_shown_as_dots(run, tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr("upwash.study.observed.evaluation.Evaluation.optimum", lambda self, bird: None)
    CliRunner().invoke(main, ["evaluate", IBIS, "seen.csv", "--output", "told.parquet"])
    monkeypatch.setattr(
        "upwash.report.figures.saving_map.draw_saving_map", lambda *given: seen.append(given[3])
    )
    monkeypatch.setattr("upwash.report.figures.catalogue.save_all", lambda *given: [])
    for table in ("seen.csv", "told.parquet"):
        result = run("--size", "2", "--observed", table)
        assert result.exit_code == 0, result.stderr
    # A bird ahead of its leader is no follower.
    assert [places[:, :2].tolist() for places in seen] == 2 * [[[1.2, 0.9], [1.0, -1.1]]]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--csv", "--json"], "found both"),
        (["--over", "z"], "upwash field"),
        (["--over", "z,stroke,wings"], "found 'wings'"),
        (["--x-m", "near"], "--x-m: expected a number, or two with a comma between, found 'near'"),
        (["--phase", "1,2,3"], "--phase: expected a number, or two"),
        (["--z-m", "0.1"], "z_m: expected LOW,HIGH or nothing"),
        (["--y-m", "0.1"], "y_m: expected LOW,HIGH or nothing"),
        (["--observed", "none.csv"], "none.csv"),
        (["--set", "span_nodes=exact"], "span_nodes"),
    ],
)
def test_what_does_not_fit_is_one_line(run, options, words):
    result = run("--size", "2", *options)
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr and len(result.stderr.splitlines()) == 1, result.stderr
