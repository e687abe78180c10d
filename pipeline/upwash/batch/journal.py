"""Journals of a results folder: when runs began and how fast they went, for estimates alone."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import IO, NamedTuple

from upwash.batch.folder import ResultsFolder, Shard

RUN, DONE = "run", "done"
"""How a line of a journal begins: when a run began, or some of its jobs were done."""


class Stretch(NamedTuple):
    """One line of a journal: that some jobs were done, when, and how long workers were busy with them."""

    time: float
    jobs: int
    seconds: float


@dataclass(frozen=True)
class Journals:
    """What the journals say.

    Parameters
    ----------
    begun : list of float
        When each run began, in seconds since 1970.
    done : list of Stretch
        What was done, in order of time.
    """

    begun: list[float]
    done: list[Stretch]


def journals_of(folder: ResultsFolder) -> list[Path]:
    """Return the journals of all runs and shards."""
    return sorted(folder.path.glob("journal-*.csv"))


def open_journal(folder: ResultsFolder, shard: Shard, jobs_to_do: int) -> IO[str]:
    """Open a journal to append to, and note that a run begins."""
    path = folder.path / f"journal-{shard}.csv"
    try:
        torn = path.exists() and not path.read_bytes().endswith(b"\n")
        file = open(path, "a", encoding="utf-8", buffering=1)  # noqa: SIM115  # the caller closes it
        file.write(("\n" if torn else "") + f"{RUN},{time.time():.3f},{jobs_to_do}\n")
    except OSError as error:
        raise folder.cannot("write there", error) from error
    return file


def read_journals(folder: ResultsFolder) -> Journals:
    """Return what the journals say; torn lines are passed over."""
    begun, done = [], []
    for path in journals_of(folder):
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            name, _, numbers = line.partition(",")
            try:
                when, jobs, *seconds = numbers.split(",")
                if name == RUN and not seconds:
                    begun.append(float(when))
                elif name == DONE and len(seconds) == 1:
                    done.append(Stretch(float(when), int(jobs), float(seconds[0])))
            except ValueError:
                continue
    return Journals(begun, sorted(done))


def journal_line(done: Stretch) -> str:
    """Return the line that `read_journals` reads."""
    return f"{DONE},{done.time:.3f},{done.jobs},{done.seconds:.6f}\n"
