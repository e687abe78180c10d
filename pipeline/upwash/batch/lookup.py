"""Finding one job in a results folder by its id, or the beginning of it."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from upwash import columns as of
from upwash.batch.folder import SUMMARY, ResultsFolder
from upwash.batch.index import table_files
from upwash.batch.merging import one_result_a_job
from upwash.batch.store import brought_up, noticing, open_table
from upwash.errors import UpwashError

SHOWN = 5


def rows_of(folder: ResultsFolder, beginning: str) -> list[of.Stored]:
    """Return the rows of a job, best first.

    Parameters
    ----------
    folder : ResultsFolder
        The folder.
    beginning : str
        The job's id, or as much of its beginning as no other job shares.

    Raises
    ------
    UpwashError
        If there is no such job, or more than one, or its file is damaged.
    """
    folder.require()
    places: dict[str, list[Path]] = {}
    for job_id in sorted(folder.job_ids()):
        places[job_id] = [folder.job_file(job_id)]
    # A folder that holds a summary alone has that.
    for path in table_files(folder) or [path for path in [folder.path / SUMMARY] if path.exists()]:
        for job_id in _ids_in(path):
            places.setdefault(job_id, []).append(path)
    ids = [job_id for job_id in places if job_id.startswith(beginning)]
    if len(ids) != 1 or not beginning:
        found = ", ".join(sorted(ids)[:SHOWN]) + (", ..." if len(ids) > SHOWN else "") if ids else "none"
        remedy = "give more of its id" if ids else f"'upwash status {folder} --jobs' lists them"
        raise UpwashError(
            f"{folder}: expected one job whose id begins with {beginning!r}, found {found}; {remedy}"
        )
    kind = folder.kind()
    tables = [
        _read(path, kind.summary if path.name == SUMMARY else kind.rows, ids[0]) for path in places[ids[0]]
    ]
    return one_result_a_job(tables).to_pylist()


def _read(path: Path, schema: pa.Schema, job_id: str) -> pa.Table:
    with noticing(path), open_table(path, schema):
        found = pq.read_table(
            path, filters=[("job_id", "=", job_id)], page_checksum_verification=True, use_threads=False
        )
        return brought_up(found, schema)


def _ids_in(path: Path) -> list[str]:
    try:
        return pq.read_table(path, columns=["job_id"]).column("job_id").unique().to_pylist()
    except (OSError, ValueError):
        return []
