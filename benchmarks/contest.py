"""A contest: contenders that do the same work, measured in turns."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from statistics import median

import numpy as np

SHORTEST_SAMPLE_S = 1e-3
"""A contender that needs less is run several times for one sample."""


@dataclass(frozen=True)
class Contender:
    """Something that does the work of a contest.

    Parameters
    ----------
    name : str
        What it is.
    run : callable
        Does the work once, with nothing left to compile or to allocate that a user would not pay for.
    work : float
        How many units of work one run does.
    answer : callable, optional
        Returns what was computed, to be compared with what the first contender answers.
    remark : callable, optional
        Returns what else is to be said of how it did, once it has been measured.
    missing : str
        Why it cannot take part; empty if it can.
    """

    name: str
    run: Callable[[], object] = lambda: None
    work: float = 1.0
    answer: Callable[[], np.ndarray] | None = None
    remark: Callable[[], str] | None = None
    missing: str = ""


@dataclass(frozen=True)
class Contest:
    """Contenders, the first being Upwash, and what a unit of their work is called."""

    name: str
    per: str
    contenders: list[Contender] = field(default_factory=list)


def measure(contest: Contest, seconds: float) -> list[dict]:
    """Run all contenders in turns for about so long, at least three times each.

    Returns
    -------
    list of dict
        For each contender: times in s for a unit of work, their ratio to the first contender's, the number
        of samples, and how far its answer is at most from the first's, as a fraction of the largest value.
    """
    present = [one for one in contest.contenders if not one.missing]
    repeats = {one.name: repeats_for(one) for one in present}
    samples: dict[str, list[float]] = {one.name: [] for one in present}
    end = time.perf_counter() + seconds
    while time.perf_counter() < end or min(map(len, samples.values())) < 3:
        for one in present:
            start = time.perf_counter()
            for _ in range(repeats[one.name]):
                one.run()
            samples[one.name].append((time.perf_counter() - start) / repeats[one.name] / one.work)
    ours = present[0]
    return [
        {
            "contest": contest.name,
            "contender": one.name,
            "per": contest.per,
            "missing": one.missing,
        }
        | (
            {
                "time_best_s": min(samples[one.name]),
                "time_median_s": median(samples[one.name]),
                "ratio": min(samples[one.name]) / min(samples[ours.name]),
                "samples": len(samples[one.name]),
                "difference": difference(one, ours),
                "remark": one.remark() if one.remark else "",
            }
            if not one.missing
            else {}
        )
        for one in contest.contenders
    ]


def repeats_for(contender: Contender) -> int:
    """Return how often a contender is run for a sample; the first run, which may compile, does not count."""
    contender.run()
    repeats = 1
    while True:
        start = time.perf_counter()
        for _ in range(repeats):
            contender.run()
        if time.perf_counter() - start >= SHORTEST_SAMPLE_S:
            return repeats
        repeats *= 2


def difference(contender: Contender, ours: Contender) -> float | None:
    """Return how far two answers are apart at most, as a fraction of the largest value."""
    if contender.answer is None or ours.answer is None:
        return None
    expected = ours.answer()
    return float(abs(contender.answer() - expected).max() / abs(expected).max())
