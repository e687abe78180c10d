"""Figure: the four pairs of stroke states of leader and follower, filaments and force in each."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.aero.interaction import phase_weights
from upwash.aero.wake import stroke_height, stroke_span, vortex_wake
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    LEADER,
    PAGE_WIDTH_IN,
    UPSTROKE,
    dot,
    entry,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.flying_bird import flying_bird
from upwash.report.figures.perspective import View, draw_directions
from upwash.report.figures.picture import Picture
from upwash.report.words import least, percent, signed
from upwash.study.rows import best, bird_of, objectives_of, state_forces_of

CAPTION = (
    "While the leader (black, at the origin) is up (a, b), the rectangle of its upstroke (blue, dashed) is the "
    "nearer one; while it is down (c, d), that of its downstroke (green, solid). Each rectangle is a closed loop "
    "of filaments of circulation Γ whose sense the small arrows show; signs, on those along the flight, are relative "
    "to +x. The follower (orange line) is a lifting line between its wingtips, raised and narrow when up (a, c), "
    "lowered and wide when down (b, d), shown at the optimum. Red: the force that the wake exerts on it, to one "
    "scale in all four, but never shorter than its head. β: the share of the "
    "wingbeat for which the pair of states lasts."
)
STATES = ("up", "down")
VIEW = View(azimuth_deg=-20.0, elevation_deg=36.0)
FOLLOWER, FORCE = "#E69F00", "#D55E00"
LONGEST_FORCE = 1.2
SHORTEST_FORCE = 0.2
"""Lengths of the largest force's arrow and of the least that is drawn, in semispans."""


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    row = _row(pair)
    forces = state_forces_of(row)
    weights = phase_weights(row["phase"])
    parts = [
        f"leader {STATES[j]}, follower {STATES[k]}: lift {signed(forces[j, k, 0])} N, thrust "
        f"{signed(forces[j, k, 1])} N for {percent(float(weights[j, k]))} of the wingbeat"
        for j, k in np.ndindex(2, 2)
    ]
    return (
        "Four views of the leader's two vortex rectangles and the follower among them. "
        + "; ".join(parts)
        + "."
    )


def _row(pair: pd.DataFrame) -> pd.Series:
    return best(pair, objectives_of(pair)[0])


@styled
def draw(pair: pd.DataFrame) -> Figure:
    """Draw leader, wake and follower in each pair of stroke states."""
    row = _row(pair)
    forces, weights = state_forces_of(row), phase_weights(row["phase"])
    figure = Figure(figsize=(PAGE_WIDTH_IN, 4.6), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    scale = LONGEST_FORCE * row["semispan_m"] / np.linalg.norm(forces, axis=-1).max()
    for (j, k), name in zip(np.ndindex(2, 2), "abcd", strict=True):
        axes = panels[j, k]
        _draw_wake(axes, row, j)
        _draw_follower(axes, row, k, scale * forces[j, k])
        beta = rf"$β_{{{STATES[j][0]}{STATES[k][0]}}}$ = {weights[j, k]:.2g}"
        letter(axes, name, f"Leader {STATES[j]}, follower {STATES[k]}: {beta}")
        lift, thrust = forces[j, k]
        axes.text(
            0.99,
            0.0,
            f"lift {signed(lift)} N\nthrust {signed(thrust)} N",
            color=FORCE,
            ha="right",
            transform=axes.transAxes,
        )
        axes.set_aspect("equal")
        axes.set_axis_off()
    b = row["semispan_m"]
    draw_directions(
        panels[0, 0], VIEW, (row["speed_m_s"] * row["period_s"] * 0.75, -1.5 * b, -0.6 * b), 0.4 * b
    )
    entries = [
        entry("leader", color=LEADER, linewidth=4.0),
        entry("upstroke's ring", color=UPSTROKE, linestyle="--", linewidth=1.8),
        entry("downstroke's ring", color=DOWNSTROKE, linewidth=1.8),
        entry(f"follower, {least(row['objective'])}", color=FOLLOWER, linewidth=3.0),
        dot("force of the wake", color=FORCE, marker=r"$\uparrow$", markersize=9),
    ]
    legend_below(figure, entries, 5)
    return figure


def _draw_wake(axes: Axes, row: pd.Series, state: int) -> None:
    bird = bird_of(row)
    wake = vortex_wake(
        bird.amplitude_m,
        bird.upstroke_span_ratio,
        bird.semispan_m,
        bird.wavelength_m,
        bird.circulation_m2_s,
        bird.circulation_ratio,
    )
    for ring, corners in zip(
        np.flatnonzero(wake.state == state), wake.corners()[wake.state == state], strict=True
    ):
        color, line = (UPSTROKE, "--") if wake.is_upstroke[ring] else (DOWNSTROKE, "-")
        for k in range(4):
            start, end = corners[k], corners[(k + 1) % 4]
            flat = VIEW.flat([start, end])
            axes.plot(*flat.T, color=color, linestyle=line, linewidth=1.8, gid=f"filament {ring} {k}")
            middle, along = flat.mean(axis=0), (flat[1] - flat[0]) / np.linalg.norm(flat[1] - flat[0])
            axes.annotate(
                "",
                middle + 0.08 * bird.semispan_m * along,
                middle - 0.08 * bird.semispan_m * along,
                arrowprops={
                    "arrowstyle": "-|>",
                    "color": color,
                    "shrinkA": 0,
                    "shrinkB": 0,
                    "mutation_scale": 9,
                },
            )
            # Filaments 0 and 1 run along +y and +x; 2 and 3 return. Signs stand outside the loop, on the long ones.
            if not k % 2:
                continue
            outward = middle - VIEW.flat(corners).mean(axis=0)
            place = middle + 0.24 * bird.semispan_m * outward / np.linalg.norm(outward)
            axes.text(place[0], place[1], "+Γ" if k < 2 else "−Γ", ha="center", va="center", fontsize=6.5)
    tip = bird.amplitude_m * stroke_height(state / 2)
    fixed, flexed = stroke_span(state / 2)
    reach = bird.semispan_m * (fixed + flexed * bird.upstroke_span_ratio)
    flexed_by = (bird.semispan_m - reach) / (bird.semispan_m * (1.0 - bird.upstroke_span_ratio))
    for outline in flying_bird(reach, tip, flexed_by, bird.semispan_m):
        axes.fill(*VIEW.flat(outline).T, color=LEADER, linewidth=0.5, zorder=3)


def _draw_follower(axes: Axes, row: pd.Series, state: int, arrow: np.ndarray) -> None:
    fixed, flexed = stroke_span(state / 2)
    reach = row["semispan_m"] * (fixed + flexed * row["upstroke_span_ratio"])
    height = row["z_m"] + row["amplitude_m"] * stroke_height(state / 2)
    middle = np.array([row["x_m"], row["y_m"], height])
    ends = middle + np.array([[0.0, -reach, 0.0], [0.0, reach, 0.0]])
    axes.plot(
        *VIEW.flat(ends).T, color=FOLLOWER, linewidth=3.0, marker="o", markersize=4, zorder=4, gid="follower"
    )
    length, least_length = float(np.linalg.norm(arrow)), SHORTEST_FORCE * row["semispan_m"]
    arrow = arrow * max(1.0, least_length / length) if length > 0.0 else arrow
    # Lift points up, thrust upstream.
    tail, head = VIEW.flat([middle, middle + np.array([-arrow[1], 0.0, arrow[0]])])
    axes.annotate(
        "",
        head,
        tail,
        arrowprops={"arrowstyle": "-|>", "color": FORCE, "linewidth": 1.8, "shrinkA": 0, "shrinkB": 0},
        zorder=5,
    )
    axes.update_datalim([head])


PICTURE = Picture("configurations", "The four pairs of stroke states", CAPTION, describe, draw)
