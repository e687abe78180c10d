"""The leader's wake: the paper's eight filaments in its two states, and any number of states."""

import math

import numpy as np
import pytest
from upwash.aero.induction import velocity
from upwash.aero.wake import WakeModel, spanwise_spacing_rule, stroke_height, stroke_span, vortex_wake

from . import paper

B, WAVELENGTH, AMPLITUDE, SPAN_RATIO, CIRCULATION = 0.6, 3.75, 1.04, 0.4, 0.9257


def wake_of(states=2, **changes):
    """Return the wake of the paper's leader in a number of states."""
    values = {
        "amplitude": AMPLITUDE,
        "upstroke_span_ratio": SPAN_RATIO,
        "semispan": B,
        "wavelength": WAVELENGTH,
        "circulation": CIRCULATION,
    }
    return vortex_wake(**{**values, **changes}, model=WakeModel(stroke_states=states))


def oriented(start, end, circulation):
    """Return a filament as a tuple that does not depend on which of its ends is called the first."""
    ends = [tuple(round(value, 12) + 0.0 for value in end_) for end_ in (start, end)]
    return (
        (*ends, round(circulation, 12)) if ends[0] < ends[1] else (*reversed(ends), round(-circulation, 12))
    )


@pytest.mark.parametrize(("state", "name"), [(0, "up"), (1, "down")])
def test_the_wake_is_the_paper_s_eight_filaments_in_each_state(state, name):
    wake = wake_of()
    found = []
    for ring in np.flatnonzero(wake.state == state):
        loop, circulation = wake.corners()[ring], wake.circulation[ring]
        found += [oriented(loop[k], loop[(k + 1) % 4], circulation) for k in range(4)]
    printed = paper.filaments(name, 0.0, 0.0, 0.0, AMPLITUDE, SPAN_RATIO, B, WAVELENGTH)
    expected = [oriented(start, end, sign * CIRCULATION) for start, end, sign in printed]
    assert len(expected) == 8
    assert sorted(found) == sorted(expected)


@pytest.mark.parametrize(("state", "name"), [(0, "up"), (1, "down")])
def test_the_wake_s_velocity_is_that_of_the_paper_s_filaments(state, name):
    wake, core = wake_of(), 0.171 * B
    rings, circulation = wake.rings[wake.state == state], wake.circulation[wake.state == state]
    points = np.random.default_rng(state).uniform([-0.5, -1.5, -1.0], [4.5, 1.5, 1.0], (200, 3))
    printed = paper.filaments(name, 0.0, 0.0, 0.0, AMPLITUDE, SPAN_RATIO, B, WAVELENGTH)
    expected = np.array([paper.velocity(point, printed, CIRCULATION, core) for point in points])
    assert velocity(points, rings, circulation, core) == pytest.approx(expected, rel=1e-11, abs=1e-12)


@pytest.mark.parametrize("state", [0, 1])
def test_behind_the_leader_upwash_is_outboard_and_downwash_inboard(state):
    wake = wake_of()
    rings, circulation = wake.rings[wake.state == state], wake.circulation[wake.state == state]
    for x, width in zip((0.25 * WAVELENGTH, 0.75 * WAVELENGTH), rings[:, 5], strict=True):
        inboard, outboard = velocity([[x, 0.0, 0.0], [x, width + 0.2, 0.0]], rings, circulation, 0.171 * B)
        assert inboard[2] < 0.0 < outboard[2]


def test_right_tips_and_starting_vortices_are_positive():
    wake = wake_of()
    assert (wake.circulation > 0.0).all()
    for left, right, far_right, far_left in wake.corners():
        assert right[1] > left[1] and right[0] == left[0]  # the starting vortex runs to the right,
        assert far_right[0] > right[0] and far_right[1] == right[1]  # the right tip downstream;
        assert far_left[1] < far_right[1] and far_left[0] > left[0]  # the others run against.


def test_a_weaker_upstroke_weakens_the_upstroke_s_rings_alone():
    whole, weak = wake_of(), wake_of(circulation_ratio=0.6)
    assert (weak.rings == whole.rings).all()
    assert (whole.circulation == CIRCULATION).all()
    narrow = weak.rings[:, 5] < 0.9 * weak.rings[:, 5].max()
    assert (weak.is_upstroke == narrow).all()
    assert weak.circulation == pytest.approx(np.where(narrow, 0.6, 1.0) * CIRCULATION, rel=1e-15)


@pytest.mark.parametrize("states", list(range(2, 10)))
def test_in_every_state_one_wavelength_of_wake_begins_at_the_leader_without_a_gap(states):
    wake = wake_of(states)
    assert (wake.state[:-1] <= wake.state[1:]).all()
    assert set(wake.state) == set(range(states))
    for state in range(states):
        first_x, last_x, first_z, last_z, centre, half = wake.rings[wake.state == state].T
        assert first_x[0] == 0.0 and last_x[-1] == pytest.approx(WAVELENGTH, rel=1e-15)
        assert (last_x[:-1] == first_x[1:]).all() and (last_z[:-1] == first_z[1:]).all()
        assert (last_x - first_x > 1e-6).all() and (last_x - first_x <= WAVELENGTH / 2 * (1 + 1e-12)).all()
        assert (centre == 0.0).all()
        up = wake.is_upstroke[wake.state == state]
        assert (up[:-1] != up[1:]).all()
        assert half == pytest.approx(math.pi / 4 * B * np.where(up, SPAN_RATIO, 1.0), rel=1e-15)
        # The upstroke's filaments fall downstream and the downstroke's rise, all with one slope.
        slope = (last_z - first_z) / (last_x - first_x)
        assert slope == pytest.approx(np.where(up, -1.0, 1.0) * 2 * AMPLITUDE / WAVELENGTH, rel=1e-9)


@pytest.mark.parametrize("states", list(range(2, 10)))
def test_the_wake_at_the_leader_is_as_high_as_its_tips_and_was_shed_by_the_stroke_just_past(states):
    wake = wake_of(states)
    for state in range(states):
        ring = np.flatnonzero(wake.state == state)[0]
        phase = state / states
        assert wake.rings[ring, 2] == pytest.approx(AMPLITUDE * stroke_height(phase), abs=1e-12)
        # The downstroke lasts from phase 0 to 1/2; just before phase 0 it was an upstroke.
        assert wake.is_upstroke[ring] == (not 0.0 < phase <= 0.5)


def test_the_pattern_is_carried_downstream_as_it_stands():
    # With eight states a state is the one before, moved by an eighth of a wavelength.
    wake = wake_of(8)

    def height(state, x):
        ring = wake.rings[wake.state == state]
        return np.interp(x, np.append(ring[:, 0], ring[-1, 1]), np.append(ring[:, 2], ring[-1, 3]))

    x = np.linspace(0.0, WAVELENGTH * 7 / 8, 50)
    for state in range(7):
        assert height(state + 1, x + WAVELENGTH / 8) == pytest.approx(height(state, x), abs=1e-12)


@pytest.mark.parametrize("states", [4, 6, 8])
def test_an_even_number_of_states_holds_the_paper_s_two(states):
    two, many = wake_of(), wake_of(states)
    for state, same in ((0, 0), (1, states // 2)):
        assert many.rings[many.state == same] == pytest.approx(
            two.rings[two.state == state], rel=1e-12, abs=1e-12
        )


def test_the_stroke_law_returns_the_paper_s_two_states():
    assert (stroke_height(0.0), stroke_height(0.5)) == (0.5, -0.5)
    for ratio in (0.3, 0.7):
        spans = [fixed + flexed * ratio for fixed, flexed in (stroke_span(0.0), stroke_span(0.5))]
        assert spans == [ratio, 1.0]


@pytest.mark.parametrize("phase", [0.0, 0.1, 0.25, 0.49, 0.5, 0.7, 0.99])
def test_the_stroke_law_is_periodic_continuous_and_between_its_ends(phase):
    assert stroke_height(phase + 1.0) == pytest.approx(stroke_height(phase), abs=1e-15)
    assert stroke_height(phase - 1.0) == pytest.approx(stroke_height(phase), abs=1e-15)
    assert abs(stroke_height(phase + 1e-9) - stroke_height(phase)) < 3e-9
    assert -0.5 <= stroke_height(phase) <= 0.5
    fixed, flexed = stroke_span(phase)
    assert fixed + flexed == pytest.approx(1.0, abs=1e-15) and min(fixed, flexed) >= 0.0


def test_the_spanwise_rule_puts_the_mean_wingtip_on_the_tip_vortex():
    # The paper's analytic value is 0.877 m, "within 1 %" of the optimum with R = 0.347.
    assert spanwise_spacing_rule(0.6, 0.347) == pytest.approx(0.877, rel=0.01)
    w_l, r_f = math.pi * B / 4, 0.5 * (B + 0.347 * B)  # means over a wingbeat
    assert spanwise_spacing_rule(B, 0.347) == pytest.approx(w_l + r_f, rel=1e-15)


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"core_radius_ratio": 0.0}, "core_radius_ratio: expected a positive, finite number, found 0.0"),
        ({"core_radius_ratio": math.nan}, "core_radius_ratio: expected a positive, finite number, found nan"),
        ({"stroke_states": 1}, "stroke_states: expected a whole number of at least 2, found 1"),
        ({"span_nodes": 0}, "span_nodes: expected exact or a whole number of at least 2, found 0"),
    ],
)
def test_what_a_wake_model_may_not_be(changes, says):
    with pytest.raises(ValueError, match=says):
        WakeModel(**changes)


def test_the_default_model_is_the_paper_s():
    assert WakeModel() == WakeModel(core_radius_ratio=0.171, stroke_states=2, span_nodes=2)
