"""Closed vortex rings at many points: the sum of their filaments, an exact gradient, the laws of a field."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from upwash.aero.compiled.rings import (
    BLOCK,
    FOUR_PI,
    filament_velocity,
    fill_velocity,
    ring_velocity_gradient,
)
from upwash.aero.induction import velocity, velocity_gradient

CORE = 0.1

# Two tilted rectangles: x of the first and the last station, z of the two, y of the centreline, half width.
RINGS = np.array([[0.0, 1.9, 0.5, -0.5, 0.0, 0.19], [1.9, 3.8, -0.4, 0.6, 0.3, 0.47]])
CIRCULATION = np.array([0.9, -1.3])


def corners(ring):
    """Return the corners of a ring: starting vortex left and right, stopping vortex right and left."""
    first_x, last_x, first_z, last_z, centre, half = ring
    return np.array(
        [
            [first_x, centre - half, first_z],
            [first_x, centre + half, first_z],
            [last_x, centre + half, last_z],
            [last_x, centre - half, last_z],
        ]
    )


def velocity_of_filaments(point, rings=RINGS, circulation=CIRCULATION, core=CORE):
    """Return the velocity at a point, filament by filament."""
    total = np.zeros(3)
    for ring, strength in zip(rings, circulation, strict=True):
        loop = corners(ring)
        for start, end in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            total += filament_velocity(*point, *start, *end, strength, core)
    return total


def distances(points, rings=RINGS):
    """Return the distance of each point from each line on which a filament lies: (p, 4 n)."""
    found = []
    for ring in rings:
        loop = corners(ring)
        for start, end in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            along = (end - start) / np.linalg.norm(end - start)
            found.append(np.linalg.norm(np.cross(points - start, along), axis=-1))
    return np.stack(found, axis=-1)


def scattered(count, seed=0):
    """Return points all about the rings, a third of them within a core."""
    rng = np.random.default_rng(seed)
    points = rng.uniform([-1.0, -1.0, -1.0], [5.0, 1.2, 1.2], (count, 3))
    for point in points[::3]:
        loop = corners(RINGS[rng.integers(2)])
        k = rng.integers(4)
        on_filament = loop[k] + rng.uniform() * (loop[(k + 1) % 4] - loop[k])
        point[:] = on_filament + rng.normal(size=3) * CORE / 3
    return points


def off_the_edges(points, margin):
    """Return the points that are no nearer to a core edge than a margin."""
    return points[(abs(distances(points) - CORE) > margin).all(axis=-1)]


def central_differences(points, step):
    """Return the gradient of the velocity by central differences of fourth order: (p, 3, 3)."""
    columns = []
    for axis in np.eye(3):
        near = velocity(points + step * axis, RINGS, CIRCULATION, CORE) - velocity(
            points - step * axis, RINGS, CIRCULATION, CORE
        )
        far = velocity(points + 2 * step * axis, RINGS, CIRCULATION, CORE) - velocity(
            points - 2 * step * axis, RINGS, CIRCULATION, CORE
        )
        columns.append((8 * near - far) / (12 * step))
    return np.stack(columns, axis=-1)


def test_rings_induce_the_sum_of_their_filaments_within_the_cores_and_out():
    points = scattered(600)
    within = (distances(points) < CORE).any(axis=-1)
    assert 100 < within.sum() < 500
    expected = np.array([velocity_of_filaments(point) for point in points])
    assert velocity(points, RINGS, CIRCULATION, CORE) == pytest.approx(expected, rel=1e-12, abs=1e-13)


def test_velocity_and_gradient_come_from_the_same_field():
    for point in scattered(60, seed=1):
        total = np.zeros(3)
        for ring, strength in zip(RINGS, CIRCULATION, strict=True):
            first_x, last_x, first_z, last_z, centre, half = ring
            run = math.hypot(last_x - first_x, last_z - first_z)
            along = (last_x - first_x) / run, (last_z - first_z) / run
            found = ring_velocity_gradient(
                point[0], point[1] - centre, point[2], *ring[:4], half, *along, *[CORE**2] * 5
            )
            total += strength / FOUR_PI * np.array(found[:3])
        assert total == pytest.approx(velocity(point, RINGS, CIRCULATION, CORE), rel=1e-12, abs=1e-13)


def test_the_gradient_agrees_with_central_differences_within_the_cores_and_out():
    points = off_the_edges(scattered(600, seed=2), margin=5e-3)
    within = (distances(points) < CORE).any(axis=-1)
    assert within.sum() > 50 and (~within).sum() > 50
    # Nor near a filament's end, where higher derivatives grow without bound.
    ends = np.concatenate([corners(ring) for ring in RINGS])
    points = points[np.linalg.norm(points[:, None] - ends, axis=-1).min(axis=1) > 0.05]
    exact = velocity_gradient(points, RINGS, CIRCULATION, CORE)
    scale = abs(CIRCULATION).max() / (2 * math.pi * CORE**2)
    assert central_differences(points, 3e-4) == pytest.approx(exact, rel=1e-7, abs=1e-7 * scale)


def test_on_a_core_edge_the_gradient_is_that_from_within():
    # Beside the middle of the second ring's right tip vortex.
    loop = corners(RINGS[1])
    point = 0.5 * (loop[1] + loop[2])
    inside, outside = point + [0.0, CORE * (1 - 1e-7), 0.0], point + [0.0, CORE * (1 + 1e-7), 0.0]
    slopes = velocity_gradient([inside, outside], RINGS, CIRCULATION, CORE)[:, 2, 1]
    # The stronger, negative circulation: downwash grows outwards within the core and fades outside.
    assert slopes[0] < 0.0 < slopes[1]


def test_the_field_is_free_of_divergence_within_the_cores_and_out():
    gradient = velocity_gradient(scattered(400, seed=3), RINGS, CIRCULATION, CORE)
    size = np.linalg.norm(gradient, axis=(1, 2))
    assert (abs(np.trace(gradient, axis1=1, axis2=2)) <= 1e-12 * size).all()


def test_as_much_fluid_leaves_a_box_as_enters_it():
    # A box around part of a tip vortex, its faces across cores and their edges: Gauss's rule on each face.
    nodes, weights = np.polynomial.legendre.leggauss(60)
    low, high = np.array([2.2, 0.4, -0.4]), np.array([2.9, 1.1, 0.3])
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    one, other = (grid.ravel() for grid in np.meshgrid(nodes, nodes))
    area = np.outer(weights, weights).ravel()
    net = gross = 0.0
    for axis in range(3):
        across = [i for i in range(3) if i != axis]
        for side in (-1.0, 1.0):
            points = np.empty((one.size, 3))
            points[:, axis] = middle[axis] + side * half[axis]
            points[:, across[0]] = middle[across[0]] + half[across[0]] * one
            points[:, across[1]] = middle[across[1]] + half[across[1]] * other
            through = (
                side * velocity(points, RINGS, CIRCULATION, CORE)[:, axis] * half[across[0]] * half[across[1]]
            )
            net += through @ area
            gross += abs(through) @ area
    assert abs(net) <= 2e-4 * gross


def test_outside_the_cores_a_closed_ring_leaves_the_fluid_free_of_rotation():
    # True of a closed loop only: a filament that ended, or carried another circulation, would break it.
    points = off_the_edges(scattered(400, seed=4), margin=0.0)
    points = points[(distances(points) > CORE).all(axis=-1)]
    gradient = velocity_gradient(points, RINGS, CIRCULATION, CORE)
    assert points.shape[0] > 50
    assert gradient == pytest.approx(gradient.transpose(0, 2, 1), rel=1e-11, abs=1e-11)


def test_in_the_middle_of_a_flat_square_ring():
    side = 1.4
    ring = [[0.0, side, 0.2, 0.2, 0.0, side / 2]]
    # Along the starting vortex to the right, then downstream: the loop turns right-handed about −z.
    expected = [0.0, 0.0, -2 * math.sqrt(2) * 0.9 / (math.pi * side)]
    assert velocity([side / 2, 0.0, 0.2], ring, [0.9], CORE) == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_far_from_a_ring_the_field_is_a_dipole_s():
    ring, circulation = RINGS[0], 0.9
    first_x, last_x, first_z, last_z, _, half = ring
    area = 2 * half * np.array([last_z - first_z, 0.0, first_x - last_x])  # (r₂ − r₁) × (r₃ − r₂)
    middle = np.array([0.5 * (first_x + last_x), 0.0, 0.5 * (first_z + last_z)])
    for direction in ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, -0.48, 0.64]):
        direction = np.array(direction)
        dipole = circulation / (FOUR_PI * 200.0**3) * (3 * (area @ direction) * direction - area)
        found = velocity(middle + 200.0 * direction, ring[None], [circulation], CORE)
        assert found == pytest.approx(dipole, rel=1e-3, abs=1e-3 * np.linalg.norm(dipole))


def test_a_ring_is_symmetric_in_its_midplane():
    rings, mirror = RINGS * [1, 1, 1, 1, 0, 1], np.array([1.0, -1.0, 1.0])
    points = scattered(200, seed=5)
    here, there = (
        velocity(points, rings, CIRCULATION, CORE),
        velocity(points * mirror, rings, CIRCULATION, CORE),
    )
    assert there == pytest.approx(here * mirror, rel=1e-13, abs=1e-14)


def test_a_rectangle_is_symmetric_about_its_middle():
    ring, circulation = RINGS[:1], CIRCULATION[:1]
    middle = np.array([0.95, 0.0, 0.0])
    points = scattered(200, seed=6)
    here = velocity(points, ring, circulation, CORE)
    there = velocity(2 * middle - points, ring, circulation, CORE)
    assert there == pytest.approx(here, rel=1e-12, abs=1e-14)


def test_rings_that_share_a_filament_make_one_longer_ring():
    whole = np.array([[0.0, 2.0, 0.5, -0.5, 0.1, 0.4]])
    parts = np.array([[0.0, 0.6, 0.5, 0.2, 0.1, 0.4], [0.6, 2.0, 0.2, -0.5, 0.1, 0.4]])
    points = scattered(200, seed=7)
    assert velocity(points, parts, [0.9, 0.9], CORE) == pytest.approx(
        velocity(points, whole, [0.9], CORE), rel=1e-11, abs=1e-13
    )


def test_velocity_and_gradient_are_linear_in_circulation():
    points = scattered(50, seed=8)
    for field in (velocity, velocity_gradient):
        each = [field(points, RINGS[k : k + 1], CIRCULATION[k : k + 1], CORE) for k in (0, 1)]
        both = field(points, RINGS, [-2.0 * CIRCULATION[0], 0.5 * CIRCULATION[1]], CORE)
        assert both == pytest.approx(-2.0 * each[0] + 0.5 * each[1], rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("offset", [0.0, 1e-20, 1e-13, 1e-8])
def test_the_field_is_finite_at_corners_and_on_filaments(offset):
    loops = np.concatenate([corners(ring) for ring in RINGS])
    on_filaments = [0.3 * loops[k] + 0.7 * loops[k + 1] for k in (0, 1, 2, 4, 5, 6)]
    points = np.concatenate([loops, on_filaments]) + offset
    expected = np.array([velocity_of_filaments(point) for point in points])
    assert velocity(points, RINGS, CIRCULATION, CORE) == pytest.approx(expected, rel=1e-11, abs=1e-12)
    bound = 8 * abs(CIRCULATION).max() / (2 * math.pi * CORE**2)
    assert (abs(velocity_gradient(points, RINGS, CIRCULATION, CORE)) < bound).all()


@pytest.mark.parametrize(
    ("edges", "core"),
    # −1 continues the outer branch inwards: a core too thin to matter.  ∞ continues the inner outwards:
    # a core that holds every point, its speed scaled to the radius of this one.
    [(-1.0, 1e-7), (math.inf, 50.0)],
)
def test_a_branch_of_the_core_continued_past_its_edge_is_the_field_of_another_core(edges, core):
    points = scattered(100, seed=9)
    ring = [*RINGS[0, :4], RINGS[0, 5]]
    run = math.hypot(1.9, -1.0)
    scale = (core / CORE) ** 2 if edges > 0 else 1.0
    expected_velocity = scale * velocity(points, RINGS[:1], [FOUR_PI], core)
    expected_gradient = scale * velocity_gradient(points, RINGS[:1], [FOUR_PI], core)
    for point, of_velocity, of_gradient in zip(points, expected_velocity, expected_gradient, strict=True):
        found = np.array(ring_velocity_gradient(*point, *ring, 1.9 / run, -1.0 / run, CORE**2, *[edges] * 4))
        assert found[:3] == pytest.approx(of_velocity, rel=1e-9, abs=1e-9)
        assert found[3:].reshape(3, 3) == pytest.approx(of_gradient, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("which", [0, 1, 2, 3])
def test_each_filament_has_its_own_edge(which):
    # Within all four cores of a small ring; one filament at a time is taken on its outer branch.
    ring = np.array([0.0, 0.12, 0.03, -0.03, 0.05])
    run = math.hypot(0.12, 0.06)
    place = 0.05, 0.01, 0.02
    edges = np.full(4, CORE**2)
    edges[which] = 0.0
    found = ring_velocity_gradient(*place, *ring, 0.12 / run, -0.06 / run, CORE**2, *edges)
    loop = corners([*ring[:4], 0.0, ring[4]])
    first, right, last, left = zip(loop, np.roll(loop, -1, axis=0), strict=True)
    expected = np.zeros(3)
    for k, (start, end) in enumerate((first, last, left, right)):
        core = 1e-6 if k == which else CORE
        expected += filament_velocity(*place, *start, *end, FOUR_PI, core)
    assert found[:3] == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("shape", [(3,), (1, 3), (4, 3), (2, 5, 3), (0, 3)])
def test_the_field_has_the_shape_of_the_points(shape):
    points = np.random.default_rng(0).uniform(-1, 1, shape)
    found = velocity(points, RINGS, CIRCULATION, CORE)
    gradient = velocity_gradient(points, RINGS, CIRCULATION, CORE)
    assert found.shape == shape and gradient.shape == (*shape, 3)
    each = [velocity(point, RINGS, CIRCULATION, CORE) for point in points.reshape(-1, 3)]
    assert found.reshape(-1, 3) == pytest.approx(np.array(each).reshape(-1, 3), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("count", [BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK + 7])
def test_every_point_of_every_block_is_reached(count):
    points = scattered(count, seed=10)
    found = velocity(points, RINGS, CIRCULATION, CORE)
    backwards = velocity(points[::-1], RINGS, CIRCULATION, CORE)[::-1]
    assert found == pytest.approx(backwards, rel=1e-12, abs=1e-13)
    for k in (0, BLOCK - 2, count - 1):
        assert found[k] == pytest.approx(velocity_of_filaments(points[k]), rel=1e-12, abs=1e-13)


def test_points_may_be_lists_integers_read_only_or_strided_and_are_left_alone():
    whole = scattered(40, seed=11)
    kept = whole.copy()
    whole.flags.writeable = False
    expected = velocity(kept, RINGS, CIRCULATION, CORE)
    assert (velocity(whole, RINGS, CIRCULATION, CORE) == expected).all()
    assert (velocity(np.asfortranarray(whole), RINGS, CIRCULATION, CORE) == expected).all()
    assert (whole == kept).all()
    assert velocity([[1, 0, 0]], RINGS.tolist(), CIRCULATION.tolist(), CORE).shape == (1, 3)


def test_no_ring_induces_nothing():
    assert (velocity(scattered(3), np.empty((0, 6)), [], CORE) == 0.0).all()


def test_each_ring_has_a_core_of_its_own():
    points, cores = scattered(300, seed=14), CORE * np.linspace(0.5, 3.0, len(RINGS))
    for found in (velocity, velocity_gradient):
        apart = [found(points, RINGS[k : k + 1], CIRCULATION[k : k + 1], cores[k]) for k in range(len(RINGS))]
        assert found(points, RINGS, CIRCULATION, cores) == pytest.approx(sum(apart), rel=1e-12, abs=1e-12)


def test_threads_fill_parts_of_one_array():
    points = scattered(4 * BLOCK, seed=12)
    found, cores = np.full_like(points, np.nan), np.full(len(CIRCULATION), CORE)

    def fill(part):
        fill_velocity(points[part], RINGS, CIRCULATION, cores, found[part])

    with ThreadPoolExecutor(2) as threads:
        list(threads.map(fill, [slice(0, 3 * BLOCK), slice(3 * BLOCK, None)]))
    assert (found == velocity(points, RINGS, CIRCULATION, CORE)).all()
