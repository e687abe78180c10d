"""What the whole comparison of species costs: the sweep over all of them, run and gathered by the command.

python -m benchmarks.cross_species [--workers 2]
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

import pandas as pd
from upwash.sweep.file import find_sweep

from benchmarks import machine
from benchmarks.batch_scale import measured

PROMISED_S = 60.0
"""On two workers, the sweep takes less."""


def main() -> None:
    """Compile once, then run the sweep from nothing, gather it, and print what each took."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.cross_species", description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    sweep = str(find_sweep("cross-species"))
    about = machine.description()
    print(f"{about['processor']}, {about['cores']} cores, {about['system']}; {asked.workers} workers")
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        measured(folder, "optimum", "northern-bald-ibis")
        run = measured(folder, "run", sweep, "--results", "results", "--workers", str(asked.workers))
        gather = measured(folder, "aggregate", "results")
        jobs = pd.read_parquet(folder / "results" / "summary.parquet")
    for label, (wall, processor, megabytes) in (("run", run), ("gather, with the tables", gather)):
        print(f"{label:24} {wall:8.2f} s {processor:8.2f} s of processor {megabytes:6.0f} MB")
    each = jobs["solve_time_s"]
    print(f"{len(jobs)} jobs, a solved one {each.median():.2f} s (median), {each.max():.2f} s (longest)")
    print(f"promised on two workers: run in less than {PROMISED_S:.0f} s")


if __name__ == "__main__":
    main()
