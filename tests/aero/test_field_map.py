"""The compiled force map against the plain statement of the force, place by place."""

from dataclasses import replace

import numpy as np
import pytest
from upwash.aero import field_map
from upwash.aero.compiled import field_map as compiled
from upwash.aero.field_map import PLANES, force_map
from upwash.aero.interaction import net_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel

LEADER = Stroke(1.0, 0.4)
POSE = Pose(1.8, 0.88, -0.06, Stroke(0.75, 0.35), 0.3)
COORDINATE = {"xy": "y_m", "xz": "z_m", "xk": "phase"}
X = np.linspace(-0.2, 5.0, 7)
SECOND = {"xy": np.linspace(-1.0, 2.0, 5), "xz": np.linspace(-1.0, 1.0, 5), "xk": np.linspace(-0.4, 1.3, 6)}
COARSE = WakeModel()
ENDLESS = replace(WakeModel.named("limit"), stroke_states=8)
FINE = WakeModel(core_radius_ratio=0.1, stroke_states=3, span_nodes=4, wavelengths=2)


@pytest.mark.parametrize("model", [COARSE, FINE, ENDLESS], ids=["the paper's", "finer", "endless"])
@pytest.mark.parametrize("plane", PLANES)
def test_equals_the_net_force_place_by_place(ibis, plane, model):
    bird = replace(ibis, circulation_ratio=0.8)
    found = force_map(bird, LEADER, POSE, plane, X, SECOND[plane], model)
    for i, second in enumerate(SECOND[plane]):
        for j, x in enumerate(X):
            pose = replace(POSE, x_m=x, **{COORDINATE[plane]: second})
            lift, thrust = net_force(bird, LEADER, pose, model)
            assert found.lift_n[i, j] == pytest.approx(lift, rel=1e-12, abs=1e-12)
            assert found.thrust_n[i, j] == pytest.approx(thrust, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("block", [4, 35, 4096])
def test_does_not_depend_on_how_many_places_are_taken_at_a_time(ibis, block, monkeypatch):
    whole = force_map(ibis, LEADER, POSE, "xy", X, SECOND["xy"])
    monkeypatch.setattr(compiled, "BLOCK", block)
    # Compiled code keeps the constant it was compiled with: this runs the same function as plain Python.
    monkeypatch.setattr(field_map, "add_force", compiled.add_force.py_func)
    parts = force_map(ibis, LEADER, POSE, "xy", X, SECOND["xy"])
    assert parts.lift_n == pytest.approx(whole.lift_n, rel=1e-13)
    assert parts.thrust_n == pytest.approx(whole.thrust_n, rel=1e-13)


def test_more_places_than_a_block_are_all_filled(ibis):
    x, y = np.linspace(0.0, 5.0, 70), np.linspace(0.0, 2.0, 70)
    found = force_map(ibis, LEADER, POSE, "xy", x, y)
    assert x.size * y.size > compiled.BLOCK
    for i, j in ((0, 0), (58, 35), (58, 36), (69, 69)):
        lift, thrust = net_force(ibis, LEADER, replace(POSE, x_m=x[j], y_m=y[i]))
        assert (found.lift_n[i, j], found.thrust_n[i, j]) == pytest.approx((lift, thrust))


def test_is_mirrored_to_the_left_and_in_phase(ibis):
    aside = force_map(ibis, LEADER, POSE, "xy", X, [-0.9, 0.9])
    assert aside.thrust_n[0] == pytest.approx(aside.thrust_n[1])
    phases = force_map(ibis, LEADER, POSE, "xk", X, [0.2, 0.8, 1.2])
    for other in (1, 2):
        assert phases.lift_n[0] == pytest.approx(phases.lift_n[other])
        assert phases.thrust_n[0] == pytest.approx(phases.thrust_n[other])


def test_an_unknown_plane_is_named(ibis):
    with pytest.raises(ValueError, match="plane: expected one of xy, xz, xk, found 'yz'"):
        force_map(ibis, LEADER, POSE, "yz", X, X)
