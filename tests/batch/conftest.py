"""Sweeps of the tests' own solvers, run as a user runs them: by the command, in processes of their own."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pyarrow.parquet as pq
import pytest

HERE = Path(__file__).parent
COMMAND = [sys.executable, "-c", "from pipeline.cli import main; main()"]
SWEEP = """\
name = "sweep"
solver = "stub_solvers:{solver}"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.1, 1.4, {jobs}] }}
"""


class Bench:
    """A folder with a sweep in it, and the command to work on it."""

    def __init__(self, folder):
        self.folder = folder
        self.results = folder / "results" / "sweep"
        self.log = folder / "solved.log"
        self.environment = os.environ | {
            "PYTHONPATH": str(HERE),
            "UPWASH_TEST_LOG": str(self.log),
            "UPWASH_TEST_MENDED": str(folder / "mended"),
        }

    def sweep(self, solver, jobs):
        """Write the sweep file."""
        (self.folder / "sweep.toml").write_text(SWEEP.format(solver=solver, jobs=jobs))

    def start(self, *arguments, **options):
        """Start the command in a process group of its own."""
        return subprocess.Popen(
            [*COMMAND, *arguments],
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
            **options,
        )

    def __call__(self, *arguments, code=0, **options):
        """Run the command; return its output and what it said, and expect an exit code."""
        process = self.start(*arguments, **options)
        out, said = process.communicate(timeout=120)
        assert process.returncode == code, said
        assert "Traceback" not in said
        return out, said

    def run(self, *options, code=0, **more):
        """Run the sweep."""
        return self("run", "./sweep.toml", *options, code=code, **more)

    def status(self, code=0):
        """Return what the status command says."""
        return json.loads(self("status", "results/sweep", "--json", code=code)[0])

    def job_files(self):
        """Return the jobs' own files."""
        return sorted((self.results / "jobs").glob("*.parquet"))

    def solved(self):
        """Return how often each job was begun."""
        return Counter(self.log.read_text().split()) if self.log.exists() else Counter()

    def summary(self):
        """Return the summary, apart from what was measured."""
        return pq.read_table(self.results / "summary.parquet").drop_columns(["solve_time_s"])

    def mend(self):
        """Let waiting jobs go on, and failing ones succeed."""
        (self.folder / "mended").touch()


def kill(process):
    """Kill a process as the system does: at once, and nothing else with it."""
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    process.stderr.close()


def group_lives(process):
    """Whether a process, or any that it started, is alive."""
    try:
        os.killpg(process.pid, 0)
    except ProcessLookupError:
        return False
    return True


def wait_until(condition, timeout=60):
    """Wait for something to come true."""
    deadline = time.monotonic() + timeout
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)


@pytest.fixture
def bench(tmp_path):
    return Bench(tmp_path)


@pytest.fixture(scope="session")
def solved_pairs(tmp_path_factory):
    """Results of a sweep of two dozen stub jobs, run and gathered without a hitch; not to be changed."""
    bench = Bench(tmp_path_factory.mktemp("undisturbed"))
    bench.sweep("slow", 40)
    bench.run()
    bench("aggregate", "results/sweep")
    return bench
