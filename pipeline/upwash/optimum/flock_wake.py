"""The wakes of a flock: what a bird feels of every bird ahead of it.

Each bird ahead sheds the paper's wake, in its own phase and for as many wavelengths as are asked for; the
velocities add up.  The follower's problem is the pair's with more vortex rings, so it is searched and proved
by the same means.  Only its phase is less simple: the weights of each bird ahead have kinks where the
follower is in phase or in antiphase with it, and the problem is posed once between each two kinks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.interaction import phase_weights, wake_force
from upwash.aero.wake import Wake, WakeModel, vortex_wake
from upwash.optimum.problem import PairProblem

SAME_PHASE = 1e-12
"""Phases closer than this are one."""


@dataclass(frozen=True)
class Place:
    """Where and how a bird of a flock flies.

    Parameters
    ----------
    row : int
        How many birds of its own line fly ahead of it, 0 for the first bird.
    x_m, y_m, z_m : float
        Its reference point relative to that of the first bird, in m: downstream, right, up.
    amplitude_m, upstroke_span_ratio : float
        Its stroke.
    phase : float
        Its lag behind the first bird, in wingbeats.
    """

    row: int
    x_m: float
    y_m: float
    z_m: float
    amplitude_m: float
    upstroke_span_ratio: float
    phase: float

    def mirrored(self) -> Place:
        """Return the place on the other side of the first bird."""
        return replace(self, y_m=0.0 - self.y_m)


@dataclass(frozen=True)
class FlockProblem(PairProblem):
    """One follower behind many birds; positions and phase are relative to the bird it follows.

    Parameters
    ----------
    ahead : tuple of Place
        Every bird whose wake is felt; the last is the one that is followed.
    wavelengths : int
        Length of each wake.
    phase_start, phase_end : float
        Phases between two kinks, relative to the bird that is followed.
    is_symmetric : bool
        Whether phases φ and −φ are the same solution, as when all birds ahead are in phase or in antiphase;
        the piece from ½ to 1 then stands for all phases.
    """

    ahead: tuple[Place, ...] = ()
    wavelengths: int = 1
    phase_start: float = 0.5
    phase_end: float = 1.0
    is_symmetric: bool = False

    def phase(self, coordinate: float) -> float:
        """Phase in [0, 1) at a phase coordinate; in a symmetric problem the lesser of the two equal ones."""
        if self.is_symmetric:
            return 0.5 - coordinate
        return (self.phase_start + coordinate) % 1.0

    def phase_span(self) -> float:
        """Greatest phase coordinate."""
        return self.phase_end - self.phase_start

    def phase_ramp(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Phase weights of the states of every bird ahead, one after the other."""
        states = self.model.stroke_states
        lags = [one.phase - self.ahead[-1].phase for one in self.ahead]
        start = np.concatenate([phase_weights(self.phase_start - lag, states) for lag in lags])
        end = np.concatenate([phase_weights(self.phase_end - lag, states) for lag in lags])
        return start, (end - start) / self.phase_span()

    def wake(self) -> Wake:
        """Rings of every bird ahead, bird by bird; their states are numbered on from bird to bird."""
        return superposed_wake(self.bird, self.ahead, self.wavelengths, self.model)

    def ring_name(self, ring: int) -> str:
        """Name a ring of `wake`, and where the bird that shed it flies."""
        wake = self.wake()
        number, state = divmod(int(wake.state[ring]), self.model.stroke_states)
        stroke = "upstroke" if wake.is_upstroke[ring] else "downstroke"
        shed_by = "leader" if number == len(self.ahead) - 1 else f"bird of row {self.ahead[number].row}"
        return f"{stroke} ring ({shed_by} {('up', 'down')[state]})"

    def wake_force_n(
        self, position_m: tuple[float, float, float], amplitude_m: float, span_ratio: float, phase: float
    ) -> tuple[float, float]:
        """Lift and thrust of all wakes on the follower, in N, by the plain statement of the model."""
        last, lift, thrust = self.ahead[-1], 0.0, 0.0
        x, y, z = position_m
        for one in self.ahead:
            for repeat in range(self.wavelengths):
                # A wake that is shifted downstream acts as on a follower that is as much further upstream.
                shift = last.x_m - one.x_m - repeat * self.bird.wavelength_m
                force = wake_force(
                    self.bird,
                    one.amplitude_m,
                    one.upstroke_span_ratio,
                    (x + shift, y + last.y_m - one.y_m, z + last.z_m - one.z_m),
                    amplitude_m,
                    span_ratio,
                    phase + last.phase - one.phase,
                    self.model,
                )
                lift, thrust = lift + force[0], thrust + force[1]
        return lift, thrust


def superposed_wake(bird: Bird, ahead: Sequence[Place], wavelengths: int, model: WakeModel) -> Wake:
    """Return the rings of several birds, in semispans and relative to the last of them.

    Parameters
    ----------
    bird : Bird
        The bird that sets circulation, semispan and wavelength.
    ahead : sequence of Place
        Where the birds fly, and how they flap.
    wavelengths : int
        Length of each wake: further downstream the frozen pattern repeats itself.
    model : WakeModel
        Resolution.

    Returns
    -------
    Wake
        Bird by bird; the states of the second are numbered on from those of the first, and so forth.
    """
    b, last = bird.semispan_m, ahead[-1]
    wavelength, states = bird.wavelength_m / b, model.stroke_states
    rings, circulation, state, is_upstroke = [], [], [], []
    for number, one in enumerate(ahead):
        wake = vortex_wake(
            one.amplitude_m / b,
            one.upstroke_span_ratio,
            1.0,
            wavelength,
            bird.circulation_m2_s / b,
            bird.circulation_ratio,
            states,
        )
        x, y, z = (one.x_m - last.x_m) / b, (one.y_m - last.y_m) / b, (one.z_m - last.z_m) / b
        for repeat in range(wavelengths):
            shift = x + repeat * wavelength
            rings.append(wake.rings + np.array([shift, shift, z, z, y, 0.0]))
            circulation.append(wake.circulation)
            state.append(wake.state + number * states)
            is_upstroke.append(wake.is_upstroke)
    return Wake(*(np.concatenate(parts) for parts in (rings, circulation, state, is_upstroke)))


def flock_problems(ahead: tuple[Place, ...], wavelengths: int, **pair: Any) -> list[FlockProblem]:
    """Pose a follower's problem once for each piece of its phase.

    Parameters
    ----------
    ahead : tuple of Place
        Every bird whose wake is felt; the last is the one that is followed.
    wavelengths : int
        Length of each wake.
    **pair
        Bird, objective, amplitude limit and model, as for `upwash.optimum.problem.PairProblem`.

    Returns
    -------
    list of FlockProblem
        In the order of phase, all around the wingbeat; a single one if the flock's phases are symmetric.
    """
    last = ahead[-1]
    lags = [(one.phase - last.phase) % 0.5 for one in ahead]
    # Each bird's weights have kinks half a wingbeat apart.
    kinks: list[float] = []
    for lag in sorted(0.0 if 0.5 - lag <= SAME_PHASE else lag for lag in lags):
        if not kinks or lag - kinks[-1] > SAME_PHASE:
            kinks.append(lag)
    shared: dict[str, Any] = pair | {
        "leader_amplitude_m": last.amplitude_m,
        "leader_upstroke_span_ratio": last.upstroke_span_ratio,
        "ahead": ahead,
        "wavelengths": wavelengths,
    }
    if len(kinks) == 1:
        return [FlockProblem(**shared, is_symmetric=True)]
    starts = [*kinks, *(kink + 0.5 for kink in kinks)]
    return [
        FlockProblem(**shared, phase_start=start, phase_end=end)
        for start, end in zip(starts, [*starts[1:], kinks[0] + 1.0], strict=True)
    ]
