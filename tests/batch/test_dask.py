"""A real scheduler and real workers on the loopback give the same results, even when one of them dies."""

import os
import re
import signal
import socket
import subprocess
import sys
import time

import pytest
from conftest import wait_until

pytest.importorskip("distributed")
pytestmark = pytest.mark.thorough

WORKERS = 2


class Cluster:
    """A dask scheduler and two workers of one thread."""

    def __init__(self, folder):
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        port = self.address.rpartition(":")[2]
        self.folder = folder
        self.processes = [self.start("scheduler", "--host", "127.0.0.1", "--port", port)]
        for _ in range(WORKERS):
            self.start_worker()
        self.ask(f"client.wait_for_workers({WORKERS})")

    def start(self, *arguments):
        command = [sys.executable, "-m", "distributed.cli.dask_" + arguments[0], *arguments[1:]]
        with (self.folder / "dask.log").open("ab") as log:
            return subprocess.Popen(
                [*command, "--no-dashboard"], stdout=log, stderr=log, cwd=self.folder, start_new_session=True
            )

    def start_worker(self):
        """Start a worker under a nanny, which starts another if it dies."""
        self.processes.append(self.start("worker", self.address, "--nthreads", "1"))

    def ask(self, expression):
        """Let a client of its own process evaluate an expression of `client`; return what that prints."""
        script = f"import os; from distributed import Client; client = Client({self.address!r}, timeout=60)\n"
        asked = [sys.executable, "-c", f"{script}print(*({expression} or {{}}).values())"]
        return subprocess.run(asked, capture_output=True, text=True, check=True, timeout=90).stdout

    def worker_processes(self):
        return [int(pid) for pid in self.ask("client.run(os.getpid)").split()]

    def close(self):
        for process in self.processes:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()


@pytest.fixture(scope="module")
def cluster(tmp_path_factory, logs):
    cluster = Cluster(tmp_path_factory.mktemp("dask"))
    yield cluster
    cluster.close()


def by_dask(cluster):
    return ("--backend", "dask", "--scheduler", cluster.address)


def run_apart(bench, cluster):
    """Start a run of the cluster in a process of its own."""
    return bench.start("run", "./sweep.toml", *by_dask(cluster))


def test_workers_anywhere_give_the_same_summary(bench, cluster, undisturbed):
    bench.sweep("slow", 40)
    process = run_apart(bench, cluster)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)


def test_a_worker_that_dies_costs_nothing(bench, cluster):
    bench.sweep("waiting_when_heavy", 6)
    process = run_apart(bench, cluster)
    wait_until(lambda: len(bench.job_files()) == 3)
    os.kill(cluster.worker_processes()[0], signal.SIGKILL)
    time.sleep(0.5)
    bench.fix()
    _, said = process.communicate(timeout=120)
    assert process.returncode == 0, said
    assert bench.status()["solved"] == 6


def test_a_job_that_kills_every_worker_fails_alone(bench, cluster):
    bench.sweep("suicidal_when_heavy", 3)
    process = run_apart(bench, cluster)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 1, said
    assert bench.status(code=1)["causes"] == {"WorkerKilled": 1}


def test_no_scheduler_is_one_clear_line(bench, monkeypatch):
    monkeypatch.setattr("upwash.batch.workers.CONNECT_TIMEOUT_S", 1)
    bench.sweep("trivial", 2)
    _, said = bench.run("--backend", "dask", "--scheduler", "tcp://127.0.0.1:1", code=2)
    assert re.fullmatch(r"Error: --scheduler: expected a dask scheduler at 'tcp://127.0.0.1:1'.*\n", said)


def test_without_dask_the_remedy_is_named(bench, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    bench.sweep("trivial", 2)
    _, said = bench.run("--backend", "dask", "--scheduler", "tcp://127.0.0.1:1", code=2)
    assert "pip install 'upwash[distributed]'" in said and len(said.splitlines()) == 1
