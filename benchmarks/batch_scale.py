"""What the batch layer itself costs: sweeps of very many jobs that compute nothing, run by the command as users do.

Sweeps of three sizes tell whether time grows in proportion, and whether memory stays bounded.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from upwash.columns import INTEGER, TEXT, Column
from upwash.jobs.schema import schema_of

from benchmarks.record import in_words

SHARES = (0.1, 0.3, 1.0)
"""Sizes of the sweeps, over that of the largest."""

WORKERS = 2
SWEEP = """\
solver = "benchmarks.batch_scale:nothing"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.0, 1.5, {jobs}] }}
"""
STEPS = {
    "run": ("run", "./sweep.toml", "--workers", str(WORKERS)),
    "status": ("status", "results/sweep"),
    "aggregate": ("aggregate", "results/sweep"),
    "status, gathered": ("status", "results/sweep"),
    "run, all done": ("run", "./sweep.toml"),
}

# A process of its own, for a process starts with the peak memory of the one that it was forked from.
METER = """\
import json, resource, subprocess, sys, time
begun = time.perf_counter()
command = [sys.executable, "-c", "from upwash.cli import main; main()", *sys.argv[1:]]
told = subprocess.run(command, stdout=subprocess.DEVNULL)
time_s, used = time.perf_counter() - begun, resource.getrusage(resource.RUSAGE_CHILDREN)
processor_s, memory_mb = used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0
print(json.dumps({"time_s": time_s, "processor_s": processor_s, "memory_mb": memory_mb}))
sys.exit(told.returncode)
"""

SCHEMA = schema_of(
    [
        Column("contest", "", "what was measured", TEXT),
        Column("jobs", "1", "jobs of the sweep, which compute nothing", INTEGER),
        Column("step", "", "command that was run", TEXT),
        Column("time_s", "s", "wall time"),
        Column("processor_s", "s", "processor time, that of the workers included"),
        Column("memory_mb", "MB", "peak memory of the largest process"),
        Column("files", "1", "files in the results folder after the step", INTEGER),
        Column("folder_mb", "MB", "size of the results folder after the step"),
        Column("load", "1", "processes that wanted a core in the minute before, this study's included"),
        Column("processor", "", "model of the processor", TEXT),
        Column("cores", "1", "number of the processor's cores", INTEGER),
        Column("system", "", "operating system", TEXT),
    ]
)


def nothing(job: Any) -> tuple[str, str, list[dict]]:
    """Solve a job at no cost."""
    v_formation = {"is_v_optimum": True, "is_global_optimum": True, "solve_time_s": 0.0}
    return "solved", "", [{"rank": 0, "cost": job.mass_kg} | v_formation]


def study(largest: int) -> list[dict[str, Any]]:
    """Run sweeps of up to so many jobs, look at them, gather them; return what each step took."""
    return [row for share in SHARES for row in steps(max(1, round(share * largest)))]


def steps(jobs: int) -> Iterator[dict[str, Any]]:
    """Take one sweep through every step, in a folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "sweep.toml").write_text(SWEEP.format(jobs=jobs), encoding="utf-8")
        for step, arguments in STEPS.items():
            about = {"contest": "batch_scale", "jobs": jobs, "step": step}
            taken = measured(folder, *arguments)
            sizes = [path.stat().st_size for path in (folder / "results").rglob("*") if path.is_file()]
            yield about | taken | {"files": len(sizes), "folder_mb": sum(sizes) / 1e6}


def measured(folder: Path, *arguments: str) -> dict[str, float]:
    """Run the command; return its wall and processor time, its workers' included, and its peak memory."""
    told = subprocess.run(
        [sys.executable, "-c", METER, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])},
        capture_output=True,
        text=True,
    )
    if told.returncode:
        raise SystemExit(f"upwash {' '.join(arguments)}: {told.stderr.strip()}")
    return json.loads(told.stdout) | {"load": os.getloadavg()[0]}


def report(rows: Sequence[dict[str, Any]]) -> str:
    """Return the figures to read: of each step, what it took, for a job, and over the smallest sweep's."""
    lines = [f"batch_scale: jobs that compute nothing, {WORKERS} workers"]
    heads = (
        "wall",
        "processor",
        "memory",
        "wall/job",
        "processor/job",
        "over smallest",
        "files",
        "bytes/job",
        "load",
    )
    lines.append(f"  {'':18} {'jobs':>8}" + "".join(f" {head:>13}" for head in heads))
    for step in STEPS:
        some = [row for row in rows if row["step"] == step]
        each = [row["processor_s"] / row["jobs"] for row in some]
        for row, processor in zip(some, each, strict=True):
            cells = [in_words(row["time_s"]), in_words(row["processor_s"]), f"{row['memory_mb']:.0f} MB"]
            cells += [in_words(row["time_s"] / row["jobs"]), in_words(processor)]
            cells += [f"{processor / each[0]:.2f}", f"{row['files']}"]
            cells += [f"{1e6 * row['folder_mb'] / row['jobs']:.0f}", f"{row['load']:.1f}"]
            lines.append(f"  {step:18} {row['jobs']:8}" + "".join(f" {cell:>13}" for cell in cells))
    return "\n".join(lines)
