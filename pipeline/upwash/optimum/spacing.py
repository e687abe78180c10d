"""What a follower keeps to, for its own reasons: how near it comes to its leader, and whether it sees it.

Two of the limits bound one variable each and are bounds like the others; two are walls, told in one table of numbers
(`upwash.optimum.compiled.walls`), which local solves, evidence, starts and proofs take as they come.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from upwash.aero.checked import REACH, WrongInput, finite, must_be, positive, rules_of, within
from upwash.optimum.variables import SPANWISE_REACH, STREAMWISE_REACH, VARIABLE_COUNT, Box

X_MIN, GAP_MIN, DISTANCE_MIN, BEARING_MAX = (
    "x_min_m",
    "wingtip_gap_min_m",
    "distance_min_m",
    "bearing_max_deg",
)
"""The limits, by their names as inputs."""

UNITS = {X_MIN: "m", GAP_MIN: "m", DISTANCE_MIN: "m", BEARING_MAX: "deg"}
"""In which unit each is told."""

_GAP = finite & within(-1000.0, 1000.0, "no wing is longer")
_ANGLE = positive & within(0.1, 90.0, "the follower is behind")


@dataclass(frozen=True)
class Spacing:
    """Limits of a follower's place relative to the bird that it follows; what is None does not limit it.

    Parameters
    ----------
    x_min_m : float, optional
        Least distance x behind, in m, from reference point to reference point.
    wingtip_gap_min_m : float, optional
        Least gap between the wingtips that are nearest, measured across the direction of flight with both wings
        spread: |y| less the two semispans, in m.  It is negative where wings overlap as seen from behind.
    distance_min_m : float, optional
        Least distance √(x² + y² + z²), in m.
    bearing_max_deg : float, optional
        Greatest bearing of the bird ahead, in degrees: the angle at the follower, seen from above, between its
        direction of flight and the line to that bird, atan(|y| / x).

    Raises
    ------
    ValueError
        If one is out of range; the message names it.

    Examples
    --------
    >>> Spacing(wingtip_gap_min_m=0.0).names
    ('wingtip_gap_min_m',)
    """

    x_min_m: float | None = field(default=None, metadata=must_be(REACH))
    wingtip_gap_min_m: float | None = field(default=None, metadata=must_be(_GAP))
    distance_min_m: float | None = field(default=None, metadata=must_be(REACH))
    bearing_max_deg: float | None = field(default=None, metadata=must_be(_ANGLE))

    def __post_init__(self) -> None:
        for name in self.names:
            object.__setattr__(self, name, rules_of(Spacing)[name](name, getattr(self, name)))

    @property
    def names(self) -> tuple[str, ...]:
        """The limits that there are."""
        return tuple(entry.name for entry in fields(self) if getattr(self, entry.name) is not None)

    def box(
        self, semispan_m: float, distance_m: float | None = None, leader_semispan_m: float | None = None
    ) -> Box:
        """Return what of them bounds one variable, in semispans.

        Parameters
        ----------
        semispan_m : float
            Semispan of the follower, in m.
        distance_m : float, optional
            Distance behind where that is given, as behind an endless wake, in m.
        leader_semispan_m : float, optional
            Semispan of the bird ahead, in m; like the follower's if not given.
        """
        least_x, least_y, most_y = self.x_min_m or 0.0, 0.0, math.inf
        if self.wingtip_gap_min_m is not None:
            both = semispan_m + (leader_semispan_m or semispan_m)
            least_y = max(0.0, both + self.wingtip_gap_min_m)
        if distance_m is not None and self.bearing_max_deg is not None and self.bearing_max_deg < 90.0:
            most_y = distance_m * math.tan(math.radians(self.bearing_max_deg))
        return Box(least_x / semispan_m, least_y / semispan_m, most_y / semispan_m)

    def walls(
        self, semispan_m: float, distance_m: float | None = None
    ) -> tuple[tuple[str, ...], NDArray[np.float64]]:
        """Return the names of those that are walls, and the walls in semispans; parameters are those of `box`.

        Returns
        -------
        tuple of str
            Their names.
        (w, 7) ndarray of float
            Rows as in `upwash.optimum.compiled.walls`; each is about the distance from the wall, in semispans.
        """
        rows: dict[str, list[float]] = {}
        if self.distance_min_m is not None:
            least = self.distance_min_m / semispan_m
            part = 0.5 / least
            free, far = (part, 0.0) if distance_m is None else (0.0, (distance_m / semispan_m) ** 2)
            rows[DISTANCE_MIN] = [free, part, part, 0.0, 0.0, 0.0, part * far - 0.5 * least]
        if self.bearing_max_deg is not None and distance_m is None and self.bearing_max_deg < 90.0:
            angle = math.radians(self.bearing_max_deg)
            rows[BEARING_MAX] = [0.0, 0.0, 0.0, math.sin(angle), -math.cos(angle), 0.0, 0.0]
        return tuple(rows), np.array([*rows.values()]).reshape(-1, 7)

    def told(
        self, x_m: float, y_m: float, z_m: float, semispan_m: float, leader_semispan_m: float | None = None
    ) -> dict[str, tuple[float, bool]]:
        """Return of a place what each limit that there is limits there, and whether it keeps it but for rounding.

        Parameters
        ----------
        x_m, y_m, z_m : float
            The place relative to the bird ahead, in m.
        semispan_m, leader_semispan_m
            As for `box`.

        Examples
        --------
        >>> Spacing(bearing_max_deg=40.0).told(1.0, -1.0, 0.2, 0.6)
        {'bearing_max_deg': (45.0, False)}
        """
        values = {
            X_MIN: x_m,
            GAP_MIN: abs(y_m) - semispan_m - (leader_semispan_m or semispan_m),
            DISTANCE_MIN: math.hypot(x_m, y_m, z_m),
            BEARING_MAX: math.degrees(math.atan2(abs(y_m), x_m)),
        }
        found = {}
        for name in self.names:
            limit, value = getattr(self, name), values[name]
            if name == BEARING_MAX:
                beyond = math.radians(value - limit) * math.hypot(x_m, y_m)
            else:
                beyond = limit - value
            found[name] = value, beyond <= 2.0 * ON_WALL * semispan_m
        return found

    def prices(
        self,
        place: NDArray[np.float64],
        multipliers: Mapping[str, float],
        semispan_m: float,
        distance_m: float | None = None,
        leader_semispan_m: float | None = None,
    ) -> dict[str, float]:
        """Return what each limit that there is costs an optimum: what more of the cost it takes, made a unit tighter.

        Parameters
        ----------
        place : (2,) ndarray of float
            x and y, in semispans.
        multipliers : mapping
            Bound, as ``y_lower``, or wall, by the name of its limit -> its multiplier at the optimum.
        semispan_m, distance_m, leader_semispan_m
            As for `box`.

        Returns
        -------
        dict
            Limit -> its price, per m or degree; 0 for one that the optimum does not rest on.
        """
        box = self.box(semispan_m, distance_m, leader_semispan_m)
        found = dict.fromkeys(self.names, 0.0)
        if box.least_x > 0.0 and distance_m is None:
            found[X_MIN] = multipliers.get("x_lower", 0.0) / semispan_m
        if self.wingtip_gap_min_m is not None and box.least_y > 0.0:
            found[GAP_MIN] = multipliers.get("y_lower", 0.0) / semispan_m
        if self.distance_min_m is not None:
            found[DISTANCE_MIN] = multipliers.get(DISTANCE_MIN, 0.0) / semispan_m
        if self.bearing_max_deg is not None:
            per_radian = multipliers.get(BEARING_MAX, 0.0) * math.hypot(*place)
            if distance_m is not None and math.isfinite(box.most_y):
                reach = distance_m / semispan_m / math.cos(math.radians(self.bearing_max_deg)) ** 2
                per_radian = multipliers.get("y_upper", 0.0) * reach
            found[BEARING_MAX] = math.radians(per_radian)
        return found

    def need_room(
        self,
        semispan_m: float,
        wavelength_m: float,
        distance_m: float | None = None,
        leader_semispan_m: float | None = None,
    ) -> None:
        """Refuse limits that leave no place to be searched.

        Parameters
        ----------
        semispan_m, distance_m, leader_semispan_m
            As for `box`.
        wavelength_m : float
            Wavelength of the wake, in m.

        Raises
        ------
        ValueError
            If there is none; the message names the input.
        """
        ahead = leader_semispan_m or semispan_m
        behind, aside = STREAMWISE_REACH * wavelength_m / semispan_m, SPANWISE_REACH
        aside *= max(1.0, ahead / semispan_m)
        box = self.box(semispan_m, distance_m, ahead)
        if distance_m is not None:
            behind = distance_m / semispan_m
            if box.least_x > behind:
                raise WrongInput(
                    X_MIN, f"at most the distance, {distance_m:.6g} m, at which it flies", self.x_min_m
                )
        elif box.least_x >= behind:
            raise WrongInput(X_MIN, f"less than {behind * semispan_m:.6g} m (1.5 wavelengths)", self.x_min_m)
        if box.least_y >= aside:
            most = aside * semispan_m - semispan_m - ahead
            raise WrongInput(GAP_MIN, f"less than {most:.6g} m", self.wingtip_gap_min_m)
        if self.bearing_max_deg is not None and self.bearing_max_deg < 90.0:
            least = math.degrees(math.atan2(box.least_y, behind))
            if self.bearing_max_deg <= least:
                expected = f"more than {least:.4g}, as by the other limits there is no lesser"
                raise WrongInput(BEARING_MAX, expected, self.bearing_max_deg)
        farthest = math.hypot(behind, min(aside, box.most_y)) * semispan_m
        if self.distance_min_m is not None and self.distance_min_m >= farthest:
            raise WrongInput(DISTANCE_MIN, f"less than {farthest:.6g} m", self.distance_min_m)


ON_WALL, TOUCHES = 1e-9, 1e-8
"""How far beyond a wall, in semispans, a place may lie by rounding; and how near it a place counts as on it."""

FREE = Spacing()
"""No limits but those of the paper."""


class Touched(NamedTuple):
    """Walls on which a place lies.

    Attributes
    ----------
    names : tuple of str
        Their names.
    outward : (t, 6) ndarray of float
        Their outward normals.
    hessians : (t, 6, 6) ndarray of float
        Their second derivatives, inward.
    """

    names: tuple[str, ...]
    outward: NDArray[np.float64]
    hessians: NDArray[np.float64]


def touched_walls(names: Sequence[str], walls: NDArray[np.float64], point: NDArray[np.float64]) -> Touched:
    """Return those of some walls on which a point lies."""
    on_wall = np.flatnonzero(np.abs(wall_values(point[None, :], walls)[0]) < TOUCHES)
    outward = np.zeros((len(on_wall), VARIABLE_COUNT))
    hessians = np.zeros((len(on_wall), VARIABLE_COUNT, VARIABLE_COUNT))
    for number, wall in enumerate(walls[on_wall]):
        outward[number, :3] = -(2.0 * wall[:3] * point[:3] + wall[3:6])
        hessians[number, range(3), range(3)] = 2.0 * wall[:3]
    return Touched(tuple(names[number] for number in on_wall.tolist()), outward, hessians)


def moved_inside(
    points: NDArray[np.float64], walls: NDArray[np.float64], bounds: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return places of which those beyond a wall are moved to it: back along x where that is free, else aside.

    Parameters
    ----------
    points : (n, 6) ndarray of float
        In scaled variables.
    walls : (w, 7) ndarray of float
        The walls; going back, or aside, leads out of each.
    bounds : (6, 2) ndarray of float
        Bounds, which they keep.
    """
    found = np.clip(points, *bounds.T)
    for wall in walls:
        axis = 0 if wall[0] or wall[3] else 1
        square, slope = wall[axis], wall[3 + axis]
        value = wall_values(found, wall[None, :])[:, 0]
        here = found[:, axis]
        rest = value - (square * here + slope) * here
        with np.errstate(invalid="ignore"):
            root = np.sqrt(np.maximum(slope**2 - 4.0 * square * rest, 0.0))
            zero = -rest / slope if square == 0.0 else (root - slope) / (2.0 * square)
        found[:, axis] = np.where(value < 0.0, np.clip(zero, *bounds[axis]), here)
    return found


def wall_values(points: NDArray[np.float64], walls: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return by how much places keep walls, about in semispans, negative beyond: (n, w) for (n, 6) and (w, 7)."""
    places = points[:, None, :3]
    return np.asarray(np.sum((walls[:, :3] * places + walls[:, 3:6]) * places, axis=2) + walls[:, 6])
