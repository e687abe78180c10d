"""A local solve: balanced to rounding, pinned to core edges, fast near the end, and never in trouble."""

import numpy as np
import pytest
from upwash import Bird, load_species
from upwash.aero.lanes import core_edges
from upwash.optimum.compiled.descent import BALANCED, SOLVED, UNBALANCED
from upwash.optimum.compiled.edges import edge_distance
from upwash.optimum.compiled.pair_descent import solve_local
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.evidence import gather_evidence
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Search
from upwash.optimum.variables import SCALE

# Near the V optimum of the ibis for force: x, y, z, h in semispans, R, |κ − ½|.
V = np.array([3.03, 1.466, -0.1025, 1.243, 0.349, 0.0])


class Solver:
    """A problem and how one start ends."""

    def __init__(self, problem):
        self.problem, self.search = problem, Search(problem)

    def __call__(self, start):
        problem, search = self.problem, self.search
        self.end, self.multipliers = np.empty(6), np.empty(2)
        self.pins = np.empty(len(search.felt.representative))
        self.status, self.cost, self.steps = solve_local(
            np.asarray(start, dtype=float),
            search.felt,
            problem.constants,
            problem.bounds,
            self.end,
            self.multipliers,
            self.pins,
        )
        return self.status

    def imbalance(self):
        problem = self.problem
        edges = core_edges(problem.lanes)
        residual = np.empty(2)
        evaluate(self.end, problem.lanes, edges, problem.constants, residual, np.empty(6), np.empty((2, 6)))
        return np.sum(np.abs(residual))

    def imbalance_of_thrust(self):
        problem = self.problem
        edges = core_edges(problem.lanes)
        residual = np.empty(2)
        evaluate(self.end, problem.lanes, edges, problem.constants, residual, np.empty(6), np.empty((2, 6)))
        return abs(residual[1]) / problem.constants.drag

    def random_starts(self, count, seed=11):
        return Search(self.problem, seed).random_starts(self.problem.bounds, count)


@pytest.fixture(scope="module", params=["force", "power"])
def solver(ibis, request):
    return Solver(PairProblem(ibis, request.param))


@pytest.fixture(scope="module")
def v_solver(ibis):
    """The solver for force, and the V optimum that it ends in."""
    solver = Solver(PairProblem(ibis, "force"))
    assert solver(V) == SOLVED
    return solver, solver.end.copy(), solver.cost


def test_random_starts_end_within_the_bounds_and_balanced_to_rounding_or_say_that_they_are_not(solver):
    low, high = solver.problem.bounds.T
    solved = 0
    for start in solver.random_starts(100):
        is_solved = solver(start) == SOLVED
        assert is_solved == (solver.imbalance() <= BALANCED)
        assert np.all(solver.end >= low) and np.all(solver.end <= high)
        solved += is_solved
    assert solved >= 95


def test_the_v_optimum_lies_on_two_core_edges_to_rounding(v_solver):
    solver, end, _ = v_solver
    solver(V)
    pinned = np.flatnonzero(solver.pins)
    assert len(pinned) == 2
    for edge in pinned:
        lane, filament = solver.search.felt.representative[edge]
        distance = edge_distance(end, solver.problem.lanes, lane, filament, np.empty(6))
        # s = r²/r_c² − 1, with r_c = 0.171 b.
        assert abs(distance) < 1e-12


@pytest.mark.parametrize(("away", "steps"), [(1e-6, 4), (1e-3, 6), (1e-2, 10)])
def test_near_an_optimum_steps_are_of_second_order(v_solver, away, steps):
    solver, _, cost = v_solver
    rng = np.random.default_rng(0)
    for _ in range(20):
        assert solver(v_solver[1] + away * SCALE * rng.uniform(-1.0, 1.0, 6)) == SOLVED
        assert solver.steps <= steps
        assert solver.cost == pytest.approx(cost, rel=1e-11)


def test_a_solve_that_starts_from_where_another_ended_stays(solver):
    for start in solver.random_starts(40, seed=12):
        if solver(start) != SOLVED:
            continue
        end, cost = solver.end.copy(), solver.cost
        assert solver(end) == SOLVED
        assert solver.cost == pytest.approx(cost, rel=1e-10)
        assert np.max(np.abs(solver.end - end) / SCALE) < 1e-4


def test_a_start_outside_the_bounds_is_one_on_them(solver):
    low, high = solver.problem.bounds.T
    for start in solver.random_starts(5):
        outside = start + [20.0, -9.0, 5.0, 3.0, -0.6, 0.9]
        solver(outside)
        end = solver.end.copy()
        solver(np.clip(outside, low, high))
        assert np.array_equal(solver.end, end)


def test_the_same_start_ends_in_the_same_digits(solver):
    for start in solver.random_starts(5):
        kept = start.copy()
        solver(start)
        end, cost, pins = solver.end.copy(), solver.cost, solver.pins.copy()
        solver(start)
        assert np.array_equal(solver.end, end) and solver.cost == cost and np.array_equal(solver.pins, pins)
        assert np.array_equal(start, kept)


@pytest.mark.parametrize("species", ["dunlin", "great-white-pelican", "mute-swan", "northern-bald-ibis"])
@pytest.mark.parametrize("objective", ["force", "power"])
def test_whatever_counts_as_solved_is_stationary(species, objective):
    """Also where edges and bounds meet in one corner, and are no longer independent of one another."""
    solver = Solver(PairProblem(load_species(species).bird(), objective))
    solved = 0
    for start in solver.random_starts(150):
        if solver(start) == SOLVED:
            search = solver.search
            found = gather_evidence(solver.problem, search.felt, solver.end)
            assert found.stationarity < 1e-9
            solved += 1
    assert solved > 140


def test_where_nothing_balances_a_solve_says_so(ibis):
    # With a twentieth of the leader's amplitude a follower cannot make up for its drag, wherever it flies.
    solver = Solver(PairProblem(ibis, amplitude_limit_m=0.05 * ibis.amplitude_m))
    for start in solver.random_starts(20):
        assert solver(start) == UNBALANCED
        assert np.all(np.isfinite(solver.end)) and solver.imbalance() > 1e-3


@pytest.mark.parametrize("objective", ["force", "power"])
def test_thrust_balances_to_a_share_of_the_drag_however_small_that_is(objective):
    """A long wave and a small stroke: the drag is a ten-thousandth of the weight."""
    slow = Bird(
        mass_kg=0.6,
        semispan_m=1.0,
        speed_m_s=10.0,
        period_s=10.0,
        density_kg_m3=1.2,
        gravity_m_s2=9.81,
        amplitude_m=0.01,
        upstroke_span_ratio=0.4,
    )
    solver = Solver(PairProblem(slow, objective))
    ends = [solver.imbalance_of_thrust() for start in solver.random_starts(300) if solver(start) == SOLVED]
    assert ends and max(ends) <= 1e-10
