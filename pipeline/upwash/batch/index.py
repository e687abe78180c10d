"""What a results folder holds, job by job, from the few files that say so: fast enough to ask at any time."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from upwash import columns as of
from upwash.batch.folder import GATHERED, RETIRED, Journals, ResultsFolder

if TYPE_CHECKING:
    import pyarrow as pa


class Known(NamedTuple):
    """How a job ended, and what kind of thing went wrong, or ""."""

    status: str
    cause: str


@dataclass
class Index:
    """What is known of a results folder.

    Parameters
    ----------
    gathered : dict of str to Known
        Jobs whose rows are in a gathered table.
    single : dict of str to Known
        Jobs that have a file of their own, which counts if there are both.
    """

    gathered: dict[str, Known] = field(default_factory=dict)
    single: dict[str, Known] = field(default_factory=dict)

    @property
    def jobs(self) -> dict[str, Known]:
        """Every job that has a result."""
        return self.gathered | self.single


def read_index(folder: ResultsFolder, journals: Journals | None = None) -> Index:
    """Return what a results folder holds, trusting the journals; files found damaged are passed over."""
    index = Index(single=read_singles(folder, journals=journals))
    for path in gathered_files(folder):
        index.gathered |= known_in(path, folder.kind())
    return index


def read_singles(
    folder: ResultsFolder, verify: bool = False, journals: Journals | None = None
) -> dict[str, Known]:
    """Return what is known of the jobs that have a file of their own.

    Parameters
    ----------
    folder : ResultsFolder
        The folder.
    verify : bool
        Whether to compare each file with the checksum in the journal. Those that no journal tells of, since
        they came from elsewhere, are read in any case. What is damaged is left out.
    journals : Journals, optional
        What the journals say, if they have been read already.
    """
    written = (journals or folder.read_journals()).lines
    singles = {}
    for job_id in folder.job_ids():
        lines = written.get(job_id)
        if not lines:
            known = read_known(folder, job_id)
        elif verify:
            entry = folder.entry_of_file(job_id, lines)
            known = Known(entry.status, entry.cause) if entry else None
        else:
            status, *_, cause = lines[-1].split(",")
            known = Known(status, cause)
        if known:
            singles[job_id] = known
    return singles


def gathered_files(folder: ResultsFolder) -> list[Path]:
    """Return the tables of gathered rows; where two hold a job, the later one counts."""
    paths = [folder.path / RETIRED, folder.path / GATHERED[folder.kind()]]
    return [path for path in paths if path.exists()]


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


def known_in(path: Path, kind: str) -> dict[str, Known]:
    """Return how each job in a gathered table ended; nothing if the table is damaged."""
    from upwash.batch.store import ROWS, Damaged, noticing, open_table

    try:
        with noticing(path), open_table(path, ROWS[kind]) as file:
            return known_of(file.read(columns=["job_id", "status", "error"], use_threads=False))
    except Damaged:
        return {}


def read_known(folder: ResultsFolder, job_id: str) -> Known | None:
    """Return how a job ended, from its own file; None if that is damaged."""
    from upwash.batch.store import ROWS, Damaged, read_table

    path = folder.job_file(job_id)
    try:
        return known_of(read_table(path, ROWS[folder.kind()])).get(job_id)
    except Damaged:
        return None
