"""Core edges: where they lie, which are one surface, and how the model's slope jumps across them."""

import numpy as np
import pytest
from upwash.aero.compiled.lanes import CORE2, HEIGHT, NODE, SPAN_FIXED, SPAN_FLEXED
from upwash.aero.lanes import core_edges
from upwash.aero.pose import Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.compiled.edges import edge_distance, edge_pull
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.core_edge import CoreEdge, edges_in, other_side
from upwash.optimum.edges import FILAMENTS, distinct_edges
from upwash.optimum.evidence import name_edge
from upwash.optimum.problem import PairProblem

# Corner of a ring at which each of FILAMENTS begins; it ends at the next.
CORNER = {"starting": 0, "right tip": 1, "stopping": 2, "left tip": 3}


@pytest.fixture(
    scope="module",
    params=[WakeModel(), WakeModel(span_nodes=3), WakeModel(stroke_states=3)],
    ids=["paper", "3 nodes", "3 states"],
)
def problem(request, ibis):
    return PairProblem(ibis, "force", Stroke(0.8, 0.35), model=request.param)


@pytest.fixture(scope="module")
def edges(problem):
    return distinct_edges(problem.lanes, problem.bounds)


def random_points(problem, count, seed=2):
    low, high = problem.bounds.T
    return low + np.random.default_rng(seed).random((count, 6)) * (high - low)


def distance(problem, point, lane, filament):
    """Return a lane's edge distance at a point, and its gradient."""
    gradient = np.empty(6)
    value = edge_distance(point, problem.lanes, lane, filament, gradient)
    return value, gradient


def each_filament(problem):
    return [(lane, k) for lane in range(problem.lanes.shape[1]) for k in range(len(FILAMENTS))]


def test_an_edge_is_a_core_radius_from_the_line_of_its_filament(problem):
    corners = problem.wake().corners()
    for point in random_points(problem, 3):
        for lane, k in each_filament(problem):
            of = problem.lanes[:, lane]
            reach = of[NODE] * (of[SPAN_FIXED] + of[SPAN_FLEXED] * point[4])
            place = [point[0], point[1] + reach, point[2] + of[HEIGHT] * point[3]]
            loop = corners[problem.ring_of_lane[lane]]
            begin = CORNER[FILAMENTS[k]]
            along = loop[(begin + 1) % 4] - loop[begin]
            across = np.cross(along, place - loop[begin])
            expected = across @ across / (along @ along) / of[CORE2] - 1.0
            assert distance(problem, point, lane, k)[0] == pytest.approx(expected, rel=1e-10, abs=1e-10)


def test_the_gradient_of_the_distance_is_its_slope(problem):
    step = 1e-4
    for point in random_points(problem, 3):
        for name in each_filament(problem):
            gradient = distance(problem, point, *name)[1]
            for i, axis in enumerate(step * np.eye(6)):
                above, below = (distance(problem, point + way * axis, *name)[0] for way in (1, -1))
                # The distance is a quadratic of each variable: central differences have but rounding to err by.
                assert gradient[i] == pytest.approx((above - below) / (2 * step), rel=1e-7, abs=1e-7)


def test_filaments_that_share_an_edge_are_as_far_from_everywhere(problem, edges):
    group, representative = edges
    for point in random_points(problem, 10):
        here = np.array([distance(problem, point, *one)[0] for one in representative])
        for lane, k in each_filament(problem):
            assert distance(problem, point, lane, k)[0] == pytest.approx(here[group[k, lane]], abs=1e-9)


def test_edges_that_are_told_apart_are_apart_somewhere(problem, edges):
    _, representative = edges
    signature = np.array(
        [[distance(problem, p, *one)[0] for p in random_points(problem, 10)] for one in representative]
    )
    apart = np.max(np.abs(signature[:, None] - signature[None]), axis=-1)
    assert np.min(apart + np.diag(np.full(len(representative), np.inf))) > 1e-6


def test_in_the_paper_s_model_no_two_edges_have_one_name(ibis):
    problem = PairProblem(ibis)
    _, representative = distinct_edges(problem.lanes, problem.bounds)
    names = [name_edge(problem, *one) for one in representative]
    assert len(set(names)) == len(names)
    assert CoreEdge("left", "down", "right tip", "upstroke", "up") in names
    text = ", ".join(map(str, names))
    assert edges_in(text) == tuple(names)
    assert edges_in("") == ()


def test_edges_on_the_other_side_are_those_of_the_mirrored_follower(ibis):
    for nodes in (2, 5):
        problem = PairProblem(ibis, model=WakeModel(span_nodes=nodes))
        _, representative = distinct_edges(problem.lanes, problem.bounds)
        names = {name_edge(problem, *one) for one in representative}
        # To each edge there is one with left and right exchanged.
        assert {name.mirrored() for name in names} == names
        text = ", ".join(map(str, names))
        assert other_side(text) != text and other_side(other_side(text)) == text


def test_both_wingtips_share_the_edge_of_a_spanwise_filament_and_no_other(problem, edges):
    group, _ = edges
    nodes, heights = problem.lanes[NODE], problem.lanes[HEIGHT]
    rings, lanes = problem.ring_of_lane, np.arange(nodes.size)
    states = np.searchsorted(problem.first_lanes, lanes, side="right")
    for left in np.flatnonzero(nodes == -1.0):
        is_like = (rings == rings[left]) & (states == states[left]) & (heights == heights[left])
        (right,) = np.flatnonzero((nodes == 1.0) & is_like)
        assert list(group[:2, left]) == list(group[:2, right])
        assert not set(group[2:, left]) & set(group[2:, right])


def point_on(problem, edge, point):
    """Return a point on an edge, by Newton's method from another."""
    for _ in range(100):
        value, gradient = distance(problem, point, *edge)
        if abs(value) < 1e-15:
            break
        point = point - value * gradient / (gradient @ gradient)
    return point


def lagrangian(problem, point, multipliers):
    """Return the Lagrangian at a point: what is cheap to balance."""
    core = core_edges(problem.lanes)
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    cost = evaluate(point, problem.lanes, core, problem.constants, residual, gradient, jacobian)
    return cost + multipliers @ residual


def test_the_pull_of_an_edge_is_the_jump_of_the_lagrangian_s_slope(problem, edges):
    group, representative = edges
    multipliers = np.array([-0.9, -0.4])
    jumps = []
    for number, edge in enumerate(representative):
        points = [point_on(problem, edge, point) for point in random_points(problem, 20, seed=number)]
        pulls = [edge_pull(point, problem.lanes, group, number, multipliers) for point in points]
        pull, point = max(zip(pulls, points, strict=True), key=lambda both: abs(both[0]))
        _, normal = distance(problem, point, *edge)
        step = 1e-6 * normal / np.linalg.norm(normal)
        within, on, beyond = (lagrangian(problem, point + k * step, multipliers) for k in (-1, 0, 1))
        jump = ((beyond - on) - (on - within)) / 1e-6
        # Curvature on either side changes the slope too, in proportion to the step.
        assert jump == pytest.approx(-pull * np.linalg.norm(normal), rel=1e-3, abs=1e-4)
        jumps.append(abs(jump))
    # With three states, some pairs of states never meet in one piece of phase.
    assert np.mean(np.array(jumps) > 1e-2) > 0.25


def test_an_edge_that_is_crossed_leaves_forces_continuous(problem, edges):
    multipliers = np.array([-0.9, -0.4])
    for number, edge in enumerate(edges[1]):
        point = point_on(problem, edge, random_points(problem, 1, seed=number)[0])
        _, normal = distance(problem, point, *edge)
        step = 1e-9 * normal / np.linalg.norm(normal)
        ends = [lagrangian(problem, point + way * step, multipliers) for way in (-1, 1)]
        assert ends[0] == pytest.approx(ends[1], abs=1e-7)
