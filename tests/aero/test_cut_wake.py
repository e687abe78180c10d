"""A wake that ends, felt on the whole span: the compiled force against the plain statement, and its slopes."""

import math
from dataclasses import replace

import numpy as np
import pytest
from upwash.aero.compiled.cut_wake import cut_wake_force
from upwash.aero.cut_wake import cut_wake, phase_pieces
from upwash.aero.interaction import wake_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel

EXACT = WakeModel(span_nodes="exact")
MODELS = {
    "paper's states": EXACT,
    "five held, stroke law, soft core": replace(
        EXACT, stroke_states=5, span_law="stroke", core="rosenhead-moore"
    ),
    "four held, two wavelengths": replace(EXACT, stroke_states=4, wavelengths=2),
    "two followed": replace(EXACT, stroke_states=2, stroke_rule="gauss"),
    "eight followed, stroke law, long": replace(
        EXACT, stroke_states=8, stroke_rule="gauss", span_law="stroke", wavelengths=11
    ),
    "four followed, soft core": replace(EXACT, stroke_states=4, stroke_rule="gauss", core="rosenhead-moore"),
}
AHEAD = Stroke(1.0, 0.42)


def random_point(rng, bird, piece):
    wavelength = bird.wavelength_m / bird.semispan_m
    place = rng.uniform([0.0, 0.0, -0.8], [1.5 * wavelength, 2.5, 0.8])
    return np.array([*place, rng.uniform(0.5, 1.7), rng.uniform(0.3, 0.5), rng.uniform(0.0, piece.span)])


def compiled(point, wake):
    jacobian = np.empty((2, 6))
    return np.array(cut_wake_force(point, wake, wake.runs.copy(), jacobian)), jacobian


@pytest.mark.parametrize("circulation_ratio", [1.0, 0.6, 0.0])
@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_compiled_force_is_the_plain_one_with_its_slopes(ibis, model, circulation_ratio):
    bird = replace(ibis, circulation_ratio=circulation_ratio)
    rng, b = np.random.default_rng(1), bird.semispan_m
    for piece in phase_pieces(model):
        wake, point = cut_wake(bird, AHEAD, model, piece), random_point(rng, bird, piece)
        x, y, z, amplitude, ratio, t = point
        pose = Pose(x * b, y * b, z * b, Stroke(amplitude * b, ratio), (piece.start + t) % 1.0)
        force, jacobian = compiled(point, wake)
        assert force == pytest.approx(wake_force(bird, AHEAD, pose, model), abs=1e-13)
        for variable in range(6):
            step = 1e-6 * np.eye(6)[variable]
            slope = (compiled(point + step, wake)[0] - compiled(point - step, wake)[0]) / 2e-6
            assert jacobian[:, variable] == pytest.approx(slope, abs=1e-7)


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_pieces_follow_one_another_around_the_wingbeat_and_meet(ibis, model):
    pieces, rng = phase_pieces(model), np.random.default_rng(2)
    assert sum(piece.span for piece in pieces) == pytest.approx(1.0, abs=1e-12)
    for piece, following in zip(pieces, [*pieces[1:], pieces[0]], strict=True):
        assert (piece.start + piece.span - following.start + 0.5) % 1.0 == pytest.approx(0.5, abs=1e-12)
        point = random_point(rng, ibis, piece)
        point[5] = piece.span
        end = compiled(point, cut_wake(ibis, AHEAD, model, piece))[0]
        point[5] = 0.0
        assert compiled(point, cut_wake(ibis, AHEAD, model, following))[0] == pytest.approx(end, abs=1e-12)


def test_where_birds_are_followed_the_force_is_smooth_within_a_piece_and_kinks_between(ibis):
    model = replace(EXACT, stroke_states=2, stroke_rule="gauss")
    first, second = (cut_wake(ibis, AHEAD, model, piece) for piece in phase_pieces(model))
    point = np.array([0.4, 0.9, 0.3, 1.2, 0.4, phase_pieces(model)[0].span])
    inside = compiled(point - 1e-6 * np.eye(6)[5], first)[1][:, 5]
    at_end, point[5] = compiled(point, first)[1][:, 5], 0.0
    beyond = compiled(point, second)[1][:, 5]
    assert at_end == pytest.approx(inside, rel=1e-4)
    assert np.max(np.abs(beyond - at_end)) > 1e-2 * np.max(np.abs(at_end))


def test_held_pieces_are_linear_in_phase(ibis):
    model = MODELS["four held, two wavelengths"]
    piece = phase_pieces(model)[2]
    wake, point = cut_wake(ibis, AHEAD, model, piece), np.array([3.0, 1.3, 0.1, 1.2, 0.4, 0.0])
    forces = []
    for share in (0.0, 0.3, 1.0):
        point[5] = share * piece.span
        forces.append(compiled(point, wake)[0])
    assert forces[1] == pytest.approx(0.7 * forces[0] + 0.3 * forces[2], abs=1e-14)


def test_a_wake_of_any_length_has_room(ibis):
    """The product of all distances in one logarithm would not fit a number; the parts keep it small."""
    model = replace(EXACT, stroke_states=2, stroke_rule="gauss", wavelengths=300)
    piece = phase_pieces(model)[0]
    wake = cut_wake(ibis, AHEAD, model, piece)
    force, jacobian = compiled(np.array([9.0, 1.4, 0.0, 1.2, 0.4, 0.1]), wake)
    assert np.all(np.isfinite(force)) and np.all(np.isfinite(jacobian))
    near = cut_wake(ibis, AHEAD, replace(model, wavelengths=40), piece)
    assert force == pytest.approx(compiled(np.array([9.0, 1.4, 0.0, 1.2, 0.4, 0.1]), near)[0], rel=1e-3)
    assert math.hypot(*force) > 0.0


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
@pytest.mark.parametrize("phase_lock", [True, False], ids=["in step", "averaged"])
def test_a_leader_of_another_kind_sheds_its_own_wake(ibis, model, phase_lock):
    leader, rng, b = replace(ibis, mass_kg=2.0, semispan_m=0.8, period_s=0.3), np.random.default_rng(5), 0.6
    piece = phase_pieces(model)[-1]
    wake, point = (
        cut_wake(ibis, AHEAD, model, piece if phase_lock else None, leader=leader),
        random_point(rng, ibis, piece),
    )
    x, y, z, amplitude, ratio, t = point
    pose = Pose(
        x * b, y * b, z * b, Stroke(amplitude * b, ratio), (piece.start + t) % 1.0 if phase_lock else 0.0
    )
    expected = wake_force(ibis, AHEAD, pose, model, leader=leader, phase_lock=phase_lock)
    assert compiled(point, wake)[0] == pytest.approx(expected, abs=1e-13)
