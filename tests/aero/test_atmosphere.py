"""The standard atmosphere: a published table's values, its ends, and that it falls with height."""

import pytest
from upwash.aero.atmosphere import CEILING_M, density_kg_m3, temperature_k, viscosity_kg_m_s

# Geometric altitude in m -> temperature in K, density over that at sea level, kinematic viscosity in 1e-5 m²/s, as the
# table of the International Standard Atmosphere at engineeringtoolbox.com prints them.
TABLE = {
    0: (288.15, 1.0, 1.461),
    1000: (281.7, 0.9075, 1.581),
    2000: (275.2, 0.8217, 1.715),
    3000: (268.7, 0.7423, 1.863),
    5000: (255.7, 0.6012, 2.211),
    8000: (236.2, 0.4292, 2.904),
    11000: (216.8, 0.2978, 3.899),
}
EARTH_RADIUS_M = 6356766.0


@pytest.mark.parametrize("geometric", TABLE)
def test_agrees_with_a_published_table(geometric):
    temperature, density, viscosity = TABLE[geometric]
    altitude = EARTH_RADIUS_M * geometric / (EARTH_RADIUS_M + geometric)
    assert temperature_k(altitude) == pytest.approx(temperature, abs=0.06)
    found = density_kg_m3(altitude)
    assert found / density_kg_m3(0.0) == pytest.approx(density, abs=6e-5)
    assert viscosity_kg_m_s(found) / found * 1e5 == pytest.approx(viscosity, abs=6e-4 if geometric else 1e-3)


def test_sea_level_is_as_dense_as_everybody_says():
    assert density_kg_m3(0.0) == pytest.approx(1.225, abs=5e-6)


@pytest.mark.parametrize("altitude", [-1.0, CEILING_M + 1.0, float("nan")])
def test_beyond_its_ends_it_tells_nothing(altitude):
    with pytest.raises(ValueError, match="altitude_m: expected 0 to 11000"):
        density_kg_m3(altitude)
