"""The wake's force on a follower: the paper's four forces, their mean, and what any resolution must keep."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from upwash.aero.induction import velocity
from upwash.aero.interaction import (
    net_force,
    phase_weights,
    span_nodes,
    state_circulation_ratio,
    state_forces,
    wake_force,
)
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel, vortex_wake

from . import paper

LEADER = Stroke(1.04, 0.4)

# Near the paper's optimum, inboard, close by, far behind.
FOLLOWERS = [
    Pose(1.83, 0.882, -0.063, Stroke(0.751, 0.347), 0.5),
    Pose(1.2, 0.31, 0.2, Stroke(0.5, 0.3), 0.0),
    Pose(0.05, 1.7, 0.9, Stroke(1.0, 0.5), 0.3),
    Pose(3.9, 0.1, -0.6, Stroke(0.3, 0.45), 0.9),
]
EACH_FOLLOWER = pytest.mark.parametrize("follower", FOLLOWERS)
RESOLUTIONS = [
    WakeModel(),
    WakeModel(stroke_states=3, span_nodes=4),
    WakeModel(stroke_states=4, span_nodes=3),
]
EACH_RESOLUTION = pytest.mark.parametrize("model", RESOLUTIONS)


def paper_forces(bird, follower):
    """Return the paper's four forces by the names of their states, as lift and thrust."""
    (x, y, z), (amplitude, ratio) = follower.position_m, vars(follower.stroke).values()
    # Away from the origin, so that only relative positions may count.
    leader = (1.0, -2.0, 0.52, *vars(LEADER).values())
    placed = (1.0 + x, -2.0 + y, 0.52 + z, amplitude, ratio)
    values = {
        "rho": bird.density_kg_m3,
        "b": bird.semispan_m,
        "U": bird.speed_m_s,
        "T": bird.period_s,
        "circulation": bird.circulation_m2_s,
    }
    forces = paper.wake_induced_force(leader, placed, values)
    return {name: np.array([force[2], -force[0]]) for name, force in forces.items()}


@EACH_FOLLOWER
def test_the_force_in_each_pair_of_states_is_the_paper_s(ibis, follower):
    (uu, ud), (du, dd) = state_forces(ibis, LEADER, follower)
    expected = paper_forces(ibis, follower)
    for name, force in (("uu", uu), ("ud", ud), ("du", du), ("dd", dd)):
        assert force == pytest.approx(expected[name], rel=1e-11, abs=1e-12)


@EACH_FOLLOWER
@pytest.mark.parametrize("kappa", [0.0, 0.2, 0.5, 0.9])
def test_the_mean_force_is_the_paper_s(ibis, follower, kappa):
    forces, weights = paper_forces(ibis, follower), paper.phase_weights(kappa)
    expected = sum(weights[name] * forces[name] for name in forces)
    assert wake_force(ibis, LEADER, replace(follower, phase=kappa)) == pytest.approx(
        expected, rel=1e-11, abs=1e-12
    )


def test_the_paper_s_follower_flies_in_balance_within_the_rounding_of_its_table(ibis):
    # Table 1: x 1.83, y 0.882, z 0.457 with the leader's 0.520, h 0.751 (all m), R 0.347, κ 0.500.
    assert ibis.lift_n(0.347) == pytest.approx(12.17, abs=5e-3)
    assert ibis.thrust_n(0.751, 0.347) == pytest.approx(1.89, abs=5e-3)
    table = np.array([1.83, 0.882, 0.457 - 0.520, 0.751, 0.347])
    rounding = np.array([0.005, 0.0005, 0.001, 0.0005, 0.0005])
    imbalance = []
    for signs in itertools.product((-1, 0, 1), repeat=5):
        x, y, z, amplitude, ratio = table + signs * rounding
        lift, thrust = net_force(ibis, ibis.stroke, Pose(x, y, z, Stroke(amplitude, ratio), 0.5))
        imbalance.append(max(abs(lift / ibis.weight_n - 1), abs(thrust / ibis.drag_n - 1)))
    assert min(imbalance) < 5e-3


@EACH_FOLLOWER
def test_net_force_is_the_follower_s_own_and_the_wake_s(slack_ibis, follower):
    amplitude, ratio = follower.stroke.amplitude_m, follower.stroke.span_ratio
    lift, thrust = wake_force(slack_ibis, LEADER, follower)
    own = slack_ibis.lift_n(ratio), slack_ibis.thrust_n(amplitude, ratio)
    assert net_force(slack_ibis, LEADER, follower) == pytest.approx((own[0] + lift, own[1] + thrust))


def test_outboard_of_the_wake_the_follower_is_pushed_and_inboard_held_back(ibis):
    # The leader is down and the follower up, a quarter wavelength behind, its tips level with the wake there.
    for y, sign in ((0.9, 1.0), (0.0, -1.0)):
        forces = state_forces(ibis, LEADER, Pose(0.94, y, -0.25, Stroke(0.5, 0.4), 0.0))
        assert np.sign(forces[1, 0, 1]) == sign


@EACH_RESOLUTION
def test_left_and_right_of_the_leader_are_alike(slack_ibis, model):
    for follower in FOLLOWERS:
        right = state_forces(slack_ibis, LEADER, follower, model)
        left = state_forces(slack_ibis, LEADER, follower.mirrored(), model)
        assert left == pytest.approx(right, rel=1e-11, abs=1e-12)


@EACH_FOLLOWER
def test_phases_kappa_and_one_less_kappa_are_the_same_solution(ibis, follower):
    late, early = (wake_force(ibis, LEADER, replace(follower, phase=phase)) for phase in (0.8, 0.2))
    assert late == pytest.approx(early)


@EACH_RESOLUTION
def test_far_away_there_is_no_wake(ibis, model):
    far = Pose(500.0, 300.0, 0.0, Stroke(0.8, 0.4), 0.0)
    assert abs(state_forces(ibis, LEADER, far, model)).max() < 1e-7


@EACH_RESOLUTION
def test_the_force_goes_with_density_and_the_square_of_circulation(make_ibis, model):
    # At a given speed, twice the mass needs twice the circulation; twice the density needs half of it.
    one = state_forces(make_ibis(), LEADER, FOLLOWERS[0], model)
    heavy = state_forces(make_ibis(mass_kg=2.6), LEADER, FOLLOWERS[0], model)
    dense = state_forces(make_ibis(density_kg_m3=2.58), LEADER, FOLLOWERS[0], model)
    assert heavy == pytest.approx(4.0 * one, rel=1e-12)
    assert dense == pytest.approx(0.5 * one, rel=1e-12)


def scaled(stroke, scale):
    return replace(stroke, amplitude_m=scale * stroke.amplitude_m)


@EACH_RESOLUTION
@pytest.mark.parametrize("scale", [0.1, 7.0])
def test_force_over_weight_depends_on_four_numbers_only(make_ibis, model, scale):
    # W/(ρ b² U²), λ/b, h/b and R: a bird of another size with the same four is carried by the same share.
    other = make_ibis(
        semispan_m=0.6 * scale,
        mass_kg=1.3 * scale**2,
        period_s=0.25 * scale,
        amplitude_m=1.0392 * scale,
    )
    one = make_ibis(amplitude_m=1.0392)
    small = state_forces(one, LEADER, FOLLOWERS[0], model) / one.weight_n
    large_pose = Pose(
        *(scale * value for value in FOLLOWERS[0].position_m), scaled(FOLLOWERS[0].stroke, scale), 0.5
    )
    large = state_forces(other, scaled(LEADER, scale), large_pose, model)
    assert large / other.weight_n == pytest.approx(small, rel=1e-11)


def test_a_weaker_upstroke_weakens_its_rings_and_the_follower_s_raised_wing(make_ibis):
    # Take the circulation of the downstroke out; what is left follows ratio² , ratio and 1.
    whole, slack = make_ibis(), make_ibis(circulation_ratio=0.6)
    per_whole = state_forces(whole, LEADER, FOLLOWERS[0]) / whole.circulation_m2_s**2
    per_slack = state_forces(slack, LEADER, FOLLOWERS[0]) / slack.circulation_m2_s**2
    wake = vortex_wake(LEADER.amplitude_m, LEADER.span_ratio, 0.6, 3.75, 1.0, 1.0)
    (x, y, z), stroke = FOLLOWERS[0].position_m, FOLLOWERS[0].stroke
    amplitude, ratio = stroke.amplitude_m, stroke.span_ratio
    for j in (0, 1):
        for k, (half_span, height, wing) in enumerate(((0.6 * ratio, 0.5, 0.6), (0.6, -0.5, 1.0))):
            tips = [[x, y + side * half_span, z + height * amplitude] for side in (1, -1)]
            of_upstroke = (wake.state == j) & wake.is_upstroke
            wind = velocity(tips, wake.rings[of_upstroke], wake.circulation[of_upstroke], 0.171 * 0.6).sum(
                axis=0
            )
            of_upstroke_rings = 1.29 * half_span * wind[[0, 2]]
            expected = wing * (per_whole[j, k] - 0.4 * of_upstroke_rings)
            assert per_slack[j, k] == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_the_wing_s_circulation_goes_from_the_upstroke_s_to_the_downstroke_s(slack_ibis, ibis):
    ratios = [state_circulation_ratio(slack_ibis, k, 4) for k in range(4)]
    assert ratios == pytest.approx([0.6, 0.8, 1.0, 0.8], rel=1e-14)
    assert [state_circulation_ratio(ibis, k, 5) for k in range(5)] == [1.0] * 5


@pytest.mark.parametrize("count", [2, 3, 5, 8])
def test_span_nodes_are_a_trapezoidal_rule_from_tip_to_tip(count):
    nodes, weights = span_nodes(count)
    assert nodes[0] == -1.0 and nodes[-1] == 1.0
    assert weights.sum() == pytest.approx(1.0, rel=1e-15)
    assert nodes == pytest.approx(-nodes[::-1]) and weights == pytest.approx(weights[::-1])
    assert weights[1:-1] == pytest.approx(2.0 * weights[0])
    # The mean of a straight line is exact; that of η² is off by the trapezoidal rule's (Δη)²/6.
    assert weights @ (3.0 + 2.0 * nodes) == pytest.approx(3.0, rel=1e-14)
    assert weights @ nodes**2 - 1.0 / 3.0 == pytest.approx((2.0 / (count - 1)) ** 2 / 6.0, rel=1e-12)


def test_with_more_nodes_the_force_tends_to_the_integral_over_the_span(ibis):
    follower = FOLLOWERS[2]
    (x, y, z), amplitude = follower.position_m, follower.stroke.amplitude_m
    wake = vortex_wake(LEADER.amplitude_m, LEADER.span_ratio, 0.6, 3.75, ibis.circulation_m2_s)
    rings, circulation = wake.rings[wake.state == 0], wake.circulation[wake.state == 0]

    def upwash(along):
        return velocity([x, along, z - amplitude / 2], rings, circulation, 0.171 * 0.6)[2]

    integral = quad(upwash, y - 0.6, y + 0.6, limit=400)[0] * ibis.density_kg_m3 * ibis.circulation_m2_s
    errors = [
        abs(state_forces(ibis, LEADER, follower, WakeModel(span_nodes=nodes))[0, 1, 1] - integral)
        for nodes in (2, 21, 201)
    ]
    assert errors[0] > 50 * errors[1] and errors[1] > 50 * errors[2]


@pytest.mark.parametrize("states", [3, 4])
def test_the_mean_over_many_states_weighs_each_pair_by_the_time_it_lasts(ibis, states):
    model = WakeModel(stroke_states=states)
    forces = state_forces(ibis, LEADER, FOLLOWERS[0], model)
    assert forces.shape == (states, states, 2)
    expected = (phase_weights(0.37, states)[:, :, None] * forces).sum(axis=(0, 1))
    assert wake_force(ibis, LEADER, replace(FOLLOWERS[0], phase=0.37), model) == pytest.approx(
        expected, rel=1e-13
    )


def test_four_states_hold_the_paper_s_four_forces(ibis):
    two = state_forces(ibis, LEADER, FOLLOWERS[0])
    four = state_forces(ibis, LEADER, FOLLOWERS[0], WakeModel(stroke_states=4))
    assert four[::2, ::2] == pytest.approx(two, rel=1e-10)


@EACH_FOLLOWER
def test_a_longer_wake_acts_as_the_first_wavelength_on_followers_as_much_nearer(ibis, follower):
    nearer = [replace(follower, x_m=follower.x_m - repeat * ibis.wavelength_m) for repeat in range(3)]
    expected = sum(np.array(wake_force(ibis, LEADER, pose)) for pose in nearer)
    found = wake_force(ibis, LEADER, follower, WakeModel(wavelengths=3))
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-12)


def test_numbers_of_a_frame_are_numbers(ibis):
    """Numpy's whole numbers, as rows of a frame hold them, are points and not the whole span."""
    told = WakeModel(stroke_states=np.int64(2), span_nodes=np.int64(2), wavelengths=np.int32(1))
    assert all(type(value) is int for value in (told.stroke_states, told.span_nodes, told.wavelengths))
    found = state_forces(ibis, LEADER, FOLLOWERS[0], told)
    assert np.array_equal(found, state_forces(ibis, LEADER, FOLLOWERS[0]))
