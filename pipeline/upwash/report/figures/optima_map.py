"""Figure: the ten cheapest optima of the problem, where each lies, what it is called, and what it costs."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.optimum.problem import ASTERN, LEVEL, OUTBOARD
from upwash.report.figures.drawing import (
    FAINT,
    LEADER,
    LOOKS,
    PAGE_WIDTH_IN,
    dot,
    in_percent,
    legend_below,
    letter,
    mark,
    styled,
)
from upwash.report.figures.marks import tell
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name, least, percent
from upwash.study.rows import objectives_of

CAPTION = (
    "The ten cheapest of the local optima found under the paper's bounds, numbered from the best, for each cost (a and "
    "so on): from above, from the side, and what each costs above the best, with what it is called. Ring: the V "
    "optimum, the best of those outboard, level and astern, which the paper reports. Cross: the best of all. Grey "
    "lines bound what counts as outboard, level and astern. The paper calls its optimum global; it is not where ring "
    "and cross fall apart."
)
SHOWN = 10
"""So many optima are shown, and the V optimum if it is not among them."""

EMPHASIS = LOOKS[0]["color"]
SIDES = ((5, 3), (-5, 3), (5, -9), (-5, -9))
"""Where the number of a mark stands, in points from it; of marks that lie together each takes the next."""

NEAR = (0.03, 0.15)
"""Marks nearer than this in both directions lie together."""


def _best_of(pair: pd.DataFrame, objective: str) -> pd.DataFrame:
    """Return the optima of a cost that are shown, the best first, with where they lie and what they cost."""
    rows = pair[pair["objective"] == objective].sort_values("rank")
    wavelength = rows["speed_m_s"] * rows["period_s"]
    rows = rows.assign(
        above=rows["cost"] / rows["cost"].iloc[0] - 1.0,
        along=rows["x_m"] / wavelength,
        aside=rows["y_m"] / rows["semispan_m"],
        high=rows["z_m"] / rows["leader_amplitude_m"],
        number=range(1, len(rows) + 1),
    )
    return rows[(rows["number"] <= SHOWN) | rows["is_v_optimum"].eq(True)]


def _name(row: pd.Series) -> str:
    return f"{row['number']} {row['placement']}, {row['tier']}, {row['station']}"


def _told(row: pd.Series, objective: str) -> str:
    """Return what is told of an optimum."""
    return (
        f"{_name(row)}: {row['x_m']:.3f} m behind, {row['y_m']:.3f} m aside, {row['z_m']:+.3f} m high, phase "
        f"{row['phase']:.2f}; {percent(row['above'], 2)} above the best {objective.replace('_', ' ')}; saves "
        f"{percent(row['saving_total'], 1)} of the power; job {row['job_id'][:8]}, rank {row['rank']:.0f}"
    )


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for objective in objectives_of(pair):
        rows = pair[pair["objective"] == objective].sort_values("rank")
        in_v = rows[rows["is_v_optimum"].fillna(False).astype(bool)]
        best = rows.iloc[0]
        gap = f"{percent(in_v['cost'].iloc[0] / best['cost'] - 1.0, 2)} above it" if len(in_v) else "missing"
        parts.append(
            f"{least(objective)}: {len(rows)} optima; the best is {best['placement']}, "
            f"{best['tier']} and {best['station']} at {best['x_m']:.2f} m behind and {best['y_m']:.2f} m "
            f"aside, the V optimum is {gap}"
        )
    return f"The optima of a {common_name(pair['species'].iloc[0]).lower()}. " + "; ".join(parts) + "."


@styled
def draw(pair: pd.DataFrame) -> Figure:
    """Draw the map of the best optima."""
    objectives = objectives_of(pair)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 5.6), layout="constrained")
    panels = figure.subplots(3, len(objectives), squeeze=False, height_ratios=(1.0, 1.0, 1.1))
    for column, objective in enumerate(objectives):
        rows = _best_of(pair, objective)
        above, side, costs = panels[:, column]
        _draw_plane(above, rows, "aside", objective)
        _draw_plane(side, rows, "high", objective)
        astern = (ASTERN * rows["semispan_m"] / (rows["speed_m_s"] * rows["period_s"])).iloc[0]
        for axes in (above, side):
            axes.axvline(astern, color=FAINT, linewidth=0.7)
            axes.set_xlabel("x/λ, downstream")
        above.axhline(OUTBOARD, color=FAINT, linewidth=0.7)
        for level in (-LEVEL, LEVEL):
            side.axhline(level, color=FAINT, linewidth=0.7)
        _draw_costs(costs, rows, objective)
        letter(above, "abc"[column], least(objective).capitalize())
    panels[0, 0].set_ylabel("y/b, to the right")
    panels[1, 0].set_ylabel("z/$h_L$, up")
    entries = [
        dot("leader", marker="D", color=LEADER),
        *(dot(**mark(one)) for one in objectives),
        dot("V optimum", marker="o", markersize=10, markerfacecolor="none", markeredgecolor=EMPHASIS),
        dot("best of all", marker="x", markersize=8, markeredgewidth=1.8, color=EMPHASIS),
    ]
    legend_below(figure, entries, len(entries))
    return figure


def _draw_plane(axes: Axes, rows: pd.DataFrame, second: str, objective: str) -> None:
    axes.plot(0.0, 0.0, "D", color=LEADER, markersize=5)
    points = axes.plot(rows["along"], rows[second], **mark(objective), zorder=3, gid=f"{second} optima")[0]
    tell(points, [_told(row, objective) for _, row in rows.iterrows()])
    placed: list[tuple[float, float]] = []
    for _, row in rows.iterrows():
        at = float(row["along"]), float(row[second])
        crowded = sum(abs(at[0] - x) < NEAR[0] and abs(at[1] - y) < NEAR[1] for x, y in placed)
        placed.append(at)
        axes.annotate(
            str(row["number"]),
            at,
            SIDES[crowded % len(SIDES)],
            textcoords="offset points",
            ha="left" if crowded % 2 == 0 else "right",
            fontsize=6.5,
        )
    _emphasise(axes, rows, "along", second)
    axes.margins(x=0.08, y=0.16)


def _emphasise(axes: Axes, rows: pd.DataFrame, first: str, second: str) -> None:
    """Ring the V optimum and cross the best of all."""
    ring: dict[str, Any] = {"facecolors": "none", "edgecolors": EMPHASIS, "linewidths": 1.5, "s": 110}
    in_v, is_best = rows[rows["is_v_optimum"].eq(True)], rows[rows["rank"] == 0]
    axes.scatter(in_v[first], in_v[second], marker="o", zorder=4, **ring)
    axes.scatter(is_best[first], is_best[second], marker="x", color=EMPHASIS, linewidths=1.8, s=70, zorder=5)


def _draw_costs(axes: Axes, rows: pd.DataFrame, objective: str) -> None:
    """Draw what each optimum costs above the best, with its name."""
    lines = list(range(len(rows)))
    points = axes.plot(rows["above"], lines, **mark(objective), zorder=3, gid="costs")[0]
    tell(points, [_told(row, objective) for _, row in rows.iterrows()])
    _emphasise(axes, rows.assign(line=lines), "above", "line")
    axes.set_yticks(lines, [_name(row) for _, row in rows.iterrows()])
    axes.tick_params(axis="y", labelsize=6.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.margins(x=0.08)
    in_percent(axes.xaxis)
    axes.set_xlabel(f"{objective.replace('_', ' ')} above that of the best")


PICTURE = Picture("optima-map", "The best places, and what each costs", CAPTION, describe, draw)
