"""Sweeps of the tests' own solvers, run as a user runs them: by the command."""

import json
import os
import signal
import subprocess
import sys
import time
import traceback
from collections import Counter
from contextlib import chdir
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from joblib.externals.loky import get_reusable_executor
from upwash.cli import main

HERE = Path(__file__).parent
COMMAND = [sys.executable, "-c", "from upwash.cli import main; main()"]
SWEEP = """\
name = "sweep"
solver = "stub_solvers:{solver}"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.1, 1.4, {jobs}] }}
"""


class Bench:
    """A folder with a sweep in it, and the command to work on it.

    Called, the command runs in this process, so that all tests share the workers; started, in one of its own.
    """

    command = COMMAND

    def __init__(self, folder, logs):
        self.folder = folder
        self.results = folder / "results" / "sweep"
        self.log = logs / "solved.log"
        self.marker = logs / "fixed"
        self.marker.unlink(missing_ok=True)
        self.before = self.all_solved()

    def sweep(self, solver, jobs):
        """Write the sweep file."""
        (self.folder / "sweep.toml").write_text(SWEEP.format(solver=solver, jobs=jobs))

    def start(self, *arguments, **options):
        """Start the command in a process group of its own."""
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        return subprocess.Popen(
            [*COMMAND, *arguments], cwd=self.folder, start_new_session=True, **pipes | options
        )

    def __call__(self, *arguments, code=0):
        """Run the command; return its output and what it said, and expect an exit code."""
        with chdir(self.folder):
            result = CliRunner().invoke(main, arguments)
        unexpected = result.exception is not None and not isinstance(result.exception, SystemExit)
        assert not unexpected, traceback.format_exception(result.exception)
        assert result.exit_code == code, result.stderr
        return result.stdout, result.stderr

    def run(self, *options, code=0):
        """Run the sweep."""
        return self("run", "./sweep.toml", *options, code=code)

    def status(self, code=0):
        """Return what the status command says."""
        return json.loads(self("status", "results/sweep", "--json", code=code)[0])

    def job_files(self):
        """Return the jobs' own files."""
        return sorted((self.results / "jobs").glob("*.parquet"))

    def all_solved(self):
        return Counter(self.log.read_text().split()) if self.log.exists() else Counter()

    def solved(self):
        """Return how often each job was begun in this test."""
        return self.all_solved() - self.before

    def summary(self):
        """Return the summary, apart from what was measured."""
        return pq.read_table(self.results / "summary.parquet").drop_columns(["solve_time_s"])

    def fix(self):
        """Let waiting jobs go on, and failing ones succeed."""
        self.marker.touch()


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


@pytest.fixture(autouse=True, scope="session")
def _interrupts_reach_what_is_started():
    """Shells start what they put in the background deaf to Ctrl-C, and so would be what the tests start."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture(scope="session")
def logs(tmp_path_factory):
    """Where the tests' solvers tell what they did; the same for all, and set before any worker starts."""
    # Other tests may have left workers behind, which know nothing of it.
    get_reusable_executor().shutdown()
    folder = tmp_path_factory.mktemp("logs")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("UPWASH_TEST_LOG", str(folder / "solved.log"))
        patch.setenv("UPWASH_TEST_FIXED", str(folder / "fixed"))
        patch.setenv("PYTHONPATH", str(HERE), prepend=os.pathsep)
        yield folder


@pytest.fixture
def bench(tmp_path, logs):
    return Bench(tmp_path, logs)


@pytest.fixture(scope="session")
def undisturbed(tmp_path_factory, logs):
    """The summary of a sweep of forty stub jobs that was run and gathered without a hitch."""
    bench = Bench(tmp_path_factory.mktemp("undisturbed"), logs)
    bench.sweep("slow", 40)
    bench.run()
    bench("aggregate", "results/sweep")
    return bench.summary()


@pytest.fixture(scope="session")
def reproduced(tmp_path_factory, logs):
    """The results folder of the paper's pair, solved by the real solver and gathered; not to be changed."""
    bench = Bench(tmp_path_factory.mktemp("paper"), logs)
    bench("run", "reproduce")
    bench("aggregate", "results/reproduce")
    return bench.folder / "results" / "reproduce"


@pytest.fixture(scope="session")
def flocks(tmp_path_factory, logs):
    """The results folder of small flocks, solved by the real solver and gathered; not to be changed."""
    bench = Bench(tmp_path_factory.mktemp("flocks"), logs)
    (bench.folder / "flocks.toml").write_text(
        'kind = "flock"\nspecies = "northern-bald-ibis"\n'
        '[flock]\nbirds = 4\nshape = "vee"\nwake = ["neighbour", "all-upstream"]\n'
    )
    bench("run", "./flocks.toml")
    bench("aggregate", "results/flocks")
    return bench.folder / "results" / "flocks"


@pytest.fixture(scope="session")
def converged(tmp_path_factory, logs):
    """The results folder of pairs behind endless wakes, gathered: both costs and both span laws; not to be changed."""
    bench = Bench(tmp_path_factory.mktemp("limit"), logs)
    (bench.folder / "converged.toml").write_text(
        'species = "northern-bald-ibis"\ntolerance = 1e-2\n[fixed]\nmodel = "limit"\n'
        '[[block]]\nobjective = ["force", "power"]\n'
        '[[block]]\nobjective = "power"\n[block.fixed]\nspan_law = "tip"\ndistance_m = 1.2\n'
    )
    bench("run", "./converged.toml")
    bench("aggregate", "results/converged")
    return bench.folder / "results" / "converged"


@pytest.fixture(scope="session")
def converged_flock(tmp_path_factory, logs):
    """The results folder of a flock behind endless wakes, gathered; not to be changed."""
    bench = Bench(tmp_path_factory.mktemp("limit-flock"), logs)
    (bench.folder / "flock.toml").write_text(
        'kind = "flock"\nspecies = "northern-bald-ibis"\nobjective = "power"\ntolerance = 1e-2\n'
        '[fixed]\nmodel = "limit"\n[flock]\nbirds = 3\n'
    )
    bench("run", "./flock.toml")
    bench("aggregate", "results/flock")
    return bench.folder / "results" / "flock"
