"""The drag of a lone bird: its parts against formulas written out, and the speeds that follow against closed forms."""

import math

import pytest
from scipy.optimize import minimize_scalar
from upwash.aero.atmosphere import density_kg_m3
from upwash.aero.drag import DragPolar
from upwash.aero.power import body_area_m2

# A jackdaw, the example of the R package afpt: its drag components by afpt's own formulas, with its kinematic viscosity
# of 14.6e-6 m²/s at sea level, are written out below.
MASS, SEMISPAN, AREA = 0.215, 0.335, 0.0652
AIR, GRAVITY = 1.225, 9.80665


def test_profile_drag_is_afpts_where_its_formulas_are_the_same():
    for speed in (6.0, 10.8, 18.0):
        pressure = 0.5 * AIR * speed**2
        reynolds = speed * (AREA / (2.0 * SEMISPAN)) / 14.6e-6
        friction = pressure * 2.66 / math.sqrt(reynolds) * AREA
        of_lift = 0.03 * (MASS * GRAVITY) ** 2 / (pressure * AREA)
        _, ours, ours_of_lift = DragPolar(AREA).parts_n(MASS, SEMISPAN, speed, AIR, GRAVITY)
        assert ours == pytest.approx(friction, rel=1e-3)
        assert ours_of_lift == pytest.approx(of_lift, rel=1e-12)


def test_body_drag_is_proportional_to_its_coefficient_and_to_the_square_of_speed():
    slim, blunt = (DragPolar(AREA, c).parts_n(MASS, SEMISPAN, 10.0, AIR, GRAVITY)[0] for c in (0.2, 1.0))
    fast = DragPolar(AREA, 0.2).parts_n(MASS, SEMISPAN, 20.0, AIR, GRAVITY)[0]
    assert blunt == pytest.approx(5.0 * slim, rel=1e-14)
    assert fast == pytest.approx(4.0 * slim, rel=1e-14)
    assert blunt == pytest.approx(0.5 * AIR * 100.0 * 0.00813 * MASS**0.666, rel=1e-12)


def test_minimum_power_speed_of_induced_and_body_drag_is_pennycuicks():
    # 0.807 k^(1/4) sqrt(m g) / (sqrt(B rho) (S_b C_Db)^(1/4)): Pennycuick 2008, as Claramunt & Wright 2016 quote it.
    polar, k = DragPolar(AREA, 0.1), 1.2

    def power(speed):
        induced = 2.0 * k * (MASS * GRAVITY) ** 2 / (math.pi * AIR * speed * (2.0 * SEMISPAN) ** 2)
        return induced + speed * polar.parts_n(MASS, SEMISPAN, speed, AIR, GRAVITY)[0]

    found = minimize_scalar(power, bounds=(3.0, 30.0), method="bounded", options={"xatol": 1e-9}).x
    body = (body_area_m2(MASS) * 0.1) ** 0.25
    known = 0.807 * k**0.25 * math.sqrt(MASS * GRAVITY) / (math.sqrt(2.0 * SEMISPAN * AIR) * body)
    assert found == pytest.approx(known, rel=5e-4)


def test_thinner_air_changes_drag_as_it_must():
    high = density_kg_m3(5000.0)
    low = density_kg_m3(0.0)
    equal = math.sqrt(low / high)
    # At equal dynamic pressure all but friction are the same.
    here = DragPolar(AREA).parts_n(MASS, SEMISPAN, 10.0, low, GRAVITY)
    there = DragPolar(AREA).parts_n(MASS, SEMISPAN, 10.0 * equal, high, GRAVITY)
    assert there[0] == pytest.approx(here[0], rel=1e-13)
    assert there[2] == pytest.approx(here[2], rel=1e-13)
    assert here[1] < there[1] < 1.1 * here[1]


@pytest.mark.parametrize(
    "given", [{"wing_area_m2": 0.0}, {"wing_area_m2": 0.1, "body_drag_coefficient": -1.0}]
)
def test_what_is_no_wing_and_no_body_is_refused(given):
    with pytest.raises(ValueError, match="expected a positive, finite number"):
        DragPolar(**given)
