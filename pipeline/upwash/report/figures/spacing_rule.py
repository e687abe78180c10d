"""Figure: why the follower flies so far aside, the rule for it, and how well the rule holds."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.aero.wake import ROLL_UP, spanwise_spacing_rule, stroke_span, vortex_wake
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    FAINT,
    LEADER,
    OBJECTIVES,
    PAGE_WIDTH_IN,
    UPSTROKE,
    legend_below,
    letter,
    mark,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.report.words import least, signed
from upwash.study.rows import best, bird_of, objectives_of

CAPTION = (
    "From above, the two pairs of stroke states that matter in antiphase: (a) leader down, follower up; (b) "
    "leader up, follower down. The nearer tip vortex of the leader's downstroke lies π b/4 aside throughout "
    "(green); the follower's inner wingtip would meet it if the follower were at π b/4 + R_F b (a) and π "
    "b/4 + b (b), the dotted lines. It cannot be at both, and flies near their mean: the spacing rule. (c) "
    "The position found for each cost, and by how much it differs from the rule's, y = b (π/4 + (1 + R_F)/2)."
)


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for objective in objectives_of(pair):
        row = best(pair, objective)
        rule = spanwise_spacing_rule(row["semispan_m"], row["upstroke_span_ratio"])
        parts.append(
            f"{least(objective)}: {row['y_m']:.3f} m found, {rule:.3f} m by the rule, "
            f"{signed(100.0 * (row['y_m'] / rule - 1.0), 1)} % apart"
        )
    return "Two sketches of leader, wake and follower from above, and the spacing. " + "; ".join(parts) + "."


@styled
def draw(pair: pd.DataFrame) -> Figure:
    """Draw the spacing rule."""
    rows = [best(pair, objective) for objective in objectives_of(pair)]
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.7), layout="constrained")
    down_up, up_down, beside_rule = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 0.75))
    _draw_states(down_up, rows[0], leader_state=1, follower_state=0)
    letter(down_up, "a", "Leader down, follower up")
    _draw_states(up_down, rows[0], leader_state=0, follower_state=1)
    letter(up_down, "b", "Leader up, follower down")
    up_down.set_ylabel("")
    _draw_found(beside_rule, rows)
    legend_below(figure, down_up, 5)
    return figure


def _draw_states(axes: Axes, row: pd.Series, leader_state: int, follower_state: int) -> None:
    bird = bird_of(row)
    b, wavelength = bird.semispan_m, bird.wavelength_m
    wake = vortex_wake(bird.amplitude_m, bird.upstroke_span_ratio, b, wavelength, bird.circulation_m2_s)
    for ring, corners in enumerate(wake.corners()):
        if wake.state[ring] != leader_state:
            continue
        color, line, name = (UPSTROKE, "--", "up") if wake.is_upstroke[ring] else (DOWNSTROKE, "-", "down")
        loop = np.vstack([corners, corners[:1]])
        axes.plot(
            loop[:, 0] / wavelength,
            loop[:, 1] / b,
            color=color,
            linestyle=line,
            label=f"{name}stroke's vortices",
        )
    _draw_wing(axes, 0.0, 0.0, leader_state, bird.upstroke_span_ratio, LEADER, "leader")
    look = OBJECTIVES[row["objective"]]
    x, y = row["x_m"] / wavelength, row["y_m"] / b
    _draw_wing(axes, x, y, follower_state, row["upstroke_span_ratio"], look["color"], "follower")
    reach = _reach(follower_state, row["upstroke_span_ratio"])
    axes.axhline(
        ROLL_UP + reach, color=FAINT, linestyle=":", linewidth=1.0, label="tip meets vortex", gid="meeting"
    )
    axes.annotate(
        r"$\frac{π}{4}b + b$" if follower_state else r"$\frac{π}{4}b + R_Fb$",
        (1.0, ROLL_UP + reach),
        (0, 2),
        textcoords="offset points",
        ha="right",
        va="bottom",
        xycoords=("axes fraction", "data"),
    )
    axes.set(xlim=(-0.08, 1.08), ylim=(-1.15, 2.65), xlabel="x/λ, downstream", ylabel="y/b, to the right")


def _reach(state: int, upstroke_span_ratio: float) -> float:
    fixed, flexed = stroke_span(state / 2)
    return fixed + flexed * upstroke_span_ratio


def _draw_wing(axes: Axes, x: float, y: float, state: int, ratio: float, color: str, name: str) -> None:
    reach = _reach(state, ratio)
    axes.plot(
        [x, x, x],
        [y - reach, y, y + reach],
        color=color,
        linewidth=2.5,
        marker="o",
        markersize=4,
        label=name,
        gid=name,
        zorder=3,
    )


def _draw_found(axes: Axes, rows: list[pd.Series]) -> None:
    for place, row in enumerate(rows):
        rule = spanwise_spacing_rule(1.0, row["upstroke_span_ratio"])
        spacing = row["y_m"] / row["semispan_m"]
        axes.plot(
            [place - 0.3, place + 0.3],
            [rule, rule],
            color=FAINT,
            linewidth=2.0,
            gid=f"rule {row['objective']}",
        )
        axes.plot(place, spacing, **mark(row["objective"], markersize=6), gid=f"found {row['objective']}")
        axes.annotate(
            f"{signed(100.0 * (spacing / rule - 1.0), 1)} %",
            (place, spacing),
            (0, 6),
            textcoords="offset points",
            ha="center",
        )
    axes.margins(y=1.0)
    axes.set(xlim=(-0.6, len(rows) - 0.4), ylabel="y/b")
    axes.set_xticks(range(len(rows)), [least(row["objective"]) for row in rows])
    axes.plot([], [], color=FAINT, linewidth=2.0, label="the rule")
    axes.legend(handles=[axes.lines[-1]], loc="upper left")
    letter(axes, "c", "Found, and the rule")


PICTURE = Picture("spacing-rule", "How far to the side", CAPTION, describe, draw)
