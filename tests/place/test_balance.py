"""A bird at a given place: every stroke with which it balances, and what the cheapest saves."""

import math
from dataclasses import replace

import numpy as np
import pytest
from upwash import Pose, WakeModel, load_species, wake_force
from upwash.kernel import kernel
from upwash.place.balance import Behind
from upwash.place.compiled.felt import look, settle

IBIS = load_species("northern-bald-ibis").bird()
LIMIT = WakeModel.named("limit")
# Cores so thin that wing tips meet several balances, and lift may fall where the span ratio rises.
THIN = WakeModel(core_radius_ratio=0.03)


def random_places(bird, count, seed):
    """Return places about a leader, where the wake is strong, with their phase."""
    random = np.random.default_rng(seed)
    low = [0.0, 0.0, -0.6 * bird.amplitude_m, 0.0]
    high = [1.5 * bird.wavelength_m, 1.8 * bird.semispan_m, 0.6 * bird.amplitude_m, 1.0]
    return [tuple(place) for place in random.uniform(low, high, (count, 4)).tolist()]


def forces(behind, places, stroke):
    """Return lift over weight and thrust over drag by the plain statement of the model."""
    bird, (lift, thrust) = behind.bird, behind.bird.self_force_n(stroke)
    for x, y, z, phase in places:
        wake = wake_force(bird, behind.ahead, Pose(x, y, z, stroke, phase), behind.model)
        lift, thrust = lift + wake[0], thrust + wake[1]
    return lift / bird.weight_n, thrust / bird.drag_n


@kernel
def _fill_grid(amplitudes, ratios, felt, room, lift, thrust):
    for i in range(amplitudes.size):
        for j in range(ratios.size):
            look(amplitudes[i], ratios[j], felt, room)
            lift[i, j], thrust[i, j] = room.balance[0], room.balance[1]


def grid(behind, place, size):
    """Return amplitudes (in semispans), ratios, and lift and thrust in excess for each pair of them."""
    bounds, felt, room = behind.bounds, behind.felt, behind.room(1)
    settle(behind.scaled([place]), felt, room)
    amplitudes = np.linspace(bounds.least_amplitude, bounds.most_amplitude, size)
    ratios = np.linspace(bounds.least_ratio, bounds.most_ratio, size)
    lift, thrust = np.empty((size, size)), np.empty((size, size))
    _fill_grid(amplitudes, ratios, felt, room, lift, thrust)
    return amplitudes, ratios, lift, thrust


def strokes_by_brute_force(behind, place, size=400):
    """Return amplitude (in semispans) and ratio of each balance that a grid shows, improved by Newton's method."""
    bounds, felt, room = behind.bounds, behind.felt, behind.room(1)
    amplitudes, ratios, lift, thrust = grid(behind, place, size)

    def changes_sign(values):
        corners = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
        return (corners.min(axis=0) <= 0.0) & (corners.max(axis=0) >= 0.0)

    found = []
    for i, j in np.argwhere(changes_sign(lift) & changes_sign(thrust)):
        point = np.array([amplitudes[i : i + 2].mean(), ratios[j : j + 2].mean()])
        for _ in range(60):
            look(*point, felt, room)
            if np.max(np.abs(room.balance)) < 1e-14:
                break
            point -= np.linalg.solve(room.slopes[:, 3:5], room.balance)
            if not np.all(np.abs(point) < 3.0):
                break
        inside = bounds.least_amplitude <= point[0] <= bounds.most_amplitude
        inside &= bounds.least_ratio <= point[1] <= bounds.most_ratio
        if inside and np.max(np.abs(room.balance)) < 1e-9:
            found.append(point)
    return found


def best_saving(behind, x, y):
    """Return the largest saving over the phases at a level place, and the phase."""
    found = []
    for phase in np.arange(100) / 100:
        strokes = behind.balances([(x, y, 0.0, phase)]).strokes
        found += [(1.0 - strokes[0].cost, phase)] if strokes else []
    return max(found)


@pytest.mark.parametrize("model", [WakeModel(), LIMIT, THIN], ids=["paper", "limit", "thin cores"])
def test_every_stroke_balances_by_the_plain_statement(model):
    behind = Behind(IBIS, model=model)
    count = 0
    for place in random_places(IBIS, 30, seed=1):
        for balance in behind.balances([place]).strokes:
            lift, thrust = forces(behind, [place], balance.stroke)
            assert lift == pytest.approx(1.0, abs=1e-10)
            assert thrust == pytest.approx(1.0, abs=1e-10)
            count += 1
    assert count >= 29


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("species", "model", "count"),
    [
        ("northern-bald-ibis", WakeModel(), 40),
        ("mute-swan", WakeModel(), 40),
        ("mute-swan", THIN, 40),
        ("northern-bald-ibis", LIMIT, 2),
    ],
    ids=["ibis, paper", "swan, paper", "swan, thin cores", "ibis, limit"],
)
def test_no_stroke_is_missed_and_none_is_cheaper(species, model, count):
    bird = load_species(species).bird()
    behind = Behind(bird, model=model)
    most = 0
    for place in random_places(bird, count, seed=5):
        strokes = behind.balances([place]).strokes
        ours = [(one.stroke.amplitude_m / bird.semispan_m, one.stroke.span_ratio) for one in strokes]
        for amplitude, ratio in strokes_by_brute_force(behind, place):
            apart = [max(abs(h - amplitude), abs(r - ratio)) for h, r in ours]
            assert min(apart, default=math.inf) < 1e-7, (place, ours, amplitude, ratio)
        assert [one.cost for one in strokes] == sorted(one.cost for one in strokes)
        most = max(most, len(strokes))
    assert most >= (3 if model is THIN else 1)


def test_saving_where_ibises_were_seen():
    assert best_saving(Behind(IBIS), 1.2, 0.904)[0] == pytest.approx(0.003, abs=0.0005)
    assert best_saving(Behind(IBIS, model=LIMIT), 1.2, 0.904)[0] == pytest.approx(0.020, abs=0.0005)
    by_tip = replace(LIMIT, span_law="tip")
    assert best_saving(Behind(IBIS, model=by_tip), 1.2, 0.904)[0] == pytest.approx(0.042, abs=0.0005)
    # Further aside the stroke law saves more than the tip law.
    assert best_saving(Behind(IBIS, model=LIMIT), 1.2, 1.1)[0] == pytest.approx(0.040, abs=0.0005)
    assert best_saving(Behind(IBIS, model=by_tip), 1.2, 1.1)[0] == pytest.approx(0.030, abs=0.0005)


@pytest.mark.parametrize("span_law", ["stroke", "tip"])
def test_straight_behind_in_phase_pays_or_cannot_balance_in_the_limit(span_law):
    behind = Behind(IBIS, model=replace(LIMIT, span_law=span_law))
    found = behind.balances([(0.5 * IBIS.wavelength_m, 0.0, 0.0, 0.5)])
    assert found.missing == "thrust" if not found.strokes else found.strokes[0].cost > 1.04
    if not found.strokes:
        assert 0.0 < found.missing_share < 0.2


@pytest.mark.parametrize("model", [WakeModel(), LIMIT], ids=["paper", "limit"])
def test_the_wakes_of_several_birds_add_up(model):
    behind = Behind(IBIS, model=model)
    places = [(1.2, 0.9, 0.0, 0.3), (2.6, 1.9, -0.1, 0.8), (1.4, -1.1, 0.2, 0.55)]
    found = behind.balances(places)
    for balance in found.strokes:
        assert forces(behind, places, balance.stroke) == pytest.approx((1.0, 1.0), abs=1e-10)
    assert len(found.strokes) == 1
    alone = behind.balances(places[:1]).strokes[0]
    assert abs(found.strokes[0].cost - alone.cost) > 1e-3


def test_more_states_and_points_are_felt_as_stated():
    behind = Behind(IBIS, model=WakeModel(stroke_states=6, span_nodes=5, wavelengths=2))
    (balance,) = behind.balances([(1.3, 0.8, 0.1, 0.37)]).strokes
    lift, thrust = forces(behind, [(1.3, 0.8, 0.1, 0.37)], balance.stroke)
    assert (lift, thrust) == pytest.approx((1.0, 1.0), abs=1e-10)


def test_far_away_a_bird_flies_as_alone():
    for model in (WakeModel(), LIMIT):
        (balance,) = Behind(IBIS, model=model).balances([(2.0, 400.0, 0.0, 0.2)]).strokes
        assert balance.cost == pytest.approx(1.0, abs=1e-5)
        assert balance.stroke.amplitude_m == pytest.approx(IBIS.amplitude_m, rel=1e-4)


def test_the_papers_bounds_are_kept():
    behind = Behind(IBIS, model=LIMIT, bounds="paper")
    for place in random_places(IBIS, 40, seed=2):
        for one in behind.balances([place]).strokes:
            assert 0.25 * IBIS.amplitude_m <= one.stroke.amplitude_m <= IBIS.amplitude_m * (1.0 + 1e-7)
            assert 0.3 <= one.stroke.span_ratio <= 0.5


def test_says_what_is_missing():
    behind, said = Behind(IBIS, bounds="paper"), 0
    for place in random_places(IBIS, 300, seed=3):
        found = behind.balances([place])
        if found.strokes:
            assert (found.missing, found.missing_share) == ("", 0.0)
            continue
        amplitudes, ratios, lift, thrust = grid(behind, place, 60)
        # Thrust in excess where lift balances, row by row.
        crosses = (lift[:, 0] <= 0.0) & (lift[:, -1] >= 0.0)
        left = [np.interp(0.0, lift[i], thrust[i]) for i in np.flatnonzero(crosses)]
        left = np.array(left) / behind.felt.own.drag if left else np.concatenate([lift[:, 0], lift[:, -1]])
        least = left[np.argmin(np.abs(left))]
        what = "thrust" if np.any(crosses) else "lift"
        assert found.missing == (what if least < 0.0 else f"less {what}")
        assert found.missing_share == pytest.approx(abs(least), abs=0.02)
        said += 1
    assert said > 10


def test_other_bounds_are_refused():
    with pytest.raises(ValueError, match="bounds: expected one of paper, wide"):
        Behind(IBIS, bounds="narrow")
