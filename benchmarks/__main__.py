"""Run the contests, print each as a table of times and ratios, and keep them as Parquet."""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import numba

from benchmarks import machine
from benchmarks.contest import measure
from benchmarks.record import store, table

CONTESTS = ("field", "wake_force")
RESULTS = Path(__file__).parents[1] / "results" / "bench"


def main() -> None:
    """Run the contests that the command line names, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of {', '.join(CONTESTS)}")
    parser.add_argument("--seconds", type=float, default=20.0, help="time to spend on each contest")
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder for the Parquet files")
    asked = parser.parse_args()
    for name in asked.names:
        if name not in CONTESTS:
            parser.error(f"expected a contest ({', '.join(CONTESTS)}), found {name!r}")

    numba.set_num_threads(1)  # a peer's kernel may run in parallel: here all have one core
    about = machine.description()
    print(f"{about['processor']}, {about['cores']} cores, {about['system']}")
    print(", ".join(f"{name} {version}" for name, version in machine.versions().items()))
    for name in asked.names or CONTESTS:
        rows = measure(importlib.import_module(f"benchmarks.{name}").contest(), asked.seconds)
        print(f"\n{table(rows)}\n  {store(rows, asked.results)}")


if __name__ == "__main__":
    main()
