"""The compiled wake force: the same force as the plain statement of the model, and an exact Jacobian."""

import numpy as np
import pytest
from upwash.aero.compiled.lanes import (
    ALONG_X,
    ALONG_Z,
    AMPLITUDE,
    CENTRE_Y,
    CORE2,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    HEIGHT,
    LAST_X,
    LAST_Z,
    NODE,
    PHASE,
    SLIDING,
    SPAN_FIXED,
    SPAN_FLEXED,
    SPAN_RATIO,
    STEADY,
    X,
    Y,
    Z,
    wake_force_jacobian,
)
from upwash.aero.compiled.rings import ring_velocity_gradient
from upwash.aero.interaction import phase_piece, state_circulation_ratio, wake_force
from upwash.aero.lanes import core_edges, wake_lanes
from upwash.aero.pose import Pose, Stroke
from upwash.aero.span_integral import span_nodes
from upwash.aero.wake import WakeModel, vortex_wake

LEADER = 1.04, 0.4  # amplitude in m, upstroke span ratio
RESOLUTIONS = [(2, 2), (2, 5), (3, 2), (3, 4), (4, 3), (5, 2)]  # stroke states, span nodes
EACH_RESOLUTION = pytest.mark.parametrize(("states", "nodes"), RESOLUTIONS)


def lanes_of(bird, states, nodes, piece):
    """Return the lanes of a bird behind one like itself, lengths in semispans, forces in N."""
    b = bird.semispan_m
    wake = vortex_wake(
        LEADER[0] / b,
        LEADER[1],
        1.0,
        bird.wavelength_m / b,
        bird.circulation_m2_s / b,  # velocity of a ring of the scaled size is then in m/s
        bird.circulation_ratio,
        WakeModel(stroke_states=states),
    )
    wing = np.array([state_circulation_ratio(bird, k, states) for k in range(states)])
    wing *= bird.density_kg_m3 * bird.circulation_m2_s * 2.0 * b
    return wake_lanes(wake, *phase_piece(piece, states), wing, states, nodes)


def force_and_jacobian(point, lanes, edges=None):
    """Return lift and thrust as an array and their Jacobian."""
    jacobian = np.full((2, 6), np.nan)
    edges = core_edges(lanes) if edges is None else edges
    return np.array(wake_force_jacobian(np.array(point), lanes, edges, jacobian)), jacobian


def followers(states, count, seed=0):
    """Return follower points in semispans: x, y, z, amplitude, upstroke span ratio, phase coordinate."""
    rng = np.random.default_rng(seed)
    low = [0.0, -2.0, -1.7, 0.4, 0.3, 0.0]
    return rng.uniform(low, [9.0, 4.0, 1.7, 1.7, 0.5, 1.0 / states], (count, 6))


def nearest_core_edge(point, lanes):
    """Return how near the nodes of a follower come to a core edge, in semispans."""
    span = lanes[SPAN_FIXED] + lanes[SPAN_FLEXED] * point[SPAN_RATIO]
    y = point[Y] + lanes[NODE] * span - lanes[CENTRE_Y]
    z = point[Z] + lanes[HEIGHT] * point[AMPLITUDE]
    run_x, run_z = lanes[LAST_X] - lanes[FIRST_X], lanes[LAST_Z] - lanes[FIRST_Z]
    below = (run_z * (point[X] - lanes[FIRST_X]) - run_x * (z - lanes[FIRST_Z])) / np.hypot(run_x, run_z)
    distances = [
        np.hypot(point[X] - lanes[FIRST_X], z - lanes[FIRST_Z]),
        np.hypot(point[X] - lanes[LAST_X], z - lanes[LAST_Z]),
        np.hypot(y + lanes[HALF_WIDTH], below),
        np.hypot(y - lanes[HALF_WIDTH], below),
    ]
    return abs(np.array(distances) - np.sqrt(lanes[CORE2])).min()


@EACH_RESOLUTION
def test_there_is_a_lane_for_each_ring_node_and_pair_of_states(ibis, states, nodes):
    rings = vortex_wake(*LEADER, 0.6, 3.75, 1.0, model=WakeModel(stroke_states=states)).rings.shape[0]
    lanes = lanes_of(ibis, states, nodes, 0)
    assert lanes.shape == (15, states * nodes * rings)
    assert lanes.flags.c_contiguous
    assert set(lanes[NODE]) == set(span_nodes(nodes)[0])


@EACH_RESOLUTION
def test_the_compiled_force_is_the_force_of_the_model(slack_ibis, states, nodes):
    model, b = WakeModel(stroke_states=states, span_nodes=nodes), slack_ibis.semispan_m
    for piece in range(states):
        lanes = lanes_of(slack_ibis, states, nodes, piece)
        for point in followers(states, 12, seed=piece):
            x, y, z, amplitude, ratio, t = point
            pose = Pose(b * x, b * y, b * z, Stroke(b * amplitude, ratio), piece / states + t)
            expected = wake_force(slack_ibis, Stroke(*LEADER), pose, model)
            found, _ = force_and_jacobian(point, lanes)
            assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)


@EACH_RESOLUTION
def test_the_jacobian_agrees_with_central_differences_away_from_core_edges(slack_ibis, states, nodes):
    lanes = lanes_of(slack_ibis, states, nodes, states - 1)
    step, tried = 2e-4, 0
    for point in followers(states, 60, seed=states):
        if nearest_core_edge(point, lanes) < 3 * step:
            continue
        tried += 1
        _, jacobian = force_and_jacobian(point, lanes)
        for variable in range(6):
            shift = step * np.eye(6)[variable]
            near, far = (
                force_and_jacobian(point + k * shift, lanes)[0]
                - force_and_jacobian(point - k * shift, lanes)[0]
                for k in (1, 2)
            )
            slope = (8 * near - far) / (12 * step)
            assert slope == pytest.approx(jacobian[:, variable], rel=1e-7, abs=1e-7 * slack_ibis.weight_n)
    assert tried > 30


def test_force_is_linear_in_the_phase_coordinate(ibis):
    lanes = lanes_of(ibis, 2, 2, 1)
    for point in followers(2, 10):
        ends = [force_and_jacobian([*point[:PHASE], t], lanes) for t in (0.0, 0.5)]
        middle, jacobian = force_and_jacobian([*point[:PHASE], 0.25], lanes)
        assert middle == pytest.approx(0.5 * (ends[0][0] + ends[1][0]), rel=1e-12, abs=1e-13)
        assert jacobian[:, PHASE] == pytest.approx(2.0 * (ends[1][0] - ends[0][0]), rel=1e-11, abs=1e-12)


def test_raised_tips_depend_on_their_height_and_span_and_lowered_ones_on_their_height_alone(ibis):
    # With z + h/2 kept, what changes with h is the force on the lowered tips; those do not know R.
    lanes = lanes_of(ibis, 2, 2, 1)
    raised, lowered = (np.ascontiguousarray(lanes[:, lanes[HEIGHT] == height]) for height in (0.5, -0.5))
    assert raised.shape == lowered.shape == (15, 8)
    for x, y, z, amplitude, ratio, t in followers(2, 10):
        here, there = [x, y, z, amplitude, ratio, t], [x, y, z - 0.1, amplitude + 0.2, ratio, t]
        assert force_and_jacobian(here, raised)[0] == pytest.approx(
            force_and_jacobian(there, raised)[0], rel=1e-11, abs=1e-12
        )
        assert (force_and_jacobian(here, lowered)[1][:, SPAN_RATIO] == 0.0).all()


def test_each_ring_has_a_core_of_its_own(ibis):
    lanes = lanes_of(ibis, 2, 2, 1)
    lanes[CORE2] *= np.linspace(0.3, 4.0, lanes.shape[1])
    for point in followers(2, 10):
        apart = [
            np.append(*force_and_jacobian(point, np.ascontiguousarray(lanes[:, k : k + 1])))
            for k in range(lanes.shape[1])
        ]
        assert np.append(*force_and_jacobian(point, lanes)) == pytest.approx(sum(apart), rel=1e-10, abs=1e-11)


def test_only_the_place_relative_to_the_wake_counts(ibis):
    lanes = lanes_of(ibis, 2, 2, 1)
    moved = lanes.copy()
    moved[CENTRE_Y] += 0.7
    for point in followers(2, 10):
        here, there = (
            force_and_jacobian(point, lanes),
            force_and_jacobian(point + 0.7 * np.eye(6)[Y], moved),
        )
        assert there[0] == pytest.approx(here[0], rel=1e-11, abs=1e-12)
        assert there[1] == pytest.approx(here[1], rel=1e-10, abs=1e-11)


@pytest.mark.parametrize("which", [0, 1, 2, 3])
def test_a_branch_is_continued_for_the_filament_that_is_named(ibis, which):
    # In the order starting, stopping, left, right; the point is within no core, one filament is taken so.
    lanes = lanes_of(ibis, 2, 2, 1)
    lane = np.ascontiguousarray(lanes[:, :1])
    edges = core_edges(lane)
    edges[which] = np.inf
    point = np.array([1.1, 0.9, 0.1, 1.2, 0.35, 0.2])
    span = lane[SPAN_FIXED, 0] + lane[SPAN_FLEXED, 0] * point[SPAN_RATIO]
    place = (
        point[X],
        point[Y] + lane[NODE, 0] * span - lane[CENTRE_Y, 0],
        point[Z] + lane[HEIGHT, 0] * point[AMPLITUDE],
    )
    ring = lane[[FIRST_X, LAST_X, FIRST_Z, LAST_Z, HALF_WIDTH, ALONG_X, ALONG_Z], 0]
    found = ring_velocity_gradient(*place, *ring, lane[CORE2, 0], *edges[:, 0])
    weight = span * (lane[STEADY, 0] + lane[SLIDING, 0] * point[PHASE])
    expected = weight * np.array([found[0], found[2]])
    assert force_and_jacobian(point, lane, edges)[0] == pytest.approx(expected, rel=1e-12)


def test_a_branch_continued_past_the_core_edge_is_smooth_there(ibis):
    # The follower's lowered inner tip crosses a tip vortex's core edge, as at the optimum.
    lanes = lanes_of(ibis, 2, 2, 1)
    start = np.array([3.05, 1.4605, -0.105, 1.2517, 0.347, 0.0])
    ys = start[Y] + np.linspace(-0.3, 0.3, 6001)
    edge_at = ys[np.argmin([nearest_core_edge([start[X], y, *start[2:]], lanes) for y in ys])]
    outer, rankine = np.full((4, lanes.shape[1]), -1.0), core_edges(lanes)
    jumps = []
    for edges in (rankine, outer):
        sides = [
            force_and_jacobian([start[X], edge_at + offset, *start[2:]], lanes, edges)[1]
            for offset in (-3e-4, 3e-4)
        ]
        jumps.append(abs(sides[1] - sides[0]).max() / abs(sides[0]).max())
    assert jumps[0] > 20 * jumps[1]
