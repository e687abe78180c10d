"""The paper beside ours: what it prints, and its claims, each judged by our numbers, with the reason why.

A claim is an entry in a table: where it stands, what it says, which values of ours would make it true, and the
function that measures ours.  The modules ``of_…`` hold the entries, `ledger` puts the judgements into one frame.

The names below load when they are first used: what the paper prints can be told without the libraries that judge it.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from upwash.paper.claim import FAILS, HOLDS, HOLDS_WITH_CONDITION, NOT_RUN, Claim, judge
    from upwash.paper.evidence import Evidence, gather_evidence, read_evidence
    from upwash.paper.ledger import CLAIM_COLUMNS, CLAIMS, judge_claims

__all__ = [
    "CLAIMS",
    "CLAIM_COLUMNS",
    "FAILS",
    "HOLDS",
    "HOLDS_WITH_CONDITION",
    "NOT_RUN",
    "Claim",
    "Evidence",
    "gather_evidence",
    "judge",
    "judge_claims",
    "read_evidence",
]

_HOME = {
    "claim": ("FAILS", "HOLDS", "HOLDS_WITH_CONDITION", "NOT_RUN", "Claim", "judge"),
    "evidence": ("Evidence", "gather_evidence", "read_evidence"),
    "ledger": ("CLAIMS", "CLAIM_COLUMNS", "judge_claims"),
}


def __getattr__(name: str) -> Any:
    """Import a public name from the module it lives in, on first use."""
    for module, names in _HOME.items():
        if name in names:
            return getattr(import_module(f"upwash.paper.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
