"""Places that the explorer shows: where birds of a species were seen, the paper's own point, a user's own birds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.errors import UpwashError, environment_fault
from upwash.paper.printed import TABLE_1
from upwash.species.library import REFERENCE, load_species
from upwash.study.observed.published import published_places

PLACE = ("x_m", "y_m")
"""What a table of observed birds must hold."""

MOST_OBSERVED = 20_000
"""More dots than this make a page that no browser moves smoothly."""


def seen_places(species: str, bird: Bird, observations: pd.DataFrame) -> list[dict[str, Any]]:
    """Return where a species was seen flying behind another bird, in m.

    Parameters
    ----------
    species : str
        Name in the library.
    bird : Bird
        Its bird, by whose lengths observations are given.
    observations : DataFrame
        As `upwash.study.observations.read_observations` returns.

    Returns
    -------
    list of dict
        One for each distance aside that a study gives: ``label``, ``y_m``, and ``x_m``, which is None where it tells
        no distance behind.
    """
    try:
        found = published_places(species, bird, observations)
    except UpwashError:
        return []
    is_told = ~found["assumed"].str.contains("behind")
    return [
        {"label": str(label), "x_m": x if told else None, "y_m": y}
        for label, x, y, told in zip(found["label"], found["x_m"], found["y_m"], is_told, strict=True)
    ]


def paper_place(bird: Bird) -> dict[str, float] | None:
    """Return the follower of the paper's Table 1, or None for any bird but the paper's."""
    if bird != load_species(REFERENCE).bird():
        return None
    value = {name.removeprefix("table-1-"): printed.values[0] for name, printed in TABLE_1.items()}
    return {
        "x_m": value["x"],
        "y_m": value["y"],
        # The paper counts heights from half the leader's amplitude below it.
        "z_m": value["z"] - bird.amplitude_m / 2.0,
        "phase": value["phase"],
        "amplitude_m": value["h"],
        "upstroke_span_ratio": value["R"],
    }


def read_observed(path: Path) -> list[list[float]]:
    """Return the places of a user's own birds.

    Parameters
    ----------
    path : Path
        CSV with the columns ``x_m`` (behind) and ``y_m`` (right of the leader), and any others.

    Returns
    -------
    list of [float, float]
        x and y of each bird, in m.

    Raises
    ------
    UpwashError
        If the file cannot be read, lacks a column, holds no bird or too many, or a place is no number.
    """
    try:
        table = pd.read_csv(path)
    except OSError as error:
        raise environment_fault(error) from error
    except (ValueError, pd.errors.ParserError) as error:
        said = " ".join(str(error).split())
        raise UpwashError(f"{path}: expected a table as CSV, found: {said}; correct it") from error
    missing = [name for name in PLACE if name not in table]
    if missing:
        found = ", ".join(map(str, table.columns[:8]))
        raise UpwashError(
            f"{path}: expected columns x_m (behind) and y_m (right of the leader), found {found}; "
            f"name them in its first line"
        )
    if not 1 <= len(table) <= MOST_OBSERVED:
        raise UpwashError(
            f"{path}: expected 1 to {MOST_OBSERVED} birds, found {len(table)}; take a sample of them"
        )
    numbers = table[list(PLACE)].apply(pd.to_numeric, errors="coerce")
    wrong = ~np.isfinite(numbers.to_numpy(dtype=float))
    if wrong.any():
        row, column = map(int, np.argwhere(wrong)[0])
        raise UpwashError(
            f"{path}, line {row + 2}, {PLACE[column]}: expected a number in m, "
            f"found {table[PLACE[column]].iloc[row]}; correct it or leave the line out"
        )
    return numbers.to_numpy(dtype=float).tolist()
