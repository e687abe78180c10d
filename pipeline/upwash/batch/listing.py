"""Naming jobs for people: by species, objective, and whatever else varies among them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from typing import Any

from upwash import columns as of
from upwash.batch.folder import ResultsFolder
from upwash.batch.index import read_index, table_files

ALWAYS = ("species", "objective")


@dataclass(frozen=True)
class Listed:
    """One job of a results folder: how it ended, what it is, and what went wrong, or ""."""

    job_id: str
    status: str
    label: str
    cause: str


def list_jobs(folder: ResultsFolder) -> list[Listed]:
    """Return all jobs of a folder's sweep, in its order; those that have no result yet are ``left``.

    Raises
    ------
    UpwashError
        If the folder holds no results.
    """
    folder.require()
    known, plan = read_index(folder), folder.plan()
    ids = plan.jobs if plan else list(known)
    rows = {row["job_id"]: row for row in inputs_in(folder, set(ids))}
    label = labels(list(rows.values()))
    listed = []
    for job_id in ids:
        one = known.get(job_id)
        name = label(rows[job_id]) if job_id in rows else ""
        listed.append(Listed(job_id, one.status if one else "left", name, one.cause if one else ""))
    return listed


def inputs_in(folder: ResultsFolder, job_ids: set[str]) -> Iterator[of.Stored]:
    """Give the inputs of those of some jobs that have a result, from its first row; of some more than once."""
    from upwash.batch.store import Damaged, brought_up, open_table
    from upwash.jobs.schema import schema_of

    asked = of.belonging(of.OUTCOME, of.PROBLEM, of.SEARCH, of.FLOCK)
    schema = folder.kind().rows
    names = [name for name in of.names(asked) if name in schema.names]
    asked_for = schema_of(column for column in asked if column.name in names)
    paths = [*(folder.job_file(job_id) for job_id in job_ids & folder.job_ids()), *table_files(folder)]
    for path in paths if job_ids else ():
        try:
            with open_table(path, schema) as file:
                table = file.read(columns=names, use_threads=False)
            rows = brought_up(table, asked_for).to_pylist()
        except (Damaged, FileNotFoundError):
            continue
        first = {row["job_id"]: row for row in reversed(rows) if row["job_id"] in job_ids}
        yield from map(of.told, first.values())


def labels(inputs: Collection[of.Stored]) -> Callable[[of.Stored], str]:
    """Return a function that names a job, given its inputs, by what varies among those of several."""
    apart = of.names(of.belonging(of.OUTCOME))
    names = [name for name in next(iter(inputs), ()) if name not in apart]
    return label_by({name for name in names if len({row[name] for row in inputs}) > 1})


def label_by(varied: Collection[str]) -> Callable[[of.Stored], str]:
    """Return a function that names a job, given its inputs, by those that vary."""
    return lambda row: " ".join(
        [
            *(row[name] for name in ALWAYS),
            *(f"{name}={_short(row[name])}" for name in row if name in varied and name not in ALWAYS),
        ]
    )


def _short(value: Any) -> str:
    return f"{value:.10g}" if isinstance(value, float) else str(value)
