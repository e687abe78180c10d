"""Figure: when a follower should flap, against its distance, and what other phases cost: in a V and in line."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import (
    FAINT,
    LOOKS,
    OBSERVED,
    PAGE_WIDTH_IN,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.limit_place import LAWS
from upwash.report.figures.picture import Picture
from upwash.report.words import percent, signed
from upwash.study.phase_rule import IN_LINE, V, judge_rules, phase_rule, wrapped

CAPTION = (
    "The ibis, least power. (a) The best phase in a V against the distance behind the leader: filled, in the "
    "limit by either law of the follower's span; crosses, in the paper's model, which knows two phases. Purple "
    "line: spatially in phase, as Portugal et al. (2014) saw ibises flap in a V. (b) The same straight behind the"
    " leader; purple line: spatially in antiphase, as they saw there. (c) What is saved in every spatial phase in"
    " the limit, by the same marks: in a V (upper lines) and in line (lower lines), where the bird pays in any "
    "phase, and where a line is broken cannot fly."
)
PAPER = "paper"
SHOWN = {
    ("limit", "stroke"): "limit, stroke law",
    ("limit", "tip"): "limit, tip law",
    (PAPER, "tip"): "the paper's model",
}


def look_of(model: str, law: str) -> dict[str, Any]:
    """Return how marks of a model look."""
    return {"color": LOOKS[0]["color"], "marker": "x", "linestyle": "none"} if model == PAPER else LAWS[law]


def describe(limit: pd.DataFrame, phase: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    rule = phase_rule(phase)
    parts = []
    for (model, law), words in SHOWN.items():
        of_it = rule[(rule["model"] == model) & (rule["span_law"] == law)]
        holds = judge_rules(of_it)["holds"]
        told = []
        for formation, of_formation in of_it.groupby("formation", sort=False):
            phases = sorted(
                {
                    signed(best + 0.0, 2).replace("−0.00", "+0.00")
                    for best in of_formation["spatial_phase_best"]
                }
            )
            savings = sorted({percent(saving, 1) for saving in of_formation["saving_best"]})
            told.append(f"{formation} Φ = {', '.join(phases)}, saving {', '.join(savings)}")
        parts.append(
            f"{words}: {'; '.join(told)}; {int(holds.sum())} of {len(holds)} observed rules come out"
        )
    return "Best phase against distance, and saving against spatial phase. " + ". ".join(parts) + "."


@styled
def draw(limit: pd.DataFrame, phase: pd.DataFrame) -> Figure:
    """Draw the best phase against distance in both formations, and the saving against spatial phase."""
    rule = phase_rule(phase)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 3.0), layout="constrained")
    panels = figure.subplots(1, 3)
    _draw_rule(panels[0], rule[rule["formation"] == V], 0.0, "a", "In a V")
    _draw_rule(panels[1], rule[rule["formation"] == IN_LINE], 0.5, "b", "Straight behind")
    _draw_savings(panels[2], phase)
    legend_below(figure, panels[0], 4)
    return figure


def _draw_rule(axes: Axes, rule: pd.DataFrame, observed: float, name: str, title: str) -> None:
    # κ = x/λ − Φ, broken where it passes from one wingbeat to the next.
    x = np.linspace(0.1, 1.1, 1001)
    kappa = (x - observed) % 1.0
    kappa[1:][np.abs(np.diff(kappa)) > 0.5] = np.nan
    axes.plot(
        x, kappa, color=OBSERVED, linewidth=3.0, alpha=0.5, label="as ibises do", gid=f"observed {name}"
    )
    for (model, law), words in SHOWN.items():
        of_it = rule[(rule["model"] == model) & (rule["span_law"] == law)]
        look = {**look_of(model, law), "linestyle": "none"}
        best = of_it["phase_best"].to_numpy(float).round(6) % 1.0
        axes.plot(
            of_it["x_wavelengths"], best, **look, markersize=5, label=words, gid=f"best {name} {model} {law}"
        )
    axes.set(xlim=(0.1, 1.1), ylim=(-0.04, 1.04), xlabel="x/λ, downstream", ylabel="best phase κ, wingbeats")
    letter(axes, name, title)


def _draw_savings(axes: Axes, phase: pd.DataFrame) -> None:
    axes.axhline(0.0, color=FAINT, linewidth=0.5)
    at = phase["x_wavelengths"] == phase["x_wavelengths"].iloc[0]
    for law, look in LAWS.items():
        for formation in (V, IN_LINE):
            of_it = phase[
                at
                & (phase["model"] == "limit")
                & (phase["span_law"] == law)
                & (phase["formation"] == formation)
            ]
            of_it = of_it.sort_values("spatial_phase", kind="stable")
            # Once more at −½, as at ½.
            phases = of_it["spatial_phase"].map(wrapped).to_numpy(float)
            style = {**look, "marker": ""}
            axes.plot(phases, of_it["saving_cost"], **style, linewidth=1.4, gid=f"saving {formation} {law}")
    axes.set(xlim=(-0.5, 0.5), xlabel="spatial phase Φ = x/λ − κ", ylabel="power saved")
    in_percent(axes.yaxis)
    letter(axes, "c", "What other phases cost")


PICTURE = Picture("limit-phase", "When to flap", CAPTION, describe, draw)
