"""A flock flapping in its wakes, as a moving picture: one wingbeat that repeats."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pandas as pd
from matplotlib import style
from matplotlib.animation import FFMpegWriter
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from upwash.aero.wake import stroke_span
from upwash.batch.store import replacing
from upwash.errors import UpwashError
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    LEADER,
    OBJECTIVES,
    STYLE,
    UPSTROKE,
    letter,
    tip_height,
)
from upwash.report.figures.perspective import View, draw_directions

FRAMES = 40
"""Pictures of one wingbeat."""

FRAMES_A_SECOND = 20
ENDINGS = (".gif", ".mp4")

VIEW = View(azimuth_deg=-28.0, elevation_deg=28.0)
SIZE_IN = (7.2, 6.0)
DOTS_AN_INCH = 100
WAKE_WAVELENGTHS = 1.0
WAKE_POINTS = 121
BODY_LENGTH = 0.7
"""Length of a body, in semispans."""


def own_phases(birds: pd.DataFrame, time: float) -> NDArray[np.float64]:
    """Return where in its own wingbeat each bird is.

    Parameters
    ----------
    birds : DataFrame
        A flock's birds.
    time : float
        Time since the first bird ended an upstroke, in wingbeats.

    Returns
    -------
    (n,) ndarray of float
        Phase in [0, 1): the wings are raised at 0 and lowered at ½.
    """
    return np.mod(time - birds["phase_flock"].to_numpy(dtype=float), 1.0)


def half_span(bird: pd.Series, phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far aside the wingtips of a bird are at some phases, in m."""
    parts = np.array([stroke_span(turn) for turn in np.ravel(phase)]).reshape(*np.shape(phase), 2)
    return bird["semispan_m"] * (parts[..., 0] + parts[..., 1] * bird["upstroke_span_ratio"])


def tip_track(bird: pd.Series, phase: float) -> NDArray[np.float64]:
    """Return the path in the air of a bird's right wingtip, from the tip downstream.

    Parameters
    ----------
    bird : Series
        A bird of a flock.
    phase : float
        Where it is in its own wingbeat.

    Returns
    -------
    (n, 3) ndarray of float
        Position in m, relative to the first bird.
    """
    behind = np.linspace(0.0, WAKE_WAVELENGTHS, WAKE_POINTS)
    shed = phase - behind
    wavelength = bird["speed_m_s"] * bird["period_s"]
    return np.stack(
        [
            bird["x_flock_m"] + wavelength * behind,
            bird["y_flock_m"] + half_span(bird, np.mod(shed, 1.0)),
            bird["z_flock_m"] + bird["amplitude_m"] * tip_height(shed),
        ],
        axis=-1,
    )


class Scene:
    """The picture: a view from the left above it, and one from the side; `show` moves it to a time.

    Parameters
    ----------
    birds : DataFrame
        A flock's birds, the first one included, by the columns of ``flock.parquet``.
    """

    def __init__(self, birds: pd.DataFrame) -> None:
        self.birds = birds.sort_values("bird").reset_index(drop=True)
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            style.use(STYLE)
            self.figure = Figure(figsize=SIZE_IN, dpi=DOTS_AN_INCH)
            # Not laid out anew for every picture, which would make the panels tremble.
            self.view = self.figure.add_axes((0.02, 0.4, 0.97, 0.56))
            self.side = self.figure.add_axes((0.09, 0.09, 0.88, 0.25))
            self.moving = [self._artists(bird) for _, bird in self.birds.iterrows()]
            self._frame()
        self.canvas = FigureCanvasAgg(self.figure)

    def _color(self, bird: pd.Series) -> str:
        return LEADER if bird["bird"] == 1 else OBJECTIVES[bird["objective"]]["color"]

    def _artists(self, bird: pd.Series) -> dict[str, Line2D]:
        color = self._color(bird)

        def line(axes: Axes, **look: Any) -> Line2D:
            return axes.plot([], [], **look)[0]

        wake = {"linewidth": 1.3, "alpha": 0.9}
        return {
            "left down": line(self.view, color=DOWNSTROKE, **wake),
            "left up": line(self.view, color=UPSTROKE, linestyle="--", **wake),
            "right down": line(self.view, color=DOWNSTROKE, **wake),
            "right up": line(self.view, color=UPSTROKE, linestyle="--", **wake),
            "wings": line(self.view, color=color, linewidth=2.8, solid_joinstyle="round", zorder=3),
            "body": line(self.view, color=color, linewidth=4.5, solid_capstyle="round", zorder=3),
            "path": line(self.side, color=color, linewidth=1.2),
            "tip": line(self.side, color=color, marker="o", markersize=6, zorder=3),
        }

    def _frame(self) -> None:
        birds = self.birds
        b, wavelength = birds["semispan_m"].max(), (birds["speed_m_s"] * birds["period_s"]).max()
        amplitude = birds["amplitude_m"].max()
        low = birds[["x_flock_m", "y_flock_m", "z_flock_m"]].min().to_numpy() - (b, b, amplitude / 2)
        high = birds[["x_flock_m", "y_flock_m", "z_flock_m"]].max().to_numpy() + (
            wavelength,
            b,
            amplitude / 2,
        )
        corners = np.array(
            [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
        )
        flat = VIEW.flat(corners)
        self.view.set(
            xlim=(flat[:, 0].min(), flat[:, 0].max()),
            ylim=(flat[:, 1].min(), flat[:, 1].max()),
            aspect="equal",
        )
        self.view.set_axis_off()
        draw_directions(self.view, VIEW, (low[0] + 0.8 * (high[0] - low[0]), low[1], low[2]), 0.5 * b)
        self.side.set(
            xlim=(low[0], high[0]),
            ylim=(low[2] - 0.1 * amplitude, high[2] + 0.1 * amplitude),
            xlabel="x, downstream (m)",
            ylabel="z, up (m)",
        )
        letter(self.view, "a", "Wings, and the paths that wingtips leave: downstroke solid, upstroke dashed")
        letter(self.side, "b", "Wingtips from the side, and the paths that they leave")

    def show(self, time: float) -> None:
        """Move the picture to a time, in wingbeats since the first bird ended an upstroke."""
        for (_, bird), phase, moving in zip(
            self.birds.iterrows(), own_phases(self.birds, time), self.moving, strict=True
        ):
            right = tip_track(bird, float(phase))
            left = right * (1.0, -1.0, 1.0) + (0.0, 2.0 * bird["y_flock_m"], 0.0)
            # The tip falls, in a downstroke, during the first half of the wingbeat.
            shed = phase - np.linspace(0.0, WAKE_WAVELENGTHS, WAKE_POINTS)
            is_down = np.mod(shed, 1.0) < 0.5
            for side, track in (("left", left), ("right", right)):
                flat = VIEW.flat(track)
                moving[f"{side} down"].set_data(*np.where(is_down[:, None], flat, np.nan).T)
                moving[f"{side} up"].set_data(*np.where(is_down[:, None], np.nan, flat).T)
            middle = np.array([bird["x_flock_m"], bird["y_flock_m"], bird["z_flock_m"]])
            moving["wings"].set_data(*VIEW.flat([left[0], middle, right[0]]).T)
            length = BODY_LENGTH * bird["semispan_m"]
            body = middle + length * np.array([[-0.4, 0.0, 0.0], [0.6, 0.0, 0.0]])
            moving["body"].set_data(*VIEW.flat(body).T)
            moving["path"].set_data(right[:, 0], right[:, 2])
            moving["tip"].set_data(right[:1, 0], right[:1, 2])

    def pictures(self) -> Iterator[NDArray[np.uint8]]:
        """Give the pictures of one wingbeat, each as an array of red, green, blue and opacity."""
        for number in range(FRAMES):
            self.show(number / FRAMES)
            self.canvas.draw()
            yield np.asarray(self.canvas.buffer_rgba()).copy()


def write_animation(birds: pd.DataFrame, path: Path) -> None:
    """Write a flock's wingbeat as a moving picture that repeats.

    Parameters
    ----------
    birds : DataFrame
        A flock's birds, by the columns of ``flock.parquet``.
    path : Path
        File; it ends in ``.gif``, or in ``.mp4`` where ffmpeg is installed.

    Raises
    ------
    UpwashError
        If it ends otherwise, there is no ffmpeg, or the file cannot be written.
    """
    check_ending(path)
    scene = Scene(birds)
    with replacing(path) as unfinished:
        if path.suffix == ".gif":
            _write_gif(scene, unfinished)
        else:
            _write_mp4(scene, unfinished)


def check_ending(path: Path) -> None:
    """Complain about a file that no animation can be written to."""
    if path.suffix not in ENDINGS:
        raise UpwashError(
            f"{path}: expected a name that ends in {' or '.join(ENDINGS)}, found none; choose one"
        )
    if path.suffix == ".mp4" and not FFMpegWriter.isAvailable():
        raise UpwashError(
            f"{path}: expected ffmpeg to be installed for .mp4, found none; install it or write .gif"
        )


def _write_gif(scene: Scene, path: Path) -> None:
    from PIL import Image

    pictures = [Image.fromarray(picture).convert("RGB") for picture in scene.pictures()]
    # One palette for all, taken from the first, or colours would flicker.
    palette = pictures[0].quantize(colors=64)
    first, *others = (picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in pictures)
    duration = 1000 // FRAMES_A_SECOND
    first.save(path, format="GIF", save_all=True, append_images=others, duration=duration, loop=0)


def _write_mp4(scene: Scene, path: Path) -> None:
    writer = FFMpegWriter(
        fps=FRAMES_A_SECOND, codec="libx264", extra_args=["-f", "mp4", "-pix_fmt", "yuv420p"]
    )
    with writer.saving(scene.figure, str(path), DOTS_AN_INCH):
        for number in range(FRAMES):
            scene.show(number / FRAMES)
            writer.grab_frame()
