"""Figure: what flight costs at each airspeed, alone and behind another bird, and the airspeeds that are best."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from upwash.report.figures.drawing import LEADER, OBJECTIVES, PAGE_WIDTH_IN, legend_below, letter, styled
from upwash.report.figures.picture import Picture
from upwash.report.words import common_name
from upwash.study.airspeed import best_speed

CAPTION = (
    "(a) Total power and (b) energy per distance against airspeed: of the lone bird, of a follower at the V "
    "optimum, and of one at the best optimum of all, each at the position and stroke of least power at that "
    "airspeed. Upright lines and numbers: the airspeed at which each costs least; with ≤, the least lies at "
    "the slowest airspeed that was solved, or below."
)
CURVES = {
    "alone": {"color": LEADER, "linestyle": "-", "marker": "D", "label": "lone bird"},
    "is_v_optimum": OBJECTIVES["power"] | {"label": "V optimum"},
    "is_global_optimum": {"color": "#009E73", "linestyle": ":", "marker": "o", "label": "best of all"},
}
PANELS = (
    ("Power", "total power (W)", False),
    ("Energy per distance", "energy per distance (J/m)", True),
)


def power_curves(speeds: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return airspeed and total power of the lone bird and of both optima.

    Parameters
    ----------
    speeds : DataFrame
        All optima of least power of a bird at several airspeeds.

    Returns
    -------
    dict of str to DataFrame
        Key of `CURVES` -> ``speed_m_s`` in increasing order and ``power_w``; airspeeds without such an
        optimum are left out.
    """
    curves = {}
    for name in CURVES:
        of_it = speeds[speeds["rank"] == 0] if name == "alone" else speeds[speeds[name].eq(True)]
        power = of_it["leader_power_total_w" if name == "alone" else "power_total_w"]
        curves[name] = pd.DataFrame({"speed_m_s": of_it["speed_m_s"], "power_w": power}).sort_values(
            "speed_m_s"
        )
    return {name: curve for name, curve in curves.items() if len(curve)}


def describe(speeds: pd.DataFrame) -> str:
    """Say in words what the figure shows."""
    parts = []
    for title, _, per_metre in PANELS:
        best = [
            f"{CURVES[name]['label']} {_best(curve, per_metre)[1]} m/s"
            for name, curve in power_curves(speeds).items()
        ]
        parts.append(f"least {title.lower()}: {', '.join(best)}")
    return f"The best airspeeds of a {common_name(speeds['species'].iloc[0]).lower()}. {'; '.join(parts)}."


def _best(curve: pd.DataFrame, per_metre: bool) -> tuple[float, str]:
    """Return the airspeed of least cost, and how it is written."""
    speed = curve["speed_m_s"].to_numpy(float)
    cost = curve["power_w"].to_numpy(float) / (speed if per_metre else 1.0)
    best = best_speed(speed, cost)
    sign = "≤ " if best == speed[0] else "≥ " if best == speed[-1] else ""
    return best, f"{sign}{best:.1f}"


@styled
def draw(speeds: pd.DataFrame) -> Figure:
    """Draw power and energy per distance against airspeed."""
    figure = Figure(figsize=(PAGE_WIDTH_IN, 2.9), layout="constrained")
    panels = figure.subplots(1, 2)
    for axes, name, (title, label, per_metre) in zip(panels, "ab", PANELS, strict=True):
        for curve_name, curve in power_curves(speeds).items():
            _draw_curve(axes, curve, per_metre, curve_name)
        axes.set(xlabel="U, airspeed (m/s)", ylabel=label)
        axes.set_ylim(bottom=0.0)
        letter(axes, name, title)
    legend_below(figure, panels[0], 3)
    return figure


def _draw_curve(axes: Axes, curve: pd.DataFrame, per_metre: bool, name: str) -> None:
    look = CURVES[name]
    unit = curve["speed_m_s"] if per_metre else 1.0
    axes.plot(
        curve["speed_m_s"],
        curve["power_w"] / unit,
        markersize=3.5,
        gid=f"{name} {'energy' if per_metre else 'power'}",
        **look,
    )
    best, words = _best(curve, per_metre)
    axes.axvline(best, color=look["color"], linestyle=look["linestyle"], linewidth=0.7)
    height = 0.02 + 0.08 * list(CURVES).index(name)
    axes.annotate(
        words,
        (best, height),
        (3, 0),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        color=look["color"],
        fontsize=7,
        bbox={"facecolor": "white", "edgecolor": "none", "pad": 1.0},
    )


PICTURE = Picture("speed-power", "How fast to fly", CAPTION, describe, draw)
