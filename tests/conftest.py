"""The paper's ibis and its solutions, solved once for all tests of the optimum."""

import pytest
from upwash import load_species, solve_pair


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
