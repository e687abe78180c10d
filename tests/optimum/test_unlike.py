"""Birds that are not alike: whose values the wake and the follower have, and that nothing changes where they are."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from upwash import (
    FlockRules,
    Pose,
    Stroke,
    WakeModel,
    evaluate,
    load_species,
    solve_flock,
    solve_pair,
    wake_force,
)
from upwash.errors import UpwashError
from upwash.optimum.certify import certify
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.solve import certify_endless
from upwash.optimum.problem import PairProblem
from upwash.optimum.proof import is_proved
from upwash.optimum.record import record
from upwash.optimum.search import Search
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import record_in

LIMIT = WakeModel.named("limit")
LOOSE = SearchSettings(tolerance=1e-2, starts=24)


def bird(mass_kg, semispan_m, period_s, half_angle_deg=40.0, speed_m_s=15.0):
    """A bird of a mass, in the air of all."""
    ibis = load_species("northern-bald-ibis").bird()
    return replace(
        ibis,
        mass_kg=mass_kg,
        semispan_m=semispan_m,
        period_s=period_s,
        speed_m_s=speed_m_s,
        amplitude_m=2.0 * semispan_m * float(np.sin(np.radians(half_angle_deg))),
    )


SMALL, LARGE = bird(0.08, 0.19, 0.09), bird(9.0, 1.15, 0.28)
PAIRS = [(SMALL, LARGE), (LARGE, SMALL)]
MODELS = [WakeModel(), LIMIT]


def problem_of(follower, leader, model, lock, **more):
    kind = EndlessProblem if model.is_endless else PairProblem
    steps = model.resolving(leader.wavelength_m / leader.semispan_m)
    return kind(follower, "power", model=steps, leader=leader, phase_lock=lock, **more)


def without_time(solution):
    return [{**row, "solve_time_s": 0.0} for row in solution.rows()]


@pytest.mark.parametrize("model", [WakeModel(), WakeModel(stroke_states=4)])
def test_a_leader_that_is_alike_changes_no_digit(ibis, model):
    search = SearchSettings(tolerance=1e-1, starts=12)
    alone = solve_pair(ibis, "power", model=model, search=search)
    beside = solve_pair(ibis, "power", model=model, search=search, leader=replace(ibis))
    assert without_time(alone) == without_time(beside)


def test_members_that_are_alike_change_no_digit(ibis):
    search = SearchSettings(tolerance=1e-1, starts=24)
    rules = FlockRules("vee", "all-upstream")
    alone = solve_flock(ibis, 3, "power", rules=rules, search=search)
    told = solve_flock(ibis, objective="power", rules=rules, search=search, members=[ibis, ibis])
    assert without_time(alone) == without_time(told)


@pytest.mark.parametrize("lock", [True, False])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("follower", "leader"), PAIRS)
def test_the_compiled_balances_are_those_that_are_stated(follower, leader, model, lock):
    problem = problem_of(follower, leader, model, lock)
    search, draw = Search(problem) if not model.is_endless else None, np.random.default_rng(1)
    for share in draw.uniform(0.1, 0.9, (8, 6)):
        point = problem.bounds[:, 0] + share * (problem.bounds[:, 1] - problem.bounds[:, 0])
        found = record_in(problem, problem.pose(point))
        lift, thrust = balances_of(problem, search, point)
        assert found.residual_lift == pytest.approx(lift, abs=1e-11)
        assert found.residual_thrust * follower.drag_n == pytest.approx(
            thrust * follower.weight_n, abs=1e-11 * follower.weight_n
        )


def balances_of(problem, search, point):
    """Lift and thrust in excess, in weights, by the compiled statement."""
    from upwash.aero.lanes import core_edges
    from upwash.optimum.compiled.endless_descent import evaluate_endless, make_room
    from upwash.optimum.compiled.problem import evaluate
    from upwash.optimum.compiled.programme import new_balance

    balance, constants = new_balance(), problem.constants
    if search is None:
        none = np.empty(0, np.int64), np.empty(0), 0
        evaluate_endless(point, problem.felt, constants, make_room(problem.felt), *none, balance)
    else:
        evaluate(point, problem.lanes, core_edges(problem.lanes), constants, *balance)
    return balance.residual


@pytest.mark.parametrize("model", MODELS)
def test_a_leader_twice_as_large_is_felt_as_a_bird_half_as_large_feels_it(ibis, model):
    # Lengths by two and speeds by one: what follows in the follower's own units is the same.
    stroke, place = Stroke(0.5, 0.4), Pose(1.8, 1.1, 0.1, Stroke(0.9, 0.35), 0.3)
    leader = replace(ibis, mass_kg=3.0, semispan_m=1.1, period_s=0.4, amplitude_m=1.2)
    force = np.array(wake_force(ibis, stroke, place, model, leader=leader))
    half = {"semispan_m": 0.5, "period_s": 0.5, "amplitude_m": 0.5, "mass_kg": 0.25}
    small, small_leader = (
        replace(one, **{name: share * getattr(one, name) for name, share in half.items()})
        for one in (ibis, leader)
    )
    near = Pose(0.9, 0.55, 0.05, Stroke(0.45, 0.35), 0.3)
    again = np.array(wake_force(small, Stroke(0.25, 0.4), near, model, leader=small_leader))
    assert 4.0 * again == pytest.approx(force, rel=1e-9)


def test_the_force_grows_with_either_birds_circulation(ibis):
    # With wing, beat and place as they are, weight changes circulation alone.
    place = Pose(1.8, 1.1, 0.1, Stroke(0.9, 0.35), 0.3)
    heavy = replace(ibis, mass_kg=2.0 * ibis.mass_kg)
    force = np.array(wake_force(ibis, ibis.stroke, place))
    assert np.array(wake_force(ibis, ibis.stroke, place, leader=heavy)) == pytest.approx(2.0 * force)
    assert np.array(wake_force(heavy, ibis.stroke, place, leader=ibis)) == pytest.approx(2.0 * force)


@pytest.mark.parametrize("model", [WakeModel(), LIMIT, replace(LIMIT, stroke_rule="held")])
def test_birds_that_keep_their_own_beat_feel_the_mean_over_all_phases(ibis, model):
    leader = replace(ibis, mass_kg=3.0, semispan_m=0.9, period_s=0.4)
    place = Pose(2.4, 1.5, -0.1, Stroke(0.9, 0.35), 0.0)
    found = wake_force(ibis, leader.stroke, place, model, leader=leader, phase_lock=False)
    phases = (np.arange(96) + 0.5) / 96
    locked = [
        wake_force(ibis, leader.stroke, replace(place, phase=phase), model, leader=leader) for phase in phases
    ]
    size = np.max(np.abs(locked), axis=0)
    assert np.all(np.abs(found - np.mean(locked, axis=0)) < 2e-3 * size)


def test_in_step_the_follower_beats_in_its_leaders_period(ibis):
    slow = replace(ibis, period_s=0.5)
    pose = Pose(2.0, 1.0, 0.0, Stroke(0.9, 0.35), 0.5)
    for lock, period in ((True, 0.5), (False, 0.25)):
        problem = PairProblem(ibis, "power", leader=slow, phase_lock=lock)
        found = record_in(problem, pose)
        own = replace(ibis, period_s=period).self_force_n(pose.stroke)
        assert (found.lift_self_n, found.thrust_self_n) == own
        # What it is measured by is the bird alone, in its own period.
        assert (found.drag_n, found.leader_power_total_w) == (ibis.drag_n, record_in_alone(ibis))
        assert (found.phase is None) == (found.spatial_phase is None) == (not lock)


def record_in_alone(ibis):
    return record(ibis, "power", None, None, WakeModel()).power_total_w


def test_birds_at_two_speeds_do_not_fly_together(ibis):
    with pytest.raises(ValueError, match=r"leader's speed_m_s: expected the follower's, 15, .* found 14"):
        solve_pair(ibis, leader=replace(ibis, speed_m_s=14.0))


@pytest.mark.thorough
@pytest.mark.parametrize(("follower", "leader"), PAIRS)
def test_a_bird_a_hundred_times_as_heavy_as_the_other(follower, leader):
    solution = solve_pair(
        follower,
        "power",
        leader=leader,
        phase_lock=False,
        model=LIMIT.resolving(leader.wavelength_m / leader.semispan_m),
        search=LOOSE,
    )
    best = solution.global_optimum
    assert max(abs(best.residual_lift), abs(best.residual_thrust)) < 1e-9
    assert is_proved(solution.proof.global_certified_gap, LOOSE.tolerance)
    # Little is to be had behind a small bird, and much behind a large one.
    assert (best.saving_total > 0.05) if follower is SMALL else (0.0 < best.saving_total < 0.005)


@pytest.mark.thorough
@pytest.mark.parametrize("lock", [True, False])
@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("follower", "leader"), PAIRS)
def test_every_kind_of_unlike_pair_balances_and_is_proved(follower, leader, model, lock):
    steps = model.resolving(leader.wavelength_m / leader.semispan_m)
    search = SearchSettings(tolerance=1e-2)
    solution = solve_pair(follower, "power", leader=leader, phase_lock=lock, model=steps, search=search)
    if not solution.optima:
        assert solution.status == "infeasible" and solution.proof.global_lower_bound == np.inf
        return
    for one in solution.optima:
        assert max(abs(one.residual_lift), abs(one.residual_thrust)) < 1e-9
    assert is_proved(solution.proof.global_certified_gap, search.tolerance)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize(("follower", "leader"), PAIRS)
def test_a_proof_does_not_close_above_what_is_reached(follower, leader, model):
    problem = problem_of(follower, leader, model, False)
    prove = certify_endless if model.is_endless else certify
    # With the threshold above the lone bird's cost there are followers that reach it.
    proof = prove(problem, problem.bounds, 1.2, 1e-3, 4000)
    assert not proof.is_closed


@pytest.mark.parametrize("lock", [True, False])
@pytest.mark.parametrize("model", MODELS)
def test_what_is_evaluated_behind_another_bird_balances_as_it_is_stated(model, lock):
    goose, phase = bird(2.0, 0.7, 0.24), 1.2 / LARGE.wavelength_m
    seen = pd.DataFrame({"x_m": [1.2], "y_m": [1.6], "z_m": [0.0], "phase": [phase]})
    told = evaluate(goose, seen, model=model, leader=LARGE, phase_lock=lock, finds_optimum=False).iloc[0]
    assert told["outcome"] in ("saves", "pays")
    pose = Pose(1.2, 1.6, 0.0, Stroke(told["amplitude_m"], told["upstroke_span_ratio"]), phase)
    found = record(goose, "power", LARGE.stroke, pose, model, leader=LARGE, phase_lock=lock)
    assert max(abs(found.residual_lift), abs(found.residual_thrust)) < 1e-9
    assert told["saving_total"] == pytest.approx(found.saving_total, abs=1e-12)
    assert np.isnan(told["phase"]) == (not lock)


def test_birds_that_follow_one_another_are_alike_in_a_table_of_all(ibis):
    seen = pd.DataFrame({"time": [0.0, 0.0], "bird": ["a", "b"], "x_m": [0.0, 1.2], "y_m": [0.0, 0.9]})
    with pytest.raises(UpwashError, match="--pairs: expected birds that are alike"):
        evaluate(ibis, seen, pairs=True, leader=LARGE)
