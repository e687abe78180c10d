"""The ledger of the paper's claims in words: for a terminal, as Markdown, and as the page shows it."""

from __future__ import annotations

from typing import Any

import pandas as pd

from upwash.paper.claim import (
    FAILS,
    HOLDS,
    HOLDS_WITH_CONDITION,
    MEANINGLESS,
    NOT_JUDGED,
    NOT_RUN,
    PAPER_ALONE,
)
from upwash.paper.ledger import BETWEEN, NUMBER, cases_in, tally
from upwash.report.table import Table
from upwash.report.words import true_minus

LIMIT = ".5g"

ROUNDED_TO_ZERO = 1e-6
"""Accepted values this near to zero on both sides are written as zero."""

COUNTED = {HOLDS: "hold", HOLDS_WITH_CONDITION: "hold with a condition", FAILS: "fail", NOT_RUN: "not run"}
COUNTED |= {
    MEANINGLESS: "have no meaning",
    PAPER_ALONE: "are about the paper's model alone",
    NOT_JUDGED: "not judged",
}


def counts(ledger: pd.DataFrame) -> str:
    """Say how many claims hold and how many do not, in the paper's model and in the limit."""
    ours, limit = (
        ", ".join(
            f"{number} {COUNTED[verdict]}" for verdict, number in tally(ledger, column).items() if number
        )
        for column in ("verdict", "limit_verdict")
    )
    return f"{len(ledger)} claims: {ours}; in the limit: {limit}"


def ledger_text(ledger: pd.DataFrame) -> str:
    """Write the ledger for a terminal: one table, and below it why a claim does not simply hold."""
    shown = pd.DataFrame(
        {
            "claim": ledger["claim_id"],
            "printed": ledger["printed"],
            "unit": ledger["unit"],
            "ours": ledger["ours"],
            "accepted": _accepted(ledger),
            "verdict": ledger["verdict"],
            "in the limit": ledger["limit_verdict"],
        }
    )
    open_ones = ledger[ledger["verdict"] != HOLDS]
    why = [f"{row.claim_id}: {row.claim}: {_spelled(row)}. {row.why}" for row in open_ones.itertuples()]
    others = ledger[(ledger["limit_verdict"] != ledger["verdict"]) & (ledger["limit_cases"] != "")]
    why += [f"{row.claim_id}, in the limit: {_limit_in_words(row)}" for row in others.itertuples()]
    table = Table("The paper's claims, and our verdicts", shown, {"ours": NUMBER}, tuple(why)).text()
    return f"{table}\n\n{counts(ledger)}"


def _limit_in_words(row: Any) -> str:
    """Write a verdict in the limit, its cases and why."""
    unit = f" {row.unit}" if row.unit else ""
    return f"{row.limit_verdict}: {row.limit_cases}{unit}. {row.limit_why}".rstrip()


def _spelled(row: Any) -> str:
    """Write a verdict and, if it is conditional, the cases that are not as claimed."""
    return row.verdict + (f" (not so: {row.exceptions})" if row.verdict == HOLDS_WITH_CONDITION else "")


def ledger_markdown(ledger: pd.DataFrame) -> str:
    """Write the ledger as Markdown, one table a topic."""
    parts = [f"{counts(ledger)}."]
    for topic, rows in ledger.groupby("topic", sort=False):
        shown = pd.DataFrame(
            {
                "claim": [f"{row.claim} ({row.place})" for row in rows.itertuples()],
                "printed": rows["printed"],
                "ours": list(map(_marked, rows["cases"], rows["exceptions"])),
                "unit": rows["unit"],
                "accepted": _accepted(rows),
                "verdict": [f"**{verdict}**" if verdict != HOLDS else verdict for verdict in rows["verdict"]],
                "why": rows["why"],
                "in the limit": list(map(_in_limit, rows.itertuples())),
            }
        )
        # A heading stands in the place of the table's own title.
        lines = Table(str(topic), shown).markdown().splitlines()[2:]
        parts.append("\n".join([f"## {topic}", "", *lines]))
    return true_minus("\n\n".join(parts))


def ledger_shown(ledger: pd.DataFrame) -> pd.DataFrame:
    """Return the ledger as people read it on one page: verdict, claim, values, and why."""
    values = [
        f"{cases} {unit}".strip() if cases else ""
        for cases, unit in zip(ledger["cases"], ledger["unit"], strict=True)
    ]
    return pd.DataFrame(
        {
            "verdict": ledger["verdict"],
            "claim": [f"{row.claim} ({row.place})" for row in ledger.itertuples()],
            "printed": ledger["printed"],
            "ours": values,
            "accepted": _accepted(ledger),
            "why": ledger["why"],
            "in the limit": [_in_limit(row, "") for row in ledger.itertuples()],
        }
    )


def _in_limit(row: Any, bold: str = "**") -> str:
    """Write a verdict in the limit, our values there, and why."""
    verdict = row.limit_verdict
    verdict = f"{bold}{verdict}{bold}" if verdict in (HOLDS_WITH_CONDITION, FAILS) else verdict
    values = ""
    if row.limit_cases:
        values = _marked(row.limit_cases, row.limit_exceptions) if bold else row.limit_cases
    return ". ".join(part for part in (": ".join(filter(None, (verdict, values))), row.limit_why) if part)


def _marked(cases: str, exceptions: str) -> str:
    """Return the cases with those that are not as claimed in bold."""
    written = (f"**{case}**" if is_bold else case for case, is_bold in cases_in(cases, exceptions))
    return BETWEEN.join(written) or "-"


def _accepted(ledger: pd.DataFrame) -> list[str]:
    """Write the accepted values of each claim."""
    written = []
    for low, high in zip(ledger["accepted_low"], ledger["accepted_high"], strict=True):
        if pd.isna(low):
            written.append(f"at most {high:{LIMIT}}")
        elif pd.isna(high):
            written.append(f"at least {low:{LIMIT}}")
        elif max(-low, high) <= ROUNDED_TO_ZERO:
            written.append("0")
        else:
            written.append(f"{low:{LIMIT}} to {high:{LIMIT}}")
    return written
