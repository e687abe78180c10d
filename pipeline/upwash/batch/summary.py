"""One row a job: what the rows of a job come to."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.batch.store import FLOCK_SUMMARY, SUMMARY, own_fields


def summary_of(rows: pa.Table, kind: str) -> pa.Table:
    """Return one row for each job.

    Parameters
    ----------
    rows : Table
        All rows of some jobs, sorted by job and by rank or bird.
    kind : str
        ``pair``: the V optimum's row, with nulls where a job has none; ``flock``: means over the birds.

    Returns
    -------
    Table
        In the order of the jobs.
    """
    if not rows.num_rows:
        return summary_schema(rows.schema, kind).empty_table()
    starts = np.flatnonzero(_changes(rows.column("job_id")))
    return _pairs(rows, starts) if kind == "pair" else _flocks(rows, starts)


def summary_schema(rows: pa.Schema, kind: str) -> pa.Schema:
    """Return the schema of the summary of rows: of pairs with the columns of a solver's own."""
    return pa.schema([*SUMMARY, *own_fields(rows)]) if kind == "pair" else FLOCK_SUMMARY


def _pairs(rows: pa.Table, starts: NDArray[np.intp]) -> pa.Table:
    is_v = rows.column("is_v_optimum").fill_null(False).to_numpy()
    cost = rows.column("cost").to_numpy()
    job = np.repeat(np.arange(starts.size), np.diff([*starts, rows.num_rows]))
    chosen = starts.copy()
    chosen[job[is_v]] = np.flatnonzero(is_v)
    has_v = is_v[chosen]
    summary = rows.take(chosen)
    # What is true of the job stands in the row of one that has no V optimum too.
    own = [field.name for field in own_fields(rows.schema)]
    for name in (*of.names(of.belonging(of.OPTIMUM)), *own):
        place = summary.schema.get_field_index(name)
        values = summary.column(place).combine_chunks()
        only_v = pa.compute.if_else(has_v, values, pa.scalar(None, values.type))
        summary = summary.set_column(place, summary.schema.field(place), only_v)
    # The best of a job comes first.
    gap = pa.array(cost[chosen] / cost[starts] - 1.0, mask=~has_v)
    found = np.add.reduceat(rows.column("rank").is_valid().to_numpy().astype(np.int64), starts)
    return _with(
        summary, summary_schema(rows.schema, "pair"), {"v_gap": gap, "optima_found": pa.array(found)}
    )


def _flocks(rows: pa.Table, starts: NDArray[np.intp]) -> pa.Table:
    status = np.array([of.STATUSES.index(one) for one in rows.column("status").to_pylist()])
    worst = [
        start + int(np.argmax(part)) for start, part in zip(starts, np.split(status, starts[1:]), strict=True)
    ]
    is_placed = status == of.STATUSES.index(of.SOLVED)
    placed = np.add.reduceat(is_placed.astype(np.int64), starts)

    def mean(name: str) -> pa.Array:
        values = np.where(is_placed, rows.column(name).to_numpy(), 0.0)
        return pa.array(np.add.reduceat(values, starts) / np.maximum(placed, 1), mask=placed == 0)

    summary = rows.take(starts)
    for name in ("status", "error"):
        place = summary.schema.get_field_index(name)
        summary = summary.set_column(
            place, summary.schema.field(place), rows.column(name).take(pa.array(worst))
        )
    means = {"cost_mean": mean("cost"), "saving_total_mean": mean("saving_total")}
    return _with(summary, FLOCK_SUMMARY, {"birds_placed": pa.array(placed), **means})


def _changes(column: pa.ChunkedArray) -> NDArray[np.bool_]:
    """Return where a sorted column begins a new value."""
    codes = column.combine_chunks().dictionary_encode().indices.to_numpy()
    return np.diff(codes, prepend=-1) != 0


def _with(table: pa.Table, schema: pa.Schema, more: dict[str, pa.Array]) -> pa.Table:
    """Return a table of a schema, with columns from two places."""
    columns = [more[name] if name in more else table.column(name) for name in schema.names]
    return pa.table(columns, schema=schema)
