"""The paper's ibis and its solutions, solved once for all tests of the optimum."""

import logging
import math

import pytest
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
