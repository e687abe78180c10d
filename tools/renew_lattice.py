"""Renew the tables and the figure of docs/lattice.md from the stored flights of an unsteady vortex lattice.

    python tools/renew_lattice.py

``make uvlm`` flies them anew. Each table stands between two marks that bear its name.
"""

import json
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from renew_comparison import between
from upwash import load_species
from upwash.aero.bird import Bird
from upwash.report.figures.drawing import (
    LEADER,
    LOOKS,
    PAGE_WIDTH_IN,
    entry,
    in_percent,
    legend_below,
    letter,
    save,
    styled,
)
from upwash.report.table import Table
from upwash.study.lattice import MODELS, aside, beside_models, best_phases, followers, grids, phase_sweeps

ROOT = Path(__file__).parents[1]
FLIGHTS = ROOT / "results" / "crosscheck" / "uvlm.parquet"
PAGE = ROOT / "docs" / "lattice.md"
FIGURE = PAGE.with_name("lattice.png")
STATION_LOOKS = (*LOOKS, {"color": "#009E73", "marker": "d", "linestyle": "-."})


def percent(values: pd.Series) -> pd.Series:
    """Return shares in per cent."""
    return 100.0 * values


def phases_table(flights: pd.DataFrame, bird: Bird) -> Table:
    """Return the best phase at each distance behind."""
    found = best_phases(flights, bird.wavelength_m)
    shown = pd.DataFrame(
        {
            "half-angle": found["half_angle_deg"].map("{:.0f}°".format),
            "aside (m)": found["y_m"],
            "x/λ": found["x_wavelengths"],
            "best phase": found["best_phase"],
            "best %": percent(found["best_saving"]),
            "mean %": percent(found["mean_saving"]),
            "worst %": percent(found["worst_saving"]),
        }
    )
    formats = {"aside (m)": ".1f", "x/λ": ".2f", "best phase": ".2f"}
    return Table("", shown, formats | dict.fromkeys(("best %", "mean %", "worst %"), ".1f"))


def beside(found: pd.DataFrame) -> Table:
    """Return what followers save by the lattice and by the models at the same places."""
    shown = pd.DataFrame(
        {
            "half-angle": found["half_angle_deg"].map("{:.0f}°".format),
            "behind (m)": found["x_m"],
            "aside (m)": found["y_m"],
            "phase": found["phase"],
            "lattice %": percent(found["saving"]),
            "paper %": percent(found["paper"]),
            "limit, stroke law %": percent(found["stroke law"]),
            "limit, tip law %": percent(found["tip law"]),
        }
    )
    formats = {"behind (m)": ".2f", "aside (m)": ".2f", "phase": ".2f"}
    shares = [name for name in shown if name.endswith("%")]
    return Table("", shown, formats | dict.fromkeys(shares, ".1f"))


def places_table(flights: pd.DataFrame, bird: Bird) -> Table:
    """Return the paper's place, and those where ibises were seen."""
    found = followers(flights)
    papers = found["z_m"] != 0.0
    return beside(beside_models(found[papers | np.isclose(found["x_m"], 1.2)], bird))


def grids_table(flights: pd.DataFrame) -> Table:
    """Return the saving at the paper's place on each grid."""
    shown = grids(flights)
    shown = shown.assign(saving=percent(shown["saving"])).rename(columns={"saving": "saving %"})
    return Table("", shown, {"saving %": ".2f"})


def both_ways_table(flights: pd.DataFrame) -> Table:
    """Return the paper's place flown one way and both ways."""
    both = flights[flights["role"] == "together"].iloc[0]
    one = followers(flights)
    one = one[np.isclose(one["x_m"], both["x_m"]) & (one["z_m"] == both["z_m"])].iloc[0]
    shown = pd.DataFrame(
        {
            "": ["the leader does not feel the follower", "each feels the other"],
            "follower saves %": [100.0 * one["saving"], 100.0 * both["saving"]],
            "leader saves %": [0.0, 100.0 * both["leader_saving"]],
        }
    )
    return Table("", shown, {"follower saves %": ".2f", "leader saves %": ".2f"})


@styled
def draw(flights: pd.DataFrame, bird: Bird) -> Figure:
    """Draw the saving against phase at four distances, and against the distance aside beside the models."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 0.45 * PAGE_WIDTH_IN), layout="constrained")
    left, right = figure.subplots(1, 2)
    _draw_phases(left, flights, bird)
    lines = _draw_aside(right, aside(flights, bird))
    legend_below(figure, lines, 4)
    return figure


def _draw_phases(axes: Axes, flights: pd.DataFrame, bird: Bird) -> None:
    swept = [(x, rows) for angle, x, _, rows in phase_sweeps(flights) if angle == 60.0]
    for look, (x, rows) in zip(STATION_LOOKS, swept, strict=True):
        station = x / bird.wavelength_m
        # A wingbeat later is the same.
        whole = pd.concat([rows, rows.iloc[:1].assign(phase=1.0)])
        axes.plot(whole["phase"], whole["saving"], **look, markersize=4)
        axes.axvline(station, color=look["color"], linewidth=0.8, linestyle=":")
        axes.annotate(f"{station:.2f} λ", (station, 0.055), color=look["color"], ha="center", fontsize=7)
    axes.set(xlabel="phase of the follower (wingbeats)", ylabel="shaft power saved", xlim=(0.0, 1.0))
    axes.set_ylim(0.0, 0.058)
    in_percent(axes.yaxis)
    letter(axes, "a", "Best where the phase is the distance in wavelengths")


def _draw_aside(axes: Axes, found: pd.DataFrame) -> list[Line2D]:
    looks = dict(zip(MODELS, LOOKS, strict=True))
    for angle, style in ((60.0, "-"), (32.0, "--")):
        rows = found[found["half_angle_deg"] == angle]
        axes.plot(rows["y_m"], rows["saving"], color=LEADER, linestyle=style, marker="o", markersize=3)
        for name, look in looks.items():
            axes.plot(rows["y_m"], rows[name], color=look["color"], linestyle=style, linewidth=1.0)
    axes.axhline(0.0, color="0.6", linewidth=0.6)
    axes.set(xlabel="distance aside (m)", ylabel="power saved", ylim=(-0.16, 0.13))
    in_percent(axes.yaxis)
    letter(axes, "b", "0.48 λ behind, in phase with the path")
    words = {"paper": "paper's model", "stroke law": "limit, stroke law", "tip law": "limit, tip law"}
    return [
        entry("lattice, 60° (dashed: 32°)", color=LEADER, marker="o", markersize=3),
        *(entry(words[name], color=look["color"]) for name, look in looks.items()),
    ]


def tables(flights: pd.DataFrame, bird: Bird) -> dict[str, Table]:
    """Return each table of the page by its name."""
    return {
        "best-phases": phases_table(flights, bird),
        "aside": beside(aside(flights, bird)),
        "places": places_table(flights, bird),
        "both-ways": both_ways_table(flights),
        "grids": grids_table(flights),
    }


def main() -> None:
    """Put the tables into the page, and the figure beside it."""
    stored = pq.read_table(FLIGHTS)
    flights, about = (
        stored.to_pandas(),
        {key.decode(): value.decode() for key, value in stored.schema.metadata.items()},
    )
    bird = load_species(about["species"]).bird()
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables(flights, bird).items():
        body = table.markdown().partition("\n\n")[2]
        text, count = between(name).subn(lambda _, body=body: f"\n{body}\n\n", text)
        if count != 1:
            sys.exit(f"{PAGE}: expected one table named {name}, found {count}; mark its place")
    PAGE.write_text(text, encoding="utf-8")
    save(draw(flights, bird), FIGURE)
    print(json.loads(about["package_versions"]), about["wall_time_s"], "s")


if __name__ == "__main__":
    main()
