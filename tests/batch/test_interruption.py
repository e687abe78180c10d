"""Whatever stops a run, what was finished stays finished and the rest is done later, once."""

import os
import random
import shutil
import signal
import subprocess

import pyarrow.parquet as pq
import pytest
from conftest import group_lives, kill, wait_until

pytestmark = pytest.mark.thorough

KILLS = 20
JOBS = 40


def test_kill_9_of_the_run_twenty_times(bench, undisturbed):
    bench.sweep("slow", JOBS)
    chance = random.Random(0)
    finished = set()
    for _ in range(KILLS):
        process = bench.start("run", "./sweep.toml")
        # Somewhere between the start of the workers and the second result after it.
        goal = len(finished) + chance.randrange(3)
        wait_until(lambda goal=goal: len(bench.job_files()) >= min(JOBS, goal))
        kill(process)
        now = {path.stem for path in bench.job_files()}
        assert finished <= now
        finished = now
    wait_until(lambda: not group_lives(process))
    before = bench.solved()
    bench.run()
    assert not finished & (bench.solved() - before).keys(), "a finished job was solved again"
    files = bench.job_files()
    assert len(files) == JOBS
    assert all(pq.read_table(path, page_checksum_verification=True).num_rows == 2 for path in files)
    assert {path.name for path in (bench.results / "jobs").iterdir()} == {path.name for path in files}
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)
    assert not (bench.results / "corrupt").exists()


@pytest.fixture
def half_done(bench):
    """A run whose light birds are done and whose heavy birds keep the workers waiting."""
    bench.sweep("waiting_when_heavy", 6)
    process = bench.start("run", "./sweep.toml")
    wait_until(lambda: len(bench.job_files()) == 3)
    yield process
    if process.poll() is None:
        kill(process)


@pytest.mark.parametrize(
    ("send", "request_to_stop"),
    # Ctrl-C reaches every process of the terminal; a batch queue's request the first one, or all.
    [(os.killpg, signal.SIGINT), (os.kill, signal.SIGTERM), (os.killpg, signal.SIGTERM)],
    ids=["Ctrl-C", "TERM", "TERM to all"],
)
def test_a_request_to_stop_is_met_cleanly(bench, half_done, send, request_to_stop):
    send(half_done.pid, request_to_stop)
    out, said = half_done.communicate(timeout=30)
    assert (half_done.returncode, out) == (130, "")
    assert "Traceback" not in said and "Warning" not in said
    assert said.splitlines()[-1] == (
        "Interrupted: 3 of 6 jobs are done and kept in results/sweep; run the same command again to go on"
    )
    wait_until(lambda: not group_lives(half_done))
    bench.fix()
    assert "3 done now, 3 before" in bench.run()[1]


@pytest.mark.parametrize("sign", [".lock", "journal-1-of-1.csv"], ids=["begins", "starts its workers"])
@pytest.mark.parametrize("request_to_stop", [signal.SIGINT, signal.SIGTERM])
def test_a_request_to_stop_while_a_run_begins_is_met_cleanly(bench, sign, request_to_stop):
    bench.sweep("slow", 4)
    process = bench.start("run", "./sweep.toml")
    wait_until(lambda: (bench.results / sign).exists())
    os.killpg(process.pid, request_to_stop)
    out, said = process.communicate(timeout=30)
    assert (process.returncode, out) == (130, "")
    *_, last = said.splitlines()
    assert last.startswith("Interrupted") and "Traceback" not in said and "Warning" not in said
    wait_until(lambda: not group_lives(process))
    assert "4 done now, 0 before" in bench.run()[1]


def test_workers_do_not_outlive_a_run_that_is_killed(half_done):
    kill(half_done)
    wait_until(lambda: not group_lives(half_done))


def test_a_second_run_at_the_same_time_is_refused_until_the_first_is_gone(bench, half_done):
    for command in (["run", "./sweep.toml"], ["aggregate", "results/sweep"]):
        _, said = bench(*command, code=2)
        assert said.startswith("Error: results/sweep: expected nobody else to write there")
        assert len(said.splitlines()) == 1
    assert bench.status()["is_running"] is True
    kill(half_done)
    assert bench.status()["is_running"] is False
    bench("aggregate", "results/sweep")


@pytest.mark.skipif(not shutil.which("pgrep"), reason="needs pgrep to find the workers")
def test_a_worker_that_the_system_kills_costs_no_job(bench, half_done):
    found = subprocess.run(["pgrep", "-P", str(half_done.pid), "-f", "loky"], capture_output=True, text=True)
    os.kill(int(found.stdout.split()[-1]), signal.SIGKILL)
    # The jobs that were in flight are begun again, one at a time.
    wait_until(lambda: max(bench.solved().values()) == 2)
    bench.fix()
    _, said = half_done.communicate(timeout=60)
    assert half_done.returncode == 0, said
    assert bench.status()["solved"] == 6


def test_a_job_that_kills_its_worker_gets_one_retry(bench):
    bench.sweep("suicidal_once", 4)
    bench.run()
    assert bench.status()["solved"] == 4


def test_a_job_that_always_kills_its_worker_fails_alone(bench):
    bench.sweep("suicidal_when_heavy", 3)
    _, said = bench.run(code=1)
    status = bench.status(code=1)
    # Of 1.1, 1.25 and 1.4 kg the last is too heavy.
    assert (status["solved"], status["failed"], status["causes"]) == (2, 1, {"WorkerKilled": 1})
    assert "killed twice" in said
    assert max(bench.solved().values()) == 2
