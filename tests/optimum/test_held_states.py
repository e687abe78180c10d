"""More than two held states behind a wake that ends: the pieces of phase, their lanes, bounds and proofs."""

import math

import numpy as np
import pytest
from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import (
    CORE2,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    HEIGHT,
    NODE,
    SPAN_FIXED,
    SPAN_FLEXED,
)
from upwash.aero.interaction import net_force, wake_force
from upwash.aero.lanes import core_edges
from upwash.aero.wake import WakeModel
from upwash.optimum import certify
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.compiled.steps_enclosure import enclose_steps
from upwash.optimum.pair import pair_problems, solve_pair
from upwash.optimum.proof import PROVED
from upwash.optimum.search import Search
from upwash.optimum.settings import SearchSettings

IBIS = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
MODELS = {
    "three": WakeModel(stroke_states=3),
    "four": WakeModel(stroke_states=4, span_nodes=4),
    "eight, thin": WakeModel(stroke_states=8, span_nodes=3, core_radius_ratio=0.03),
    "four, long": WakeModel(stroke_states=4, wavelengths=2),
    "four, stroke law": WakeModel(stroke_states=4, span_law="stroke"),
}
EACH_MODEL = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)


def force_at(problem, point):
    """Return the wake's lift and thrust at a point, in weights."""
    residual, edges = np.empty(2), core_edges(problem.lanes)
    felt, alone = problem.lanes, np.zeros_like(problem.lanes[:, :1])
    alone[:9], alone[CORE2] = problem.lanes[:9, :1], problem.lanes[CORE2, :1]
    evaluate(point, felt, edges, problem.constants, residual, np.empty(6), np.empty((2, 6)))
    own = np.empty(2)
    evaluate(point, alone, edges[:, :1], problem.constants, own, np.empty(6), np.empty((2, 6)))
    return residual - own


def random_points(problem, rng, count):
    return problem.bounds[:, 0] + rng.random((count, 6)) * (problem.bounds[:, 1] - problem.bounds[:, 0])


@EACH_MODEL
def test_each_piece_is_the_force_at_its_phases(model):
    rng = np.random.default_rng(1)
    for problem in pair_problems(IBIS, "force", model=model):
        for point in random_points(problem, rng, 4):
            plain = np.array(wake_force(IBIS, IBIS.stroke, problem.pose(point), model)) / IBIS.weight_n
            assert force_at(problem, point) == pytest.approx(plain, abs=1e-13)


def test_states_that_never_meet_in_a_piece_have_no_lanes():
    model = WakeModel(stroke_states=16, span_nodes=2)
    for problem in pair_problems(IBIS, "force", model=model):
        all_pairs = 16 * 2 * len(problem.wake().circulation)
        assert problem.lanes.shape[1] == pytest.approx(all_pairs * 2 / 16, rel=0.05)
        begins = problem.first_lanes
        heights = [set(problem.lanes[HEIGHT, begins[k] : begins[k + 1]]) for k in range(16)]
        assert all(len(one) == 1 for one in heights)
        assert problem.first_lanes[-1] == problem.lanes.shape[1]


def forms_over(problem, low, high):
    """Enclose the wake force over a box at both ends of the phase, as affine forms in the offsets."""
    forms = np.empty((3, 2, 2, 6))
    enclose_steps(
        low,
        high,
        0.5 * (high - low),
        problem.lanes,
        problem.first_lanes,
        problem.phase_span(),
        forms,
    )
    return forms


def special_point(problem, rng):
    """Return a box's point (x, y, z_up, z_down, R) with a node of some state at a ring's corner or filament."""
    lane = problem.lanes[:, rng.integers(problem.lanes.shape[1])]
    ratio, amplitude = rng.uniform(0.3, 0.5), rng.uniform(0.3, 1.7)
    core = problem.model.core_radius_ratio
    span = lane[SPAN_FIXED] + lane[SPAN_FLEXED] * ratio
    y = rng.choice([-1.0, 1.0, 0.3]) * lane[HALF_WIDTH] - lane[NODE] * span + rng.choice([0.0, core])
    z = lane[FIRST_Z] - lane[HEIGHT] * amplitude
    return np.array([lane[FIRST_X], y, z + 0.5 * amplitude, z - 0.5 * amplitude, ratio])


@EACH_MODEL
def test_the_wake_force_never_leaves_its_enclosure(model):
    rng, worst, tightest = np.random.default_rng(2), -math.inf, math.inf
    problems = pair_problems(IBIS, "force", model=model)
    for number in range(240):
        problem = problems[number % len(problems)]
        size = math.exp(rng.uniform(math.log(1e-12), 0.0))
        point = special_point(problem, rng)
        middle = np.append(point + (rng.random() < 0.7) * size * rng.normal(size=5) * [1, 1, 1, 1, 0.1], 0.0)
        half = np.append(size * rng.random(5) * [1.0, 1.0, 1.0, 1.0, 0.1] * (rng.random(5) < 0.8), 0.0)
        forms = forms_over(problem, middle - half, middle + half)
        tightest = min(tightest, float(np.max(forms[0, ..., 5])))
        offsets = half * np.concatenate([rng.choice([-1.0, 1.0], (6, 6)), rng.uniform(-1.0, 1.0, (4, 6))])
        for offset in offsets:
            x, y, up, down, ratio, _ = middle + offset
            for end in range(2):
                at = np.array([x, y, 0.5 * (up + down), up - down, ratio, end * problem.phase_span()])
                form = forms[0, end]
                centred = form[:, 0] + form[:, 1:5] @ offset[[0, 1, 2, 4]] + forms[1, end, :, 3] * offset[3]
                excess = np.abs(force_at(problem, at) - centred) - form[:, 5]
                worst = max(worst, float(np.max(excess)))
    assert worst <= 1e-12
    assert tightest < 1e-9


@EACH_MODEL
def test_no_proof_excludes_a_follower_that_can_fly(model):
    rng, tried = np.random.default_rng(3), 0
    for problem in pair_problems(IBIS, "force", model=model)[:3]:
        search = Search(problem, seed=4)
        search.explore(search.random_starts(problem.bounds, 20))
        for basin in search.basins[:4]:
            for width in (1e-6, 1e-3, 0.1):
                around = width * (1.0 + rng.random(6))
                box = np.clip(
                    np.stack([basin.point - around, basin.point + around], axis=1),
                    *problem.bounds.T[:, :, None],
                )
                proof = certify.certify(problem, box, basin.cost * 1.0005, 1e-4, 3000)
                assert not proof.is_closed and proof.lower_bound <= basin.cost + 1e-9
                tried += 1
    assert tried >= 12


@pytest.fixture(scope="module", params=["force", "power"])
def solved(request):
    model = WakeModel(stroke_states=4)
    return model, solve_pair(IBIS, request.param, model=model, search=SearchSettings(tolerance=1e-2))


class TestAPair:
    def test_is_proved(self, solved):
        _, solution = solved
        claims = solution.proof.claims
        assert (claims.v_region, claims.everywhere) == (PROVED, PROVED)

    def test_balances_and_stays_in_the_bounds_by_the_plain_statement(self, solved):
        model, solution = solved
        for one in solution.optima[:20]:
            lift, thrust = net_force(IBIS, IBIS.stroke, one.pose, model)
            assert lift == pytest.approx(IBIS.weight_n, rel=1e-9)
            assert thrust == pytest.approx(IBIS.drag_n, rel=1e-9)

    def test_names_each_optimum_once(self, solved):
        _, solution = solved
        poses = [one.pose for one in solution.optima]
        places = np.array([[*one.position_m, one.stroke.amplitude_m, one.phase] for one in poses])
        apart = np.abs(places[:, None] - places[None, :])
        apart[..., 4] = np.minimum(apart[..., 4], 1.0 - apart[..., 4])
        np.fill_diagonal(apart[..., 0], 1.0)
        assert np.min(np.max(apart, axis=2)) > 1e-5


@pytest.mark.parametrize(
    ("model", "line"),
    [
        (WakeModel(stroke_states=4, stroke_rule="gauss"), r"^stroke_rule: expected held \(.*'gauss'$"),
        (WakeModel(core="rosenhead-moore"), r"^core: expected rankine \(.*'rosenhead-moore'$"),
        (WakeModel(wavelengths=math.inf), r"^span_nodes: expected exact \(behind an endless wake .*found 2$"),
    ],
    ids=["gauss", "core", "points"],
)
def test_a_model_in_which_no_optimum_is_searched_is_refused_before_the_search(model, line):
    with pytest.raises(ValueError, match=line):
        pair_problems(IBIS, "force", model=model)
