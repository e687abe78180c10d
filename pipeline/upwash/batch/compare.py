"""Comparing two tables of results, column by column, each within its stated agreement."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.batch.folder import SUMMARY, ResultsFolder, jobs_in
from upwash.batch.store import Damaged, read_table
from upwash.errors import UpwashError
from upwash.jobs.kind import Kind
from upwash.jobs.schema import own_fields

# How a job is to be solved is no part of what is asked.
KEY = of.names(of.belonging(of.PROBLEM, of.FLOCK))
# Inputs are equal if they print the same to so many digits.
KEY_DIGITS = 12


@dataclass(frozen=True)
class Difference:
    """A column in which two tables do not agree.

    Parameters
    ----------
    column : str
        Its name.
    rows : int
        Rows in which they do not.
    job_id : str
        The job, by its id in the first table, in which they differ most.
    first, second : object
        The values there.
    allowed : str
        How much they may differ.
    """

    column: str
    rows: int
    job_id: str
    first: Any
    second: Any
    allowed: str


@dataclass(frozen=True)
class Comparison:
    """What came of comparing two tables.

    Parameters
    ----------
    rows : int
        Rows that both have.
    only_first, only_second : list of str
        Jobs that only one of them has.
    differences : list of Difference
        One for each column in which they do not agree.
    """

    rows: int
    only_first: list[str]
    only_second: list[str]
    differences: list[Difference]

    @property
    def agrees(self) -> bool:
        """Whether both have the same jobs, and the same results within the agreements."""
        return not (self.only_first or self.only_second or self.differences)


def compare_folders(first: ResultsFolder, second: ResultsFolder) -> list[Comparison]:
    """Compare two results folders by the jobs' physical inputs: their summaries and, of flocks, each bird.

    Raises
    ------
    UpwashError
        If one of them is not gathered, or they hold different kinds of sweep.
    """
    kind = first.kind()
    if second.kind() != kind:
        message = f"expected results of one kind, found {kind.name} and {second.kind().name}; compare like with like"
        raise UpwashError(f"{first}, {second}: {message}")
    # Which of one problem's dearer optima are met depends on the starts.
    files = [SUMMARY] if kind.is_one_problem else [SUMMARY, kind.file]
    return [compare(*(_read(folder, name, kind) for folder in (first, second))) for name in files]


def _read(folder: ResultsFolder, name: str, kind: type[Kind]) -> pa.Table:
    folder.require()
    path = folder.path / name
    if not path.exists():
        raise UpwashError(f"{folder}: expected {name}, found none; gather it by 'upwash aggregate {folder}'")
    if loose := len(folder.job_ids()) + sum(map(jobs_in, folder.part_files())):
        found = f"found {loose} not gathered yet; gather them by 'upwash aggregate {folder}'"
        raise UpwashError(f"{folder}: expected all finished jobs in {name}, {found}")
    try:
        return read_table(path, kind.summary if name == SUMMARY else kind.rows)
    except Damaged as error:
        raise UpwashError(f"{error}; gather it anew by 'upwash aggregate {folder}'") from error


def compare(first: pa.Table, second: pa.Table) -> Comparison:
    """Compare two tables of one schema row by row, rows being the same if their physical inputs are."""
    keys, other_keys = _keys(first), _keys(second)
    places, other_places = ({key: place for place, key in enumerate(own)} for own in (keys, other_keys))
    shared = [key for key in keys if key in other_places]
    left = first.take(pa.array([places[key] for key in shared], pa.int64()))
    right = second.take(pa.array([other_places[key] for key in shared], pa.int64()))
    compared = [column for column in of.COLUMNS if column.name in first.column_names]
    compared += [
        of.Column(field.name, "", "", of.FLOAT if field.type == pa.float64() else of.TEXT)
        for field in own_fields(first.schema)
        if field.name in second.column_names
    ]
    differences = [_difference(left, right, column) for column in compared]
    return Comparison(
        len(shared),
        _jobs(first, [place for key, place in places.items() if key not in other_places]),
        _jobs(second, [place for key, place in other_places.items() if key not in places]),
        [one for one in differences if one],
    )


def _jobs(table: pa.Table, rows: list[int]) -> list[str]:
    return table.column("job_id").take(pa.array(rows, pa.int64())).unique().to_pylist()


def _keys(table: pa.Table) -> list[tuple[Any, ...]]:
    """Return what makes each row the same as another's: its physical inputs and, of a flock, the bird.

    Rows that agree in all of that, as those of several seeds do, are told apart by their order.
    """
    names = [name for name in (*KEY, "bird") if name in table.column_names]
    values = {name: [_plain(value) for value in table.column(name).to_pylist()] for name in names}
    counts: dict[tuple[Any, ...], int] = {}
    keys = []
    for key in zip(*values.values(), strict=True):
        counts[key] = counts.get(key, 0) + 1
        keys.append((*key, counts[key]))
    return keys


def _plain(value: Any) -> Any:
    return f"{value:.{KEY_DIGITS}g}" if isinstance(value, float) else value


def _difference(left: pa.Table, right: pa.Table, column: of.Column) -> Difference | None:
    if not column.agreement.compared:
        return None
    a, b = left.column(column.name), right.column(column.name)
    off = excess(a.to_pylist(), b.to_pylist(), column)
    if not np.any(off > 0.0):
        return None
    worst = int(np.argmax(off))
    agreement = column.agreement
    return Difference(
        column.name,
        int(np.count_nonzero(off > 0.0)),
        left.column("job_id")[worst].as_py(),
        a[worst].as_py(),
        b[worst].as_py(),
        f"{agreement.relative:g} relative, {agreement.absolute:g} absolute",
    )


def excess(first: Sequence[Any], second: Sequence[Any], column: of.Column) -> NDArray[np.float64]:
    """Return by how much values disagree beyond what the column allows; 0 where they agree.

    A value and its absence, or two texts, disagree by infinity.
    """
    if column.type != of.FLOAT:
        return np.array([0.0 if a == b else np.inf for a, b in zip(first, second, strict=True)])
    a, b = (
        np.array([np.nan if value is None else value for value in values], float)
        for values in (first, second)
    )
    agreement = column.agreement
    with np.errstate(invalid="ignore"):
        off = np.abs(a - b) - agreement.absolute - agreement.relative * np.maximum(np.abs(a), np.abs(b))
    one_absent = np.isnan(a) != np.isnan(b)
    return np.where(one_absent, np.inf, np.nan_to_num(np.maximum(off, 0.0)))
