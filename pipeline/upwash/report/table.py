"""A table: a frame and how its cells are written, as plain text, as Markdown or as CSV."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from numbers import Integral, Real
from typing import Any

import numpy as np
import pandas as pd

from upwash.columns import Column

NUMBER = "#.5g"
ABSENT = "-"
UNIT = "unit"

NOISE = 1e-12
"""Numbers smaller than this are the rounding of zero, and written as zero unless a format is asked for."""


@dataclass(frozen=True)
class Table:
    """A frame and how to write it.

    Parameters
    ----------
    title : str
        What it shows.
    frame : DataFrame
        One row a line; the index is not written.
    formats : dict
        How numbers are written: column, or else content of the row's column ``unit`` -> format specification,
        or a list of one for each row. Five significant digits where there is neither.
    notes : tuple of str
        Lines below it.
    """

    title: str
    frame: pd.DataFrame
    formats: Mapping[str, str | Sequence[str]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def cells(self) -> list[list[str]]:
        """Return the written cells, row by row."""
        names = list(self.frame.columns)
        units = self.frame[UNIT] if UNIT in names else [""] * len(self.frame)
        columns = [self._specs(name, units) for name in names]
        return [
            [cell(value, spec) for value, spec in zip(values, specs, strict=True)]
            for values, *specs in zip(self.frame.itertuples(index=False, name=None), *columns, strict=True)
        ]

    def _specs(self, name: str, units: Iterable[str]) -> Sequence[str]:
        """Return the format of each cell of a column."""
        spec = self.formats.get(name)
        if spec is None:
            return [str(self.formats.get(unit, "")) for unit in units]
        return [spec] * len(self.frame) if isinstance(spec, str) else spec

    def text(self) -> str:
        """Return the table as plain text: columns aligned, numbers to the right."""
        lines = [[str(name) for name in self.frame.columns], *self.cells()]
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        to_the_right = self._is_numeric()
        written = [
            "  ".join(
                text.rjust(width) if right else text.ljust(width)
                for text, width, right in zip(line, widths, to_the_right, strict=True)
            ).rstrip()
            for line in lines
        ]
        return "\n".join([self.title, "", *written, *(("", *self.notes) if self.notes else ())])

    def markdown(self) -> str:
        """Return the table as Markdown, its title in bold above and its notes as a list below."""

        def line(cells: list[str]) -> str:
            return "| " + " | ".join(text.replace("|", r"\|") for text in cells) + " |"

        rule = "|" + "|".join("---:" if right else "---" for right in self._is_numeric()) + "|"
        head = [f"**{self.title}**", "", line([str(name) for name in self.frame.columns]), rule]
        notes = ["", *(f"- {note}" for note in self.notes)] if self.notes else []
        return "\n".join([*head, *map(line, self.cells()), *notes])

    def csv(self) -> str:
        """Return the frame as CSV, numbers to their last digit; neither title nor notes."""
        return self.frame.to_csv(index=False, lineterminator="\n")

    def records(self) -> list[dict[str, Any]]:
        """Return the rows as dictionaries of plain Python values, fit for JSON; what is absent is None."""
        return [
            {str(name): _plain(value) for name, value in zip(self.frame.columns, values, strict=True)}
            for values in self.frame.itertuples(index=False, name=None)
        ]

    def _is_numeric(self) -> list[bool]:
        """Return of each column whether it holds a number."""
        return [
            any(
                isinstance(value, Real) and not isinstance(value, (bool, np.bool_))
                for value in self.frame[name]
            )
            for name in self.frame.columns
        ]


def shown(
    rows: pd.DataFrame, columns: Iterable[Column]
) -> tuple[dict[str, pd.Series], dict[str, str | Sequence[str]]]:
    """Return columns of results as people are shown them, and the formats of their numbers, both by their heads."""
    columns = list(columns)
    values = {
        column.heading: column.factor * rows[column.name] if column.percent else rows[column.name]
        for column in columns
    }
    return values, {column.heading: column.format for column in columns if column.format}


def cell(value: Any, spec: str = "") -> str:
    """Write one value: text as it is, truth as yes or no, absence as a dash, a number by a format."""
    value = _plain(value)
    if value is None:
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    if not isinstance(value, float):
        return str(value)
    if not spec and abs(value) < NOISE:
        value = 0.0
    # "#" keeps the zeros that count, and a point after a whole number.
    return format(value, spec or NUMBER).rstrip(".")


def _plain(value: Any) -> Any:
    """Return a value as Python's own bool, int, float, str or None."""
    if value is None or value is pd.NA:
        return None
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return float(value) if math.isfinite(value) else None
    return value
