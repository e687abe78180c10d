"""How a bird flaps, and where: the two values that a follower's flight consists of."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from upwash.aero.checked import REACH, check_fields, finite, must_be, ratio, within

_PLACE = finite & within(-1e20, 1e20, "no bird is so far away: look at the unit")


@dataclass(frozen=True)
class Stroke:
    """How a bird flaps.

    Parameters
    ----------
    amplitude_m : float
        Tip-to-tip flapping amplitude, h, in m.
    span_ratio : float
        Projected span on the upstroke over that on the downstroke, R, in (0, 1).

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.

    Examples
    --------
    >>> Stroke(0.75, 0.35)
    Stroke(amplitude_m=0.75, span_ratio=0.35)
    >>> Stroke(0.75, 1.2)
    Traceback (most recent call last):
    upwash.aero.checked.WrongInput: span_ratio: expected a ratio strictly between 0 and 1, found 1.2
    """

    amplitude_m: float = field(metadata=must_be(REACH))
    span_ratio: float = field(metadata=must_be(ratio & REACH))

    def __post_init__(self) -> None:
        check_fields(self)


@dataclass(frozen=True)
class Pose:
    """Where a bird flies relative to another, how it flaps, and by how much it lags.

    Parameters
    ----------
    x_m, y_m, z_m : float
        Its reference point relative to the other's, in m: downstream, right, up.
    stroke : Stroke
        How it flaps.
    phase : float
        Its lag behind the other, κ, in wingbeats; any real number, of which the whole part changes nothing.

    Raises
    ------
    ValueError
        If a value is not finite; the message names it.

    Examples
    --------
    >>> pose = Pose(1.8, 0.9, -0.1, Stroke(0.75, 0.35), 0.5)
    >>> pose.mirrored().y_m
    -0.9
    >>> pose.behind(pose).x_m, pose.behind(pose).phase
    (3.6, 0.0)
    """

    x_m: float = field(metadata=must_be(_PLACE))
    y_m: float = field(metadata=must_be(_PLACE))
    z_m: float = field(metadata=must_be(_PLACE))
    stroke: Stroke
    phase: float = field(metadata=must_be(_PLACE))

    def __post_init__(self) -> None:
        check_fields(self)

    @property
    def position_m(self) -> tuple[float, float, float]:
        """Position x, y, z in m."""
        return self.x_m, self.y_m, self.z_m

    def spatial_phase(self, wavelength_m: float) -> float:
        """Return x/λ − κ in (−½, ½]: 0 if the wing retraces the path of the other's in the air.

        Examples
        --------
        >>> Pose(1.875, 0.9, 0.0, Stroke(0.75, 0.35), 0.0).spatial_phase(3.75)
        0.5
        """
        phase = self.x_m / wavelength_m - self.phase
        return phase - math.ceil(phase - 0.5)

    def mirrored(self) -> Pose:
        """Return the pose on the other side of the other bird."""
        return replace(self, y_m=0.0 - self.y_m)

    def behind(self, ahead: Pose) -> Pose:
        """Return the pose relative to what `ahead` is relative to; its phase is then in [0, 1)."""
        return Pose(
            ahead.x_m + self.x_m,
            ahead.y_m + self.y_m,
            ahead.z_m + self.z_m,
            self.stroke,
            (ahead.phase + self.phase) % 1.0,
        )

    def relative_to(self, ahead: Pose) -> Pose:
        """Return the pose relative to a bird ahead, both given relative to a third."""
        return Pose(
            self.x_m - ahead.x_m,
            self.y_m - ahead.y_m,
            self.z_m - ahead.z_m,
            self.stroke,
            self.phase - ahead.phase,
        )
