"""The proof in boxes of every size, down to a point, where the wake is least smooth: at corners, filaments, core edges.

A bound that is wrong in small boxes alone shows in no proof of a whole problem, and in none of the large boxes that
random places mostly are: it would show first in the one bird whose optimum happens to lie there.
"""

import math
from threading import Thread

import numpy as np
import pytest
from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import (
    CENTRE_Y,
    FIRST_X,
    FIRST_Z,
    HALF_WIDTH,
    HEIGHT,
    LAST_X,
    LAST_Z,
    NODE,
    SPAN_FLEXED,
    wake_force_jacobian,
)
from upwash.aero.lanes import core_edges
from upwash.aero.wake import WakeModel
from upwash.optimum.certify import certify
from upwash.optimum.compiled import enclosure
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.problem import PairProblem

PHASE_END = 0.5
BIRDS = {
    "light": Bird(0.3, 0.6, 15.0, 0.25, 1.29, 9.8, 0.5, 0.4),
    "ibis": Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4),
    "heavy": Bird(5.0, 0.6, 15.0, 0.25, 1.29, 9.8, 0.9, 0.35),
}
CORES = (0.03, 0.171, 0.4)
PROBLEMS = [
    pytest.param(PairProblem(bird, model=WakeModel(core_radius_ratio=core)), id=f"{name}, core {core:g} b")
    for name, bird in BIRDS.items()
    for core in CORES
]


def tips_of(problem, part):
    """Return the lanes of one follower state, with the tips' own height as z."""
    half = problem.lanes.shape[1] // 2
    lanes = problem.lanes[:, part * half : (part + 1) * half].copy()
    lanes[HEIGHT] = 0.0
    return lanes


def force_at(problem, lanes, place, phase):
    """Return the wake force of one follower state at (x, y, z of the tips, R), from the kernel of the search."""
    edges = core_edges(lanes)
    x, y, z, ratio = place
    return wake_force_jacobian(np.array([x, y, z, 0.0, ratio, phase]), lanes, edges, np.empty((2, 6)))


def form_over(problem, part, middle, widths):
    """Enclose the force of one follower state over a box in (x, y, z of the tips, R)."""
    half, forms = problem.lanes.shape[1] // 2, np.empty((2, 2, 6))
    enclosure.enclose_wake_force(
        *middle,
        *widths,
        problem.lanes,
        part * half,
        (part + 1) * half,
        part == 0,
        PHASE_END,
        forms,
    )
    return forms


def special_place(problem, rng, part):
    """Return (x, y, z of the tips, R) with a wingtip at a corner, on a filament or on a core edge, or with y = 0."""
    lanes, core = tips_of(problem, part), problem.model.core_radius_ratio
    lane = lanes[:, rng.integers(lanes.shape[1])]
    ratio = rng.uniform(0.3, 0.5)
    first, last = (
        np.array([lane[FIRST_X], lane[FIRST_Z]]),
        np.array([lane[LAST_X], lane[LAST_Z]]),
    )
    side = rng.choice([-1.0, 1.0]) * lane[HALF_WIDTH] + lane[CENTRE_Y]
    kind = rng.choice(["corner", "spanwise", "tip", "spanwise edge", "tip edge", "symmetric"])
    (x, z), y = (first if rng.random() < 0.5 else last), side
    if kind in ("spanwise", "spanwise edge", "symmetric"):
        y = rng.uniform(-1.0, 1.0) * lane[HALF_WIDTH]
    if kind in ("tip", "tip edge"):
        x, z = first + rng.random() * (last - first)
    angle = rng.uniform(0.0, 2.0 * math.pi)
    if kind == "spanwise edge":
        x, z = x + core * math.cos(angle), z + core * math.sin(angle)
    if kind == "tip edge":
        across = np.array([-(last - first)[1], (last - first)[0]]) / np.linalg.norm(last - first)
        y += core * math.cos(angle)
        x, z = np.array([x, z]) + core * math.sin(angle) * across
    span = ratio if lane[SPAN_FLEXED] else 1.0
    return np.array([x, 0.0 if kind == "symmetric" else y - lane[NODE] * span, z, ratio])


def log_uniform(rng, low, high, size=None):
    return np.exp(rng.uniform(math.log(low), math.log(high), size))


@pytest.mark.parametrize("problem", PROBLEMS)
def test_the_wake_force_never_leaves_its_enclosure(problem):
    rng, worst = np.random.default_rng(12), -math.inf
    for number in range(500):
        part = number % 2
        place, lanes = special_place(problem, rng, part), tips_of(problem, part)
        middle = place + (0.0 if rng.random() < 0.3 else log_uniform(rng, 1e-12, 1.0)) * rng.normal(size=4)
        widths = log_uniform(rng, 1e-12, 1.0) * rng.random(4) * [1.0, 1.0, 1.0, 0.2]
        widths *= rng.random(4) < 0.8
        middle[3] = min(max(middle[3], 0.2), 0.6)
        forms = form_over(problem, part, middle, widths)
        within = np.clip(place, middle - widths, middle + widths)
        corners = middle + widths * rng.choice([-1.0, 1.0], size=(5, 4))
        inside = middle + widths * rng.uniform(-1.0, 1.0, size=(5, 4))
        for at in (within, *corners, *inside):
            for end, phase in enumerate((0.0, PHASE_END)):
                centred = forms[end, :, 0] + forms[end, :, 1:5] @ (at - middle)
                excess = np.abs(force_at(problem, lanes, at, phase) - centred) - forms[end, :, 5]
                worst = max(worst, float(np.max(excess)))
    assert worst <= 1e-12


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_box_of_no_width_gives_the_force(problem):
    """At any distance from a corner at which rounding leaves a direction to it."""
    rng, worst = np.random.default_rng(13), 0.0
    for number in range(300):
        part = number % 2
        middle = special_place(problem, rng, part)
        middle[:3] += log_uniform(rng, 1e-9, 1.0) * rng.normal(size=3)
        forms = form_over(problem, part, middle, np.zeros(4))
        for end, phase in enumerate((0.0, PHASE_END)):
            force = force_at(problem, tips_of(problem, part), middle, phase)
            worst = max(worst, float(np.max(np.abs(force - forms[end, :, 0]) + forms[end, :, 5])))
    assert worst <= 1e-12


def balanced_at_a_corner(problem, rng, tries):
    """Return followers in balance with a wingtip within 1e-5 semispans of a corner of a ring, and their costs."""
    bounds, found = problem.bounds, []
    edges = core_edges(problem.lanes)
    residual, gradient, jacobian = np.empty(2), np.empty(6), np.empty((2, 6))
    for _ in range(tries):
        lane = problem.lanes[:, rng.integers(problem.lanes.shape[1])]
        end = rng.random() < 0.5
        corner = np.array(
            [
                lane[LAST_X if end else FIRST_X],
                lane[CENTRE_Y] + rng.choice([-1.0, 1.0]) * lane[HALF_WIDTH],
                lane[LAST_Z if end else FIRST_Z],
            ]
        )
        tip = corner + log_uniform(rng, 1e-9, 1e-5) * rng.uniform(-1.0, 1.0, 3)
        stroke = bounds[3:, 0] + rng.random(3) * (bounds[3:, 1] - bounds[3:, 0])

        def place(stroke, lane=lane, tip=tip):
            span = stroke[1] if lane[SPAN_FLEXED] else 1.0
            x, y, z = tip[0], tip[1] - lane[NODE] * span, tip[2] - lane[HEIGHT] * stroke[0]
            return np.array([x, y, z, *stroke])

        # Along these the wingtip stays where it is.
        along = np.zeros((6, 3))
        along[3:] = np.eye(3)
        along[1, 1] = -lane[NODE] if lane[SPAN_FLEXED] else 0.0
        along[2, 0] = -lane[HEIGHT]
        for _ in range(40):
            evaluate(place(stroke), problem.lanes, edges, problem.constants, residual, gradient, jacobian)
            free = (stroke > bounds[3:, 0]) & (stroke < bounds[3:, 1])
            step = np.linalg.lstsq((jacobian @ along) * free, -residual, rcond=None)[0]
            stroke = np.clip(stroke + step, bounds[3:, 0], bounds[3:, 1])
        point = place(stroke)
        cost = evaluate(point, problem.lanes, edges, problem.constants, residual, gradient, jacobian)
        inside = np.all((point >= bounds[:, 0]) & (point <= bounds[:, 1]))
        if inside and np.max(np.abs(residual)) < 5e-13:
            found.append((point, cost))
    return found


def assert_is_not_excluded(problem, point, cost, width):
    """Check that no proof around a balanced follower closes above its cost."""
    around = width * np.ones(6)
    box = np.clip(np.stack([point - around, point + around], axis=1), *problem.bounds.T[:, :, None])
    proof = certify(problem, box, cost * 1.0005, 1e-4, 3000)
    assert not proof.is_closed
    assert proof.lower_bound <= cost + 1e-9


@pytest.mark.parametrize("core", [0.03, 0.1, 0.171, 0.4])
def test_a_follower_with_a_wingtip_at_a_corner_is_not_excluded(core):
    rng, found = np.random.default_rng(14), 0
    for mass in (0.3, 1.3, 2.6, 5.0):
        bird = Bird(mass, 0.6, 15.0, 0.25, 1.29, 9.8, 1.2 * math.sin(math.pi / 3.0), 0.4)
        problem = PairProblem(bird, model=WakeModel(core_radius_ratio=core))
        for point, cost in balanced_at_a_corner(problem, rng, 60)[:10]:
            found += 1
            for width in (1e-10, 3e-8, 3e-7, 1e-5, 1e-3):
                assert_is_not_excluded(problem, point, cost, width)
    assert found >= 8


def test_a_known_follower_with_a_wingtip_by_a_corner_is_not_excluded():
    """The place was found by an attempt to falsify a proof whose bounds took filaments' ends too lightly."""
    bird = Bird(
        2.2998580446820873, 1.0, 10.0, 0.621897173228199, 1.2, 9.81, 1.2083304789156593, 0.3223843351150673
    )
    problem = PairProblem(bird, "force")
    point = [6.218973395506475, 0.2146010341827772, 1.1973367047994468]
    point += [1.1863408996823996, 0.32608015168543986, 0.10105264876982964]
    point = np.array(point)
    edges, residual = core_edges(problem.lanes), np.empty(2)
    cost = evaluate(point, problem.lanes, edges, problem.constants, residual, np.empty(6), np.empty((2, 6)))
    assert np.max(np.abs(residual)) < 1e-12
    assert cost == pytest.approx(1.0025921030752, abs=1e-12)
    for width in (1e-8, 3e-7, 1e-5):
        assert_is_not_excluded(problem, point, cost, width)


def test_a_proof_ends_where_a_coordinate_is_large_against_the_box():
    """Rounding of a coordinate of a thousand semispans is wider than the box that is left: it cannot shrink on."""
    bird = Bird(0.6, 1.0, 10.0, 100.0, 1.2, 9.81, 1e-3, 0.4)
    problem = PairProblem(bird)
    box = problem.bounds.copy()
    box[0] = 900.0
    claims = []
    proof = Thread(target=lambda: claims.append(certify(problem, box, 2.0, 1e-4, 50)), daemon=True)
    proof.start()
    proof.join(100.0)
    assert claims
