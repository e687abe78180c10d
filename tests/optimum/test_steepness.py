"""How steeply the least cost rises off an optimum, against solving anew with the follower held beside it."""

import numpy as np
import pytest
from upwash import WakeModel, load_species, wake_force
from upwash.optimum import verify
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.evidence import gather_evidence
from upwash.optimum.pair import pair_problems, solve_pair
from upwash.optimum.search import Search
from upwash.optimum.settings import SearchSettings
from upwash.optimum.steepness import Held, Vicinity, steepness
from upwash.optimum.variables import SCALE

IBIS = load_species("northern-bald-ibis").bird()
FEW = SearchSettings(starts=40, tolerance=1e-2)
SIDES = {"x_m": ("ahead", "behind"), "y_m": ("inward", "outward"), "z_m": ("below", "above")}


def least_cost(search, point, axis, step):
    """Return the least cost near a point from which one variable is held a step off, all others being free."""
    held = point.copy()
    held[axis] += step
    bounds = search.problem.bounds.copy()
    bounds[axis] = held[axis]
    around = np.random.default_rng(0).uniform(-1.0, 1.0, (30, 6)) * SCALE * 3.0 * abs(step)
    found = search.descend(np.clip(np.vstack([held, held + around]), *bounds.T), bounds)
    return found[0].cost if found else np.inf


@pytest.fixture(scope="module", params=["force", "power"])
def solved(request):
    """The paper's pair: its search, and optima of many kinds with what is said of them."""
    (problem,) = pair_problems(IBIS, request.param)
    search = Search(problem)
    solution = solve_pair(IBIS, request.param, search=FEW)
    points = [verify.point_in(problem, optimum.pose) for optimum in solution.optima[:8]]
    found = [gather_evidence(problem, search.felt, point) for point in points]
    return search, [
        (point, steepness(one.vicinity, one.held, (0, 1, 2, 5)))
        for point, one in zip(points, found, strict=True)
    ]


class TestBehindAWakeThatEnds:
    def test_the_cost_rises_as_it_does_where_all_else_is_solved_anew(self, solved):
        search, optima = solved
        kinds = set()
        for point, rise in optima:
            cost = least_cost(search, point, 0, 0.0)
            for number, axis in enumerate((0, 1, 2, 5)):
                for side, sign in enumerate((-1.0, 1.0)):
                    slope = rise.slope[number, side] / SCALE[axis]
                    curvature = rise.curvature[number, side] / SCALE[axis] ** 2
                    if not np.isfinite(slope):
                        continue
                    kinds.add((bool(slope), number))
                    # Steps that stay in the valley however narrow it is; two of them tell what a third would.
                    step = 1e-4
                    if not slope:
                        step *= min(max(1.0, 0.1 / curvature), 10.0) / max(1.0, curvature / 200.0)
                    near, far = (
                        (least_cost(search, point, axis, sign * k * step) - cost) / (k * step) for k in (1, 2)
                    )
                    if slope:
                        assert 2.0 * near - far == pytest.approx(slope, rel=5e-3)
                    else:
                        told = 2.0 * (2.0 * near - far / 2.0) / step
                        assert told == pytest.approx(curvature, rel=2e-2, abs=1e-3)
        assert {(False, 0), (False, 1), (False, 2), (True, 3)} <= kinds

    def test_at_a_bound_it_cannot_be_passed(self, solved):
        search, optima = solved
        for point, rise in optima:
            for number, axis in enumerate((0, 1, 2, 5)):
                for side in (0, 1):
                    at_end = abs(point[axis] - search.problem.bounds[axis, side]) < 1e-9
                    assert np.isinf(rise.slope[number, side]) == at_end


@pytest.fixture(scope="module")
def best():
    """The V optimum of least power behind the paper's wake."""
    return solve_pair(IBIS, "power", search=FEW).v_optimum


@pytest.fixture(scope="module")
def best_in_limit():
    """The same behind an endless wake."""
    return solve_pair(IBIS, "power", model=WakeModel.named("limit"), search=FEW).v_optimum


class TestStated:
    def test_antiphase_costs_alike_to_both_sides_from_the_first_moment_on(self, best):
        assert best.phase == pytest.approx(0.5, abs=1e-9)
        assert best.slope_earlier == best.slope_later > 0.1
        assert best.curvature_earlier is best.curvature_later is None

    def test_units_are_metres_and_the_lone_birds_cost(self, best):
        (problem,) = pair_problems(IBIS, "power")
        search, point = Search(problem), verify.point_in(problem, best.pose)
        step = 1e-4 / IBIS.semispan_m
        risen = least_cost(search, point, 0, step) - best.cost / best.cost_leader
        assert 2.0 * risen / 1e-4**2 == pytest.approx(best.curvature_behind_per_m2, rel=0.05)

    @pytest.mark.parametrize("model", ["paper", "limit"])
    def test_restoring_is_the_sign_of_the_force_a_little_off_with_the_stroke_held(self, model):
        wake = WakeModel.named(model)
        optima = solve_pair(IBIS, "power", model=wake, search=FEW).optima[:6]
        for optimum in optima:
            pose, here = optimum.pose, wake_force(IBIS, IBIS.stroke, optimum.pose, wake)

            def slope(axis, side, force, pose=pose, here=here):
                off = 1e-5 * side
                moved = type(pose)(**(vars(pose) | {axis: getattr(pose, axis) + off}))
                return (wake_force(IBIS, IBIS.stroke, moved, wake)[force] - here[force]) / off

            assert optimum.restores_x == all(slope("x_m", side, 1) > 0.0 for side in (-1.0, 1.0))
            assert optimum.restores_z == all(slope("z_m", side, 0) < 0.0 for side in (-1.0, 1.0))


class TestBehindAnEndlessWake:
    def test_distance_costs_nothing_as_the_phase_follows(self, best_in_limit):
        assert best_in_limit.slope_ahead_per_m == best_in_limit.slope_behind_per_m == 0.0
        assert best_in_limit.curvature_ahead_per_m2 == best_in_limit.curvature_behind_per_m2 == 0.0

    def test_phase_and_place_cost_as_where_all_else_is_solved_anew(self, best_in_limit):
        (problem,) = pair_problems(IBIS, "power", model=WakeModel.named("limit"))
        search, point = EndlessSearch(problem), problem.point(best_in_limit.pose)
        cost = best_in_limit.cost / best_in_limit.cost_leader
        for axis, unit, names in (
            (1, 1.0 / IBIS.semispan_m, ("curvature_inward_per_m2", "curvature_outward_per_m2")),
            (2, 1.0 / IBIS.semispan_m, ("curvature_below_per_m2", "curvature_above_per_m2")),
        ):
            for sign, name in zip((-1.0, 1.0), names, strict=True):
                # The valley is smooth within the step of the wing that the optimum rides.
                risen = least_cost(search, point, axis, sign * 1e-4) - cost
                assert 2.0 * risen / 1e-8 * unit**2 == pytest.approx(getattr(best_in_limit, name), rel=5e-2)
        assert best_in_limit.curvature_earlier == best_in_limit.curvature_later > 1.0


def test_where_multipliers_are_not_unique_the_pieces_tell_the_same(solved):
    # Any optimum will do: its multipliers are only not asked.
    _, optima = solved
    search = solved[0]
    held_at_all = 0
    for point, rise in optima[:4]:
        found = gather_evidence(search.problem, search.felt, point)
        told = steepness(found.vicinity, found.held._replace(is_unique=False), (0, 1, 2, 5))
        assert told.slope == pytest.approx(rise.slope, rel=1e-2, abs=1e-9)
        held_at_all += np.count_nonzero(rise.slope[np.isfinite(rise.slope)])
    assert held_at_all >= 4


def test_an_axis_that_nothing_holds_but_flatness_costs_nothing():
    nothing = Vicinity(np.empty(0, np.int64), np.empty((0, 3)), None, None, None, None)
    held = Held(
        np.eye(3)[:2], np.zeros(2), np.eye(3)[2:], np.zeros((3, 3)), np.zeros((3, 2), bool), is_unique=True
    )
    rise = steepness(nothing, held, (2,))
    assert rise.slope.tolist() == rise.curvature.tolist() == [[0.0, 0.0]]
