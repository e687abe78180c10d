"""A flock improved as a whole: its problem's derivatives, and what each bird gives up or gains."""

import numpy as np
import pytest
from upwash.optimum.flock import solve_flock
from upwash.optimum.joint import improve_together
from upwash.optimum.joint_problem import JointProblem
from upwash.optimum.settings import FlockRules
from upwash.optimum.variables import SCALE


@pytest.fixture(scope="module")
def chain(ibis):
    """Four ibises, each at its own best."""
    return solve_flock(ibis, 4, "force")


@pytest.fixture(scope="module")
def joint(chain):
    """The same four, improved together."""
    return improve_together(chain)


class TestProblem:
    @pytest.fixture(params=["neighbour", "all-upstream"])
    def problem(self, ibis, request):
        return JointProblem(solve_flock(ibis, 4, "power", rules=FlockRules("vee", request.param)))

    def test_starts_at_the_chain(self, problem):
        found = problem.evaluate(problem.start)
        costs = [one.optimum.cost / one.optimum.cost_leader for one in problem.flock.placed[1:]]
        assert found.costs == pytest.approx(costs, rel=1e-12)
        assert np.abs(found.residual).max() < 1e-10
        for place, member in zip(problem.places(problem.start), problem.flock.placed, strict=True):
            found, known = place.pose, member.place.pose
            assert found.position_m == pytest.approx(known.position_m, abs=1e-12)
            assert vars(found.stroke) == pytest.approx(vars(known.stroke), abs=1e-12)
            assert (place.row, found.phase) == pytest.approx((member.place.row, known.phase), abs=1e-12)

    def test_respects_its_own_bounds_there(self, problem):
        assert np.all(problem.start >= problem.bounds[..., 0] - 1e-12)
        assert np.all(problem.start <= problem.bounds[..., 1] + 1e-12)
        assert np.all(problem.coupling @ (problem.start / SCALE).ravel() >= problem.least - 1e-12)

    def test_slopes_are_those_of_differences(self, problem):
        generator = np.random.default_rng(1)
        point = problem.start + 0.02 * generator.uniform(-1.0, 1.0, problem.start.shape) * SCALE
        sides = [np.where(one <= 0.0, 1.0, -1.0) for one in problem.distances(point)]
        every = [np.arange(len(one)) for one in sides]
        here, step = problem.evaluate(point, sides, every), 1e-5
        held = problem.bounds[..., 0] == problem.bounds[..., 1]
        for place in zip(*np.nonzero(~held), strict=True):
            there = []
            for sign in (1.0, -1.0):
                moved = point.copy()
                moved[place] += sign * step * SCALE[place[1]]
                there.append(problem.evaluate(moved, sides, every))
            column = 6 * place[0] + place[1]
            for name in ("residual", "distance"):
                difference = (getattr(there[0], name) - getattr(there[1], name)) / (2.0 * step)
                assert getattr(here, f"{name}_slopes")[:, column] == pytest.approx(
                    difference, rel=1e-5, abs=1e-6
                )
            difference = (there[0].costs.sum() - there[1].costs.sum()) / (2.0 * step)
            assert here.gradient[column] == pytest.approx(difference, rel=1e-6, abs=1e-8)


class TestImprovement:
    def test_the_flock_as_a_whole_pays_less(self, joint):
        assert joint.flock.total_cost() < joint.chain.total_cost()
        assert joint.gained == pytest.approx(
            (joint.chain.total_cost() - joint.flock.total_cost())
            / 4
            / joint.chain.placed[1].optimum.cost_leader
        )

    def test_the_second_bird_gives_up_something_for_those_behind(self, joint):
        assert joint.given_up[0] > 1e-4
        assert max(joint.given_up[1:]) < 0.0
        assert sum(joint.given_up) < -1e-4

    def test_it_is_little(self, joint):
        assert joint.gained < 2e-3

    def test_every_bird_balances_by_the_plain_statement(self, joint):
        assert joint.flock.worst_residual() <= 1e-9

    def test_amplitude_stays_within_that_of_the_bird_ahead(self, joint):
        amplitudes = [one.place.pose.stroke.amplitude_m for one in joint.flock.placed]
        assert np.all(np.diff(amplitudes) <= 1e-9)

    def test_it_ends_where_no_pattern_beside_it_is_better(self, joint):
        assert joint.stationarity < 1e-6
        assert improve_together(joint.flock).gained == pytest.approx(0.0, abs=1e-8)

    def test_the_birds_remain_in_formation(self, joint):
        for one in joint.flock.placed[1:]:
            optimum = one.optimum
            assert (optimum.placement, optimum.tier, optimum.station) == ("outboard", "level", "astern")

    def test_a_last_bird_alone_has_nobody_to_give_up_for(self, ibis):
        joint = improve_together(solve_flock(ibis, 2, "power"))
        assert joint.gained == pytest.approx(0.0, abs=1e-9)
        assert joint.stationarity < 1e-6

    def test_a_flock_that_ended_early_is_improved_as_far_as_it_goes(self, ibis):
        ended = solve_flock(ibis, 4, "force", rules=FlockRules("alternating", "all-upstream"))
        joint = improve_together(ended)
        assert len(joint.flock.members) == len(ended.placed) == 3
        assert joint.gained > 0.0
