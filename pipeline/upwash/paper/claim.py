"""A claim, what would make it true, and the verdict on it.

A claim may be measured in several cases: for both cost functions, or in both readings of the flock.  It holds if
every case is as claimed, fails if none is, and otherwise holds with a condition, which the cases name.

In the limit a claim is judged by the same measure, or by one of its own, on the optima of both span laws.  What it is
about may not exist there: then it has no meaning, which is measured too.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from upwash.paper.evidence import Evidence

HOLDS, HOLDS_WITH_CONDITION, FAILS, NOT_RUN = "holds", "holds with a condition", "fails", "not run"
VERDICTS = (HOLDS, HOLDS_WITH_CONDITION, FAILS, NOT_RUN)

MEANINGLESS, NOT_JUDGED, PAPER_ALONE = "has no meaning", "not judged", "about the paper's model alone"
LIMIT_VERDICTS = (HOLDS, HOLDS_WITH_CONDITION, FAILS, MEANINGLESS, PAPER_ALONE, NOT_JUDGED, NOT_RUN)
"""Verdicts in the limit: beside those above, that what a claim is about does not exist there, that it is about the
paper's own text, numbers or solver, and that it needs results that nobody has in the limit."""

PAPER = "paper"
"""What a claim is about that concerns the paper alone."""

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
    about : str
        What it is about that another model of the wake may lack: a key of `upwash.paper.of_limit.ABOUT`, `PAPER`, or
        nothing.
    limit_measure : callable, optional
        Evidence of the pair in the limit -> our value in each case; `measure` if not given.
    limit_why : str
        One line of why in the limit, as `why`; the cases are named after the span law too.
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
    about: str = ""
    limit_measure: Measure | None = None
    limit_why: str = ""


def read_claim(
    said: Mapping[str, str], measure: Measure, facts: Measure | None, limit_measure: Measure | None = None
) -> Claim:
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
        about=said["about"],
        limit_measure=limit_measure,
        limit_why=said["limit_why"],
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
    verdict, exceptions = _verdict(claim, cases)
    named = {**(claim.facts(evidence) if claim.facts else {}), **cases}
    return Judgement(claim, cases, exceptions, verdict, claim.why.format_map(named))


def _verdict(claim: Claim, cases: Cases) -> tuple[str, tuple[str, ...]]:
    """Return the verdict on some cases, and those that are not as claimed."""
    exceptions = tuple(case for case, value in cases.items() if not claim.accepted.holds(value))
    if not exceptions:
        return HOLDS, exceptions
    return (HOLDS_WITH_CONDITION if len(exceptions) < len(cases) else FAILS), exceptions


Absence = Callable[[Evidence], str]
"""Evidence -> why what a claim is about does not exist there; nothing if it does."""


def judge_in_limit(claim: Claim, evidence: Evidence, absences: Mapping[str, Absence]) -> Judgement:
    """Measure a claim in the limit, for both span laws, and say whether it holds there.

    Parameters
    ----------
    claim : Claim
        The claim.
    evidence : Evidence
        The paper's evidence, with that of the limit.
    absences : mapping
        What a claim may be about -> whether the limit lacks it.
    """
    if claim.about == PAPER:
        return Judgement(claim, {}, (), PAPER_ALONE, "It is about the paper's own text, figures or solver.")
    missing = evidence.missing("limit")
    if missing:
        return Judgement(claim, {}, (), NOT_RUN, missing)
    if claim.needs != "pair":
        return Judgement(claim, {}, (), NOT_JUDGED, f"No {claim.needs} were solved in the limit.")
    limits = evidence.in_limit
    if claim.about:
        reasons = {absences[claim.about](limit) for limit in limits.values()}
        if all(reasons):
            return Judgement(claim, {}, (), MEANINGLESS, " ".join(sorted(reasons)))
    measure = claim.limit_measure or claim.measure
    measured = {law: measure(limit) for law, limit in limits.items()}
    cases: dict[str, float] = {}
    for case in next(iter(measured.values())):
        values = {law: of_law[case] for law, of_law in measured.items()}
        first, *others = values.values()
        if all(other == first or (math.isnan(other) and math.isnan(first)) for other in others):
            cases[case] = first
        else:
            cases |= {f"{case}, {law} law": value for law, value in values.items()}
    verdict, exceptions = _verdict(claim, cases)
    without = {objective for limit in limits.values() for objective in limit.without_v}
    is_missing = any(math.isnan(value) for value in cases.values())
    lacking = [f"Least {objective} has no V optimum there." for objective in sorted(without) if is_missing]
    named = {
        f"{case}, {law} law": value for law, of_law in measured.items() for case, value in of_law.items()
    }
    why = " ".join([*lacking, *([claim.limit_why.format_map(named | cases)] if claim.limit_why else [])])
    return Judgement(claim, cases, exceptions, verdict, why)
