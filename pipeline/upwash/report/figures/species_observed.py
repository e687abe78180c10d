"""Figure: positions and savings beside what was published of the same species, agreement and disagreement."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import FAINT, OBSERVED, PAGE_WIDTH_IN, dot, letter, styled
from upwash.report.figures.picture import Picture
from upwash.report.figures.species_rows import ROW_IN, add_legend, look_of
from upwash.report.words import common_name
from upwash.study.observations import NOT_COMPARED, compare_with_observations

CAPTION = (
    "Our V optimum beside each published number of the same species: (a) to the side, (b) what is saved, (c) "
    "downstream, (d) up. Diamonds and bars: published, filled "
    "if measured on birds, hollow if computed by theory from measured positions; an open end of a range is "
    "an arrow. Marks: ours. Distances in semispans of the species; a published gap between wingtips is "
    "drawn as the distance between bodies that it means (wingtips). At the right: how ours lies beside it, least force "
    "and then least power: = the ranges meet, ≈ nearer than the radius of a vortex core, > larger, < "
    "smaller."
)
PANELS = (
    ("To the side", "y/b", ("lateral_distance", "wingtip_spacing")),
    ("Saving", "share saved (%)", ("total_power_saving", "induced_power_saving")),
    ("Downstream", "x/b", ("distance_behind",)),
    ("Up", "z/b", ("vertical_distance",)),
)
KINDS = {
    "induced_power_saving": ", induced",
    "total_power_saving": ", total",
    "wingtip_spacing": ", wingtips",
}
VERDICTS = {"agrees": "=", "near": "≈", "above": ">", "below": "<"}


def compared(
    species: pd.DataFrame, observations: pd.DataFrame, samples: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Return our values beside the published ones, lengths in semispans, gaps of wingtips as distances.

    Returns
    -------
    DataFrame
        Columns of `upwash.study.observations.OBSERVED`, without what compares with nothing.
    """
    beside = compare_with_observations(species, samples, observations)
    # What the paper got from this very model is no observation.
    beside = beside[(beside["verdict"] != NOT_COMPARED) & ~beside["this_model"].astype(bool)].copy()
    beside["label"] = beside["study"].map(observations.set_index("study")["label"].to_dict())
    birds = species.groupby("species")[["semispan_m", "speed_m_s", "period_s"]].first().loc[beside["species"]]
    b, wavelength = birds["semispan_m"].to_numpy(), (birds["speed_m_s"] * birds["period_s"]).to_numpy()
    units = {"m": 1.0 / b, "wingspans": 2.0, "semispans": 1.0, "wavelengths": wavelength / b}
    scale = np.select([beside["unit"] == unit for unit in units], list(units.values()), 1.0)
    between_tips = np.where(beside["quantity"] == "wingtip_spacing", 2.0, 0.0)
    for name in ("observed", "observed_low", "observed_high", "ours", "ours_low", "ours_high"):
        beside[name] = beside[name].astype(float) * scale + between_tips
    return beside


def describe(species: pd.DataFrame, observations: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    beside = compared(species, observations, samples)
    parts = []
    for title, _, quantities in PANELS:
        counts = beside[beside["quantity"].isin(quantities)]["verdict"].value_counts()
        words = ", ".join(f"{verdict} {counts[verdict]}" for verdict in VERDICTS if verdict in counts)
        parts.append(f"{title.lower()}: {words or 'nothing'}")
    return (
        "Our values beside published ones, counted over costs and amplitude conventions. "
        + "; ".join(parts)
        + "."
    )


@styled
def draw(species: pd.DataFrame, observations: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw our values beside the published ones."""
    beside = compared(species, observations, samples)
    panels = [beside[beside["quantity"].isin(quantities)] for _, _, quantities in PANELS]
    lines = [max(1, _count(panels[i]), _count(panels[i + 1])) for i in (0, 2)]
    height = 1.9 + 1.3 * ROW_IN * sum(lines)
    figure = Figure(figsize=(PAGE_WIDTH_IN, height), layout="constrained")
    axes = figure.subplots(2, 2, height_ratios=lines)
    for panel_axes, rows, (title, label, _), name in zip(axes.flat, panels, PANELS, "abcd", strict=True):
        _draw_panel(panel_axes, rows)
        panel_axes.set_xlabel(label)
        letter(panel_axes, name, title)
    entries = [
        dot("published, measured on birds", marker="D", color=OBSERVED),
        dot("published, computed by theory", marker="D", color=OBSERVED, markerfacecolor="white"),
    ]
    add_legend(figure, beside, entries)
    return figure


def _keys(rows: pd.DataFrame) -> list[tuple[str, str, str, str]]:
    names = ["species", "study", "quantity", "basis"]
    return list(dict.fromkeys(rows[names].itertuples(index=False, name=None)))[::-1]


def _count(rows: pd.DataFrame) -> int:
    return len(_keys(rows))


def _draw_panel(axes: Axes, rows: pd.DataFrame) -> None:
    keys = _keys(rows)
    labels = []
    for line, (species, study, quantity, basis) in enumerate(keys):
        own = rows[
            (rows["species"] == species)
            & (rows["study"] == study)
            & (rows["quantity"] == quantity)
            & (rows["basis"] == basis)
        ]
        labels.append(f"{common_name(species)}\n{own['label'].iloc[0]}{KINDS.get(quantity, '')}")
        axes.axhline(line, color=FAINT, alpha=0.25, linewidth=0.5, zorder=0)
        _draw_published(axes, own.iloc[0], line)
        for number, (_, row) in enumerate(own.iterrows()):
            look = look_of(row["objective"], row["amplitude_convention"])
            place = line + 0.5 * ((number + 0.5) / len(own) - 0.5) - 0.05
            axes.hlines(place, row["ours_low"], row["ours_high"], color=look["color"], linewidth=0.7)
            axes.plot(
                row["ours"],
                place,
                **look,
                markersize=3.5,
                gid=f"ours {species} {quantity} {row['objective']} {row['amplitude_convention']}",
                zorder=3,
            )
        verdicts = own.drop_duplicates("objective")["verdict"]
        axes.text(
            1.02,
            line,
            " ".join(VERDICTS[verdict] for verdict in verdicts),
            transform=axes.get_yaxis_transform(),
            va="center",
        )
    axes.set_yticks(range(len(keys)), labels)
    axes.tick_params(axis="y", length=0, labelsize=6)
    axes.set_ylim(-0.6, max(len(keys), 1) - 0.4)


def _draw_published(axes: Axes, row: pd.Series, line: int) -> None:
    """Draw a published value, range or both; an end that is not given is an arrow."""
    low, high = row["observed_low"], row["observed_high"]
    look: dict[str, Any] = {
        "color": OBSERVED,
        "linewidth": 3.0,
        "alpha": 0.5,
        "zorder": 1,
        "solid_capstyle": "butt",
    }
    if not np.isnan(low) and not np.isnan(high):
        axes.plot([low, high], [line, line], **look)
    elif not np.isnan(low) or not np.isnan(high):
        end = high if np.isnan(low) else low
        axes.plot(
            end, line, marker="<" if np.isnan(low) else ">", color=OBSERVED, markersize=7, alpha=0.7, zorder=1
        )
    if not np.isnan(row["observed"]):
        face = OBSERVED if row["basis"] == "measured" else "white"
        axes.plot(
            row["observed"],
            line,
            marker="D",
            color=OBSERVED,
            markerfacecolor=face,
            markersize=6,
            zorder=2,
            gid=f"published {row['species']} {row['quantity']}",
        )


PICTURE = Picture("species-observed", "Species: beside what was observed", CAPTION, describe, draw)
