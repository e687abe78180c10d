"""A wake that begins at the leader and ends, laid out for the force on a follower's whole span.

The phase κ is taken in pieces between the kinks of the force.  Where the birds are held in N states these are the
kinks of the phase weights, κ = k/N.  Where they are followed through the wingbeat, a step of the follower sees the
leader's cut cross from one run of its wake to the next as it turns, at ψ + κ = 0 and ½: as many kinks as steps.
Between two kinks the force is linear in phase in the first case and smooth in the second.

`upwash.aero.compiled.cut_wake` computes the force; `upwash.aero.interaction` states it plainly.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.cut_wake import AT_END, AT_LEADER, NO_CUT, CutWake
from upwash.aero.compiled.exact_span import Core
from upwash.aero.interaction import mean_phase_weights, phase_piece
from upwash.aero.pose import Stroke
from upwash.aero.wake import ROLL_UP, WakeModel
from upwash.aero.wingbeat import wingbeat_steps

MOST_RUNS = 9
"""Runs of a wake that one part holds at most: the product of many distances has no place in a number."""

SAME_PHASE = 1e-12
"""Phases closer than this are one."""


class Piece(NamedTuple):
    """Phases between two kinks of the force.

    Attributes
    ----------
    start, span : float
        κ = start + t, t from 0 to span.
    """

    start: float
    span: float


class _Run(NamedTuple):
    """One run of a wake: x and z of its two ends, its half stroke, and at which of its ends it is cut."""

    first_x: float
    last_x: float
    first_z: float
    last_z: float
    is_upstroke: bool
    is_cut_first: bool
    is_cut_last: bool


def phase_pieces(model: WakeModel) -> list[Piece]:
    """Return the pieces of phase between the kinks of the force, all around the wingbeat.

    Examples
    --------
    >>> phase_pieces(WakeModel(stroke_states=4))[1]
    Piece(start=0.25, span=0.25)
    >>> [round(piece.start, 4) for piece in phase_pieces(WakeModel(stroke_states=2, stroke_rule="gauss"))]
    [0.25, 0.75]
    """
    if model.stroke_rule == "held":
        count = model.stroke_states
        return [Piece(piece / count, 1.0 / count) for piece in range(count)]
    kinks: list[float] = []
    for kink in sorted(-wingbeat_steps(model).phase % 0.5):
        if not kinks or kink - kinks[-1] > SAME_PHASE:
            kinks.append(float(kink))
    starts = [*kinks, *(kink + 0.5 for kink in kinks)]
    ends = [*starts[1:], starts[0] + 1.0]
    return [Piece(start, end - start) for start, end in zip(starts, ends, strict=True)]


def cut_wake(
    bird: Bird,
    ahead: Stroke,
    model: WakeModel,
    piece: Piece | None,
    unit_n: float = 1.0,
    *,
    leader: Bird | None = None,
) -> CutWake:
    """Lay out a wake that ends, in one piece of phase: lengths in the follower's semispans, forces in a unit.

    Parameters
    ----------
    bird, ahead, model, leader
        As for `upwash.aero.interaction.wake_force`; the wake ends and the span is felt as a whole.
    piece : Piece or None
        Phases, one of `phase_pieces`; None for the mean over all phases.
    unit_n : float
        The unit of force, in N.
    """
    leader = leader or bird
    steps, b, count = wingbeat_steps(model, piece is not None), bird.semispan_m, model.stroke_states
    wavelength, semispan = leader.wavelength_m / b, leader.semispan_m / b
    length = model.wavelengths * wavelength
    is_held = model.stroke_rule == "held"
    # In the follower's own circulation, so that of like birds it is 1.
    circulation = leader.circulation_m2_s / bird.circulation_m2_s
    unit = bird.density_kg_m3 * bird.circulation_m2_s**2 / unit_n
    # Of each part: the follower's step, its weights, and the leader's phase, at t = 0 and in the piece's middle.
    wanted: list[tuple[int, float, float, float, float]] = []
    if is_held:
        steps = wingbeat_steps(model)
        steady, sliding = mean_phase_weights(count), np.zeros((count, count))
        if piece is not None:
            steady, sliding = phase_piece(round(piece.start * count), count)
        for behind, follower in np.ndindex(count, count):
            weights = float(steady[behind, follower]), float(sliding[behind, follower])
            # Half of a rounding is no share of a wingbeat.
            if max(abs(weights[0]), abs(weights[0] + weights[1] / count)) > SAME_PHASE:
                wanted.append((follower, *weights, behind / count, behind / count))
    else:
        begins, span = piece or Piece(0.0, 0.0)
        for follower, weight in enumerate(steps.weight):
            start = float(steps.phase[follower] + steps.lag[follower]) + begins
            wanted.append((follower, float(weight), 0.0, start, start + 0.5 * span))
    per_wind = unit * steps.circulation(bird.circulation_ratio)
    columns, runs, numbers = [], [], []
    for number, (follower, steady_weight, sliding_weight, start, middle) in enumerate(wanted):
        per_wind_here = float(per_wind[follower])
        flexed = float(steps.flexed[follower])
        column = [float(steps.height[follower]), 1.0 - flexed, flexed]
        whole = _runs(start, middle, ahead.amplitude_m / b, wavelength, length)
        for some in np.array_split(np.arange(len(whole)), -(-len(whole) // MOST_RUNS)):
            numbers.append(number)
            is_down = float(steps.is_downstroke[follower])
            columns.append([*column, steady_weight * per_wind_here, sliding_weight * per_wind_here, is_down])
            runs.append([whole[each] for each in some])
    room = max(map(len, runs))
    half, rise = 0.5 * wavelength, ahead.amplitude_m / b
    along = half / math.hypot(half, rise), rise / math.hypot(half, rise)
    wide, strong = ROLL_UP * semispan, circulation / (4.0 * math.pi)
    down, up = (wide, strong), (wide * ahead.span_ratio, strong * leader.circulation_ratio)
    laid, cuts = zip(*(_laid_out(part, room, along, down, up) for part in runs), strict=True)
    core2 = (model.core_radius_ratio * semispan) ** 2
    return CutWake(
        Core(core2, 0.0, 1.0 / core2) if model.core == "rankine" else Core(0.0, core2, 1.0 / core2),
        0.0 if is_held or piece is None else wavelength,
        length,
        np.ascontiguousarray(np.array(columns).T),
        np.array(laid),
        np.array(cuts) if not (is_held or piece is None) else np.full((len(runs), 2), NO_CUT),
        np.array(numbers),
    )


def _runs(start: float, middle: float, amplitude: float, wavelength: float, length: float) -> list[_Run]:
    """Return the runs between the leader and the wake's end, which is as far away as at t = 0.

    Which runs are cut is that of the leader's phase in the middle of a piece; the places are those of its start.
    """
    half, shift = 0.5 * wavelength, wavelength * (middle % 1.0)
    moved = wavelength * (middle - start)
    found = []
    for k in range(-2, math.ceil(length / half) + 1):
        begin, end = shift + k * half, shift + (k + 1) * half
        first, last = max(begin, 0.0), min(end, length)
        if last - first <= SAME_PHASE * wavelength:
            continue
        is_up = k % 2 == 0
        is_cut_first, is_cut_last = first > begin, last < end
        # Where a run turns its height is exact; on it, the slope says it.
        top = 0.5 * amplitude if is_up else -0.5 * amplitude
        rise = -2.0 * top / half
        first = 0.0 if is_cut_first else begin - moved
        last = length if is_cut_last else end - moved
        first_z = top + rise * (first - (begin - moved)) if is_cut_first else top
        last_z = -top - rise * (end - moved - last) if is_cut_last else -top
        found.append(_Run(first, last, first_z, last_z, is_up, is_cut_first, is_cut_last))
    return found


def _laid_out(
    part: list[_Run],
    room: int,
    along: tuple[float, float],
    down: tuple[float, float],
    up: tuple[float, float],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Lay out some runs, the downstrokes' first, and fill the room with runs of no length; say which are cut.

    `along` is the direction of a downstroke's run, `down` and `up` are half-width and circulation of both kinds.
    """
    part = sorted(part, key=lambda run: run.is_upstroke)
    # A run of no length takes nothing and adds nothing.
    nothing = part[-1]._replace(
        first_x=part[-1].last_x, first_z=part[-1].last_z, is_cut_first=False, is_cut_last=False
    )
    filled = [*part, *([nothing] * (room - len(part)))]
    laid, cuts = np.empty((9, room)), np.array([NO_CUT, NO_CUT])
    for number, run in enumerate(filled):
        width, strength = up if run.is_upstroke else down
        laid[:, number] = [
            run.first_x,
            run.last_x,
            run.first_z,
            run.last_z,
            width,
            along[0],
            -along[1] if run.is_upstroke else along[1],
            strength,
            not run.is_upstroke,
        ]
        if run.is_cut_first:
            cuts[AT_LEADER] = number
        if run.is_cut_last:
            cuts[AT_END] = number
    return laid, cuts
