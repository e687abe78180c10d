"""The page's two switches, which cost is least and which model is meant, and what is true for some settings."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import pandas as pd

from upwash.aero.power import COST_FUNCTIONS
from upwash.study.rows import objectives_of
from upwash.study.sources import Sources

PAPER, LIMIT = "paper", "limit"
MODELS = (PAPER, LIMIT)
"""Settings of the switch of models."""


@dataclass(frozen=True)
class Said:
    """A text that is true for some settings of the switches.

    Parameters
    ----------
    text : str
        The text.
    costs, models : tuple of str
        The settings; all, if empty.
    """

    text: str
    costs: tuple[str, ...] = ()
    models: tuple[str, ...] = ()


@dataclass(frozen=True)
class Switches:
    """Which settings the switches have: those that the results tell of, the first of each at the beginning."""

    costs: tuple[str, ...]
    models: tuple[str, ...]


def switches(sources: Sources) -> Switches:
    """Return the switches that some results allow."""
    frames = {PAPER: sources.pair, LIMIT: sources.limit}
    models = tuple(name for name, frame in frames.items() if frame is not None)
    every = [sources.pair, sources.limit, sources.flock, sources.species]
    return Switches(_costs(frame for frame in every if frame is not None), models)


def _costs(frames: Iterable[pd.DataFrame]) -> tuple[str, ...]:
    """Return the costs that were made least; least power, by which savings are told, before the others."""
    found: Sequence[str] = [name for frame in frames for name in objectives_of(frame)]
    return tuple(
        sorted(dict.fromkeys(found), key=lambda name: (name != "power", [*COST_FUNCTIONS].index(name)))
    )
