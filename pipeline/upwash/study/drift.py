"""What is left of savings while birds drift about their best places, kept beside the results of the sweep."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas as pd

from upwash import columns as of
from upwash.batch.store import encode, provenance, write_atomic
from upwash.columns import Column, column
from upwash.jobs.schema import schema_of
from upwash.place.balance import Behind
from upwash.place.robust import Jittering, Spread
from upwash.study.robustness import ROBUSTNESS
from upwash.study.rows import bird_of, model_of, pose_of

FILE = "drift.parquet"
"""File of what is left, in a results folder."""

SIGMAS_M = (0.01, 0.05, 0.1, 0.2)
"""Standard deviations of the place in x, y and z that are looked at, in m."""

TOLD_M = 0.1
"""The one of them that is told where there is room for one."""

_SAID = {entry.name: entry for entry in ROBUSTNESS}
DRIFT: tuple[Column, ...] = (
    *(column(name) for name in ("job_id", "species", "objective", "model", "span_law")),
    *(_SAID[name] for name in ("sigma_m", "saving_still", "saving_held")),
)
"""Columns of the file, one row a job and deviation."""


def drift(rows: pd.DataFrame, sigmas_m: Sequence[float] = SIGMAS_M) -> pd.DataFrame:
    """Return what is left of the saving at each V optimum while its place jitters, with one stroke that is held.

    Parameters
    ----------
    rows : DataFrame
        Optima of pairs, by the columns of ``solutions.parquet``; those that are no V optimum are passed over.
    sigmas_m : sequence of float
        Standard deviations of the place in x, y and z, in m.

    Returns
    -------
    DataFrame
        The columns of `DRIFT`.
    """
    found = []
    for _, row in rows[rows["is_v_optimum"].eq(True)].iterrows():
        behind = Behind(bird_of(row), row["objective"], model=model_of(row))
        same = {name: row[name] for name in ("job_id", "species", "objective", "model", "span_law")}
        for sigma_m in sigmas_m:
            left = Jittering(behind, Spread.of_place(sigma_m)).remaining(pose_of(row))
            numbers = {"saving_still": row["saving_total"], "saving_held": left.saving_held}
            found.append(same | {"sigma_m": sigma_m} | numbers)
    return pd.DataFrame(found, columns=of.names(DRIFT))


def keep_drift(folder: Path, rows: pd.DataFrame) -> pd.DataFrame:
    """Return what is left for the V optima of a results folder; what its file holds already is not computed anew.

    Parameters
    ----------
    folder : Path
        The folder, whose file `FILE` is written.
    rows : DataFrame
        Its optima.
    """
    path = folder / FILE
    known = read_drift(folder)
    jobs = set(rows.loc[rows["is_v_optimum"].eq(True), "job_id"])
    if known is not None and set(known["job_id"]) == jobs and set(known["sigma_m"]) == set(SIGMAS_M):
        return known
    found = drift(rows)
    write_atomic(path, encode(of_records(found), schema_of(DRIFT), provenance("")))
    return found


def of_records(frame: pd.DataFrame) -> list[of.Row]:
    """Return a frame as dictionaries, one a row; what is absent is None."""
    values = frame.astype(object).where(frame.notna(), None)
    return [dict(zip(frame.columns, row, strict=True)) for row in values.itertuples(index=False, name=None)]


def read_drift(folder: Path) -> pd.DataFrame | None:
    """Return what is kept in a results folder, or None."""
    path = folder / FILE
    return pd.read_parquet(path) if path.exists() else None
