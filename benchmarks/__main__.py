"""Run the contests and the studies, print what they show, and keep it as Parquet."""

from __future__ import annotations

import argparse
import importlib
from pathlib import Path

import numba

from benchmarks import batch_scale, machine, seeds
from benchmarks.contest import measure
from benchmarks.record import store, table

CONTESTS = ("field", "wake_force", "force_map", "local_solve", "place", "saving_map", "job")
NAMES = (*CONTESTS, "batch_scale", "seeds")
RESULTS = Path(__file__).parents[1] / "results" / "bench"


def main() -> None:
    """Run what the command line names, or all."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one or more of {', '.join(NAMES)}")
    parser.add_argument("--seconds", type=float, default=20.0, help="time to spend on each contest")
    parser.add_argument("--seeds", type=int, default=20, help="seeds of the study, for each objective")
    parser.add_argument("--birds", type=int, default=20, help="random birds of the study")
    parser.add_argument("--workers", type=int, default=1, help="processes of the study")
    parser.add_argument("--jobs", type=int, default=100_000, help="jobs of the largest sweep of batch_scale")
    parser.add_argument("--results", type=Path, default=RESULTS, help="folder for the Parquet files")
    asked = parser.parse_args()
    for name in asked.names:
        if name not in NAMES:
            parser.error(f"expected one of {', '.join(NAMES)}, found {name!r}")
    for option in ("seeds", "birds", "workers", "jobs"):
        least = 1 if option in ("workers", "jobs") else 0
        if getattr(asked, option) < least:
            parser.error(f"--{option}: expected at least {least}, found {getattr(asked, option)}")

    numba.set_num_threads(1)  # a peer's kernel may run in parallel: here all have one core
    about = machine.description()
    print(f"{about['processor']}, {about['cores']} cores, {about['system']}")
    print(", ".join(f"{name} {version}" for name, version in machine.versions().items()))
    for name in asked.names or NAMES:
        if name in CONTESTS:
            rows = measure(importlib.import_module(f"benchmarks.{name}").contest(), asked.seconds)
            print(f"\n{table(rows)}\n  {store(rows, asked.results)}", flush=True)
            continue
        if name == "batch_scale":
            rows = batch_scale.study(asked.jobs)
            print(
                f"\n{batch_scale.report(rows)}\n  {store(rows, asked.results, batch_scale.SCHEMA)}",
                flush=True,
            )
            continue
        rows = seeds.study(asked.seeds, asked.birds, asked.workers)
        print(f"\n{seeds.report(rows)}")
        for part in seeds.PARTS:
            some = [row for row in rows if row["contest"] == part]
            if some:
                print(f"  {store(some, asked.results, seeds.SCHEMA)}", flush=True)


if __name__ == "__main__":
    main()
