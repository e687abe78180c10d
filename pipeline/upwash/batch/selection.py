"""Which jobs of a sweep a run does."""

from __future__ import annotations

from upwash import columns as of
from upwash.batch.folder import Shard
from upwash.batch.index import Known


def in_shard(job_id: str, shard: Shard) -> bool:
    """Whether a job belongs to a shard: by its id, so whatever else is in the sweep."""
    return int(job_id, 16) % shard.count == shard.number - 1


def is_to_run(known: Known | None, retry_failed: bool) -> bool:
    """Whether a job is to be run, given what is known of it."""
    return known is None or (retry_failed and known.status == of.FAILED)
