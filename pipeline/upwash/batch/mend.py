"""Before anything is added to a results folder: verify what is there, name and set aside what is damaged.

A damaged job file costs its job; a damaged part of a gathered table costs the jobs in that part. They are
then done again like any job that has no result.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from upwash.batch.folder import ResultsFolder
from upwash.batch.index import Index, Known, gathered_files, known_of, read_singles
from upwash.batch.store import (
    ROWS,
    Damaged,
    TableWriter,
    metadata_of,
    noticing,
    open_table,
    remove_temporary,
    replacing,
)

Tell = Callable[[str], None]


def verified_index(folder: ResultsFolder, tell: Tell) -> Index:
    """Return what a results folder holds, after looking at every bit of it.

    Parameters
    ----------
    folder : ResultsFolder
        The folder, which the caller has locked.
    tell : callable
        Takes one line on each file that was set aside.

    Raises
    ------
    UpwashError
        If a file cannot be read, or another version of Upwash wrote it.
    """
    remove_temporary(folder.path)
    remove_temporary(folder.jobs)
    kind = folder.kind()
    index = Index()
    for path in gathered_files(folder):
        index.gathered |= _verified_table(folder, path, kind, tell)
    index.single = read_singles(folder, verify=True)
    for job_id in sorted(folder.job_ids() - index.single.keys()):
        path = folder.job_file(job_id)
        tell(f"{path}: damaged; set aside as {folder.set_aside(path)}, its job will be done again")
    return index


def _verified_table(folder: ResultsFolder, path: Path, kind: str, tell: Tell) -> dict[str, Known]:
    """Return how each job in the undamaged part of a gathered table ended; the rest is set aside."""
    known: dict[str, Known] = {}
    whole: list[int] = []
    try:
        with open_table(path, ROWS[kind]) as file:
            count = file.num_row_groups
            for number in range(count):
                try:
                    with noticing(path):
                        known |= known_of(file.read_row_group(number, use_threads=False))
                    whole.append(number)
                except Damaged:
                    continue
    except Damaged:
        tell(f"{path}: damaged; set aside as {folder.set_aside(path)}, its jobs will be done again")
        return {}
    if len(whole) < count:
        aside = folder.copy_aside(path)
        _keep_only(path, kind, whole)
        found = f"{count - len(whole)} of {count} parts damaged"
        tell(f"{path}: {found}; a copy is {aside}, the jobs of those parts will be done again")
    return known


def _keep_only(path: Path, kind: str, row_groups: list[int]) -> None:
    with open_table(path, ROWS[kind]) as file, replacing(path) as unfinished:
        writer = TableWriter(unfinished, ROWS[kind])
        for number in row_groups:
            writer.write(file.read_row_group(number, use_threads=False).replace_schema_metadata())
        writer.close(metadata_of(file.schema_arrow))
