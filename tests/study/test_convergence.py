"""How far the limit is converged: a small part of what docs/convergence.md shows, computed anew."""

from dataclasses import replace

import numpy as np
import pytest
from upwash.aero.pose import Pose, Stroke
from upwash.study.convergence import LIMIT, force_errors, long_wakes, random_poses, savings, with_orders

STEPS = (16, 32, 64, 128)
FINE = replace(LIMIT, stroke_states=256)


@pytest.fixture(scope="module")
def errors(ibis):
    models = [
        replace(LIMIT, stroke_states=n, stroke_rule=rule, span_law=law)
        for law in ("stroke", "tip")
        for rule in ("held", "gauss")
        for n in STEPS
    ]
    frame = force_errors(ibis, random_poses(ibis, 6), models, FINE)
    return with_orders(frame, {"lift_error": 0.0, "thrust_error": 0.0}, ("span_law", "stroke_rule"))


def mean_order(errors, law, rule):
    chosen = errors[(errors["span_law"] == law) & (errors["stroke_rule"] == rule)]
    return float(np.nanmean(chosen[["lift_error_order", "thrust_error_order"]].to_numpy()))


def error_of(errors, law, rule, steps):
    (row,) = errors[
        (errors["span_law"] == law) & (errors["stroke_rule"] == rule) & (errors["stroke_states"] == steps)
    ].itertuples()
    return row.lift_error, row.thrust_error


class TestForces:
    def test_of_held_steps_are_of_first_order_by_the_stroke_law_and_of_second_by_the_tip_law(self, errors):
        assert mean_order(errors, "stroke", "held") == pytest.approx(1.0, abs=0.3)
        assert mean_order(errors, "tip", "held") == pytest.approx(2.0, abs=0.6)

    def test_of_gauss_points_are_of_second_order_by_either(self, errors):
        assert mean_order(errors, "stroke", "gauss") == pytest.approx(2.3, abs=0.7)
        assert mean_order(errors, "tip", "gauss") == pytest.approx(2.3, abs=0.7)

    def test_of_the_default_are_nearer_than_those_of_as_many_held_steps(self, errors):
        default, held = error_of(errors, "stroke", "gauss", 32), error_of(errors, "stroke", "held", 32)
        assert default[0] < 0.02 and default[1] < 0.01
        assert default[0] < held[0] and default[1] < held[1]

    def test_of_two_points_and_two_states_are_wrong_by_more_than_themselves(self, ibis):
        coarse = replace(LIMIT, stroke_states=2, stroke_rule="held", span_nodes=2, span_law="tip")
        (row,) = force_errors(ibis, random_poses(ibis, 6), [coarse], FINE).itertuples()
        assert row.lift_error > 1.0 and row.thrust_error > 1.0


@pytest.mark.thorough
class TestSavings:
    @pytest.mark.parametrize(("law", "least", "most"), [("stroke", 0.0405, 0.0407), ("tip", 0.0440, 0.0442)])
    def test_of_the_default_are_converged_to_a_thousandth(self, ibis, law, least, most):
        models = [replace(LIMIT, span_law=law, stroke_states=n) for n in (32, 96)]
        found = savings(ibis, "power", models)["saving"].to_numpy()
        assert least < found[-1] < most
        assert found[0] == pytest.approx(found[-1], rel=1e-3)


class TestLongWakes:
    def test_do_not_become_the_endless_one_where_the_follower_flies(self, ibis):
        pose = Pose(0.5 * ibis.wavelength_m, 1.81 * 0.6, 0.0, Stroke(0.95, 0.4), 0.5)
        gaps = long_wakes(ibis, pose, (0.3, 0.5, 2.5), (4, 8)).set_index(["x_wavelengths", "wavelengths"])
        gap = gaps["thrust_gap"]
        assert gap[0.5, 8] == pytest.approx(-0.028, abs=0.002)
        assert gap[0.3, 8] == pytest.approx(-0.054, abs=0.002)
        assert abs(gap[2.5, 8]) < 0.003
        assert abs(gap[0.5, 8] - gap[0.5, 4]) < 0.001
