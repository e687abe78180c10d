"""What observed birds save, told to a person: a table of the first rows and a summary of all."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from upwash.report.table import Table, shown
from upwash.study.observed.tally import EvaluationTally
from upwash.study.told import EVALUATION, INVALID, LEADING, NO_BALANCE, PAYS, SAVES

ROWS_SHOWN = 20
"""Rows that are printed; the rest is told of."""

# Of the table's own columns those that name a bird, and then the first.
_OWN_SHOWN, _OWN_FIRST = 3, ("id", "time", "bird")
_SHOWN = (
    "leader",
    "x_m",
    "y_m",
    "z_m",
    "phase",
    "outcome",
    "saving_total",
    "saving_total_low",
    "saving_total_high",
    "saving_mean_phase",
    "saving_worst_phase",
    "amplitude_to_alone",
    "reason",
)


def first_rows(told: pd.DataFrame, title: str) -> str:
    """Return the first rows of what was evaluated as a table."""
    rows = told.head(ROWS_SHOWN)
    names = {column.name for column in EVALUATION}
    others = [name for name in rows if name not in names]
    own = sorted(others, key=lambda name: name not in _OWN_FIRST)[:_OWN_SHOWN]
    ours = {one.name: one for one in EVALUATION if one.name in rows and rows[one.name].notna().any()}
    columns = [ours[name] for name in _SHOWN if name in ours]
    values, formats = shown(rows, columns)
    own_values: dict[str, pd.Series] = {str(name): rows[name] for name in own}
    frame = pd.DataFrame(own_values | values)
    frame = frame.astype(object).where(frame.notna(), None)
    return Table(title, frame, formats | {"x m": ".2f", "y m": ".2f", "z m": "+.2f", "κ": ".2f"}).text()


def summary(tally: EvaluationTally) -> str:
    """Return in a line or two what all birds come to."""
    counts = tally.outcomes
    found = [f"{counts[SAVES]} of {counts[SAVES] + counts[PAYS] + counts[NO_BALANCE]} followers save"]
    if counts[PAYS]:
        found.append(f"{counts[PAYS]} pay")
    if counts[NO_BALANCE]:
        found.append(f"{counts[NO_BALANCE]} cannot balance")
    if not math.isnan(tally.median_saving()):
        found.append(f"median saving {100.0 * tally.median_saving():.1f} %")
    if not math.isnan(tally.median_share()):
        found.append(f"{100.0 * tally.median_share():.0f} % of what the V optimum saves")
    if counts[LEADING]:
        found.append(f"{counts[LEADING]} lead")
    if counts[INVALID]:
        found.append(f"{counts[INVALID]} rows cannot be used (first: {tally.first_fault})")
    lines = ["; ".join(found) + "."]
    count, mean, concentration, p = tally.phase_statistics()
    if count > 1:
        chance = f"p = {p:.2g}" if p >= 1e-4 else "p < 0.0001"
        lines.append(
            f"Spatial phase of the {count} whose phase is given: mean {mean:+.3f} wingbeats, concentration "
            f"{concentration:.2f}, Rayleigh {chance}."
        )
    return "\n".join(lines)


def records(told: pd.DataFrame) -> list[dict[str, Any]]:
    """Return rows as dictionaries fit for JSON."""
    return Table("", told).records()
