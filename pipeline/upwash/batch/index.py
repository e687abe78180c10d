"""What a results folder holds, job by job, from the few files that say so: fast enough to ask at any time."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from upwash import columns as of
from upwash.batch.folder import RETIRED, ResultsFolder

if TYPE_CHECKING:
    import pyarrow as pa

    from upwash.jobs.kind import Kind


class Known(NamedTuple):
    """How a job ended, and what kind of thing went wrong, or ""."""

    status: str
    cause: str


def read_index(folder: ResultsFolder, verify: bool = False) -> dict[str, Known]:
    """Return how each job that has a result ended; files found damaged are passed over.

    While a run goes on, files vanish into others; those are looked at later, so that no job is missed.

    Parameters
    ----------
    folder : ResultsFolder
        The folder.
    verify : bool
        Whether to read all of the jobs' own files, and not just what is asked for.
    """
    index: dict[str, Known] = {}
    kind = folder.kind()
    for job_id in folder.job_ids():
        note(index, known_in(folder.job_file(job_id), kind, verify))
    done = set[Path]()
    while paths := [path for path in table_files(folder) if path not in done]:
        for path in paths:
            note(index, known_in(path, kind))
            done.add(path)
    return index


def note(index: dict[str, Known], more: dict[str, Known]) -> None:
    """Add what another file says: of a job in both, what is no failure counts, and else the first."""
    for job_id, known in more.items():
        if job_id not in index or index[job_id].status == of.FAILED:
            index[job_id] = known


def table_files(folder: ResultsFolder) -> list[Path]:
    """Return the tables of rows of several jobs, newest first."""
    gathered = (folder.gathered(), folder.path / RETIRED)
    return [*reversed(folder.part_files()), *(path for path in gathered if path.exists())]


def known_of(table: pa.Table) -> dict[str, Known]:
    """Return how each job in a table ended: by the worst of its rows."""
    import pyarrow.compute as pc

    known = dict.fromkeys(table.column("job_id").unique().to_pylist(), Known(of.SOLVED, ""))
    others = table.filter(pc.not_equal(table.column("status"), of.SOLVED))
    rows = (others.column(name).to_pylist() for name in ("job_id", "status", "error"))
    for job_id, status, error in zip(*rows, strict=True):
        if of.STATUSES.index(status) > of.STATUSES.index(known[job_id].status):
            known[job_id] = Known(status, of.cause_of(error))
    return known


def known_in(path: Path, kind: type[Kind], verify: bool = False) -> dict[str, Known]:
    """Return how each job in a file ended; nothing if it is damaged, or gone since it was listed."""
    from upwash.batch.store import Damaged, noticing, open_table

    try:
        with noticing(path), open_table(path, kind.rows) as file:
            columns = None if verify else ["job_id", "status", "error"]
            return known_of(file.read(columns=columns, use_threads=False))
    except (Damaged, FileNotFoundError):
        return {}
