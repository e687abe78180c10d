"""How long each pair of stroke states lasts: the paper's weights, and those of any number of states."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from upwash.aero.interaction import phase_piece, phase_weights

from . import paper

repeatable = settings(deadline=None, derandomize=True, max_examples=100)
phases = st.floats(-2.0, 2.0)
numbers_of_states = st.integers(2, 9)


@repeatable
@given(st.floats(0.0, 1.0, exclude_max=True))
def test_two_states_have_the_paper_s_weights(kappa):
    (uu, ud), (du, dd) = phase_weights(kappa)
    expected = paper.phase_weights(kappa)
    assert (uu, dd) == pytest.approx((expected["uu"], expected["dd"]), abs=1e-15)
    assert (ud, du) == pytest.approx((expected["ud"], expected["du"]), abs=1e-15)


@repeatable
@given(phases, numbers_of_states)
def test_weights_are_shares_of_a_wingbeat(phase, states):
    weights = phase_weights(phase, states)
    assert (weights >= 0.0).all()
    # Each state of either bird lasts 1/N of the wingbeat.
    assert weights.sum(axis=0) == pytest.approx(1.0 / states, abs=1e-14)
    assert weights.sum(axis=1) == pytest.approx(1.0 / states, abs=1e-14)


@pytest.mark.parametrize("states", [2, 3, 4, 7])
@pytest.mark.parametrize("phase", [0.0, 0.1, 0.36, 0.5, 0.83])
def test_weights_are_the_time_that_two_states_overlap(states, phase):
    instants = (np.arange(200_000) + 0.5) / 200_000
    of_leader = np.floor(instants * states).astype(int)
    of_follower = np.floor(((instants - phase) % 1.0) * states).astype(int)
    share = np.zeros((states, states))
    np.add.at(share, (of_leader, of_follower), 1.0 / instants.size)
    assert phase_weights(phase, states) == pytest.approx(share, abs=2e-5)


@repeatable
@given(phases, numbers_of_states)
def test_only_the_phase_within_a_wingbeat_counts(phase, states):
    assert phase_weights(phase + 1.0, states) == pytest.approx(phase_weights(phase, states), abs=1e-14)


@repeatable
@given(phases)
def test_phases_kappa_and_one_less_kappa_are_the_same_with_two_states(phase):
    assert phase_weights(1.0 - phase) == pytest.approx(phase_weights(phase), abs=1e-14)


@repeatable
@given(phases, numbers_of_states)
def test_leading_by_a_phase_swaps_the_birds(phase, states):
    assert phase_weights(-phase, states) == pytest.approx(phase_weights(phase, states).T, abs=1e-14)


@repeatable
@given(numbers_of_states, st.integers(0, 8), st.floats(0.0, 1.0))
def test_within_a_piece_the_weights_are_linear_in_phase(states, piece, share):
    piece %= states
    steady, sliding = phase_piece(piece, states)
    t = share / states
    assert steady + sliding * t == pytest.approx(phase_weights(piece / states + t, states), abs=1e-13)


@repeatable
@given(st.floats(0.0, 0.5))
def test_with_two_states_the_second_piece_is_linear_in_the_distance_from_antiphase(mu):
    steady, sliding = phase_piece(1)
    for phase in (0.5 + mu, 0.5 - mu):
        assert steady + sliding * mu == pytest.approx(phase_weights(phase), abs=1e-15)


@pytest.mark.parametrize("states", [3, 4])
def test_the_weights_have_kinks_at_the_ends_of_pieces_and_there_alone(states):
    step = 1e-3
    for phase, kinked in ((1 / states, True), (1.5 / states, False)):
        before, here, after = (phase_weights(phase + offset, states) for offset in (-step, 0.0, step))
        assert (abs(after - 2 * here + before).max() > step) == kinked
