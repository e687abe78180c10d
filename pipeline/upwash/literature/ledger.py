"""The ledger of the literature: each published number beside both models, with a verdict and how sure the number is.

The entries stand in ``literature.csv``, one a line.  An entry that is an observation of ``species/observations.csv``
names it, and takes number, unit and source from there.  Three kinds are judged: a *number* holds if ours lies from
`low` to `high`, which may be no wider than the effect itself; of a *sign* only the side of zero counts; and what is
*outside* both models is a row that says so.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import pandas as pd

from upwash.columns import TEXT, Column
from upwash.errors import UpwashError
from upwash.literature import of_birds, of_wings
from upwash.literature.models import Cases
from upwash.literature.of_birds import Measured
from upwash.shipped import shipped
from upwash.study.observations import read_observations

HOLDS, CONDITION, FAILS = "holds", "holds with a condition", "fails"
SAME_SIGN, CONTRADICTS = "same sign", "contradicts"
SAYS_LITTLE, CANNOT_FACE = "says little", "cannot face"
VERDICTS = {
    CONTRADICTS: "the model says the opposite: another sign in every case",
    FAILS: "no case of ours is near the published number",
    CONDITION: "some cases are, and others not",
    HOLDS: "every case is",
    SAME_SIGN: "only a direction was published, and ours is the same",
    SAYS_LITTLE: "ours is within what was published, which is wider than the effect",
    CANNOT_FACE: "the model has nothing that could be compared",
}
"""Verdict -> what it means, from worst to least."""

NUMBER, SIGN, OUTSIDE = "number", "sign", "outside"
MODELS = ("paper", "limit")

KEPT = shipped("results/reference/literature.csv")
"""The ledger as it was judged last; a test judges it anew."""

SURE = {"original": "read", "quoted": "quoted", "recalled": "recalled"}
"""How a publication was read, in the table of observations -> how sure its number is."""

LEDGER_COLUMNS = (
    Column("row_id", "", "name of the entry", TEXT),
    Column("topic", "", "what it is about", TEXT),
    Column("says", "", "what was published, in few words of ours", TEXT),
    Column("published", "", "the number as it was published", TEXT),
    Column("unit", "", "unit of all values; empty for a pure number", TEXT),
    Column("accepted_low", "as in unit", "least value of ours that is as published; absent if there is none"),
    Column("accepted_high", "as in unit", "largest such value; absent if there is none"),
    Column("paper", "", "our values by the paper's model, case by case, semicolon separated", TEXT),
    Column("paper_verdict", "", "verdict on the paper's model", TEXT),
    Column("limit", "", "our values in the limit model, case by case, semicolon separated", TEXT),
    Column("limit_verdict", "", "verdict on the limit model", TEXT),
    Column("source", "", "who published it", TEXT),
    Column("sure", "", "how sure the number is: read, quoted, recalled, derived or computed", TEXT),
    Column("why", "", "one line of why", TEXT),
)
"""Columns of the ledger."""


@dataclass(frozen=True)
class Entry:
    """One published number.

    Attributes
    ----------
    row_id, topic, says, published, unit, source, sure, why : str
        As the columns of the ledger.
    kind : str
        ``number``, ``sign`` or ``outside``.
    low, high : float
        Values of ours that are as published; infinite where a side is open.
    effect : float
        How large the effect is, in the entry's unit: what there would be to see if there were none. Not a number where
        no number is judged.
    measure : str
        What is measured: a name in the modules' `MEASURES`, or ``QUANTITY of SPECIES``.
    observation : str
        The observation that it is; empty if it is none.
    """

    row_id: str
    topic: str
    says: str
    published: str
    unit: str
    source: str
    sure: str
    why: str
    kind: str
    low: float
    high: float
    effect: float
    measure: str
    observation: str

    def measured(self) -> Measured:
        """Return our values: model -> case -> value."""
        if self.kind == OUTSIDE:
            return {model: {} for model in MODELS}
        for module in (of_wings, of_birds):
            if self.measure in module.MEASURES:
                return module.MEASURES[self.measure]()
        quantity, _, species = self.measure.rpartition(" of ")
        return of_birds.of_v(quantity, species)

    def verdict(self, cases: Cases) -> str:
        """Judge a model by its values in each case."""
        if not cases:
            return CANNOT_FACE
        fits = [self.low <= value <= self.high for value in cases.values()]
        if self.kind == SIGN:
            return SAME_SIGN if all(fits) else CONDITION if any(fits) else CONTRADICTS
        if not any(fits):
            return FAILS
        if self.high - self.low > self.effect:
            return SAYS_LITTLE
        return HOLDS if all(fits) else CONDITION


def observation_names(observations: pd.DataFrame) -> list[str]:
    """Return a name for each observation: study, species and quantity, and which of several."""
    names: list[str] = []
    for row in observations.to_dict("records"):
        name = f"{row['label']}, {row['species'] or '-'}, {row['quantity']}"
        count = 1 + sum(known.partition(" #")[0] == name for known in names)
        names.append(name if count == 1 else f"{name} #{count}")
    return names


def _published(row: Mapping[str, Any]) -> str:
    """Write a published number, range or bound."""
    value, low, high = row["value"], row["low"], row["high"]
    if not math.isnan(value):
        return f"{value:g}"
    if math.isnan(low) and math.isnan(high):
        return ""
    if math.isnan(low):
        return f"at most {high:g}"
    return f"at least {low:g}" if math.isnan(high) else f"{low:g} to {high:g}"


def read_entries() -> list[Entry]:
    """Return the entries in the order of the table."""
    observations = read_observations()
    named: dict[str, Any] = dict(
        zip(observation_names(observations), observations.to_dict("records"), strict=True)
    )
    text = (files("upwash.literature") / "literature.csv").read_text(encoding="utf-8")
    entries = []
    for line in csv.DictReader(text.splitlines()):
        said: dict[str, Any] = dict(line)
        if line["observation"]:
            row = named[line["observation"]]
            said |= {"published": _published(row) or line["published"], "unit": row["unit"].removesuffix("1")}
            said |= {"source": row["study"], "sure": SURE[row["read"]]}
        numbers: dict[str, Any] = {
            "low": float(said.pop("low") or -math.inf),
            "high": float(said.pop("high") or math.inf),
            "effect": float(said.pop("effect") or math.nan),
        }
        entries.append(Entry(**said, **numbers))
    return entries


def judge_literature() -> pd.DataFrame:
    """Measure both models and judge each entry.

    Returns
    -------
    DataFrame
        The columns of `LEDGER_COLUMNS`: what is contradicted first, then in the order of the table.
    """
    rows = [_row(entry) for entry in read_entries()]
    return _contradictions_first(rows)


def _contradictions_first(rows: list[dict[str, object]]) -> pd.DataFrame:
    first = [row for row in rows if CONTRADICTS in (row["paper_verdict"], row["limit_verdict"])]
    rest = [row for row in rows if row not in first]
    return pd.DataFrame([*first, *rest], columns=[column.name for column in LEDGER_COLUMNS])


def read_kept() -> pd.DataFrame:
    """Return the ledger that comes with the package, as it was judged last.

    Raises
    ------
    UpwashError
        If it is not there.
    """
    texts = {column.name: str for column in LEDGER_COLUMNS if column.type == TEXT}
    numbers = [column.name for column in LEDGER_COLUMNS if column.type != TEXT]
    try:
        return pd.read_csv(KEPT, dtype=texts, keep_default_na=False, na_values=dict.fromkeys(numbers, ""))
    except OSError as error:
        raise UpwashError(
            f"{KEPT}: expected the kept ledger of the literature, found no such file; judge it anew (--fresh), or "
            "install Upwash again"
        ) from error


def _row(entry: Entry) -> dict[str, object]:
    measured = entry.measured()
    row: dict[str, object] = {
        name: getattr(entry, name)
        for name in ("row_id", "topic", "says", "published", "unit", "source", "sure", "why")
    }
    row["accepted_low"] = entry.low if math.isfinite(entry.low) and entry.kind != OUTSIDE else None
    row["accepted_high"] = entry.high if math.isfinite(entry.high) and entry.kind != OUTSIDE else None
    for model in MODELS:
        cases = measured[model]
        row[model] = "; ".join(f"{case} {_number(value)}" for case, value in cases.items())
        row[f"{model}_verdict"] = entry.verdict(cases)
    return row


def _number(value: float) -> str:
    # Two digits more would tell of the search and not of the model.
    return f"{0.0 if abs(value) < 5e-4 else value:.3g}" if math.isfinite(value) else "no V"


def records(ledger: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the ledger as dictionaries, one an entry; what is absent is None."""
    values = ledger.astype(object).where(ledger.notna(), None)
    return [dict(zip(ledger.columns, row, strict=True)) for row in values.itertuples(index=False, name=None)]


def tally(ledger: pd.DataFrame) -> dict[str, dict[str, int]]:
    """Return how many entries have each verdict: model -> verdict -> number."""
    return {
        model: {verdict: int((ledger[f"{model}_verdict"] == verdict).sum()) for verdict in VERDICTS}
        for model in MODELS
    }
