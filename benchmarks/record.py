"""What comes out of a contest: a table to read, and a Parquet file to keep."""

from __future__ import annotations

import json
from datetime import UTC, datetime
from pathlib import Path

import pyarrow as pa
from upwash.batch.store import code_version, encode, write_atomic
from upwash.columns import INTEGER, TEXT, Column
from upwash.jobs.schema import schema_of

from benchmarks import machine

SCHEMA = schema_of(
    [
        Column("contest", "", "what was measured", TEXT),
        Column("contender", "", "who did the work; the first of a contest is Upwash", TEXT),
        Column("per", "", "unit of work", TEXT),
        Column("time_best_s", "s", "shortest time for a unit of work, on one core"),
        Column("time_median_s", "s", "median time for a unit of work, on one core"),
        Column("ratio", "1", "shortest time over Upwash's"),
        Column("samples", "1", "number of times it was measured", INTEGER),
        Column("difference", "1", "largest difference from Upwash's answer over the largest value"),
        Column("remark", "", "what else is to be said of how it did; empty if nothing", TEXT),
        Column("missing", "", "why it was not measured; empty if it was", TEXT),
        Column("processor", "", "model of the processor", TEXT),
        Column("cores", "1", "number of the processor's cores", INTEGER),
        Column("system", "", "operating system", TEXT),
    ]
)

UNITS = (("ns", 1e-9), ("µs", 1e-6), ("ms", 1e-3), ("s", 1.0))


def store(rows: list[dict], folder: Path, schema: pa.Schema = SCHEMA) -> Path:
    """Write a contest's rows, with the machine and the versions, and return the file."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{rows[0]['contest']}.parquet"
    metadata = {
        "code_version": code_version(),
        "package_versions": json.dumps(machine.versions()),
        "measured": datetime.now(UTC).isoformat(timespec="seconds"),
    }
    write_atomic(path, encode([row | machine.description() for row in rows], schema, metadata))
    return path


def table(rows: list[dict]) -> str:
    """Return a contest's rows as a table to read."""
    lines = [
        f"{rows[0]['contest']}: time per {rows[0]['per']}, one core",
        f"  {'':44} {'best':>9} {'median':>9} {'ratio':>9}  differs by",
    ]
    for row in rows:
        if row["missing"]:
            lines.append(f"  {row['contender']:44} missing: {row['missing']}")
            continue
        apart = "" if row["difference"] is None else f"{row['difference']:.0e}"
        best, typical = in_words(row["time_best_s"]), in_words(row["time_median_s"])
        line = (
            f"  {row['contender']:44} {best:>9} {typical:>9} {row['ratio']:9.2f}  {apart:10}  {row['remark']}"
        )
        lines.append(line.rstrip())
    return "\n".join(lines)


def in_words(seconds: float) -> str:
    """Return a time with three digits, in the unit that suits it."""
    unit, scale = next((unit, scale) for unit, scale in reversed(UNITS) if seconds >= scale or unit == "ns")
    return f"{seconds / scale:.3g} {unit}"
