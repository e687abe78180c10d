"""Figure: every optimum of the problem, where it lies and what it costs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from upwash.optimum.problem import ASTERN, LEVEL, OUTBOARD
from upwash.report.figures.drawing import FAINT, LEADER, PAGE_WIDTH_IN, dot, legend_below, letter, styled
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name, least, percent
from upwash.study.rows import objectives_of

CAPTION = (
    "Every local optimum found under the paper's bounds, for each cost (a and so on), from above and from the "
    "side. Colour: its cost over the leader's, dark the cheapest. Circles fly in antiphase (κ = ½), "
    "triangles in phase (κ = 0), squares between. Ring: the best of those outboard, level and astern, the V "
    "optimum that the paper reports. Cross: the best of all. Grey lines bound what counts as outboard, "
    "level and astern. The paper calls its optimum global; it is not where ring and cross fall apart."
)
CHEAPEST_COLOURS = 0.25
"""Part of the colour map kept off the bright end, where marks would fade into the paper."""

PHASES = {"o": "in antiphase", "^": "in phase", "s": "between"}
SHARP = 0.01
"""Marker -> phase; a phase nearer than this to ½ or 0 counts as that."""


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
    """Draw the map of all optima."""
    objectives = objectives_of(pair)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.9), layout="constrained")
    panels = figure.subplots(2, len(objectives), squeeze=False, sharex=True, sharey="row")
    for column, objective in enumerate(objectives):
        rows = pair[pair["objective"] == objective].sort_values("cost", ascending=False)
        costs = rows["cost"] / rows["cost_leader"]
        norm = Normalize(costs.min(), costs.max() + CHEAPEST_COLOURS * np.ptp(costs))
        above, side = panels[:, column]
        _draw_plane(above, rows, "y_m", rows["semispan_m"].iloc[0], norm)
        _draw_plane(side, rows, "z_m", rows["leader_amplitude_m"].iloc[0], norm)
        b = rows["semispan_m"].iloc[0]
        astern = ASTERN * b / (rows["speed_m_s"] * rows["period_s"]).iloc[0]
        for axes in (above, side):
            axes.axvline(astern, color=FAINT, linewidth=0.7)
        above.axhline(OUTBOARD, color=FAINT, linewidth=0.7)
        for level in (-LEVEL, LEVEL):
            side.axhline(level, color=FAINT, linewidth=0.7)
        letter(
            above,
            "ab"[column] if len(objectives) == 2 else "abc"[column],
            least(objective).capitalize(),
        )
        side.set_xlabel("x/λ, downstream")
        figure.colorbar(
            ScalarMappable(norm),
            ax=panels[:, column],
            location="bottom",
            aspect=35,
            pad=0.02,
            label="cost over the leader's",
        )
    panels[0, 0].set_ylabel("y/b, to the right")
    panels[1, 0].set_ylabel("z/$h_L$, up")
    panels[0, 0].margins(x=0.06, y=0.12)
    panels[1, 0].margins(y=0.12)
    _legend(figure, _markers(pair))
    return figure


def _draw_plane(axes: Axes, rows: pd.DataFrame, second: str, unit: float, norm: Normalize) -> None:
    x, y = rows["x_m"] / (rows["speed_m_s"] * rows["period_s"]), rows[second] / unit
    markers = _markers(rows)
    axes.plot(0.0, 0.0, "D", color=LEADER, markersize=5)
    for marker in PHASES:
        chosen = markers == marker
        if chosen.any():
            axes.scatter(
                x[chosen],
                y[chosen],
                c=(rows["cost"] / rows["cost_leader"])[chosen],
                norm=norm,
                marker=marker,
                s=28,
                edgecolors="black",
                linewidths=0.4,
                zorder=3,
                gid=f"{second} {marker}",
            )
    in_v = rows["is_v_optimum"].fillna(False).astype(bool)
    ring: dict[str, Any] = {
        "facecolors": "none",
        "edgecolors": "#D55E00",
        "linewidths": 1.5,
        "s": 110,
        "zorder": 4,
    }
    axes.scatter(x[in_v], y[in_v], marker="o", gid=f"{second} V optimum", **ring)
    least = rows["rank"] == 0
    axes.scatter(
        x[least], y[least], marker="x", color="#D55E00", linewidths=1.8, s=70, zorder=5, gid=f"{second} best"
    )


def _markers(rows: pd.DataFrame) -> np.ndarray:
    """Return the marker of each optimum, which tells its phase."""
    lag = np.abs(rows["phase"].to_numpy(float) - 0.5)
    return np.where(lag < SHARP, "o", np.where(lag > 0.5 - SHARP, "^", "s"))


def _legend(figure: Figure, markers: np.ndarray) -> None:
    look: dict[str, Any] = {"markerfacecolor": FAINT, "markeredgecolor": "black", "markeredgewidth": 0.4}
    entries = [
        dot("leader", marker="D", color=LEADER),
        *(dot(words, marker=marker, **look) for marker, words in PHASES.items() if marker in markers),
        dot("V optimum", marker="o", markersize=10, markerfacecolor="none", markeredgecolor="#D55E00"),
        dot("best of all", marker="x", markersize=8, markeredgewidth=1.8, color="#D55E00"),
    ]
    legend_below(figure, entries, len(entries))


PICTURE = Picture("optima-map", "All the optima, and what each costs", CAPTION, describe, draw)
