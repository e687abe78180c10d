"""Figure: wings that do not flap, where theory has closed forms, and what the paper's two points make of them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.fixed_wing import FixedWing
from upwash.aero.wake import CORE_RADIUS_RATIO, ROLL_UP
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    FAINT,
    LEADER,
    LOOKS,
    PAGE_WIDTH_IN,
    in_percent,
    legend_below,
    letter,
    styled,
)
from upwash.report.figures.picture import Picture
from upwash.study.rows import bird_of

CAPTION = (
    "What a wing that does not flap saves of the induced drag of an elliptic wing of its span and lift, level behind "
    "another. (a) Against its distance aside: the model in the limit of h → 0 and R → 1, with an endless wake felt on "
    "the whole span (line) and its closed form (dots); one wavelength of wake, felt there in the paper's two points; "
    "and Prandtl's elliptic wings. (b) Against its distance behind, 1.81 b aside: the one behind gains, the one ahead "
    "gains less the farther ahead it is, and together they save the same wherever they are, as Munk found."
)

EDGE = 1.0 + ROLL_UP + CORE_RADIUS_RATIO
"""Semispans aside at which the inner wingtip is on the edge of a vortex core."""
ASIDE = np.sort([*np.linspace(1.0, 3.0, 81), EDGE - 2.0 * CORE_RADIUS_RATIO, EDGE])
BEHIND = np.linspace(0.0, 6.0, 61)
BEST = 1.81


def _wings(bird: Bird) -> dict[str, FixedWing]:
    elliptic = FixedWing(bird.semispan_m, bird.weight_n, bird.speed_m_s, bird.density_kg_m3)
    papers = FixedWing(
        bird.semispan_m, bird.weight_n, bird.speed_m_s, bird.density_kg_m3, loading="uniform", wake="pair"
    )
    return {"elliptic": elliptic, "papers": papers}


def _closed_form(aside: NDArray[np.float64]) -> NDArray[np.float64]:
    """Integrate the wind of a straight pair with Rankine cores over a wing of uniform loading, as a saving."""

    def antiderivative(eta: NDArray[np.float64]) -> NDArray[np.float64]:
        near = np.abs(eta) < CORE_RADIUS_RATIO
        outside = np.log(np.where(near, 1.0, np.abs(eta)))
        inside = 0.5 * ((eta / CORE_RADIUS_RATIO) ** 2 - 1.0) + np.log(CORE_RADIUS_RATIO)
        return np.where(near, inside, outside)

    def wind(vortex: float) -> NDArray[np.float64]:
        return antiderivative(aside + 1.0 - vortex) - antiderivative(aside - 1.0 - vortex)

    return np.asarray(0.25 * (wind(ROLL_UP) - wind(-ROLL_UP)))


def _curves(bird: Bird, aside: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return the saving at each distance aside, in semispans."""
    wings, b, wavelength = _wings(bird), bird.semispan_m, bird.wavelength_m
    papers, core = wings["papers"], CORE_RADIUS_RATIO * bird.semispan_m
    cut = {"wake_length_m": wavelength, "core_radius_m": core}
    return {
        "elliptic": np.array([wings["elliptic"].saving_behind(wings["elliptic"], y_m=y * b) for y in aside]),
        "limit": np.array([papers.saving_behind(papers, y_m=y * b, core_radius_m=core) for y in aside]),
        "two points": np.array(
            [papers.saving_behind(papers, 0.5 * wavelength, y * b, nodes=2, **cut) for y in aside]
        ),
    }


def describe(pair: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    bird = bird_of(pair.iloc[0])
    best, at_edge = _curves(bird, np.array([BEST])), _curves(bird, np.array([EDGE]))
    return (
        f"Two panels. (a) {BEST} b aside the model in the limit saves {best['limit'][0]:.3f} of the drag, its closed "
        f"form {_closed_form(np.array([BEST]))[0]:.3f}, an elliptic wing {best['elliptic'][0]:.2f}; with two points, "
        f"{EDGE:.3f} b aside, {at_edge['two points'][0]:.2f}. (b) Together both wings save {best['limit'][0]:.3f}."
    )


@styled
def draw(pair: pd.DataFrame) -> Figure:
    """Draw the savings of wings that do not flap."""
    bird = bird_of(pair.iloc[0])
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.9), layout="constrained")
    aside, behind = figure.subplots(1, 2, width_ratios=(1.3, 1.0))
    _draw_aside(aside, bird)
    _draw_behind(behind, bird)
    legend_below(figure, aside, 2)
    return figure


def _draw_aside(axes: Axes, bird: Bird) -> None:
    curves = _curves(bird, ASIDE)
    looks = {"two points": LOOKS[1], "elliptic": LOOKS[2], "limit": LOOKS[0]}
    words = {
        "limit": "limit model, uniform loading",
        "two points": "one wavelength, two points",
        "elliptic": "elliptic wings",
    }
    for name, look in looks.items():
        line = {key: look[key] for key in ("color", "linestyle")}
        axes.plot(ASIDE, curves[name], **line, label=words[name], gid=name)
    dots = np.linspace(1.0, 3.0, 21)
    black: dict[str, Any] = {"color": LEADER, "linestyle": "none", "marker": ".", "markersize": 4}
    axes.plot(dots, _closed_form(dots), **black, label="its closed form", gid="closed form")
    axes.axhline(1.0, color=FAINT, linewidth=0.8, linestyle=":")
    axes.set(xlabel="y/b, to the side", ylabel="induced drag saved")
    in_percent(axes.yaxis)
    letter(axes, "a", "Beside the wing ahead, far behind")


def _draw_behind(axes: Axes, bird: Bird) -> None:
    papers, b = _wings(bird)["papers"], bird.semispan_m
    where = {"y_m": BEST * b, "core_radius_m": CORE_RADIUS_RATIO * b}
    follower = np.array([papers.saving_behind(papers, x * b, **where) for x in BEHIND])
    leader = np.array([papers.saving_behind(papers, -x * b, **where) for x in BEHIND])
    axes.plot(BEHIND, follower + leader, color=LEADER, gid="both")
    axes.plot(BEHIND, follower, color=LOOKS[0]["color"], gid="follower")
    axes.plot(BEHIND, leader, color=DOWNSTROKE, linestyle="--", gid="leader")
    for curve, text, above in (
        (follower + leader, "both", 4),
        (follower, "behind", -10),
        (leader, "ahead", 4),
    ):
        axes.annotate(text, (2.0, curve[20]), (0, above), textcoords="offset points", ha="left")
    axes.set(xlabel="x/b, behind", ylabel="induced drag saved", ylim=(0.0, 0.62))
    in_percent(axes.yaxis)
    letter(axes, "b", "One behind the other")


PICTURE = Picture("fixed-wings", "Wings that do not flap", CAPTION, describe, draw)
