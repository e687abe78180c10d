"""Figure: the six-bird flock, where each bird flies, how it flaps, and what it spends."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, letter, styled
from upwash.report.figures.flocks import READINGS, look_of, papers_flocks, series
from upwash.report.figures.picture import Picture
from upwash.report.words import least

CAPTION = (
    "A chain of birds, each at the V optimum of the wake of the bird ahead: positions from (a) above and "
    "(b) the side, (c) upstroke span ratio and (d) amplitude over the first bird's, (e) induced and (f) "
    "profile power over the first bird's. Colours and markers: the cost. Filled, solid: the follower's "
    "amplitude is bounded by that of the bird ahead; hollow, dotted: by that of a lone bird. The paper's "
    "words allow both."
)
KINEMATICS = (
    ("span_ratio_ratio", "$R/R_1$", "Upstroke span ratio"),
    ("amplitude_ratio", "$h/h_1$", "Amplitude"),
    ("induced_ratio", "$P_\\mathrm{ind}/P_{\\mathrm{ind},1}$", "Induced power"),
    ("profile_ratio", "$P_\\mathrm{pro}/P_{\\mathrm{pro},1}$", "Profile power"),
)


def describe(flock: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for objective, reading, birds in series(papers_flocks(flock)):
        steps = birds["y_flock_m"].diff().abs().dropna()
        parts.append(
            f"{least(objective)}, {READINGS[reading]['words']}: {len(birds)} birds, "
            f"{steps.min():.2f} to {steps.max():.2f} m apart to the side, profile power of the second "
            f"{birds['profile_ratio'].iloc[1]:.2f} and of the last {birds['profile_ratio'].iloc[-1]:.2f} of "
            "the leader's"
        )
    return "Six panels of a flock. " + "; ".join(parts) + "."


@styled
def draw(flock: pd.DataFrame) -> Figure:
    """Draw the six panels of a flock."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 6.0), layout="constrained")
    panels = figure.subplots(3, 2)
    for objective, reading, birds in series(papers_flocks(flock)):
        look = look_of(objective, reading)
        for axes, second in ((panels[0, 0], "y_flock_m"), (panels[0, 1], "z_flock_m")):
            axes.plot(birds["x_flock_m"], birds[second], gid=f"{second} {objective} {reading}", **look)
        for axes, (name, _, _) in zip(panels[1:].flat, KINEMATICS, strict=True):
            axes.plot(birds["bird"], birds[name], gid=f"{name} {objective} {reading}", **look)
    panels[0, 0].set(xlabel="x, downstream (m)", ylabel="y, to the right (m)")
    panels[0, 1].set(xlabel="x, downstream (m)", ylabel="z, up (m)")
    letter(panels[0, 0], "a", "From above")
    letter(panels[0, 1], "b", "From the side (heights enlarged)")
    for axes, (_, symbol, words), name in zip(panels[1:].flat, KINEMATICS, "cdef", strict=True):
        _label(axes, symbol)
        letter(axes, name, words)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _label(axes: Axes, symbol: str) -> None:
    axes.axhline(1.0, color=FAINT, linewidth=0.6)
    axes.set(xlabel="bird, 1 the first", ylabel=symbol)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))


PICTURE = Picture("flock-formation", "A flock, bird by bird", CAPTION, describe, draw)
