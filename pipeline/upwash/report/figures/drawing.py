"""What all figures share: style, colours that keep their meaning, birds, files that are alike each time."""

from __future__ import annotations

import functools
import io
from collections.abc import Callable, Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from matplotlib.ticker import FuncFormatter

from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import stroke_height
from upwash.report.words import least

STYLE = Path(__file__).parents[1] / "style.mplstyle"
PAGE_WIDTH_IN = 7.0
"""Width of a printed page's text, in inches."""

# As in the style file.
TITLE_PAD_PT, TICK_LABEL_PT = 5.0, 7.0

# Okabe and Ito's colours by what they mean here. Nothing is told by colour alone: marker or line says it too.
LEADER = "#000000"
DOWNSTROKE, UPSTROKE = "#009E73", "#56B4E9"
OBSERVED = "#CC79A7"
FAINT = "#8a8a8a"
LOOKS: tuple[dict[str, Any], ...] = (
    {"color": "#D55E00", "marker": "o", "linestyle": "-"},
    {"color": "#0072B2", "marker": "s", "linestyle": "--"},
    {"color": "#E69F00", "marker": "^", "linestyle": ":"},
)
OBJECTIVES = dict(zip(COST_FUNCTIONS, cycle(LOOKS), strict=False))
"""Cost function -> how its lines and marks look."""

# Without dates and versions of the writer the same figure is the same bytes.
METADATA: dict[str, dict[str, None]] = {
    ".pdf": {"CreationDate": None, "Producer": None, "Creator": None},
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
}


def styled(draw: Callable[..., Figure]) -> Callable[..., Figure]:
    """Let a function draw in the style of all figures, whatever the caller's own settings.

    Its panels are laid out once, here: saving would do it again for every format. How many ticks an axis
    has room for depends on the size of their labels, which is looked up when a figure is saved: it is fixed
    here too, so that a figure stays as it is drawn whoever saves it.
    """

    @functools.wraps(draw)
    def drawn(*args: Any, **kwargs: Any) -> Figure:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            style.use(STYLE)
            figure = draw(*args, **kwargs)
            for axes in figure.axes:
                for axis in (axes.xaxis, axes.yaxis):
                    axis.set_tick_params(labelsize=axis.get_tick_params().get("labelsize", TICK_LABEL_PT))
            figure.draw_without_rendering()
            figure.set_layout_engine(None)
            return figure

    return drawn


def save(figure: Figure, path: Path, ending: str = "") -> None:
    """Write a figure.

    Parameters
    ----------
    figure : Figure
        The figure.
    path : Path
        The file.
    ending : str
        Format: ``.pdf``, ``.png`` or ``.svg``; that of the path if not given.
    """
    path.write_bytes(as_bytes(figure, ending or path.suffix))


def as_bytes(figure: Figure, ending: str) -> bytes:
    """Return a figure as the content of a file of a format, given by its ending."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        style.use(STYLE)
        # A disk that fills up while Matplotlib writes to it ends in errors of its own.
        drawn = io.BytesIO()
        figure.savefig(drawn, format=ending[1:], metadata=METADATA[ending])
    return drawn.getvalue()


def mark(objective: str, **changes: Any) -> dict[str, Any]:
    """Return how the points of an objective look: colour, marker and label."""
    look = OBJECTIVES[objective] | {"linestyle": "none"}
    return look | {"label": least(objective)} | changes


def in_percent(axis: Axis) -> None:
    """Write an axis' ticks, which are fractions, as percentages with the digits that they need."""
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{100.0 * value:.3g} %".replace("-", "−")))


def letter(axes: Axes, name: str, title: str) -> None:
    """Name a panel by a bold letter before its title."""
    axes.set_title(f"     {title}")
    axes.annotate(
        name,
        (0.0, 1.0),
        (0.0, TITLE_PAD_PT),
        xycoords="axes fraction",
        textcoords="offset points",
        fontweight="bold",
        annotation_clip=False,
    )


def entry(label: str, **look: Any) -> Line2D:
    """Return a line for a legend."""
    return Line2D([], [], label=label, **look)


def dot(label: str, **look: Any) -> Line2D:
    """Return a mark for a legend."""
    return entry(label, **{"linestyle": "none", **look})


def legend_below(figure: Figure, shown: Axes | Sequence[Line2D], columns: int) -> None:
    """Explain below a figure what is named in a panel, or some lines and marks."""
    handles = shown.get_legend_handles_labels()[0] if isinstance(shown, Axes) else shown
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)


OUTLINE = (
    (-0.50, 0.00),
    (-0.36, 0.04),
    (-0.22, 0.07),
    (-0.24, 0.45),
    (-0.06, 1.00),
    (0.10, 0.50),
    (0.14, 0.08),
    (0.34, 0.05),
    (0.50, 0.09),
)
"""Half the outline of a bird seen from above, from the bill back to the tail: x in lengths, y in half-spans."""


def draw_bird(
    axes: Axes,
    x: float,
    y: float,
    half_span: float,
    length: float,
    **look: Any,
) -> None:
    """Draw a bird seen from above, flying to the left, in the units of the axes.

    Parameters
    ----------
    axes : Axes
        Where: streamwise to the right, spanwise up.
    x, y : float
        Its reference point.
    half_span, length : float
        Half of its wingspan, and its length from bill to tail.
    **look
        Passed on to the polygon.
    """
    outline = np.array(OUTLINE)
    both = np.vstack([outline, outline[::-1] * (1.0, -1.0)])
    look = {"facecolor": LEADER, "edgecolor": "none", "alpha": 0.25, "zorder": 1} | look
    axes.add_patch(Polygon(both * (length, half_span) + (x, y), closed=True, **look))


def tip_height(turns: np.ndarray) -> np.ndarray:
    """Return the height of a wingtip over its tip-to-tip amplitude.

    Parameters
    ----------
    turns : ndarray of float
        Phase of the bird, in wingbeats: the tip is highest at 0 and lowest at ½. The path that the tip of a
        bird at phase p has left in the air has at a distance x behind it the height of phase x/λ − p.

    Returns
    -------
    ndarray of float
        Height, between −½ and ½.
    """
    return np.vectorize(stroke_height, otypes=[float])(turns)
