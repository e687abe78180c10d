"""Figure: all species on one chart of the dimensionless groups on which a force-optimal pair depends."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, dot, in_percent, letter, styled
from upwash.report.figures.picture import Picture
from upwash.report.figures.species_rows import order_of
from upwash.report.words import common_name, percent
from upwash.study.comparison import compare
from upwash.study.rows import objectives_of

CAPTION = (
    "Each species by its dimensionless groups: (a) wavelength and weight number, (b) wavelength and "
    "amplitude, in semispans. Birds at one point, with equal R_L, have the same solution in semispans and "
    "weights when force is minimised, whatever their size. Colour: share of total power saved at the V "
    "optimum; grey where there is none. Circles: amplitude from the species' own stroke angle, numbered "
    "from the lightest species; small squares above or below them: from the ibis's Strouhal number, which "
    "makes amplitude a fixed part of the wavelength."
)

# In points: how far a number may stand from its mark, the room that it needs, and about how large a panel is
# between its outermost points.
LABEL_DISTANCES_PT = (7.5, 11.0, 15.0)
LABEL_ROOM_PT = 7.0
PANEL_PT = (145.0, 200.0)


def _chosen(species: pd.DataFrame, samples: pd.DataFrame | None) -> pd.DataFrame:
    compared = compare(species, samples)
    return compared[compared["objective"] == objectives_of(compared)[0]]


def describe(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    compared = _chosen(species, samples)
    ranges = [
        f"{words} {compared[name].min():.2f} to {compared[name].max():.2f}"
        for name, words in (
            ("wavelength_number", "wavelength"),
            ("amplitude_number", "amplitude"),
        )
    ]
    most = compared.sort_values("saving_total", na_position="first").iloc[-1]
    return (
        f"A chart of {compared['species'].nunique()} species: weight number {compared['weight_number'].min():.3f} "
        f"to {compared['weight_number'].max():.3f}, {' and '.join(ranges)} semispans. The "
        f"{common_name(most['species']).lower()} saves most, {percent(most['saving_total'], 1)}, at weight number "
        f"{most['weight_number']:.3f} and wavelength {most['wavelength_number']:.2f} semispans."
    )


@styled
def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw the chart of dimensionless groups."""
    compared, order = _chosen(species, samples), order_of(species)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.8), layout="constrained")
    panels = figure.subplots(1, 2)
    norm = Normalize(0.0, compared["saving_total"].max())
    for axes, second in zip(panels, ("weight_number", "amplitude_number"), strict=True):
        for convention, rows in compared.groupby("amplitude_convention", sort=False):
            own = convention == compared["amplitude_convention"].iloc[0]
            if second == "weight_number" and not own:
                continue  # the weight number does not depend on the amplitude
            look = {
                "marker": "o" if own else "s",
                "s": 34 if own else 16,
                "edgecolors": "black",
                "linewidths": 0.4,
            }
            axes.scatter(rows["wavelength_number"], rows[second], color=FAINT, **look)
            axes.scatter(
                rows["wavelength_number"],
                rows[second],
                c=rows["saving_total"],
                norm=norm,
                zorder=3,
                gid=f"{second} {convention}",
                **look,
            )
            if own:
                numbers = [order.index(species) + 1 for species in rows["species"]]
                every = compared[["wavelength_number", second]].to_numpy()
                _number(axes, rows[["wavelength_number", second]].to_numpy(), numbers, every)
        axes.set_xlabel("λ/b")
    panels[0].set_ylabel("$W/(ρ b^2 U^2)$")
    panels[1].set_ylabel("$h_L/b$")
    letter(panels[0], "a", "Weight and wavelength")
    letter(panels[1], "b", "Amplitude and wavelength")
    bar = figure.colorbar(
        ScalarMappable(norm), ax=panels, location="right", label="total power saved", aspect=30
    )
    in_percent(bar.ax.yaxis)
    entries = [dot(f"{number}  {common_name(name)}") for number, name in enumerate(order, 1)]
    figure.legend(
        handles=entries, loc="outside lower center", ncols=4, handlelength=0, handletextpad=0, fontsize=6.5
    )
    return figure


def _number(axes: Axes, points: np.ndarray, numbers: list[int], every: np.ndarray) -> None:
    """Write a number beside each point, as near as there is room, with a line to it if it stands apart.

    Parameters
    ----------
    axes : Axes
        Where.
    points : (n, 2) ndarray of float
        The points.
    numbers : list of int
        Their numbers.
    every : (m, 2) ndarray of float
        All points that the panel shows.
    """
    axes.margins(0.1)
    angles = np.arange(0.0, 2.0 * np.pi, np.pi / 8.0)
    around = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    low, high = every.min(axis=0), every.max(axis=0)
    taken = list((every - low) / (high - low) * PANEL_PT)
    for point, place, number in zip(points, (points - low) / (high - low) * PANEL_PT, numbers, strict=True):
        others = np.array([point_taken for point_taken in taken if not np.array_equal(point_taken, place)])
        for distance in LABEL_DISTANCES_PT:
            room = np.linalg.norm(place + distance * around[:, None] - others, axis=-1).min(axis=1)
            if room.max() >= LABEL_ROOM_PT:
                break
        offset = distance * around[np.argmax(room)]
        taken.append(place + offset)
        is_apart = distance > LABEL_DISTANCES_PT[0]
        axes.annotate(
            str(number),
            point,
            offset,
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=6,
            zorder=4,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "shrinkA": 1.0, "shrinkB": 2.5}
            if is_apart
            else None,
        )


PICTURE = Picture("species-groups", "Species: one chart for all", CAPTION, describe, draw)
