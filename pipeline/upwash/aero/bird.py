"""A lone flapping bird: what its wake carries, what it weighs, the drag it must overcome, the force it makes.

The bird is the paper's: its wake is a chain of ellipses (downstroke) and rectangles (upstroke) whose impulse,
divided by the wingbeat period, is the time-averaged force.  Circulation follows from weight support and drag
from the thrust that then results; both are properties of the bird, not inputs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from upwash.aero.checked import REACH, WrongInput, at_most, check_fields, must_be, not_negative, ratio
from upwash.aero.pose import Stroke

_SOME = must_be(REACH)
_SHARE = must_be(ratio & REACH)


_UPSTROKE = not_negative & at_most(1e9, "a bird's upstroke carries little more than its downstroke")


@dataclass(frozen=True)
class Bird:
    """One bird in its environment, in SI units.

    Parameters
    ----------
    mass_kg : float
        Body mass, in kg.
    semispan_m : float
        Half the wingspan of the outstretched wings, b, in m.
    speed_m_s : float
        Airspeed, U, in m/s.
    period_s : float
        Wingbeat period, T, in s.
    density_kg_m3 : float
        Density of the air, in kg/m³.
    gravity_m_s2 : float
        Gravitational acceleration, in m/s².
    amplitude_m : float
        Tip-to-tip flapping amplitude when flying alone, h, in m.
    upstroke_span_ratio : float
        Projected span on the upstroke over that on the downstroke when flying alone, R, in (0, 1).
    circulation_ratio : float, optional
        Circulation of the upstroke wake over that of the downstroke wake; the paper takes 1, and with 0 an upstroke
        leaves nothing.

    Raises
    ------
    ValueError
        If a value is not of the kind named above; the message names the field, what was expected and what was found.

    Examples
    --------
    >>> ibis = Bird(1.3, 0.6, 15.0, 0.25, 1.29, 9.8, amplitude_m=1.04, upstroke_span_ratio=0.4)
    >>> round(ibis.weight_n, 2), round(ibis.drag_n, 2)
    (12.74, 2.3)
    >>> ibis.stroke
    Stroke(amplitude_m=1.04, span_ratio=0.4)
    """

    mass_kg: float = field(metadata=_SOME)
    semispan_m: float = field(metadata=_SOME)
    speed_m_s: float = field(metadata=_SOME)
    period_s: float = field(metadata=_SOME)
    density_kg_m3: float = field(metadata=_SOME)
    gravity_m_s2: float = field(metadata=_SOME)
    amplitude_m: float = field(metadata=_SOME)
    upstroke_span_ratio: float = field(metadata=_SHARE)
    circulation_ratio: float = field(default=1.0, metadata=must_be(_UPSTROKE))

    def __post_init__(self) -> None:
        check_fields(self)
        if self.amplitude_m > 2.0 * self.semispan_m:
            expected = f"at most twice the semispan ({2.0 * self.semispan_m:g} m, a half-angle of 90°)"
            raise WrongInput("amplitude_m", expected, float(f"{self.amplitude_m:g}"))
        if not self.drag_n > 0.0:
            found = float(f"{self.circulation_ratio * self.upstroke_span_ratio:.3g}")
            expected = "a lone bird that makes thrust, circulation_ratio · R < π/4 = 0.785"
            raise WrongInput("upstroke_span_ratio", expected, found)

    @property
    def stroke(self) -> Stroke:
        """How it flaps when flying alone."""
        return Stroke(self.amplitude_m, self.upstroke_span_ratio)

    @property
    def wavelength_m(self) -> float:
        """Length of one wingbeat's wake, λ = U T, in m."""
        return self.speed_m_s * self.period_s

    @property
    def weight_n(self) -> float:
        """Weight W = M g, in N."""
        return self.mass_kg * self.gravity_m_s2

    @property
    def circulation_m2_s(self) -> float:
        """Circulation of the downstroke wake, in m²/s, from weight support (eq:gamma_sol)."""
        return self.weight_n / (
            self.density_kg_m3 * self.semispan_m * self.speed_m_s * self.lift_span(self.upstroke_span_ratio)
        )

    @property
    def drag_n(self) -> float:
        """Drag to be overcome, in N: the thrust of the lone bird."""
        return self.thrust_n(self.amplitude_m, self.upstroke_span_ratio)

    def lift_span(self, upstroke_span_ratio: float) -> float:
        """Span that carries lift, in semispans and weighted by circulation: π/4 of downstroke, R of upstroke."""
        return math.pi / 4.0 + self.circulation_ratio * upstroke_span_ratio

    def thrust_span(self, upstroke_span_ratio: float) -> float:
        """Span that carries thrust, in semispans, by circulation: π/2 of downstroke less 2 R of upstroke."""
        return math.pi / 2.0 - 2.0 * self.circulation_ratio * upstroke_span_ratio

    def vertical_impulse_n_s(self, upstroke_span_ratio: float) -> float:
        """Vertical impulse of one wingbeat's wake, in N s (leader_vert_imp)."""
        return (
            self.density_kg_m3
            * self.semispan_m
            * self.wavelength_m
            * self.circulation_m2_s
            * self.lift_span(upstroke_span_ratio)
        )

    def horizontal_impulse_n_s(self, amplitude_m: float, upstroke_span_ratio: float) -> float:
        """Upstream impulse of one wingbeat's wake, in N s (leader_hor_force)."""
        return (
            self.density_kg_m3
            * self.semispan_m
            * amplitude_m
            * self.circulation_m2_s
            * self.thrust_span(upstroke_span_ratio)
        )

    def self_force_n(self, stroke: Stroke) -> tuple[float, float]:
        """Self-generated lift and thrust (positive upstream) with a stroke, averaged over a wingbeat, in N."""
        return self.lift_n(stroke.span_ratio), self.thrust_n(stroke.amplitude_m, stroke.span_ratio)

    def lift_n(self, upstroke_span_ratio: float) -> float:
        """Self-generated lift, averaged over a wingbeat, in N (leader_vert_force)."""
        return self.vertical_impulse_n_s(upstroke_span_ratio) / self.period_s

    def thrust_n(self, amplitude_m: float, upstroke_span_ratio: float) -> float:
        """Self-generated thrust, averaged over a wingbeat, in N; positive upstream."""
        return self.horizontal_impulse_n_s(amplitude_m, upstroke_span_ratio) / self.period_s
