"""Figure: what the follower saves as each of the bird's inputs is varied alone."""

from __future__ import annotations

import math
import re

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.columns import Column, column
from upwash.report.figures.drawing import (
    FAINT,
    OBJECTIVES,
    PAGE_WIDTH_IN,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.report.words import least, percent
from upwash.study.rows import objectives_of
from upwash.study.sources import subject, varied_inputs

CAPTION = (
    "Share of the leader's total power that the follower saves at the V optimum, as one input (a and so on) is varied "
    "and all others stay as they are. Upright line: the bird itself. A line breaks where there is no V optimum; "
    "a step is a change from one optimum to another."
)
COLUMNS = 3


def curve(rows: pd.DataFrame, name: str, objective: str) -> pd.DataFrame:
    """Return saving against one varied input: one row a value, NaN where there is no V optimum.

    Parameters
    ----------
    rows : DataFrame
        All optima of problems that differ in one input.
    name : str
        Column of that input.
    objective : str
        Whose optima.

    Returns
    -------
    DataFrame
        ``name`` in increasing order, and ``saving_total``.
    """
    of_it = rows[rows["objective"] == objective]
    saving = of_it[of_it["is_v_optimum"].eq(True)].groupby(name)["saving_total"].first()
    values = sorted(of_it[name].unique())
    return pd.DataFrame({name: values, "saving_total": saving.reindex(values).to_numpy()})


def axis_label(column: Column) -> str:
    """Return the symbol and unit of a column for an axis: its indices set low, its exponents high."""
    symbol = re.sub(r"_(\w{2,})", r"_{\1}", column.head) if column.head else column.name
    symbol = f"${symbol}$" if "_" in column.head else symbol
    unit = column.shown_unit.replace("2", "²").replace("3", "³")
    return f"{symbol} ({unit})" if unit else symbol


def describe(varied: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for name, rows in varied_inputs(varied, subject(varied)).items():
        objective = objectives_of(rows)[0]
        saving = curve(rows, name, objective).dropna()
        first, last = saving.iloc[0], saving.iloc[-1]
        parts.append(
            f"{column(name).label} {first[name]:.3g} to {last[name]:.3g}: {percent(first['saving_total'], 1)} "
            f"to {percent(last['saving_total'], 1)}"
        )
    return f"Savings for {least(objective)} as one input varies. " + "; ".join(parts) + "."


@styled
def draw(varied: pd.DataFrame) -> Figure:
    """Draw saving against every input that is varied alone."""
    base = subject(varied)
    inputs = varied_inputs(varied, base)
    lines = math.ceil(len(inputs) / COLUMNS)
    columns = min(COLUMNS, len(inputs))
    figure = Figure(figsize=(PAGE_WIDTH_IN, 0.6 + 1.9 * lines), layout="constrained")
    panels = figure.subplots(lines, columns, sharey=True, squeeze=False).ravel()
    for axes, (name, rows), panel in zip(panels, inputs.items(), "abcdefghij", strict=False):
        draw_curves(axes, rows, name)
        axes.axvline(base[name].iloc[0], color=FAINT, linewidth=0.7)
        letter(axes, panel, (column(name).label or name).capitalize())
    for axes in panels[len(inputs) :]:
        axes.set_axis_off()
    for axes in panels[: len(inputs) : columns]:
        axes.set_ylabel("total power saved")
    panels[0].set_ylim(bottom=min(0.0, panels[0].get_ylim()[0]))
    legend_below(figure, panels[0], 3)
    return figure


def draw_curves(axes: Axes, rows: pd.DataFrame, name: str) -> None:
    """Draw saving against one input, a line for each objective."""
    for objective in objectives_of(rows):
        saving = curve(rows, name, objective)
        style = OBJECTIVES[objective]
        axes.plot(
            saving[name],
            saving["saving_total"],
            color=style["color"],
            linestyle=style["linestyle"],
            marker=style["marker"],
            markersize=3.5,
            label=least(objective),
            gid=f"{name} {objective}",
        )
    in_percent(axes.yaxis)
    axes.set_xlabel(axis_label(column(name)))


PICTURE = Picture("parameter-saving", "What the saving depends on", CAPTION, describe, draw)
