"""The machine that a benchmark ran on: times mean nothing without it."""

from __future__ import annotations

import os
import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = ("llvmlite", "nlopt", "numba", "numpy", "PteraSoftware", "scipy")


def processor() -> str:
    """Return the processor's model."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()


def versions() -> dict[str, str]:
    """Return the version of each package that is measured or that compiles, if installed."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return found


def description() -> dict[str, str | int]:
    """Return processor, number of its cores and operating system."""
    return {"processor": processor(), "cores": os.cpu_count() or 1, "system": platform.system()}
