"""A table of observed birds: what its columns are called, in what units they stand, and what is wrong in which row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from upwash.errors import UpwashError
from upwash.study.observed.choices import PHASE_SIGNS, PHASE_STARTS, PHASE_UNITS

PLACE = ("x_m", "y_m")
"""What each row must have: how far behind its leader and how far to the right of it a bird flies, in m."""

KNOWN = (
    *PLACE,
    "z_m",
    "phase",
    "speed_m_s",
    "period_s",
    "mass_kg",
    "sigma_x_m",
    "sigma_y_m",
    "sigma_z_m",
    "sigma_phase",
)
"""Columns that are understood; all others are passed through."""

# Ends of names by which a unit is told: end -> (dimension, in SI units); the longest are tried first.
_UNITS = {
    "_m_s": ("speed", 1.0),
    "_km_h": ("speed", 1.0 / 3.6),
    "_cm_s": ("speed", 0.01),
    "_mm": ("length", 1e-3),
    "_cm": ("length", 1e-2),
    "_km": ("length", 1e3),
    "_m": ("length", 1.0),
    "_ms": ("time", 1e-3),
    "_s": ("time", 1.0),
    "_kg": ("mass", 1.0),
    "_g": ("mass", 1e-3),
}

FAR = 200.0
"""A median so many semispans behind or aside is no formation's: the unit is another."""

_MOST_TURNS = 1.5


@dataclass(frozen=True)
class Reading:
    """How a table is to be read.

    Parameters
    ----------
    columns : mapping of str to str, optional
        Name in the table -> the column that it stands for, as in ``{"behind_cm": "x_m"}``: a unit at the end of the
        name is converted.
    phase_unit : str, optional
        ``beats``, ``deg`` or ``rad``; beats if not given, and then phases of many turns are refused.
    phase_sign : str
        ``lag`` if a positive phase says that the follower comes later, ``lead`` if earlier.
    phase_at : str, optional
        Not given: a phase is the lag of one point of the stroke behind the same point of the leader's.  Else it is the
        follower's own phase when the leader begins its downstroke, counted from ``downstroke-start`` or
        ``upstroke-start``.

    Raises
    ------
    UpwashError
        If a choice is unknown.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    phase_unit: str | None = None
    phase_sign: str = "lag"
    phase_at: str | None = None

    def __post_init__(self) -> None:
        for name, known in (
            ("phase_unit", (None, *PHASE_UNITS)),
            ("phase_sign", PHASE_SIGNS),
            ("phase_at", (None, *PHASE_STARTS)),
        ):
            if getattr(self, name) not in known:
                expected = ", ".join(str(one) for one in known if one)
                raise UpwashError(f"{name}: expected one of {expected}, found {getattr(self, name)!r}")
        for theirs, ours in self.columns.items():
            if ours not in (*KNOWN, *PAIRED):
                raise UpwashError(
                    f"--columns {theirs}={ours}: expected one of {', '.join(KNOWN)} after the sign, found {ours}; "
                    "write NAME IN THE TABLE=NAME HERE"
                )

    def turns(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return phases as they stand, in wingbeats."""
        return phase * PHASE_UNITS[self.phase_unit or "beats"]

    def lag(self, phase: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the lag of the same point of the stroke, in wingbeats from 0 to 1, of phases as they stand."""
        turns = self.turns(phase)
        if self.phase_at is not None:
            turns = -(turns + PHASE_STARTS[self.phase_at])
        if self.phase_sign == "lead":
            turns = -turns
        return turns % 1.0


PAIRED = ("time", "bird", "heading_deg")
"""Columns of positions of all birds at each time, beside those of a place."""


@dataclass(frozen=True)
class Rows:
    """A table that was read.

    Attributes
    ----------
    values : dict of str to (n,) ndarray of float
        Each known column that the table has, in SI units, NaN where nothing stands or nothing that can be used.
    faults : (n,) ndarray of str
        What is wrong with a row, or "".
    """

    values: dict[str, NDArray[np.float64]]
    faults: NDArray[np.object_]

    def value(self, name: str) -> NDArray[np.float64]:
        """Return a column, NaN where the table has none."""
        return self.values.get(name, np.full(len(self.faults), np.nan))

    def find(self, fault: str, where: NDArray[np.bool_]) -> None:
        """Note what is wrong with some rows, if nothing is yet."""
        self.faults[where & (self.faults == "")] = fault


def named(frame: pd.DataFrame, reading: Reading, needed: tuple[str, ...] = PLACE) -> dict[str, str]:
    """Return which column of a table each known column is: known -> name in the table.

    Raises
    ------
    UpwashError
        If a needed one is missing, or one is told twice; the message names the columns found.
    """
    found = [str(name) for name in frame.columns]
    for theirs in reading.columns:
        if theirs not in found:
            raise UpwashError(f"--columns {theirs}: expected a column of the table, found {_listed(found)}")
    names = {ours: theirs for theirs, ours in reading.columns.items()}
    for ours in (*KNOWN, *PAIRED):
        if ours in found and ours not in reading.columns:
            if ours in names:
                raise UpwashError(
                    f"{ours}: expected one column, found {names[ours]} by --columns and {ours} itself; rename one"
                )
            names[ours] = ours
    missing = [name for name in needed if name not in names]
    if missing:
        remedy = f"name it by --columns THEIRS={missing[0]}"
        if len(found) == 1 and (";" in found[0] or "\t" in found[0]):
            remedy = "separate the columns by commas"
        raise UpwashError(f"{missing[0]}: expected such a column, found {_listed(found)}; {remedy}")
    return names


def read_rows(
    frame: pd.DataFrame, reading: Reading, semispan_m: float, needed: tuple[str, ...] = PLACE
) -> Rows:
    """Read the known columns of a table, and say of each row what is wrong with it.

    Parameters
    ----------
    frame : DataFrame
        The table.
    reading : Reading
        How it is read.
    semispan_m : float
        Semispan of the birds, by which a wrong unit is noticed.
    needed : tuple of str
        Columns that it must have.

    Raises
    ------
    UpwashError
        If a needed column is missing, or nearly all of it is in another unit.
    """
    names = named(frame, reading, needed)
    faults = np.full(len(frame), "", dtype=object)
    rows = Rows({}, faults)
    for ours, theirs in names.items():
        if ours in ("time", "bird"):
            continue
        written = frame[theirs]
        if isinstance(written, pd.DataFrame):
            raise UpwashError(
                f"{theirs}: expected one column of that name, found {written.shape[1]}; rename them"
            )
        numbers = pd.to_numeric(written, errors="coerce").to_numpy(dtype=float, na_value=np.nan).copy()
        is_empty = written.isna().to_numpy() | (written.astype(str).str.strip() == "").to_numpy()
        for row in np.flatnonzero(np.isnan(numbers) & ~is_empty):
            if faults[row] == "" and str(written.iloc[row]).strip().lower() not in ("nan", "na", "null"):
                faults[row] = f"{theirs}: expected a number, found {str(written.iloc[row]).strip()[:40]!r}"
        rows.find(f"{theirs}: expected a finite number, found infinity", np.isinf(numbers))
        numbers[np.isinf(numbers)] = np.nan
        rows.values[ours] = numbers * _factor(theirs, ours)
        if ours in needed:
            rows.find(f"{theirs}: expected a number, found none", np.isnan(numbers))
    for name in ("speed_m_s", "period_s", "mass_kg"):
        rows.find(f"{names.get(name)}: expected a number above 0", rows.value(name) <= 0.0)
    for name in KNOWN[-4:]:
        rows.find(f"{names.get(name)}: expected a number that is not negative", rows.value(name) < 0.0)
    _notice_units(rows, names, reading, semispan_m)
    if "phase" in rows.values:
        # Of a pair of birds each has its own phase, and the lag is their difference.
        own = "bird" in needed
        rows.values["phase"] = (reading.turns if own else reading.lag)(rows.values["phase"])
    return rows


def _factor(theirs: str, ours: str) -> float:
    """Return by what a column is multiplied, for the units that its two names end in."""
    here, there = _unit(ours), _unit(theirs)
    return there[1] if here and there and here[0] == there[0] else 1.0


def _unit(name: str) -> tuple[str, float] | None:
    ends = [end for end in sorted(_UNITS, key=len, reverse=True) if name.endswith(end)]
    return _UNITS[ends[0]] if ends else None


def _notice_units(rows: Rows, names: Mapping[str, str], reading: Reading, semispan_m: float) -> None:
    """Refuse a table whose places or phases are of another unit, by their size."""
    for name in PLACE:
        numbers = np.abs(rows.value(name))
        known = numbers[np.isfinite(numbers)]
        if known.size and np.median(known) > FAR * semispan_m:
            raise UpwashError(
                f"{names[name]}: expected metres relative to the leader, found a median of {np.median(known):.4g}, "
                f"{np.median(known) / semispan_m:.0f} semispans; if these are centimetres write "
                f"--columns {names[name]}_cm={name} and rename the column so, if they are positions write --pairs"
            )
    phases = np.abs(rows.value("phase"))
    phases = phases[np.isfinite(phases)]
    if reading.phase_unit is None and phases.size and np.quantile(phases, 0.9) > _MOST_TURNS:
        largest = float(np.max(phases))
        unit = "degrees (--phase-unit deg)" if largest > 7.0 else "radians (--phase-unit rad)"
        raise UpwashError(
            f"{names['phase']}: expected wingbeats from 0 to 1, found up to {largest:.4g}; "
            f"if these are {unit}, say so; if they are wingbeats, --phase-unit beats"
        )


def _listed(names: list[str]) -> str:
    shown = ", ".join(repr(name) if name.strip() != name or not name else name for name in names[:12])
    return f"{shown} and {len(names) - 12} more" if len(names) > 12 else shown or "none"
