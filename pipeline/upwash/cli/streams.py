"""Standard output and standard error, whatever state they are in.

Results that cannot be written are an error, in one line. What is told to a person beside them never stops the work:
it is told if it can be, and after some seconds of silence that the command is still at work.
"""

from __future__ import annotations

import logging
import os
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from upwash.errors import EnvironmentFault

SILENCE_S = 8.0
"""After so long without a word a person is told that the command is still at work."""

LOOK_EVERY_S = 0.5


class Stream:
    """A stream that notes when it was last written to, and turns what goes wrong into one line, or into nothing.

    Parameters
    ----------
    stream : text stream or None
        The stream; None if it was closed before the program began.
    name : str
        What a person calls it, or "" if what is written there may get lost.
    wrote : callable
        Called with whether the end of a line was written, each time something is.
    """

    # Without this click would write UTF-8 to where another encoding was asked for.
    buffer = None

    def __init__(self, stream: TextIO | None, name: str, wrote: Callable[[bool], None]) -> None:
        self._stream = stream
        self._name = name
        self._wrote = wrote

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text."""
        if not isinstance(text, str):
            raise TypeError(f"expected text, found {type(text).__name__}")
        if not text:
            return 0  # click asks in this way whether a stream is one of text
        with self._guarded():
            if self._stream is None:
                raise OSError(0, "it is closed")
            self._stream.write(text)
            self._wrote(text.endswith("\n"))
        return len(text)

    def flush(self) -> None:
        """Put what was written where it belongs."""
        with self._guarded():
            if self._stream is not None:
                self._stream.flush()

    def isatty(self) -> bool:
        """Whether a person looks at it."""
        return self._stream is not None and self._stream.isatty()

    @contextmanager
    def _guarded(self) -> Iterator[None]:
        try:
            yield
        except UnicodeEncodeError as error:
            if self._name:
                found = f"the encoding {error.encoding}"
                remedy = "set PYTHONIOENCODING=utf-8, or redirect to a file with that set"
                raise EnvironmentFault(
                    f"{self._name}: expected an encoding that can write {error.object[error.start]!a}, found {found}; "
                    f"{remedy}"
                ) from error
        except BrokenPipeError:
            self._let_go()
            if self._name:
                raise
        except OSError as error:
            self._let_go()
            if self._name:
                remedy = "redirect it to a file on a disk with room, or print to a terminal"
                raise EnvironmentFault(
                    f"{self._name}: expected to write the results there, found: {error.strerror}; {remedy}"
                ) from error

    def _let_go(self) -> None:
        """Point the stream nowhere, so that what is left in it gives no further error when the program ends."""
        with suppress(OSError, ValueError, AttributeError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), self._stream.fileno())  # type: ignore[union-attr]


@contextmanager
def guarded_streams() -> Iterator[None]:
    """Guard both streams while a command runs."""
    _fill_closed_descriptors()
    before = sys.stdout, sys.stderr
    pulse = _Pulse()
    sys.stdout = Stream(before[0], "standard output", pulse.wrote)  # type: ignore[assignment]
    messages = Stream(before[1], "", pulse.wrote)
    sys.stderr = messages  # type: ignore[assignment]
    try:
        with pulse.beating(messages), _as_current(pulse), _passing_on(messages):
            yield
    finally:
        sys.stdout, sys.stderr = before


def at_work(doing: str) -> None:
    """Say from now on, after each silence, what the command is doing, as in "solving".

    A command calls it when its arguments are found to be good: before that there is nothing to tell but a mistake.
    """
    if _pulses:
        _pulses[-1].begin(doing)


def _fill_closed_descriptors() -> None:
    """Open what was closed before the program began, or the next file that is opened would take its place."""
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


@contextmanager
def _passing_on(stream: Stream) -> Iterator[None]:
    """Show what the package logs, such as that it compiles."""
    logger = logging.getLogger("upwash")
    handler = logging.StreamHandler(stream)
    level = logger.level
    logger.addHandler(handler)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.setLevel(level)


class _Pulse:
    """Says after each silence what the command is doing."""

    def __init__(self) -> None:
        self.is_line_ended = True
        self.begin("")

    def begin(self, doing: str) -> None:
        """Note what the command begins to do."""
        self.doing = doing
        self.begun = self.heard = time.monotonic()

    def wrote(self, is_line_ended: bool) -> None:
        """Note that something was written."""
        self.heard = time.monotonic()
        self.is_line_ended = is_line_ended

    @contextmanager
    def beating(self, stream: Stream) -> Iterator[None]:
        """Look at the clock now and then until the command ends."""
        ended = threading.Event()

        def watch() -> None:
            while not ended.wait(LOOK_EVERY_S):
                now = time.monotonic()
                if self.doing and now - self.heard >= SILENCE_S:
                    start = "" if self.is_line_ended else "\n"
                    stream.write(f"{start}still {self.doing}, {now - self.begun:.0f} s\n")
                    stream.flush()

        thread = threading.Thread(target=watch, name="pulse", daemon=True)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()


# The pulse of the command that runs; in tests a command may run within another.
_pulses: list[_Pulse] = []


@contextmanager
def _as_current(pulse: _Pulse) -> Iterator[None]:
    _pulses.append(pulse)
    try:
        yield
    finally:
        _pulses.remove(pulse)
