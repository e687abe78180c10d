"""Positions of all birds at each time, turned into places of followers behind the birds ahead of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from upwash.errors import UpwashError
from upwash.optimum.settings import WAKES
from upwash.study.observed.table import Reading, Rows, named

NEEDED = ("time", "bird", "x_m", "y_m")
"""What each row of such a table must have."""

LEADS = "no bird ahead"
"""What is said of a bird that leads."""


@dataclass(frozen=True)
class Pairs:
    """Who flies behind whom.

    Attributes
    ----------
    places : (p, 4) ndarray of float
        x, y, z in m and the lag in wingbeats, of followers relative to birds ahead, the nearest first; NaN for what is
        not known.
    first : (n + 1,) ndarray of int
        Row i has the places from ``first[i]`` to ``first[i + 1]``.
    leader : (n,) ndarray of object
        The nearest bird ahead, by its name; None of a bird that leads.
    """

    places: NDArray[np.float64]
    first: NDArray[np.int64]
    leader: NDArray[np.object_]


def one_ahead(rows: Rows) -> Pairs:
    """Return the places of a table whose rows each have one bird ahead; what is wrong with a row is added there."""
    x, y = rows.value("x_m"), rows.value("y_m")
    rows.find(
        "x_m: expected a distance behind the leader, found less than 0: this bird is ahead of it", x < 0.0
    )
    is_leaders = (x == 0.0) & (y == 0.0) & (rows.value("z_m") == 0.0)
    rows.find("x_m, y_m, z_m: expected another place than the leader's own, found 0 for all", is_leaders)
    places = np.column_stack([x, y, rows.value("z_m"), rows.value("phase")])
    return Pairs(places, np.arange(len(x) + 1), np.full(len(x), None, dtype=object))


def pair_up(
    frame: pd.DataFrame,
    rows: Rows,
    reading: Reading,
    wake: str = "neighbour",
    heading_deg: float | None = None,
) -> Pairs:
    """Pair each bird with the nearest ahead of it at the same time, or with all that are ahead.

    Parameters
    ----------
    frame : DataFrame
        The table, with `NEEDED` columns.
    rows : Rows
        The same, read; what is wrong with a row is added there.
    reading : Reading
        How it is read.
    wake : str
        ``neighbour`` or ``all-upstream``.
    heading_deg : float, optional
        Compass bearing of the flight, in degrees clockwise from y, of coordinates x east and y north.  If not given,
        the column ``heading_deg`` says (its mean over the birds at each time), and without one birds fly along −x with
        y to their right.
    """
    if wake not in WAKES:
        raise UpwashError(f"wake: expected one of {', '.join(WAKES)}, found {wake!r}")
    names = named(frame, reading, NEEDED)
    time, bird = frame[names["time"]].to_numpy(dtype=object), frame[names["bird"]].to_numpy(dtype=object)
    for name, values in (("time", time), ("bird", bird)):
        is_missing = pd.isna(values) | np.array([str(value).strip() == "" for value in values], dtype=bool)
        rows.find(f"{names[name]}: expected a value, found none", is_missing)
    times, names_of_birds = pd.Series(time).astype(str), pd.Series(bird).astype(str)
    twice = pd.DataFrame({"time": times, "bird": names_of_birds}).duplicated(keep=False).to_numpy()
    rows.find("expected each bird once at a time, found it more than once", twice)
    x, y, z, phase = (rows.value(name) for name in ("x_m", "y_m", "z_m", "phase"))
    heading = rows.value("heading_deg") if heading_deg is None else np.full(len(frame), float(heading_deg))
    counts = np.zeros(len(frame), np.int64)
    of_row: list[NDArray[np.float64]] = [np.empty((0, 4))] * len(frame)
    leader = np.full(len(frame), None, dtype=object)
    usable = rows.faults == ""
    for members in pd.Series(np.arange(len(frame))).groupby(times, sort=False).indices.values():
        here = members[usable[members]]
        behind, right = _along_the_flight(x[here], y[here], heading[here])
        for k, row in enumerate(here):
            apart = behind[k] - behind
            ahead = np.flatnonzero(apart > 0.0)
            if not ahead.size:
                continue
            distance = np.hypot(apart[ahead], right[k] - right[ahead])
            ahead = ahead[np.argsort(distance, kind="stable")]
            leader[row] = bird[here[ahead[0]]]
            chosen = ahead if wake == "all-upstream" else ahead[:1]
            of_row[row] = np.column_stack(
                [
                    apart[chosen],
                    right[k] - right[chosen],
                    z[row] - z[here[chosen]],
                    # Each bird's own phase grows with time: the one that lags is less far in its wingbeat.
                    (phase[here[chosen]] - phase[row]) % 1.0,
                ]
            )
            counts[row] = len(chosen)
    places = [one for one in of_row if len(one)]
    first = np.concatenate([[0], np.cumsum(counts)])
    return Pairs(np.concatenate(places) if places else np.empty((0, 4)), first, leader)


def _along_the_flight(
    x: NDArray[np.float64], y: NDArray[np.float64], heading_deg: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return how far downstream and how far to the right birds are, in a common frame."""
    known = heading_deg[np.isfinite(heading_deg)]
    if not known.size:
        return x, y
    angle = np.angle(np.mean(np.exp(1j * np.radians(known))))
    return -(x * np.sin(angle) + y * np.cos(angle)), x * np.cos(angle) - y * np.sin(angle)
