"""A single run of a general-purpose solver, as the paper searched: what it may and may not be trusted with."""

import numpy as np
import pytest
from upwash.optimum.problem import PairProblem
from upwash.paper.single_start import paper_start, solve_from, spread_starts


@pytest.fixture(scope="module")
def problem(ibis):
    return PairProblem(ibis, "force")


def as_point(problem, optimum):
    b = problem.bird.semispan_m
    lengths = optimum.x_m, optimum.y_m, optimum.z_m, optimum.amplitude_m
    return np.array([*(one / b for one in lengths), optimum.upstroke_span_ratio, optimum.phase])


def test_the_papers_start_is_the_leaders_own_place_and_stroke(ibis, problem):
    start = paper_start(problem)
    assert start == pytest.approx([0, 0, 0, ibis.amplitude_m / ibis.semispan_m, 0.4, 0.5])


def test_straight_behind_the_leader_it_never_turns_aside(problem):
    assert solve_from(problem, paper_start(problem)).point[1] == pytest.approx(0.0, abs=1e-9)


def test_it_is_not_below_what_is_proved_of_all(problem, ibis_force):
    ends = [solve_from(problem, start) for start in spread_starts(problem, 12, seed=3)]
    costs = [end.cost * problem.leader_cost for end in ends if end.is_balanced]
    assert len(costs) >= 6
    assert min(costs) >= ibis_force.proof.global_lower_bound * (1 - 1e-5)


def test_started_at_the_v_optimum_it_stays_about_there(problem, ibis_force):
    best = ibis_force.v_optimum
    end = solve_from(problem, as_point(problem, best))
    assert end.is_balanced
    assert end.cost * problem.leader_cost == pytest.approx(best.cost, rel=1e-4)


def test_ends_that_do_not_balance_are_told(ibis):
    """So little amplitude is allowed that no wake makes up for the thrust that is missing."""
    problem = PairProblem(ibis, "force", amplitude_limit_m=0.05)
    assert not solve_from(problem, paper_start(problem)).is_balanced


def test_spread_starts_fill_the_bounds_and_come_again(problem):
    starts = spread_starts(problem, 200, seed=0)
    low, high = problem.bounds[:, 0].copy(), problem.bounds[:, 1].copy()
    low[5], high[5] = 0.0, 1.0
    assert np.all((starts >= low) & (starts <= high))
    assert np.all(np.ptp(starts, axis=0) > 0.9 * (high - low))
    assert np.array_equal(starts, spread_starts(problem, 200, seed=0))
    assert not np.array_equal(starts, spread_starts(problem, 200, seed=1))
