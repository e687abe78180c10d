"""Sweeps: a TOML file that says what is varied in, jobs with stable ids out.

The names below load when they are first used: what a job is can be known without the libraries that expand a sweep.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from upwash.jobs.job import MODEL_VERSION, Job
    from upwash.sweep.file import Sweep, read_sweep

__all__ = ["MODEL_VERSION", "Job", "Sweep", "read_sweep"]

_HOME = {
    "MODEL_VERSION": "upwash.jobs.job",
    "Job": "upwash.jobs.job",
    "Sweep": "upwash.sweep.file",
    "read_sweep": "upwash.sweep.file",
}


def __getattr__(name: str) -> Any:
    """Import a public name from the module it lives in, on first use."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
