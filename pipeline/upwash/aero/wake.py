"""The vortex wake of a leader: closed rings of straight filaments, in each stroke state.

One wingbeat leaves two rectangles, one of the upstroke and one of the downstroke, half a wavelength long and tilted:
the upstroke's falls downstream, the downstroke's rises.  Each is a closed loop (starting vortex, right tip, stopping
vortex, left tip), so its four signed filaments carry one circulation, right-handed about the loop.  While a stroke
state lasts the pattern stands still; between states it is carried downstream.

Frame: origin at the leader's reference point, x downstream, y to the right, z up.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import NDArray

from upwash.aero.checked import (
    Rule,
    WrongInput,
    check_fields,
    must_be,
    one_of,
    positive,
    whole_from,
    within,
)

ROLL_UP = math.pi / 4.0
"""Half-distance of the rolled-up tip vortices over the wing's half-span (Hummel 1983)."""

CORE_RADIUS_RATIO = 0.171
"""Radius of a vortex core over the semispan (Young 2003)."""

_CORE = positive & within(
    1e-3, 1.0, "in semispans: a core is thicker than a line and thinner than a wing is long"
)
STEP_IN_CORES = 1.2
"""How far a step of the wingbeat may carry the wing along an endless wake, in core radii."""

FINENESS = whole_from(2, 1000, "the wake's force has long converged, and more only takes time")
"""What a number of stroke states or of points across the span must be."""

LENGTH = whole_from(1, 1000, "so far back a wake is no longer felt, and more only takes time")
"""What a number of wavelengths must be."""

GIVEN = "given"
"""What is said of a model that has no name."""

_ENDLESS = Rule("math.inf", lambda value: isinstance(value, float) and value == math.inf)


@dataclass(frozen=True)
class WakeModel:
    """How finely a wake and its action on a follower are resolved, and what is assumed where the paper says nothing.

    The defaults are the paper's.

    Parameters
    ----------
    stroke_states : int
        Number N of states in which a wingbeat is told, at least 2.
    stroke_rule : str
        ``held``: the birds are held in N states that follow one another evenly.  ``gauss``: the time average is
        taken by N/2 Gauss–Legendre points in each half stroke; N must be even.
    span_nodes : int or str
        Number of points across the follower's span at which the wake's velocity is taken, at least 2; ``exact`` for
        the integral over the span, in closed form.
    wavelengths : int or float
        Length of a wake, in wavelengths, at least 1: further downstream the frozen pattern repeats itself.  `math.inf`
        is a wake that repeats itself for ever, upstream as well.
    core : str
        ``rankine`` or ``rosenhead-moore``.
    core_radius_ratio : float
        Radius of the core over the semispan.
    span_law : str
        Half-span and circulation of the follower through its wingbeat: ``tip``, in step with the height of the tip;
        ``stroke``, one value in each half stroke, as the rings that it sheds imply.  At the paper's two states both
        say the same.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.

    Examples
    --------
    >>> WakeModel(stroke_states=32, span_nodes=41).core_radius_ratio
    0.171
    >>> WakeModel.named("limit").span_nodes
    'exact'
    >>> WakeModel(stroke_states=4).wavelengths
    1
    """

    stroke_states: int = field(default=2, metadata=must_be(FINENESS))
    stroke_rule: str = field(default="held", metadata=must_be(one_of(["held", "gauss"])))
    span_nodes: int | str = field(default=2, metadata=must_be(one_of(["exact"]) | FINENESS))
    wavelengths: int | float = field(default=1, metadata=must_be(_ENDLESS | LENGTH))
    core: str = field(default="rankine", metadata=must_be(one_of(["rankine", "rosenhead-moore"])))
    core_radius_ratio: float = field(default=CORE_RADIUS_RATIO, metadata=must_be(_CORE))
    span_law: str = field(default="tip", metadata=must_be(one_of(["stroke", "tip"])))

    def __post_init__(self) -> None:
        check_fields(self)
        if self.stroke_rule == "gauss" and self.stroke_states % 2:
            raise WrongInput(
                "stroke_states", "an even number (half the points of each half stroke)", self.stroke_states
            )

    @classmethod
    def named(cls, name: str) -> WakeModel:
        """Return a model by its name: ``paper``, the defaults, or ``limit``, what the paper's equations converge to.

        Raises
        ------
        ValueError
            If there is no model of that name.
        """
        return _NAMED[one_of(_NAMED)("model", name)]

    def of_points(self) -> WakeModel:
        """Return the model if its wake ends and is felt in points by birds that are held, or raise a ValueError.

        The force of such a model is a weighted sum of velocities at points.
        """
        rules = {
            "stroke_rule": one_of(["held"]),
            "span_nodes": FINENESS,
            "wavelengths": LENGTH,
            "core": one_of(["rankine"]),
        }
        for name, rule in rules.items():
            rule(name, getattr(self, name))
        return self

    def resolving(self, wavelength_ratio: float) -> WakeModel:
        """Return the model with as many steps as a wavelength needs, where its wake is endless.

        While a step carries the wing by no more than 1.2 core radii along the wake, the least power is told to a
        thousandth of what is saved and forces to a hundredth; thin cores and long waves take more steps than the
        model may have.

        Parameters
        ----------
        wavelength_ratio : float
            Wavelength over semispan.

        Examples
        --------
        >>> WakeModel.named("limit").resolving(6.25).stroke_states
        32
        >>> WakeModel.named("limit").resolving(20.0).stroke_states
        98
        """
        needed = self._needed(wavelength_ratio)
        return self if needed <= self.stroke_states else replace(self, stroke_states=needed)

    def _needed(self, wavelength_ratio: float) -> int:
        needed = math.ceil(wavelength_ratio / (STEP_IN_CORES * self.core_radius_ratio))
        return needed + needed % 2 if self.is_endless else 0

    def coarseness(self, wavelength_ratio: float) -> str:
        """Say what it costs that the model has fewer steps than a wavelength needs; "" if it has enough.

        Parameters
        ----------
        wavelength_ratio : float
            Wavelength over semispan.

        Examples
        --------
        >>> WakeModel.named("limit").coarseness(6.25)
        ''
        >>> WakeModel(stroke_states=16, wavelengths=math.inf).coarseness(6.25)[:49]
        'stroke_states: each of 16 steps carries the wing '
        """
        needed = self._needed(wavelength_ratio)
        if needed <= self.stroke_states:
            return ""
        cores = wavelength_ratio / (self.stroke_states * self.core_radius_ratio)
        return (
            f"stroke_states: each of {self.stroke_states} steps carries the wing {cores:.1f} core radii along the "
            f"wake, and forces may be wrong by several per cent; {needed} would tell them to about one"
        )

    def name(self, wavelength_ratio: float) -> str:
        """Return the name of the model, ``given`` if it has none; a named one has the steps that a wavelength needs.

        Parameters
        ----------
        wavelength_ratio : float
            Wavelength over semispan.

        Examples
        --------
        >>> WakeModel().name(6.25), WakeModel(span_nodes=5).name(6.25)
        ('paper', 'given')
        >>> WakeModel.named("limit").resolving(20.0).name(20.0)
        'limit'
        """
        return next((name for name, one in _NAMED.items() if one.resolving(wavelength_ratio) == self), GIVEN)

    @property
    def is_endless(self) -> bool:
        """Whether the wake has no end."""
        return self.wavelengths == math.inf


_NAMED = {
    "paper": WakeModel(),
    "limit": WakeModel(
        stroke_states=32, stroke_rule="gauss", span_nodes="exact", wavelengths=math.inf, span_law="stroke"
    ),
}

NAMES = tuple(_NAMED)
"""The named models."""


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
    core_radius : (n,) ndarray of float
        Radius of the cores of the ring's filaments, in m.
    """

    rings: NDArray[np.float64]
    circulation: NDArray[np.float64]
    state: NDArray[np.int64]
    is_upstroke: NDArray[np.bool_]
    core_radius: NDArray[np.float64]

    def only(self, chosen: NDArray[np.bool_]) -> Wake:
        """Return some of the rings."""
        return Wake(*(getattr(self, each.name)[chosen] for each in fields(self)))

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
    model: WakeModel | None = None,
) -> Wake:
    """Return the vortex rings behind a leader in each stroke state.

    State j shows the pattern of phase j/N: the frozen chain of rectangles, carried j λ/N downstream of where the end
    of the upstroke left it, and cut at the leader and where the wake ends.  With two states nothing is cut and the
    rings of one wavelength are the paper's eight filaments in its "up" (j = 0) and "down" (j = 1) configurations.

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
    model : WakeModel, optional
        Resolution, length and cores; the paper's if not given.

    Returns
    -------
    Wake
        Ring by ring: wavelength by wavelength, in each ordered by state and then downstream.
    """
    model = model or WakeModel()
    shifts = [wavelength * state / model.stroke_states for state in range(model.stroke_states)]
    stroke = amplitude, upstroke_span_ratio
    return _cut_wake(shifts, *stroke, semispan, wavelength, circulation, circulation_ratio, model)


def wake_at_phases(
    phases: Sequence[float],
    amplitude: float,
    upstroke_span_ratio: float,
    semispan: float,
    wavelength: float,
    circulation: float,
    circulation_ratio: float = 1.0,
    model: WakeModel | None = None,
) -> Wake:
    """Return the vortex rings behind a leader at any phases of its wingbeat, in their order as its states.

    Parameters
    ----------
    phases : sequence of float
        Phases of the leader, 0 being the end of its upstroke.
    amplitude, upstroke_span_ratio, semispan, wavelength, circulation, circulation_ratio, model
        As for `vortex_wake`; its stroke states have no say here.
    """
    shifts = [wavelength * (phase % 1.0) for phase in phases]
    stroke = amplitude, upstroke_span_ratio
    return _cut_wake(
        shifts, *stroke, semispan, wavelength, circulation, circulation_ratio, model or WakeModel()
    )


def _cut_wake(
    shifts: Sequence[float],
    amplitude: float,
    upstroke_span_ratio: float,
    semispan: float,
    wavelength: float,
    circulation: float,
    circulation_ratio: float,
    model: WakeModel,
) -> Wake:
    """Return the chain of rectangles carried downstream by each shift, cut at the leader and repeated."""
    if model.is_endless:
        raise ValueError("wavelengths: expected a wake that ends, found inf")
    wavelengths = int(model.wavelengths)
    half = 0.5 * wavelength
    rings, strengths, states, upstroke = [], [], [], []
    for state, shift in enumerate(shifts):
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
    repeats = wavelength * np.arange(wavelengths)[:, None, None]
    return Wake(
        (np.array(rings) + repeats * [1.0, 1.0, 0.0, 0.0, 0.0, 0.0]).reshape(-1, 6),
        np.tile(strengths, wavelengths),
        np.tile(states, wavelengths),
        np.tile(upstroke, wavelengths),
        np.full(wavelengths * len(rings), model.core_radius_ratio * semispan),
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
