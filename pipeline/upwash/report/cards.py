"""The paper's claims as the page shows them: those that fail as cards, all of them in a table."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pandas as pd

from upwash.paper.claim import FAILS, HOLDS
from upwash.report.claims import counts, ledger_shown
from upwash.report.switches import LIMIT, PAPER
from upwash.report.table import Table
from upwash.report.words import true_minus

MOST_CARDS = 6
"""More cards than these are folded away."""


TOPICS = (
    "The search",
    "Power and stroke",
    "Where the follower flies",
    "The flock",
    "The wake's force",
    "The airspeed of a group",
)
"""Topics whose cards come first; the others follow as they stand in the ledger."""


def claims_shown(
    ledger: pd.DataFrame | None, as_table: Callable[[Table, str], dict[str, Any]]
) -> dict[str, Any] | None:
    """Return the claims as the page takes them: counts, cards for each model, and the table; None if not judged.

    Parameters
    ----------
    ledger : DataFrame or None
        As `upwash.paper.ledger.judge_claims` returns.
    as_table : callable
        Table and its name -> the table as the page takes it.
    """
    if ledger is None:
        return None
    order = {topic: number for number, topic in enumerate(TOPICS)}
    ranks = ledger["topic"].map(order).fillna(len(order))
    weighty = ledger.loc[ranks.sort_values(kind="stable").index]
    in_paper = weighty[weighty["verdict"] == FAILS]
    lost = weighty[(weighty["limit_verdict"] == FAILS) & (weighty["verdict"] != FAILS)]
    return {
        "counts": counts(ledger),
        "groups": [
            _group(
                PAPER,
                "fail in the paper's own model",
                [_card(row, "") for row in in_paper.to_dict("records")],
            ),
            _group(
                LIMIT,
                "fail in the limit, though not in the paper's own model",
                [_card(row, "limit_") for row in lost.to_dict("records")],
            ),
        ],
        "holds": int((ledger["verdict"] == HOLDS).sum()),
        "count": len(ledger),
        "table": as_table(Table("Each claim of the paper, and our verdict", ledger_shown(ledger)), "claims"),
    }


def _group(model: str, words: str, cards: list[dict[str, str]]) -> dict[str, Any]:
    return {
        "model": model,
        "words": words,
        "shown": cards[:MOST_CARDS],
        "folded": cards[MOST_CARDS:],
        "count": len(cards),
    }


def _card(row: dict[Any, Any], prefix: str) -> dict[str, str]:
    """Return what a card says: the claim, what is printed, and what we find instead and why."""
    unit = f" {row['unit']}" if row["unit"] else ""
    ours = f"{row[f'{prefix}cases']}{unit}" if row[f"{prefix}cases"] else ""
    printed = f"{row['printed']}{unit if re.search(r'[0-9]$', row['printed']) else ''}"
    return {
        "claim": str(row["claim"]),
        "place": str(row["place"]),
        "printed": true_minus(printed),
        "ours": true_minus(ours),
        "why": str(row[f"{prefix}why"]),
    }
