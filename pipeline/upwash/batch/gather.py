"""Gathering finished jobs while a run goes on, so that there are never many files, however many jobs there are.

Jobs' own files become a part when there are many of them; parts of about one size become a larger one. A
file is in place, and on the disk, before those that it gathers are removed: whatever stops this, nothing is
lost, and what is there twice is read once.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

import pyarrow as pa

from upwash.batch.folder import ResultsFolder, Shard, jobs_in, shard_of
from upwash.batch.merging import JobFiles, Table, merged
from upwash.batch.selection import in_shard
from upwash.batch.store import Damaged, TableWriter, merged_provenance, replacing, sync

MOST_JOB_FILES = 512
"""With so many jobs' own files, those of all shards together, they become a part."""

MOST_PARTS = 16
"""With so many parts of one size they become one, and sizes are the powers of this."""

JOBS_PER_GROUP = 250
"""Jobs in a row group of a part: few, for one of each part is held while parts are merged."""


class Gathering:
    """Keeps few files in a results folder, of the jobs of one shard.

    Parameters
    ----------
    folder : ResultsFolder
        The folder, of which the caller has locked the shard.
    shard : Shard
        Whose jobs and parts may be touched.
    schema : Schema
        Of the rows.
    sweep_text : str
        The sweep's own text, for the files' metadata.
    """

    def __init__(self, folder: ResultsFolder, shard: Shard, schema: pa.Schema, sweep_text: str) -> None:
        self.folder = folder
        self.shard = shard
        self.schema = schema
        self.sweep_text = sweep_text
        self.most_job_files = max(2, MOST_JOB_FILES // shard.count)
        self.job_files = len(self._own_jobs())

    def added(self, jobs: int) -> None:
        """Take note of a new file of so many jobs; gather if that makes too many."""
        self.job_files += jobs == 1
        if self.job_files >= self.most_job_files:
            self._gather(self._own_jobs(), [])
            self.job_files = 0
        elif jobs == 1:
            return
        try:
            while parts := self._too_many():
                self._gather([], parts)
        except Damaged:
            # Who has the folder alone looks for damage and sets it aside; a shard goes on beside it.
            return

    def _own_jobs(self) -> list[str]:
        return [job_id for job_id in self.folder.job_ids() if in_shard(job_id, self.shard)]

    def _too_many(self) -> list[Path]:
        """Return parts of one size of which there are too many, or none."""
        sizes: dict[int, list[Path]] = {}
        for path in self.folder.part_files():
            if self.shard.count == 1 or shard_of(path) == str(self.shard):
                sizes.setdefault(_size(path), []).append(path)
        return next((paths for paths in sizes.values() if len(paths) >= MOST_PARTS), [])

    def _gather(self, job_ids: list[str], parts: Sequence[Path]) -> None:
        with ExitStack() as files:
            singles = JobFiles(self.folder, job_ids, self.schema)
            sources: list[JobFiles | Table] = [singles, *(Table(files, path, self.schema) for path in parts)]
            ids = sorted({job_id for source in sources for job_id in source.ids()})
            with replacing(self.folder.new_part(len(ids), self.shard)) as unfinished:
                writer = TableWriter(unfinished, self.schema)
                for rows in merged(sources, ids, JOBS_PER_GROUP):
                    writer.write(rows)
                metadata = [one for source in sources for one in source.metadata]
                writer.close(merged_provenance(metadata, self.sweep_text))
        sync(self.folder.parts)
        for path in (*singles.given, *parts):
            path.unlink(missing_ok=True)


def _size(part: Path) -> int:
    """Return the power of `MOST_PARTS` that the number of a part's jobs reaches."""
    size, jobs = 0, jobs_in(part)
    while jobs >= MOST_PARTS:
        size, jobs = size + 1, jobs // MOST_PARTS
    return size
