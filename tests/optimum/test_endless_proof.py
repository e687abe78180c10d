"""The proof behind an endless wake: its bounds hold in boxes of every size, and it refuses to prove what is false.

The checks are functions of the code under test, so that the same checks can be shown to catch a weakened bound: the
mutants at the end are run by the interpreter.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path
from threading import Thread
from types import ModuleType

import numpy as np
import pytest
from upwash.aero.bird import Bird
from upwash.aero.compiled.endless import HEIGHT, SHIFT, SPAN_FIXED, SPAN_FLEXED, endless_force_jacobian
from upwash.aero.wake import WakeModel
from upwash.optimum.compiled import endless_boxes, endless_enclosure
from upwash.optimum.compiled.endless_descent import evaluate_endless, make_room
from upwash.optimum.compiled.programme import new_balance
from upwash.optimum.compiled.relaxation import Limits
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.endless.solve import certify_endless

IBIS = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
LIMIT = WakeModel.named("limit")
MODELS = {
    "limit": LIMIT,
    "tip law": replace(LIMIT, span_law="tip"),
    "held": replace(LIMIT, stroke_rule="held", stroke_states=9),
    "soft core": replace(LIMIT, core="rosenhead-moore"),
}
SIZES = 10.0 ** np.arange(-12.0, 1.0)


@pytest.fixture(scope="module", params=MODELS)
def problem(request):
    return EndlessProblem(IBIS, "power", model=MODELS[request.param])


def in_the_kernel(problem, box_point):
    """(Φ, y, z, h, R) of a point given by X and the heights of its wingtips."""
    x, y, up, down, ratio = box_point[:5]
    return np.array([x / problem.wavelength, y, 0.5 * (up + down), up - down, ratio])


def force_at(problem, box_point, wake=None):
    wake = wake or problem.wake_felt
    places, jacobian = np.empty((4, wake.steps.shape[1])), np.empty((2, 5))
    return np.array(endless_force_jacobian(in_the_kernel(problem, box_point), wake, places, jacobian))


def awkward_place(problem, rng):
    """A point in (X, y, z_up, z_down, R): anywhere, or where a step's wing meets a filament, its core or its end."""
    wake, wavelength = problem.wake_felt, problem.wavelength
    (_, _), y_range, z_range, h_range, r_range = problem.bounds[:5]
    x, y, z = rng.uniform(-0.25, 0.75) * wavelength, rng.uniform(*y_range), rng.uniform(*z_range)
    h, ratio = rng.uniform(*h_range), rng.uniform(*r_range)
    step = rng.integers(wake.steps.shape[1])
    window = int(step >= wake.downstroke_steps)
    run = wake.runs[window][:, rng.integers(wake.runs.shape[2])]
    span = wake.steps[SPAN_FIXED, step] + wake.steps[SPAN_FLEXED, step] * ratio
    kind, core = rng.integers(4), problem.model.core_radius_ratio
    at_x, at_z = run[0], run[2]
    if kind == 1:
        # A wing's end on a tip filament, at its core's edge or somewhere in it, also at the filament's end.
        y = abs(
            rng.choice([-1, 1]) * run[4]
            + rng.choice([-1, 1]) * span
            + core * rng.choice([0.0, 1.0, rng.random()])
        )
        share = rng.choice([0.0, 1.0, rng.random()])
        at_x, at_z = run[0] + share * (run[1] - run[0]), run[2] + share * (run[3] - run[2])
    elif kind == 2:
        angle = rng.uniform(0.0, 2.0 * math.pi)
        at_x, at_z = run[0] + core * math.cos(angle), run[2] + core * math.sin(angle)
    if kind in (1, 2):
        x, z = at_x - wavelength * wake.steps[SHIFT, step], at_z - wake.steps[HEIGHT, step] * h
    x = (x / wavelength + 0.25) % 1.0 * wavelength - 0.25 * wavelength
    return np.array([x, y, z + 0.5 * h, z - 0.5 * h, ratio])


def random_box(problem, rng, size):
    """Centre and half-widths of a box of some size, of random shape and often at an awkward place."""
    half = size * rng.random(5) * [1.0, 1.0, 1.0, 1.0, 0.1]
    shape = rng.random()
    if shape < 0.3:
        half *= 10.0 ** rng.uniform(-3.0, 0.0, 5)
    elif shape < 0.5:
        half *= rng.permutation([1.0, 0.0, 0.0, 0.0, 0.0])
    return awkward_place(problem, rng) + half * rng.uniform(-1.0, 1.0, 5), half


def enclosed(enclose, problem, middle, half):
    """Enclose lift and thrust over a box: value, slopes, radius."""
    places, jacobian = np.empty((4, problem.wake_felt.steps.shape[1])), np.empty((2, 5))
    forms = np.empty((2, 7))
    enclose(in_the_kernel(problem, middle), half, problem.enclosure, places, jacobian, forms)
    return forms


@np.errstate(all="ignore")  # compiled, a division by zero is infinite without a word
def escape_from_enclosure(code, problem, seed, boxes):
    """By how much the force, of near runs or of far ones, leaves its enclosure, at worst; not above 0 if it holds."""
    rng, worst = np.random.default_rng(seed), -math.inf
    near, far = problem.enclosure.near, problem.enclosure.far
    for k in range(boxes):
        middle, half = random_box(problem, rng, SIZES[k % SIZES.size])
        parts = [
            (near, enclosed(code.enclose_near_force, problem, middle, half)),
            (far, enclosed(code.enclose_far_force, problem, middle, half)),
        ]
        for _ in range(10):
            offset = half * (rng.choice([-1.0, 1.0], 5) if rng.random() < 0.5 else rng.uniform(-1.0, 1.0, 5))
            for wake, forms in parts:
                left = np.abs(force_at(problem, middle + offset, wake) - forms[:, 0] - forms[:, 1:6] @ offset)
                worst = max(worst, float(np.max(left - forms[:, 6])))
    return worst


def test_near_and_far_runs_are_the_wake(problem):
    rng = np.random.default_rng(0)
    for _ in range(20):
        place = awkward_place(problem, rng)
        parts = [force_at(problem, place, wake) for wake in (problem.enclosure.near, problem.enclosure.far)]
        assert sum(parts) == pytest.approx(force_at(problem, place), rel=1e-12, abs=1e-14)


def test_the_force_never_leaves_its_enclosure(problem):
    assert escape_from_enclosure(endless_enclosure, problem, seed=1, boxes=40 * SIZES.size) <= 0.0


@pytest.mark.parametrize("ratio", [0.5, 0.0])
def test_nor_behind_a_weaker_upstroke(ratio):
    weak = EndlessProblem(replace(IBIS, circulation_ratio=ratio), "power", model=LIMIT)
    assert escape_from_enclosure(endless_enclosure, weak, seed=2, boxes=30 * SIZES.size) <= 0.0


def test_an_enclosure_tightens_with_the_square_of_the_box(problem):
    middle, radii = np.array([2.0, 3.1, 1.0, 0.3, 0.4]), []
    for size in (0.03, 0.003):
        half = size * np.array([1.0, 1.0, 1.0, 1.0, 0.1])
        radii.append(enclosed(endless_enclosure.enclose_near_force, problem, middle, half)[:, 6])
    assert np.all(radii[1] < radii[0] / 30.0)


# Each filament by itself: in the whole force, bounds of hundreds of them hide what one lacks.

CORE = 0.171


def charge(p, e, d):
    """What one end of a tip filament contributes, A of the closed form, and its slopes by p, e and d."""
    r = e * e + d * d
    m = max(r, CORE**2)
    u, v = math.sqrt(p * p + r + 1e-300), math.sqrt(p * p + m)
    value = -math.asinh(p / math.sqrt(m)) + p * (u - v) / CORE**2
    by_p = -1.0 / v + (u - v) / CORE**2 + p * p * (1.0 / u - 1.0 / v) / CORE**2
    return value, np.array([by_p, p * e / (u * m), p * d / (u * m)])


@np.errstate(all="ignore")  # compiled, a division by zero is infinite without a word
def escape_of_a_tip_filament(code, seed, boxes):
    """By how much what one tip filament contributes leaves its bound, as a share of the bound; at worst."""
    rng, worst = np.random.default_rng(seed), -math.inf
    for k in range(boxes):
        length = 10.0 ** rng.uniform(-1.0, 2.0)
        r, angle = CORE * 10.0 ** rng.uniform(-2.0, 1.5), rng.uniform(0.0, 2.0 * math.pi)
        p = rng.choice([0.5, rng.random(), 1.0 + 3.0 * rng.random(), 0.0, 1.0]) * length
        e, d = r * math.cos(angle), r * math.sin(angle)
        size = 10.0 ** rng.uniform(-3.0, 0.0) * max(r, 0.1 * CORE)
        wp, we, wd = size * (rng.random(3) if k % 2 else rng.permutation([1.0, 0.0, 0.0]))
        bound = code._filament_radius(
            np.float64(e),
            we,
            max(abs(d) - wd, np.float64(0.0)),
            max(p - length - wp, -p - wp, np.float64(0.0)),
            max(abs(p) - wp, 0.0),
            max(abs(p - length) - wp, 0.0),
            length,
            wp,
            math.hypot(we, wd),
            CORE**2,
            0.0,
        )
        (a0, s0), (a1, s1) = charge(p, e, d), charge(p - length, e, d)
        for _ in range(8):
            dp, de, dd = offset = rng.choice([-1.0, 1.0], 3) * [wp, we, wd]
            moved = charge(p + dp, e + de, d + dd)[0] - charge(p + dp - length, e + de, d + dd)[0]
            left = abs(moved - (a0 - a1) - (s0 - s1) @ offset)
            noise = 1e-15 * (10.0 + (p * p + length * length) / CORE**2)
            worst = max(worst, (left - noise) / bound)
    return worst


def strips(x, z, e, column):
    """What spanwise filaments at a station contribute: the strips' distances, and the vortex over them."""
    _, _, wide, narrow, strong, weak, _, _ = column
    q = x * x + z * z
    size = strong * (math.hypot(math.sqrt(q), e + wide) - math.hypot(math.sqrt(q), e - wide))
    size -= weak * (math.hypot(math.sqrt(q), e + narrow) - math.hypot(math.sqrt(q), e - narrow))
    return np.array([z, x]) * size / max(q, CORE**2)


@np.errstate(all="ignore")  # compiled, a division by zero is infinite without a word
def escape_of_a_station(code, seed, boxes):
    """The same of the spanwise filaments that meet at one station, slopes being taken from differences."""
    rng, worst = np.random.default_rng(seed), -math.inf
    for k in range(boxes):
        wide = rng.uniform(0.3, 0.8)
        narrow = wide * rng.choice([rng.random(), 0.0])
        strong, weak = rng.choice([1.0, rng.random()]), rng.choice([1.0, rng.random()])
        weak = 0.0 if narrow == 0.0 else weak
        size = 2.0 * min(strong, weak) * (wide - narrow)
        size += 2.0 * abs(strong - weak) * (wide if strong > weak else narrow)
        column = np.array([0.0, 0.0, wide, narrow, strong, weak, size, narrow if strong == weak else 0.0])
        r, angle = CORE * rng.choice([1.0, 10.0 ** rng.uniform(-2.0, 1.5)]), rng.uniform(0.0, 2.0 * math.pi)
        x, z, e = r * math.cos(angle), r * math.sin(angle), rng.choice([wide, narrow, rng.uniform(0.0, 3.0)])
        width = 10.0 ** rng.uniform(-4.0, -0.5) * max(r, 0.1 * CORE)
        wx, wz, we = width * (rng.random(3) if k % 2 else rng.permutation([1.0, 0.0, 0.0]))
        # The other end is on the other side, or the two of them would see the strips alike.
        bound = 0.5 * code.station_radius(x, z, e, -e, wx, wz, we, column[:, None], CORE**2, 0.0)
        step, value = 1e-7 * width, strips(x, z, e, column)
        if abs(math.hypot(x, z) - CORE) < 3.0 * step:
            continue
        at = np.array([x, z, e])
        slopes = [
            (strips(*(at + step * axis), column) - strips(*(at - step * axis), column)) / (2.0 * step)
            for axis in np.eye(3)
        ]
        noise = 1e-15 * (1.0 + np.max(np.abs(value))) * width / step + 1e-13
        for _ in range(8):
            offset = rng.choice([-1.0, 1.0], 3) * [wx, wz, we]
            left = strips(*(at + offset), column) - value - offset @ np.array(slopes)
            worst = max(worst, (float(np.max(np.abs(left))) - noise) / bound)
    return worst


@np.errstate(all="ignore")  # compiled, a division by zero is infinite without a word
def escape_of_a_wing_aside(code, seed, boxes):
    """The same of a wing that is wholly beyond the strips, both of whose ends count."""
    rng, worst = np.random.default_rng(seed), -math.inf
    for k in range(boxes):
        wide = rng.uniform(0.3, 0.8)
        column = np.array([0.0, 0.0, wide, 0.0, 1.0, 0.0, 2.0 * wide, 0.0])
        r, angle = CORE * rng.choice([1.0, 10.0 ** rng.uniform(-2.0, 1.0)]), rng.uniform(0.0, 2.0 * math.pi)
        x, z, left = r * math.cos(angle), r * math.sin(angle), wide + 10.0 ** rng.uniform(-2.0, 0.5)
        right = left + rng.uniform(0.1, 2.0)
        width = 10.0 ** rng.uniform(-3.0, -0.5) * max(r, 0.1 * CORE)
        wx, wz, we = width * (rng.random(3) if k % 2 else rng.permutation([1.0, 0.0, 0.0]))
        bound = code.station_radius(x, z, right, left, wx, wz, we, column[:, None], CORE**2, 0.0)

        def wing(x, z, right, left, column=column):
            return strips(x, z, right, column) - strips(x, z, left, column)

        step, at = 1e-6 * width, np.array([x, z, right, left])
        if abs(math.hypot(x, z) - CORE) < 3.0 * step:
            continue
        slopes = [
            (wing(*(at + step * axis)) - wing(*(at - step * axis))) / (2.0 * step) for axis in np.eye(4)
        ]
        noise = 1e-14 * width / step + 1e-13
        for _ in range(8):
            offset = rng.choice([-1.0, 1.0], 4) * [wx, wz, we, we]
            gone = wing(*(at + offset)) - wing(*at) - offset @ np.array(slopes)
            worst = max(worst, (float(np.max(np.abs(gone))) - noise) / bound)
    return worst


def test_no_filament_leaves_its_bound():
    code = interpreted(endless_enclosure)
    assert 0.8 < escape_of_a_tip_filament(code, seed=3, boxes=3000) <= 1.0
    assert 0.7 < escape_of_a_station(code, seed=4, boxes=3000) <= 1.0
    assert 0.3 < escape_of_a_wing_aside(code, seed=5, boxes=3000) <= 1.0


# The proof.


@pytest.fixture(scope="module", params=["power", "force"])
def search(request):
    """A problem with basins found from a fixed set of starts: feasible points of known cost."""
    found = EndlessSearch(EndlessProblem(IBIS, request.param, model=LIMIT), seed=3)
    found.explore_places(10)
    return found


def evaluated(problem, point):
    balance, none = new_balance(), (np.empty(0, np.int64), np.empty(0), 0)
    room = make_room(problem.felt)
    cost = evaluate_endless(point.copy(), problem.felt, problem.constants, room, *none, balance)
    return cost, balance.residual, balance.jacobian


def feasible_points(search):
    """Balanced points of many costs: every basin, and points slid along the balances away from it."""
    problem, rng, found = search.problem, np.random.default_rng(11), []
    for basin in search.basins:
        for size in (0.0, 0.01, 0.05, 0.2):
            point = basin.point + size * rng.normal(size=6) * [1.0, 1.0, 1.0, 1.0, 0.2, 0.0]
            point[1:] = np.clip(point, problem.bounds[:, 0], problem.bounds[:, 1])[1:]
            for _ in range(30):
                _, residual, jacobian = evaluated(problem, point)
                free = (point > problem.bounds[:, 0]) & (point < problem.bounds[:, 1])
                point = point + np.linalg.lstsq(jacobian * free, -residual, rcond=None)[0]
                point[1:] = np.clip(point, problem.bounds[:, 0], problem.bounds[:, 1])[1:]
            cost, residual, _ = evaluated(problem, point)
            if np.max(np.abs(residual)) < 1e-12:
                found.append((point, cost))
    return found


def lost_tracers(code, search, seed, rounds):
    """How many feasible points a threshold above their cost removes, of those followed; and how many were."""
    rng, lost, followed = np.random.default_rng(seed), 0, 0
    problem = search.problem
    limits = Limits(*problem.bounds[2], *problem.bounds[3])
    for point, cost in feasible_points(search):
        x, y, z, h, ratio, _ = point
        where = np.array([x, y, z + 0.5 * h, z - 0.5 * h, ratio, 0.0])
        for k in range(rounds):
            half = (1.0, 0.2, 0.02, 1e-3, 1e-6, 1e-9)[k % 6] * rng.random(6) * [1.0, 1.0, 1.0, 1.0, 0.1, 0.0]
            share = rng.random(6)
            low, high = where - share * half, where + (1.0 - share) * half
            low[4], high[4] = max(low[4], problem.bounds[4, 0]), min(high[4], problem.bounds[4, 1])
            far = np.full((3, 7), np.inf)
            if k % 2:
                # As a box within a larger one, whose enclosure of the far runs it was given.
                middle, wide = 0.5 * (low + high)[:5] + 0.3 * half[:5], 2.0 * half[:5]
                far[:2] = enclosed(endless_enclosure.enclose_far_force, problem, middle, wide)
                far[2, :5] = middle
            state, bound = code.examine_endless(
                low,
                high,
                rng.normal(0.0, 2.0, 2),
                problem.enclosure,
                problem.constants,
                limits,
                cost + 1e-12,
                far,
                np.empty((12, 10)),
                np.empty((2, 2, 2, 6)),
                np.empty((4, problem.wake_felt.steps.shape[1])),
            )
            followed += 1
            kept = (
                state == endless_boxes.OPEN and np.all(where >= low - 1e-9) and np.all(where <= high + 1e-9)
            )
            lost += not (kept and bound <= cost + 1e-9)
    return lost, followed


def test_no_feasible_point_is_lost_below_a_threshold_above_its_cost(search):
    lost, followed = lost_tracers(endless_boxes, search, seed=5, rounds=30)
    assert followed > 100
    assert lost == 0


def test_a_false_claim_is_not_proved(search):
    best = search.basins[0].cost
    claim = certify_endless(search.problem, search.problem.bounds, best * 1.001, 1e-4, 30_000)
    assert not claim.is_closed
    assert claim.lower_bound <= best


def test_half_of_the_phases_stands_for_all_where_they_mirror():
    problem = EndlessProblem(IBIS, "power", model=LIMIT)
    half = problem.proof_bounds(problem.bounds)
    assert half[0] == pytest.approx([0.0, 0.5 * problem.wavelength])
    for model in (MODELS["tip law"], MODELS["held"]):
        other = EndlessProblem(IBIS, "power", model=model)
        assert np.ptp(other.proof_bounds(other.bounds)[0]) == pytest.approx(other.wavelength)


# Mutants: each weakens one bound.

ENCLOSURE_MUTANTS = {
    "curvature across a filament halved": ("ACROSS = 1.0887", "ACROSS = 0.54"),
    "curvature along a filament forgotten": ("per_u2 * wp * (2.0 * across + along * wp)", "0.0"),
    "core taken for smooth along the filament": (
        "(1.0 if is_out else 2.0), (2.0",
        "(0.4 if is_out else 0.8), (2.0",
    ),
    "charge of a far filament halved": ("far = charge * length", "far = 0.5 * charge * length"),
    "half of the filaments' steepness forgotten": ("steep = 4.0 * across", "steep = 0.5 * across"),
    "curvature of the cosines quartered": ("COSINE_CURVATURE = 2.0 /", "COSINE_CURVATURE = 0.2 /"),
    "vortex taken for straight": (
        "else 0.5 * bend * per_m",
        "else 0.1 * bend * per_m",
    ),
    "product of slopes forgotten": ("+ per_m * slope * aside * whole", ""),
    "curvature of the corners forgotten": ("+ 0.5 * root * curve * whole2", ""),
    "jump at the core's edge forgotten": ("straight += 2.0 * per_m", "straight += 0.0 * per_m"),
}
WHOLE_MUTANTS = {
    "far runs taken for straight": ("radius = enclosure.far_curvature", "radius = 0.0"),
    "flexion's reach aside forgotten": ("wy + steps[SPAN_FLEXED, k] * w_ratio", "0.0"),
    "heights of the tips mixed up": (
        "0.5 * jacobian[c, 2] - jacobian[c, 3]",
        "0.5 * jacobian[c, 2] + jacobian[c, 3]",
    ),
    "slope of the ratio forgotten": ("form[BY_RATIO] = jacobian[c, 4]", "form[BY_RATIO] = 0.0"),
}


def interpreted(module, replaced=None, **given):
    """A module's source run by the interpreter, with one piece replaced and names given anew."""
    source = Path(module.__file__).read_text(encoding="utf-8")
    if replaced:
        assert source.count(replaced[0]) >= 1, f"nothing to mutate: {replaced[0]!r}"
        source = source.replace(*replaced)
    plain = "def kernel(function=None, **_):\n    return function or (lambda function: function)"
    assert "from upwash.kernel import kernel" in source
    mutant = ModuleType(module.__name__ + "_interpreted")
    sys.modules[mutant.__name__] = mutant
    try:
        code = compile(source.replace("from upwash.kernel import kernel", plain), module.__file__, "exec")
        exec(code, mutant.__dict__)
    finally:
        del sys.modules[mutant.__name__]
    mutant.__dict__.update(given)
    return mutant


def test_a_proof_ends_where_a_coordinate_is_large_against_the_box():
    """Rounding of a coordinate of thousands of semispans is wider than the box that is left: it cannot shrink on."""
    bird = Bird(0.6, 1.0, 10.0, 1000.0, 1.2, 9.81, 1e-3, 0.4)
    problem = EndlessProblem(bird, "force", model=replace(LIMIT, stroke_states=4))
    box = problem.bounds.copy()
    box[0] = 7000.0
    claims = []
    proof = Thread(target=lambda: claims.append(certify_endless(problem, box, 2.0, 1e-4, 3000)), daemon=True)
    proof.start()
    proof.join(100.0)
    assert claims and claims[0].boxes == 3000


@pytest.mark.thorough
@pytest.mark.parametrize("name", ENCLOSURE_MUTANTS)
def test_a_weakened_bound_of_a_filament_is_caught(name):
    mutant = interpreted(endless_enclosure, ENCLOSURE_MUTANTS[name])
    assert (
        escape_of_a_tip_filament(mutant, seed=3, boxes=3000) > 1.0
        or escape_of_a_station(mutant, seed=4, boxes=3000) > 1.0
    )


@pytest.mark.parametrize("name", WHOLE_MUTANTS)
def test_a_weakened_sum_is_caught(name):
    few = EndlessProblem(IBIS, "power", model=replace(LIMIT, stroke_states=4))
    mutant = interpreted(endless_enclosure, WHOLE_MUTANTS[name])
    assert escape_from_enclosure(mutant, few, seed=6, boxes=10 * SIZES.size) > 0.0


@pytest.mark.parametrize(
    "mutation",
    [
        ("_RADIUS] = force[c, RADIUS]", "_RADIUS] = 0.0"),
        ("force[c, BY_DOWN]", "force[c, BY_UP]"),
        ("if bound > threshold:", "if bound > 0.97 * threshold:"),
        (
            "amplitude = max(low[2] - high[3], limits.least_amplitude - MARGIN)",
            "amplitude = high[2] - low[3]",
        ),
    ],
)
def test_a_weakened_proof_is_caught(mutation):
    search = EndlessSearch(EndlessProblem(IBIS, "force", model=replace(LIMIT, stroke_states=8)), seed=4)
    search.explore_places(6)
    search.basins = search.basins[:4]
    lost, _ = lost_tracers(interpreted(endless_boxes, mutation), search, seed=5, rounds=12)
    assert lost > 0
