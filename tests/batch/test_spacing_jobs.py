"""Limits of a follower's place as inputs of sweeps and commands: stored, checked, proved again, and refused."""

import json

import pyarrow.parquet as pq
import pytest
from upwash import columns as of
from upwash.batch.check import check, of_rows
from upwash.batch.folder import ResultsFolder
from upwash.jobs.job import Job
from upwash.jobs.pair import Pair
from upwash.optimum.spacing import UNITS

SWEEP = """\
species = "northern-bald-ibis"
objective = "power"
tolerance = 1e-2
[grid]
wingtip_gap_min_m = [-0.28, 0.0]
[fixed]
bearing_max_deg = 50
"""
FLOCK = """\
kind = "flock"
species = "northern-bald-ibis"
objective = "power"
tolerance = 1e-2
[flock]
birds = 3
shape = "alternating"
[fixed]
distance_min_m = 2.0
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory, logs):
    from conftest import Bench

    bench = Bench(tmp_path_factory.mktemp("spacing"), logs)
    for name, text in (("pairs", SWEEP), ("flock", FLOCK)):
        (bench.folder / f"{name}.toml").write_text(text)
        bench("run", f"./{name}.toml")
        bench("aggregate", f"results/{name}")
    return bench.folder / "results"


@pytest.mark.parametrize("name", ["pairs", "flock"])
def test_what_is_stored_is_in_order_and_proved_again(folder, name):
    assert check(ResultsFolder(folder / name), prove=True).findings == []


def test_rows_hold_the_limits_and_what_they_cost(folder):
    rows = pq.read_table(folder / "pairs" / "summary.parquet").to_pylist()
    assert sorted(row["wingtip_gap_min_m"] for row in rows) == [-0.28, 0.0]
    for row in rows:
        assert row["bearing_max_deg"] == 50.0 and row["x_min_m"] is None
        assert abs(row["y_m"]) - 2.0 * row["semispan_m"] == pytest.approx(row["wingtip_gap_min_m"], abs=1e-9)
        assert row["wingtip_gap_min_costs_per_m"] > 0.0 == row["bearing_max_costs_per_deg"]
        assert row["distance_min_costs_per_m"] is None


@pytest.mark.parametrize(("name", "file"), [("pairs", Pair.file), ("flock", "flock.parquet")])
def test_a_place_that_does_not_keep_them_is_refused(folder, name, file):
    rows = pq.read_table(folder / name / file).to_pylist()
    job = [row for row in rows if row["job_id"] == rows[0]["job_id"]]
    assert of_rows(job, "") == []
    number = len(job) - 1
    # Of limits and place nothing can be changed alone.
    for column, value in (("y_m", 0.9), ("x_m", 0.4), ("z_m", 0.0)):
        changed = [row | {column: value} if k == number else row for k, row in enumerate(job)]
        assert of_rows(changed, "")
    for column in UNITS:
        value = job[0][column]
        changed = [row | {column: 1.0 if value is None else None} for row in job]
        assert {found.column for found in of_rows(changed, "")} == {"job_id"}
    # With the id made to match, the place is what is wrong, or the evidence.
    tight = [row | {"distance_min_m": 6.0} for row in job]
    ids = {"job_id": Job.of(tight[0]).job_id}
    ids |= {"flock_id": ids["job_id"]} if "flock_id" in job[0] else {}
    found = of_rows([row | ids for row in tight], "")
    assert "distance_min_m" in {one.column for one in found}


def test_limits_that_are_left_out_leave_an_id_as_it_was(folder):
    row = pq.read_table(folder / "pairs" / "summary.parquet").to_pylist()[0]
    free = Job.of({name: value for name, value in row.items() if name not in UNITS})
    assert Job.of(free.inputs()).job_id == free.job_id != row["job_id"]
    assert Job.of(row).spacing.names == ("wingtip_gap_min_m", "bearing_max_deg")


def test_commands_take_them_as_options_and_as_settings(bench):
    one, _ = bench(
        "optimum", "northern-bald-ibis", "--wingtip-gap-min-m", "-0.28", "--tolerance", "1e-2", "--json"
    )
    other, _ = bench(
        "optimum", "northern-bald-ibis", "--set", "wingtip_gap_min_m=-0.28", "--tolerance", "1e-2", "--json"
    )
    first, second = (json.loads(text) for text in (one, other))
    strip = of.names(of.belonging(of.EFFORT))
    optima = [
        [{k: v for k, v in row.items() if k not in strip} for row in told["optima"]]
        for told in (first, second)
    ]
    assert optima[0] == optima[1] and optima[0]


@pytest.mark.parametrize(
    ("args", "expected"),
    [
        (("optimum", "--x-min-m", "-1"), "--x-min-m: expected a positive"),
        (("optimum", "--x-min-m", "99"), "x_min_m: expected less than"),
        (("optimum", "--bearing-max-deg", "95"), "--bearing-max-deg: expected 0.1 to 90"),
        (("flock", "--distance-min-m", "2", "--joint"), "--joint: expected birds that keep to nothing"),
        (("optimum", "--set", "x_min_m=1", "--x-min-m", "1"), "expected each input once"),
    ],
)
def test_what_cannot_be_is_told_in_one_line(bench, args, expected):
    _, said = bench(args[0], "northern-bald-ibis", *args[1:], code=2)
    assert expected in said and said.count("\n") == 1
