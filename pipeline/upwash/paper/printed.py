"""What the paper prints: its claims, its Table 1, and what of ours each figure is to be compared with.

The claims stand in ``claims.csv``, one a line: where each stands, what it says in few words of ours, the printed
value or phrase, the values of ours that make it true, from which evidence, and why ours are as they are.  Figures
are those of arXiv:2602.22043; rows are rows of the results, by column name.
"""

from __future__ import annotations

import csv
from collections.abc import Callable
from dataclasses import dataclass
from importlib.resources import files

from upwash.study.rows import Row

_TEXT = (files("upwash.paper") / "claims.csv").read_text(encoding="utf-8")
SAID = {line["claim_id"]: line for line in csv.DictReader(_TEXT.splitlines())}
"""Name of a claim -> what the table of claims says of it, by column."""


@dataclass(frozen=True)
class Printed:
    """One quantity of the follower as the paper prints it.

    Parameters
    ----------
    quantity, unit : str
        The paper's symbol and words, and the unit of all values here.
    ours : callable
        Row of the results -> our value.
    printed : tuple of str
        The values as they are printed, Table 1 first if the quantity stands there.
    places : tuple of str
        Where each of them is printed.
    """

    quantity: str
    unit: str
    ours: Callable[[Row], float]
    printed: tuple[str, ...]
    places: tuple[str, ...] = ("Table 1",)

    @property
    def values(self) -> tuple[float, ...]:
        """The printed values as numbers."""
        return tuple(map(float, self.printed))

    @property
    def decimals(self) -> int:
        """Decimals of the printed values."""
        return len(self.printed[0].partition(".")[2])


def _column(name: str) -> Callable[[Row], float]:
    return lambda row: row[name]


def _percent(name: str) -> Callable[[Row], float]:
    return lambda row: 100.0 * row[name]


def _height_m(row: Row) -> float:
    """Height as the paper counts it: that of the leader, z_L, is half the leader's amplitude."""
    return row["leader_amplitude_m"] / 2.0 + row["z_m"]


TABLE_1 = {
    name: Printed(SAID[name]["claim"], SAID[name]["unit"], ours, (SAID[name]["printed"],))
    for name, ours in {
        "table-1-x": _column("x_m"),
        "table-1-y": _column("y_m"),
        "table-1-z": _height_m,
        "table-1-R": _column("upstroke_span_ratio"),
        "table-1-h": _column("amplitude_m"),
        "table-1-phase": _column("phase"),
        "table-1-lift": _column("lift_self_n"),
        "table-1-thrust": _column("thrust_self_n"),
    }.items()
}
"""Name of a claim -> the figure of the follower's column of Table 1 that it is of."""

PRINTED_VARIOUSLY = {
    "y": Printed(
        "y_F, to the right", "m", _column("y_m"), ("0.882", "0.877", "0.886"), ("Table 1", "text", "text")
    ),
    "induced": Printed(
        "P_ind, saving of induced power", "%", _percent("saving_induced"), ("9", "8"), ("text", "text")
    ),
    "profile": Printed(
        "P_pro, saving of profile power", "%", _percent("saving_profile"), ("18", "17"), ("text", "text")
    ),
    "total": Printed("P, saving of total power", "%", _percent("saving_total"), ("11",), ("text",)),
}
"""Savings, and what the paper prints with more than one value."""
