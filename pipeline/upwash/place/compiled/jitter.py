"""What a bird feels on average while its place jitters and its stroke is held: compiled."""

from __future__ import annotations

import numpy as np

from upwash.kernel import kernel
from upwash.place.compiled.felt import BY_AMPLITUDE, BY_RATIO, look, settle

MOST_STEPS = 40

BALANCED = 1e-12
"""Mean imbalance of lift over weight and of thrust over drag at which a stroke is said to balance."""

LONGEST = 0.2
"""Longest step of Newton's method, in semispans or as a ratio."""


@kernel
def look_on_average(place, draws, amplitude, ratio, felt, room, balance, slopes):
    """Average what is in excess of weight and drag over places, with one stroke.

    Parameters
    ----------
    place : (4,) ndarray of float
        The middle, relative to the bird ahead, in semispans, with the lag.
    draws : (m, 4) ndarray of float
        What is added to it.
    amplitude, ratio : float
        The stroke, in semispans and as a ratio.
    felt : Felt
        The wake.
    room : Room
        Scratch behind one bird.
    balance : (2,) ndarray of float
        Overwritten: mean excess of lift and of thrust, in weights.
    slopes : (2, 6) ndarray of float
        Overwritten: its slopes.
    """
    moved = np.empty((1, 4))
    balance[:] = 0.0
    slopes[:] = 0.0
    for k in range(draws.shape[0]):
        for i in range(4):
            moved[0, i] = place[i] + draws[k, i]
        settle(moved, felt, room)
        look(amplitude, ratio, felt, room)
        for c in range(2):
            balance[c] += room.balance[c]
            for i in range(6):
                slopes[c, i] += room.slopes[c, i]
    balance /= draws.shape[0]
    slopes /= draws.shape[0]


@kernel
def balance_on_average(place, draws, stroke, felt, room, balance, slopes):
    """Move a stroke to one that balances in the mean, by Newton's method; return whether it was reached.

    Parameters
    ----------
    place, draws, felt, room, balance, slopes
        As for `look_on_average`.
    stroke : (2,) ndarray of float
        Amplitude and ratio; overwritten.
    """
    for _ in range(MOST_STEPS):
        look_on_average(place, draws, stroke[0], stroke[1], felt, room, balance, slopes)
        lift, thrust = balance[0], balance[1]
        if abs(lift) < BALANCED and abs(thrust) < BALANCED * felt.own.drag:
            return True
        a, b = slopes[0, BY_AMPLITUDE], slopes[0, BY_RATIO]
        c, d = slopes[1, BY_AMPLITUDE], slopes[1, BY_RATIO]
        size = a * d - b * c
        if size == 0.0:
            return False
        by_amplitude, by_ratio = (b * thrust - d * lift) / size, (c * lift - a * thrust) / size
        shorter = min(1.0, LONGEST / max(abs(by_amplitude), abs(by_ratio), 1e-300))
        stroke[0] += shorter * by_amplitude
        stroke[1] += shorter * by_ratio
        if not (0.0 < stroke[0] < 3.0 and -0.5 < stroke[1] < 1.5):
            return False
    return False
