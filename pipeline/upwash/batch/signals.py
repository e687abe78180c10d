"""Requests to stop: held back while workers are started, and then heard as Ctrl-C is."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

STOPPING = (signal.SIGINT, signal.SIGTERM)
"""Requests to stop: of a person at a terminal, of the system."""


@contextmanager
def signals_held() -> Iterator[None]:
    """Hold requests to stop back while workers are started.

    They inherit that: Ctrl-C, or a queue's signal to all processes, reaches this one alone, which stops them.
    """
    # multiprocessing lets the signals through when it starts this process of its own; so that comes first.
    resource_tracker.ensure_running()
    # Another thread of this process may still be handed a signal, which Python then handles in this one.
    requests: list[int] = []
    heard = {one: signal.getsignal(one) for one in STOPPING if signal.getsignal(one) != signal.SIG_IGN}
    for one in heard:
        signal.signal(one, lambda number, _: requests.append(number))
    held = signal.pthread_sigmask(signal.SIG_BLOCK, STOPPING)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
        for one, handler in heard.items():
            signal.signal(one, handler)
        if requests:
            raise KeyboardInterrupt


@contextmanager
def stopping_on_signals() -> Iterator[None]:
    """Let a polite request of the system, such as a queue's at the time limit, stop us as Ctrl-C does."""

    def interrupt(*_: Any) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)
