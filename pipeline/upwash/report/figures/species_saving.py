"""Figure: what the follower of each species saves, in all and by kind of power."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, in_percent, letter, percent, styled
from upwash.report.figures.species_rows import add_legend, draw_rows, guide, name_rows, order_of, row_height
from upwash.study.comparison import compare
from upwash.study.sources import common_name

NAME = "species-saving"
TITLE = "Species: what is saved"
NEEDS = ("species",)
MAY_TAKE = ("samples",)
CAPTION = (
    "Savings at the V optimum of each species, the lightest at the bottom, as fractions of the leader's: "
    "(a) total power, (b) induced power, (c) profile power. Marks and lines as in the figure of the "
    "positions."
)
PANELS = (
    ("saving_total", "Total power"),
    ("saving_induced", "Induced power"),
    ("saving_profile", "Profile power"),
)


def describe(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    found = compare(species, samples).dropna(subset=["saving_total"])
    ordered = found.sort_values("saving_total")
    least, most = ordered.iloc[0], ordered.iloc[-1]
    larger = (found["saving_profile"] > found["saving_induced"]).sum()
    return (
        f"Total savings run from {percent(least['saving_total'], 1)} ({common_name(least['species']).lower()}, least "
        f"{least['objective']}) to {percent(most['saving_total'], 1)} ({common_name(most['species']).lower()}, least "
        f"{most['objective']}). A larger part of profile than of induced power is saved in {larger} of "
        f"{len(found)} cases."
    )


@styled
def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw the savings of all species.

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
    found, order = compare(species, samples), order_of(species)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.3 + row_height(species)), layout="constrained")
    panels = figure.subplots(1, len(PANELS), sharey=True)
    guide(panels, order)
    for axes, (column, title), name in zip(panels, PANELS, "abc", strict=True):
        draw_rows(axes, found, column, order)
        axes.axvline(0.0, color=FAINT, linewidth=0.7)
        in_percent(axes.xaxis)
        axes.set_xlabel("share of the leader's saved")
        letter(axes, name, title)
    name_rows(panels[0], order)
    add_legend(figure, found)
    return figure
