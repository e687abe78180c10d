"""A lone bird: weight support, drag, impulses, the ibis's numbers, and what a bird may not be."""

import math
import re

import numpy as np
import pytest
from upwash.aero.bird import Bird

from .conftest import IBIS

# From an independent implementation, to the last digit printed; the paper says 12.74 N and 2.30 N.
IBIS_FACTS = {"circulation_m2_s": 0.92571, "weight_n": 12.74, "drag_n": 2.29575, "wavelength_m": 3.75}


@pytest.mark.parametrize(("name", "value"), IBIS_FACTS.items())
def test_the_lone_ibis(ibis, name, value):
    assert getattr(ibis, name) == pytest.approx(value, abs=5e-6)


@pytest.mark.parametrize("ratio", [0.3, 1.0, 1.4])
def test_a_lone_bird_carries_its_weight_and_its_thrust_is_the_drag(make_ibis, ratio):
    bird = make_ibis(circulation_ratio=ratio)
    assert bird.lift_n(bird.upstroke_span_ratio) == pytest.approx(bird.weight_n, rel=1e-14)
    assert bird.thrust_n(bird.amplitude_m, bird.upstroke_span_ratio) == bird.drag_n


@pytest.mark.parametrize("ratio", [0.3, 1.0, 1.4])
def test_impulse_is_that_of_an_ellipse_and_of_a_rectangle(make_ibis, ratio):
    # The impulse of a plane vortex loop is ρ Γ times its area; its z part counts the area seen from above.
    # Downstroke: an ellipse λ/2 long and 2 b wide; upstroke: a rectangle λ/2 long and 2 b R wide.  Seen from
    # ahead both are h tall; the downstroke's impulse leans upstream, the upstroke's downstream.
    bird = make_ibis(circulation_ratio=ratio)
    b, density, circulation = bird.semispan_m, bird.density_kg_m3, bird.circulation_m2_s
    h, r = 0.7, 0.35
    areas_above = math.pi * (b * bird.wavelength_m / 4), 2 * b * r * bird.wavelength_m / 2
    areas_ahead = math.pi * (b * h / 2), 2 * b * r * h
    assert bird.vertical_impulse_n_s(r) == pytest.approx(
        density * circulation * (areas_above[0] + ratio * areas_above[1]), rel=1e-14
    )
    assert bird.horizontal_impulse_n_s(h, r) == pytest.approx(
        density * circulation * (areas_ahead[0] - ratio * areas_ahead[1]), rel=1e-14
    )


def test_a_weaker_upstroke_needs_a_stronger_downstroke_and_drags_less_on_the_way_up(ibis, slack_ibis):
    assert slack_ibis.circulation_m2_s > ibis.circulation_m2_s
    assert slack_ibis.drag_n > ibis.drag_n


def test_only_the_product_of_span_ratio_and_upstroke_circulation_counts(make_ibis):
    one, other = make_ibis(upstroke_span_ratio=0.3), make_ibis(upstroke_span_ratio=0.6, circulation_ratio=0.5)
    assert other.circulation_m2_s == pytest.approx(one.circulation_m2_s, rel=1e-15)
    assert other.drag_n == pytest.approx(one.drag_n, rel=1e-15)


def test_circulation_is_inverse_to_speed_and_so_is_drag(make_ibis):
    slow, fast = make_ibis(speed_m_s=10.0), make_ibis(speed_m_s=20.0)
    assert slow.circulation_m2_s == pytest.approx(2 * fast.circulation_m2_s, rel=1e-14)
    assert slow.drag_n == pytest.approx(2 * fast.drag_n, rel=1e-14)


def test_drag_over_weight_is_the_wake_s_slope_times_a_number_of_the_span_ratio(ibis):
    r, slope = 0.4, 2 * ibis.amplitude_m / ibis.wavelength_m
    assert ibis.drag_n / ibis.weight_n == pytest.approx(
        slope * (math.pi / 4 - r) / (math.pi / 4 + r), rel=1e-14
    )


@pytest.mark.parametrize("name", IBIS)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf, True, "1", None])
def test_a_bird_is_made_of_positive_numbers(name, value):
    with pytest.raises(ValueError, match=rf"^{name}: expected .*, found {re.escape(repr(value))}$"):
        Bird(**{**IBIS, name: value})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (
            {"upstroke_span_ratio": 1.0},
            "upstroke_span_ratio: expected a ratio strictly between 0 and 1, found 1.0",
        ),
        (
            {"circulation_ratio": -0.5},
            "circulation_ratio: expected a finite number that is not negative, found -0.5",
        ),
        ({"amplitude_m": 1.3}, "amplitude_m: expected at most twice the semispan .*1.2 m.*, found 1.3"),
        (
            {"upstroke_span_ratio": 0.8},
            r"upstroke_span_ratio: expected a lone bird that makes thrust.*found 0\.8",
        ),
        ({"circulation_ratio": 2.0}, r"expected a lone bird that makes thrust.*found 0\.8"),
    ],
)
def test_what_a_bird_may_not_be(changes, says):
    with pytest.raises(ValueError, match=says):
        Bird(**{**IBIS, **changes})


def test_values_become_floats_whatever_kind_of_number_they_were():
    bird = Bird(**{**IBIS, "speed_m_s": 15, "mass_kg": np.float64(1.3)})
    assert all(type(getattr(bird, name)) is float for name in IBIS)
    assert bird == Bird(**IBIS)
