"""Figure: what birds save where they were published to fly, by both models, beside the best place."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import (
    FAINT,
    OBSERVED,
    PAGE_WIDTH_IN,
    dot,
    entry,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name, percent
from upwash.species.library import REFERENCE

CAPTION = (
    "Birds where they were published to fly, for least power, by the paper's model (a) and by the same equations "
    "converged (b). Dot: what a bird saves there if it keeps the best phase; filled if the place was measured, hollow "
    "if it was computed. Line: from the worst phase to the best; bar across it: the mean over all phases, which a bird "
    "saves that keeps none. Star: the best place in a V. Left of zero the follower pays. Where no number is published "
    "a bird is taken to fly level, and one wingspan behind."
)
PANELS = {"paper": "By the paper's model", "limit": "In the limit"}
BEST = "#D55E00"


def describe(observed: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for model, rows in observed.groupby("model", sort=False):
        ibis = rows[(rows["species"] == REFERENCE) & (rows["basis"] == "measured")]
        saved, mean, best = ibis["saving_total"], ibis["saving_mean_phase"], ibis["saving_at_v_optimum"]
        parts.append(
            f"{PANELS[str(model)].lower()} ibises save {percent(saved.min(), 1)} to {percent(saved.max(), 1)} "
            f"where they were measured, if they keep the best phase, {percent(mean.min(), 1)} to "
            f"{percent(mean.max(), 1)} if they keep none, and {percent(best.iloc[0], 1)} at the best place"
        )
    return f"{observed['species'].nunique()} species at published places: " + "; ".join(parts) + "."


@styled
def draw(observed: pd.DataFrame) -> Figure:
    """Draw what is saved at each published place, a panel for each model."""
    places = observed.drop_duplicates(["species", "label", "quantity", "y_m"])[
        ["species", "label", "quantity", "y_m", "basis"]
    ]
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.3 + 0.24 * len(places)), layout="constrained")
    panels = figure.subplots(1, len(PANELS), sharex=True, sharey=True)
    for axes, name, (model, title) in zip(panels, "ab", PANELS.items(), strict=True):
        rows = places.merge(observed[observed["model"] == model], how="left")
        _draw_rows(axes, rows, model)
        letter(axes, name, title)
    panels[0].set_yticks(range(len(places)), [_name(place) for _, place in places.iterrows()])
    panels[0].invert_yaxis()
    look = {"marker": "o", "color": OBSERVED}
    legend_below(
        figure,
        [
            dot("best phase, measured place", **look),
            dot("computed place", **look | {"markerfacecolor": "white"}),
            entry("worst to best phase", color=OBSERVED),
            dot("mean over phases", marker="|", markersize=8, color=OBSERVED),
            dot("best place in a V", marker="*", markersize=8, color=BEST),
        ],
        5,
    )
    return figure


def _draw_rows(axes: Axes, rows: pd.DataFrame, model: str) -> None:
    axes.axvline(0.0, color=FAINT, linewidth=0.7)
    up = range(len(rows))
    axes.plot(rows["saving_at_v_optimum"], up, "*", color=BEST, markersize=10, gid=f"optimum {model}")
    axes.hlines(up, rows["saving_worst_phase"], rows["saving_total"], color=OBSERVED, gid=f"phases {model}")
    axes.plot(
        rows["saving_mean_phase"],
        up,
        "|",
        color=OBSERVED,
        markersize=9,
        markeredgewidth=1.4,
        gid=f"mean {model}",
    )
    for basis, face in (("measured", OBSERVED), ("computed", "white")):
        chosen = (rows["basis"] == basis).to_numpy()
        axes.plot(
            rows["saving_total"][chosen],
            pd.Series(up)[chosen],
            "o",
            color=OBSERVED,
            markerfacecolor=face,
            gid=f"{basis} {model}",
        )
    axes.set_xlabel("power saved")
    in_percent(axes.xaxis)


def _name(place: pd.Series) -> str:
    return f"{common_name(place['species'])}, {place['y_m']:.2f} m aside ({place['label']})"


PICTURE = Picture("observed-saving", "What birds save where they were seen", CAPTION, describe, draw)
