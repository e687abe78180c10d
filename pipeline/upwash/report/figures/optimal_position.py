"""Figure: where the follower flies at the optimum, how its wingtips meet the wake, and the force by state."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.aero.interaction import phase_weights
from upwash.aero.wake import spanwise_spacing_rule
from upwash.report.figures.drawing import (
    FAINT,
    LEADER,
    OBJECTIVES,
    OBSERVED,
    PAGE_WIDTH_IN,
    draw_bird,
    in_percent,
    letter,
    mark,
    styled,
    tip_height,
)
from upwash.report.figures.marks import tell
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name, least
from upwash.study.rows import best, objectives_of, state_forces_of

CAPTION = (
    "(a) The best position outboard of and level with the leader, from above, in wavelengths λ and "
    "semispans b, for each cost. Upright line: x = λ/2; level lines: the spacing rule y = b (π/4 + (1 + "
    "R_F)/2). Diamonds: what was measured on birds, hollow where it was computed from another measurement. "
    "Birds show which way is forward; their wings are to scale in y. (b) The same from the side, in units "
    "of the leader's amplitude h_L. Lines: the path in the air of the leader's wingtip at the end of its "
    "upstroke, and of the followers' at the same time; bars: the followers' stroke. What the wake gives "
    "in each pair of stroke states, and on average over the wingbeat: (c) thrust over the bird's drag, (d) lift over "
    "its weight. In antiphase only two of the pairs come to pass: one wing up while the other is down."
)
STATES = {
    "uu": "leader up, follower up",
    "ud": "leader up, follower down",
    "du": "leader down, follower up",
    "dd": "leader down, follower down",
}
MEAN = "mean of the wingbeat"
KINDS = ("thrust", "lift")


def wake_forces(row: pd.Series) -> np.ndarray:
    """Return thrust over drag and lift over weight for each of `STATES`, and last the mean over the wingbeat.

    Returns
    -------
    (5, 2) ndarray of float
        Thrust over D, lift over W.
    """
    of_states = state_forces_of(row)
    mean = np.tensordot(phase_weights(row["phase"]), of_states, axes=2)
    forces = np.vstack([of_states.reshape(4, 2), mean])
    return forces[:, ::-1] / (row["drag_n"], row["weight_n"])


def measured(observations: pd.DataFrame, species: str) -> list[tuple[float, float, bool]]:
    """Return the observed positions of a species: x and y in m, and whether both were measured directly."""
    of_it = observations[(observations["species"] == species) & observations["value"].notna()]
    of_it = of_it[(of_it["unit"] == "m") & ~of_it["this_model"]]
    behind, aside = (of_it[of_it["quantity"] == name] for name in ("distance_behind", "lateral_distance"))
    return [
        (float(x["value"]), float(y["value"]), x["basis"] == y["basis"] == "measured")
        for _, x in behind.iterrows()
        for _, y in aside[aside["study"] == x["study"]].iterrows()
    ]


def describe(pair: pd.DataFrame, observations: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    rows = {objective: best(pair, objective) for objective in objectives_of(pair)}
    places = [
        f"for {least(objective)} {row['x_m']:.2f} m behind, {row['y_m']:.3f} m aside and "
        f"{abs(row['z_m']):.3f} m {'below' if row['z_m'] < 0 else 'above'} at phase {row['phase']:.2f}"
        for objective, row in rows.items()
    ]
    seen = [
        f"{x:.2f} m behind and {y:.3f} m aside" for x, y, _ in measured(observations, pair["species"].iloc[0])
    ]
    return (
        f"The best place behind a {common_name(pair['species'].iloc[0]).lower()} is {'; '.join(places)}. "
        f"Observed: {' or '.join(seen) or 'nothing to compare with'}. The wingtip's path of the follower "
        "runs along that of the leader, and the pair of states with the leader up and the follower down "
        "gives most of the force."
    )


@styled
def draw(pair: pd.DataFrame, observations: pd.DataFrame) -> Figure:
    """Draw the optimal position in two planes, and the forces in each pair of stroke states."""
    rows = [best(pair, objective) for objective in objectives_of(pair)]
    figure = Figure(figsize=(PAGE_WIDTH_IN, 5.2), layout="constrained")
    panels = figure.subplots(2, 2)
    _draw_above(panels[0, 0], rows, measured(observations, rows[0]["species"]))
    _draw_side(panels[0, 1], rows)
    forces = {row["objective"]: wake_forces(row) for row in rows}
    _draw_forces(panels[1, 0], forces, 0, "c", "Thrust that the wake gives, over drag")
    _draw_forces(panels[1, 1], forces, 1, "d", "Lift that the wake gives, over weight")
    panels[1, 1].tick_params(labelleft=False)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5)
    return figure


def _draw_above(axes: Axes, rows: list[pd.Series], seen: list[tuple[float, float, bool]]) -> None:
    wavelength, b = rows[0]["speed_m_s"] * rows[0]["period_s"], rows[0]["semispan_m"]
    length = 0.7 * b / wavelength
    draw_bird(axes, 0.0, 0.0, 1.0, length)
    axes.plot(0.0, 0.0, "D", color=LEADER, markersize=4, linestyle="none", label="leader")
    for row in rows:
        look = OBJECTIVES[row["objective"]]
        place = row["x_m"] / wavelength, row["y_m"] / b
        draw_bird(axes, *place, 1.0, length, facecolor=look["color"], alpha=0.12)
        axes.plot(*place, **mark(row["objective"], markersize=6, zorder=4), gid=f"optimum {row['objective']}")
        rule = spanwise_spacing_rule(b, row["upstroke_span_ratio"]) / b
        axes.axhline(
            rule,
            color=look["color"],
            linestyle=look["linestyle"],
            linewidth=0.7,
            gid=f"rule {row['objective']}",
        )
    axes.axvline(0.5, color=FAINT, linestyle="--", linewidth=0.7)
    for x, y, is_direct in seen:
        face: dict[str, Any] = {} if is_direct else {"markerfacecolor": "white"}
        axes.plot(
            x / wavelength,
            y / b,
            "D",
            color=OBSERVED,
            markersize=6,
            linestyle="none",
            gid="observed",
            label="measured on birds" if is_direct else "computed from measurements",
            **face,
        )
    axes.set(xlim=(-0.15, 0.75), ylim=(-1.15, 2.75), xlabel="x/λ, downstream", ylabel="y/b, to the right")
    letter(axes, "a", "From above")


def _draw_side(axes: Axes, rows: list[pd.Series]) -> None:
    wavelength, amplitude = rows[0]["speed_m_s"] * rows[0]["period_s"], rows[0]["leader_amplitude_m"]
    x = np.linspace(0.0, 1.25, 501)
    axes.plot(x, tip_height(x), color=LEADER, linewidth=1.0, gid="path leader")
    axes.plot(0.0, 0.0, "D", color=LEADER, markersize=4)
    axes.plot([0.0, 0.0], [-0.5, 0.5], color=LEADER, linewidth=0.8, alpha=0.4)
    for row in rows:
        look = OBJECTIVES[row["objective"]]
        start, height, share = row["x_m"] / wavelength, row["z_m"] / amplitude, row["amplitude_m"] / amplitude
        # The leader is at the end of its upstroke, phase 0; the follower lags it by κ.
        behind = x[x <= x[-1] - start]
        path = height + share * tip_height(behind + row["phase"])
        axes.plot(
            start + behind,
            path,
            color=look["color"],
            linestyle=look["linestyle"],
            linewidth=1.2,
            gid=f"path {row['objective']}",
        )
        axes.plot(
            [start] * 2,
            [height - share / 2, height + share / 2],
            color=look["color"],
            alpha=0.4,
            linewidth=0.8,
        )
        axes.plot(
            start, height, **mark(row["objective"], markersize=6, zorder=4), gid=f"optimum {row['objective']}"
        )
    axes.axvline(0.5, color=FAINT, linestyle="--", linewidth=0.7)
    axes.set(xlim=(-0.1, 1.25), ylim=(-0.8, 0.8), xlabel="x/λ, downstream", ylabel="z/$h_L$, up")
    letter(axes, "b", "From the side, with the wingtips' paths")


def _draw_forces(axes: Axes, forces: dict[str, np.ndarray], kind: int, name: str, title: str) -> None:
    """Draw thrust (0) or lift (1) in each pair of states, one line a pair."""
    axes.axvline(0.0, color=FAINT, linewidth=0.7)
    axes.axhline(len(STATES) - 0.5, color=FAINT, linewidth=0.5)
    lines = np.arange(len(STATES) + 1)
    for number, (objective, of_states) in enumerate(forces.items()):
        color = OBJECTIVES[objective]["color"]
        at = lines + 0.26 * (number - (len(forces) - 1) / 2.0)
        axes.hlines(at, 0.0, of_states[:, kind], color=color, linewidth=1.6)
        axes.plot(of_states[:, kind], at, **mark(objective, markersize=5), gid=f"{KINDS[kind]} {objective}")
        tell(axes.lines[-1], [f"{least(objective)}, {words}" for words in (*STATES.values(), MEAN)])
    axes.set_yticks(lines, [words.replace(", ", ",\n") for words in (*STATES.values(), MEAN)])
    axes.set_ylim(len(STATES) + 0.6, -0.6)
    in_percent(axes.xaxis)
    axes.set_xlabel(f"{KINDS[kind]} from the wake, over {('drag', 'weight')[kind]}")
    letter(axes, name, title)


PICTURE = Picture("optimal-position", "Where the follower should fly", CAPTION, describe, draw)
