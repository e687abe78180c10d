"""Figures with a line for each species: where it flies, what it saves, how its stroke changes, what the V costs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from upwash.report.figures.drawing import (
    FAINT,
    OBJECTIVES,
    PAGE_WIDTH_IN,
    dot,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name, least, percent
from upwash.study.comparison import compare, compare_objectives
from upwash.study.rows import objectives_of

CONVENTIONS = {"stroke-angle": "own stroke angle", "strouhal": "ibis's Strouhal number", "drag": "drag polar"}
"""Amplitude conventions in words; the first is drawn filled, any other hollow."""

ROW_IN = 0.21
"""Height of a species' line, in inches."""

CHANGE = "change"
"""Stands in the place of the objective where two objectives are set against each other."""


@dataclass(frozen=True)
class Panel:
    """A quantity of every species.

    Parameters
    ----------
    title, label : str
        Over the panel, and under it.
    column : str
        Column of `upwash.study.comparison.compare`, or of `compare_objectives` if it ends in ``_change``.
    is_share : bool
        Whether it is a fraction, shown in percent.
    guide : float or None
        Where an upright line stands.
    guide_style : str
        How that line is drawn.
    most_ticks : int or None
        Largest number of intervals between ticks.
    """

    title: str
    label: str
    column: str
    is_share: bool = False
    guide: float | None = 0.0
    guide_style: str = "-"
    most_ticks: int | None = None


POSITION = (
    Panel("Downstream", "x/λ", "x_wavelengths", guide=0.5, guide_style="--"),
    Panel("Downstream", "x/b", "x_semispans", guide=None),
    Panel("To the side", "y/b", "y_semispans", guide=None),
    Panel("Up", "z/$h_L$", "z_amplitudes", guide_style="--"),
)
SAVING = tuple(
    Panel(f"{part.capitalize()} power", "share of the leader's saved", f"saving_{part}", is_share=True)
    for part in ("total", "induced", "profile")
)
STROKE = (
    Panel("Amplitude less by", "$1 − h_F/h_L$", "amplitude_reduction", is_share=True),
    Panel("Span ratio less by", "$1 − R_F/R_L$", "span_ratio_reduction", is_share=True),
)
GAP = (
    Panel("The V's gap", "cost above the best's", "v_gap", is_share=True),
    Panel("Downstream", "Δx/λ", "x_wavelengths_change", most_ticks=3),
    Panel("To the side", "Δy/b", "y_semispans_change", most_ticks=3),
    Panel("Power saved", "Δ saving", "saving_total_change", is_share=True, most_ticks=3),
)


def order_of(species: pd.DataFrame) -> list[str]:
    """Return the species from the lightest to the heaviest."""
    return species.groupby("species")["mass_kg"].first().sort_values(kind="stable").index.tolist()


def look_of(objective: str, convention: str) -> dict[str, Any]:
    """Return how a mark looks: colour and shape by what is minimised, filled or hollow by the convention."""
    style = {"marker": "D", "color": "#000000"} if objective == CHANGE else OBJECTIVES[objective]
    filled = convention == next(iter(CONVENTIONS))
    return {
        "linestyle": "none",
        "marker": style["marker"],
        "color": style["color"],
        "markerfacecolor": style["color"] if filled else "white",
    }


def add_legend(figure: Figure, table: pd.DataFrame, extra: Sequence[Line2D] = ()) -> None:
    """Explain the marks below a figure."""
    entries = [
        Line2D(
            [],
            [],
            **look_of(objective, convention),
            label=f"{least(objective)}, {CONVENTIONS.get(convention, convention)}",
        )
        for objective in objectives_of(table)
        for convention in table["amplitude_convention"].unique()
    ]
    legend_below(figure, [*entries, *extra], 2)


def _draw_rows(axes: Axes, table: pd.DataFrame, panel: Panel, order: Sequence[str]) -> None:
    """Draw one quantity of every species: marks, and a line for its interval where the table has one."""
    groups = list(table.groupby(["objective", "amplitude_convention"], sort=False))
    for number, ((objective, convention), rows) in enumerate(groups):
        # Marks of one line stand a little apart, so that none hides another.
        shift = 0.5 * ((number + 0.5) / len(groups) - 0.5)
        line = np.array([order.index(name) for name in rows["species"]]) + shift
        look = look_of(str(objective), str(convention))
        axes.plot(
            rows[panel.column].to_numpy(dtype=float),
            line,
            **look,
            markersize=4,
            markeredgewidth=0.8,
            zorder=3,
            gid=f"{panel.column} {objective} {convention}",
        )
        low, high = (rows[f"{panel.column}_{end}"].to_numpy(dtype=float) for end in ("low", "high"))
        axes.hlines(line, low, high, color=look["color"], linewidth=0.7, alpha=0.7, zorder=2)
    axes.set_ylim(-0.6, len(order) - 0.4)


def _draw_panels(
    axes: Sequence[Axes],
    panels: Sequence[Panel],
    species: pd.DataFrame,
    samples: pd.DataFrame | None,
) -> pd.DataFrame:
    """Draw panels side by side, name the species at the left, and return what is compared."""
    compared, order = compare(species, samples), order_of(species)
    is_of_changes = any(panel.column.endswith(CHANGE) for panel in panels)
    changes = compare_objectives(species, samples).assign(objective=CHANGE) if is_of_changes else None
    for panel_axes, panel, name in zip(axes, panels, "abcd", strict=False):
        panel_axes.set_axisbelow(True)
        for line in range(len(order)):
            panel_axes.axhline(line, color=FAINT, alpha=0.25, linewidth=0.5, zorder=0)
        panel_axes.tick_params(axis="y", length=0)
        table = changes if changes is not None and panel.column.endswith(CHANGE) else compared
        _draw_rows(panel_axes, table, panel, order)
        if panel.guide is not None:
            panel_axes.axvline(panel.guide, color=FAINT, linewidth=0.7, linestyle=panel.guide_style)
        if panel.is_share:
            in_percent(panel_axes.xaxis)
        if panel.most_ticks:
            panel_axes.xaxis.set_major_locator(MaxNLocator(panel.most_ticks))
        panel_axes.set_xlabel(panel.label)
        letter(panel_axes, name, panel.title)
    axes[0].set_yticks(range(len(order)), [common_name(name) for name in order])
    return compared


def _figure(species: pd.DataFrame, margin_in: float = 1.3) -> Figure:
    height = margin_in + ROW_IN * species["species"].nunique()
    return Figure(figsize=(PAGE_WIDTH_IN, height), layout="constrained")


def _drawing(panels: Sequence[Panel]) -> Callable[..., Figure]:
    """Return what draws panels of equal width."""

    @styled
    def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
        has_changes = panels[-1].column.endswith(CHANGE)
        figure = _figure(species, 1.4 if has_changes else 1.3)
        compared = _draw_panels(figure.subplots(1, len(panels), sharey=True), panels, species, samples)
        look = look_of(CHANGE, next(iter(CONVENTIONS)))
        extra = [dot("power less force", **look, markersize=4)] if has_changes else []
        add_legend(figure, compared, extra)
        return figure

    return draw


def _describe_position(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    compared = compare(species, samples)
    x, y = compared["x_wavelengths"].dropna(), compared["y_semispans"].dropna()
    return (
        f"The positions of {compared['species'].nunique()} species: {x.min():.2f} to {x.max():.2f} wavelengths "
        f"downstream, half of them within {x.quantile(0.25):.2f} to {x.quantile(0.75):.2f}, and "
        f"{y.min():.2f} to {y.max():.2f} semispans aside."
    )


def _describe_saving(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    ordered = compare(species, samples).dropna(subset=["saving_total"]).sort_values("saving_total")
    least_saved, most_saved = (
        f"{percent(row['saving_total'], 1)} ({common_name(row['species']).lower()}, {least(row['objective'])})"
        for _, row in ordered.iloc[[0, -1]].iterrows()
    )
    larger = (ordered["saving_profile"] > ordered["saving_induced"]).sum()
    return (
        f"Total savings run from {least_saved} to {most_saved}. A larger part of profile than of induced power "
        f"is saved in {larger} of {len(ordered)} cases."
    )


def _describe_stroke(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    compared = compare(species, samples).dropna(subset=["amplitude_reduction"])
    amplitude, span_ratio = compared["amplitude_reduction"], compared["span_ratio_reduction"]
    exceptions = ", ".join(sorted(map(common_name, compared["species"][amplitude <= span_ratio].unique())))
    return (
        f"The amplitude falls by {percent(amplitude.min())} to {percent(amplitude.max())}, the upstroke span "
        f"ratio by {percent(span_ratio.min())} to {percent(span_ratio.max())}. The amplitude changes more in "
        f"{(amplitude > span_ratio).sum()} of {len(compared)} cases; "
        f"{f'not always in {exceptions}' if exceptions else 'there is no exception'}."
    )


@styled
def _draw_stroke(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    figure = _figure(species)
    grid = figure.add_gridspec(1, 3, width_ratios=(1.0, 1.0, 1.35))
    amplitude = figure.add_subplot(grid[0])
    flexion = figure.add_subplot(grid[1], sharey=amplitude)
    flexion.tick_params(labelleft=False)
    compared = _draw_panels((amplitude, flexion), STROKE, species, samples)
    axes = figure.add_subplot(grid[2])
    for (objective, convention), rows in compared.groupby(["objective", "amplitude_convention"], sort=False):
        axes.plot(
            rows["span_ratio_reduction"],
            rows["amplitude_reduction"],
            **look_of(str(objective), str(convention)),
            markersize=4,
            gid=f"both {objective} {convention}",
        )
    axes.axline((0.0, 0.0), slope=1.0, color=FAINT, linewidth=0.8)
    in_percent(axes.xaxis)
    in_percent(axes.yaxis)
    axes.set(xlabel="span ratio less by", ylabel="amplitude less by")
    letter(axes, "c", "Which is the larger change")
    add_legend(figure, compared)
    return figure


def _describe_gap(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    compared = compare(species, samples).dropna(subset=["v_gap"])
    parts = [
        f"{least(str(objective))}: {percent(gap.min(), 1)} to {percent(gap.max(), 1)}; the two are one in "
        f"{(gap <= 0.0).sum()} of {len(gap)} cases"
        for objective, gap in compared.groupby("objective")["v_gap"]
    ]
    return "How much more the V optimum costs than the best of all. " + "; ".join(parts) + "."


PICTURES = (
    Picture(
        "species-position",
        "Species: where to fly",
        "The V optimum of each species, the lightest at the bottom: downstream in (a) wavelengths and (b) "
        "semispans, (c) to the side in semispans and (d) up in the leader's amplitudes. Filled: amplitude from "
        "the species' own stroke angle; hollow: from the ibis's Strouhal number. Thin lines, if any: 5 to 95 % "
        "of the samples of each bird's uncertain inputs. A species without a mark has no V optimum, or no such "
        "stroke is possible. Dashed: half a wavelength, and level with the leader.",
        _describe_position,
        _drawing(POSITION),
    ),
    Picture(
        "species-saving",
        "Species: what is saved",
        "Savings at the V optimum of each species, the lightest at the bottom, as fractions of the leader's: "
        "(a) total power, (b) induced power, (c) profile power. Marks and lines as in the figure of the "
        "positions.",
        _describe_saving,
        _drawing(SAVING),
    ),
    Picture(
        "species-stroke",
        "Species: how the stroke changes",
        "By how much the follower at the V optimum (a) flaps less far, 1 − h_F/h_L, and (b) flexes its wings "
        "more on the upstroke, 1 − R_F/R_L, the lightest species at the bottom. (c) One against the other: "
        "above the line the amplitude changes more, as the paper says of the ibis. Marks and lines as in the "
        "figure of the positions.",
        _describe_stroke,
        _draw_stroke,
    ),
    Picture(
        "species-gap",
        "Species: the V against the best, and force against power",
        "(a) By how much the V optimum of each species costs more than the best optimum of all; 0 where they "
        "are one. The others: what changes at the V optimum if power is minimised instead of force, in (b) the "
        "place downstream, (c) the place to the side and (d) the share of total power saved (in percent of the "
        "leader's). Diamonds: power less force; filled and hollow as the marks of (a). The lightest species at "
        "the bottom.",
        _describe_gap,
        _drawing(GAP),
    ),
)
