"""All figures in the order of the story, and drawing them from results folders.

The name of a figure stands once, with its `Picture`, in the module that draws it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from matplotlib.figure import Figure

from upwash.batch.store import cannot_write, replacing
from upwash.errors import UpwashError
from upwash.report.figures import (
    configurations,
    drift,
    fixed_wings,
    flock_formation,
    flock_saving,
    flock_view,
    force_maps,
    limit_claims,
    limit_phase,
    limit_place,
    lone_wake,
    observed_saving,
    optima_map,
    optimal_position,
    parameter_saving,
    refinement,
    spacing_rule,
    species_groups,
    species_observed,
    species_rows,
    speed_power,
)
from upwash.report.figures.drawing import METADATA, save
from upwash.report.figures.picture import Picture
from upwash.study.sources import Sources, read_study, sort_studies

FIGURES: dict[str, Picture] = {
    picture.name: picture
    for picture in (
        lone_wake.PICTURE,
        configurations.PICTURE,
        optimal_position.PICTURE,
        force_maps.PICTURE,
        spacing_rule.PICTURE,
        fixed_wings.PICTURE,
        optima_map.PICTURE,
        limit_place.PICTURE,
        limit_phase.PICTURE,
        limit_claims.PICTURE,
        drift.PICTURE,
        refinement.PICTURE,
        observed_saving.PICTURE,
        flock_formation.PICTURE,
        flock_view.PICTURE,
        flock_saving.PICTURE,
        *species_rows.PICTURES,
        species_groups.PICTURE,
        species_observed.PICTURE,
        speed_power.PICTURE,
        parameter_saving.PICTURE,
    )
}
"""Name -> figure, in the order of the story."""

FOLDER = "figures"
"""Folder for the figures, in a results folder."""


def read_sources(*results: str | os.PathLike[str]) -> Sources:
    """Read what figures can be drawn from: results folders, the first before the others.

    Raises
    ------
    UpwashError
        If one of them is no gathered results folder.
    """
    return sort_studies(read_study(Path(folder)) for folder in results)


def draw(name: str, *results: str | os.PathLike[str]) -> Figure:
    """Draw one figure.

    Parameters
    ----------
    name : str
        A key of `FIGURES`.
    *results : str or path
        Results folders; each frame is taken from the first that has it.

    Raises
    ------
    UpwashError
        If there is no such figure, or the folders hold nothing to draw it from.
    """
    if name not in FIGURES:
        raise UpwashError(f"figure: expected one of {', '.join(FIGURES)}, found {name!r}; choose one")
    figure = FIGURES[name]
    frames = figure.arguments(read_sources(*results))
    if frames is None:
        needed, folders = " and ".join(figure.needs), ", ".join(map(str, results))
        raise UpwashError(
            f"figure {name}: expected a study to draw it from ({needed}), found none in {folders}; name "
            "another folder"
        )
    return figure.draw(**frames)


def make_folder(folder: Path) -> None:
    """Make the folder of the figures."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise cannot_write(folder, error) from error


def save_all(drawn: Figure, stem: Path, endings: Iterable[str] = METADATA) -> list[Path]:
    """Write one figure in all formats, or those whose endings are given, each file whole or not at all."""
    paths = [stem.with_name(f"{stem.name}{ending}") for ending in endings]
    for path in paths:
        with replacing(path) as unfinished:
            save(drawn, unfinished, path.suffix)
    return paths
