"""Parquet files to be trusted: explicit schemas, provenance, atomic writes, reads that notice damage."""

from __future__ import annotations

import base64
import json
import os
import subprocess
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from importlib.metadata import version
from pathlib import Path
from secrets import token_hex
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from upwash import __version__
from upwash import columns as of
from upwash.errors import UpwashError
from upwash.jobs.schema import table_of, without_own
from upwash.shipped import checkout

PACKAGES = ("joblib", "numba", "numpy", "pyarrow", "scipy")

# A job has few rows: neither dictionaries nor compression pay in its own file.
JOB_FILE_OPTIONS = {"use_dictionary": False, "compression": "none", "write_statistics": False}
TABLE_OPTIONS = {"compression": "zstd", "write_statistics": ["job_id"]}


class Damaged(Exception):
    """A file that is not what was written: torn, or with bits changed."""


def conformed(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """Return a table with a schema's columns; those of a solver's own that it lacks are null.

    Raises
    ------
    UpwashError
        If it has such a column that the schema lacks.
    """
    if table.schema.equals(schema):
        return table
    extra = sorted(set(table.column_names) - set(schema.names))
    if extra:
        found = f"found {', '.join(extra)} in a file"
        raise UpwashError(
            f"expected columns that plan.json names, {found}; run the sweep again, by its solver"
        )
    columns = [
        table.column(field.name) if field.name in table.column_names else pa.nulls(table.num_rows, field.type)
        for field in schema
    ]
    return pa.table(columns, schema=schema)


def brought_up(table: pa.Table, schema: pa.Schema) -> pa.Table:
    """Return a table with the columns of a schema that came after it was written: what it stood for, or null."""
    later = [field for field in schema if field.name not in table.column_names and _is_later(field.name)]
    if not later:
        return table
    names = [*schema.names, *(name for name in table.column_names if name not in schema.names)]
    table = pa.table(
        {
            **{name: table.column(name) for name in table.column_names},
            **{
                field.name: pa.repeat(pa.scalar(of.column(field.name).before, field.type), table.num_rows)
                for field in later
            },
        },
        schema=pa.schema([*table.schema, *later], metadata=table.schema.metadata),
    )
    return table.select([name for name in names if name in table.column_names])


def _forms(schema: pa.Schema) -> list[tuple[str, pa.DataType, bytes | None]]:
    """Return name, type and unit of each column."""
    return [(field.name, field.type, (field.metadata or {}).get(b"unit")) for field in schema]


def _is_later(name: str) -> bool:
    return any(column.since > of.OLDEST_READ for column in of.COLUMNS if column.name == name)


@cache
def code_version() -> str:
    """Return Upwash's version and, in a checkout, the commit and whether files differ from it."""
    folder = checkout()
    if folder is None:
        # A wheel may lie within a repository that is another's.
        return __version__
    try:
        command = ["git", "-C", str(folder), "describe", "--always", "--dirty", "--exclude=*"]
        described = subprocess.run(command, capture_output=True, text=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return __version__
    commit = described.stdout.strip()
    return f"{__version__}+{commit}" if described.returncode == 0 and commit else __version__


@cache
def package_versions() -> dict[str, str]:
    """Return the versions of the packages that results may depend on."""
    return {name: version(name) for name in PACKAGES}


def provenance(sweep_text: str) -> dict[str, str]:
    """Return a file's metadata: versions of schema, code and packages, and the sweep's own text."""
    return {
        "schema_version": str(of.SCHEMA_VERSION),
        "code_version": code_version(),
        "package_versions": json.dumps(package_versions()),
        "sweep": sweep_text,
    }


def merged_provenance(all_metadata: Iterable[dict[str, str]], sweep_text: str) -> dict[str, str]:
    """Return the metadata of a file that gathers others: each version that took part, once."""
    seen = [dict(pairs) for pairs in {tuple(sorted(metadata.items())) for metadata in all_metadata}]
    codes = sorted({metadata["code_version"] for metadata in seen})
    packages = [json.loads(metadata["package_versions"]) for metadata in seen]
    names = sorted({name for versions in packages for name in versions})
    return {
        "schema_version": str(of.SCHEMA_VERSION),
        "code_version": ", ".join(codes),
        "package_versions": json.dumps(
            {name: ", ".join(sorted({one[name] for one in packages if name in one})) for name in names}
        ),
        "sweep": sweep_text,
    }


def metadata_of(schema: pa.Schema) -> dict[str, str]:
    """Return a file's own metadata as text."""
    return {key.decode(): value.decode() for key, value in (schema.metadata or {}).items()}


def encode(
    rows: Sequence[of.Row],
    schema: pa.Schema,
    metadata: dict[str, str],
    options: Mapping[str, Any] = JOB_FILE_OPTIONS,
) -> bytes:
    """Return the bytes of a Parquet file of a few rows, or with other options of more."""
    table = table_of(rows, schema).replace_schema_metadata(metadata)
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink, write_page_checksum=True, **options)
    return sink.getvalue().to_pybytes()


def temporary(path: Path) -> Path:
    """Return a name under which a file is written until it is whole; no other writer's, if shards run."""
    return path.with_name(f".{path.name}.{token_hex(4)}.tmp")


def remove_temporary(folder: Path) -> None:
    """Remove what interrupted writes left in a folder, if there is one."""
    for path in folder.glob(".*.tmp"):
        path.unlink()


def write_atomic(path: Path, data: bytes, flush: bool = True) -> None:
    """Write a file so that it is there whole or not at all.

    Parameters
    ----------
    path : Path
        The file.
    data : bytes
        Its content.
    flush : bool
        Whether to wait until the disk has it, so that this holds even if the power fails.

    Raises
    ------
    UpwashError
        If it cannot be written; nothing is left behind.
    """
    with replacing(path) as unfinished:
        descriptor = os.open(unfinished, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        try:
            # A write to a disk that is nearly full may be short.
            while data:
                data = data[os.write(descriptor, data) :]
            if flush:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)


def sync(path: Path) -> None:
    """Put a file, or a folder's list of files, on the disk, so that it outlives a power cut."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Give a temporary name to write to, and put the file in its place if nothing went wrong.

    Raises
    ------
    UpwashError
        If the folder cannot be written or the disk is full; nothing is left behind.
    """
    unfinished = temporary(path)
    try:
        yield unfinished
        os.replace(unfinished, path)
    except BaseException as error:
        unfinished.unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise cannot_write(path, error) from error
        raise


def cannot_write(path: Path, error: OSError) -> UpwashError:
    """Build the one line that says why a file cannot be written."""
    found = error.strerror or str(error)
    return UpwashError(
        f"{path}: expected to write it, found: {found}; what was finished is kept: make room or fix the "
        "permissions, then run the same command again"
    )


def _coding(schema: pa.Schema) -> dict[str, list[str]]:
    """Return how columns are coded: what differs from row to row byte by byte, a fifth less, the rest by dictionary."""
    own = set(of.names(of.belonging(of.OPTIMUM)))
    split = [field.name for field in schema if field.name in own and pa.types.is_floating(field.type)]
    return {
        "use_byte_stream_split": split,
        "use_dictionary": [name for name in schema.names if name not in split],
    }


class TableWriter:
    """Writes a table piece by piece to a temporary name; `replacing` puts it in place."""

    def __init__(self, path: Path, schema: pa.Schema) -> None:
        self.path = path
        self.schema = schema
        # The metadata is known when all is read: `close` stores the schema, as Arrow would have done here.
        self.writer = pq.ParquetWriter(
            path, schema, write_page_checksum=True, store_schema=False, **TABLE_OPTIONS | _coding(schema)
        )

    def write(self, table: pa.Table) -> None:
        """Write a table as one row group."""
        if table.num_rows:
            self.writer.write_table(table, row_group_size=table.num_rows)

    def close(self, metadata: dict[str, str]) -> None:
        """Finish the file and put it on the disk."""
        schema = base64.b64encode(self.schema.with_metadata(metadata).serialize().to_pybytes())
        self.writer.add_key_value_metadata({**metadata, "ARROW:schema": schema.decode()})
        self.writer.close()
        sync(self.path)


@contextmanager
def noticing(path: Path) -> Iterator[None]:
    """Turn whatever a Parquet reader says of a broken file into `Damaged`; that there is none stays as it is."""
    try:
        yield
    except (pa.ArrowException, ValueError, KeyError, OverflowError, MemoryError, EOFError) as error:
        raise Damaged(f"{path}: {' '.join(str(error).split())[:200]}") from error
    except FileNotFoundError:
        raise
    except OSError as error:
        if error.errno is not None:
            raise UpwashError(f"{path}: expected to read it, found: {error.strerror}; fix that") from error
        raise Damaged(f"{path}: {' '.join(str(error).split())[:200]}") from error


def open_table(path: Path, schema: pa.Schema, data: bytes | None = None) -> pq.ParquetFile:
    """Open a Parquet file of one of our schemas, and maybe a solver's own columns.

    A file of an older version may lack columns that came since: `brought_up` adds them to what is read of it.
    Reading from it verifies the checksum of every page.

    Parameters
    ----------
    path : Path
        The file.
    schema : Schema
        What it must hold.
    data : bytes, optional
        Its content, if that has been read already.

    Raises
    ------
    Damaged
        If it is no such file.
    UpwashError
        If another version of Upwash wrote it.
    """
    with noticing(path):
        source = pa.BufferReader(data) if data is not None else str(path)
        file = pq.ParquetFile(source, page_checksum_verification=True)
        found = file.schema_arrow
        written_by = metadata_of(found).get("schema_version")
        is_ours, is_older = written_by == str(of.SCHEMA_VERSION), written_by in OLDER
        expected = without_own(schema)
        if is_older:
            expected = pa.schema(
                [field for field in expected if field.name in found.names or not _is_later(field.name)]
            )
        # What a column means may have been put into other words since.
        if (is_ours and without_own(found).equals(expected, check_metadata=True)) or (
            is_older and _forms(without_own(found)) == _forms(expected)
        ):
            if not _lies_close(file.metadata):
                raise ValueError("expected columns one after the other, found one elsewhere")
            return file
    if not is_ours and not is_older:
        remedy = "take another results folder, or the version of Upwash that wrote it"
        raise UpwashError(
            f"{path}: expected schema version {of.SCHEMA_VERSION}, found {written_by or 'none'}; {remedy}"
        )
    raise Damaged(f"{path}: its columns are not those of schema version {written_by}")


def _lies_close(file: pq.FileMetaData) -> bool:
    """Whether each column follows the one before, as they are written: the footer that says so bears no checksum."""
    place = len(b"PAR1")
    for group in range(file.num_row_groups):
        columns = file.row_group(group)
        for number in range(columns.num_columns):
            column = columns.column(number)
            first = column.dictionary_page_offset if column.has_dictionary_page else column.data_page_offset
            if first != place:
                return False
            place += column.total_compressed_size
    return True


OLDER = tuple(str(version) for version in range(of.OLDEST_READ, of.SCHEMA_VERSION))
"""Versions of the schema that are read, and brought up to this one."""


def read_table(path: Path, schema: pa.Schema, data: bytes | None = None) -> pa.Table:
    """Read a whole table of one of our schemas; raises as `open_table` does."""
    with noticing(path), open_table(path, schema, data) as file:
        return brought_up(file.read(use_threads=False), schema)
