"""Figure: what each place in a flock saves, and what flocks gain by taking turns at the front."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, in_percent, legend_below, letter, styled
from upwash.report.figures.flocks import READINGS, look_of, papers_flocks, series
from upwash.report.figures.picture import Picture
from upwash.report.words import least, percent

CAPTION = (
    "(a) Total power that each bird saves. (b) The mean over a flock of each size, that is what every bird "
    "saves when all take equal turns in each place; a bird's saving depends on the birds ahead alone, so a "
    "smaller flock is the front of a larger one. (c) The range gained on the same energy. Colours, markers "
    "and filling as in the figure of the flock."
)


def means(birds: pd.DataFrame) -> pd.DataFrame:
    """Return mean saving and range gained by the number of birds.

    Parameters
    ----------
    birds : DataFrame
        One flock, in order, the first bird included.

    Returns
    -------
    DataFrame
        ``size``, ``saving`` (fraction of power), ``range_gain`` (fraction of range), from two birds on.
    """
    size = np.arange(1, len(birds) + 1)
    saving = birds["saving_total"].to_numpy().cumsum() / size
    means_by_size = pd.DataFrame({"size": size, "saving": saving, "range_gain": 1.0 / (1.0 - saving) - 1.0})
    return means_by_size[1:]


def describe(flock: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for objective, reading, birds in series(papers_flocks(flock)):
        last = means(birds).iloc[-1]
        parts.append(
            f"{least(objective)}, {READINGS[reading]['words']}: "
            f"{percent(birds['saving_total'].iloc[1], 1)} for the second bird, "
            f"{percent(birds['saving_total'].iloc[-1], 1)} for the last, "
            f"{percent(last['saving'], 1)} in the mean over {last['size']:.0f} birds, which is "
            f"{percent(last['range_gain'], 1)} more range"
        )
    return "Savings in a flock. " + "; ".join(parts) + "."


@styled
def draw(flock: pd.DataFrame) -> Figure:
    """Draw savings by place, and means by size."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.9), layout="constrained")
    by_place, by_size, gained = figure.subplots(1, 3)
    for objective, reading, birds in series(papers_flocks(flock)):
        look = look_of(objective, reading)
        by_place.plot(birds["bird"], birds["saving_total"], gid=f"saving {objective} {reading}", **look)
        mean = means(birds)
        by_size.plot(mean["size"], mean["saving"], gid=f"mean {objective} {reading}", **look)
        gained.plot(mean["size"], mean["range_gain"], gid=f"range {objective} {reading}", **look)
    _label(by_place, "bird, 1 the first", "total power saved")
    _label(by_size, "birds in the flock", "mean saving, taking turns")
    _label(gained, "birds in the flock", "range gained")
    for axes, name, title in zip(
        (by_place, by_size, gained), "abc", ("By place", "By size", "Range"), strict=True
    ):
        letter(axes, name, title)
    legend_below(figure, by_place, 2)
    return figure


def _label(axes: Axes, across: str, up: str) -> None:
    axes.axhline(0.0, color=FAINT, linewidth=0.6)
    axes.set(xlabel=across, ylabel=up)
    axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    in_percent(axes.yaxis)


PICTURE = Picture("flock-saving", "What flying in a flock is worth", CAPTION, describe, draw)
