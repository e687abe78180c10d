"""What a person sees while a sweep runs: a bar on a terminal, plain lines elsewhere, and each failure."""

from __future__ import annotations

import time
from typing import TextIO

from upwash import columns as of

LINES = 20
"""Plain lines in all, at least, when the output is no terminal."""

MAX_SILENCE_S = 60.0
BAR_WIDTH = 30
FAILURES_SHOWN = 20


class Progress:
    """Counts finished jobs and says so.

    Parameters
    ----------
    total : int
        Jobs of the sweep, or of this part of it.
    before : int
        Those of them that were done before.
    stream : text stream
        Where to write: standard error.
    """

    def __init__(self, total: int, before: int, stream: TextIO) -> None:
        self.total = total
        self.before = before
        self.stream = stream
        self.is_terminal = stream.isatty()
        self.done = 0
        self.failed = 0
        self.begun = self.said_at = time.monotonic()
        self.said = 0

    @property
    def left(self) -> int:
        """Jobs that are still to be done."""
        return self.total - self.before - self.done

    def finished(self, job_id: str, status: str, error: str) -> None:
        """Count a job, and show its failure."""
        self.done += 1
        if status == of.FAILED:
            self.failed += 1
            if self.failed <= FAILURES_SHOWN:
                self.tell(f"job {job_id} failed: {error}")
            if self.failed == FAILURES_SHOWN:
                self.tell("further failures are counted here, and listed by 'upwash status'")

    def restart(self) -> None:
        """Tell the rate from here on."""
        self.begun = time.monotonic()

    def tell(self, line: str) -> None:
        """Write a line of its own."""
        self.stream.write(f"\r\x1b[K{line}\n" if self.is_terminal else f"{line}\n")

    def show(self) -> None:
        """Bring the bar up to date, or write a line if enough has happened."""
        now = time.monotonic()
        if self.is_terminal:
            filled = BAR_WIDTH * (self.before + self.done) // max(1, self.total)
            self.stream.write(f"\r[{'#' * filled:{BAR_WIDTH}}] {self.words(now)}\x1b[K")
            self.stream.flush()
        elif self.done != self.said and (
            self.done - self.said >= (self.total - self.before) / LINES
            or self.left == 0
            or now - self.said_at > MAX_SILENCE_S
        ):
            self.stream.write(self.words(now) + "\n")
            self.stream.flush()
            self.said, self.said_at = self.done, now

    def words(self, now: float) -> str:
        """Return how far the run has come."""
        elapsed = now - self.begun
        rate = self.done / elapsed if elapsed > 0 else 0.0
        parts = [f"{self.before + self.done} of {self.total} jobs"]
        if self.failed:
            parts.append(f"{self.failed} failed")
        if self.done:
            parts.append(f"{rate:.3g} jobs/s")
        if self.done and self.left and rate:
            parts.append(f"{duration(self.left / rate)} left")
        return ", ".join(parts)

    def close(self) -> None:
        """Leave the bar as it is and go to the next line."""
        if self.is_terminal:
            self.stream.write("\n")
            self.stream.flush()


def duration(seconds: float) -> str:
    """Write a time as a person would: 12 s, 3 min, 2 h 05 min."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 100:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60:02d} min"
