"""The search: starts, basins, and the evidence that tells an optimum from what only looks like one."""

from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from itertools import product

import numpy as np
import pytest
from scipy.optimize import minimize
from upwash.aero.compiled.lanes import PHASE
from upwash.aero.lanes import core_edges
from upwash.optimum.compiled.edges import edge_distance, edge_pull
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.evidence import gather_evidence
from upwash.optimum.problem import PairProblem
from upwash.optimum.record import labels
from upwash.optimum.search import (
    MOST_NEIGHBOURHOODS,
    NEAR_BEST,
    NEIGHBOURS,
    SAME_BASIN,
    Basin,
    Search,
    find_basin,
    merge_basins,
)
from upwash.optimum.variables import SCALE, TABLE, neighbourhood_of


@pytest.fixture(scope="module")
def search(ibis):
    """The ibis for force, with the basins of a fixed set of starts."""
    found = Search(PairProblem(ibis, "force"), seed=3)
    found.explore(found.random_starts(found.problem.bounds, 120))
    return found


def evidence(search, point):
    return gather_evidence(search.problem, search.felt, point)


def basin(cost, hits=1, **moved):
    """Return a basin at a common point but for what is moved, in units of SCALE."""
    point = np.array([3.0, 1.5, -0.1, 1.2, 0.35, 0.1])
    for index, by in moved.items():
        point[int(index[1:])] += by * SCALE[int(index[1:])]
    return Basin(point, cost, np.zeros(2), hits)


class TestStarts:
    def test_are_drawn_over_the_whole_box(self, search):
        low, high = search.problem.bounds.T
        starts = search.random_starts(search.problem.bounds, 500)
        fractions = (starts - low) / (high - low)
        assert np.all((fractions >= 0.0) & (fractions <= 1.0))
        assert np.mean(fractions, axis=0) == pytest.approx(np.full(6, 0.5), abs=0.06)

    def test_follow_from_the_seed(self, search):
        problem = search.problem
        one, again, other = (Search(problem, seed).random_starts(problem.bounds, 10) for seed in (7, 7, 8))
        assert np.array_equal(one, again) and not np.any(one == other)

    def test_are_as_many_in_each_kind_of_place(self, search, monkeypatch):
        problem, drawn = search.problem, []
        monkeypatch.setattr(Search, "explore", lambda _, starts: drawn.append(starts))
        Search(problem).explore_places(25)
        starts = np.concatenate(drawn)
        assert np.all((starts >= problem.bounds[:, 0]) & (starts <= problem.bounds[:, 1]))
        assert Counter(
            labels(problem.bird, problem.pose(start).position_m)[::2] for start in starts
        ) == dict.fromkeys(product(("outboard", "inboard"), ("astern", "abreast")), 25)

    def test_around_the_best_lie_within_the_bounds_and_around_each_of_them_once(self, search, monkeypatch):
        problem, drawn = search.problem, []
        around = Search(problem)
        around.basins = search.basins
        monkeypatch.setattr(Search, "explore", lambda _, starts: drawn.append(starts))
        around.explore_around_best()
        near = [one for one in search.basins if one.cost <= NEAR_BEST * search.basins[0].cost]
        assert 1 < len(near) < len(search.basins)
        groups = np.split(np.concatenate(drawn), len(near))
        for one, starts in zip(near, groups, strict=True):
            assert np.all((starts >= problem.bounds[:, 0]) & (starts <= problem.bounds[:, 1]))
            apart = np.abs(starts - one.point)[:, :PHASE] / neighbourhood_of(TABLE)[:PHASE]
            assert np.max(apart) <= 1.0 and np.all(np.max(apart, axis=0) > 0.5)
        around.explore_around_best()
        assert len(drawn) == 1

    def test_go_on_around_what_they_find_until_nothing_near_the_best_is_new(self, search):
        """Wherever they end: each basin near the best, also one that they found, was searched around."""
        problem = search.problem
        around = Search(problem, seed=5)
        around.basins = search.basins[-1:]
        dearest = around.basins[0].cost
        around.explore_around_best()
        near = [one for one in around.basins if one.cost <= NEAR_BEST * around.basins[0].cost]
        known = [find_basin(one, around.searched_around) is not None for one in near]
        assert all(known) or len(around.searched_around) == MOST_NEIGHBOURHOODS
        assert around.basins[0].cost <= dearest and around.starts == NEIGHBOURS * len(around.searched_around)


class TestBasins:
    def test_ends_that_are_one_optimum_are_merged_with_their_hits(self):
        merged = merge_basins([basin(1.0 + 1e-13, 2, v0=0.5 * SAME_BASIN), basin(1.0, 3)])
        assert [(one.cost, one.hits) for one in merged] == [(1.0, 5)]

    @pytest.mark.parametrize("variable", range(6))
    def test_optima_apart_in_one_variable_are_two(self, variable):
        merged = merge_basins([basin(1.0), basin(0.9, **{f"v{variable}": 2.0 * SAME_BASIN})])
        assert [one.cost for one in merged] == [0.9, 1.0]

    def test_phases_kappa_and_one_less_kappa_are_one_basin(self, search):
        # The phase coordinate is |κ − ½|: there is no other point to be told apart from.
        assert list(search.problem.bounds[5]) == [0.0, 0.5]
        assert {search.problem.phase(one.point[5]) <= 0.5 for one in search.basins} == {True}

    def test_each_start_hits_one_basin(self, search):
        assert search.starts == 120
        # A start may stall short of any optimum; few do.
        assert 0.95 * 120 <= sum(one.hits for one in search.basins) <= 120
        costs = [one.cost for one in search.basins]
        assert costs == sorted(costs) and len(costs) > 10

    def test_are_the_same_in_one_batch_in_many_and_in_threads(self, search):
        starts = search.random_starts(search.problem.bounds, 24)
        whole = search.descend(starts)
        parts = merge_basins([one for start in starts for one in search.descend(start[None, :])])
        with ThreadPoolExecutor(2) as pool:
            threads = merge_basins(sum(pool.map(search.descend, np.split(starts, 6)), []))
        for other in (parts, threads):
            assert [(one.cost, one.hits) for one in other] == [(one.cost, one.hits) for one in whole]
            assert all(np.array_equal(a.point, b.point) for a, b in zip(whole, other, strict=True))


class TestEvidence:
    """It trusts nothing of the solve that found a point."""

    def test_at_every_end_of_a_solve_the_generalised_gradient_is_0(self, search):
        for one in search.basins:
            found = evidence(search, one.point)
            assert found.stationarity <= 1e-8
            multipliers = [found.multiplier_lift, found.multiplier_thrust]
            assert len(found.core_edges) > 2 or multipliers == pytest.approx(one.multipliers, abs=1e-6)

    def test_a_point_moved_off_an_optimum_is_not_stationary(self, search):
        rng = np.random.default_rng(4)
        for one in search.basins[:8]:
            moved = one.point + 1e-4 * SCALE * rng.uniform(0.5, 1.0, 6) * rng.choice([-1, 1], 6)
            moved = np.clip(moved, *search.problem.bounds.T)
            assert evidence(search, moved).stationarity > 1e-6

    def test_an_edge_that_sheds_is_not_taken_for_one_that_holds(self, search):
        # On such an edge, held there by force, cost falls to both sides: a ridge.
        edges = range(len(search.felt.representative))
        point, pull = next(met for met in (ridge(search, edge) for edge in edges) if met is not None)
        assert pull > 0.0
        assert evidence(search, point).stationarity > 1e-6

    def test_straight_behind_the_leader_a_saddle_is_told_by_its_curvature(self, search):
        """By symmetry nothing slopes aside of the leader's track, so the bound y ≥ 0 holds nobody back."""
        on_track = [one for one in search.basins if one.point[1] == 0.0]
        assert on_track
        rng = np.random.default_rng(6)
        for one in on_track:
            found = evidence(search, one.point)
            aside = one.point + SCALE * [0.0, 1e-2, 0.0, 0.0, 0.0, 0.0]
            near = aside + 1e-4 * SCALE * rng.uniform(-1.0, 1.0, (4, 6))
            is_left = all(end.cost < one.cost - 1e-9 and end.point[1] > 0.0 for end in search.descend(near))
            assert is_left == (found.curvature is not None and found.curvature < 0.0)


def ridge(search, edge):
    """Return the best point that is kept on a core edge, and the edge's pull there; None if none is met."""
    problem = search.problem
    lane, filament = search.felt.representative[edge]
    core = core_edges(problem.lanes)
    residual, gradient, jacobian, normal = np.empty(2), np.empty(6), np.empty((2, 6)), np.empty(6)

    def fill(point):
        cost = evaluate(point, problem.lanes, core, problem.constants, residual, gradient, jacobian)
        return cost, edge_distance(point, problem.lanes, lane, filament, normal)

    def cost(point):
        return fill(point)[0], gradient.copy()

    def kept(point):
        distance = fill(point)[1]
        return np.append(residual, 0.05 * distance)

    def slopes(point):
        fill(point)
        return np.vstack([jacobian, 0.05 * normal])

    for start in Search(problem, edge).random_starts(problem.bounds, 4):
        end = minimize(
            cost,
            start,
            jac=True,
            method="SLSQP",
            bounds=problem.bounds,
            constraints={"type": "eq", "fun": kept, "jac": slopes},
            options={"ftol": 1e-12, "maxiter": 200},
        ).x
        end = np.clip(end, *problem.bounds.T)
        if np.max(np.abs(kept(end))) > 1e-9:
            continue
        found = evidence(search, end)
        multipliers = np.array([found.multiplier_lift, found.multiplier_thrust])
        pull = edge_pull(end, problem.lanes, search.felt.group, edge, multipliers)
        if edge in found.core_edges and pull > 1e-5:
            return end, pull
    return None
