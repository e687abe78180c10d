"""What the batch layer itself costs: very many jobs that compute nothing, run by the command as users do.

python -m benchmarks.batch_scale [--jobs 100000]
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

SWEEP = """\
solver = "benchmarks.batch_scale:nothing"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.0, 1.5, {jobs}] }}
"""


def nothing(job: Any) -> tuple[str, str, list[dict]]:
    """Solve a job at no cost."""
    v_formation = {"is_v_optimum": True, "is_global_optimum": True, "solve_time_s": 0.0}
    return "solved", "", [{"rank": 0, "cost": job.mass_kg} | v_formation]


def measured(folder: Path, *arguments: str) -> tuple[float, float, float]:
    """Run the command; return its wall time and processor time in s, and its peak memory in MB.

    The workers' processor time counts; the memory is that of the largest process.
    """
    begun = time.perf_counter()
    process = subprocess.Popen(
        [sys.executable, "-c", "from pipeline.cli import main; main()", *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[1])},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise SystemExit(f"upwash {' '.join(arguments)}: exit code {process.returncode}")
    return time.perf_counter() - begun, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0


def main() -> None:
    """Run the sweep, look at it, gather it half by half, and print what each took."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.batch_scale", description=__doc__)
    parser.add_argument("--jobs", type=int, default=100_000)
    parser.add_argument("--workers", type=int, default=2)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=".") as name:
        folder = Path(name)
        (folder / "sweep.toml").write_text(SWEEP.format(jobs=asked.jobs))
        run = ("run", "./sweep.toml", "--workers", str(asked.workers))
        steps = [
            ("read the sweep and foresee", (*run, "--dry-run")),
            ("run the first half", (*run, "--shard", "1/2")),
            ("status", ("status", "results/sweep")),
            ("gather the first half", ("aggregate", "results/sweep")),
            ("run the second half", (*run, "--shard", "2/2")),
            ("gather the second half", ("aggregate", "results/sweep")),
            ("status when gathered", ("status", "results/sweep")),
            ("run when all is done", run),
        ]
        print(f"{asked.jobs} jobs, {asked.workers} workers")
        print(f"{'':28} {'wall':>10} {'processor':>10} {'memory':>10}")
        for label, arguments in steps:
            wall, processor, megabytes = measured(folder, *arguments)
            each = f"{1e3 * wall / (asked.jobs / 2):7.3f} ms a job" if "half" in label else ""
            print(f"{label:28} {wall:8.2f} s {processor:8.2f} s {megabytes:7.0f} MB {each}", flush=True)


if __name__ == "__main__":
    main()
