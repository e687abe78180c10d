"""Figures of how fast and how far: best speeds and ranges against a flock's size, and a flight's four panels."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from upwash.report.figures.drawing import LEADER, LOOKS, PAGE_WIDTH_IN, legend_below, letter, styled
from upwash.study.best_speed import FLOCK, FOLLOWER

CRITERIA = {"least-power": "least power", "least-transport": "most range"}

ALONE: dict[str, Any] = {"color": LEADER, "linestyle": "--"}

PANELS = (
    ("mass_kg", "Mass", "kg", 1.0),
    ("power_w", "Power, mean of the flock", "W", 1.0),
    ("speed_m_s", "Airspeed", "m/s", 1.0),
    ("y_m", "Bird 2, distance aside", "m", 1.0),
)
"""What the panels of a flight show: column, title, unit, and what it is multiplied by."""


@styled
def draw_speeds(rows: pd.DataFrame) -> Figure:
    """Draw best speed, and range over that of a bird alone, against the size of flocks that take turns.

    Parameters
    ----------
    rows : DataFrame
        As `upwash.study.best_speed.best_speeds` returns.
    """
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.9), layout="constrained")
    panels = figure.subplots(1, 2)
    counted = rows[((rows["who"] == FLOCK) & (rows["turns"] == True)) | (rows["birds"] == 1)]  # noqa: E712
    for look, (criterion, words) in zip(LOOKS, CRITERIA.items(), strict=False):
        of_flocks = counted[counted["criterion"] == criterion]
        of_follower = rows[(rows["criterion"] == criterion) & (rows["who"] == FOLLOWER)]
        for axes, column in zip(panels, ("speed_m_s", "range_ratio"), strict=True):
            axes.plot(of_flocks["birds"], of_flocks[column].astype(float), **look, label=words)
            axes.plot(
                of_follower["birds"],
                of_follower[column].astype(float),
                **look | {"linestyle": "none", "markerfacecolor": "white"},
                label=f"{words}, behind one other",
            )
    letter(panels[0], "a", "Best airspeed")
    panels[0].set_ylabel("m/s")
    letter(panels[1], "b", "Range on the same energy, over alone")
    panels[1].set_ylabel("1")
    for axes in panels:
        axes.set_xlabel("birds that take turns")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    legend_below(figure, panels[0], 2)
    return figure


@styled
def draw_flight(rows: pd.DataFrame) -> Figure:
    """Draw mass, power, airspeed and place against distance, of a flock and of a bird alone.

    Parameters
    ----------
    rows : DataFrame
        As `upwash.study.migration.migrate` returns.
    """
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True).ravel()
    for number, (axes, (column, title, unit, factor)) in enumerate(zip(panels, PANELS, strict=True)):
        for size in rows["birds"].unique():
            flown = rows[(rows["birds"] == size) & rows["mass_kg"].notna()]
            look = ALONE if size == 1 else {**LOOKS[0], "markersize": 3.0}
            label = "alone" if size == 1 else f"flock of {size}, taking turns"
            axes.plot(flown["distance_m"] / 1e3, factor * flown[column].astype(float), **look, label=label)
        letter(axes, "abcd"[number], title)
        axes.set_ylabel(unit)
        if number > 1:
            axes.set_xlabel("distance, km")
    legend_below(figure, panels[0], 2)
    return figure
