"""The similarity law: birds with equal dimensionless groups have the same scaled solution."""

from dataclasses import replace

import pytest
from upwash import load_species, solve_pair
from upwash.aero.bird import Bird

MASS_RATIO = 100.0
SCALED_LIKE_LENGTH = ("x_m", "y_m", "z_m", "amplitude_m")
SCALED_LIKE_WEIGHT = ("lift_self_n", "thrust_self_n", "lift_wake_n", "thrust_wake_n", "drag_n")
FREE_OF_UNITS = ("upstroke_span_ratio", "phase", "saving_induced", "saving_profile")
LABELS = ("placement", "tier", "station", "is_v_optimum", "is_global_optimum", "active_bounds")


def groups(bird: Bird) -> list[float]:
    """Return the four groups on which a force-optimal pair depends."""
    b = bird.semispan_m
    return [
        bird.weight_n / (bird.density_kg_m3 * b**2 * bird.speed_m_s**2),
        bird.wavelength_m / b,
        bird.amplitude_m / b,
        bird.upstroke_span_ratio,
    ]


def scaled(bird: Bird) -> Bird:
    """Return a bird a hundred times as heavy, elsewhere and in other air, with the same groups."""
    density_ratio, gravity_ratio, length_ratio = 0.6, 0.9, 5.0
    weight_ratio = MASS_RATIO * gravity_ratio
    speed_ratio = (weight_ratio / density_ratio) ** 0.5 / length_ratio
    return replace(
        bird,
        mass_kg=MASS_RATIO * bird.mass_kg,
        semispan_m=length_ratio * bird.semispan_m,
        amplitude_m=length_ratio * bird.amplitude_m,
        speed_m_s=speed_ratio * bird.speed_m_s,
        period_s=length_ratio / speed_ratio * bird.period_s,
        density_kg_m3=density_ratio * bird.density_kg_m3,
        gravity_m_s2=gravity_ratio * bird.gravity_m_s2,
    )


BIRD = load_species("common-starling").bird()
GIANT = scaled(BIRD)


@pytest.fixture(scope="module", params=["force", "power"])
def objective(request):
    return request.param


@pytest.fixture(scope="module")
def pairs(objective):
    """Return the V optima of a starling and of its giant, and the best optima of both."""
    small, large = (solve_pair(bird, objective) for bird in (BIRD, GIANT))
    return [(small.v_optimum, large.v_optimum), (small.global_optimum, large.global_optimum)]


def alike(value):
    """Compare to the promised 1e-8, absolutely: positions in semispans, forces in weights."""
    return pytest.approx(value, rel=0.0, abs=1e-8)


def test_the_giant_is_a_hundred_times_as_heavy_and_has_the_same_groups():
    assert GIANT.mass_kg == MASS_RATIO * BIRD.mass_kg
    assert groups(GIANT) == pytest.approx(groups(BIRD), rel=1e-13)


def test_equal_groups_give_the_same_position_stroke_and_labels(pairs):
    for small, large in pairs:
        for name in SCALED_LIKE_LENGTH:
            assert getattr(large, name) / GIANT.semispan_m == alike(getattr(small, name) / BIRD.semispan_m)
        for name in FREE_OF_UNITS:
            assert getattr(large, name) == alike(getattr(small, name))
        for name in LABELS:
            assert getattr(large, name) == getattr(small, name)


def test_equal_groups_give_the_same_forces_in_weights(pairs):
    for small, large in pairs:
        for name in SCALED_LIKE_WEIGHT:
            assert getattr(large, name) / GIANT.weight_n == alike(getattr(small, name) / BIRD.weight_n)


def test_the_saving_of_total_power_does_not_scale_as_the_body_does_not(pairs):
    # The body's area grows with mass^0.666 whatever the wings do: parasite power is not in the groups.
    for small, large in pairs:
        assert abs(large.saving_total - small.saving_total) > 1e-3


def test_another_group_gives_another_solution(pairs, objective):
    other = solve_pair(replace(BIRD, gravity_m_s2=1.01 * BIRD.gravity_m_s2), objective).v_optimum
    assert abs(other.x_m - pairs[0][0].x_m) / BIRD.semispan_m > 1e-6
