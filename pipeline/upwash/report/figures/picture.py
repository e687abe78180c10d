"""What a figure is: a name, words about it, and a function that draws it from frames."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from matplotlib.figure import Figure

from upwash.study.sources import Sources


@dataclass(frozen=True)
class Picture:
    """A figure that is drawn from results.

    Its functions take frames of `upwash.study.sources.Sources` by their names: those without a default are
    needed, any other may be None.

    Parameters
    ----------
    name : str
        Its name, and that of its files.
    title, caption : str
        What it is called, and what is to be seen in it; each panel's letter stands in the caption.
    describe : callable
        Frames -> what it shows, in words and numbers.
    draw : callable
        Frames -> the figure.
    """

    name: str
    title: str
    caption: str
    describe: Callable[..., str]
    draw: Callable[..., Figure]

    @property
    def needs(self) -> list[str]:
        """The frames without which it cannot be drawn."""
        return [frame for frame, is_needed in self._frames().items() if is_needed]

    def arguments(self, sources: Sources) -> dict[str, Any] | None:
        """Return the frames that it takes, or None if one that it needs is not there."""
        if any(getattr(sources, frame) is None for frame in self.needs):
            return None
        return {frame: getattr(sources, frame) for frame in self._frames()}

    def _frames(self) -> dict[str, bool]:
        """Return each frame that it takes, and whether it is needed."""
        parameters = inspect.signature(self.describe).parameters.values()
        return {parameter.name: parameter.default is parameter.empty for parameter in parameters}
