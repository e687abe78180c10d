"""A pair behind an endless wake: searched, proved, and recorded like any other."""

import math
from dataclasses import replace

import numpy as np
import pytest
from upwash import Bird, SearchSettings, WakeModel, load_species, solve_pair
from upwash.optimum.compiled.endless_edges import edge_distance, edge_force, edge_pull
from upwash.optimum.endless.evidence import gather_endless_evidence
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.proof import NOT_CLAIMED, PROVED

IBIS = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
LIMIT = WakeModel.named("limit")
TIP = replace(LIMIT, span_law="tip")


@pytest.fixture(scope="module")
def solved():
    """Solutions by objective and span law, each to a tolerance of its own."""
    return {
        (objective, law): solve_pair(
            IBIS, objective, model=replace(LIMIT, span_law=law), search=SearchSettings(tolerance=tolerance)
        )
        for objective, law, tolerance in (
            ("power", "stroke", 1e-4),
            ("power", "tip", 1e-4),
            ("force", "stroke", 1e-3),
        )
    }


@pytest.mark.parametrize(("law", "saving", "y"), [("stroke", 0.0406, 1.81), ("tip", 0.0441, 1.375)])
def test_least_power_is_a_v_and_proved_best(solved, law, saving, y):
    solution = solved["power", law]
    best = solution.global_optimum
    assert (solution.proof.claims.everywhere, solution.proof.claims.v_optimum) == (PROVED, PROVED)
    assert best.is_v_optimum
    assert best.saving_total == pytest.approx(saving, abs=5e-5)
    assert best.y_m / 0.6 == pytest.approx(y, abs=0.005)
    spatial_phase = best.x_m / IBIS.wavelength_m - best.phase
    assert abs(spatial_phase - round(spatial_phase)) < 0.06
    assert abs(best.z_m) < 0.02 * IBIS.amplitude_m


def test_least_force_is_best_on_the_wall_of_the_v(solved):
    proof = solved["force", "stroke"].proof
    assert proof.v_wall == "y_lower"
    assert (proof.claims.v_region, proof.claims.everywhere) == (PROVED, PROVED)
    # The small optima that the steps make in the V go away with finer steps, and are none.
    assert proof.claims.v_optimum == NOT_CLAIMED
    assert solved["force", "stroke"].v_optimum is None


def test_every_optimum_balances_by_the_plain_statement_and_is_stationary(solved):
    for solution in solved.values():
        assert solution.status == "solved"
        costs = [optimum.cost for optimum in solution.optima]
        assert costs == sorted(costs)
        for optimum in solution.optima:
            assert abs(optimum.residual_lift) < 1e-10 and abs(optimum.residual_thrust) < 1e-9
            assert optimum.stationarity < 1e-6


def test_where_phases_mirror_so_do_optima(solved):
    """F(Φ, y, z) = F(−Φ, y, −z): an optimum off the middle has its mirror image beside it."""
    optima = solved["force", "stroke"].optima
    mirrored = [one for one in optima[:6] if abs(one.z_m) > 1e-3]
    assert mirrored
    for one in mirrored:
        assert any(
            abs(one.z_m + other.z_m) < 1e-4 and abs(one.cost - other.cost) < 1e-7 * one.cost
            for other in optima
        )


def test_the_distance_asked_for_changes_the_phase_alone():
    few = SearchSettings(starts=8, most_boxes=1)
    near, far = (solve_pair(IBIS, "power", model=LIMIT, search=few, distance_m=d) for d in (1.0, 4.75))
    one, other = near.global_optimum, far.global_optimum
    assert (one.x_m, other.x_m) == (1.0, 4.75)
    assert other.phase == pytest.approx(one.phase, abs=1e-6)
    assert other.cost == pytest.approx(one.cost, rel=1e-9)
    abreast = solve_pair(IBIS, "power", model=LIMIT, search=few, distance_m=0.3)
    assert abreast.global_optimum.station == "abreast"
    assert abreast.v_optimum is None


@pytest.mark.thorough
def test_the_same_optima_are_found_from_any_starts():
    problem, found = EndlessProblem(IBIS, "power", model=TIP), []
    for seed in range(4):
        search = EndlessSearch(problem, seed)
        search.explore_places(12)
        found.append(search.basins[0])
    for basin in found[1:]:
        assert basin.cost == pytest.approx(found[0].cost, rel=1e-10)
        assert basin.point == pytest.approx(found[0].point, abs=1e-5)


@pytest.mark.thorough
@pytest.mark.parametrize("model", [LIMIT, TIP], ids=["stroke", "tip"])
def test_the_least_power_has_converged_in_the_steps_to_a_thousandth_of_the_saving(model):
    savings = []
    for steps in (32, 128):
        search = EndlessSearch(EndlessProblem(IBIS, "power", model=replace(model, stroke_states=steps)))
        search.explore_places(4)
        savings.append(1.0 - search.basins[0].cost)
    assert savings[0] == pytest.approx(savings[1], rel=2e-3)


def test_behind_an_endless_wake_the_span_is_exact():
    with pytest.raises(ValueError, match="span_nodes: expected exact"):
        solve_pair(IBIS, model=replace(LIMIT, span_nodes=5))
    with pytest.raises(ValueError, match="distance_m: expected none"):
        solve_pair(IBIS, distance_m=2.0)


@pytest.mark.thorough
def test_a_bird_that_sheds_nothing_on_its_upstroke_has_an_answer():
    bird = replace(IBIS, circulation_ratio=0.0)
    for model in (LIMIT, WakeModel()):
        solution = solve_pair(bird, "power", model=model, search=SearchSettings(starts=16, tolerance=1e-2))
        assert solution.status == "solved"
        assert solution.global_optimum.saving_total > 0.0


# Core edges of the spanwise filaments.


def edges_near(problem, rng):
    """Points on core edges, and the edges."""
    wake, stations = problem.wake_felt, problem.stations
    for _ in range(30):
        point = np.array([0.0, *rng.uniform(*problem.bounds[1:5].T), 0.0])
        edge = int(rng.integers(wake.steps.shape[1] * stations.shape[2]))
        step, station = divmod(edge, stations.shape[2])
        window = int(step >= wake.downstroke_steps)
        angle = rng.uniform(0.0, 2.0 * math.pi)
        point[0] = (
            stations[window, 0, station] + 0.171 * math.cos(angle) - wake.wavelength * wake.steps[0, step]
        )
        height = stations[window, 1, station] + 0.171 * math.sin(angle)
        point[2] = height - wake.steps[1, step] * point[3]
        yield point, edge


def test_a_branch_continued_past_a_core_edge_is_smooth_and_joins_the_force_there():
    problem, rng = EndlessProblem(IBIS, "power", model=TIP), np.random.default_rng(0)
    wake, stations, gradient = problem.wake_felt, problem.stations, np.empty(6)
    for point, edge in edges_near(problem, rng):
        assert edge_distance(point, wake, stations, edge, gradient) == pytest.approx(0.0, abs=1e-9)
        across = gradient / np.dot(gradient, gradient)
        for side in (1, -1):
            shares = []
            for s in (1e-3, 2e-3):
                force, jacobian = np.zeros(2), np.zeros((2, 6))
                edge_force(point - side * s * across, wake, stations, edge, side, force, jacobian)
                shares.append(force.copy())
                beyond, _ = np.zeros(2), np.zeros((2, 6))
                edge_force(point + side * s * across, wake, stations, edge, side, beyond, jacobian)
                assert np.all(beyond == 0.0)
            # It grows linearly from the edge on, as much as the pull says.
            pull = np.array(
                [
                    edge_pull(point, wake, stations, edge, nu, np.empty(2), np.empty((2, 6)))
                    for nu in np.eye(2)
                ]
            )
            assert shares[0] == pytest.approx(1e-3 * pull, rel=0.02, abs=1e-12)
            assert shares[1] == pytest.approx(2.0 * shares[0], rel=0.02, abs=1e-12)


def test_an_optimum_on_a_core_edge_is_stationary_on_either_side_of_it():
    """Its distance from the edge is a rounding error of either sign, and so is that of its mirror image."""
    starling = load_species("common-starling").bird()
    search = EndlessSearch(EndlessProblem(starling, "power", model=LIMIT))
    search.explore_places(8)
    best = search.basins[:2]
    assert best[0].point[2] == pytest.approx(-best[1].point[2], abs=1e-3)
    for basin in best:
        for moved in (0.0, 1e-14, -1e-14):
            point = basin.point + moved * np.array([1.0, 0.0, 1.0, 1.0, 0.0, 0.0])
            evidence = gather_endless_evidence(search.problem, point)
            assert evidence.core_edges
            assert evidence.stationarity < 1e-6
