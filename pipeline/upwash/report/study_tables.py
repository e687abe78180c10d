"""The tables that a gathered results folder is worth, written beside its summary.

A sweep over species is compared, one that samples each species' own ranges gives intervals, and one with a
Saltelli design gives sensitivity indices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from upwash.batch.folder import Plan, ResultsFolder
from upwash.batch.store import (
    Damaged,
    cannot_write,
    encode,
    provenance,
    write_atomic,
)
from upwash.columns import INTEGER, Column
from upwash.errors import UpwashError
from upwash.jobs.schema import schema_of
from upwash.report import species_tables as show
from upwash.report.table import Table
from upwash.study import comparison as between_species
from upwash.study import sensitivity as of_inputs
from upwash.study.intervals import COUNTS as SAMPLE_COUNTS
from upwash.study.intervals import interval_columns, intervals
from upwash.study.mechanism import COUNTS, MECHANISM, count_species, mechanism
from upwash.study.observations import OBSERVED, compare_with_observations
from upwash.study.quantities import QUANTITIES, optima_of_jobs
from upwash.study.studies import (
    SENSITIVITY,
    UNCERTAINTY,
    is_of_several_species,
    read_rows,
    samples_beside,
    study_of,
)

TABLES = "tables"
"""Folder for the tables, in the results folder."""


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
    paths = [path for table in written for path in table.write(folder.path / TABLES, metadata)]
    tell(f"{folder}: tables in {folder.path / TABLES}: {', '.join(table.name for table in written)}")
    return paths


def _written(study: str, folder: ResultsFolder, plan: Plan, tell: Callable[[str], None]) -> list[Written]:
    rows = read_rows(folder)
    if study == SENSITIVITY:
        return _sensitivity(rows, plan)
    if study == UNCERTAINTY:
        return _intervals(rows)
    return _comparison(rows, samples_beside(folder, rows, tell)) if is_of_several_species(rows) else []


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
            "md": "\n\n".join([table.markdown() for table in self.tables]).encode() + b"\n",
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
    return [
        Written("intervals", ends[[column.name for column in columns]], columns, [show.intervals_table(ends)])
    ]


def _sensitivity(rows: pd.DataFrame, plan: Plan) -> list[Written]:
    indices = of_inputs.sensitivity(rows, plan.jobs)
    return [Written("sensitivity", indices, of_inputs.SENSITIVITY, show.sensitivity_tables(indices))]
