"""Tables of observed birds as files: read and written piece by piece, so that one of any length fits into memory."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import chain
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.batch.store import TABLE_OPTIONS, provenance, replacing
from upwash.errors import UpwashError
from upwash.jobs.schema import schema_of
from upwash.shipped import shipped
from upwash.study.observed.pairs import one_ahead
from upwash.study.observed.published import is_published, published_places
from upwash.study.observed.table import Reading, named, read_rows
from upwash.study.told import EVALUATION

ROWS_AT_ONCE = 20_000
"""Rows of a piece."""

ROWS_TOGETHER = 200_000
"""So many rows of birds at all times are sorted out here; those of a longer table must come in the order of time."""

PARQUET = (".parquet", ".pq")
TEXT = (".csv", ".txt", ".tsv")

PUBLISHED = Path("species/observations.csv")
"""The published observations that come with Upwash."""


def read_pieces(path: Path) -> Iterator[pd.DataFrame]:
    """Read a table piece by piece; what stands in a CSV file stays text, so that names of birds stay what they are.

    Parameters
    ----------
    path : Path
        A file whose name ends in .csv, .txt or .tsv (separated by tabs), or .parquet.

    Raises
    ------
    UpwashError
        If it is no such file, cannot be read, or holds no row.
    """
    ending = path.suffix.lower()
    if ending not in (*PARQUET, *TEXT):
        raise UpwashError(
            f"{path}: expected a table in .csv or .parquet, found {ending or 'no ending'}; save it so"
        )
    is_empty = True
    with _noticing(path):
        pieces = _parquet(path) if ending in PARQUET else _text(path, "\t" if ending == ".tsv" else ",")
        for piece in pieces:
            is_empty &= piece.empty
            if not piece.empty:
                yield piece
    if is_empty:
        raise UpwashError(
            f"{path}: expected a row for each bird, found none; write one a line below the names"
        )


def _text(path: Path, separator: str) -> Iterator[pd.DataFrame]:
    with path.open(encoding="utf-8-sig", newline="") as file:
        names = [name.strip() for name in next(csv.reader(file, delimiter=separator), [])]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise UpwashError(
            f"{path}: expected each column once, found {', '.join(map(repr, twice))} twice; rename one"
        )
    with pd.read_csv(
        path,
        sep=separator,
        dtype=str,
        encoding="utf-8-sig",
        keep_default_na=False,
        na_values=[""],
        skipinitialspace=True,
        index_col=False,
        iterator=True,
    ) as reader:
        while True:
            try:
                piece = reader.get_chunk(ROWS_AT_ONCE)
            except StopIteration:
                return
            piece.columns = [str(name).strip() for name in piece.columns]
            yield piece


def _parquet(path: Path) -> Iterator[pd.DataFrame]:
    with pq.ParquetFile(path) as file:
        for batch in file.iter_batches(ROWS_AT_ONCE):
            yield batch.to_pandas()


@contextmanager
def _noticing(path: Path) -> Iterator[None]:
    """Turn whatever a reader says of a broken file into one line."""
    try:
        yield
    except UnicodeDecodeError as error:
        raise UpwashError(
            f"{path}: expected text in UTF-8, found other bytes; save it as CSV UTF-8"
        ) from error
    except pd.errors.EmptyDataError as error:
        raise UpwashError(f"{path}: expected a line with the columns' names, found an empty file") from error
    except (pd.errors.ParserError, csv.Error) as error:
        found = " ".join(str(error).split()).removeprefix("Error tokenizing data. C error: ")
        raise UpwashError(
            f"{path}: expected as many cells in each line as columns, found: {found}"
        ) from error
    except pa.ArrowException as error:
        found = " ".join(str(error).split())[:120]
        raise UpwashError(f"{path}: expected a Parquet file, found: {found}; save it again") from error


def read_flights(path: Path, reading: Reading) -> Iterator[pd.DataFrame]:
    """Read a table of all birds at each time, so that the rows of a time are in one piece.

    Parameters
    ----------
    path : Path
        As for `read_pieces`; with more than `ROWS_TOGETHER` rows the rows of a time must follow one another.
    reading : Reading
        What its columns are called.

    Raises
    ------
    UpwashError
        As by `read_pieces`, if it has no column of times, or if rows of one time lie apart in a long table.
    """
    pieces, few, count = read_pieces(path), [], 0
    for piece in pieces:
        few.append(piece)
        count += len(piece)
        if count > ROWS_TOGETHER:
            break
    first = pd.concat(few, ignore_index=True)
    if count <= ROWS_TOGETHER:
        yield first
        return
    name = named(first, reading, ("time",))["time"]
    seen: set[str] = set()
    rest = first.iloc[:0]
    for piece in chain([first], pieces):
        rows = pd.concat([rest, piece], ignore_index=True)
        times = rows[name].astype(str)
        # The last time of a piece may go on in the next one.
        goes_on = len(rows) - int(np.argmax((times != times.iloc[-1]).to_numpy()[::-1]))
        if (times == times.iloc[-1]).all():
            rest = rows
            continue
        _note_times(path, seen, times.iloc[:goes_on])
        rest = rows.iloc[goes_on:]
        yield rows.iloc[:goes_on]
    _note_times(path, seen, rest[name].astype(str))
    yield rest


def _note_times(path: Path, seen: set[str], times: pd.Series) -> None:
    """Note which times were met, none of which may come again."""
    new = set(times)
    if again := seen & new:
        raise UpwashError(
            f"{path}: expected the rows of a time together, as there are more than {ROWS_TOGETHER:,} in all, found "
            f"time {min(again)} again after others; sort the table by time"
        )
    seen |= new


def read_birds(path: Path, species: str, bird: Bird) -> Iterator[pd.DataFrame]:
    """Read a table with a row for each bird; published observations become the places that they tell.

    Parameters
    ----------
    path : Path
        As for `read_pieces`; ``species/observations.csv`` is found wherever Upwash is installed.
    species : str
        Name of the species, whose observations are read of published ones.
    bird : Bird
        Its bird.

    Raises
    ------
    UpwashError
        As by `read_pieces`, or if nothing is published of the species.
    """
    if path == PUBLISHED and not path.exists():
        path = shipped(PUBLISHED.as_posix())
    pieces = read_pieces(path)
    first = next(pieces)
    if is_published(first):
        yield published_places(species, bird, pd.concat([first, *pieces]))
    else:
        yield first
        yield from pieces


def read_places(path: Path, species: str, bird: Bird) -> NDArray[np.float64]:
    """Read where birds fly, as dots of a map: of a table with a row for each bird, or of one that was evaluated.

    Parameters
    ----------
    path, species, bird
        As for `read_birds`.

    Returns
    -------
    (n, 4) ndarray of float
        x, y, z in m and the phase of each bird whose row can be used; NaN for what is not known.

    Raises
    ------
    UpwashError
        If it is no such table, or no row can be used.
    """
    found = []
    for piece in read_birds(path, species, bird):
        rows = read_rows(piece, Reading(), bird.semispan_m)
        places = one_ahead(rows).places
        found.append(places[rows.faults == ""])
    places = np.concatenate(found)
    if not len(places):
        raise UpwashError(
            f"{path}: expected x_m and y_m of birds behind their leaders, found no row with both"
        )
    return places


class EvaluationWriter:
    """Writes what was evaluated as Parquet, piece by piece, with the unit and meaning of each column of ours.

    Parameters
    ----------
    path : Path
        The file, under a temporary name.
    said : dict of str to str
        What the file's metadata say beside the versions.
    """

    def __init__(self, path: Path, said: dict[str, str]) -> None:
        self.path, self.said = path, said
        self.writer: pq.ParquetWriter | None = None

    def write(self, piece: pd.DataFrame) -> None:
        """Write a piece; the types of the table's own columns are those of the first."""
        ours = schema_of(EVALUATION)
        if self.writer is None:
            others = pa.Schema.from_pandas(
                piece.drop(columns=list(ours.names), errors="ignore"), preserve_index=False
            )
            fields = [
                ours.field(name) if name in ours.names else others.field(name) for name in piece.columns
            ]
            # A column in which nothing stands yet may hold anything later.
            fields = [one.with_type(pa.string()) if pa.types.is_null(one.type) else one for one in fields]
            self.schema = pa.schema(fields, metadata=provenance("") | self.said)
            self.writer = pq.ParquetWriter(
                self.path, self.schema, **TABLE_OPTIONS | {"write_statistics": True}
            )
        self.writer.write_table(pa.Table.from_pandas(piece, schema=self.schema, preserve_index=False))

    def close(self) -> None:
        """Finish the file."""
        if self.writer is not None:
            self.writer.close()


@contextmanager
def evaluation_file(path: Path, said: dict[str, str]) -> Iterator[EvaluationWriter]:
    """Give a writer whose file is in place when all was written, whole or not at all."""
    if path.suffix.lower() not in PARQUET:
        raise UpwashError(
            f"--output: expected a name that ends in .parquet, found {str(path)!r}; for text write --csv"
        )
    with replacing(path) as unfinished:
        writer = EvaluationWriter(unfinished, said)
        try:
            yield writer
        finally:
            writer.close()
