"""Powers and cost functions: the ibis's numbers, laws of speed, and the shape that a proof rests on."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from upwash.aero.bird import Bird
from upwash.aero.power import (
    COST_FUNCTIONS,
    CostFunction,
    induced_power_w,
    parasite_power_w,
    profile_power_w,
    total_power_w,
)

from .conftest import IBIS

EACH_COST = pytest.mark.parametrize("name", COST_FUNCTIONS)
repeatable = settings(deadline=None, derandomize=True, max_examples=60)
lifts = st.floats(0.0, 1e3)
thrusts = st.floats(0.0, 1e3)


def powers(bird):
    """Return the lone bird's induced, profile and parasite power."""
    return (
        induced_power_w(bird, bird.weight_n),
        profile_power_w(bird, bird.drag_n),
        parasite_power_w(bird),
    )


def test_powers_of_the_lone_ibis(ibis):
    # From an independent implementation, to the last digit printed; the paper says 60 W in all.
    assert powers(ibis) == pytest.approx((4.4500, 34.436, 21.077), abs=5e-4)
    assert total_power_w(ibis, ibis.weight_n, ibis.drag_n) == pytest.approx(59.963, abs=5e-4)


@pytest.mark.parametrize(("which", "exponent"), [(0, -1.0), (1, 0.0), (2, 3.0)])
def test_how_each_power_goes_with_speed(make_ibis, which, exponent):
    # At one wingbeat period.  Profile power D U does not change: circulation, and so D, is inverse to U.
    slow, fast = powers(make_ibis(speed_m_s=9.0)), powers(make_ibis(speed_m_s=18.0))
    assert math.log2(fast[which] / slow[which]) == pytest.approx(exponent, abs=1e-12)


def test_parasite_power_goes_with_mass_as_the_body_s_frontal_area(make_ibis):
    light, heavy = (parasite_power_w(make_ibis(mass_kg=mass)) for mass in (1.0, 8.0))
    assert heavy / light == pytest.approx(8.0**0.666, rel=1e-12)
    assert light == pytest.approx(1.29 * 15**3 * 0.00813 / 2, rel=1e-12)


def test_the_cost_functions_by_name(ibis):
    lift, thrust = 12.0, 2.0
    cost = {name: function.value(ibis, lift, thrust) for name, function in COST_FUNCTIONS.items()}
    assert cost["force"] == pytest.approx(math.sqrt(lift**2 + thrust**2), rel=1e-15)
    assert cost["power"] == pytest.approx(total_power_w(ibis, lift, thrust), rel=1e-15)
    assert cost["cost_of_transport"] == pytest.approx(cost["power"] / 15.0, rel=1e-15)
    assert {name: function.unit for name, function in COST_FUNCTIONS.items()} == {
        "force": "N",
        "power": "W",
        "cost_of_transport": "J/m",
        "aerodynamic_power": "W",
    }


def test_aerodynamic_power_counts_no_drag_twice(ibis):
    """Thrust times speed pays for the whole drag; the body's own power is in it."""
    cost = COST_FUNCTIONS["aerodynamic_power"].value(ibis, ibis.weight_n, ibis.drag_n)
    assert cost == pytest.approx(total_power_w(ibis, ibis.weight_n, ibis.drag_n) - parasite_power_w(ibis))
    assert cost == pytest.approx(induced_power_w(ibis, ibis.weight_n) + ibis.drag_n * ibis.speed_m_s)


@EACH_COST
@repeatable
@given(st.tuples(lifts, thrusts), st.tuples(lifts, thrusts), st.floats(0.0, 1.0))
def test_a_cost_is_convex_in_lift_and_thrust(name, one, other, share):
    def cost(force):
        return COST_FUNCTIONS[name].value(Bird(**IBIS), *force)

    between = tuple(share * a + (1 - share) * b for a, b in zip(one, other, strict=True))
    chord = share * cost(one) + (1 - share) * cost(other)
    assert cost(between) <= chord * (1 + 1e-14)


@EACH_COST
@repeatable
@given(lifts, thrusts, st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_a_cost_never_falls_as_more_lift_or_thrust_is_made(name, lift, thrust, more_lift, more_thrust):
    cost, bird = COST_FUNCTIONS[name], Bird(**IBIS)
    assert cost.value(bird, lift, thrust + more_thrust) >= cost.value(bird, lift, thrust)
    assert cost.value(bird, lift + more_lift, thrust) >= cost.value(bird, lift, thrust)


@pytest.mark.parametrize("part", ["force", "induced", "profile", "parasite"])
def test_no_weight_of_a_cost_may_be_negative(part):
    with pytest.raises(ValueError, match="weights of a cost function: expected none below 0, found"):
        CostFunction("W", **{part: -1.0})


def test_each_weight_weighs_its_own_part(ibis):
    parts = {
        "force": math.hypot(12.0, 2.0),
        "induced": induced_power_w(ibis, 12.0),
        "profile": profile_power_w(ibis, 2.0),
        "parasite": parasite_power_w(ibis),
    }
    for part, value in parts.items():
        assert CostFunction("", **{part: 3.0}).value(ibis, 12.0, 2.0) == pytest.approx(3.0 * value, rel=1e-15)
