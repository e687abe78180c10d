"""The ledger of the literature in words: for a terminal, and as Markdown."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from upwash.literature.ledger import CANNOT_FACE, CONTRADICTS, HOLDS, MODELS, SAME_SIGN, tally
from upwash.report.table import Table
from upwash.report.words import true_minus

CONTRADICTED = "What a model contradicts"
"""The first topic: entries of which a model says the opposite."""


def topics(ledger: pd.DataFrame) -> pd.Series:
    """Return each entry's topic, what is contradicted being one of its own."""
    contradicted = ledger["paper_verdict"].eq(CONTRADICTS) | ledger["limit_verdict"].eq(CONTRADICTS)
    return ledger["topic"].mask(contradicted, CONTRADICTED)


def counts(ledger: pd.DataFrame) -> str:
    """Say how many entries have each verdict."""
    parts = [
        f"{model} model: {', '.join(f'{number} {verdict}' for verdict, number in numbers.items() if number)}"
        for model, numbers in tally(ledger).items()
    ]
    return f"{len(ledger)} entries. {'; '.join(parts)}"


def literature_text(ledger: pd.DataFrame) -> str:
    """Write the ledger for a terminal: topic by topic, and below each table why."""
    parts = []
    for topic, rows in ledger.groupby(topics(ledger), sort=False):
        shown = pd.DataFrame({"entry": rows["row_id"], "published": rows["published"], "unit": rows["unit"]})
        for model in MODELS:
            shown[model] = rows[model]
            shown[f"{model}: verdict"] = rows[f"{model}_verdict"]
        shown["sure"] = rows["sure"]
        notes = tuple(f"{row.row_id}: {row.says} ({row.source}). {row.why}" for row in rows.itertuples())
        parts.append(Table(str(topic), shown, {}, notes).text())
    return "\n\n".join([*parts, counts(ledger)])


def literature_markdown(ledger: pd.DataFrame) -> str:
    """Write the ledger as Markdown, one table a topic."""
    parts = [f"{counts(ledger)}."]
    for topic, rows in ledger.groupby(topics(ledger), sort=False):
        shown = pd.DataFrame(
            {
                "published": [f"{row.says}: {_with_unit(row)}" for row in rows.itertuples()],
                "accepted": [_accepted(row) for row in rows.itertuples()],
                **{
                    f"{model} model": [
                        _cell(values, verdict)
                        for values, verdict in zip(rows[model], rows[f"{model}_verdict"], strict=True)
                    ]
                    for model in MODELS
                },
                "source": [f"{row.source} ({row.sure})" for row in rows.itertuples()],
                "why": rows["why"],
            }
        )
        lines = Table(str(topic), shown).markdown().splitlines()[2:]
        parts.append("\n".join([f"## {topic}", "", *lines]))
    return true_minus("\n\n".join(parts))


def _with_unit(row: Any) -> str:
    return f"{row.published} {row.unit}".strip() if row.published else "no number"


def _accepted(row: Any) -> str:
    low, high = row.accepted_low, row.accepted_high
    if math.isnan(low):
        return "" if math.isnan(high) else f"at most {high:g}"
    return f"at least {low:g}" if math.isnan(high) else f"{low:g} to {high:g}"


def _cell(values: str, verdict: str) -> str:
    if verdict == CANNOT_FACE:
        return verdict
    return f"{values}: {verdict}" if verdict in (HOLDS, SAME_SIGN) else f"{values}: **{verdict}**"
