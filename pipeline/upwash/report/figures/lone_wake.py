"""Figure: the wake of a bird flying alone, and the impulse of its rings that carries and propels it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Rectangle

from upwash.aero.bird import Bird
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    FAINT,
    LEADER,
    PAGE_WIDTH_IN,
    UPSTROKE,
    letter,
    styled,
    tip_height,
)
from upwash.report.figures.perspective import View, draw_directions
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name
from upwash.study.rows import bird_of

CAPTION = (
    "(a) The vortices that the wingtips of a bird leave behind, at the end of an upstroke: far apart and "
    "curved after a downstroke (green, solid), straight and close after an upstroke (blue, dashed), where "
    "the wings are flexed to the fraction R of their span. (b) The same from the side and (c) from above, "
    "as the model has them for its impulse: ellipses of half-width b and rectangles of half-width R b, each "
    "half a wavelength λ long, tilted by the amplitude h. Arrows: the impulse I of each ring, normal to it. "
    "It points up in both; upstream after a downstroke and downstream after an upstroke, and as the ellipse "
    "is wider, thrust is left over."
)

PIECES = 60
VIEW = View(azimuth_deg=-14.0, elevation_deg=24.0)


def impulses(bird: Bird) -> dict[str, tuple[float, float]]:
    """Return the impulse of a downstroke's and of an upstroke's ring: upstream and upward, in N s."""
    down = (bird.density_kg_m3 * np.pi * bird.semispan_m * bird.circulation_m2_s) * np.array(
        [bird.amplitude_m / 2.0, bird.wavelength_m / 4.0]
    )
    both = np.array(
        [
            bird.horizontal_impulse_n_s(bird.amplitude_m, bird.upstroke_span_ratio),
            bird.vertical_impulse_n_s(bird.upstroke_span_ratio),
        ]
    )
    up = both - down
    return {"down": (float(down[0]), float(down[1])), "up": (float(up[0]), float(up[1]))}


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    bird = bird_of(pair.iloc[0])
    impulse = impulses(bird)
    return (
        f"Three sketches of the wake of a {common_name(pair.iloc[0]['species']).lower()} flying alone. A "
        f"downstroke's ring has {impulse['down'][1]:.2f} N s of upward and {impulse['down'][0]:.2f} N s of "
        f"upstream impulse, an upstroke's {impulse['up'][1]:.2f} N s upward and {-impulse['up'][0]:.2f} N s "
        f"downstream; over a wingbeat of {bird.period_s:.3g} s that is {bird.weight_n:.4g} N of lift and "
        f"{bird.drag_n:.3g} N of thrust."
    )


@styled
def draw(pair: pd.DataFrame) -> Figure:
    """Draw the lone bird's wake."""
    bird = bird_of(pair.iloc[0])
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.1), layout="constrained")
    grid = figure.add_gridspec(2, 2, height_ratios=(1.15, 1.0))
    _draw_wake(figure.add_subplot(grid[0, :]), bird)
    _draw_side(figure.add_subplot(grid[1, 0]), bird)
    _draw_plan(figure.add_subplot(grid[1, 1]), bird)
    return figure


def _draw_wake(axes: Axes, bird: Bird) -> None:
    """Draw tip vortices over three half-wavelengths, the nearest from an upstroke."""
    half, b, narrow = bird.wavelength_m / 2.0, bird.semispan_m, bird.upstroke_span_ratio * bird.semispan_m
    tip = bird.amplitude_m / 2.0
    share = np.linspace(0.0, 1.0, PIECES)
    for stroke in range(3):
        x = (stroke + share) * half
        z = tip_height(x / bird.wavelength_m) * bird.amplitude_m
        is_up = stroke % 2 == 0
        y = np.full(PIECES, narrow) if is_up else narrow + (b - narrow) * np.sqrt(np.sin(np.pi * share))
        look: dict[str, Any] = {"color": UPSTROKE, "linestyle": "--"} if is_up else {"color": DOWNSTROKE}
        for side in (-1.0, 1.0):
            axes.plot(*VIEW.flat(np.stack([x, side * y, z], axis=-1)).T, linewidth=2.0, **look)
        across = [(x[-1], -narrow, z[-1]), (x[-1], narrow, z[-1])]
        axes.plot(*VIEW.flat(across).T, color=FAINT, linestyle=":", linewidth=1.2)
    wings = [(0.0, -narrow, tip), (0.0, -0.15 * b, 0.0), (0.0, 0.15 * b, 0.0), (0.0, narrow, tip)]
    body = [(-0.3 * b, 0.0, 0.0), (0.45 * b, 0.0, 0.0)]
    axes.plot(*VIEW.flat(wings).T, color=LEADER, linewidth=2.5, solid_joinstyle="round")
    axes.plot(*VIEW.flat(body).T, color=LEADER, linewidth=5.0, solid_capstyle="round")
    behind, ahead = VIEW.flat([(-0.5 * b, 0.0, 0.0), (-1.5 * b, 0.0, 0.0)])
    axes.annotate("", ahead, behind, arrowprops={"arrowstyle": "-|>", "color": LEADER}, annotation_clip=False)
    words = (
        ("flight", (-1.0 * b, 0.0, -0.25 * tip)),
        ("upstroke", (0.42 * half, -narrow, -0.75 * tip)),
        ("downstroke", (1.6 * half, -b, -0.75 * tip)),
        ("upstroke", (2.42 * half, -narrow, -0.75 * tip)),
    )
    for text, place in words:
        x, y = VIEW.flat(place)
        axes.text(x, y, text, ha="center", va="top")
    axes.update_datalim([ahead])
    draw_directions(axes, VIEW, (2.85 * half, 0.0, 0.4 * tip), 0.45 * b)
    axes.set_aspect("equal")
    axes.set_axis_off()
    letter(axes, "a", "What the wingtips leave behind, at the end of an upstroke")


def _height(bird: Bird) -> float:
    """Return what the lower panels show from bottom to top, in m: the same, so that they stand level."""
    return max(1.9 * bird.amplitude_m, 2.75 * bird.semispan_m)


def _draw_side(axes: Axes, bird: Bird) -> None:
    half, tip = bird.wavelength_m / 2.0, bird.amplitude_m / 2.0
    impulse = impulses(bird)
    scale = 0.9 * bird.amplitude_m / max(up for _, up in impulse.values())
    rings = (("up", 0.0, tip, -tip, UPSTROKE, "--"), ("down", half, -tip, tip, DOWNSTROKE, "-"))
    for name, start, first, last, color, line in rings:
        axes.plot(
            [start, start + half],
            [first, last],
            color=color,
            linestyle=line,
            linewidth=2.0,
            gid=f"{name} ring",
        )
        upstream, up = impulse[name]
        middle = start + half / 2.0
        axes.annotate(
            "",
            (middle - scale * upstream, scale * up),
            (middle, 0.0),
            arrowprops={"arrowstyle": "-|>", "color": LEADER, "shrinkA": 0, "shrinkB": 0},
        )
        axes.text(
            middle - scale * upstream,
            scale * up + 0.06 * bird.amplitude_m,
            f"$I_{name[0]}$: {up:.2f} up, {abs(upstream):.2f} {'up' if upstream > 0 else 'down'}stream",
            ha="center",
            fontsize=7,
        )
    axes.annotate(
        "", (2.08 * half, -tip), (2.08 * half, tip), arrowprops={"arrowstyle": "<->", "linewidth": 0.6}
    )
    axes.text(2.13 * half, 0.0, "$h$", va="center")
    axes.set(
        xlim=(-0.1 * half, 2.25 * half),
        ylim=(-1.2 * tip, -1.2 * tip + _height(bird)),
        aspect="equal",
        xlabel="x, downstream (m)",
        ylabel="z, up (m)",
    )
    letter(axes, "b", "From the side; impulse in N s")


def _draw_plan(axes: Axes, bird: Bird) -> None:
    half, b = bird.wavelength_m / 2.0, bird.semispan_m
    narrow = bird.upstroke_span_ratio * b
    axes.add_patch(
        Rectangle(
            (0.0, -narrow), half, 2.0 * narrow, facecolor=UPSTROKE, alpha=0.3, edgecolor="none", gid="up area"
        )
    )
    axes.add_patch(
        Rectangle(
            (0.0, -narrow), half, 2.0 * narrow, fill=False, edgecolor=UPSTROKE, linestyle="--", linewidth=2.0
        )
    )
    ellipse: dict[str, Any] = {"xy": (1.5 * half, 0.0), "width": half, "height": 2.0 * b}
    axes.add_patch(Ellipse(**ellipse, facecolor=DOWNSTROKE, alpha=0.3, edgecolor="none", gid="down area"))
    axes.add_patch(Ellipse(**ellipse, fill=False, edgecolor=DOWNSTROKE, linewidth=2.0))
    double = {"arrowstyle": "<->", "linewidth": 0.6, "shrinkA": 0, "shrinkB": 0}
    for middle, reach, text in ((0.5 * half, narrow, "$2Rb$"), (1.5 * half, b, "$2b$")):
        axes.annotate("", (middle, -reach), (middle, reach), arrowprops=double)
        axes.text(middle + 0.04 * half, 0.0, text, va="center")
    axes.annotate("", (0.0, -1.18 * b), (half, -1.18 * b), arrowprops=double)
    axes.text(0.5 * half, -1.36 * b, "$λ/2$", ha="center", va="center")
    axes.annotate("", (half, -1.18 * b), (2.0 * half, -1.18 * b), arrowprops=double)
    axes.text(1.5 * half, -1.36 * b, "$λ/2$", ha="center", va="center")
    axes.set(
        xlim=(-0.1 * half, 2.25 * half),
        ylim=(-1.6 * b, -1.6 * b + _height(bird)),
        aspect="equal",
        xlabel="x, downstream (m)",
        ylabel="y, to the right (m)",
    )
    letter(axes, "c", "From above")


PICTURE = Picture("lone-wake", "The wake of a lone bird", CAPTION, describe, draw)
