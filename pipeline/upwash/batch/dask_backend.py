"""joblib's dask backend, patched in two places where it would hang, or compute in the wrong process."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

from joblib._dask import DaskDistributedBackend


class KilledBatch(Exception):
    """A batch killed every worker that the scheduler gave it to; `jobs` are the batch's."""

    def __init__(self, jobs: list[Any]) -> None:
        super().__init__("a batch killed its workers")
        self.jobs = jobs


class PatchedDaskBackend(DaskDistributedBackend):
    """Tells joblib of a task that was lost, and never runs tasks in this process."""

    def submit(self, func: Any, callback: Callable[[Any], None] | None = None) -> Future:
        """Hand over a batch; if the scheduler gives it up, say so, or joblib would wait for ever."""
        future = super().submit(func, callback)

        def tell(done: Future) -> None:
            if callback is not None and done.exception() is not None:
                (_, (jobs, *_), _), *_ = func.items
                callback(KilledBatch(jobs))

        future.add_done_callback(tell)
        return future

    def effective_n_jobs(self, n_jobs: int) -> int:
        """Return the cluster's threads, or two if there is one: joblib would run that one's tasks here."""
        return max(2, super().effective_n_jobs(n_jobs))
