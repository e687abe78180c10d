"""Birds that the tests of the physics share."""

import math

import pytest
from upwash.aero.bird import Bird

# The paper's northern bald ibis; the amplitude is that of a stroke half-angle of 60 degrees.
IBIS = {
    "mass_kg": 1.3,
    "semispan_m": 0.6,
    "speed_m_s": 15.0,
    "period_s": 0.25,
    "density_kg_m3": 1.29,
    "gravity_m_s2": 9.8,
    "amplitude_m": 2 * 0.6 * math.sin(math.pi / 3),
    "upstroke_span_ratio": 0.4,
}


@pytest.fixture(scope="session")
def make_ibis():
    """Return a function that makes the paper's ibis, with changes."""
    return lambda **changes: Bird(**{**IBIS, **changes})


@pytest.fixture(scope="session")
def ibis(make_ibis):
    return make_ibis()


@pytest.fixture(scope="session")
def slack_ibis(make_ibis):
    """An ibis whose upstroke carries 0.6 of the downstroke's circulation."""
    return make_ibis(circulation_ratio=0.6)
