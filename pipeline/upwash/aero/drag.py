"""The drag of a lone bird that glides: of its body and, by friction and by lift, of its wing's profile.

It is what the thrust of a flapping bird must overcome besides the induced drag, which the wake's impulse already holds.
The paper takes another way round: it takes the stroke as known, and the thrust that follows for the drag.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from upwash.aero.atmosphere import viscosity_kg_m_s
from upwash.aero.checked import REACH, check_fields, must_be
from upwash.aero.power import BODY_DRAG_COEFFICIENT, body_area_m2

FRICTION_FACTOR = 2.66
"""Profile drag coefficient without lift, times the square root of the chord's Reynolds number: both sides of a plate in
laminar flow (Klein Heerenbrink et al. 2015 Proc. R. Soc. A 471:20140952; the R package afpt)."""

PROFILE_LIFT_FACTOR = 0.03
"""Profile drag coefficient that comes with lift, over the square of the lift coefficient (afpt's usual value)."""


@dataclass(frozen=True)
class DragPolar:
    """What the drag of a bird follows from, besides the inputs of `upwash.aero.bird.Bird`.

    Parameters
    ----------
    wing_area_m2 : float
        Area of the outstretched wings, S, in m².
    body_drag_coefficient : float
        Drag coefficient of the body on its frontal area, C_Db; the paper's is 1.

    Raises
    ------
    ValueError
        If a value is not positive.

    Examples
    --------
    >>> ibis = DragPolar(wing_area_m2=0.18)
    >>> print(f"{ibis.drag_n(1.3, 0.6, 15.0, 1.29, 9.8):.3f} N")
    1.765 N
    """

    wing_area_m2: float = field(metadata=must_be(REACH))
    body_drag_coefficient: float = field(default=BODY_DRAG_COEFFICIENT, metadata=must_be(REACH))

    def __post_init__(self) -> None:
        check_fields(self)

    def drag_n(
        self,
        mass_kg: float,
        semispan_m: float,
        speed_m_s: float,
        density_kg_m3: float,
        gravity_m_s2: float,
    ) -> float:
        """Drag but for the induced one, in N; the inputs are those of `upwash.aero.bird.Bird`."""
        return sum(self.parts_n(mass_kg, semispan_m, speed_m_s, density_kg_m3, gravity_m_s2))

    def parts_n(
        self,
        mass_kg: float,
        semispan_m: float,
        speed_m_s: float,
        density_kg_m3: float,
        gravity_m_s2: float,
    ) -> tuple[float, float, float]:
        """Drag of the body, of the wing by friction, and of the wing by lift, in N."""
        pressure = 0.5 * density_kg_m3 * speed_m_s**2
        chord = self.wing_area_m2 / (2.0 * semispan_m)
        reynolds = density_kg_m3 * speed_m_s * chord / viscosity_kg_m_s(density_kg_m3)
        lift = mass_kg * gravity_m_s2
        return (
            pressure * body_area_m2(mass_kg) * self.body_drag_coefficient,
            pressure * self.wing_area_m2 * FRICTION_FACTOR / math.sqrt(reynolds),
            PROFILE_LIFT_FACTOR * lift**2 / (pressure * self.wing_area_m2),
        )
