"""Where the workers come from: processes of this machine (loky), or those of a dask scheduler."""

from __future__ import annotations

import asyncio
import os
import threading
import time
import warnings
from collections.abc import Iterator
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from joblib import Parallel, parallel_config

from upwash.errors import UpwashError

LOKY, DASK = "loky", "dask"
CONNECT_TIMEOUT_S = 5
WORKERS_TIMEOUT_S = 10
SETTLE_TIMEOUT_S = 1

PARENT_CHECK_S = 0.5
"""A worker whose parent is gone has nobody to give its results to; it looks this often."""


@contextmanager
def workers(backend: str, scheduler: str = "") -> Iterator[type[BaseException]]:
    """Make joblib use workers of one kind, each with one thread for arrays and compiled loops.

    Parameters
    ----------
    backend : str
        ``loky`` or ``dask``.
    scheduler : str
        Address of the dask scheduler.

    Yields
    ------
    type
        What joblib raises when a worker is killed.

    Raises
    ------
    UpwashError
        If dask is not installed, or no scheduler or no worker answers.
    """
    if backend == LOKY:
        with parallel_config(
            backend=LOKY, inner_max_num_threads=1, initializer=_die_with, initargs=(os.getpid(),)
        ):
            yield BrokenProcessPool
        return
    try:
        from distributed import Client, Security
        from distributed.comm.core import connect

        from upwash.batch.dask_backend import KilledBatch, PatchedDaskBackend
    except ImportError as error:
        remedy = "pip install 'upwash[distributed]'"
        raise UpwashError(
            f"--backend dask: expected dask.distributed, found it not installed; {remedy}"
        ) from error

    async def reach() -> None:
        arguments = Security().get_connection_args("client")
        await (await connect(scheduler, timeout=CONNECT_TIMEOUT_S, **arguments)).close()

    try:
        # Asked first, since a client that finds no scheduler waits for itself, and complains when the program ends.
        asyncio.run(reach())
        client = Client(scheduler, timeout=CONNECT_TIMEOUT_S, set_as_default=False)
    except Exception as error:  # Any: whatever its transport says of an address.
        remedy = "start one by 'dask scheduler' and give its address, as in tcp://host:8786"
        raise UpwashError(
            f"--scheduler: expected a dask scheduler at {scheduler!r}, found none; {remedy}",
            field="scheduler",
        ) from error
    with client:
        if not _has_workers(client):
            remedy = f"start some by 'dask worker {scheduler} --nthreads 1'"
            raise UpwashError(f"--scheduler: expected workers at {scheduler}, found none; {remedy}")
        with parallel_config(backend=PatchedDaskBackend(client=client)):
            yield KilledBatch


def stop(pool: Parallel, outputs: Any) -> None:
    """Stop whatever still runs, once no more tasks are given out; it is of no use any more.

    Parameters
    ----------
    pool : Parallel
        The pool.
    outputs : generator
        What calling it returned.
    """
    # joblib's thread trips, with a traceback, over a task that it has begun to hand over when it is shut down.
    with pool._lock:
        executor = getattr(pool._backend, "_workers", None)
    deadline = time.monotonic() + SETTLE_TIMEOUT_S
    while executor and executor._work_ids.qsize() and time.monotonic() < deadline:
        time.sleep(0.001)
    with warnings.catch_warnings():
        # joblib need not warn of tasks that were not finished.
        warnings.simplefilter("ignore")
        outputs.close()


def _die_with(parent: int) -> None:
    """End this process soon after its parent has ended, however that came about, also when it never had a task."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_S)
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def _has_workers(client: Any) -> bool:
    try:
        client.wait_for_workers(1, timeout=WORKERS_TIMEOUT_S)
    except TimeoutError:
        return False
    return True
