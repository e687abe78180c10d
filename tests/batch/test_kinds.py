"""Another kind of job is a module and a line: sweeps, runs, tables and commands then know it."""

import json

import pyarrow.parquet as pq
import pytest
from other_kind import Line
from upwash.jobs import kinds
from upwash.sweep import read_sweep

SWEEP = """\
kind = "line"
species = "northern-bald-ibis"
solver = "stub_solvers:two_optima"
[line]
birds = 4
"""


@pytest.fixture
def lines(bench, monkeypatch):
    """A sweep of another kind, and the kind made known."""
    monkeypatch.setitem(kinds.KINDS, Line.name, Line)
    (bench.folder / "sweep.toml").write_text(SWEEP)
    return bench


def test_its_table_in_a_sweep_is_read_by_its_rules(lines):
    (job,) = read_sweep(lines.folder / "sweep.toml").jobs
    assert job.kind == Line(birds=4) and job.inputs()["kind"] == "line"


def test_it_is_run_gathered_listed_compared_and_shown(lines):
    lines.run()
    lines("aggregate", "results/sweep")
    rows = pq.read_table(lines.results / "lines.parquet")
    assert rows.column("kind").to_pylist() == ["line"] * 2
    assert rows.column("flock_id").equals(rows.column("job_id"))
    assert pq.read_table(lines.results / "summary.parquet").num_rows == 1
    assert lines.status()["solved"] == 1
    lines("diff", "results/sweep", "results/sweep")
    shown = json.loads(lines("show", "results/sweep", rows["job_id"][0].as_py(), "--json")[0])
    assert [row["rank"] for row in shown] == [0, 1]
    assert "(done: solved)" in lines.run("--dry-run")[0]


def test_another_kinds_table_is_refused_by_its_name(lines):
    (lines.folder / "sweep.toml").write_text(SWEEP.replace('kind = "line"', 'kind = "flock"'))
    _, said = lines("run", "./sweep.toml", code=2)
    assert 'expected no such table in a sweep of flocks; write kind = "line" at the top' in said
