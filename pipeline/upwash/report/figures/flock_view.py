"""Figure: the flock with its wings and wakes, from above and from the side."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.aero.wake import ROLL_UP, stroke_span
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    LEADER,
    OBJECTIVES,
    PAGE_WIDTH_IN,
    UPSTROKE,
    dot,
    draw_bird,
    entry,
    legend_below,
    letter,
    styled,
    tip_height,
)
from upwash.report.figures.flocks import papers_flocks, series
from upwash.report.figures.picture import Picture
from upwash.report.words import least

CAPTION = (
    "The flock of least force (or of the first cost that was solved) at the moment when the first bird ends "
    "its upstroke. (a) From above, to scale: the wings of each bird as they are at that moment, and one "
    "wavelength of its wake, the rectangles of its downstrokes (green, solid) and upstrokes (blue, dashed). "
    "Each follower's inner wing rides the edge of a downstroke's rectangle. (b) From the side: the height "
    "of each bird (dot), its stroke (bar) and the path of its wingtips. Paths that run together are the "
    "wingtip path coherence that was seen in ibises."
)


def describe(flock: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    objective, _, birds = next(series(papers_flocks(flock)))
    phases = ", ".join(f"{phase:.2f}" for phase in birds["phase_flock"])
    return (
        f"{len(birds)} birds of {least(objective)}, one behind and beside the other, with "
        f"their wakes. Their phases against the first bird are {phases} wingbeats; the paths of their "
        "wingtips run along one another."
    )


@styled
def draw(flock: pd.DataFrame) -> Figure:
    """Draw a flock from above and from the side."""
    objective, _, birds = next(series(papers_flocks(flock)))
    figure = Figure(figsize=(PAGE_WIDTH_IN, 6.0), layout="constrained")
    above, side = figure.subplots(2, 1, height_ratios=(1.6, 1.0), sharex=True)
    for _, bird in birds.iterrows():
        color = LEADER if bird["bird"] == 1 else OBJECTIVES[objective]["color"]
        _draw_above(above, bird, color)
        _draw_side(side, bird, color)
    above.set(ylabel="y, to the right (m)", aspect="equal")
    side.set(xlabel="x, downstream (m)", ylabel="z, up (m)")
    letter(above, "a", "From above, to scale")
    letter(side, "b", "From the side, with the paths of the wingtips")
    entries = [
        dot("first bird", color=LEADER, marker="o"),
        dot(f"followers, {least(objective)}", color=OBJECTIVES[objective]["color"], marker="o"),
        entry("downstroke's vortices", color=DOWNSTROKE),
        entry("upstroke's vortices", color=UPSTROKE, linestyle="--"),
    ]
    legend_below(figure, entries, 4)
    return figure


def own_phase(bird: pd.Series) -> float:
    """Return where in its own wingbeat a bird is when the first bird ends its upstroke."""
    return float(-bird["phase_flock"] % 1.0)


def _draw_above(axes: Axes, bird: pd.Series, color: str) -> None:
    wavelength, b, ratio = (
        bird["speed_m_s"] * bird["period_s"],
        bird["semispan_m"],
        bird["upstroke_span_ratio"],
    )
    phase = own_phase(bird)
    for first, last, is_up in ring_stations(phase):
        reach = ROLL_UP * b * (ratio if is_up else 1.0)
        x = bird["x_flock_m"] + wavelength * np.array([first, last, last, first, first])
        y = bird["y_flock_m"] + reach * np.array([-1.0, -1.0, 1.0, 1.0, -1.0])
        look: dict[str, Any] = (
            {"color": UPSTROKE, "linestyle": "--"} if is_up else {"color": DOWNSTROKE, "linestyle": "-"}
        )
        axes.plot(x, y, linewidth=0.9, zorder=1, **look)
    fixed, flexed = stroke_span(phase)
    draw_bird(
        axes,
        bird["x_flock_m"],
        bird["y_flock_m"],
        b * (fixed + flexed * ratio),
        0.75 * b,
        facecolor=color,
        alpha=0.9,
        zorder=3,
        gid=f"bird {bird['bird']:.0f}",
    )
    axes.update_datalim(
        [(bird["x_flock_m"] - b, bird["y_flock_m"] - b), (bird["x_flock_m"], bird["y_flock_m"] + b)]
    )


def ring_stations(phase: float) -> list[tuple[float, float, bool]]:
    """Return where a bird's rings lie: first and last distance in wavelengths, and whether of an upstroke."""
    stations = []
    for k in (-2, -1, 0, 1):
        first, last = max(phase + 0.5 * k, 0.0), min(phase + 0.5 * (k + 1), 1.0)
        if last - first > 1e-12:
            stations.append((first, last, k % 2 == 0))
    return stations


def _draw_side(axes: Axes, bird: pd.Series, color: str) -> None:
    wavelength, amplitude = bird["speed_m_s"] * bird["period_s"], bird["amplitude_m"]
    behind = np.linspace(0.0, 1.0, 201)
    path = bird["z_flock_m"] + amplitude * tip_height(behind - own_phase(bird))
    x = bird["x_flock_m"]
    axes.plot(x + wavelength * behind, path, color=color, linewidth=1.0, gid=f"path {bird['bird']:.0f}")
    height = bird["z_flock_m"]
    axes.plot([x, x], [height - amplitude / 2, height + amplitude / 2], color=color, linewidth=0.8, alpha=0.5)
    axes.plot(x, height, "o", color=color)
    axes.annotate(f"{bird['bird']:.0f}", (x, height), (6, 0), textcoords="offset points", va="center")


PICTURE = Picture("flock-view", "The flock and its wakes", CAPTION, describe, draw)
