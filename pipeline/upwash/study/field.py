"""The force map through a stored optimum: computed on all cores, and as a table."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.field_map import COORDINATES, PLANES, ForceMap, force_map
from upwash.batch.store import TABLE_OPTIONS, provenance, replacing
from upwash.columns import Column
from upwash.jobs.schema import schema_of
from upwash.optimum.variables import STREAMWISE_REACH
from upwash.study.rows import bird_of, model_of, pose_of

SPANWISE = 3.0
"""Reach of a map to the side, in semispans."""

FIELD = (
    *(of.column(name) for name in ("x_m", "y_m", "z_m", "phase")),
    Column("lift_n", "N", "vertical force on the follower, its own and the wake's"),
    Column("thrust_n", "N", "thrust of the follower, its own and the wake's, positive upstream"),
)
"""Columns of a force map, one row a point."""

# What a map is of: kept in its file's metadata, so that forces can be scaled and the optimum found.
OF_THE_OPTIMUM = of.names(of.belonging(of.PROBLEM, of.JOB, of.OPTIMUM, among=of.SOLUTIONS_COLUMNS))


def grid(bird: Bird, plane: str, size: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the coordinates of a map over the range that is searched, `size` of each.

    Returns
    -------
    tuple of (size,) ndarray of float
        x from 0 to 1.5 wavelengths; y from 0 to `SPANWISE` semispans, z within the leader's amplitude, or all
        phases.
    """
    reach = {
        "xy": (0.0, SPANWISE * bird.semispan_m),
        "xz": (-bird.amplitude_m, bird.amplitude_m),
        "xk": (0.0, 1.0),
    }
    return np.linspace(0.0, STREAMWISE_REACH * bird.wavelength_m, size), np.linspace(*reach[plane], size)


def plane_through(row: pd.Series, plane: str, size: int) -> ForceMap:
    """Return the force map in a plane through a stored optimum, over the range that is searched.

    Parameters
    ----------
    row : Series
        The optimum, by the columns of ``solutions.parquet``.
    plane : str
        ``xy``, ``xz`` or ``xk``: x and y, z or the phase.
    size : int
        Points along each side.

    Returns
    -------
    ForceMap
        The map, on the coordinates of `grid`.
    """
    bird, pose, model = bird_of(row), pose_of(row), model_of(row)
    first, across = grid(bird, plane, size)
    cores = os.cpu_count() or 1

    def rows_of(second: np.ndarray) -> ForceMap:
        return force_map(bird, bird.stroke, pose, plane, first, second, model)

    with ThreadPoolExecutor(cores) as threads:
        parts = list(threads.map(rows_of, np.array_split(across, cores)))
    names = ("second", "lift_n", "thrust_n")
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    return ForceMap(plane, first, **joined)


def ratios(plane_map: ForceMap, row: pd.Series) -> dict[str, np.ndarray]:
    """Return lift over weight and thrust over drag of a map, by ``lift`` and ``thrust``."""
    return {"lift": plane_map.lift_n / row["weight_n"], "thrust": plane_map.thrust_n / row["drag_n"]}


def field_table(plane_map: ForceMap, row: pd.Series) -> pa.Table:
    """Return a force map as a table, one row a point, the optimum in its metadata.

    Parameters
    ----------
    plane_map : ForceMap
        The map.
    row : Series
        The optimum through which it goes.
    """
    shape = plane_map.lift_n.shape
    columns = {name: np.full(plane_map.lift_n.size, row[name]) for name in ("x_m", "y_m", "z_m", "phase")}
    second = FIELD[COORDINATES.index(PLANES[plane_map.plane])].name
    columns["x_m"] = np.broadcast_to(plane_map.first, shape).ravel()
    columns[second] = np.broadcast_to(plane_map.second[:, None], shape).ravel()
    columns |= {"lift_n": plane_map.lift_n.ravel(), "thrust_n": plane_map.thrust_n.ravel()}
    metadata = provenance("") | {"plane": plane_map.plane} | {name: str(row[name]) for name in OF_THE_OPTIMUM}
    return pa.table(columns, schema=schema_of(FIELD).with_metadata(metadata))


def write_field(plane_map: ForceMap, row: pd.Series, path: Path) -> None:
    """Write a force map as Parquet, whole or not at all."""
    with replacing(path) as unfinished:
        pq.write_table(field_table(plane_map, row), unfinished, **TABLE_OPTIONS | {"write_statistics": True})
