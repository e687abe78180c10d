"""Superposed wakes: every bird ahead, each in its own phase, added up; and the pieces of phase that follow."""

import dataclasses

import numpy as np
import pytest
from upwash.aero.compiled.lanes import wake_force_jacobian
from upwash.aero.interaction import phase_weights, wake_force
from upwash.aero.lanes import core_edges, wake_lanes
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.flock import solve_flock
from upwash.optimum.flock_wake import Place, flock_problems, superposed_wake
from upwash.optimum.pieces import solve_pieces
from upwash.optimum.problem import PairProblem
from upwash.optimum.record import record
from upwash.optimum.settings import FlockRules, SearchSettings

FIRST = Place(0, Pose(0.0, 0.0, 0.0, Stroke(1.04, 0.4), 0.0))
SECOND = Place(1, Pose(1.8, 0.9, -0.1, Stroke(0.75, 0.35), 0.5))
THIRD = Place(2, Pose(3.5, 1.7, 0.2, Stroke(0.7, 0.36), 0.2))
FAR = 1e5


def problems(ibis, *ahead, wavelengths=1):
    return flock_problems(ibis, "force", ahead, 0.9, WakeModel(wavelengths=wavelengths))


def plain(ibis, one, last, point, phase):
    """The force of one bird's wake on a follower whose point and phase are relative to the last bird."""
    own = np.array(point[:3]) * ibis.semispan_m + last.pose.position_m - np.array(one.pose.position_m)
    stroke = Stroke(point[3] * ibis.semispan_m, point[4])
    pose = Pose(*own, stroke, phase + last.pose.phase - one.pose.phase)
    return np.array(wake_force(ibis, one.pose.stroke, pose))


def moved(place, **changes):
    """Return a bird's place with some of its pose changed."""
    return dataclasses.replace(place, pose=dataclasses.replace(place.pose, **changes))


def compiled(problem, point):
    """The force of a problem's lanes at a point, in N."""
    edges, jacobian = core_edges(problem.lanes), np.empty((2, 6))
    force = wake_force_jacobian(point, problem.lanes, edges, jacobian)
    return np.array(force) * problem.bird.weight_n


def stated_force(problem, pose):
    """The force of all wakes that is recorded of a pose, in N."""
    others = problem.others(pose)
    found = record(problem.bird, problem.objective, problem.ahead, pose, problem.model, others)
    return found.lift_wake_n, found.thrust_wake_n


@pytest.fixture
def points():
    """Points behind a bird: x, y, z, h, R."""
    generator = np.random.default_rng(3)
    low, high = np.array([1.0, 0.2, -0.8, 0.6, 0.3]), np.array([4.0, 2.5, 0.8, 1.5, 0.5])
    return low + generator.random((20, 5)) * (high - low)


class TestOneBirdAhead:
    def test_the_problem_is_the_pairs_to_the_last_digit(self, ibis):
        (one,) = problems(ibis, SECOND)
        pair = PairProblem(ibis, "force", SECOND.pose.stroke, 0.9)
        for name in ("lanes", "constants", "bounds"):
            assert np.array_equal(getattr(one, name), getattr(pair, name))
        assert one.phase(0.1) == pair.phase(0.1)

    def test_both_choices_of_wakes_build_the_same_pair(self, ibis):
        neighbour, upstream = (
            solve_flock(ibis, 2, rules=FlockRules(wake=wake)) for wake in ("neighbour", "all-upstream")
        )
        assert neighbour.members == upstream.members


class TestSuperposition:
    def test_forces_of_all_birds_ahead_add_up(self, ibis, points):
        for problem in problems(ibis, FIRST, SECOND, THIRD):
            for point in points:
                coordinate = 0.3 * problem.phase_span()
                phase = problem.phase(coordinate)
                expected = sum(plain(ibis, one, THIRD, point, phase) for one in (FIRST, SECOND, THIRD))
                assert compiled(problem, np.append(point, coordinate)) == pytest.approx(
                    expected, rel=1e-10, abs=1e-10
                )
                stated = stated_force(problem, problem.pose(np.append(point, coordinate)))
                assert stated == pytest.approx(expected, rel=1e-12, abs=1e-12)

    def test_is_linear_in_the_circulation_of_each_bird_ahead(self, ibis, points):
        wake = superposed_wake(ibis, (FIRST, SECOND), WakeModel())
        lags = [one.pose.phase - SECOND.pose.phase for one in (FIRST, SECOND)]
        weights = np.concatenate([phase_weights(0.6 - lag) for lag in lags])
        of_first = wake.state < 2

        def force(first, second, point):
            strengths = np.where(of_first, first, second) * wake.circulation
            scaled = dataclasses.replace(wake, circulation=strengths)
            lanes = wake_lanes(scaled, weights, np.zeros_like(weights), np.ones(2), 2, 2)
            edges, jacobian = core_edges(lanes), np.empty((2, 6))
            return np.array(wake_force_jacobian(np.append(point, 0.0), lanes, edges, jacobian))

        for point in points:
            each = force(1.0, 0.0, point), force(0.0, 1.0, point)
            assert force(3.0, -2.0, point) == pytest.approx(
                3.0 * each[0] - 2.0 * each[1], rel=1e-12, abs=1e-14
            )

    def test_a_bird_far_away_is_not_felt(self, ibis, points):
        far = moved(FIRST, x_m=-FAR, y_m=FAR, phase=0.5)
        (alone,), (both,) = problems(ibis, SECOND), problems(ibis, far, SECOND)
        for point in points:
            at = np.append(point, 0.2)
            assert compiled(both, at) == pytest.approx(compiled(alone, at), abs=1e-9)

    def test_the_mirrored_flock_lifts_its_mirrored_follower_alike(self, ibis):
        pose = Pose(1.7, 0.8, 0.1, Stroke(0.7, 0.35), 0.5)
        right = stated_force(problems(ibis, FIRST, SECOND)[0], pose)
        left = stated_force(problems(ibis, FIRST, SECOND.mirrored())[0], pose.mirrored())
        assert left == pytest.approx(right, rel=1e-12)


class TestLength:
    def test_each_further_wavelength_repeats_the_pattern(self, ibis):
        one, three = (superposed_wake(ibis, (FIRST,), WakeModel(wavelengths=n)) for n in (1, 3))
        wavelength = ibis.wavelength_m / ibis.semispan_m
        for repeat in range(3):
            part = slice(4 * repeat, 4 * repeat + 4)
            shifted = three.rings[part] - np.array([1, 1, 0, 0, 0, 0]) * repeat * wavelength
            assert shifted == pytest.approx(one.rings, abs=1e-12)
            assert np.array_equal(three.circulation[part], one.circulation)

    def test_a_longer_wake_acts_as_the_plain_statement_says(self, ibis, points):
        (problem,) = problems(ibis, FIRST, SECOND, wavelengths=2)
        for point in points:
            phase, b = problem.phase(0.1), ibis.semispan_m
            expected = np.zeros(2)
            for one in (FIRST, SECOND):
                for repeat in range(2):
                    moved = np.concatenate([[point[0] - repeat * ibis.wavelength_m / b], point[1:]])
                    expected += plain(ibis, one, SECOND, moved, phase)
            assert compiled(problem, np.append(point, 0.1)) == pytest.approx(expected, rel=1e-9, abs=1e-10)

    def test_of_one_neighbour_it_is_felt_too(self, ibis):
        flock = solve_flock(ibis, 2, model=WakeModel(wavelengths=2))
        assert flock.worst_residual() <= 1e-9
        assert flock.members[1].optimum.cost < solve_flock(ibis, 2).members[1].optimum.cost


class TestPiecesOfPhase:
    def test_one_piece_holds_all_phases_of_a_flock_in_antiphase(self, ibis):
        (problem,) = problems(ibis, FIRST, SECOND, moved(THIRD, phase=0.0))
        assert problem.is_symmetric
        assert [problem.phase(t) for t in (0.0, 0.2, 0.5)] == pytest.approx([0.5, 0.3, 0.0])

    def test_several_follow_one_another_around_the_wingbeat(self, ibis):
        pieces = problems(ibis, FIRST, SECOND, THIRD)
        # Relative to the third bird the others lag by −0.2 and 0.3, which kink at the same phases.
        assert [one.phase_start for one in pieces] == pytest.approx([0.0, 0.3, 0.5, 0.8])
        assert [one.phase_end for one in pieces] == pytest.approx([0.3, 0.5, 0.8, 1.0])

    def test_weights_are_linear_within_a_piece(self, ibis):
        ahead = FIRST, SECOND, THIRD, moved(THIRD, x_m=5.0, phase=0.93)
        for problem in problems(ibis, *ahead):
            start, slope = problem.phase_ramp()
            for share in (0.0, 0.2, 0.7, 1.0):
                coordinate = share * problem.phase_span()
                lags = [
                    problem.phase_start + coordinate + ahead[-1].pose.phase - one.pose.phase for one in ahead
                ]
                expected = np.concatenate([phase_weights(lag) for lag in lags])
                assert start + slope * coordinate == pytest.approx(expected, abs=1e-12)

    def test_a_problem_in_pieces_has_the_optimum_of_the_problem_in_one(self, ibis):
        far = moved(FIRST, x_m=-FAR, y_m=FAR, phase=0.37)
        near = moved(SECOND, stroke=Stroke(0.7458, 0.3493))
        pieces, (whole,) = problems(ibis, far, near), problems(ibis, near)
        assert len(pieces) == 4
        found = solve_pieces(pieces, SearchSettings(starts=30), proves_all=False)
        known = solve_pieces([whole], SearchSettings(starts=60), proves_all=False)
        assert found.proof.is_closed
        for name in ("x_m", "y_m", "z_m", "amplitude_m", "upstroke_span_ratio", "phase", "cost"):
            assert getattr(found.v_optimum, name) == pytest.approx(getattr(known.v_optimum, name), abs=1e-6)


@pytest.mark.thorough
@pytest.mark.parametrize("objective", ["force", "power"])
class TestAFlockInSuperposedWakes:
    def test_stays_in_antiphase_and_each_bird_gains_a_little(self, ibis, objective):
        neighbour, upstream = (
            solve_flock(ibis, 5, objective, rules=FlockRules(wake=wake))
            for wake in ("neighbour", "all-upstream")
        )
        assert upstream.worst_residual() <= 1e-9
        assert all(one.proof.is_closed for one in upstream.placed[1:])
        for one, other in zip(neighbour.placed[2:], upstream.placed[2:], strict=True):
            assert other.optimum.phase == pytest.approx(0.5, abs=1e-9)
            assert 0.0 < 1.0 - other.optimum.cost / one.optimum.cost < 0.01

    def test_a_vee_mirrors_itself(self, ibis, objective):
        vee = solve_flock(ibis, 5, objective, rules=FlockRules("vee", "all-upstream"))
        for right, left in ((1, 2), (3, 4)):
            assert vee.members[left].place == vee.members[right].place.mirrored()
            assert vee.members[left].optimum.cost == vee.members[right].optimum.cost
