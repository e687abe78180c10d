"""The tables that a gathered results folder is worth, written beside its summary.

A sweep over species is compared, one that samples each species' own ranges gives intervals, and one with a
Saltelli design gives sensitivity indices.  Which of these a sweep is, its own text says.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from upwash.batch.columns import INTEGER, Column
from upwash.batch.folder import Plan, ResultsFolder
from upwash.batch.store import (
    GATHERED,
    ROWS,
    Damaged,
    cannot_write,
    encode,
    provenance,
    read_table,
    schema_of,
    write_atomic,
)
from upwash.errors import UpwashError
from upwash.report import comparison as between_species
from upwash.report import sensitivity as of_inputs
from upwash.report import species_tables as show
from upwash.report.intervals import COUNTS as SAMPLE_COUNTS
from upwash.report.intervals import KEYS, interval_columns, intervals, outside_of_samples
from upwash.report.mechanism import COUNTS, MECHANISM, count_species, mechanism
from upwash.report.observations import OBSERVED, compare_with_observations
from upwash.report.quantities import QUANTITIES, optima_of_jobs
from upwash.report.table import Table

COMPARISON, UNCERTAINTY, SENSITIVITY = "comparison", "uncertainty", "sensitivity"
"""Studies with tables of their own.

A comparison takes its intervals from the results folder named ``uncertainty`` beside its own.
"""

TABLES = "tables"
"""Folder for the tables, in the results folder."""

SALTELLI = "saltelli"


def after_aggregate(results: str | Path, tell: Callable[[str], None]) -> list[Path]:
    """Write the tables that follow from a gathered results folder.

    Parameters
    ----------
    results : str or path
        The folder.
    tell : callable
        Takes lines for a person: what was written, and what could not be and why.

    Returns
    -------
    list of Path
        The files; none if the sweep is not one of those that have such tables.
    """
    folder = ResultsFolder(results)
    plan = folder.plan()
    study = study_of(plan) if plan else ""
    if plan is None or not study:
        return []
    try:
        written = _written(study, folder, plan, tell)
    except (UpwashError, Damaged) as error:
        # The rows are gathered whatever becomes of the tables.
        tell(f"{folder}: no tables: {error}")
        return []
    if not written:
        return []
    metadata = provenance(plan.text)
    paths = [path for one in written for path in one.write(folder.path / TABLES, metadata)]
    tell(f"{folder}: tables in {folder.path / TABLES}: {', '.join(one.name for one in written)}")
    return paths


def study_of(plan: Plan) -> str:
    """Return which study a sweep may be: `COMPARISON`, `UNCERTAINTY`, `SENSITIVITY`, or "" for any other."""
    content = tomllib.loads(plan.text)
    blocks = content.get("block", [])
    tables = [content, *(blocks if isinstance(blocks, list) else [blocks])]
    keys = {key for table in tables for key in table}
    if plan.kind != "pair" or keys & {"solver", "grid", "zip"}:
        return ""
    samples = [table["sample"] for table in tables if "sample" in table]
    if not samples:
        return COMPARISON
    if all(sample["method"] == SALTELLI for sample in samples):
        return SENSITIVITY
    return UNCERTAINTY if all("within" in sample for sample in samples) else ""


def _written(study: str, folder: ResultsFolder, plan: Plan, tell: Callable[[str], None]) -> list[Written]:
    rows = read_rows(folder)
    if study == SENSITIVITY:
        return _sensitivity(rows, plan)
    if study == UNCERTAINTY:
        return _intervals(rows)
    return _comparison(rows, samples_beside(folder, rows, tell)) if _is_of_several_species(rows) else []


def _is_of_several_species(rows: pd.DataFrame) -> bool:
    """Whether rows are of several species, one job for each objective and amplitude convention."""
    jobs = rows.drop_duplicates("job_id")
    return jobs["species"].nunique() > 1 and not jobs.duplicated(list(KEYS)).any()


def read_rows(folder: ResultsFolder) -> pd.DataFrame:
    """Return all rows of a gathered results folder of pairs."""
    return read_table(folder.path / GATHERED["pair"], ROWS["pair"]).to_pandas()


def samples_beside(
    folder: ResultsFolder, rows: pd.DataFrame, tell: Callable[[str], None]
) -> pd.DataFrame | None:
    """Return the rows of the uncertainty sweep beside a results folder, or None if there is none to be used.

    Samples of a bird that has changed since they were drawn are left out, and said to be.
    """
    beside = ResultsFolder(folder.path.resolve().parent / UNCERTAINTY)
    if not (beside.path / GATHERED["pair"]).exists():
        remedy = f"'upwash run {UNCERTAINTY}' and 'upwash aggregate' on its results, then on these again"
        tell(f"{folder}: tables without intervals: expected samples in {beside}, found none; {remedy}")
        return None
    samples = read_rows(beside)
    strays = outside_of_samples(optima_of_jobs(rows), optima_of_jobs(samples))
    if strays:
        found = f"found {', '.join(sorted(strays))} outside, left without"
        tell(f"{folder}: intervals: expected each bird among its samples in {beside}, {found}; run it again")
    return samples[~samples["species"].isin(strays)]


@dataclass(frozen=True)
class Written:
    """A frame to be kept as Parquet and CSV, and how it is shown as Markdown."""

    name: str
    frame: pd.DataFrame
    columns: Sequence[Column]
    tables: Sequence[Table]

    def write(self, folder: Path, metadata: dict[str, str]) -> list[Path]:
        """Write the three files into a folder and return their paths."""
        try:
            folder.mkdir(exist_ok=True)
        except OSError as error:
            raise cannot_write(folder, error) from error
        whole = [column.name for column in self.columns if column.type == INTEGER]
        table = Table(self.name, self.frame.astype(dict.fromkeys(whole, "Int64")))
        contents = {
            "parquet": encode(table.records(), schema_of(self.columns), metadata),
            "csv": table.csv().encode(),
            "md": "\n\n".join([one.markdown() for one in self.tables]).encode() + b"\n",
        }
        paths = [folder / f"{self.name}.{ending}" for ending in contents]
        for path, content in zip(paths, contents.values(), strict=True):
            write_atomic(path, content)
        return paths


def _comparison(rows: pd.DataFrame, samples: pd.DataFrame | None) -> list[Written]:
    compared = between_species.compare(rows, samples)
    changes = between_species.compare_objectives(rows, samples)
    answers, observed = mechanism(rows, samples), compare_with_observations(rows, samples)
    counts = count_species(answers)
    return [
        Written(
            "comparison",
            compared,
            between_species.COMPARISON,
            [show.overview_table(compared), *show.comparison_tables(compared), show.groups_table(compared)],
        ),
        Written("objectives", changes, between_species.objectives_columns(), show.objectives_tables(changes)),
        Written("mechanism", answers, MECHANISM, [show.answers_table(answers)]),
        Written("mechanism-counts", counts, COUNTS, [show.counts_table(counts)]),
        Written("observations", observed, OBSERVED, show.observations_tables(observed)),
    ]


def _intervals(rows: pd.DataFrame) -> list[Written]:
    ends = intervals(optima_of_jobs(rows)).reset_index()
    columns = (*between_species.NAMES, *interval_columns(QUANTITIES), *SAMPLE_COUNTS)
    return [Written("intervals", ends[[one.name for one in columns]], columns, [show.intervals_table(ends)])]


def _sensitivity(rows: pd.DataFrame, plan: Plan) -> list[Written]:
    indices = of_inputs.sensitivity(rows, plan.jobs)
    return [Written("sensitivity", indices, of_inputs.SENSITIVITY, show.sensitivity_tables(indices))]
