"""Rows of species in a figure: one line each, a mark for each cost and amplitude convention, intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from upwash.report.figures.drawing import FAINT, OBJECTIVE_LABELS, OBJECTIVES
from upwash.study.sources import common_name, objectives_of

CONVENTIONS = {"stroke-angle": "own stroke angle", "strouhal": "ibis's Strouhal number"}
"""Amplitude conventions in words; the first is drawn filled, any other hollow."""

ROW_IN = 0.21
"""Height of a species' line, in inches."""


def order_of(species: pd.DataFrame) -> list[str]:
    """Return the species from the lightest to the heaviest."""
    return species.groupby("species")["mass_kg"].first().sort_values(kind="stable").index.tolist()


def row_height(species: pd.DataFrame) -> float:
    """Return the height of all lines together, in inches."""
    return ROW_IN * species["species"].nunique()


def draw_rows(
    axes: Axes, table: pd.DataFrame, column: str, order: Sequence[str], factor: float = 1.0
) -> None:
    """Draw one quantity of every species: marks, and a line for its interval where the table has one.

    Parameters
    ----------
    axes : Axes
        Where.
    table : DataFrame
        One row for each species, objective and amplitude convention, as from
        `upwash.study.comparison.compare`.
    column : str
        The quantity; ``column_low`` and ``column_high`` hold its interval.
    order : sequence of str
        The species, from the lowest line up.
    factor : float
        By which values are multiplied.
    """
    groups = list(table.groupby(["objective", "amplitude_convention"], sort=False))
    for number, ((objective, convention), rows) in enumerate(groups):
        # Marks of one line stand a little apart, so that none hides another.
        shift = 0.5 * ((number + 0.5) / len(groups) - 0.5)
        line = np.array([order.index(name) for name in rows["species"]]) + shift
        style = OBJECTIVES[str(objective)]
        filled = convention == next(iter(CONVENTIONS))
        values = factor * rows[column].to_numpy(dtype=float)
        axes.plot(
            values,
            line,
            linestyle="none",
            marker=style["marker"],
            markersize=4,
            color=style["color"],
            markerfacecolor=style["color"] if filled else "white",
            markeredgewidth=0.8,
            zorder=3,
            gid=f"{column} {objective} {convention}",
        )
        if f"{column}_low" in rows:
            low, high = (factor * rows[f"{column}_{end}"].to_numpy(dtype=float) for end in ("low", "high"))
            axes.hlines(line, low, high, color=style["color"], linewidth=0.7, alpha=0.7, zorder=2)
    axes.set_ylim(-0.6, len(order) - 0.4)


def name_rows(axes: Axes, order: Sequence[str]) -> None:
    """Write the species' names at the left, and faint lines to lead the eye."""
    axes.set_yticks(range(len(order)), [common_name(name) for name in order])
    axes.tick_params(axis="y", length=0)


def guide(panels: Sequence[Axes], order: Sequence[str]) -> None:
    """Draw a faint line under each species in all panels."""
    for axes in panels:
        axes.set_axisbelow(True)
        for line in range(len(order)):
            axes.axhline(line, color=FAINT, alpha=0.25, linewidth=0.5, zorder=0)
        axes.tick_params(axis="y", length=0)


def add_legend(figure: Figure, table: pd.DataFrame, extra: Sequence[Line2D] = ()) -> None:
    """Explain the marks of `draw_rows` below a figure."""
    entries = []
    for objective in objectives_of(table):
        for convention in table["amplitude_convention"].unique():
            style: dict[str, Any] = OBJECTIVES[objective]
            filled = convention == next(iter(CONVENTIONS))
            entries.append(
                Line2D(
                    [],
                    [],
                    linestyle="none",
                    marker=style["marker"],
                    color=style["color"],
                    markerfacecolor=style["color"] if filled else "white",
                    label=f"{OBJECTIVE_LABELS[objective]}, {CONVENTIONS.get(convention, convention)}",
                )
            )
    figure.legend(handles=[*entries, *extra], loc="outside lower center", ncols=2)
