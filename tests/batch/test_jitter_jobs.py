"""A place's jitter as an input of a sweep: what its rows tell is what `upwash robust` tells, and is computed anew."""

import pyarrow.parquet as pq
import pytest
from conftest import Bench
from upwash import WakeModel, load_species
from upwash.batch.check import check, of_rows
from upwash.batch.folder import ResultsFolder
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.jitter import NAMES, POSE, SAVING, STILL
from upwash.jobs.job import Job
from upwash.jobs.pair import Pair
from upwash.optimum.settings import FlockRules
from upwash.optimum.spacing import Spacing
from upwash.study.robustness import robustness
from upwash.sweep import read_sweep

SWEEP = """\
species = "northern-bald-ibis"
objective = "power"
tolerance = 1e-2
[grid]
position_sigma_ratio = [0.05]
"""


@pytest.fixture(scope="module")
def rows(tmp_path_factory, logs):
    bench = Bench(tmp_path_factory.mktemp("jitter"), logs)
    (bench.folder / "sweep.toml").write_text(SWEEP)
    bench("run", "./sweep.toml")
    bench("aggregate", "results/sweep")
    folder = bench.folder / "results" / "sweep"
    assert check(ResultsFolder(folder)).findings == []
    return pq.read_table(folder / Pair.file).to_pylist()


def test_all_rows_of_a_job_tell_what_the_command_tells(rows):
    bird = load_species("northern-bald-ibis").bird()
    (told,) = robustness(bird, sigmas_m=[0.05 * bird.semispan_m]).to_dict("records")
    for row in rows:
        assert row["position_sigma_ratio"] == 0.05
        assert row[STILL] == pytest.approx(told["saving_held"], rel=1e-6)
        assert row[SAVING] == pytest.approx(told["robust_saving_held"], rel=1e-4)
        assert [row[f"robust_{name}"] for name in POSE] == pytest.approx(
            [told[f"robust_{name}"] for name in POSE], abs=1e-3
        )
    assert rows[0][SAVING] > 2.0 * rows[0][STILL]


@pytest.mark.parametrize("name", NAMES)
def test_no_one_column_can_be_altered(rows, name):
    # A place is told by the stroke that balances there in the mean.
    for value in (None, rows[0][name] * 1.001 + 1e-3):
        found = {found.column for found in of_rows([row | {name: value} for row in rows], "")}
        assert found and found <= set(NAMES)
    alone = [row | {name: None} if number == len(rows) - 1 else row for number, row in enumerate(rows)]
    assert of_rows(alone, "")


def test_rows_whose_job_asked_for_no_jitter_tell_none(rows):
    calm = [row | {"position_sigma_ratio": None} for row in rows]
    job_id = Job.of(calm[0]).job_id
    assert job_id != rows[0]["job_id"]
    found = of_rows([row | {"job_id": job_id} for row in calm], "")
    assert {one.column for one in found} == set(NAMES)


@pytest.mark.parametrize(
    "other",
    [
        {"kind": Flock(3, FlockRules())},
        {"kind": Pair(phase_lock=False)},
        {"spacing": Spacing(wingtip_gap_min_m=0.0)},
    ],
    ids=["flock", "out of step", "limits"],
)
def test_where_it_is_not_told_it_is_refused(other):
    asked = {"species": "ibis", "objective": "power", "amplitude_convention": "given"}
    bird = load_species("northern-bald-ibis").bird()
    assert Job(**asked, bird=bird, position_sigma_ratio=0.1).position_sigma_ratio == 0.1
    with pytest.raises(ValueError, match="position_sigma_ratio: expected none but for a pair"):
        Job(**asked, bird=bird, position_sigma_ratio=0.1, **other)


@pytest.mark.parametrize("value", ["0", "-0.1", "2", '"wide"'])
def test_what_is_no_jitter_is_refused_by_its_line(tmp_path, value):
    path = tmp_path / "sweep.toml"
    path.write_text(SWEEP.replace("0.05", value))
    with pytest.raises(UpwashError, match="line 5: grid.position_sigma_ratio: expected"):
        read_sweep(path)


def test_the_shipped_sweep_asks_every_species_in_both_models():
    jobs = read_sweep("robust-species").jobs
    assert len(jobs) == 80 and len({job.species for job in jobs}) == 20
    assert {(job.model == WakeModel(), job.position_sigma_ratio) for job in jobs} == {
        (is_paper, sigma) for is_paper in (True, False) for sigma in (0.05, 0.1)
    }
