"""The scaled problem is the SI physics: the same balances, the same cost, the paper's bounds."""

from dataclasses import replace

import numpy as np
import pytest
from upwash.aero.interaction import net_force
from upwash.aero.lanes import core_edges
from upwash.aero.pose import Stroke
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.problem import PairProblem
from upwash.optimum.variables import VARIABLES

POINTS = 20


def evaluated(problem, point):
    """Return cost, residual, gradient and Jacobian of a scaled point."""
    edges = core_edges(problem.lanes)
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    cost = evaluate(point, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
    return cost, residual, gradient, jacobian


def random_points(problem, count=POINTS):
    low, high = problem.bounds.T
    return low + np.random.default_rng(5).random((count, 6)) * (high - low)


@pytest.fixture(params=[1.0, 0.7], ids=["even wake", "slack upstroke"])
def bird(request, ibis):
    return replace(ibis, circulation_ratio=request.param)


@pytest.fixture(
    params=[
        WakeModel(),
        WakeModel(span_nodes=5),
        WakeModel(stroke_states=4),
        WakeModel(core_radius_ratio=0.1),
    ],
    ids=["paper", "5 nodes", "4 states", "thin core"],
)
def model(request):
    return request.param


def flock_problem(bird, objective="force", model=None, piece=1):
    """Pose the problem behind a bird that flaps less than a lone one."""
    return PairProblem(
        bird, objective, Stroke(0.7 * bird.amplitude_m, 0.35), model=model or WakeModel(), piece=piece
    )


class TestUnits:
    """Lengths in semispans, forces in weights, costs in the lone bird's."""

    def test_the_residual_is_what_lift_and_thrust_exceed_weight_and_drag_by(self, bird, model):
        for piece in range(model.stroke_states):
            problem = flock_problem(bird, model=model, piece=piece)
            for point in random_points(problem, 5):
                lift, thrust = net_force(bird, problem.ahead, problem.pose(point), model)
                expected = [lift - bird.weight_n, thrust - bird.drag_n]
                assert evaluated(problem, point)[1] * bird.weight_n == pytest.approx(expected, abs=1e-10)

    @pytest.mark.parametrize("objective", sorted(COST_FUNCTIONS))
    def test_the_cost_is_that_of_the_follower_s_own_forces_over_the_lone_bird_s(self, bird, objective):
        problem, value = flock_problem(bird, objective), COST_FUNCTIONS[objective].value
        for point in random_points(problem):
            lift, thrust = bird.lift_n(point[4]), bird.thrust_n(point[3] * bird.semispan_m, point[4])
            expected = value(bird, lift, thrust) / value(bird, bird.weight_n, bird.drag_n)
            assert evaluated(problem, point)[0] == pytest.approx(expected, rel=1e-13)

    @pytest.mark.parametrize("objective", sorted(COST_FUNCTIONS))
    def test_the_lone_bird_costs_1_and_balances_where_there_is_no_wake(self, bird, objective):
        problem = PairProblem(bird, objective)
        alone = [1e4, 1e4, 0.0, problem.leader_height, bird.upstroke_span_ratio, 0.2]
        cost, residual, _, _ = evaluated(problem, np.array(alone))
        assert cost == pytest.approx(1.0, rel=1e-13)
        assert residual == pytest.approx([0.0, 0.0], abs=1e-6)

    def test_phases_kappa_and_one_less_kappa_have_one_coordinate(self, ibis):
        problem = PairProblem(ibis)
        assert [problem.phase(mu) for mu in (0.0, 0.5)] == [0.5, 0.0]
        assert problem.phase(0.2) == pytest.approx(0.3)

    def test_the_pieces_of_phase_follow_one_another_around_the_wingbeat(self, ibis):
        pieces = [PairProblem(ibis, model=WakeModel(stroke_states=3), piece=piece) for piece in range(3)]
        for one, after in zip(pieces, [*pieces[1:], pieces[0]], strict=True):
            assert one.phase(one.phase_span()) == pytest.approx(after.phase(0.0), abs=1e-15)


class TestDerivatives:
    """Gradient and Jacobian are those of the cost and the residual."""

    @pytest.mark.parametrize("objective", sorted(COST_FUNCTIONS))
    def test_against_central_differences(self, bird, objective):
        problem, step = flock_problem(bird, objective), 1e-6
        for point in random_points(problem):
            _, _, gradient, jacobian = evaluated(problem, point)
            for i, axis in enumerate(step * np.eye(6)):
                above, below = evaluated(problem, point + axis), evaluated(problem, point - axis)
                assert gradient[i] == pytest.approx((above[0] - below[0]) / (2 * step), abs=1e-8)
                slope = (above[1] - below[1]) / (2 * step)
                assert jacobian[:, i] == pytest.approx(slope, rel=1e-5, abs=1e-7)

    def test_position_and_phase_cost_nothing(self, ibis):
        for point in random_points(PairProblem(ibis)):
            gradient = evaluated(PairProblem(ibis), point)[2]
            assert list(gradient[[0, 1, 2, 5]]) == [0.0] * 4
            assert gradient[3] > 0.0

    def test_the_balances_are_linear_in_phase(self, ibis):
        problem = PairProblem(ibis)
        for point in random_points(problem):
            at = [evaluated(problem, np.array([*point[:5], mu]))[1] for mu in (0.0, 0.25, 0.5)]
            assert at[1] == pytest.approx((at[0] + at[2]) / 2, abs=1e-13)


class TestBounds:
    """As the paper lists them, with the far bounds that it does not state."""

    def test_of_the_paper_s_pair(self, ibis):
        bounds = dict(zip(VARIABLES, PairProblem(ibis).bounds.tolist(), strict=True))
        h, wavelength = ibis.amplitude_m / 0.6, ibis.wavelength_m / 0.6
        assert bounds["x"] == pytest.approx([0.0, 1.5 * wavelength])
        assert bounds["y"] == pytest.approx([0.0, 4.0])
        assert bounds["z"] == pytest.approx([-h, h])
        assert bounds["h"] == pytest.approx([0.25 * h, h])
        assert bounds["R"] == [0.3, 0.5]
        assert bounds["mu"] == [0.0, 0.5]

    def test_those_of_height_and_amplitude_follow_the_bird_ahead(self, ibis):
        bounds = flock_problem(ibis).bounds
        h = 0.7 * ibis.amplitude_m / ibis.semispan_m
        assert bounds[2] == pytest.approx([-h, h])
        assert bounds[3] == pytest.approx([0.25 * h, h])
        assert list(bounds[4]) == [0.3, 0.5]

    def test_that_of_amplitude_may_be_set_apart_from_the_bird_ahead(self, ibis):
        problem = PairProblem(ibis, "force", Stroke(0.7, 0.35), amplitude_limit_m=0.9)
        assert problem.bounds[3] * ibis.semispan_m == pytest.approx([0.225, 0.9])
        assert problem.bounds[2] * ibis.semispan_m == pytest.approx([-0.7, 0.7])

    def test_of_the_v_they_keep_the_follower_outboard_level_and_astern(self, ibis):
        problem = PairProblem(ibis)
        whole, v = problem.bounds, problem.v_bounds()
        assert list(v[:2, 0]) == [1.0, 1.0]
        assert v[2] * ibis.semispan_m == pytest.approx([-ibis.amplitude_m / 2, ibis.amplitude_m / 2])
        assert np.array_equal(v[3:], whole[3:]) and np.array_equal(v[:2, 1], whole[:2, 1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"objective": "speed"},
            "objective: expected one of aerodynamic_power, cost_of_transport, force, power, found 'speed'",
        ),
        ({"ahead": Stroke(1.3, 0.4)}, "amplitude_m: expected at most twice the semispan"),
        ({"ahead": Stroke(1.0, 0.8)}, "upstroke_span_ratio: expected a lone bird that makes thrust"),
        ({"amplitude_limit_m": float("nan")}, "amplitude_m: expected"),
        ({"amplitude_limit_m": 0.0}, "amplitude_m: expected"),
    ],
)
def test_what_is_out_of_range_is_named(ibis, arguments, message):
    with pytest.raises(ValueError, match=message) as refused:
        PairProblem(ibis, **arguments)
    assert "\n" not in str(refused.value)
