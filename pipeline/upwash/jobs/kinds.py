"""The kinds of jobs; another one is a line here."""

from __future__ import annotations

from upwash.jobs.flock import Flock
from upwash.jobs.kind import Kind
from upwash.jobs.pair import Pair

KINDS: dict[str, type[Kind]] = {kind.name: kind for kind in (Pair, Flock)}
"""Name -> kind of job."""
