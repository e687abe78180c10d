"""Behind a wake that ends and is felt on the whole span: core edges, local solves, bounds and proofs."""

import math
from dataclasses import replace

import numpy as np
import pytest
from upwash.aero.bird import Bird
from upwash.aero.compiled.cut_wake import AT_LEADER, HEIGHT, SPAN_FIXED, SPAN_FLEXED, cut_wake_force
from upwash.aero.compiled.exact_span import Core
from upwash.aero.interaction import net_force
from upwash.aero.wake import WakeModel
from upwash.optimum.certify import certify
from upwash.optimum.compiled import cut_boxes, cut_descent
from upwash.optimum.compiled.programme import new_balance
from upwash.optimum.means import CutSearch
from upwash.optimum.pair import pair_problems, solve_pair
from upwash.optimum.proof import OPEN, PROVED
from upwash.optimum.settings import SearchSettings
from upwash.optimum.sided_evidence import CUT, gather_sided_evidence
from upwash.optimum.spacing import Spacing
from upwash.optimum.verify import examine, refute_bound

IBIS = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
EXACT = WakeModel(span_nodes="exact")
MODELS = {
    "two held": EXACT,
    "five held, soft core, two wavelengths": replace(
        EXACT, stroke_states=5, core="rosenhead-moore", wavelengths=2
    ),
    "four followed": replace(EXACT, stroke_states=4, stroke_rule="gauss", span_law="stroke"),
    "two followed, soft core, long": replace(
        EXACT, stroke_states=2, stroke_rule="gauss", core="rosenhead-moore", wavelengths=6
    ),
}
EACH_MODEL = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
SIZES = 10.0 ** np.arange(-12.0, 1.0)


def problems_of(model):
    return pair_problems(IBIS, "power", model=model)


def force_at(problem, box_point):
    """Wake force at (X, y, z_up, z_down, R, t), as boxes have it."""
    x, y, up, down, ratio, t = box_point
    wake = problem.wake_felt
    point = np.array([x + wake.drift * t, y, 0.5 * (up + down), up - down, ratio, t])
    return np.array(cut_wake_force(point, wake, wake.runs.copy(), np.empty((2, 6))))


def awkward_place(problem, rng):
    """A box's point: anywhere, or where a wing meets a filament, its core or its end, also one that is cut."""
    wake, t = (
        problem.wake_felt,
        rng.choice([0.0, problem.phase_span(), rng.uniform(0.0, problem.phase_span())]),
    )
    part = rng.integers(wake.parts.shape[1])
    run = wake.runs[part][:, rng.integers(wake.runs.shape[2])]
    h, ratio = rng.uniform(0.3, 1.7), rng.uniform(0.3, 0.5)
    x, y, z = rng.uniform(0.0, 9.0) - wake.drift * t, rng.uniform(0.0, 3.0), rng.uniform(-1.0, 1.0)
    span = wake.parts[SPAN_FIXED, part] + wake.parts[SPAN_FLEXED, part] * ratio
    kind, core, height = rng.integers(4), problem.model.core_radius_ratio, wake.parts[HEIGHT, part]
    if kind in (1, 2):
        end, angle = rng.integers(2), rng.uniform(0.0, 2.0 * math.pi)
        away = core * rng.choice([0.0, 1.0, rng.random()])
        x, z = run[end] + away * math.cos(angle), run[2 + end] + away * math.sin(angle) - height * h
    if kind in (2, 3):
        y = (
            rng.choice([-1, 1]) * run[4]
            + rng.choice([-1, 1]) * span
            + core * rng.choice([0.0, 1.0, rng.random()])
        )
    return np.array([x, y, z + 0.5 * h, z - 0.5 * h, ratio, t])


def forms_over(problem, low, high, enclose=cut_boxes.enclose_cut_force):
    forms, by_phase, reach = np.empty((2, 2, 2, 6)), np.empty(2), np.empty(6)
    felt, span = problem.enclosure, problem.phase_span()
    enclose(low, high, 0.5 * (high - low), felt, span, felt.wake.runs.copy(), forms, by_phase, reach)
    return forms, by_phase


@np.errstate(all="ignore")  # compiled, a division by zero is infinite without a word
def escape(problems, seed, boxes, enclose=cut_boxes.enclose_cut_force):
    """By how much the force leaves its enclosure at worst, and the least radius."""
    rng, worst, tightest = np.random.default_rng(seed), -math.inf, math.inf
    for number in range(boxes):
        problem = problems[number % len(problems)]
        size, span = SIZES[number % SIZES.size], problem.phase_span()
        half = size * rng.random(6) * [1.0, 1.0, 1.0, 1.0, 0.1, 0.3 * span] * (rng.random(6) < 0.8)
        # Sometimes nothing but the phase has a range: the cuts alone move.
        half[:5] *= rng.random() < 0.8
        middle = awkward_place(problem, rng) + half * rng.uniform(-1.0, 1.0, 6)
        low, high = middle - half, middle + half
        low[5], high[5] = max(low[5], 0.0), min(high[5], span)
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        forms, by_phase = forms_over(problem, low, high, enclose)
        tightest = min(tightest, float(np.max(forms[0, ..., 5])))
        for _ in range(10):
            offset = half * (rng.choice([-1.0, 1.0], 6) if rng.random() < 0.5 else rng.uniform(-1.0, 1.0, 6))
            share = (middle[5] + offset[5]) / span
            centred, radius = np.zeros(2), np.zeros(2)
            for end, weight in ((0, 1.0 - share), (1, share)):
                form = forms[0, end]
                centred += weight * (form[:, 0] + form[:, 1:5] @ offset[[0, 1, 2, 4]])
                centred += weight * forms[1, end, :, 3] * offset[3]
                radius += weight * form[:, 5]
            left = np.abs(force_at(problem, middle + offset) - centred - by_phase * offset[5]) - radius
            worst = max(worst, float(np.max(left)))
    return worst, tightest


@EACH_MODEL
def test_the_force_never_leaves_its_enclosure(model):
    worst, tightest = escape(problems_of(model), seed=1, boxes=60 * SIZES.size)
    assert worst <= 0.0
    assert tightest < 1e-11


def contributed(p, e, d, core):
    """What one corner of a tip filament contributes, A of the closed form, and its slope by p."""
    r = e * e + d * d
    m = max(r, core**2)
    u, v = math.sqrt(p * p + r), math.sqrt(p * p + m)
    value = -math.asinh(p / math.sqrt(m)) + p * (u - v) / core**2
    return value, -1.0 / v + (u - v) / core**2 + p * p * (1.0 / u - 1.0 / v) / core**2


def test_what_a_sliding_cut_adds_never_leaves_its_bound():
    rng, worst, core = np.random.default_rng(6), -math.inf, 0.171
    for _ in range(2000):
        r, angle = core * 10.0 ** rng.uniform(-1.5, 1.5), rng.uniform(0.0, 2.0 * math.pi)
        e, d, p = r * math.cos(angle), r * math.sin(angle), rng.normal() * r
        wx, we, wz, slide = 10.0 ** rng.uniform(-3.0, 0.0) * max(r, 0.1 * core) * rng.random(4)
        # A run along x of no width has all four corners in one place.
        runs = np.array([[0.0, 9.0, 0.0, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0]]).T.copy()
        soft = Core(core**2, 0.0, core**-2)
        bound = 0.25 * cut_boxes.cut_radius(p, -d, e, e, wx, wz, we, slide, runs, 0, AT_LEADER, soft)[1]
        slope = contributed(p, e, d, core)[1]
        for _ in range(8):
            dp, de, dd, by = rng.choice([-1.0, 1.0], 4) * [wx, we, wz, slide]
            moved = p + dp, e + de, d + dd
            added = contributed(moved[0] + by, *moved[1:], core)[0] - contributed(*moved, core)[0]
            worst = max(worst, (abs(added - by * slope) - 1e-13) / bound)
    assert 0.5 < worst <= 1.0


def test_a_bound_that_forgets_that_cuts_move_is_noticed(monkeypatch):
    """All of it, as what their spanwise filaments add is the larger part."""
    problems, known = problems_of(MODELS["four followed"]), cut_boxes.station_radius
    monkeypatch.setattr(cut_boxes, "cut_radius", lambda *_: (0.0, 0.0))
    monkeypatch.setattr(
        cut_boxes, "station_radius", lambda *given: 0.0 if given[7].shape[1] == 2 else known(*given)
    )
    enclose = cut_boxes.enclose_cut_force.py_func
    assert escape(problems, seed=1, boxes=20 * SIZES.size, enclose=enclose)[0] > 0.0


@EACH_MODEL
def test_a_core_edge_is_where_the_slope_jumps_and_either_branch_continues_past_it(model):
    rng = np.random.default_rng(3)
    problem = problems_of(model)[-1]
    felt = problem.felt
    if model.core == "rosenhead-moore":
        assert cut_descent.count_edges(felt) == 0
        return
    for edge in rng.permutation(cut_descent.count_edges(felt))[:8]:
        point, normal = np.array([0.0, 0.9, 0.0, 1.1, 0.4, 0.3 * problem.phase_span()]), np.empty(6)
        station = felt.stations[:, felt.edges[edge]]
        at_x, at_z = station[0] + station[2] * point[5], station[1] + station[3] * point[5]
        angle, core = rng.uniform(0.0, 2.0 * math.pi), model.core_radius_ratio
        point[0] = at_x + core * math.cos(angle)
        point[2] = at_z + core * math.sin(angle) - station[8] * point[3]
        assert cut_descent.edge_distance(point, felt, edge, normal) == pytest.approx(0.0, abs=1e-12)
        step = 1e-7 * normal / np.linalg.norm(normal)
        slopes = []
        for side, to in ((1.0, point + step), (-1.0, point - step)):
            balances = []
            for at, seen in ((to, 0), (to, 1), (2.0 * point - to, 1)):
                balance, room = new_balance(), cut_descent.make_room(felt)
                near = np.array([edge]), np.array([side]), seen
                cut_descent.evaluate_cut(at, felt, problem.constants, room, *near, balance)
                balances.append(balance)
            # On its own side the branch is the force; beyond, it goes on smoothly.
            assert balances[1].residual == pytest.approx(balances[0].residual, abs=1e-13)
            assert balances[2].jacobian == pytest.approx(balances[1].jacobian, abs=1e-4)
            slopes.append(balances[0].jacobian)
        assert np.max(np.abs(slopes[0] - slopes[1])) > 1e-4


@pytest.mark.thorough
@EACH_MODEL
def test_no_proof_excludes_a_follower_that_can_fly(model):
    rng, tried = np.random.default_rng(4), 0
    for problem in problems_of(model)[:2]:
        search = CutSearch(problem, seed=5)
        search.explore(search.random_starts(problem.bounds, 15))
        for basin in search.basins[:3]:
            for width in (1e-6, 1e-3, 0.1):
                around = width * (1.0 + rng.random(6))
                box = np.stack([basin.point - around, basin.point + around], axis=1)
                box = np.clip(box, *problem.bounds.T[:, :, None])
                proof = certify(problem, box, basin.cost * 1.0005, 1e-4, 2000)
                assert not proof.is_closed and proof.lower_bound <= basin.cost + 1e-9
                tried += 1
    assert tried >= 9


@pytest.fixture(scope="module")
def solution():
    return solve_pair(IBIS, "power", model=EXACT, search=SearchSettings(tolerance=1e-2))


class TestAPair:
    def test_of_the_papers_states_is_proved(self, solution):
        claims = solution.proof.claims
        assert (claims.v_region, claims.everywhere) == (PROVED, PROVED)

    def test_flies_straight_behind_the_wakes_end_which_is_an_artefact_of_its_length(self, solution):
        best = solution.global_optimum
        assert best.saving_total == pytest.approx(0.165, abs=0.001)
        assert best.x_m / IBIS.wavelength_m == pytest.approx(1.03, abs=0.01)
        assert best.y_m == 0.0
        assert solution.v_optimum.saving_total == pytest.approx(0.093, abs=0.001)

    def test_balances_by_the_plain_statement(self, solution):
        for one in solution.optima:
            lift, thrust = net_force(IBIS, IBIS.stroke, one.pose, EXACT)
            assert lift == pytest.approx(IBIS.weight_n, rel=1e-9)
            assert thrust == pytest.approx(IBIS.drag_n, rel=1e-9)

    def test_is_examined_again_with_the_same_evidence(self, solution):
        problems = problems_of(EXACT)
        for one in solution.optima[:5]:
            again = examine(problems, one.pose)
            assert [each.core_edges for each in again] == [one.core_edges]
            assert all(each.stationarity < 1e-6 for each in again)

    @pytest.mark.thorough
    def test_a_bound_above_what_can_be_flown_is_refuted(self, solution):
        claimed = solution.v_optimum.cost * 1.01
        assert refute_bound(problems_of(EXACT), claimed, claimed, 1e-2, in_v=True) is not None


def test_what_is_open_says_so():
    model = replace(EXACT, stroke_states=2, stroke_rule="gauss")
    found = solve_pair(IBIS, "power", model=model, search=SearchSettings(starts=8, most_boxes=200))
    assert found.optima
    assert found.proof.claims.everywhere == OPEN
    assert found.proof.global_certified_gap > 1e-4
    # Once open, the other piece of phase is worth no work.
    assert found.proof.certificate_boxes <= 2 * 201


def test_followed_birds_reach_the_same_optimum_from_either_piece_of_phase():
    model = replace(EXACT, stroke_states=2, stroke_rule="gauss", core="rosenhead-moore")
    found = solve_pair(IBIS, "power", model=model, search=SearchSettings(starts=40, most_boxes=1))
    phases = {one.phase for one in found.optima}
    assert len(phases) > 2
    for one in found.optima[:5]:
        lift, thrust = net_force(IBIS, IBIS.stroke, one.pose, model)
        assert (lift, thrust) == pytest.approx((IBIS.weight_n, IBIS.drag_n), rel=1e-9)
    evidence = gather_sided_evidence(
        problem := problems_of(model)[0], CutSearch(problem).random_starts(problem.bounds, 1)[0], CUT
    )
    assert evidence.core_edges == ()


@pytest.mark.parametrize("rule", ["held", "gauss"])
def test_limits_of_the_place_are_kept_by_search_and_proof(rule):
    model = replace(EXACT, stroke_rule=rule, core="rosenhead-moore")
    near = Spacing(distance_min_m=5.0)
    problems = pair_problems(IBIS, "power", model=model, spacing=near)
    search = CutSearch(problems[0], seed=1)
    search.explore(search.random_starts(problems[0].bounds, 20))
    assert search.basins
    assert all(np.linalg.norm(basin.point[:3]) * 0.6 >= 5.0 * (1.0 - 1e-9) for basin in search.basins)
    # No box within the limit is looked at further: there the least cost of all is no bound.
    inside = problems[0].bounds.copy()
    inside[0, 1], inside[1, 1] = 2.0, 2.0
    assert certify(problems[0], inside, 2.0, 1e-2, 50).is_closed
    free = pair_problems(IBIS, "power", model=model)[0]
    assert not certify(free, inside, 2.0, 1e-2, 50).is_closed


def test_a_wall_of_the_place_in_reach_exerts_nothing(ibis):
    model = WakeModel(stroke_states=4, span_nodes="exact", wavelengths=2)
    problem = pair_problems(ibis, "force", model=model)[0]
    felt, balance, room = problem.felt, new_balance(), cut_descent.make_room(problem.felt)
    # Walls are numbered on after the edges.
    wall, side, point = np.array([felt.edges.size - 1]), np.array([1.0]), problem.bounds.mean(axis=1)
    seen = []
    for count in (0, 1):
        cost = cut_descent.evaluate_cut(point, felt, problem.constants, room, wall, side, count, balance)
        seen.append([cost, *balance.residual, *balance.jacobian.ravel()])
    assert seen[0] == seen[1]
