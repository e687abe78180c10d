"""The small quadratic programme: the minimiser, by its optimality conditions and by another solver."""

import numpy as np
import pytest
from scipy.optimize import minimize
from upwash.optimum.compiled.quadratic import MOST_INEQUALITIES, solve_quadratic

TOLERANCE = 1e-9


class Programme:
    """A random strictly convex programme with 0 feasible, some of its constraints active there."""

    def __init__(self, seed, condition=1e3, count=None, is_degenerate=False):
        rng = np.random.default_rng(seed)
        axes, _ = np.linalg.qr(rng.standard_normal((6, 6)))
        self.hessian = axes * np.geomspace(1.0, condition, 6) @ axes.T
        self.hessian = 0.5 * (self.hessian + self.hessian.T)
        self.linear = rng.standard_normal(6) * rng.choice([0.1, 1.0, 100.0])
        self.lower, self.upper = -rng.random(6), rng.random(6)
        self.count = int(rng.integers(0, MOST_INEQUALITIES + 1)) if count is None else count
        self.slopes = rng.standard_normal((MOST_INEQUALITIES, 6))
        self.levels = -0.3 * rng.random(MOST_INEQUALITIES)
        if is_degenerate:
            # Resting on bounds and edges from the start, one variable fixed, one edge told twice.
            self.lower[:2] = 0.0
            self.upper[1] = 0.0
            self.levels[::2] = 0.0
            self.slopes[1], self.levels[1] = self.slopes[0], self.levels[0]

    def solve(self):
        self.step, self.at_bound = np.zeros(6), np.zeros(6, dtype=np.int64)
        self.is_active = np.zeros(MOST_INEQUALITIES, dtype=np.bool_)
        self.multipliers = np.zeros(MOST_INEQUALITIES)
        return solve_quadratic(
            self.hessian,
            self.linear,
            self.lower,
            self.upper,
            self.slopes,
            self.levels,
            self.count,
            self.step,
            self.at_bound,
            self.is_active,
            self.multipliers,
            np.empty((40, 10)),
            np.empty((2, 10), np.int64),
        )

    def value(self, step):
        return self.linear @ step + 0.5 * step @ self.hessian @ step

    @property
    def scale(self):
        return 1.0 + np.max(np.abs(self.linear)) + np.max(np.abs(self.hessian))


def assert_optimal(programme):
    """Feasible, stationary, multipliers of the right sign, none where there is room: then it is the minimiser."""
    p, n = programme, programme.count
    room = p.slopes[:n] @ p.step - p.levels[:n]
    assert np.all(p.step >= p.lower) and np.all(p.step <= p.upper)
    limit = TOLERANCE * p.scale
    assert np.all(room >= -limit)
    multipliers = p.multipliers[:n]
    assert np.all(multipliers >= -limit)
    assert np.all(np.abs(room[p.is_active[:n]]) < limit)
    assert np.all(multipliers[~p.is_active[:n]] == 0.0)
    slope = p.linear + p.hessian @ p.step - multipliers @ p.slopes[:n]
    at_lower, at_upper = p.step == p.lower, p.step == p.upper
    assert np.all(np.abs(slope[~at_lower & ~at_upper]) < limit)
    assert np.all(slope[at_lower & ~at_upper] > -limit)
    assert np.all(slope[at_upper & ~at_lower] < limit)


@pytest.mark.parametrize("condition", [1.0, 1e3, 1e8])
def test_random_programmes_end_at_their_minimiser(condition):
    for seed in range(300):
        programme = Programme(seed, condition)
        assert programme.solve()
        assert_optimal(programme)


def test_degenerate_programmes_end_at_their_minimiser():
    for seed in range(300):
        programme = Programme(seed, is_degenerate=True)
        assert programme.solve()
        assert_optimal(programme)


def test_another_solver_ends_in_the_same_place():
    for seed in range(40):
        p = Programme(seed, condition=30.0)
        assert p.solve()
        room = {
            "type": "ineq",
            "fun": lambda step, p=p: p.slopes[: p.count] @ step - p.levels[: p.count],
            "jac": lambda step, p=p: p.slopes[: p.count],
        }
        other = minimize(
            p.value,
            np.zeros(6),
            jac=lambda step, p=p: p.linear + p.hessian @ step,
            method="SLSQP",
            bounds=list(zip(p.lower, p.upper, strict=True)),
            constraints=[room] if p.count else [],
            options={"ftol": 1e-14, "maxiter": 500},
        )
        assert p.value(p.step) <= other.fun + 1e-8 * p.scale
        assert p.step == pytest.approx(other.x, abs=1e-4)


def test_without_constraints_in_the_way_it_is_newton_s_step():
    programme = Programme(1, count=0)
    programme.lower, programme.upper = np.full(6, -1e6), np.full(6, 1e6)
    assert programme.solve()
    assert programme.step == pytest.approx(-np.linalg.solve(programme.hessian, programme.linear), rel=1e-9)
    assert not programme.at_bound.any()


def test_what_bounds_and_edges_hold_the_step_is_told():
    programme = Programme(0, count=1)
    programme.hessian, programme.linear = np.eye(6), np.array([-9.0, 9.0, -9.0, 0.0, 0.0, 0.0])
    programme.lower, programme.upper = np.full(6, -1.0), np.full(6, 2.0)
    # 9 along the third variable, of which the edge allows 0.5.
    programme.slopes[0], programme.levels[0] = [0.0, 0.0, -2.0, 0.0, 0.0, 0.0], -1.0
    assert programme.solve()
    assert programme.step == pytest.approx([2.0, -1.0, 0.5, 0.0, 0.0, 0.0])
    assert list(programme.at_bound) == [1, -1, 0, 0, 0, 0]
    assert programme.is_active[0] and programme.multipliers[0] == pytest.approx(8.5 / 2.0)


def test_a_programme_that_is_not_convex_is_refused():
    programme = Programme(0, count=0)
    programme.hessian = -np.eye(6)
    assert not programme.solve()


class Vertex(Programme):
    """Two edges that differ in the sign of one slope meet where that variable's bound makes them one."""

    def __init__(self, seed):
        super().__init__(seed, 1e6, count=3)
        rng = np.random.default_rng(seed)
        self.upper[3] = 0.0
        self.slopes[2] = self.slopes[0]
        self.slopes[2, 3] *= -1.0
        self.levels[[0, 2]] = -1e-15 * rng.random()
        # 0 is the minimiser: the slope is one of edges and bound with multipliers that are not negative.
        first, second, bound = 0.01 * rng.random(3)
        self.linear = first * self.slopes[0] + second * self.slopes[2] - bound * np.eye(6)[3]


def test_constraints_that_are_linearly_dependent_are_not_met_and_released_for_ever():
    for seed in range(1000):
        vertex = Vertex(seed)
        assert vertex.solve(), seed
        assert np.max(np.abs(vertex.step)) < 1e-8
        assert np.all(vertex.multipliers >= -1e-9)
