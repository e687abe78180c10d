"""Renew the verdicts on the paper's claims: results/reference/claims.csv, docs/claims.md that shows them, and the
README's count of them.

``make reference`` does it, after a change that is meant to change results or claims. A changed verdict shows in the
diff of claims.csv; the tests compare fresh verdicts with it.
"""

import re
from pathlib import Path

import pandas as pd
from upwash.columns import FLOAT
from upwash.jobs.run import run_job
from upwash.jobs.schema import table_of
from upwash.paper import CLAIM_COLUMNS, gather_evidence, judge_claims
from upwash.paper.evidence import FLOCKS, LIMIT, SPEEDS
from upwash.paper.ledger import NOISE
from upwash.report.claims import counts, ledger_markdown
from upwash.sweep import read_sweep

ROOT = Path(__file__).parents[1]
LEDGER = ROOT / "results" / "reference" / "claims.csv"
PAGE = ROOT / "docs" / "claims.md"
README = ROOT / "README.md"
COUNTS = re.compile(r"\d+ claims:[^;]*; in the limit:[^;]*")

SWEEPS = ("reproduce", FLOCKS, SPEEDS, LIMIT)
NUMBERS = [column.name for column in CLAIM_COLUMNS if column.type == FLOAT]

HEAD = """\
# The paper's claims, judged

Every claim of the paper that can be put as a number, beside ours. A claim is measured in one case or in
several, such as for both cost functions (**force**, **power**) or both readings of the flock's amplitude
bound (**immediate**, **lone**; see [flocks](model.md#flocks)). It **holds** if every case is among the
accepted values, **fails** if none is, and otherwise **holds with a condition**; values that are not as
claimed are bold. Where the paper gives a figure, the accepted values are that figure within a tolerance:
1.5 % for the follower in Table 1, a percentage point for savings and reductions, and half of the last
printed digit for what follows from the inputs alone. Where it gives a word, the accepted values are our
reading of it, so that everyone can disagree with it.

The last column says what becomes of a claim where the paper's equations are converged, in [the limit](limit.md): judged
by the same accepted values, for both laws of the follower's span (**stroke** and **tip law**). What a claim is about
may not exist there, and then it **has no meaning**: behind an endless wake no distance is better than another, and a
wing that moves all the time is in no state. Least force has no V optimum there, so that a claim on its place **fails**;
`-` stands for the value that is missing. What needs flocks or airspeeds is **not judged** there.

`upwash claims results/reproduce` judges them anew from stored results, prints the ledger and keeps it as
`claims.parquet` beside them. Claims on flocks, on airspeed and in the limit need the sweeps `paper-flocks`,
`group-speed` and `limit` to have been run and aggregated as well. This page and `results/reference/claims.csv` come
from `make reference`; a test fails when a verdict is no longer the one shown here.
"""


def solved(sweep: str) -> pd.DataFrame:
    """Solve the jobs of a sweep in this process and return their rows."""
    jobs = read_sweep(sweep).jobs
    return table_of([row for job in jobs for row in run_job(job).rows], jobs[0].kind.rows).to_pandas()


def as_csv(ledger: pd.DataFrame) -> str:
    """Write a ledger as CSV, numbers to six digits."""
    rounded = {name: [_rounded(value) for value in ledger[name]] for name in NUMBERS}
    return ledger.assign(**rounded).to_csv(index=False, lineterminator="\n")


def _rounded(value: float | None) -> str:
    return "" if pd.isna(value) else f"{0.0 if abs(value) < NOISE else value:.6g}"


def kept() -> pd.DataFrame:
    """Return the ledger that is kept."""
    texts = {column.name: str for column in CLAIM_COLUMNS if column.type != FLOAT}
    return pd.read_csv(LEDGER, dtype=texts, keep_default_na=False, na_values=dict.fromkeys(NUMBERS, ""))


def page() -> str:
    """Return the page that shows the kept ledger."""
    return f"{HEAD}\n{ledger_markdown(kept())}\n"


def main() -> None:
    """Solve, judge, and keep what comes of it."""
    ledger = judge_claims(gather_evidence([solved(sweep) for sweep in SWEEPS]))
    LEDGER.write_text(as_csv(ledger), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")
    text = README.read_text(encoding="utf-8")
    README.write_text(COUNTS.sub(counts(ledger), text), encoding="utf-8")


if __name__ == "__main__":
    main()
