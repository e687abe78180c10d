"""One vortex filament: Biot–Savart outside its core, a solid body's rotation within it."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.spatial.transform import Rotation
from upwash.aero.compiled.rings import filament_velocity

from . import paper

repeatable = settings(deadline=None, derandomize=True, max_examples=80)
coordinates = st.floats(-3.0, 3.0)
places = st.tuples(coordinates, coordinates, coordinates).map(np.array)

CIRCULATION, CORE = 0.9, 0.1
LONG = 1e6  # half the length of a filament that stands for an infinite one


def velocity(point, start, end, circulation=CIRCULATION, core=CORE):
    """Return the velocity of one filament as an array."""
    return np.array(filament_velocity(*point, *start, *end, circulation, core))


def distance(point, start, end):
    """Return the distance of a point from the line through a filament."""
    along = end - start
    return np.linalg.norm(np.cross(along, point - start)) / np.linalg.norm(along)


def velocity_by_quadrature(point, start, end, circulation):
    """Return ∫ Γ/4π dl × r/|r|³ along a filament, by adaptive quadrature."""
    along = end - start

    def integrand(s, component):
        arm = point - (start + s * along)
        return np.cross(along, arm)[component] / np.linalg.norm(arm) ** 3

    nearest = min(max(along @ (point - start) / (along @ along), 0.0), 1.0)
    return (
        circulation
        / (4 * math.pi)
        * np.array(
            [
                sum(
                    quad(integrand, low, high, args=(i,), epsabs=1e-13, epsrel=1e-12, limit=200)[0]
                    for low, high in ((0.0, nearest), (nearest, 1.0))
                )
                for i in range(3)
            ]
        )
    )


@pytest.mark.parametrize("seed", list(range(25)))
def test_outside_the_core_velocity_is_the_biot_savart_integral(seed):
    rng = np.random.default_rng(seed)
    start, end, point = rng.uniform(-2.0, 2.0, (3, 3))
    assert distance(point, start, end) > CORE
    expected = velocity_by_quadrature(point, start, end, CIRCULATION)
    assert velocity(point, start, end) == pytest.approx(expected, rel=1e-10, abs=1e-12)


@repeatable
@given(places, places, places, st.floats(0.01, 5.0))
def test_velocity_is_the_paper_s_outside_the_core_and_within(point, start, end, core):
    assume(np.linalg.norm(end - start) > 0.1)
    assume(min(np.linalg.norm(point - start), np.linalg.norm(point - end)) > 1e-3)
    expected = paper.velocity_of_filament(point, start, end, CIRCULATION, core)
    assert velocity(point, start, end, core=core) == pytest.approx(expected, rel=1e-10, abs=1e-11)


@pytest.mark.parametrize("r", [0.11, 0.5, 3.0])
def test_far_from_its_ends_a_filament_turns_the_fluid_right_handed_at_circulation_over_2_pi_r(r):
    start, end = np.array([-LONG, 0.0, 0.0]), np.array([LONG, 0.0, 0.0])
    speed = CIRCULATION / (2 * math.pi * r)
    assert velocity((0.0, r, 0.0), start, end) == pytest.approx([0.0, 0.0, speed], rel=1e-11)
    assert velocity((0.0, 0.0, r), start, end) == pytest.approx([0.0, -speed, 0.0], rel=1e-11)


def test_abreast_of_its_end_a_long_filament_counts_half():
    start, end = np.array([0.0, 0.0, 0.0]), np.array([LONG, 0.0, 0.0])
    speed = CIRCULATION / (4 * math.pi * 0.5)
    assert velocity((0.0, 0.5, 0.0), start, end) == pytest.approx([0.0, 0.0, speed], rel=1e-6)


@pytest.mark.parametrize("fraction", [1e-6, 0.25, 0.5, 1.0])
def test_within_the_core_the_fluid_turns_as_a_solid_body(fraction):
    start, end = np.array([-LONG, 0.0, 0.0]), np.array([LONG, 0.0, 0.0])
    turning = CIRCULATION / (2 * math.pi * CORE**2)
    for angle in (0.0, 1.0, 4.0):
        y, z = fraction * CORE * math.cos(angle), fraction * CORE * math.sin(angle)
        assert velocity((0.0, y, z), start, end) == pytest.approx([0.0, -turning * z, turning * y], rel=1e-11)


@repeatable
@given(places, places, places)
def test_within_the_core_the_integral_is_scaled_by_the_square_of_the_distance(point, start, end):
    r = distance(point, start, end) if np.linalg.norm(end - start) > 0.1 else 0.0
    assume(r > 0.01)
    wide = 2.0 * r
    bare = velocity(point, start, end, core=1e-3 * r)
    assert velocity(point, start, end, core=wide) == pytest.approx(bare * (r / wide) ** 2, rel=1e-10)


def across_the_edge(offset):
    """Return the velocity at an offset from the core edge of a tilted filament, off its middle."""
    start, end = np.array([0.0, 0.3, -0.2]), np.array([1.5, 0.3, 0.4])
    along = (end - start) / np.linalg.norm(end - start)
    outwards = np.cross(along, [0.0, 1.0, 0.0])
    return velocity(start + 0.6 * along + (CORE + offset) * outwards, start, end)


@pytest.mark.parametrize("offset", [1e-4, 1e-7, 1e-10])
def test_velocity_is_continuous_across_the_core_edge(offset):
    step = np.linalg.norm(across_the_edge(offset) - across_the_edge(-offset))
    speed = np.linalg.norm(across_the_edge(0.0))
    assert step <= 4.0 * speed * offset / CORE


def test_velocity_is_not_differentiable_at_the_core_edge():
    h = 1e-6 * CORE
    edge = np.linalg.norm(across_the_edge(0.0))
    inwards = (edge - np.linalg.norm(across_the_edge(-h))) / h
    outwards = (np.linalg.norm(across_the_edge(h)) - edge) / h
    # The speed grows like r within and falls like 1/r outside: the two slopes differ by 2 v/r_c.
    assert inwards > 0.0 > outwards
    assert inwards - outwards == pytest.approx(2.0 * edge / CORE, rel=1e-5)


@repeatable
@given(places, places, places, st.floats(0.05, 0.95))
def test_a_split_filament_induces_what_the_whole_does_within_the_core_and_out(point, start, end, share):
    assume(np.linalg.norm(end - start) > 0.1)
    split = start + share * (end - start)
    whole = velocity(point, start, end)
    parts = velocity(point, start, split) + velocity(point, split, end)
    assert parts == pytest.approx(whole, rel=1e-10, abs=1e-12)


@pytest.mark.parametrize("r", [0.3, 0.999, 1.001, 3.0])
def test_a_split_filament_equals_the_whole_on_either_side_of_the_core_edge(r):
    start, split, end = (np.array([x, 0.0, 0.5 * x]) for x in (0.0, 0.7, 2.0))
    point = 0.4 * end + r * CORE * np.array([0.0, 1.0, 0.0])
    parts = velocity(point, start, split) + velocity(point, split, end)
    assert parts == pytest.approx(velocity(point, start, end), rel=1e-13)


@repeatable
@given(places, places, places, st.floats(-5.0, 5.0))
def test_velocity_is_linear_in_circulation_and_turns_with_the_filament(point, start, end, factor):
    assume(np.linalg.norm(end - start) > 0.1)
    once = velocity(point, start, end)
    assert velocity(point, start, end, factor * CIRCULATION) == pytest.approx(
        factor * once, rel=1e-13, abs=1e-14
    )
    assert velocity(point, end, start) == pytest.approx(-once, rel=1e-13, abs=1e-14)


@repeatable
@given(places, places, places)
def test_mirror_image_in_y_with_the_sense_of_rotation_reversed(point, start, end):
    assume(np.linalg.norm(end - start) > 0.1)
    mirror = np.array([1.0, -1.0, 1.0])
    image = velocity(mirror * point, mirror * start, mirror * end, -CIRCULATION)
    assert image == pytest.approx(mirror * velocity(point, start, end), rel=1e-13, abs=1e-14)


@repeatable
@given(places, places, places, st.integers(0, 10**6), st.floats(0.01, 100.0))
def test_no_frame_and_no_unit_of_length_is_preferred(point, start, end, seed, scale):
    assume(np.linalg.norm(end - start) > 0.1)
    assume(distance(point, start, end) > 1e-3)
    rng = np.random.default_rng(seed)
    turn, shift = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-1.0, 1.0, 3)
    moved = [scale * (turn @ place + shift) for place in (point, start, end)]
    expected = turn @ velocity(point, start, end) / scale
    found = velocity(*moved, core=scale * CORE)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-12 / scale)


@pytest.mark.parametrize("share", [-0.5, 0.0, 0.3, 1.0, 2.0])
def test_on_the_axis_and_at_the_ends_of_a_filament_it_induces_nothing(share):
    start, end = np.array([0.1, -0.2, 0.3]), np.array([1.1, 0.4, -0.1])
    assert velocity(start + share * (end - start), start, end) == pytest.approx([0.0, 0.0, 0.0], abs=1e-14)


@pytest.mark.parametrize("step", [1e-30, 1e-12, 1e-6, 1e-3])
def test_velocity_stays_below_that_of_the_core_edge_of_an_infinite_filament(step):
    start, end = np.zeros(3), np.array([1.0, 0.0, 0.0])
    bound = CIRCULATION / (2 * math.pi * CORE)
    for direction in np.vstack([np.eye(3), -np.eye(3), np.ones((1, 3))]):
        found = np.linalg.norm(velocity(start + step * direction, start, end))
        assert found <= bound * step / CORE * 2.0


def test_a_right_wingtip_vortex_trailing_downstream_gives_upwash_outboard():
    start, end = (0.0, 0.5, 0.0), (4.0, 0.5, 0.0)
    assert velocity((2.0, 1.0, 0.0), start, end)[2] > 0.0 > velocity((2.0, 0.0, 0.0), start, end)[2]
