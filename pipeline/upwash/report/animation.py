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
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from upwash.aero.wake import ROLL_UP, stroke_span
from upwash.batch.store import replacing
from upwash.errors import UpwashError
from upwash.report.figures.drawing import (
    DOWNSTROKE,
    LEADER,
    OBJECTIVES,
    STYLE,
    UPSTROKE,
    entry,
    legend_below,
    letter,
    tip_height,
)
from upwash.report.figures.flying_bird import flying_bird
from upwash.report.figures.perspective import View, draw_directions

FRAMES = 40
"""Pictures of one wingbeat."""

FRAMES_A_SECOND = 20
ENDINGS = (".gif", ".mp4")

VIEW = View(azimuth_deg=-28.0, elevation_deg=28.0)
SIZE_IN = (7.2, 6.0)
DOTS_AN_INCH = 100
MOST_WAVELENGTHS = 1.5
"""How much is drawn of a wake that is longer, or endless."""

TRACK_POINTS = 121
TURN = 0.09
"""Part of a wingbeat in which a drawn wing is flexed or stretched, where the model does it at once."""


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


def flexed(bird: pd.Series, phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far a bird's wings are flexed at some phases: 0 outstretched, 1 as on its upstroke.

    By the bird's span law they flex as the tip rises, or through the whole upstroke.
    """
    turn = np.mod(phase, 1.0)
    if bird["span_law"] == "tip":
        return np.reshape([stroke_span(one)[1] for one in np.ravel(turn)], np.shape(turn))

    def ease(share: NDArray[np.float64]) -> NDArray[np.float64]:
        s = np.clip(share + 0.5, 0.0, 1.0)
        return s * s * (3.0 - 2.0 * s)

    return np.asarray(ease((turn - 0.5) / TURN) - ease((turn - 1.0) / TURN) + ease(-turn / TURN))


def half_span(bird: pd.Series, phase: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far aside the wingtips of a bird are at some phases, in m."""
    narrower = 1.0 - bird["upstroke_span_ratio"]
    return np.asarray(bird["semispan_m"] * (1.0 - flexed(bird, phase) * narrower))


def shown_wavelengths(bird: pd.Series) -> float:
    """Return how many wavelengths of a bird's wake are drawn."""
    return min(float(bird["wavelengths"]), MOST_WAVELENGTHS)


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
    behind = np.linspace(0.0, shown_wavelengths(bird), TRACK_POINTS)
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


def rings(bird: pd.Series, phase: float) -> list[tuple[bool, NDArray[np.float64]]]:
    """Return the vortex rings behind a bird, the one that it is shedding first.

    Parameters
    ----------
    bird : Series
        A bird of a flock.
    phase : float
        Where it is in its own wingbeat.

    Returns
    -------
    list of (bool, (4, 3) ndarray of float)
        Of each ring whether an upstroke shed it, and its corners in m, relative to the first bird.
    """
    length, wavelength = shown_wavelengths(bird), bird["speed_m_s"] * bird["period_s"]
    # A half stroke began wherever the phase was a multiple of ½.
    turns = np.mod(phase, 0.5) + 0.5 * np.arange(int(2 * length) + 2)
    ends = np.unique(np.clip([0.0, *turns], 0.0, length))
    found = []
    for near, far in zip(ends[:-1], ends[1:], strict=True):
        is_up = bool(np.mod(phase - 0.5 * (near + far), 1.0) > 0.5)
        width = ROLL_UP * bird["semispan_m"] * (bird["upstroke_span_ratio"] if is_up else 1.0)
        x = bird["x_flock_m"] + wavelength * np.array([near, near, far, far])
        y = bird["y_flock_m"] + width * np.array([-1.0, 1.0, 1.0, -1.0])
        z = bird["z_flock_m"] + bird["amplitude_m"] * tip_height(phase - np.array([near, near, far, far]))
        found.append((is_up, np.stack([x, y, z], axis=-1)))
    return found


def outlines(bird: pd.Series, phase: float) -> list[NDArray[np.float64]]:
    """Return a bird's outlines as seen from its left, back to front, in m relative to the first bird.

    Parameters
    ----------
    bird : Series
        A bird of a flock.
    phase : float
        Where it is in its own wingbeat.

    Returns
    -------
    list of (n, 3) ndarray of float
        Right wing, body from above, body from the side, left wing.
    """
    middle = np.array([bird["x_flock_m"], bird["y_flock_m"], bird["z_flock_m"]])
    at = np.array(phase)
    tip = bird["amplitude_m"] * float(tip_height(at))
    parts = flying_bird(float(half_span(bird, at)), tip, float(flexed(bird, at)), bird["semispan_m"])
    return [middle + part for part in parts]


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
            self.side = self.figure.add_axes((0.09, 0.13, 0.88, 0.21))
            # Seen from the left, who flies further to the right is behind the others.
            order = self.birds["y_flock_m"].rank(method="first", ascending=False)
            self.moving = [
                self._artists(bird, int(rank))
                for (_, bird), rank in zip(self.birds.iterrows(), order, strict=True)
            ]
            self._frame()
        self.canvas = FigureCanvasAgg(self.figure)

    def _color(self, bird: pd.Series) -> str:
        return LEADER if bird["bird"] == 1 else OBJECTIVES[bird["objective"]]["color"]

    def _artists(self, bird: pd.Series, order: int) -> dict[str, Any]:
        color = self._color(bird)

        def patch(**look: Any) -> Polygon:
            shape = Polygon(np.zeros((3, 2)), closed=True, **look)
            self.view.add_patch(shape)
            return shape

        def line(**look: Any) -> Line2D:
            return self.side.plot([], [], **look)[0]

        return {
            "rings": [
                patch(linewidth=1.1, zorder=1, visible=False)
                for _ in range(int(2 * shown_wavelengths(bird)) + 2)
            ],
            "bird": [
                patch(facecolor=color, edgecolor="white", linewidth=0.3, zorder=3 + order) for _ in range(4)
            ],
            "path": line(color=color, linewidth=1.2),
            "tip": line(color=color, marker="o", markersize=6, zorder=3),
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
        seen = np.concatenate([VIEW.flat(part) for time in np.arange(8) / 8 for part in self._parts(time)])
        flat = np.array([seen.min(axis=0), seen.max(axis=0)]) + 0.1 * b * np.array([[-1.0], [1.0]])
        self.view.set(
            xlim=(flat[:, 0].min(), flat[:, 0].max()),
            ylim=(flat[:, 1].min(), flat[:, 1].max()),
            aspect="equal",
        )
        self.view.set_axis_off()
        draw_directions(self.view, VIEW, (high[0] + 0.5 * b, low[1], low[2]), 0.5 * b)
        self.side.set(
            xlim=(low[0], high[0]),
            ylim=(low[2] - 0.1 * amplitude, high[2] + 0.1 * amplitude),
            xlabel="x, downstream (m)",
            ylabel="z, up (m)",
        )
        letter(self.view, "a", "Birds, and the vortex rings that their wingbeats leave")
        look = {"linewidth": 5.0, "alpha": 0.6}
        legend_below(
            self.figure,
            [
                entry("shed on the downstroke", color=DOWNSTROKE, **look),
                entry("shed on the upstroke", color=UPSTROKE, **look),
            ],
            columns=2,
        )
        letter(self.side, "b", "Wingtips from the side, and the paths that they leave")

    def _parts(self, time: float) -> Iterator[NDArray[np.float64]]:
        """Give all that is seen of birds and rings at a time."""
        for (_, bird), phase in zip(self.birds.iterrows(), own_phases(self.birds, time), strict=True):
            yield from outlines(bird, float(phase))
            yield from (corners for _, corners in rings(bird, float(phase)))

    def show(self, time: float) -> None:
        """Move the picture to a time, in wingbeats since the first bird ended an upstroke."""
        for (_, bird), phase, moving in zip(
            self.birds.iterrows(), own_phases(self.birds, time), self.moving, strict=True
        ):
            right = tip_track(bird, float(phase))
            shed = rings(bird, float(phase))
            for patch in moving["rings"]:
                patch.set_visible(False)
            for patch, (is_up, corners) in zip(moving["rings"], shed, strict=False):
                color = UPSTROKE if is_up else DOWNSTROKE
                patch.set(
                    visible=True, xy=VIEW.flat(corners), facecolor=(color, 0.22), edgecolor=(color, 0.9)
                )
            parts = outlines(bird, float(phase))
            for patch, part in zip(moving["bird"], parts, strict=True):
                patch.set_xy(VIEW.flat(part))
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
