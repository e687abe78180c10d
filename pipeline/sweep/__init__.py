"""Sweeps: a TOML file that says what is varied in, jobs with stable ids out."""

from pipeline.sweep.file import Sweep, read_sweep
from pipeline.sweep.job import MODEL_VERSION, Job

__all__ = ["MODEL_VERSION", "Job", "Sweep", "read_sweep"]
