"""Figure: what a follower saves at each place of a plane, the best place, and birds that were observed."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from upwash.place.choices import COORDINATES
from upwash.report.figures.drawing import (
    LEADER,
    OBSERVED,
    PAGE_WIDTH_IN,
    dot,
    in_percent,
    legend_below,
    styled,
)
from upwash.report.words import common_name, least, percent
from upwash.study.saving_map import NAMES, SavingMap
from upwash.study.told import NO_BALANCE

AXES = {
    "x": "x, behind the leader (m)",
    "y": "y, to the right of it (m)",
    "z": "z, above it (m)",
    "phase": "κ, lag (wingbeats)",
}
WAKES = {"paper": "the paper's wake", "limit": "the limit's wake"}
SAVING, PAYING, UNBALANCED = ("#ffffff", "#56B4E9", "#0072B2", "#002b49"), "#f6d9b8", "#c4c4c4"
PAYS_HATCH, UNBALANCED_HATCH = "....", "xxxx"
BEST = "#D55E00"
STEPS = np.array([0.005, 0.01, 0.02, 0.025, 0.05, 0.1])
"""Steps that contours may have."""

MOST_CONTOURS = 6

# Share of the places that may save more than the colours tell: the paper's optima are a few centimetres wide.
CLIPPED = 0.002


@styled
def draw_saving_map(
    found: SavingMap, species: str, model: str, observed: NDArray[np.float64] | None = None
) -> Figure:
    """Draw a map of savings.

    Parameters
    ----------
    found : SavingMap
        The map.
    species : str
        Of whom it is.
    model : str
        What the wake's model is called: ``paper``, ``limit`` or ``given``.
    observed : (n, 4) ndarray of float, optional
        Places of observed birds: x, y, z in m and phase; those that lack a coordinate of the plane are left out.

    Returns
    -------
    Figure
        The figure.
    """
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.2), layout="constrained")
    axes = figure.subplots()
    saving, first, second = found.values["saving_total"], found.first, found.second
    lacks = found.values["outcome"] == NO_BALANCE
    known = np.ma.masked_invalid(saving)
    positive = saving[saving > 0.0]
    highest = float(np.quantile(positive, 1.0 - CLIPPED)) if positive.size else 0.01
    extent = (*_edges(first), *_edges(second))
    colours = LinearSegmentedColormap.from_list("saving", SAVING).with_extremes(under=PAYING, bad=UNBALANCED)
    image = axes.imshow(
        known,
        origin="lower",
        extent=extent,
        aspect="auto",
        norm=Normalize(0.0, highest),
        cmap=colours,
        interpolation="nearest",
    )
    zones: list[Any] = []
    for zone, colour, hatch, label in (
        (saving <= 0.0, PAYING, PAYS_HATCH, "pays"),
        (lacks, UNBALANCED, UNBALANCED_HATCH, "cannot balance"),
    ):
        if np.any(zone):
            axes.contourf(
                first, second, zone.astype(float), [0.5, 1.5], colors="none", hatches=[hatch]
            ).set_edgecolor("#8a6a3f" if hatch == PAYS_HATCH else "#777777")
            zones.append(Patch(facecolor=colour, edgecolor="#777777", hatch=hatch, label=label))
    levels = _levels(highest)
    if known.count() and known.min() < highest:
        axes.contour(first, second, known, [0.0], colors="black", linewidths=0.9)
        lines = axes.contour(first, second, known, levels, colors="black", linewidths=0.4)
        digits = 0 if np.allclose(levels, np.round(levels, 2)) else 1
        for text in axes.clabel(lines, fmt=lambda value: percent(value, digits), fontsize=6):
            text.set_path_effects([withStroke(linewidth=1.5, foreground="white")])
    bar = figure.colorbar(image, ax=axes, extend="max", aspect=30, pad=0.02, label="saving of power")
    in_percent(bar.ax.yaxis)
    labels = [*_marks(axes, found, observed), *zones]
    axes.set_xlim(extent[0], extent[1])
    axes.set_ylim(extent[2], extent[3])
    axes.set_xlabel(AXES[found.asked.sides[0]])
    axes.set_ylabel(AXES[found.asked.sides[1]])
    axes.set_title(
        f"{common_name(species)}, {least(found.objective)}, {WAKES.get(model, 'a wake as given')}, "
        f"{_of_the_rest(found)}"
    )
    legend_below(figure, labels, len(labels))
    return figure


def _edges(values: NDArray[np.float64]) -> tuple[float, float]:
    """Return where the first and the last cell of an axis end."""
    half = 0.5 * (values[1] - values[0])
    return float(values[0] - half), float(values[-1] + half)


def _levels(highest: float) -> NDArray[np.float64]:
    """Return round savings at which contours are drawn."""
    step = next((one for one in STEPS if highest / one <= MOST_CONTOURS), STEPS[-1])
    return np.arange(1, max(int(highest / step), 1) + 1) * step


def _of_the_rest(found: SavingMap) -> str:
    """Say what is optimised at each place, and what is held."""
    words = {"x": "distance", "y": "distance aside", "z": "height", "phase": "phase"}
    units = {"x": " m", "y": " m", "z": " m", "phase": ""}
    symbols = {"phase": "κ"}
    free = [words[name] for name in found.asked.free]
    parts = [f"best {' and '.join(free)}"] if free else []
    parts += [f"{symbols.get(name, name)} = {value:.2f}{units[name]}" for name, value in found.held.items()]
    return ", ".join(parts)


def _marks(axes: Axes, found: SavingMap, observed: NDArray[np.float64] | None) -> list[Any]:
    """Draw the leader, the best places and the observed birds; return what the legend says of them."""
    sides = [COORDINATES.index(name) for name in found.asked.sides]
    shown: list[Any] = []
    look: dict[str, Any]
    first, second = found.first, found.second
    if observed is not None:
        places = observed.copy()
        if found.second[0] >= 0.0 and found.asked.plane == "xy":
            places[:, 1] = np.abs(places[:, 1])
        across, up = places[:, sides].T
        within = (across >= first[0]) & (across <= first[-1]) & (up >= second[0]) & (up <= second[-1])
        look = {"marker": "o", "color": OBSERVED, "markeredgecolor": "white", "markeredgewidth": 0.5}
        axes.plot(across[within], up[within], linestyle="none", markersize=4.5, gid="observed", **look)
        shown.append(dot(f"observed ({within.sum()} of {len(places)})", **look))
    place: tuple[float, ...]
    marks: list[tuple[str, dict[str, Any], tuple[float, ...]]] = []
    white = {"markeredgecolor": "white", "markeredgewidth": 0.6}
    if found.asked.plane in ("xy", "xz"):
        marks.append(
            ("leader", {"marker": "D", "color": LEADER, "markersize": 5} | white, (0.0, 0.0, 0.0, 0.0))
        )
    if found.shows_optimum() and found.optimum is not None:
        place = (*found.optimum.position_m, found.optimum.phase)
        marks.append(("V optimum", {"marker": "*", "color": BEST, "markersize": 9} | white, place))
    if best := found.best():
        place = tuple(best[name] for name in NAMES.values())
        marks.append(("best of the map", {"marker": "P", "color": BEST, "markersize": 8} | white, place))
    for label, look, place in marks:
        at = [place[side] for side in sides]
        # What lies beyond the map would make it small.
        if first[0] <= at[0] <= first[-1] and second[0] <= at[1] <= second[-1]:
            axes.plot(*at, linestyle="none", clip_on=False, zorder=4, gid=label, **look)
            shown.append(dot(label, **look))
    return shown
