"""Figure: the net force on the follower in three planes through the optimum; also that of a single plane."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from upwash.aero.field_map import PLANES, ForceMap
from upwash.report.figures.drawing import PAGE_WIDTH_IN, letter, mark, styled
from upwash.report.figures.picture import Picture
from upwash.report.words import least
from upwash.study.field import plane_through, ratios
from upwash.study.rows import best, objectives_of

CAPTION = (
    "The follower's own force and the wake's together, in three planes through the optimum, from above (a, b), "
    "from the side (c, d) and by phase (e, f): vertical force over weight (left) and thrust over drag (right). "
    "Colours mean the same in both columns: white, the wake gives nothing there and the bird has its own force alone; "
    "the more orange, the more of what it lacks the wake gives; purple, the wake takes. Black line: exactly what is "
    "needed, 1; it is reached in few places, and at the optimum (dot) in both columns at once. All that is not "
    "on the axes is as at the optimum. The leader (black diamond) is at the origin; in the last row it has "
    "phase 0. Colours end at the limits of the bar; beyond them, near the vortex cores, they stay the same."
)
QUANTITIES = {"lift": "vertical force over weight", "thrust": "thrust over drag"}
TITLES = {"xy": "From above", "xz": "From the side", "xk": "By phase"}
SECOND_LABELS = {"xy": "y/b, to the right", "xz": "z/$h_L$, up", "xk": "κ, phase"}

COLOURS = "PuOr_r"
"""From purple, where the wake takes, over white to orange, where it gives."""

REACH = 1.25
"""Colours end where the wake gives or takes so many times what the bird lacks."""


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    row = best(pair, objectives_of(pair)[0])
    reached = ratios(plane_through(row, "xy", 120), row)
    return (
        f"Six maps. In the plane from above the vertical force runs from {reached['lift'].min():.2f} to "
        f"{reached['lift'].max():.2f} of the weight and the thrust from {reached['thrust'].min():.2f} to "
        f"{reached['thrust'].max():.2f} of the drag. Both are 1 at the optimum, {row['x_m']:.2f} m behind and "
        f"{row['y_m']:.2f} m aside; nearly everywhere else at least one is not enough."
    )


@styled
def draw(pair: pd.DataFrame, size: int = 300) -> Figure:
    """Draw the six force maps."""
    row = best(pair, objectives_of(pair)[0])
    return _draw_maps(row, [plane_through(row, plane, size) for plane in PLANES])


@styled
def draw_plane(plane_map: ForceMap, row: pd.Series) -> Figure:
    """Draw the two maps of one plane.

    Parameters
    ----------
    plane_map : ForceMap
        The map.
    row : Series
        The optimum through which it goes.

    Returns
    -------
    Figure
        The figure.
    """
    return _draw_maps(row, [plane_map])


def _draw_maps(row: pd.Series, maps: list[ForceMap]) -> Figure:
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.0 + 1.75 * len(maps)), layout="constrained")
    panels = figure.subplots(len(maps), 2, squeeze=False, sharex=True)
    values = [ratios(plane_map, row) for plane_map in maps]
    own = {"lift": row["lift_self_n"] / row["weight_n"], "thrust": row["thrust_self_n"] / row["drag_n"]}
    for column, quantity in enumerate(QUANTITIES):
        norm = _norm(own[quantity])
        for line, plane_map in enumerate(maps):
            axes = panels[line, column]
            _draw_map(axes, row, plane_map, values[line][quantity], norm)
            letter(axes, "abcdef"[2 * line + column], f"{TITLES[plane_map.plane]}: {QUANTITIES[quantity]}")
            axes.set_xlabel("x/λ, downstream" if line == len(maps) - 1 else "")
            axes.set_ylabel(SECOND_LABELS[plane_map.plane] if column == 0 else "")
        bar = figure.colorbar(
            ScalarMappable(norm, COLOURS),
            ax=panels[:, column],
            location="bottom",
            aspect=40,
            pad=0.02,
            extend="both",
            label=QUANTITIES[quantity],
        )
        bar.ax.axvline(1.0, color="black", linewidth=1.2)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure


def _norm(own: float) -> Normalize:
    """Colours about the bird's own force, white, as far as what it lacks and a little beyond, both ways."""
    reach = REACH * max(abs(1.0 - own), 0.01)
    return Normalize(own - reach, own + reach)


def _draw_map(axes: Axes, row: pd.Series, plane_map: ForceMap, values: np.ndarray, norm: Normalize) -> None:
    unit = {"xy": row["semispan_m"], "xz": row["leader_amplitude_m"], "xk": 1.0}[plane_map.plane]
    x, second = plane_map.first / (row["speed_m_s"] * row["period_s"]), plane_map.second / unit
    extent = (x[0], x[-1], second[0], second[-1])
    axes.imshow(
        values, origin="lower", extent=extent, aspect="auto", norm=norm, cmap=COLOURS, interpolation="nearest"
    )
    axes.contour(x, second, values, levels=[1.0], colors="black", linewidths=0.8)
    place = {"xy": row["y_m"], "xz": row["z_m"], "xk": row["phase"]}[plane_map.plane] / unit
    axes.plot(
        0.0, 0.0, "D", color="black", markeredgecolor="white", markersize=5, clip_on=False, label="leader"
    )
    look = mark(row["objective"], color="#E69F00", markeredgecolor="black", markersize=5, clip_on=False)
    look["label"] = f"follower, {least(row['objective'])}"
    axes.plot(
        row["x_m"] / (row["speed_m_s"] * row["period_s"]), place, gid=f"optimum {plane_map.plane}", **look
    )


PICTURE = Picture("force-maps", "The force on a follower, place by place", CAPTION, describe, draw)
