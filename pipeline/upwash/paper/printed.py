"""What the paper prints of its own optimum, and what of ours each figure is to be compared with.

The figures are those of arXiv:2602.22043; rows are rows of the results, by column name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

Row = Mapping[str, Any]


@dataclass(frozen=True)
class Printed:
    """One quantity of the follower as the paper prints it.

    Parameters
    ----------
    symbol, quantity, unit : str
        The paper's symbol, words, and the unit of all values here.
    decimals : int
        Decimals of the printed values.
    ours : callable
        Row of the results -> our value.
    values : tuple of float
        What is printed, Table 1 first if the quantity stands there.
    places : tuple of str
        Where each value is printed.
    """

    symbol: str
    quantity: str
    unit: str
    decimals: int
    ours: Callable[[Row], float]
    values: tuple[float, ...]
    places: tuple[str, ...] = ("Table 1",)


def _column(name: str) -> Callable[[Row], float]:
    return lambda row: row[name]


def _percent(name: str) -> Callable[[Row], float]:
    return lambda row: 100.0 * row[name]


def _height_m(row: Row) -> float:
    """Height as the paper counts it: that of the leader, z_L, is half the leader's amplitude."""
    return row["leader_amplitude_m"] / 2.0 + row["z_m"]


TABLE_1 = (
    Printed("x_F", "downstream of the leader", "m", 2, _column("x_m"), (1.83,)),
    Printed("y_F", "to the right of the leader", "m", 3, _column("y_m"), (0.882,)),
    Printed("z_F", "height, the leader's being h_L/2", "m", 3, _height_m, (0.457,)),
    Printed("R_F", "upstroke span ratio", "", 3, _column("upstroke_span_ratio"), (0.347,)),
    Printed("h_F", "tip-to-tip amplitude", "m", 3, _column("amplitude_m"), (0.751,)),
    Printed("κ_F", "phase", "", 3, _column("phase"), (0.500,)),
    Printed("I_z/T", "self-generated lift", "N", 2, _column("lift_self_n"), (12.17,)),
    Printed("I_x/T", "self-generated thrust", "N", 2, _column("thrust_self_n"), (1.89,)),
)
"""The follower's column of Table 1."""

IN_TEXT = ("text", "text")

PRINTED_VARIOUSLY = (
    Printed("y_F", "to the right", "m", 3, _column("y_m"), (0.882, 0.877, 0.886), ("Table 1", *IN_TEXT)),
    Printed("P_ind", "saving of induced power", "%", 0, _percent("saving_induced"), (9.0, 8.0), IN_TEXT),
    Printed("P_pro", "saving of profile power", "%", 0, _percent("saving_profile"), (18.0, 17.0), IN_TEXT),
    Printed("P", "saving of total power", "%", 0, _percent("saving_total"), (11.0,), ("text",)),
)
"""Savings, and what the paper prints with more than one value."""
