"""Wings that do not flap: what the model's wake and force become as h → 0 and R → 1, where theory has closed forms.

The rings of a steady wake lie flat, and of two neighbours the stopping and the starting vortex cancel: what is left are
long rectangles from the wing to the wake's end.  A wing whose loading varies along its span sheds a sheet of them, one
inside another, and feels a wind as the sum of narrower wings of uniform loading.  Both are summed here from the limit
model's own antiderivative over the span, `upwash.aero.span_integral`; nothing else is needed for Prandtl's and Munk's
theory of wings in formation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.aero.checked import REACH, check_fields, must_be, one_of
from upwash.aero.span_integral import ring_velocity, span_antiderivative, span_nodes
from upwash.aero.wake import ROLL_UP

FAR = 1e5
"""Semispans after which an end of the wake is no longer felt."""

STRIPS = 200
"""Parts in which an elliptic loading is told: a saving is then off by no more than 4e-4 wherever the wings overlap."""

_SOME = must_be(REACH)


@dataclass(frozen=True)
class FixedWing:
    """A wing in steady flight that does not flap.

    Parameters
    ----------
    semispan_m : float
        Half its span, b, in m.
    lift_n : float
        Its lift L, in N.
    speed_m_s : float
        Airspeed U, in m/s.
    density_kg_m3 : float
        Density of the air ρ, in kg/m³.
    loading : str
        How its circulation lies along the span: ``elliptic``, or ``uniform``, the paper's.
    wake : str
        What it leaves: ``sheet``, shed where the loading falls and not rolled up; or ``pair``, two vortices of the
        circulation at its middle, rolled up at ±π b/4, the paper's.

    Raises
    ------
    ValueError
        If a value is of another kind; the message names it.

    Examples
    --------
    An elliptic wing behind another saves most of its induced drag where it overlaps by a twelfth of a span:

    >>> wing = FixedWing(semispan_m=0.6, lift_n=12.74, speed_m_s=15.0, density_kg_m3=1.29)
    >>> round(wing.saving_behind(wing, y_m=1.82 * 0.6), 2)
    0.69
    """

    semispan_m: float = field(metadata=_SOME)
    lift_n: float = field(metadata=_SOME)
    speed_m_s: float = field(metadata=_SOME)
    density_kg_m3: float = field(metadata=_SOME)
    loading: str = field(default="elliptic", metadata=must_be(one_of(["elliptic", "uniform"])))
    wake: str = field(default="sheet", metadata=must_be(one_of(["sheet", "pair"])))

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def circulation_m2_s(self) -> float:
        """Circulation at its middle, in m²/s: lift over ρ U and the mean span that carries it."""
        carrying = math.pi / 4.0 if self.loading == "elliptic" else 1.0
        return self.lift_n / (self.density_kg_m3 * self.speed_m_s * 2.0 * self.semispan_m * carrying)

    @property
    def induced_drag_n(self) -> float:
        """Induced drag of an elliptic wing of its span and lift, L²/(2π ρ U² b²), in N: the least there is."""
        lift_per_head = self.lift_n / (self.speed_m_s * self.semispan_m)
        return lift_per_head**2 / (2.0 * math.pi * self.density_kg_m3)

    def drag_saved_n(
        self,
        ahead: FixedWing,
        x_m: float = math.inf,
        y_m: float = 0.0,
        z_m: float = 0.0,
        *,
        wake_length_m: float = math.inf,
        core_radius_m: float | None = None,
        nodes: int | str = "exact",
    ) -> float:
        """Return how much of its drag another wing's wake takes from it, in N.

        Parameters
        ----------
        ahead : FixedWing
            The other wing; its bound vortex is felt as well.
        x_m, y_m, z_m : float
            Where this wing is relative to it, in m: downstream (negative ahead of it; infinite where only the wake is
            left), to the right, up.
        wake_length_m : float
            Length of the other's wake, in m.
        core_radius_m : float, optional
            Radius of the vortices' cores; thin, a millionth of a semispan, if not given.
        nodes : int or str
            Points across the span where the wind is taken, for a uniform loading, as the paper's two; ``exact`` for
            the integral.

        Returns
        -------
        float
            ρ ∫ Γ v_z dy: what upwash pulls it forward.

        Raises
        ------
        ValueError
            If the wind of an elliptic loading is asked for in points.
        """
        core_radius = 1e-6 * ahead.semispan_m if core_radius_m is None else core_radius_m
        rings, circulation = ahead._wake_rings(x_m, wake_length_m)
        x = 0.0 if math.isinf(x_m) else x_m
        # As many pairs of parts for a pair of vortices as for a sheet; one more part, so that none meet at y = 0.
        half_span, own = self._parts(STRIPS**2 // circulation.size + 1)
        if nodes == "exact":
            ends = [
                span_antiderivative(x, y_m + side, z_m, rings, circulation, core_radius)[1]
                for side in (half_span, -half_span)
            ]
            upwash = ends[0] - ends[1]
        elif self.loading == "uniform":
            where, weights = span_nodes(nodes)
            y = y_m + self.semispan_m * where
            points = np.stack([np.full(y.size, x), y, np.full(y.size, z_m)], axis=-1)
            mean = weights @ ring_velocity(points, rings, circulation, core_radius)[:, 2]
            upwash = np.array([2.0 * self.semispan_m * mean])
        else:
            raise ValueError(f"nodes: expected exact for an elliptic loading, found {nodes!r}")
        return float(self.density_kg_m3 * (own @ upwash))

    def saving_behind(self, ahead: FixedWing, x_m: float = math.inf, y_m: float = 0.0, **where: Any) -> float:
        """Return what another wing's wake saves it, as a share of `induced_drag_n`.

        Parameters
        ----------
        ahead, x_m, y_m, **where
            As for `drag_saved_n`.
        """
        return self.drag_saved_n(ahead, x_m, y_m, **where) / self.induced_drag_n

    def _parts(self, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return half-spans, in m, and circulation of wings of uniform loading of which it is the sum."""
        if self.loading == "uniform":
            return np.array([self.semispan_m]), np.array([self.circulation_m2_s])
        # Γ = Γ₀ cos t at y = b sin t, in parts of equal angle.
        angle = (np.arange(count) + 0.5) * 0.5 * math.pi / count
        return self.semispan_m * np.sin(angle), self.circulation_m2_s * 0.5 * math.pi / count * np.sin(angle)

    def _wake_rings(
        self, x_m: float, wake_length_m: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the rings of its wake, as `upwash.aero.wake.Wake` has them, and their circulation."""
        if self.wake == "pair":
            half_width, shed = np.array([ROLL_UP * self.semispan_m]), np.array([self.circulation_m2_s])
        else:
            half_width, shed = self._parts(STRIPS)
        far = FAR * self.semispan_m
        first = -far if math.isinf(x_m) else 0.0
        last = min(wake_length_m, far)
        rings = np.zeros((half_width.size, 6))
        rings[:, 0], rings[:, 1], rings[:, 5] = first, last, half_width
        return rings, shed
