"""The ledger: every claim judged, as a frame and as a Parquet file."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pandas as pd

from upwash.batch.store import encode, provenance, write_atomic
from upwash.columns import TEXT, Column
from upwash.jobs.schema import schema_of
from upwash.paper import (
    of_flock,
    of_forces,
    of_limit,
    of_lone_bird,
    of_optimum,
    of_power,
    of_print,
    of_search,
    of_speed,
    of_table_1,
)
from upwash.paper.claim import (
    LIMIT_VERDICTS,
    VERDICTS,
    Cases,
    Claim,
    Judgement,
    judge,
    judge_in_limit,
    read_claim,
)
from upwash.paper.evidence import Evidence
from upwash.paper.printed import SAID
from upwash.study.sources import CLAIMS as CLAIMS_FILE

OF = (of_table_1, of_lone_bird, of_optimum, of_search, of_forces, of_power, of_flock, of_speed, of_print)
MEASURES = {name: measure for module in OF for name, measure in module.MEASURES.items()}
FACTS = {name: facts for module in OF for name, facts in getattr(module, "FACTS", {}).items()}

CLAIMS = tuple(
    read_claim(said, MEASURES[name], FACTS.get(name), of_limit.MEASURES.get(name))
    for name, said in SAID.items()
)
"""The claims in the order of the ledger."""

CLAIM_COLUMNS = (
    Column("claim_id", "", "name of the claim", TEXT),
    Column("topic", "", "what it is about", TEXT),
    Column("place", "", "where it stands in the paper", TEXT),
    Column("claim", "", "what it says, in few words of ours", TEXT),
    Column("printed", "", "printed value or phrase", TEXT),
    Column("ours", "as in unit", "our value in the first case; absent if not run"),
    Column("unit", "", "unit of our values; empty for a pure number", TEXT),
    Column(
        "tolerance",
        "as in unit",
        "how far beyond the printed value ours may lie; absent where only a limit counts",
    ),
    Column(
        "accepted_low", "as in unit", "least value of ours that makes the claim true; absent if there is none"
    ),
    Column("accepted_high", "as in unit", "largest such value; absent if there is none"),
    Column("cases", "", "our value in each case that was looked at, semicolon separated", TEXT),
    Column("exceptions", "", "cases that are not as claimed, semicolon separated", TEXT),
    Column("verdict", "", ", ".join(VERDICTS), TEXT),
    Column("why", "", "one line of why", TEXT),
    Column("limit_cases", "", "our value in each case in the limit, semicolon separated", TEXT),
    Column("limit_exceptions", "", "those cases that are not as claimed, semicolon separated", TEXT),
    Column("limit_verdict", "", "in the limit: " + ", ".join(LIMIT_VERDICTS), TEXT),
    Column("limit_why", "", "one line of why in the limit, where that is not plain", TEXT),
)
"""Columns of ``claims.parquet``."""

FILE = CLAIMS_FILE

NUMBER = ".4g"
NOISE = 1e-9
"""Numbers smaller than this are an imbalance of the search, and written as zero."""

LIMIT_NOISE = 1e-6
"""The same in the limit, where the V optimum lies on a plane of symmetry and is found beside it."""


def judge_claims(evidence: Evidence) -> pd.DataFrame:
    """Judge every claim.

    Returns
    -------
    DataFrame
        The columns of `CLAIM_COLUMNS`, one row a claim, in the order of the ledger.
    """
    rows = [_row(judge(claim, evidence), in_limit(claim, evidence)) for claim in CLAIMS]
    return pd.DataFrame(rows, columns=[column.name for column in CLAIM_COLUMNS])


def in_limit(claim: Claim, evidence: Evidence) -> Judgement:
    """Judge a claim in the limit."""
    return judge_in_limit(claim, evidence, of_limit.ABOUT)


def _row(judged: Judgement, limit: Judgement) -> dict[str, object]:
    claim, accepted = judged.claim, judged.claim.accepted
    has_width = math.isfinite(accepted.low) and math.isfinite(accepted.high)
    return {
        "claim_id": claim.name,
        "topic": claim.topic,
        "place": claim.place,
        "claim": claim.says,
        "printed": claim.printed,
        "ours": next(iter(judged.cases.values()), None),
        "unit": claim.unit,
        "tolerance": accepted.tolerance if has_width else None,
        "accepted_low": accepted.least if math.isfinite(accepted.low) else None,
        "accepted_high": accepted.most if math.isfinite(accepted.high) else None,
        "cases": _written(judged.cases),
        "exceptions": BETWEEN.join(judged.exceptions),
        "verdict": judged.verdict,
        "why": judged.why,
        "limit_cases": _written(limit.cases, LIMIT_NOISE),
        "limit_exceptions": BETWEEN.join(limit.exceptions),
        "limit_verdict": limit.verdict,
        "limit_why": limit.why,
    }


BETWEEN = "; "
"""What stands between the cases of a row: a ledger is a table of texts, which `cases_in` takes apart again."""


def _written(cases: Cases, noise: float = NOISE) -> str:
    return BETWEEN.join(f"{case} {_number(value, noise)}" for case, value in cases.items())


def cases_in(cases: str, exceptions: str) -> list[tuple[str, bool]]:
    """Return each case of a row with its value, as it is written there, and whether it is not as claimed.

    Examples
    --------
    >>> cases_in("force 1.2; power 3.4", "power")
    [('force 1.2', False), ('power 3.4', True)]
    """
    unlike = exceptions.split(BETWEEN)
    return [(case, case.rpartition(" ")[0] in unlike) for case in cases.split(BETWEEN) if case]


def _number(value: float, noise: float) -> str:
    return format(0.0 if abs(value) < noise else float(value), NUMBER) if math.isfinite(value) else "-"


def write_claims(ledger: pd.DataFrame, folder: str | Path, sweep_text: str = "") -> Path:
    """Write the ledger as ``claims.parquet`` into a folder, whole or not at all.

    Parameters
    ----------
    ledger : DataFrame
        As `judge_claims` returns.
    folder : str or path
        The folder.
    sweep_text : str
        Text of the sweep whose results were judged, for the file's metadata.
    """
    path = Path(folder) / FILE
    write_atomic(path, encode(ledger_records(ledger), schema_of(CLAIM_COLUMNS), provenance(sweep_text)))
    return path


def ledger_records(ledger: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the ledger as dictionaries, one a claim; what is absent is None."""
    values = ledger.astype(object).where(ledger.notna(), None)
    return [dict(zip(ledger.columns, row, strict=True)) for row in values.itertuples(index=False, name=None)]


def tally(ledger: pd.DataFrame, column: str = "verdict") -> dict[str, int]:
    """Return how many claims have each verdict, or with ``limit_verdict`` each verdict in the limit."""
    verdicts = LIMIT_VERDICTS if column == "limit_verdict" else VERDICTS
    return {verdict: int((ledger[column] == verdict).sum()) for verdict in verdicts}
