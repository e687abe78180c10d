"""Figure: what is left of the saving at the best place while a bird drifts about it, in either model."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import (
    FAINT,
    LOOKS,
    PAGE_WIDTH_IN,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.limit_place import LAWS
from upwash.report.figures.picture import Picture
from upwash.report.words import least, percent
from upwash.study.rows import objectives_of

CAPTION = (
    "The power that a follower at its best place in a V still saves, for each cost (a and so on), while its place "
    "jitters in x, y and z, with independent normal errors of the deviation shown. It flaps always alike, with the "
    "stroke that balances in the mean. At 0 the place is kept. Colours: the paper's model, and the limit by either "
    "law of the wing's span."
)
PAPER = "the paper's model"


def _lines(of_cost: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return what is left by the words of a model, from rest on."""
    lines = {}
    for (model, law), rows in of_cost.groupby(["model", "span_law"], sort=False):
        still = rows.head(1).assign(sigma_m=0.0, saving_held=rows["saving_still"].iloc[0])
        words = PAPER if model == "paper" else f"limit, {law} law"
        lines[words] = pd.concat([still, rows.sort_values("sigma_m")])
    return lines


def look_of(words: str) -> dict[str, Any]:
    """Return how a model's line looks."""
    return LOOKS[0] if words == PAPER else LAWS[words.removeprefix("limit, ").removesuffix(" law")]


def describe(drift: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = [
        f"{least(cost)}, {words}: "
        + ", ".join(
            f"{percent(saving, 1)} at {100.0 * sigma:.3g} cm"
            for sigma, saving in zip(rows["sigma_m"], rows["saving_held"], strict=True)
        )
        for cost in objectives_of(drift)
        for words, rows in _lines(drift[drift["objective"] == cost]).items()
    ]
    return f"Power saved against how far the place jitters. {'; '.join(parts)}."


@styled
def draw(drift: pd.DataFrame) -> Figure:
    """Draw the saving against the deviation of the place, one panel a cost."""
    costs = objectives_of(drift)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.7), layout="constrained")
    panels = figure.subplots(1, len(costs), squeeze=False, sharey=True)[0]
    shown: dict[str, Any] = {}
    for axes, cost, name in zip(panels, costs, "abc", strict=False):
        _draw_cost(axes, drift[drift["objective"] == cost], cost)
        letter(axes, name, least(cost).capitalize())
        shown |= {line.get_label(): line for line in axes.get_legend_handles_labels()[0]}
    panels[0].set_ylabel("power saved")
    in_percent(panels[0].yaxis)
    legend_below(figure, list(shown.values()), 3)
    return figure


def _draw_cost(axes: Axes, of_cost: pd.DataFrame, cost: str) -> None:
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    for words, rows in _lines(of_cost).items():
        axes.plot(
            100.0 * rows["sigma_m"],
            rows["saving_held"],
            **look_of(words),
            label=words,
            gid=f"left {cost} {words}",
        )
    axes.set_xlabel("how far the place jitters: standard deviation (cm)")


PICTURE = Picture("drift", "What is left while the bird drifts", CAPTION, describe, draw)
