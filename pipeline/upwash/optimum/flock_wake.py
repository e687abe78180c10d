"""The wakes of a flock: what a bird feels of every bird ahead of it.

Each bird ahead sheds its wake in its own phase, and the velocities add up.  The follower's problem is the pair's with
more vortex rings, so it is searched and proved by the same means.  Only its phase is less simple: the weights of each
bird ahead have kinks where the follower is in phase or in antiphase with it, and the problem is posed once between each
two kinks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import PHASE
from upwash.aero.interaction import mean_phase_weights, phase_weights
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import Wake, WakeModel, vortex_wake
from upwash.optimum.problem import PairProblem, least_turn
from upwash.optimum.settings import FlockRules
from upwash.optimum.spacing import FREE, Spacing

SAME_PHASE = 1e-12
"""Phases closer than this are one."""


@dataclass(frozen=True)
class Place:
    """Where and how a bird of a flock flies.

    Parameters
    ----------
    row : int
        How many birds of its own line fly ahead of it, 0 for the first bird.
    pose : Pose
        Where it flies relative to the first bird, how it flaps, and its lag behind the first bird.
    bird : Bird or None
        The bird, as it flies alone but for its period; like the one that feels its wake if None.
    """

    row: int
    pose: Pose
    bird: Bird | None = None

    def mirrored(self) -> Place:
        """Return the place on the other side of the first bird."""
        return replace(self, pose=self.pose.mirrored())


@dataclass(frozen=True)
class FlockProblem(PairProblem):
    """One follower behind many birds; positions and phase are relative to the bird it follows.

    Parameters
    ----------
    places : tuple of Place
        Every bird whose wake is felt; the last is the one that is followed.
    phase_start, phase_end : float
        Phases between two kinks, relative to the bird that is followed.
    is_symmetric : bool
        Whether phases φ and −φ are the same solution, as when all birds ahead are in phase or in antiphase;
        the piece from ½ to 1 then stands for all phases.
    """

    places: tuple[Place, ...] = ()
    phase_start: float = 0.5
    phase_end: float = 1.0
    is_symmetric: bool = False

    @property
    def is_mirrored_in_phase(self) -> bool:
        """Whether the ends of the phase coordinate are planes of symmetry."""
        return self.phase_lock and self.is_symmetric

    def mirrors(self, variable: int, side: int) -> bool:
        """Whether a bound, the lower (0) or the upper (1), is a plane of symmetry: birds further ahead stand aside."""
        return super().mirrors(variable, side) and (variable == PHASE or len(self.places) == 1)

    def phase(self, coordinate: float) -> float:
        """Phase in [0, 1) at a phase coordinate; in a symmetric problem the lesser of the two equal ones."""
        if not self.phase_lock:
            return super().phase(coordinate)
        if self.is_symmetric:
            return 0.5 - coordinate
        return (self.phase_start + coordinate) % 1.0

    def coordinate(self, phase: float) -> float:
        """Phase coordinate of a phase in [0, 1); outside 0 to `phase_span` if the phase is not in this piece."""
        if not self.phase_lock:
            return super().coordinate(phase)
        if self.is_symmetric:
            return 0.5 - phase
        return least_turn(phase - self.phase_start)

    def phase_span(self) -> float:
        """Greatest phase coordinate."""
        return self.phase_end - self.phase_start if self.phase_lock else 0.0

    def phase_ramp(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Phase weights of the states of every bird ahead, one after the other."""
        states = self.model.stroke_states
        if not self.phase_lock:
            mean = np.tile(mean_phase_weights(states), (len(self.places), 1))
            return mean, np.zeros_like(mean)
        lags = [one.pose.phase - self.places[-1].pose.phase for one in self.places]
        start = np.concatenate([phase_weights(self.phase_start - lag, states) for lag in lags])
        end = np.concatenate([phase_weights(self.phase_end - lag, states) for lag in lags])
        return start, (end - start) / self.phase_span()

    def wake(self) -> Wake:
        """Rings of every bird ahead, bird by bird; their states are numbered on from bird to bird."""
        return superposed_wake(self.bird, self.places, self.model)

    def ring_parts(self, ring: int) -> tuple[str, ...]:
        """Say of a ring of `wake` by which stroke and in which state it was shed, and by a bird of which row."""
        wake = self.wake()
        number, state = divmod(int(wake.state[ring]), self.model.stroke_states)
        stroke = "upstroke" if wake.is_upstroke[ring] else "downstroke"
        row = "" if number == len(self.places) - 1 else str(self.places[number].row)
        return stroke, ("up", "down")[state], row

    def others(self, pose: Pose) -> list[tuple[Stroke, Pose, Bird]]:
        """Of each bird other than the one ahead whose wake is felt: how it flaps, a pose relative to it, the bird."""
        own = pose.behind(self.places[-1].pose)
        return [
            (one.pose.stroke, own.relative_to(one.pose), one.bird or self.bird) for one in self.places[:-1]
        ]


def amplitude_limit(bird: Bird, ahead: Stroke, leader: Bird, rules: FlockRules) -> float:
    """Return the largest amplitude of a follower, in m: of its own, the share that the bird ahead has of its own.

    Parameters
    ----------
    bird : Bird
        The follower.
    ahead : Stroke
        How the bird that it follows flaps.
    leader : Bird
        That bird.
    rules : FlockRules
        By the reading ``lone`` the follower's own amplitude is the limit.
    """
    if rules.reading == "lone":
        return bird.amplitude_m
    return ahead.amplitude_m * (bird.amplitude_m / leader.amplitude_m)


def superposed_wake(bird: Bird, places: Sequence[Place], model: WakeModel) -> Wake:
    """Return the rings of several birds, in semispans and relative to the last of them.

    Parameters
    ----------
    bird : Bird
        The follower, in whose semispans the rings are told.
    places : sequence of Place
        Where the birds fly, and how they flap.
    model : WakeModel
        Resolution.

    Returns
    -------
    Wake
        Bird by bird; the states of the second are numbered on from those of the first, and so forth.
    """
    b, last, states = bird.semispan_m, places[-1].pose, model.stroke_states
    rings, circulation, state, is_upstroke, core_radius = [], [], [], [], []
    for number, one in enumerate(places):
        shed = one.bird or bird
        wake = vortex_wake(
            one.pose.stroke.amplitude_m / b,
            one.pose.stroke.span_ratio,
            shed.semispan_m / b,
            shed.wavelength_m / b,
            shed.circulation_m2_s / b,
            shed.circulation_ratio,
            model,
        )
        x, y, z = (apart / b for apart in one.pose.relative_to(last).position_m)
        rings.append(wake.rings + np.array([x, x, z, z, y, 0.0]))
        circulation.append(wake.circulation)
        state.append(wake.state + number * states)
        is_upstroke.append(wake.is_upstroke)
        core_radius.append(wake.core_radius)
    parts = rings, circulation, state, is_upstroke, core_radius
    return Wake(*(np.concatenate(part) for part in parts))


def flock_problems(
    bird: Bird,
    objective: str,
    places: tuple[Place, ...],
    amplitude_limit_m: float,
    model: WakeModel,
    phase_lock: bool = True,
    spacing: Spacing = FREE,
) -> list[FlockProblem]:
    """Pose a follower's problem once for each piece of its phase.

    Parameters
    ----------
    bird, objective, amplitude_limit_m, model, phase_lock, spacing
        As for `upwash.optimum.problem.PairProblem`.
    places : tuple of Place
        Every bird whose wake is felt; the last is the one that is followed.

    Returns
    -------
    list of FlockProblem
        In the order of phase, all around the wingbeat; a single one if the flock's phases are symmetric.
    """
    last = places[-1].pose
    lags = [(one.pose.phase - last.phase) % 0.5 for one in places]
    # Each bird's weights have kinks half a wingbeat apart.
    kinks: list[float] = []
    for lag in sorted(0.0 if 0.5 - lag <= SAME_PHASE else lag for lag in lags):
        if not kinks or lag - kinks[-1] > SAME_PHASE:
            kinks.append(lag)
    whole = FlockProblem(
        bird,
        objective,
        last.stroke,
        amplitude_limit_m,
        model,
        leader=places[-1].bird or bird,
        phase_lock=phase_lock,
        places=places,
        is_symmetric=True,
        spacing=spacing,
    )
    if len(kinks) == 1 or not phase_lock:
        return [whole]
    starts = [*kinks, *(kink + 0.5 for kink in kinks)]
    return [
        replace(whole, is_symmetric=False, phase_start=start, phase_end=end)
        for start, end in zip(starts, [*starts[1:], kinks[0] + 1.0], strict=True)
    ]
