"""Which study a sweep is, by its own text, and the rows that a results folder holds of it."""

from __future__ import annotations

import tomllib
from collections.abc import Callable

import pandas as pd

from upwash.batch.folder import Plan, ResultsFolder
from upwash.batch.store import read_table
from upwash.jobs.pair import Pair
from upwash.study.intervals import KEYS, outside_of_samples
from upwash.study.quantities import optima_of_jobs

COMPARISON, UNCERTAINTY, SENSITIVITY = "comparison", "uncertainty", "sensitivity"
"""Studies with tables of their own.

A comparison takes its intervals from the results folder named ``uncertainty`` beside its own.
"""

SALTELLI = "saltelli"


def study_of(plan: Plan) -> str:
    """Return which study a sweep may be: `COMPARISON`, `UNCERTAINTY`, `SENSITIVITY`, or "" for any other."""
    content = tomllib.loads(plan.text)
    blocks = content.get("block", [])
    tables = [content, *(blocks if isinstance(blocks, list) else [blocks])]
    keys = {key for table in tables for key in table}
    if plan.kind is not Pair or keys & {"solver", "grid", "zip", "leader", "phase_lock"}:
        return ""
    samples = [table["sample"] for table in tables if "sample" in table]
    if not samples:
        return COMPARISON
    if all(sample["method"] == SALTELLI for sample in samples):
        return SENSITIVITY
    return UNCERTAINTY if all("within" in sample for sample in samples) else ""


def is_of_several_species(rows: pd.DataFrame) -> bool:
    """Whether rows are of several species, one job for each objective and amplitude convention."""
    jobs = rows.drop_duplicates("job_id")
    return jobs["species"].nunique() > 1 and not jobs.duplicated(list(KEYS)).any()


def read_rows(folder: ResultsFolder) -> pd.DataFrame:
    """Return all rows of a gathered results folder of pairs."""
    return read_table(folder.path / Pair.file, Pair.rows).to_pandas()


def samples_beside(
    folder: ResultsFolder, rows: pd.DataFrame, tell: Callable[[str], None]
) -> pd.DataFrame | None:
    """Return the rows of the uncertainty sweep beside a results folder, or None if there is none to be used.

    Samples of a bird that has changed since they were drawn are left out, and said to be.
    """
    beside = ResultsFolder(folder.path.resolve().parent / UNCERTAINTY)
    if not (beside.path / Pair.file).exists():
        remedy = f"'upwash run {UNCERTAINTY}' and 'upwash aggregate' on its results, then on these again"
        tell(f"{folder}: tables without intervals: expected samples in {beside}, found none; {remedy}")
        return None
    samples = read_rows(beside)
    strays = outside_of_samples(optima_of_jobs(rows), optima_of_jobs(samples))
    if strays:
        strayed = f"found {', '.join(sorted(strays))} outside, left without"
        tell(
            f"{folder}: intervals: expected each bird among its samples in {beside}, {strayed}; run it again"
        )
    return samples[~samples["species"].isin(strays)]
