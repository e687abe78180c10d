"""What the columns of a stored row stand for, as values."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.optimum import variables
from upwash.optimum.endless.problem import DISTANCE
from upwash.optimum.spacing import BEARING_MAX, DISTANCE_MIN, UNITS, Spacing

Complaints = Iterator[tuple[str, str]]
"""Columns, and what does not hold of them: what was expected, and what was found."""

AGREEMENT = of.Agreement(relative=1e-9, absolute=1e-9)
"""How closely a stored value must agree with its recomputation, which sums in another order."""


def stroke_of(row: of.Stored, prefix: str = "") -> Stroke:
    """Return how a row's bird flaps or, by a prefix of the columns, another one."""
    return Stroke(row[f"{prefix}amplitude_m"], row[f"{prefix}upstroke_span_ratio"])


def pose_of(row: of.Stored) -> Pose:
    """Return where and how a row's bird flies, relative to the one that it follows."""
    return Pose(row["x_m"], row["y_m"], row["z_m"], stroke_of(row), row["phase"] or 0.0)


def pose_to_the_right(row: of.Stored) -> Pose:
    """Return the pose of a row's bird as its problem has it, to the right of the one that it follows."""
    return Pose(row["x_m"], abs(row["y_m"]), row["z_m"], stroke_of(row), row["phase"] or 0.0)


def place_of(row: of.Stored) -> Pose:
    """Return where and how a row's bird flies, relative to the first of its flock."""
    x, y, z = (row[f"{axis}_flock_m"] for axis in "xyz")
    return Pose(x, y, z, stroke_of(row), row["phase_flock"] or 0.0)


def is_v_formation(row: of.Stored) -> bool:
    """Whether a row's bird is outboard, level and astern."""
    return (row.get("placement"), row.get("tier"), row.get("station")) == ("outboard", "level", "astern")


def bounds_behind(
    row: of.Stored, bird: Bird, ahead: Stroke, leader: Bird, limit_m: float
) -> dict[str, tuple[float, float]]:
    """Return the bounds of a row's variables to the right of the bird ahead, by column.

    Parameters
    ----------
    row : mapping
        A solved row.
    bird : Bird
        Its bird.
    ahead : Stroke
        How the bird ahead flaps.
    leader : Bird
        That bird.
    limit_m : float
        Largest amplitude of the row's bird, in m.
    """
    wavelength, b = leader.wavelength_m, bird.semispan_m
    # Behind an endless wake it is the distance asked for.
    asked = (row["distance_m"] or DISTANCE * wavelength) if row["wavelengths"] == inf else None
    box = spacing_of(row).box(b, asked, leader.semispan_m)
    x = (box.least_x * b, variables.STREAMWISE_REACH * wavelength)
    aside = variables.SPANWISE_REACH * max(b, leader.semispan_m)
    return {
        "x_m": x if asked is None else (asked, asked),
        "y_m": (box.least_y * b, min(aside, box.most_y * b)),
        "z_m": (-ahead.amplitude_m, ahead.amplitude_m),
        "amplitude_m": (variables.LEAST_AMPLITUDE * limit_m, limit_m),
        "upstroke_span_ratio": variables.SPAN_RATIO_BOUNDS,
        "phase": (0.0, 1.0),
    }


def spacing_of(row: of.Stored) -> Spacing:
    """Return what a row's follower keeps to; rows from before there was such a thing keep to nothing."""
    return Spacing(**{name: row.get(name) for name in UNITS})


def beyond_spacing(row: of.Stored) -> Complaints:
    """Give what of a solved row's place is beyond what its follower keeps to."""
    if row.get("x_m") is None:
        return
    # The others are bounds of one variable.
    told = spacing_of(row).told(row["x_m"], row["y_m"], row["z_m"], row["semispan_m"])
    for name, (found, keeps) in told.items():
        if name in (DISTANCE_MIN, BEARING_MAX) and not keeps:
            yield name, f"expected a place that keeps {row[name]:.9g}, found {found:.9g}"


def unlike(row: of.Stored, expected: of.Stored, agreement: of.Agreement, how: str) -> Complaints:
    """Give the columns of a row that do not hold what is expected, and how that was found."""
    for name, value in expected.items():
        found = row[name]
        if isinstance(value, float) and isinstance(found, float):
            if not agreement.holds(found, value):
                yield name, f"expected {value:.12g} {how}, found {found:.12g}"
        elif found != value:
            yield name, f"expected {value!r} {how}, found {found!r}"
