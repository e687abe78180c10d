"""Figures as the page shows them: for each cost by itself, fit for a dark page, and with a value behind every mark."""

from __future__ import annotations

import base64
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from joblib import Parallel, cpu_count, delayed
from matplotlib.figure import Figure

from upwash.report.figures.catalogue import FIGURES, make_folder, save_all
from upwash.report.figures.drawing import as_bytes
from upwash.report.figures.marks import Mark, marks_of
from upwash.report.figures.picture import Picture
from upwash.report.switches import LIMIT, PAPER, Switches
from upwash.study.rows import objectives_of
from upwash.study.sources import Sources

BY_COST = frozenset(
    {
        "optimal-position",
        "configurations",
        "force-maps",
        "spacing-rule",
        "optima-map",
        "flock-formation",
        "flock-saving",
        "flock-view",
        "drift",
    }
)
"""Figures that are drawn for each cost by itself."""

OF_POWER = frozenset({"limit-place", "limit-phase", "observed-saving", "refinement", "speed-power"})
"""Figures that are of least power alone."""

OF_PAPER = frozenset(
    {"optimal-position", "configurations", "force-maps", "spacing-rule", "optima-map"}
    | {"flock-formation", "flock-saving", "flock-view", "speed-power", "parameter-saving"}
)
"""Figures that tell of the paper's model alone; the others tell of both models or of neither."""

PROCESSES = 2
"""Figures are drawn in so many processes."""

# What Matplotlib writes in the light -> what stands there in the dark. Colours that mean something stay.
DARK = {
    "#ffffff": "#14191c",
    "#000000": "#e4e8e9",
    "#8a8a8a": "#9aa6ac",
    "#d0d0d0": "#384248",
    "#0072b2": "#5aa9dd",
}


@dataclass(frozen=True)
class Shown:
    """A figure as it is shown for some settings of the switches; for all, if these are empty.

    Attributes
    ----------
    costs, models : tuple of str
        The settings.
    words : str
        What it shows, in words and numbers.
    data : str
        The picture, as an address that holds it.
    width, height : int
        Its size, in CSS pixels.
    marks : list of Mark
        Its marks.
    """

    costs: tuple[str, ...]
    models: tuple[str, ...]
    words: str
    data: str
    width: int
    height: int
    marks: list[Mark]


def draw_all(sources: Sources, settings: Switches, folder: Path) -> dict[str, list[Shown]]:
    """Write every figure that some frames allow into a folder, and return how the page shows it, by its name.

    Parameters
    ----------
    sources : Sources
        The frames.
    settings : Switches
        The page's switches: a figure is there for each setting in which it differs.
    folder : Path
        The folder.

    Raises
    ------
    UpwashError
        If the folder or a file cannot be written.
    """
    make_folder(folder)
    tasks = [
        delayed(_draw_one)(name, frames, settings, folder)
        for name, picture in FIGURES.items()
        for frames in [picture.arguments(sources)]
        if frames is not None
    ]
    return dict(Parallel(n_jobs=min(PROCESSES, cpu_count()))(tasks))


def _draw_one(name: str, frames: dict[str, Any], settings: Switches, folder: Path) -> tuple[str, list[Shown]]:
    picture = FIGURES[name]
    figure = picture.draw(**frames)
    save_all(figure, folder / name)
    models = (PAPER,) if name in OF_PAPER and LIMIT in settings.models else ()
    if name not in BY_COST or len(settings.costs) < 2:
        costs = ("power",) if name in OF_POWER and "power" in settings.costs else ()
        return name, [_embedded(picture, figure, frames, costs, models)]
    shown = []
    for cost in settings.costs:
        of_cost = {frame: _only(rows, cost) for frame, rows in frames.items()}
        if all(rows is None or len(rows) for rows in of_cost.values()):
            shown.append(_embedded(picture, picture.draw(**of_cost), of_cost, (cost,), models))
    return name, shown


def _only(frame: pd.DataFrame | None, cost: str) -> pd.DataFrame | None:
    """Return the rows of a cost; what has no cost stays."""
    if frame is None or "objective" not in frame or cost not in objectives_of(frame):
        return frame if frame is None or "objective" not in frame else frame.iloc[:0]
    return frame[frame["objective"] == cost]


def _embedded(
    picture: Picture,
    figure: Figure,
    frames: dict[str, Any],
    costs: tuple[str, ...],
    models: tuple[str, ...],
) -> Shown:
    svg = as_bytes(figure, ".svg").decode()
    # The size in points stands in the first tag.
    width, height = (
        round(float(size) * 4.0 / 3.0)
        for size in re.findall(r'(?:width|height)="([\d.]+)pt"', svg[:2000])[:2]
    )
    data = "data:image/svg+xml;base64," + base64.b64encode(in_both_schemes(svg).encode()).decode()
    return Shown(costs, models, picture.describe(**frames), data, width, height, marks_of(figure))


def in_both_schemes(svg: str) -> str:
    """Return an SVG that has dark ground and light ink where the reader prefers that."""
    rules = "".join(
        f'[style*="{kind}: {light}"]{{{kind}:{dark} !important}}'
        for light, dark in DARK.items()
        for kind in ("fill", "stroke")
    )
    style = f"<style>@media (prefers-color-scheme: dark){{svg{{fill:{DARK['#000000']}}}{rules}}}</style>"
    head, end, rest = svg.partition("<defs>")
    return f"{head}{style}{end}{rest}"
