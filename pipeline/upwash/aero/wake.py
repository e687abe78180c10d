"""The vortex wake of a leader: closed rings of straight filaments, in each stroke state.

One wingbeat leaves two rectangles, one of the upstroke and one of the downstroke, half a wavelength long and tilted:
the upstroke's falls downstream, the downstroke's rises.  Each is a closed loop (starting vortex, right tip, stopping
vortex, left tip), so its four signed filaments carry one circulation, right-handed about the loop.  While a stroke
state lasts the pattern stands still; between states it is carried downstream.

Frame: origin at the leader's reference point, x downstream, y to the right, z up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from upwash.aero.checked import check_fields, must_be, positive, whole_from, within

ROLL_UP = math.pi / 4.0
"""Half-distance of the rolled-up tip vortices over the wing's half-span (Hummel 1983)."""

CORE_RADIUS_RATIO = 0.171
"""Radius of a vortex core over the semispan (Young 2003)."""

_CORE = positive & within(
    1e-3, 1.0, "in semispans: a core is thicker than a line and thinner than a wing is long"
)
_FINENESS = whole_from(2, 1000, "the wake's force has long converged, and more only takes time")
_LENGTH = whole_from(1, 1000, "so far back a wake is no longer felt, and more only takes time")


@dataclass(frozen=True)
class WakeModel:
    """How finely a wake and its action on a follower are resolved.

    The defaults are the paper's.

    Parameters
    ----------
    core_radius_ratio : float
        Radius of the Rankine core over the semispan.
    stroke_states : int
        Number N of states in which leader and follower are each held during a wingbeat, at least 2.
    span_nodes : int
        Number of points across the follower's span at which the wake's velocity is taken, at least 2.
    wavelengths : int
        Length of a wake, in wavelengths, at least 1: further downstream the frozen pattern repeats itself.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.

    Examples
    --------
    >>> WakeModel(stroke_states=32, span_nodes=41).core_radius_ratio
    0.171
    """

    core_radius_ratio: float = field(default=CORE_RADIUS_RATIO, metadata=must_be(_CORE))
    stroke_states: int = field(default=2, metadata=must_be(_FINENESS))
    span_nodes: int = field(default=2, metadata=must_be(_FINENESS))
    wavelengths: int = field(default=1, metadata=must_be(_LENGTH))

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Wake:
    """The vortex rings of a leader in each of its stroke states.

    Attributes
    ----------
    rings : (n, 6) ndarray of float
        Each ring as a tilted rectangle, in m: x of its starting and of its stopping vortex, z of the two, y of its
        centreline, half its width.
    circulation : (n,) ndarray of float
        Circulation of each ring in m²/s, right-handed about the loop: the starting and the right tip filaments are
        then positive along +y and +x, the stopping and the left tip filaments negative.
    state : (n,) ndarray of int
        Stroke state to which the ring belongs.
    is_upstroke : (n,) ndarray of bool
        Whether the ring was shed on an upstroke.
    """

    rings: NDArray[np.float64]
    circulation: NDArray[np.float64]
    state: NDArray[np.int64]
    is_upstroke: NDArray[np.bool_]

    def corners(self) -> NDArray[np.float64]:
        """Corners of each ring in the order of its loop, in m.

        Returns
        -------
        (n, 4, 3) ndarray of float
            Left and right end of the starting vortex, right and left end of the stopping vortex; filament k of a ring
            runs from its corner k to the next.
        """
        first_x, last_x, first_z, last_z, centre_y, half_width = self.rings.T
        left, right = centre_y - half_width, centre_y + half_width
        return np.stack(
            [
                np.stack([first_x, left, first_z], axis=-1),
                np.stack([first_x, right, first_z], axis=-1),
                np.stack([last_x, right, last_z], axis=-1),
                np.stack([last_x, left, last_z], axis=-1),
            ],
            axis=1,
        )


def stroke_height(phase: float) -> float:
    """Height of the wingtip over the tip-to-tip amplitude, ½ at the end of the upstroke (phase 0), −½ at phase ½.

    The tip moves at constant speed between its two ends, as the straight filaments of the wake imply.
    """
    return 2.0 * abs((phase % 1.0) - 0.5) - 0.5


def stroke_span(phase: float) -> tuple[float, float]:
    """Half-span in semispans as (a, c) of a + c R: R at the end of the upstroke, 1 at the end of the downstroke.

    Between the two the span changes in step with the height of the tip.
    """
    raised = stroke_height(phase) + 0.5
    return 1.0 - raised, raised


def vortex_wake(
    amplitude: float,
    upstroke_span_ratio: float,
    semispan: float,
    wavelength: float,
    circulation: float,
    circulation_ratio: float = 1.0,
    stroke_states: int = 2,
    wavelengths: int = 1,
) -> Wake:
    """Return the vortex rings behind a leader in each stroke state.

    State j shows the pattern of phase j/N: the frozen chain of rectangles, carried j λ/N downstream of where the end
    of the upstroke left it, and cut at the leader and one wavelength behind.  With two states nothing is cut and the
    rings are the paper's eight filaments in its "up" (j = 0) and "down" (j = 1) configurations.

    Parameters
    ----------
    amplitude, semispan, wavelength : float
        Tip-to-tip flapping amplitude, semispan and wavelength in m (or all in one other unit of length).
    upstroke_span_ratio : float
        The leader's upstroke span ratio.
    circulation : float
        Circulation of the downstroke rings in m²/s.
    circulation_ratio : float
        Circulation of the upstroke rings over that of the downstroke rings.
    stroke_states : int
        Number of stroke states.
    wavelengths : int
        Length of the wake.

    Returns
    -------
    Wake
        Ring by ring: wavelength by wavelength, in each ordered by state and then downstream.
    """
    half = 0.5 * wavelength
    rings, strengths, states, upstroke = [], [], [], []
    for state in range(stroke_states):
        shift = wavelength * state / stroke_states
        # Rectangle k starts at shift + k λ/2 and is an upstroke's when k is even; height is linear within it.
        for k in (-2, -1, 0, 1):
            first, last = max(shift + k * half, 0.0), min(shift + (k + 1) * half, wavelength)
            if last - first <= 1e-12 * wavelength:
                continue
            is_up = k % 2 == 0
            half_width = ROLL_UP * semispan * (upstroke_span_ratio if is_up else 1.0)
            z = [amplitude * stroke_height((x - shift) / wavelength) for x in (first, last)]
            rings.append([first, last, *z, 0.0, half_width])
            strengths.append(circulation * (circulation_ratio if is_up else 1.0))
            states.append(state)
            upstroke.append(is_up)
    shifts = wavelength * np.arange(wavelengths)[:, None, None]
    return Wake(
        (np.array(rings) + shifts * [1.0, 1.0, 0.0, 0.0, 0.0, 0.0]).reshape(-1, 6),
        np.tile(strengths, wavelengths),
        np.tile(states, wavelengths),
        np.tile(upstroke, wavelengths),
    )


def spanwise_spacing_rule(semispan: float, upstroke_span_ratio: float) -> float:
    """Spanwise offset at which the follower's tips average onto the tip vortices (optimal_spanwise_dist).

    Parameters
    ----------
    semispan : float
        Semispan b, in m.
    upstroke_span_ratio : float
        The follower's upstroke span ratio.

    Returns
    -------
    float
        Offset y_F − y_L, in m.
    """
    return 0.5 * (2.0 * ROLL_UP + 1.0 + upstroke_span_ratio) * semispan
