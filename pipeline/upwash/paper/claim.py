"""A claim, what would make it true, and the verdict on it.

A claim may be measured in several cases: for both cost functions, or in both readings of the flock.  It holds if
every case is as claimed, fails if none is, and otherwise holds with a condition, which the cases name.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from upwash.paper.evidence import Evidence

HOLDS, HOLDS_WITH_CONDITION, FAILS, NOT_RUN = "holds", "holds with a condition", "fails", "not run"
VERDICTS = (HOLDS, HOLDS_WITH_CONDITION, FAILS, NOT_RUN)

Cases = Mapping[str, float]
"""Case -> our value in it."""

ROUNDING = 1e-9
"""A value this far beyond a limit, over the limit, is at it."""


@dataclass(frozen=True)
class Accepted:
    """Values of ours that make a claim true: from `low` to `high`, and `tolerance` beyond either."""

    low: float
    high: float
    tolerance: float = 0.0

    @property
    def least(self) -> float:
        """The least value that is accepted."""
        return self.low - self.tolerance

    @property
    def most(self) -> float:
        """The largest value that is accepted."""
        return self.high + self.tolerance

    def holds(self, value: float) -> bool:
        """Whether a value is accepted; none is that is not a number."""
        low, high = self.least, self.most
        return (
            low - ROUNDING * abs(low) <= value <= high + ROUNDING * abs(high)
            if math.isfinite(value)
            else False
        )

    def words(self) -> str:
        """Write the accepted values."""
        if math.isinf(self.low):
            return f"at most {self.most:g}"
        if math.isinf(self.high):
            return f"at least {self.least:g}"
        middle = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"{middle} ± {self.tolerance:.3g}" if self.tolerance else middle


def near(value: float, tolerance: float) -> Accepted:
    """Accept a value and what is within a tolerance of it."""
    return Accepted(value, value, tolerance)


def between(low: float, high: float, tolerance: float = 0.0) -> Accepted:
    """Accept a range, and what is within a tolerance of it."""
    return Accepted(low, high, tolerance)


def at_most(limit: float) -> Accepted:
    """Accept what is no larger than a limit."""
    return Accepted(-math.inf, limit)


def at_least(limit: float) -> Accepted:
    """Accept what is no smaller than a limit."""
    return Accepted(limit, math.inf)


Measure = Callable[[Evidence], Cases]
Measures = Mapping[str, Measure]
"""Name of a claim -> what is measured for it."""


@dataclass(frozen=True)
class Claim:
    """One claim of the paper.

    Parameters
    ----------
    name : str
        Its name, which stays when claims are added or moved.
    topic : str
        What it is about.
    place : str
        Where it stands in the paper.
    says : str
        What it says, in few words of ours.
    printed : str
        The printed value or phrase.
    unit : str
        Unit of our values; empty for a pure number.
    accepted : Accepted
        Our values that make it true.
    measure : callable
        Evidence -> our value in each case.
    why : str
        One line of why; ``{case}`` and ``{case:.3g}`` stand for our value in that case.
    needs : str
        Name of the field of the evidence that is measured.
    facts : callable, optional
        Evidence -> other numbers of ours that `why` names.
    """

    name: str
    topic: str
    place: str
    says: str
    printed: str
    unit: str
    accepted: Accepted
    measure: Measure
    why: str
    needs: str = "pair"
    facts: Measure | None = None


def read_claim(said: Mapping[str, str], measure: Measure, facts: Measure | None) -> Claim:
    """Return a claim as a line of ``claims.csv`` says it.

    An end of the accepted values that is not given is open. A tolerance in percent is a share of the printed value.
    """
    low, high = float(said["low"] or -math.inf), float(said["high"] or math.inf)
    share, is_share, _ = said["tolerance"].partition(" %")
    tolerance = float(share or 0.0) / 100.0 * low if is_share else float(share or 0.0)
    return Claim(
        name=said["claim_id"],
        topic=said["topic"],
        place=said["place"],
        says=said["claim"],
        printed=said["printed"],
        unit=said["unit"],
        accepted=Accepted(low, high, tolerance),
        measure=measure,
        why=said["why"],
        needs=said["evidence"],
        facts=facts,
    )


@dataclass(frozen=True)
class Judgement:
    """What came of a claim: our value in each case, those that are not as claimed, the verdict, and why."""

    claim: Claim
    cases: Cases
    exceptions: tuple[str, ...]
    verdict: str
    why: str


def judge(claim: Claim, evidence: Evidence) -> Judgement:
    """Measure a claim and say whether it holds."""
    missing = evidence.missing(claim.needs)
    if missing:
        return Judgement(claim, {}, (), NOT_RUN, missing)
    cases = claim.measure(evidence)
    exceptions = tuple(case for case, value in cases.items() if not claim.accepted.holds(value))
    if not exceptions:
        verdict = HOLDS
    elif len(exceptions) < len(cases):
        verdict = HOLDS_WITH_CONDITION
    else:
        verdict = FAILS
    named = {**(claim.facts(evidence) if claim.facts else {}), **cases}
    return Judgement(claim, cases, exceptions, verdict, claim.why.format_map(named))
