"""Figure: where a follower should fly in the paper's model and in the limit, to scale, and what it saves there."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.aero.wake import ROLL_UP
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    FAINT,
    LEADER,
    LOOKS,
    OBSERVED,
    PAGE_WIDTH_IN,
    draw_bird,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.optimal_position import measured
from upwash.report.figures.picture import Picture
from upwash.report.words import percent
from upwash.study.rows import Row, best

CAPTION = (
    "Least power, from above and to scale. (a) The V optimum of the paper's model. (b) The V optima of the limit,"
    " by either law of the follower's span: no distance is better than another there, so that each is a line, and"
    " the bird is drawn at half a wavelength. Green: the tip vortices of the leader's downstroke. Diamonds: "
    "measured on birds, hollow where computed from other measurements. (c) The power that the follower saves."
)
LAWS = {"stroke": LOOKS[1], "tip": LOOKS[2]}
"""Span law -> how its lines and marks look."""


def places(pair: pd.DataFrame, limit: pd.DataFrame) -> dict[str, Row]:
    """Return the V optima of least power, of the paper's model and of the limit by each span law."""
    of_v = limit[(limit["objective"] == "power") & limit["is_v_optimum"].eq(True)]
    by_law = {row["span_law"]: row for _, row in of_v.iterrows()}
    found: dict[str, Row] = {"the paper's model": best(pair, "power")}
    return found | {f"{law} law": by_law[law] for law in LAWS}


def describe(pair: pd.DataFrame, limit: pd.DataFrame, observations: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    found = places(pair, limit)
    first, *others = found.items()
    told = [
        f"{row['y_m'] / row['semispan_m']:.2f} b aside by the {name}, saving {percent(row['saving_total'], 1)}"
        for name, row in others
    ]
    row = first[1]
    return (
        f"In the paper's model the best V is {row['x_m'] / row['semispan_m']:.2f} b behind and "
        f"{row['y_m'] / row['semispan_m']:.2f} b aside and saves {percent(row['saving_total'], 1)} of the power. "
        f"In the limit it is {' and '.join(told)}, at any distance."
    )


@styled
def draw(pair: pd.DataFrame, limit: pd.DataFrame, observations: pd.DataFrame) -> Figure:
    """Draw the V of either model from above, and their savings."""
    found = places(pair, limit)
    paper, *laws = found.items()
    seen = measured(observations, str(paper[1]["species"]))
    figure = Figure(figsize=(PAGE_WIDTH_IN, 3.1), layout="constrained")
    panels = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 0.55))
    _draw_above(panels[0], [paper], seen, "a", "The paper's model")
    _draw_above(panels[1], laws, seen, "b", "The limit")
    _draw_savings(panels[2], found)
    handles = {
        handle.get_label(): handle for axes in panels[:2] for handle in axes.get_legend_handles_labels()[0]
    }
    legend_below(figure, list(handles.values()), 4)
    return figure


def look_of(name: str) -> dict[str, Any]:
    """Return how marks of a model look."""
    return LAWS.get(name.removesuffix(" law"), LOOKS[0])


def _draw_above(
    axes: Axes, found: list[tuple[str, Row]], seen: list[tuple[float, float, bool]], name: str, title: str
) -> None:
    first = found[0][1]
    b, length = first["semispan_m"], 0.8
    draw_bird(axes, 0.0, 0.0, 1.0, length)
    axes.plot(0.0, 0.0, "D", color=LEADER, markersize=4, linestyle="none", label="leader")
    for side in (1.0, -1.0):
        label = "leader's vortices" if side > 0.0 else None
        axes.plot(
            [0.0 if name == "a" else -0.7, 5.5],
            [side * ROLL_UP] * 2,
            color=DOWNSTROKE,
            linewidth=1.0,
            alpha=0.7,
            label=label,
        )
    for label, row in found:
        look = look_of(label)
        place = row["x_m"] / b, row["y_m"] / b
        draw_bird(axes, *place, 1.0, length, facecolor=look["color"], alpha=0.15)
        if name == "b":
            axes.plot(
                [1.0, 5.5], [place[1]] * 2, **{**look, "marker": ""}, linewidth=1.2, gid=f"ridge {label}"
            )
        axes.plot(
            *place, **{**look, "linestyle": "none"}, markersize=6, label=label, gid=f"place {label}", zorder=4
        )
    shown = set()
    for x, y, is_direct in seen:
        label = "measured on birds" if is_direct else "computed from measurements"
        face: dict[str, Any] = {} if is_direct else {"markerfacecolor": "white"}
        mark = {"color": OBSERVED, "marker": "D", "linestyle": "none", "markersize": 5, **face}
        axes.plot(x / b, y / b, **mark, label=None if label in shown else label, gid="observed", zorder=5)
        shown.add(label)
    axes.set_aspect("equal")
    axes.set(xlim=(-0.7, 5.5), ylim=(-1.3, 3.0), xlabel="x/b, downstream", ylabel="y/b, to the right")
    letter(axes, name, title)


def _draw_savings(axes: Axes, found: dict[str, Row]) -> None:
    for place, (label, row) in enumerate(found.items()):
        color = look_of(label)["color"]
        axes.bar(place, row["saving_total"], color=color, width=0.6, gid=f"saving {label}")
        axes.annotate(
            percent(row["saving_total"], 1),
            (place, row["saving_total"]),
            (0, 2),
            textcoords="offset points",
            ha="center",
        )
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    axes.set_xticks(range(len(found)), ["paper", "stroke\nlaw", "tip\nlaw"])
    in_percent(axes.yaxis)
    axes.margins(y=0.15)
    axes.set_xlim(-0.75, len(found) - 0.25)
    axes.set_ylabel("total power saved")
    letter(axes, "c", "Saving")


PICTURE = Picture("limit-place", "The same V, converged", CAPTION, describe, draw)
