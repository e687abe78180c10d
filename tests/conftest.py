"""The paper's ibis and its solutions, solved once for all tests of the optimum; and the paper redone, once for all."""

import fcntl
import json
import logging
import math
import os
import subprocess

import pytest
from renew_reference import COMMAND
from upwash import kernel, load_species, solve_pair
from upwash.cli import streams


@pytest.fixture(autouse=True, scope="session")
def _no_word_of_how_long_it_takes():
    """Commands that run within the tests tell neither that they compile nor that they are still at work.

    Either hangs on the machine, and on which test is the first.
    """
    kernel._tell_once(logging.INFO, kernel.COMPILING)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(streams, "SILENCE_S", math.inf)
        yield


@pytest.fixture(scope="session")
def ibis():
    """The paper's northern bald ibis."""
    return load_species("northern-bald-ibis").bird()


@pytest.fixture(scope="session")
def ibis_force(ibis):
    """All optima of the ibis pair for the paper's first objective, and their proof."""
    return solve_pair(ibis, "force")


@pytest.fixture(scope="session")
def ibis_power(ibis):
    """All optima of the ibis pair for the paper's second objective, and their proof."""
    return solve_pair(ibis, "power")


@pytest.fixture(scope="session", params=["force", "power"])
def ibis_solution(request):
    """Each of the two solutions in turn."""
    return request.getfixturevalue(f"ibis_{request.param}")


@pytest.fixture(scope="session")
def paper_redone(tmp_path_factory):
    """A folder in which `upwash reproduce` was run, as a process of its own, and what came of it; not to be changed.

    It is run by the first that asks, and serves all processes of the tests.
    """
    root = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent
    folder, told = root / "paper-redone", root / "paper-redone.json"
    with (root / "paper-redone.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not told.exists():
            folder.mkdir()
            done = subprocess.run(COMMAND, cwd=folder, capture_output=True, text=True)
            told.write_text(json.dumps([done.returncode, done.stdout, done.stderr]), encoding="utf-8")
    return folder, subprocess.CompletedProcess(COMMAND, *json.loads(told.read_text(encoding="utf-8")))
