"""A flight: closed forms of its range, its ends, and that climbing takes what it must."""

import math

import pytest
from upwash.journey.flight import Cruise, Flight, NoFlight, Profile
from upwash.journey.fuel import Fuel

TAKE_OFF, FUEL_KG, GRAVITY = 1.3, 0.39, 9.80665
PLAIN = Fuel(0.91, efficiency=0.25, energy_density_j_kg=4e7, upkeep=1.0, basal_w=0.0)


def constant(mass, altitude, before):
    return Cruise(15.0, 20.0)


def of_lift_to_drag(ratio, speed=15.0):
    """Drag is weight over a constant: the law of Breguet's formula."""
    return lambda mass, altitude, before: Cruise(speed, mass * GRAVITY / ratio * speed)


def flown(law, fuel=PLAIN, fuel_kg=FUEL_KG, **options):
    flight = Flight(law, TAKE_OFF, fuel_kg, fuel, **options)
    ended = []
    steps = [flight.start()]
    steps += flight.steps(steps[0], ended)
    return steps, ended


def test_constant_power_flies_a_time_that_the_energy_lasts():
    steps, ended = flown(constant)
    seconds = FUEL_KG * 4e7 * 0.25 / 20.0
    assert steps[-1].totals == pytest.approx(
        (15.0 * seconds, seconds, 20.0 * seconds, 15.0 * seconds), rel=1e-9
    )
    assert ended == ["the fuel is spent"]


@pytest.mark.parametrize("tailwind", [0.0, 5.0, -5.0])
def test_constant_lift_to_drag_flies_breguets_range(tailwind):
    steps, _ = flown(of_lift_to_drag(12.0), tailwind_m_s=tailwind)
    known = 4e7 * 0.25 / GRAVITY * 12.0 * math.log(TAKE_OFF / (TAKE_OFF - FUEL_KG)) * (1.0 + tailwind / 15.0)
    assert steps[-1].distance_m == pytest.approx(known, rel=1e-6)
    error = abs(steps[-1].distance_m - known)
    assert error <= max(10.0 * steps[-1].error_m, 1e-9 * known)


def test_upkeep_takes_its_share():
    fuel = Fuel(0.91, efficiency=0.25, energy_density_j_kg=4e7)
    steps, _ = flown(constant, fuel)
    burned = 1.1 * (20.0 / 0.25 + 3.79 * 0.91**0.723)
    assert steps[-1].totals[1] == pytest.approx(FUEL_KG * 4e7 / burned, rel=1e-9)


@pytest.mark.parametrize(("power", "burned"), [(2.093, 12.27), (2.523, 14.33), (5.234, 27.29)])
def test_burns_what_afpts_own_example_burns(power, burned):
    # The jackdaw of its documentation, a passerine: 0.215 kg, basal 6.25 m^0.724.
    jackdaw = Fuel(0.215, basal_w=6.25)
    assert jackdaw.chemical_w(power) == pytest.approx(burned, rel=0.01)


def test_without_fuel_it_flies_nowhere():
    steps, ended = flown(constant, fuel_kg=0.0)
    assert len(steps) == 1
    assert steps[0].distance_m == 0.0
    assert ended == ["the fuel is spent"]


def test_climbing_and_coming_down_again_costs_nothing_but_the_way():
    there_and_back = Profile(((0.0, 0.0), (200e3, 1000.0), (400e3, 0.0)))
    level, _ = flown(constant)
    hilly, _ = flown(constant, profile=there_and_back, gravity_m_s2=GRAVITY)
    assert hilly[-1].distance_m < level[-1].distance_m
    # Mass falls between, so that a little less comes back than went up.
    assert hilly[-1].distance_m == pytest.approx(level[-1].distance_m, rel=1e-2)
    up = Profile(((0.0, 0.0), (200e3, 1000.0)))
    climbed, _ = flown(constant, profile=up, gravity_m_s2=GRAVITY)
    work = climbed[-1].totals[2]
    least = 1000.0 * GRAVITY * (TAKE_OFF - FUEL_KG) + 20.0 * climbed[-1].totals[1]
    most = 1000.0 * GRAVITY * TAKE_OFF + 20.0 * climbed[-1].totals[1]
    assert least < work < most


def test_ends_where_it_cannot_fly_on_and_says_why():
    def until(mass, altitude, before):
        if mass < 1.1:
            raise NoFlight("no balance: below 1.1 kg")
        return Cruise(15.0, 20.0)

    steps, ended = flown(until)
    assert ended == ["no balance: below 1.1 kg"]
    assert steps[-1].mass_kg == pytest.approx(1.1, abs=1e-4)


def test_a_headwind_faster_than_it_flies_ends_it_at_once():
    with pytest.raises(
        NoFlight, match="wind: expected a headwind slower than the bird, 15 m/s, found 20 m/s"
    ):
        flown(constant, tailwind_m_s=-20.0)


def test_goes_on_from_any_step_as_if_it_had_not_stopped():
    flight = Flight(of_lift_to_drag(12.0), TAKE_OFF, FUEL_KG, PLAIN)
    whole = [flight.start()]
    whole += flight.steps(whole[0], [])
    again = list(flight.steps(whole[4], []))
    assert again[-1].distance_m == pytest.approx(whole[-1].distance_m, rel=1e-12)


def test_a_profile_is_straight_between_its_points_and_level_beyond():
    profile = Profile(((0.0, 0.0), (100.0, 50.0), (200.0, 0.0)))
    assert [profile.altitude_m(at) for at in (0.0, 50.0, 150.0, 999.0)] == [0.0, 25.0, 25.0, 0.0]
    assert [profile.gradient(at) for at in (0.0, 150.0, 999.0)] == [0.5, -0.5, 0.0]
