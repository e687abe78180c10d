"""A dry run of very many jobs: it gives them one by one, keeps none, and says how far it is."""

import json
import tracemalloc

import pytest
from click.testing import CliRunner
from upwash.batch import dry_run
from upwash.batch.dry_run import foresee
from upwash.batch.folder import ResultsFolder, Shard
from upwash.cli import main
from upwash.sweep import file, read_sweep

ALL = Shard(1, 1)
SWEEP = """\
solver = "stub_solvers:two_optima"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.1, 1.4, {jobs}] }}
"""


@pytest.fixture
def write(tmp_path, monkeypatch):
    """Return a function that writes a sweep of so many jobs; the tests' own folder is where we are."""
    monkeypatch.chdir(tmp_path)

    def write(jobs):
        (tmp_path / "sweep.toml").write_text(SWEEP.format(jobs=jobs))
        return "./sweep.toml"

    return write


def foreseen(sweep, show, tell=lambda line: None):
    return foresee(read_sweep(sweep, tell), ResultsFolder("results"), ALL, False, 2, show, tell)


def test_as_json_holds_what_the_lines_say(write):
    sweep = write(5)
    lines = CliRunner().invoke(main, ["run", sweep, "--dry-run"]).stdout.splitlines()
    plan = json.loads(CliRunner().invoke(main, ["run", sweep, "--dry-run", "--json"]).stdout)
    written = [f"{job['job_id']}  run   {job['label']}  ({job['reason']})" for job in plan["jobs"]]
    assert written == lines and len(lines) == plan["to_run"] == 5


def test_of_a_part_without_jobs_is_json_all_the_same(write):
    answer = CliRunner().invoke(main, ["run", write(2), "--dry-run", "--json", "--shard", "1/999"])
    plan = json.loads(answer.stdout)
    assert (plan["jobs"], plan["to_run"], plan["seconds"]) == ([], 0, 0.0)


def test_memory_does_not_grow_with_the_jobs(write):
    def peak(jobs):
        sweep = write(jobs)
        tracemalloc.start()
        try:
            assert foreseen(sweep, lambda job: None).jobs == jobs
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    peak(10)
    # The values that the file itself asks for, and a job's id of eight bytes: a job, kept, would take 2000.
    assert peak(5000) - peak(500) < 4500 * 250


def test_says_how_far_it_is(write, monkeypatch):
    monkeypatch.setattr(file, "TELL_EVERY_S", 0.0)
    monkeypatch.setattr(dry_run, "TELL_EVERY_S", 0.0)
    said = []
    foreseen(write(2500), lambda job: None, said.append)
    assert [line.rpartition("/")[2] for line in said] == [
        "sweep.toml: 1000 of 2500 jobs checked",
        "sweep.toml: 2000 of 2500 jobs checked",
        "1000 jobs listed",
        "2000 jobs listed",
    ]


def test_jobs_that_two_blocks_ask_for_are_given_once(tmp_path):
    path = tmp_path / "sweep.toml"
    blocks = ["mass_kg = [1.2, 1.3]", "mass_kg = [1.3, 1.4, 1.2]"]
    path.write_text(
        'species = "northern-bald-ibis"\n' + "".join(f"[[block]]\n[block.grid]\n{one}\n" for one in blocks)
    )
    sweep = read_sweep(path)
    assert [job.bird.mass_kg for job in sweep.stream()] == [1.2, 1.3, 1.4]
    assert sweep.jobs == list(sweep.stream()) and sweep.count == 3
    assert sweep.varied == {"mass_kg"}
