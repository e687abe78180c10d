"""The paper beside ours: what it prints, and its claims, each judged by our numbers, with the reason why.

A claim is an entry in a table: where it stands, what it says, which values of ours would make it true, and the
function that measures ours.  The modules ``of_…`` hold the entries, `ledger` puts the judgements into one frame.
"""

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
