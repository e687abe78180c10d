"""Before anything is added to a results folder: verify what is there, name and set aside what is damaged.

A damaged job file costs its job; a damaged part of a gathered table costs the jobs in that part. They are
then done again like any job that has no result.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from upwash.batch.folder import ResultsFolder
from upwash.batch.index import Known, known_of, note, table_files
from upwash.batch.store import (
    Damaged,
    TableWriter,
    brought_up,
    metadata_of,
    noticing,
    open_table,
    read_table,
    remove_temporary,
    replacing,
)
from upwash.jobs.kind import Kind

Tell = Callable[[str], None]


def verified_index(folder: ResultsFolder, tell: Tell) -> dict[str, Known]:
    """Return how each job that has a result ended, after reading all of every file.

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
    for place in (folder.path, folder.jobs, folder.parts):
        remove_temporary(place)
    kind = folder.kind()
    index: dict[str, Known] = {}
    for job_id in sorted(folder.job_ids()):
        path = folder.job_file(job_id)
        try:
            note(index, {job_id: known_of(read_table(path, kind.rows))[job_id]})
        except (Damaged, KeyError):
            tell(f"{path}: damaged; set aside as {folder.set_aside(path)}, its job will be done again")
    for path in table_files(folder):
        note(index, _verified_table(folder, path, kind, tell))
    return index


def _verified_table(folder: ResultsFolder, path: Path, kind: type[Kind], tell: Tell) -> dict[str, Known]:
    """Return how each job in the undamaged part of a gathered table ended; the rest is set aside."""
    known: dict[str, Known] = {}
    whole: list[int] = []
    try:
        with open_table(path, kind.rows) as file:
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


def _keep_only(path: Path, kind: type[Kind], row_groups: list[int]) -> None:
    with open_table(path, kind.rows) as file, replacing(path) as unfinished:
        writer = TableWriter(unfinished, kind.rows)
        for number in row_groups:
            rows = brought_up(file.read_row_group(number, use_threads=False), kind.rows)
            writer.write(rows.replace_schema_metadata())
        writer.close(metadata_of(file.schema_arrow))
