"""Figure: what is saved, and where, as the paper's model is refined in states, points of the span and wavelengths."""

from __future__ import annotations

from math import inf
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import (
    FAINT,
    LOOKS,
    PAGE_WIDTH_IN,
    dot,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.report.words import percent

CAPTION = (
    "Least power. From left to right one thing is refined: the states in which a wingbeat is told (a, d), the "
    "points of the span at which the wake is felt (b, e), the length of the wake in wavelengths (c, f); the "
    "other two are the paper's or the finest that were solved. Above: power saved; below: how far aside. "
    "Filled: the V optimum; hollow: the best place of all. Where there is no V optimum its line breaks. Grey: "
    "the limit, by the tip law of the span."
)
AXES = {
    "stroke_states": "states of a wingbeat",
    "span_nodes": "points of the span",
    "wavelengths": "wavelengths of wake",
}
"""What is refined -> its words."""

OTHERS: dict[str, dict[str, Any]] = {"others as in the paper": LOOKS[0], "others refined": LOOKS[1]}
KINDS = {"is_v_optimum": None, "is_global_optimum": "white"}
"""Label of an optimum -> what its marks are filled with, if not with their colour."""

QUANTITIES = {"saving_total": "power saved", "y_semispans": "y/b, to the right"}


def ladder(refinement: pd.DataFrame, axis: str, refined: bool) -> pd.DataFrame:
    """Return the optima of least power as one thing is refined and the others are coarsest or finest.

    Parameters
    ----------
    refinement : DataFrame
        All optima of one bird behind wakes that end, and in the limit.
    axis : str
        What is refined, a key of `AXES`.
    refined : bool
        Whether the others are the finest that were solved, or the coarsest.

    Returns
    -------
    DataFrame
        V optima and global optima, by the value refined.
    """
    rows = _ending(refinement)
    for other in AXES:
        if other != axis:
            rows = rows[rows[other] == (rows[other].max() if refined else rows[other].min())]
    is_shown = rows["is_v_optimum"].eq(True) | rows["is_global_optimum"].eq(True)
    return rows[is_shown].sort_values(axis, kind="stable")


def _ending(refinement: pd.DataFrame) -> pd.DataFrame:
    rows = refinement.assign(y_semispans=refinement["y_m"] / refinement["semispan_m"])
    return rows[(rows["objective"] == "power") & (rows["wavelengths"] < inf)]


def limit_of(refinement: pd.DataFrame) -> pd.Series | None:
    """Return the V optimum of least power in the limit by the tip law, or None if it was not solved."""
    rows = refinement.assign(y_semispans=refinement["y_m"] / refinement["semispan_m"])
    rows = rows[
        (rows["wavelengths"] == inf) & (rows["objective"] == "power") & (rows["stroke_rule"] == "gauss")
    ]
    rows = rows[(rows["span_law"] == "tip") & rows["is_v_optimum"].eq(True)]
    return None if rows.empty else rows.sort_values("stroke_states", kind="stable").iloc[-1]


def describe(refinement: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for axis, words in AXES.items():
        for others, refined in zip(OTHERS, (False, True), strict=True):
            of_v = ladder(refinement, axis, refined)
            of_v = of_v[of_v["is_v_optimum"].eq(True)]
            told = ", ".join(
                f"{percent(saving, 1)} with {value:g}"
                for value, saving in zip(of_v[axis], of_v["saving_total"], strict=True)
            )
            parts.append(f"{words}, {others}: {told or 'no V optimum'}")
    limit = limit_of(refinement)
    end = "" if limit is None else f" In the limit it saves {percent(limit['saving_total'], 1)}."
    return f"What the V optimum of least power saves as the model is refined. {'; '.join(parts)}.{end}"


@styled
def draw(refinement: pd.DataFrame) -> Figure:
    """Draw saving and place against each of the three things that are refined."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.4), layout="constrained")
    panels = figure.subplots(len(QUANTITIES), len(AXES), sharey="row")
    limit = limit_of(refinement)
    names = iter("abcdef")
    for line, (quantity, label) in zip(panels, QUANTITIES.items(), strict=True):
        for axes, (axis, words) in zip(line, AXES.items(), strict=True):
            _draw_ladders(axes, refinement, axis, quantity)
            if limit is not None:
                axes.axhline(
                    limit[quantity],
                    color=FAINT,
                    linewidth=1.0,
                    linestyle="--",
                    gid=f"limit {quantity} {axis}",
                )
            axes.set_xlabel(words)
            letter(axes, next(names), words.partition(" ")[0].capitalize())
        line[0].set_ylabel(label)
    in_percent(panels[0, 0].yaxis)
    panels[0, 0].set_ylim(bottom=min(0.0, panels[0, 0].get_ylim()[0]))
    kinds = [
        dot("V optimum", color=FAINT, marker="o"),
        dot("best of all", color=FAINT, marker="o", markerfacecolor="white"),
    ]
    others = [dot(name, **{**look, "linestyle": "none"}) for name, look in OTHERS.items()]
    legend_below(figure, [*others, *kinds], 4)
    return figure


def _draw_ladders(axes: Axes, refinement: pd.DataFrame, axis: str, quantity: str) -> None:
    values = sorted(_ending(refinement)[axis].unique())
    for refined, (others, look) in enumerate(OTHERS.items()):
        found = ladder(refinement, axis, bool(refined))
        for kind, face in KINDS.items():
            of_kind = found[found[kind].eq(True)].groupby(axis)[quantity].first().reindex(values)
            style = {**look, "linestyle": look["linestyle"] if face is None else "none"}
            axes.plot(
                np.arange(len(values)),
                of_kind.to_numpy(float),
                **style,
                markersize=5 if face is None else 8,
                markerfacecolor=face or look["color"],
                gid=f"{quantity} {axis} {others} {kind}",
            )
    axes.set_xticks(range(len(values)), [f"{value:g}" for value in values])
    axes.set_xlim(-0.4, len(values) - 0.6)


PICTURE = Picture("refinement", "What refining does", CAPTION, describe, draw)
