"""The proof of an optimum: its bounds hold, it keeps every feasible point, and it refuses to prove what is false.

The checks are functions of the code under test, so that the same checks can be shown to catch a weakened bound: the
mutants at the end are run by the interpreter.
"""

import math
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import HEIGHT, wake_force_jacobian
from upwash.aero.lanes import core_edges
from upwash.optimum.certify import certify
from upwash.optimum.compiled import boxes, enclosure, relaxation
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.problem import PairProblem
from upwash.optimum.search import Search

IBIS = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
TOLERANCE = 1e-4
PHASE_END = 0.5


@pytest.fixture(scope="module", params=["force", "power"])
def search(request):
    """A problem with basins found from a fixed set of starts: feasible points of known cost."""
    found = Search(PairProblem(IBIS, request.param), seed=3)
    found.explore(found.random_starts(found.problem.bounds, 60))
    found.explore(found.random_starts(found.problem.v_bounds(), 30))
    return found


def random_box(problem, rng, widest):
    """A box in (x, y, z_up, z_down, R, t) of random shape, often across a core edge of the wake."""
    bounds = problem.bounds
    point = bounds[:, 0] + rng.random(6) * (bounds[:, 1] - bounds[:, 0])
    if rng.random() < 0.5:
        # Near a wingtip's passage of the leader's tip vortices and of the spanwise ones.
        point[0] = rng.choice([0.0, 0.5, 1.0]) * problem.wavelength + rng.normal(0.0, 0.3)
        point[1] = (
            math.pi / 4.0 * rng.choice([0.4, 1.0]) + rng.choice([-1.0, 0.4, 1.0]) + rng.normal(0.0, 0.2)
        )
    middle = np.array(
        [point[0], point[1], point[2] + 0.5 * point[3], point[2] - 0.5 * point[3], point[4], point[5]]
    )
    half = widest * rng.random(6) * np.array([0.5, 0.5, 0.5, 0.5, 0.05, 0.2])
    # Some boxes are wide in one of the variables that enter by a product.
    shape = rng.integers(0, 4)
    if shape > 1:
        half *= 0.05
        half[2 + shape] = rng.random() * (0.1 if shape == 2 else 0.2)
    half[5] = min(half[5], middle[5], PHASE_END - middle[5])
    return middle - half, middle + half


def samples_of(low, high, rng, count):
    """Corners and interior points of a box."""
    corners = rng.integers(0, 2, size=(count // 2, 6))
    inside = rng.random((count - count // 2, 6))
    return low + np.concatenate([corners, inside]) * (high - low)


def state_force(problem, tips, phase):
    """Wake force of one follower state at (x, y, z of the tips, R), from the kernel that the search uses."""
    lanes = tips["lanes"].copy()
    lanes[HEIGHT] = 0.0
    edges = core_edges(lanes)
    x, y, z, ratio = tips["at"]
    return np.array(
        wake_force_jacobian(np.array([x, y, z, 0.0, ratio, phase]), lanes, edges, np.empty((2, 6)))
    )


def forms_of(code, problem, low, high):
    """Enclose both follower states over a box."""
    half = problem.lanes.shape[1] // 2
    middle, widths = 0.5 * (low + high), 0.5 * (high - low)
    forms = np.empty((2, 2, 2, 6))
    for part in range(2):
        code.enclose_wake_force(
            *middle[[0, 1, 2 + part, 4]],
            *widths[[0, 1, 2 + part, 4]],
            problem.lanes,
            part * half,
            (part + 1) * half,
            part == 0,
            PHASE_END,
            forms[part],
        )
    return forms


def escape_from_enclosure(code, problem, seed, boxes):
    """By how much the wake force leaves its enclosure, at worst; not above 0 if the enclosure holds."""
    rng, worst = np.random.default_rng(seed), -math.inf
    half = problem.lanes.shape[1] // 2
    for k in range(boxes):
        low, high = random_box(problem, rng, (1.0, 0.3, 0.1, 0.03)[k % 4])
        forms, middle = forms_of(code, problem, low, high), 0.5 * (low + high)
        for point in samples_of(low, high, rng, 12):
            for part in range(2):
                tips = {
                    "lanes": problem.lanes[:, part * half : (part + 1) * half],
                    "at": point[[0, 1, 2 + part, 4]],
                }
                offset = (point - middle)[[0, 1, 2 + part, 4]]
                for end, phase in enumerate((0.0, PHASE_END)):
                    force = state_force(problem, tips, phase)
                    form = forms[part, end]
                    excess = np.abs(force - form[:, 0] - form[:, 1:5] @ offset) - form[:, 5]
                    worst = max(worst, float(np.max(excess)))
    return worst


def escape_of_a_factor(code, seed, boxes):
    """By how much the factors of a filament's form, and a product of forms, leave their enclosures, at worst."""
    rng, worst, core2 = np.random.default_rng(seed), -math.inf, 0.03
    for _ in range(boxes):
        # The difference of cosines, for a filament of any direction; a small box about a point at any angle.
        along = rng.normal(size=3)
        along /= np.linalg.norm(along)
        near, length, half = rng.normal(size=3), rng.choice([0.5, 300.0]), 0.1 * rng.random() * np.ones(3)
        far = near - length * along

        def corner(position, half=half, along=along):
            nearest = max(np.linalg.norm(np.maximum(np.abs(position) - half, 0.0)), 1e-9)
            return along @ position, *position, 1.0 / np.linalg.norm(position), 1.0 / nearest

        u, *slopes, radius, spread = code._enclose_strength(
            *corner(near), *corner(far), *along, *half, half @ half
        )
        for offset in rng.choice([-1.0, 1.0], size=(8, 3)) * half:
            true = along @ (near + offset) / np.linalg.norm(near + offset)
            true -= along @ (far + offset) / np.linalg.norm(far + offset)
            worst = max(worst, abs(true - u - np.array(slopes) @ offset) - radius, abs(true - u) - spread)
        # The plane vortex, within, without and across its core's edge, with a of one sign or of both.
        a, c, wa, wc = *rng.normal(0.0, 0.2, 2), *(0.2 * rng.random(2))
        low = max(abs(a) - wa, 0.0) ** 2 + max(abs(c) - wc, 0.0) ** 2
        high = (abs(a) + wa) ** 2 + (abs(c) + wc) ** 2
        k, by_a, by_c, k_radius = code._enclose_vortex(a, c, wa, wc, a * a + c * c, low, high, core2)
        for da, dc in rng.uniform(-1.0, 1.0, size=(16, 2)) * [wa, wc]:
            true = (a + da) / max((a + da) ** 2 + (c + dc) ** 2, core2)
            worst = max(worst, abs(true - k - by_a * da - by_c * dc) - k_radius)
        # A product of forms, at the ends of their ranges.
        first, second, width = rng.normal(size=4), rng.normal(size=4), 0.3 * rng.random(3)
        u_radius, k_radius = rng.random(2)
        spread = np.abs(first[1:]) @ width + u_radius
        product = code._multiply(*first, u_radius, spread, *second, k_radius, *width)
        for offset in rng.choice([-1.0, 1.0], size=(8, 3)) * width:
            for signs in ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)):
                true = (first[0] + first[1:] @ offset + signs[0] * u_radius) * (
                    second[0] + second[1:] @ offset + signs[1] * k_radius
                )
                worst = max(worst, abs(true - product[0] - np.array(product[1:4]) @ offset) - product[4])
    return worst


def as_point(box_point):
    """(x, y, z, h, R, t) of a point given by the heights of its wingtips."""
    x, y, up, down, ratio, phase = box_point
    return np.array([x, y, 0.5 * (up + down), up - down, ratio, phase])


def lagrangian(problem, box_point, nu):
    """Cost plus multiplied residuals at a point."""
    edges = core_edges(problem.lanes)
    residual = np.empty(2)
    cost = evaluate(
        as_point(box_point),
        problem.lanes,
        edges,
        problem.constants,
        residual,
        np.empty(6),
        np.empty((2, 6)),
    )
    return cost + nu @ residual


def excess_of_dual_bound(code, enclosing, problem, seed, boxes):
    """By how much the bound of the Lagrangian exceeds its values in the box, at worst; not above 0 if it holds."""
    rng, worst = np.random.default_rng(seed), -math.inf
    for k in range(boxes):
        low, high = random_box(problem, rng, (1.0, 0.3, 0.1, 0.03)[k % 4])
        forms = forms_of(enclosing, problem, low, high)
        relaxation = np.empty((3, 8))
        product = code.relax(low, high, 0.5 * (high - low), forms, problem.constants, PHASE_END, relaxation)
        for _ in range(3):
            nu = rng.normal(0.0, 2.0, 2)
            bound = code.dual_bound(relaxation, product, 0.5 * (high - low), nu[0], nu[1])
            values = [lagrangian(problem, point, nu) for point in samples_of(low, high, rng, 16)]
            worst = max(worst, bound - min(values))
    return worst


def feasible_points(search):
    """Balanced points of many costs: every basin, and points slid along the balances away from it."""
    problem, rng, found = search.problem, np.random.default_rng(11), []
    edges = core_edges(problem.lanes)
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    for basin in search.basins:
        for size in (0.0, 0.02, 0.1):
            point = basin.point + size * rng.normal(size=6) * np.array([1.0, 1.0, 1.0, 1.0, 0.2, 0.5])
            point = np.clip(point, problem.bounds[:, 0], problem.bounds[:, 1])
            for _ in range(25):
                cost = evaluate(point, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
                free = (point > problem.bounds[:, 0]) & (point < problem.bounds[:, 1])
                step = np.linalg.lstsq(jacobian * free, -residual, rcond=None)[0]
                point = np.clip(point + step, problem.bounds[:, 0], problem.bounds[:, 1])
            cost = evaluate(point, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
            if np.max(np.abs(residual)) < 1e-12:
                found.append((point, cost))
    return found


def lost_tracers(code, search, seed, rounds):
    """How many feasible points a threshold above their cost removes, of those followed; and how many were."""
    rng, lost, followed = np.random.default_rng(seed), 0, 0
    problem = search.problem
    limits = relaxation.Limits(*problem.bounds[2], *problem.bounds[3])
    for point, cost in feasible_points(search):
        x, y, z, h, ratio, phase = point
        where = np.array([x, y, z + 0.5 * h, z - 0.5 * h, ratio, phase])
        for k in range(rounds):
            half = (0.8, 0.2, 0.05, 0.01)[k % 4] * rng.random(6) * np.array([1.0, 1.0, 1.0, 1.0, 0.1, 0.5])
            share = rng.random(6)
            low, high = where - share * half, where + (1.0 - share) * half
            low[4:], high[4:] = (
                np.maximum(low[4:], problem.bounds[4:, 0]),
                np.minimum(high[4:], problem.bounds[4:, 1]),
            )
            state, bound = code.examine(
                low,
                high,
                rng.normal(0.0, 1.0, 2),
                problem.lanes,
                problem.first_lanes,
                problem.constants,
                PHASE_END,
                limits,
                cost,
                np.empty((8, 10)),
                np.empty((3, 2, 2, 6)),
            )
            followed += 1
            kept = state == boxes.OPEN and np.all(where >= low - 1e-9) and np.all(where <= high + 1e-9)
            lost += not (kept and bound <= cost + 1e-9)
    return lost, followed


def test_the_wake_force_never_leaves_its_enclosure(search):
    assert escape_from_enclosure(enclosure, search.problem, seed=1, boxes=200) <= 1e-12


def test_the_factors_of_a_filament_never_leave_their_enclosures():
    assert escape_of_a_factor(interpreted(enclosure), seed=7, boxes=300) <= 1e-12


def test_an_enclosure_tightens_with_the_square_of_the_box(search):
    """Away from edges the radius is of second order: a tenth of the box, a hundredth of the radius."""
    problem = search.problem
    middle = np.array([2.0, 2.6, 0.9, -0.2, 0.4, 0.25])
    radii = []
    for size in (0.1, 0.01):
        half = size * np.array([1.0, 1.0, 1.0, 1.0, 0.1, 0.0])
        radii.append(forms_of(enclosure, problem, middle - half, middle + half)[..., 5])
    assert np.all(radii[1] < radii[0] / 60.0)


def test_the_dual_bound_is_below_the_lagrangian(search):
    assert excess_of_dual_bound(relaxation, enclosure, search.problem, seed=2, boxes=150) <= 1e-11


def test_no_feasible_point_is_lost_below_a_threshold_above_its_cost(search):
    lost, followed = lost_tracers(boxes, search, seed=5, rounds=8)
    assert followed > 200
    assert lost == 0


def certify_incumbent(search, bounds, incumbent, *, budget, is_searching):
    return certify(
        search.problem,
        bounds,
        incumbent,
        TOLERANCE,
        budget,
        search.descend if is_searching else None,
    )


def test_a_false_claim_is_not_proved(search):
    """With a threshold above a known optimum the proof must not close, however long it tries."""
    best = search.basins[0].cost
    claim = certify_incumbent(search, search.problem.bounds, best * 1.001, budget=60_000, is_searching=False)
    assert not claim.is_closed
    assert claim.lower_bound <= best


def test_a_better_solution_is_met_on_the_way(search):
    """Told that nothing better than a poor optimum is known, the proof finds the best and closes below it."""
    poor = search.basins[-1].cost
    proof = certify_incumbent(search, search.problem.bounds, poor, budget=400_000, is_searching=True)
    assert proof.is_closed
    assert proof.found.cost <= search.basins[0].cost * (1.0 + 1e-9)
    assert proof.lower_bound == pytest.approx(proof.found.cost / (1.0 + TOLERANCE), rel=1e-12)


def test_a_spent_budget_is_reported_as_open(search):
    proof = certify_incumbent(
        search, search.problem.bounds, search.basins[0].cost, budget=100, is_searching=False
    )
    assert proof.boxes == 100
    assert not proof.is_closed
    assert proof.lower_bound < search.basins[0].cost / (1.0 + TOLERANCE)


def test_where_no_balance_is_possible_that_is_proved():
    """A leader whose span ratio lies outside the follower's bounds leaves far too little lift to a weak wake."""
    weak = Bird(0.05, 0.6, 25.0, 0.25, 1.29, 9.8, 1.0, 0.7)
    problem = PairProblem(weak, "force")
    proof = certify(problem, problem.bounds, math.inf, TOLERANCE)
    assert proof.is_closed
    assert proof.lower_bound == math.inf


# Mutants: each weakens one bound. The interpreter runs them, so only the checks above are at work.

ENCLOSURE_MUTANTS = {
    "curvature of the cosines halved": ("HALF_CURVATURE = 1.0 /", "HALF_CURVATURE = 0.5 /"),
    "remainder of the plane vortex halved": (
        "outer_radius = (wa * wa + wc * wc)",
        "outer_radius = 0.5 * (wa * wa + wc * wc)",
    ),
    "gap at the core edge forgotten": (
        "inner_only, outer_only = gap_share * without",
        "inner_only, outer_only = 0.0",
    ),
    "gap taken as one-sided where the sign changes": (
        "if abs(a) >= wa else 1.0",
        "if abs(a) >= 0.0 else 1.0",
    ),
    "gap on the wrong side": ("(inner + outer) * a - shift", "(inner + outer) * a + shift"),
    "product of ranges forgotten": ("+ u_range * k_range", ""),
    "factor's radius forgotten": ("+ abs(k) * u_radius +", "+"),
    "span's offset forgotten": ("span * radius + w_span * reach", "span * radius"),
    "right tip's radius forgotten": ("tlr + trr", "tlr"),
    "flexion's reach aside forgotten": ("wy + abs(node[i]) * w_span", "wy"),
}
CERTIFY_MUTANTS = {
    "slopes do not widen the bound": (
        "        total -= abs(slope) * widths[i]\n    total -= abs(nu_lift)",
        "        total -= 0.9 * abs(slope) * widths[i]\n    total -= abs(nu_lift)",
    ),
    "radii do not widen the bound": ("abs(nu_thrust) * relaxation[2, 7]\n    return", "0.0\n    return"),
    "phase's product forgotten": ("row[7] += w_share * (", "row[7] += 0.0 * ("),
    "thrust's product forgotten": (
        "product = abs(constants.thrust_ratio)",
        "product = 0.0 * abs(constants.thrust_ratio)",
    ),
    "rim cut too deep": ("kept = slack / abs(slope)", "kept = 0.7 * slack / abs(slope)"),
    "threshold undercut": ("if bound > threshold:", "if bound > 0.97 * threshold:"),
    "own cost overstated": (
        "amplitude = max(low[2] - high[3], limits.least_amplitude - MARGIN)",
        "amplitude = high[2] - low[3]",
    ),
    "tips coupled too tightly": ("low[3] + h_low, 2.0 * z_low", "low[3] + h_high, 2.0 * z_low"),
    "a combination of the balances taken to be nowhere zero": (
        "if abs(rate) > slope - rate:",
        "if abs(rate) > 0.8 * (slope - rate):",
    ),
}


def interpreted(module, replaced=None, **given):
    """A module's source run by the interpreter, with one piece replaced and names given anew."""
    source = Path(module.__file__).read_text(encoding="utf-8")
    if replaced:
        assert source.count(replaced[0]) >= 1, f"nothing to mutate: {replaced[0]!r}"
        source = source.replace(*replaced)
    plain = "def kernel(function=None, **_):\n    return function or (lambda function: function)"
    assert "from upwash.kernel import kernel" in source
    source = source.replace("from upwash.kernel import kernel", plain)
    mutant = ModuleType(module.__name__ + "_interpreted")
    # Dataclasses look their module up by name.
    sys.modules[mutant.__name__] = mutant
    try:
        exec(compile(source, module.__file__, "exec"), mutant.__dict__)
    finally:
        del sys.modules[mutant.__name__]
    mutant.__dict__.update(given)
    return mutant


def interpreted_proof(enclosing, replaced=None):
    """What bounds and examines boxes by an enclosure, run by the interpreter, with one piece replaced."""
    in_relaxation = replaced and replaced[0] in Path(relaxation.__file__).read_text(encoding="utf-8")
    bounds = interpreted(relaxation, replaced if in_relaxation else None)
    parts = {name: getattr(bounds, name) for name in ("ascend", "contract", "couple", "dual_bound", "relax")}
    parts["enclose_wake_force"] = enclosing.enclose_wake_force
    return interpreted(boxes, None if in_relaxation else replaced, **parts)


def is_caught(enclosing, certifying, search):
    """Whether any of the checks sees that a bound does not hold."""
    if escape_of_a_factor(enclosing, seed=7, boxes=300) > 1e-12:
        return True
    if escape_from_enclosure(enclosing, search.problem, seed=1, boxes=60) > 1e-12:
        return True
    if excess_of_dual_bound(certifying, enclosing, search.problem, seed=2, boxes=40) > 1e-11:
        return True
    return lost_tracers(certifying, search, seed=5, rounds=4)[0] > 0


@pytest.fixture(scope="module")
def small_search():
    """A problem with a handful of basins: the interpreter is slow."""
    found = Search(PairProblem(IBIS, "force"), seed=4)
    found.explore(found.random_starts(found.problem.v_bounds(), 20))
    found.basins = found.basins[:3]
    return found


def test_the_interpreted_original_passes_the_checks(small_search):
    enclosing = interpreted(enclosure)
    certifying = interpreted_proof(enclosing)
    assert not is_caught(enclosing, certifying, small_search)


@pytest.mark.parametrize("name", ENCLOSURE_MUTANTS)
def test_a_weakened_enclosure_is_caught(name, small_search):
    enclosing = interpreted(enclosure, ENCLOSURE_MUTANTS[name])
    certifying = interpreted_proof(enclosing)
    assert is_caught(enclosing, certifying, small_search)


@pytest.mark.parametrize("name", CERTIFY_MUTANTS)
def test_a_weakened_proof_is_caught(name, small_search):
    enclosing = interpreted(enclosure)
    certifying = interpreted_proof(enclosing, CERTIFY_MUTANTS[name])
    assert is_caught(enclosing, certifying, small_search)
