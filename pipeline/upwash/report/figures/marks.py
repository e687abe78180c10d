"""The marks of a figure and the value behind each, read from what is drawn: so that both are the same."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Rectangle
from matplotlib.ticker import FuncFormatter
from numpy.typing import NDArray

MOST_ON_A_LINE = 60
"""Of a line without markers so many points answer."""


@dataclass(frozen=True)
class Mark:
    """A mark.

    Attributes
    ----------
    left, top : float
        Where it is, as shares of the figure's width and height.
    text : str
        What it is, with its values.
    """

    left: float
    top: float
    text: str


def tell(artist: Artist, rows: list[str]) -> None:
    """Say of each point of an artist which row of the results is behind it."""
    artist.upwash_rows = rows  # type: ignore[attr-defined]


def marks_of(figure: Figure) -> list[Mark]:
    """Return the marks of a figure that are named in it: points, points along lines, and bars."""
    width, height = figure.bbox.width, figure.bbox.height
    marks = []
    for axes in figure.axes:
        named = [artist for artist in axes.get_children() if artist.get_gid() and artist.get_visible()]
        both = (_Axis(axes, "x"), _Axis(axes, "y")) if named else ()
        for artist in named:
            for (x, y), text in _marks_of_artist(axes, both, artist):
                marks.append(Mark(round(float(x / width), 4), round(float(1.0 - y / height), 4), text))
    return marks


def _marks_of_artist(
    axes: Axes, both: Sequence[_Axis], artist: Artist
) -> Iterator[tuple[tuple[float, float], str]]:
    points = _points(artist)
    if points is None or not len(points):
        return
    pixels = (
        artist.get_transform().transform(points)
        if isinstance(artist, Line2D)
        else axes.transData.transform(points)
    )
    rows = getattr(artist, "upwash_rows", None)
    panel = _plain(axes.get_title(loc="left") or axes.get_title())
    label = str(artist.get_label() or "")
    name = "" if label.startswith("_") else _plain(label)
    if rows is None and not axes.axison:
        return
    inside = axes.bbox.expanded(1.02, 1.02)
    for number in _chosen(artist, len(points)):
        x, y = points[number]
        if not np.isfinite([x, y]).all() or not inside.contains(*pixels[number]):
            continue
        parts = [panel, rows[number] if rows else name]
        parts += [both[0].told(x), both[1].told(y)] if axes.axison else []
        yield (pixels[number][0], pixels[number][1]), "; ".join(dict.fromkeys(part for part in parts if part))


def _points(artist: Artist) -> NDArray[np.float64] | None:
    """Return the points of an artist in the units of its axes, or None if it has none."""
    if isinstance(artist, Line2D):
        return np.asarray(artist.get_xydata(), dtype=float)
    if isinstance(artist, PathCollection):
        return np.ma.filled(np.ma.asarray(artist.get_offsets(), dtype=float), np.nan)
    if isinstance(artist, Rectangle):
        return np.array([[artist.get_x() + artist.get_width() / 2.0, artist.get_y() + artist.get_height()]])
    return None


def _chosen(artist: Artist, count: int) -> Any:
    """Return which points answer: all that are marked, and some of those along a line."""
    is_bare = isinstance(artist, Line2D) and artist.get_marker() in ("", "None", None, " ")
    if not is_bare or count <= MOST_ON_A_LINE:
        return range(count)
    return np.unique(np.linspace(0, count - 1, MOST_ON_A_LINE).round().astype(int))


class _Axis:
    """How values along an axis are written: with its words, as names where its ticks have some, or in percent."""

    def __init__(self, axes: Axes, name: str) -> None:
        siblings = [axes, *getattr(axes, f"get_shared_{name}_axes")().get_siblings(axes)]
        labels = [getattr(one, f"get_{name}label")() for one in siblings]
        self.words = _plain(next(filter(None, labels), ""))
        axis = getattr(axes, f"{name}axis")
        formatter = axis.get_major_formatter()
        self.in_percent, self.names = False, {}
        if isinstance(formatter, FuncFormatter):
            self.in_percent = str(formatter(0.5, 0)).endswith("%")
            ticks = zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=False)
            self.names = {} if self.in_percent else {float(at): _plain(text.get_text()) for at, text in ticks}

    def told(self, value: float) -> str:
        """Return a value in words."""
        if named := self.names.get(float(value), ""):
            return f"{self.words} {named}" if named.replace(".", "").isdigit() else named
        text = f"{100.0 * value:.4g} %" if self.in_percent else f"{value:.4g}"
        text = text.replace("-", "−")
        # A unit in brackets stands behind the number.
        words, bracket, unit = self.words.rpartition(" (")
        return f"{words} {text} {unit.rstrip(')')}" if bracket else f"{self.words} {text}".strip()


def _plain(text: str) -> str:
    """Return a text without the marks of formulas."""
    text = re.sub(r"\\mathrm\{(.*?)\}", r"\1", text.replace("$", ""))
    text = re.sub(r"_\{(.*?)\}", r"_\1", text).replace("{", "").replace("}", "")
    return " ".join(text.replace("\n", " ").split())
