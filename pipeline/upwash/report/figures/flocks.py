"""Choosing flocks to draw: which ones, and how the readings of the amplitude bound and the wakes look."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pandas as pd

from upwash.report.figures.drawing import OBJECTIVES
from upwash.report.words import least
from upwash.species.library import REFERENCE
from upwash.study.rows import objectives_of

PAPERS_BIRDS = 6
"""Birds of the paper's flock."""

READINGS: dict[str, dict[str, Any]] = {
    "immediate": {"linestyle": "-", "filled": True, "words": "bound by the bird ahead"},
    "lone": {"linestyle": ":", "filled": False, "words": "bound by the lone bird"},
}
"""Readings of the bound on amplitude: how they look, and in words."""


def papers_flocks(flock: pd.DataFrame) -> pd.DataFrame:
    """Return the flocks that are most like the paper's.

    An echelon of six northern bald ibises in which each feels the wake of the bird ahead; where a study has
    none such, the nearest that it has.
    """
    chosen = flock
    for name, wanted in (
        ("species", REFERENCE),
        ("shape", "echelon"),
        ("wake", "neighbour"),
        ("birds", PAPERS_BIRDS),
    ):
        values = chosen[name]
        chosen = chosen[values == (wanted if (values == wanted).any() else values.iloc[0])]
    return chosen


def with_leader(birds: pd.DataFrame) -> pd.DataFrame:
    """Return a flock's birds in order, the ratios to its leader beside them.

    Returns
    -------
    DataFrame
        One row a bird, with ``amplitude_ratio``, ``span_ratio_ratio``, ``induced_ratio`` and
        ``profile_ratio``: amplitude, upstroke span ratio, induced and profile power over the first bird's.
    """
    ordered = birds.sort_values("bird").reset_index(drop=True)
    return ordered.assign(
        amplitude_ratio=ordered["amplitude_m"] / ordered["leader_amplitude_m"],
        span_ratio_ratio=ordered["upstroke_span_ratio"] / ordered["leader_upstroke_span_ratio"],
        induced_ratio=ordered["power_induced_w"] / ordered["leader_power_induced_w"],
        profile_ratio=ordered["power_profile_w"] / ordered["leader_power_profile_w"],
    )


def series(flock: pd.DataFrame) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Give each objective and reading with the birds of its flock."""
    for objective in objectives_of(flock):
        for reading in READINGS:
            birds = flock[(flock["objective"] == objective) & (flock["reading"] == reading)]
            if len(birds):
                yield objective, reading, with_leader(birds[birds["flock_id"] == birds["flock_id"].iloc[0]])


def look_of(objective: str, reading: str) -> dict[str, Any]:
    """Return how the line of a flock looks: colour and marker by objective, filling and dashes by reading."""
    style, how = OBJECTIVES[objective], READINGS[reading]
    return {
        "color": style["color"],
        "marker": style["marker"],
        "linestyle": how["linestyle"],
        # A ring leaves a dot below it to be seen.
        "markerfacecolor": style["color"] if how["filled"] else "none",
        "markersize": 4.5 if how["filled"] else 7.5,
        "linewidth": 1.0,
        "label": f"{least(objective)}, {how['words']}",
    }
