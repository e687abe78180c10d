"""What is left of a saving while a bird drifts, and how far a place reaches."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from upwash import Pose, Stroke, WakeModel, load_species, solve_pair
from upwash.place.balance import Behind
from upwash.place.robust import DRAWS, Jittering, Spread
from upwash.place.survey import normal_draws
from upwash.place.tolerance import tolerance

IBIS = load_species("northern-bald-ibis").bird()
B = IBIS.semispan_m
LIMIT = WakeModel.named("limit")
MODELS = {"paper": WakeModel(), "stroke law": LIMIT, "tip law": replace(LIMIT, span_law="tip")}


@cache
def behind(name):
    return Behind(IBIS, "power", model=MODELS[name])


@cache
def still(name):
    return solve_pair(IBIS, "power", model=MODELS[name]).v_optimum


@pytest.mark.parametrize(
    ("name", "sigma", "percent"),
    [
        ("paper", 0.05, 4.2),
        ("paper", 0.1, 3.3),
        ("paper", 0.2, 1.0),
        ("stroke law", 0.05, 3.9),
        ("stroke law", 0.1, 3.45),
        ("tip law", 0.05, 4.25),
        ("tip law", 0.1, 3.9),
    ],
)
def test_what_an_independent_program_found_is_left_at_the_still_optimum(name, sigma, percent):
    left = Jittering(behind(name), Spread.of_place(sigma * B)).remaining(still(name).pose)
    assert 100.0 * left.saving_held == pytest.approx(percent, abs=0.06)


@pytest.mark.parametrize("name", MODELS)
def test_without_jitter_all_is_left(name):
    left = Jittering(behind(name), Spread.of_place(0.0)).remaining(still(name).pose)
    assert left.saving_held == pytest.approx(still(name).saving_total, abs=1e-8)
    assert left.saving_retrimmed == pytest.approx(still(name).saving_total, abs=1e-8)
    assert left.balanced_share == 1.0


def test_the_stroke_balances_in_the_mean_by_the_plain_statement_of_the_wake():
    from upwash import wake_force

    sigma, pose = 0.1 * B, still("paper").pose
    left = Jittering(behind("paper"), Spread.of_place(sigma)).remaining(pose)
    stroke = left.pose.stroke
    draws = normal_draws(DRAWS)[:, :3] * sigma
    forces = [
        wake_force(
            IBIS, IBIS.stroke, Pose(*(np.array(pose.position_m) + draw), stroke, pose.phase), WakeModel()
        )
        for draw in draws[:512]
    ]
    lift, thrust = np.mean(forces, axis=0) + IBIS.self_force_n(stroke)
    # Of the first of the draws, which stand for all.
    assert lift == pytest.approx(IBIS.weight_n, rel=3e-3)
    assert thrust == pytest.approx(IBIS.drag_n, rel=0.05)


def test_no_place_nearby_leaves_more_than_the_best():
    name, sigma = "paper", 0.1 * B
    jittering = Jittering(behind(name), Spread.of_place(sigma))
    best = jittering.best([still(name).pose], in_v=True)
    assert best.saving_held > jittering.remaining(still(name).pose).saving_held - 1e-12
    assert best.pose.y_m >= B and best.pose.x_m >= B
    for step in np.random.default_rng(1).normal(0.0, 0.02, (12, 3)):
        x, y, z = np.array(best.pose.position_m) + B * step
        if y >= B:
            there = jittering.remaining(replace(best.pose, x_m=x, y_m=y, z_m=z))
            assert not there.saving_held > best.saving_held + 1e-7


def test_the_papers_best_place_is_a_knifes_edge_and_the_limits_is_not():
    paper, limit = (tolerance(behind(name), still(name).pose) for name in ("paper", "stroke law"))
    # One centimetre along x, of a wingspan of 1.2 m, takes half of what is saved.
    assert np.all(paper.half_width_m[0] < 0.01)
    assert np.all(limit.half_width_m > 0.1)
    assert np.all(limit.half_width_phase > 0.1)
    assert paper.fold_m < 0.005 < 0.3 < limit.fold_m


def test_half_of_the_saving_is_left_where_it_is_told():
    found = tolerance(behind("paper"), still("paper").pose)
    pose = still("paper").pose
    for axis, name in enumerate(("x_m", "y_m", "z_m")):
        for width, sign in zip(found.half_width_m[axis], (-1.0, 1.0), strict=True):
            inside, outside = (
                replace(pose, **{name: getattr(pose, name) + sign * share * width})
                for share in (0.999, 1.001)
            )
            savings = []
            for one in (inside, outside):
                place = (*one.position_m, one.phase)
                strokes = behind("paper").balances([place]).strokes
                savings.append(1.0 - strokes[0].cost if strokes else -np.inf)
            assert savings[0] > 0.5 * still("paper").saving_total > savings[1]


def test_straight_behind_in_phase_no_stroke_balances_or_it_pays():
    in_phase = Pose(0.5 * IBIS.wavelength_m, 0.0, 0.0, Stroke(1.0, 0.4), 0.5)
    left = Jittering(behind("stroke law"), Spread.of_place(0.01 * B)).remaining(in_phase)
    assert left.pose is None
    assert np.isnan(left.saving_held)
    assert left.balanced_share == 0.0
    assert np.isnan(left.saving_retrimmed)
