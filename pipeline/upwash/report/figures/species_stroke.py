"""Figure: how the follower of each species changes its stroke, and which change is the larger."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import (
    FAINT,
    OBJECTIVES,
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
from upwash.study.comparison import compare
from upwash.study.sources import common_name

NAME = "species-stroke"
TITLE = "Species: how the stroke changes"
NEEDS = ("species",)
MAY_TAKE = ("samples",)
CAPTION = (
    "By how much the follower at the V optimum (a) flaps less far, 1 − h_F/h_L, and (b) flexes its wings "
    "more on the upstroke, 1 − R_F/R_L, the lightest species at the bottom. (c) One against the other: "
    "above the line the amplitude changes more, as the paper says of the ibis. Marks and lines as in the "
    "figure of the positions."
)


def describe(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    found = compare(species, samples).dropna(subset=["amplitude_reduction"])
    larger = found["amplitude_reduction"] > found["span_ratio_reduction"]
    exceptions = ", ".join(sorted(map(common_name, found.loc[~larger, "species"].unique())))
    return (
        f"The amplitude falls by {percent(found['amplitude_reduction'].min())} to "
        f"{percent(found['amplitude_reduction'].max())}, the upstroke span ratio by "
        f"{percent(found['span_ratio_reduction'].min())} to {percent(found['span_ratio_reduction'].max())}. The "
        f"amplitude changes more in {larger.sum()} of {len(found)} cases; "
        f"{f'not always in {exceptions}' if exceptions else 'there is no exception'}."
    )


@styled
def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw the changes of the stroke of all species.

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
    grid = figure.add_gridspec(1, 3, width_ratios=(1.0, 1.0, 1.35))
    amplitude = figure.add_subplot(grid[0])
    flexion = figure.add_subplot(grid[1], sharey=amplitude)
    flexion.tick_params(labelleft=False)
    guide((amplitude, flexion), order)
    for axes, column in ((amplitude, "amplitude_reduction"), (flexion, "span_ratio_reduction")):
        draw_rows(axes, found, column, order)
        axes.axvline(0.0, color=FAINT, linewidth=0.7)
        in_percent(axes.xaxis)
    amplitude.set_xlabel("$1 − h_F/h_L$")
    flexion.set_xlabel("$1 − R_F/R_L$")
    letter(amplitude, "a", "Amplitude less by")
    letter(flexion, "b", "Span ratio less by")
    name_rows(amplitude, order)
    _draw_both(figure.add_subplot(grid[2]), found)
    add_legend(figure, found)
    return figure


def _draw_both(axes: Axes, found: pd.DataFrame) -> None:
    for (objective, convention), rows in found.groupby(["objective", "amplitude_convention"], sort=False):
        style = OBJECTIVES[str(objective)]
        filled = convention == next(iter(CONVENTIONS))
        axes.plot(
            rows["span_ratio_reduction"],
            rows["amplitude_reduction"],
            linestyle="none",
            marker=style["marker"],
            markersize=4,
            color=style["color"],
            markerfacecolor=style["color"] if filled else "white",
            gid=f"both {objective} {convention}",
        )
    axes.axline((0.0, 0.0), slope=1.0, color=FAINT, linewidth=0.8)
    in_percent(axes.xaxis)
    in_percent(axes.yaxis)
    axes.set(xlabel="span ratio less by", ylabel="amplitude less by")
    letter(axes, "c", "Which is the larger change")
