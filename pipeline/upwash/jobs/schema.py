"""Arrow schemas of columns, and tables of rows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import pyarrow as pa

from upwash import columns as of

ARROW_TYPES = {of.FLOAT: pa.float64(), of.INTEGER: pa.int64(), of.TEXT: pa.string(), of.TRUTH: pa.bool_()}

OWN = b"declared_by"
"""In the metadata of a column that the sweep's own solver declares."""


def schema_of(columns: Iterable[of.Column]) -> pa.Schema:
    """Return the Arrow schema of some columns, with unit and description in each field's metadata."""
    return pa.schema(
        pa.field(
            column.name,
            ARROW_TYPES[column.type],
            metadata={"unit": column.unit, "description": column.description},
        )
        for column in columns
    )


def with_own(schema: pa.Schema, own: Iterable[of.Column]) -> pa.Schema:
    """Return a schema with the columns of a solver's own at the end."""
    marked = (field.with_metadata(field.metadata | {OWN: b"solver"}) for field in schema_of(own))
    return pa.schema([*schema, *marked])


def own_fields(schema: pa.Schema) -> list[pa.Field]:
    """Return the columns of a solver's own."""
    return [field for field in schema if OWN in (field.metadata or {})]


def without_own(schema: pa.Schema) -> pa.Schema:
    """Return a schema without the columns of a solver's own."""
    return pa.schema([field for field in schema if OWN not in (field.metadata or {})])


def table_of(rows: Sequence[Mapping[str, of.Cell]], schema: pa.Schema) -> pa.Table:
    """Make a table from rows; a column that a row lacks is null there.

    Raises
    ------
    ValueError
        If a row has a column that the schema does not know, or a value of the wrong type.
    """
    unknown = sorted({name for row in rows for name in row} - set(schema.names))
    if unknown:
        raise ValueError(f"rows: expected columns of the schema, found {', '.join(unknown)}; add them to it")
    # A list of dicts becomes a struct in one call, which is twice as fast as column by column.
    structs = pa.array(rows, type=pa.struct(list(schema)))
    return pa.Table.from_batches([pa.RecordBatch.from_struct_array(structs)])


def of_two(schema: pa.Schema, table: pa.Table, more: Mapping[str, pa.Array]) -> pa.Table:
    """Return a table of a schema whose columns are some new ones, and else those of another table."""
    columns = [more[name] if name in more else table.column(name) for name in schema.names]
    return pa.table(columns, schema=schema)
