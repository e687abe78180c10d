"""Figure: what the V costs more than the best place of all, and what least power changes from least force."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from upwash.report.figures.drawing import (
    FAINT,
    OBJECTIVE_LABELS,
    PAGE_WIDTH_IN,
    in_percent,
    letter,
    percent,
    styled,
)
from upwash.report.figures.species_rows import (
    CONVENTIONS,
    add_legend,
    draw_rows,
    guide,
    name_rows,
    order_of,
    row_height,
)
from upwash.study.comparison import compare, compare_objectives

NAME = "species-gap"
TITLE = "Species: the V against the best, and force against power"
NEEDS = ("species",)
MAY_TAKE = ("samples",)
CAPTION = (
    "(a) By how much the V optimum of each species costs more than the best optimum of all; 0 where they "
    "are one. The others: what changes at the V optimum if power is minimised instead of force, in (b) the "
    "place downstream, (c) the place to the side and (d) the share of total power saved (in percent of the "
    "leader's). Diamonds: power less force; filled and hollow as the marks of (a). The lightest species at "
    "the bottom."
)
CHANGES = (
    ("x_wavelengths_change", "Δx/λ", "Downstream"),
    ("y_semispans_change", "Δy/b", "To the side"),
    ("saving_total_change", "Δ saving", "Power saved"),
)
CHANGE_COLOR = "#000000"


def describe(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    gaps = compare(species, samples).dropna(subset=["v_gap"])
    parts = [
        f"{OBJECTIVE_LABELS[str(objective)]}: {percent(rows['v_gap'].min(), 1)} to "
        f"{percent(rows['v_gap'].max(), 1)}; the two are one in {(rows['v_gap'] <= 0.0).sum()} of {len(rows)} cases"
        for objective, rows in gaps.groupby("objective")
    ]
    return "How much more the V optimum costs than the best of all. " + "; ".join(parts) + "."


@styled
def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw the gaps, and the changes from least force to least power.

    Parameters
    ----------
    species : DataFrame
        All optima of several species.
    samples : DataFrame, optional
        All optima of a study that samples the species' inputs.

    Returns
    -------
    Figure
        The figure.
    """
    found, changes, order = compare(species, samples), compare_objectives(species, samples), order_of(species)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.4 + row_height(species)), layout="constrained")
    panels = figure.subplots(1, 1 + len(CHANGES), sharey=True)
    guide(panels, order)
    draw_rows(panels[0], found, "v_gap", order)
    in_percent(panels[0].xaxis)
    panels[0].set_xlabel("cost above the best's")
    letter(panels[0], "a", "The V's gap")
    for axes, (column, symbol, title), name in zip(panels[1:], CHANGES, "bcd", strict=True):
        _draw_changes(axes, changes, column, order)
        axes.set_xlabel(symbol)
        letter(axes, name, title)
        axes.xaxis.set_major_locator(MaxNLocator(3))
    in_percent(panels[-1].xaxis)
    for axes in panels:
        axes.axvline(0.0, color=FAINT, linewidth=0.7)
    name_rows(panels[0], order)
    mark = Line2D(
        [], [], linestyle="none", marker="D", color=CHANGE_COLOR, markersize=4, label="power less force"
    )
    add_legend(figure, found, [mark])
    return figure


def _draw_changes(axes: Axes, changes: pd.DataFrame, column: str, order: list[str]) -> None:
    for convention, rows in changes.groupby("amplitude_convention", sort=False):
        filled = convention == next(iter(CONVENTIONS))
        line = [order.index(name) + (-0.12 if filled else 0.12) for name in rows["species"]]
        axes.plot(
            rows[column],
            line,
            linestyle="none",
            marker="D",
            markersize=4,
            color=CHANGE_COLOR,
            markerfacecolor=CHANGE_COLOR if filled else "white",
            zorder=3,
            gid=f"{column} {convention}",
        )
        axes.hlines(
            line, rows[f"{column}_low"], rows[f"{column}_high"], color=CHANGE_COLOR, linewidth=0.7, alpha=0.7
        )
