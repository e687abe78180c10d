"""What a follower keeps to: kept by starts, solves and proofs, and priced, in both models."""

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from upwash import WakeModel, load_species, solve_flock, solve_pair
from upwash.optimum import verify
from upwash.optimum.certify import certify
from upwash.optimum.compiled.walls import cut_by_walls, wall_value
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.endless.solve import certify_endless
from upwash.optimum.pair import pair_problems
from upwash.optimum.search import Search
from upwash.optimum.settings import FlockRules, SearchSettings
from upwash.optimum.spacing import (
    BEARING_MAX,
    DISTANCE_MIN,
    FREE,
    GAP_MIN,
    X_MIN,
    Spacing,
    moved_inside,
    wall_values,
)
from upwash.optimum.verify import examine

IBIS = load_species("northern-bald-ibis").bird()
B = IBIS.semispan_m
LIMIT = WakeModel.named("limit")
COARSE = SearchSettings(starts=40, tolerance=1e-3)

# Each is broken by the V optimum of least power that keeps to nothing.
PAPER = [
    Spacing(x_min_m=1.785),
    Spacing(wingtip_gap_min_m=-0.28),
    Spacing(distance_min_m=2.0),
    Spacing(bearing_max_deg=26.4),
]
ENDLESS = [
    (Spacing(wingtip_gap_min_m=-0.05), 1.2),
    (Spacing(distance_min_m=1.7), 1.2),
    (Spacing(bearing_max_deg=40.0), 1.2),
]


@cache
def solved(spacing=FREE, model=None, distance=None):
    """Return the optima of least power."""
    return solve_pair(IBIS, "power", spacing=spacing, model=model, distance_m=distance, search=COARSE)


def least_by_descents(problem, count=60):
    """Return the least cost that descents from seeded starts meet, the limits being kept by their ends alone."""
    search = (EndlessSearch if isinstance(problem, EndlessProblem) else Search)(problem, 1)
    return search.descend(search.random_starts(problem.bounds, count))


class TestKept:
    @pytest.mark.parametrize("spacing", PAPER, ids=lambda one: one.names[0])
    def test_by_every_optimum_which_is_one_of_the_limited_problem(self, spacing):
        solution = solved(spacing)
        (problem,) = pair_problems(IBIS, "power", spacing=spacing)
        rests = 0
        for optimum in solution.optima:
            told = spacing.told(optimum.x_m, optimum.y_m, optimum.z_m, B)
            assert all(keeps for _, keeps in told.values())
            ((value, _),) = told.values()
            limit = getattr(spacing, spacing.names[0])
            price = next(v for k, v in optimum.columns().items() if "_costs_per_" in k and v is not None)
            # A price is asked where the optimum rests on the limit, and there alone.
            is_on = math.isclose(value, limit, rel_tol=1e-7)
            assert price >= 0.0 and (price > 0.0) <= is_on
            rests += is_on
        assert solution.proof.claims.everywhere == "proved"
        free = solved()
        assert solution.v_optimum.cost > free.v_optimum.cost
        assert solution.global_optimum.cost >= free.global_optimum.cost * (1.0 - 1e-9)
        # No descent meets anything better than what is proved.
        for basin in least_by_descents(problem):
            assert basin.cost * problem.leader_cost >= solution.proof.global_lower_bound * (1.0 - 1e-9)
            assert np.all(wall_values(basin.point[None, :], problem.walls) > -1e-9)

    @pytest.mark.parametrize(("spacing", "distance"), ENDLESS, ids=lambda one: str(one))
    def test_behind_an_endless_wake_at_the_distance_asked_for(self, spacing, distance):
        best = solved(spacing, LIMIT, distance).v_optimum
        ((value, keeps),) = spacing.told(best.x_m, best.y_m, best.z_m, B).values()
        assert keeps and value == pytest.approx(getattr(spacing, spacing.names[0]), rel=1e-7)
        assert best.cost > solved(FREE, LIMIT, distance).v_optimum.cost * (1.0 + 1e-5)

    def test_by_each_bird_of_a_flock_of_the_one_that_it_follows(self):
        spacing = Spacing(wingtip_gap_min_m=-0.25)
        rules = FlockRules("alternating")
        flock = solve_flock(IBIS, 3, "power", rules=rules, spacing=spacing, search=COARSE)
        rows = flock.rows()[1:]
        assert len(rows) == 2 and rows[0]["y_m"] > 0.0 > rows[1]["y_m"]
        for row in rows:
            assert abs(row["y_m"]) >= 2.0 * B - 0.25 - 1e-9

    def test_a_limit_that_the_optimum_keeps_of_itself_changes_nothing(self):
        free = solved().v_optimum
        loose = Spacing(x_min_m=1.0, wingtip_gap_min_m=-0.5, distance_min_m=1.2, bearing_max_deg=60.0)
        best = solved(loose).v_optimum
        assert best.cost == pytest.approx(free.cost, rel=1e-9)
        assert [best.x_m, best.y_m, best.z_m] == pytest.approx([free.x_m, free.y_m, free.z_m], abs=1e-6)
        assert {v for k, v in best.columns().items() if "_costs_per_" in k} == {0.0}


class TestPrices:
    @pytest.mark.parametrize(
        ("spacing", "model", "distance"),
        [(one, None, None) for one in PAPER] + [(one, LIMIT, d) for one, d in ENDLESS],
        ids=lambda one: one.names[0] if isinstance(one, Spacing) else "",
    )
    def test_are_what_the_cost_rises_by_as_the_limit_is_made_tighter(self, spacing, model, distance):
        (name,) = spacing.names
        limit = getattr(spacing, name)
        solution = solved(spacing, model, distance)
        rests = [
            (optimum, price)
            for optimum in solution.optima[:12]
            for key, price in optimum.columns().items()
            if "_costs_per_" in key and price
        ]
        assert rests
        for optimum, price in rests[:2]:
            step = 1e-5 * abs(limit)
            costs = []
            for sign in (-1.0, 1.0):
                moved = replace(spacing, **{name: limit + sign * step})
                (problem,) = pair_problems(
                    IBIS, "power", model=model or WakeModel(), distance_m=distance, spacing=moved
                )
                search = (EndlessSearch if model else Search)(problem)
                point = verify.point_in(problem, optimum.pose)
                near = point + np.random.default_rng(0).uniform(-1.0, 1.0, (20, 6)) * 1e-4
                costs.append(search.descend(np.vstack([point, near]))[0].cost)
            tighter = -1.0 if name == BEARING_MAX else 1.0
            assert tighter * (costs[1] - costs[0]) / (2.0 * step) == pytest.approx(price, rel=0.02)


class TestWalls:
    @pytest.mark.parametrize("distance", [None, 1.2])
    def test_a_walls_value_is_the_distance_from_it_and_its_slopes_are_exact(self, distance):
        spacing = Spacing(distance_min_m=1.5, bearing_max_deg=35.0)
        names, walls = spacing.walls(B, distance)
        assert names == ((DISTANCE_MIN, BEARING_MAX) if distance is None else (DISTANCE_MIN,))
        random, gradient, other = np.random.default_rng(0), np.empty(6), np.empty(6)
        for point in random.uniform(0.1, 3.0, (50, 6)):
            x = point[0] if distance is None else distance / B
            place = x * B, point[1] * B, point[2] * B
            for wall, name in enumerate(names):
                value = wall_value(point, walls, wall, gradient)
                assert (value > 0.0) == spacing.told(*place, B)[name][1]
                assert wall_values(point[None, :], walls)[0, wall] == pytest.approx(value, abs=1e-12)
                for axis in range(3):
                    moved = point.copy()
                    moved[axis] += 1e-6
                    slope = (wall_value(moved, walls, wall, other) - value) / 1e-6
                    assert slope == pytest.approx(gradient[axis], abs=1e-5)

    @pytest.mark.parametrize("distance", [None, 1.2])
    def test_no_place_that_keeps_them_is_cut_from_a_box(self, distance):
        spacing = Spacing(distance_min_m=1.5, bearing_max_deg=35.0)
        _, walls = spacing.walls(B, distance)
        random, cut, cleared = np.random.default_rng(1), 0, 0
        for _ in range(4000):
            centre = random.uniform([0, 0, -1, -2, 0.3, 0], [5, 3, 2, 1, 0.5, 0.5])
            half = 10.0 ** random.uniform(-9, 0.3) * random.uniform(0.1, 1.0, 6)
            low, high = np.maximum(centre - half, [0, 0, -9, -9, 0, 0]), centre + half
            inside = low + random.random((60, 6)) * (high - low)
            points = np.column_stack([inside[:, :2], 0.5 * (inside[:, 2] + inside[:, 3]), inside[:, 3:]])
            keeps = np.all(wall_values(points, walls) >= 0.0, axis=1)
            old = low.copy(), high.copy()
            left = cut_by_walls(low, high, walls)
            assert left or not np.any(keeps)
            kept = np.all((inside >= low) & (inside <= high), axis=1)
            assert np.all(kept[keeps]) or not left
            cleared += not left
            cut += left and not (np.array_equal(low, old[0]) and np.array_equal(high, old[1]))
        assert cut > 50 and cleared > 300

    def test_starts_are_moved_to_where_they_keep_them(self):
        for distance in (None, 1.2):
            _, walls = Spacing(distance_min_m=1.5, bearing_max_deg=60.0).walls(B, distance)
            bounds = np.array([[0.0, 9.0], [0.0, 4.0], [-1.0, 1.0], [0.4, 1.6], [0.3, 0.5], [0.0, 0.5]])
            starts = bounds[:, 0] + np.random.default_rng(0).random((500, 6)) * np.ptp(bounds, axis=1)
            moved = moved_inside(starts, walls, bounds)
            assert np.any(wall_values(starts, walls) < 0.0)
            assert np.all(wall_values(moved, walls) > -1e-12)
            keeps = np.all(wall_values(starts, walls) >= 0.0, axis=1)
            assert np.array_equal(moved[keeps], starts[keeps])


class TestProof:
    """A better follower that keeps the limits keeps a proof from closing; one that does not has no say."""

    @pytest.mark.parametrize("spacing", PAPER[2:], ids=lambda one: one.names[0])
    def test_behind_a_wake_that_ends(self, spacing):
        (problem,) = pair_problems(IBIS, "power", spacing=spacing)
        solution = solved(spacing)
        free = solved()
        best, bounds = solution.v_optimum, problem.v_bounds()
        cost, unlimited = best.cost / problem.leader_cost, free.v_optimum.cost / problem.leader_cost
        assert unlimited < cost * (1.0 - 5e-3)
        assert certify(problem, bounds, cost, 1e-3, 400_000).is_closed
        # With a threshold above the best the box that holds it stays open, however small.
        dear = cost * 1.002
        point = verify.point_in(problem, best.pose)
        for half in (1e-2, 1e-6, 1e-9):
            around = np.clip(point[:, None] + half * np.array([-1.0, 1.0]), bounds[:, :1], bounds[:, 1:])
            assert not certify(problem, around, dear, 1e-3, 3000).is_closed
        # The better place beyond the limit, which the unlimited problem finds, is cleared at once.
        beyond = verify.point_in(problem, free.v_optimum.pose)
        around = beyond[:, None] + 1e-3 * np.array([-1.0, 1.0])
        around = np.clip(around, problem.bounds[:, :1], problem.bounds[:, 1:])
        cleared = certify(problem, around, np.inf, 1e-3, 3000)
        assert cleared.is_closed and cleared.boxes == 1

    def test_behind_an_endless_wake(self):
        spacing, distance = ENDLESS[1]
        (problem,) = pair_problems(IBIS, "power", model=LIMIT, distance_m=distance, spacing=spacing)
        best = solved(spacing, LIMIT, distance).v_optimum
        free = solved(FREE, LIMIT, distance).v_optimum
        cost = best.cost / problem.leader_cost
        for pose, closes in ((best.pose, False), (free.pose, True)):
            point = problem.point(pose)
            around = np.clip(
                point[:, None] + 1e-3 * np.array([-1.0, 1.0]), problem.bounds[:, :1], problem.bounds[:, 1:]
            )
            proof = certify_endless(problem, around, cost * 1.002, 1e-3, 2000)
            assert proof.is_closed == closes

    def test_a_search_that_a_proof_asks_is_not_misled_by_a_better_place_beyond(self):
        spacing = PAPER[2]
        (problem,) = pair_problems(IBIS, "power", spacing=spacing)
        solution = solved(spacing)
        v = solution.proof
        best = v.v_lower_bound * (1.0 + v.v_region_certified_gap)
        assert verify.refute_bound([problem], v.v_lower_bound, best, 1e-3, in_v=True) is None
        # A dearer claim is refuted by the optimum itself.
        refuted = verify.refute_bound([problem], best * 1.02, best * 1.03, 1e-3, in_v=True)
        assert refuted.cost == pytest.approx(best, rel=1e-2)
        (unlimited,) = pair_problems(IBIS, "power")
        assert verify.refute_bound([unlimited], v.v_lower_bound, best, 1e-3, in_v=True).cost < best


class TestRefused:
    @pytest.mark.parametrize(
        ("limits", "expected"),
        [
            ({X_MIN: -1.0}, "x_min_m: expected a positive"),
            ({BEARING_MAX: 120.0}, "bearing_max_deg: expected 0.1 to 90"),
            ({GAP_MIN: math.nan}, "wingtip_gap_min_m: expected a finite"),
            ({X_MIN: 50.0}, "x_min_m: expected less than"),
            ({GAP_MIN: 5.0}, "wingtip_gap_min_m: expected less than"),
            ({DISTANCE_MIN: 50.0}, "distance_min_m: expected less than"),
            ({GAP_MIN: 1.0, BEARING_MAX: 2.0}, "bearing_max_deg: expected more than"),
        ],
    )
    def test_what_leaves_no_place(self, limits, expected):
        with pytest.raises(ValueError, match=expected):
            solve_pair(IBIS, spacing=Spacing(**limits))

    def test_a_distance_asked_for_that_the_follower_does_not_keep(self):
        with pytest.raises(ValueError, match="x_min_m: expected at most the distance, 1.2 m"):
            solve_pair(IBIS, model=LIMIT, distance_m=1.2, spacing=Spacing(x_min_m=1.3))


def test_evidence_is_the_same_when_the_optimum_is_examined_anew():
    spacing = PAPER[3]
    best = solved(spacing).optima[0]
    (again,) = examine(pair_problems(IBIS, "power", spacing=spacing), best.pose)
    assert again.bearing_max_costs_per_deg == pytest.approx(best.bearing_max_costs_per_deg, rel=1e-6)
    assert again.active_bounds == best.active_bounds
