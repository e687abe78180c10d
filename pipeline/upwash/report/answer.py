"""The answer to a single problem: for a person sentences and tables, for a program one record."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from math import inf, isfinite
from typing import Any

import pandas as pd

from upwash import columns as of
from upwash.optimum.problem import ASTERN
from upwash.optimum.proof import OPEN, PROVED, claims_of, wall_in_words
from upwash.report.table import ABSENT, Table
from upwash.report.tables import GLOBAL, V, basins, best_optima, both_optima
from upwash.report.words import least, percent
from upwash.study.limit_ranges import LimitRange

OF_THE_JOB = of.names(
    of.belonging(of.OUTCOME, of.PROBLEM, of.AHEAD, of.AHEAD_STROKE, of.SEARCH, of.EFFORT, of.PROOF)
)
OF_AN_OPTIMUM = of.names(of.belonging(of.JOB, of.OPTIMUM))


def answer(rows: pd.DataFrame, show_all: bool = False, ranges: Sequence[LimitRange] = ()) -> str:
    """Say where one bird should fly behind another.

    Parameters
    ----------
    rows : DataFrame
        All rows of one job, best first.
    show_all : bool
        Whether to list every optimum.
    ranges : sequence of LimitRange
        Behind an endless wake, what is saved by each span law.
    """
    first = rows.iloc[0]
    if first["status"] != of.SOLVED:
        return f"{first['species']}, {least(first['objective'])}: {_nothing_found(first)}"
    parts = [both_optima(rows).text()]
    if V not in best_optima(rows):
        parts.append(_no_v_optimum(first))
    if ranges:
        label = V if V in best_optima(rows) else GLOBAL
        parts.append(ranges_table(ranges, label, first["objective"]).text())
    if show_all:
        parts.append(basins(rows).text())
    return "\n\n".join(parts)


def _nothing_found(row: Any) -> str:
    """Say that there is no follower, and whether that is proved."""
    proved = {PROVED: " (this is proved)", OPEN: " (open: none was found, which is no proof)"}
    return f"no optimum: {of.reason_of(row['error'])}{proved.get(claims_of(row).everywhere, '')}"


def _no_v_optimum(row: Any) -> str:
    """Say that no optimum is outboard, level and astern, and what is known of that region instead."""
    if row["wavelengths"] == inf and row["x_m"] < ASTERN * row["semispan_m"]:
        known = f"{row['x_m']:.3g} m behind, which was asked for, is not astern"
    elif claims_of(row).v_region == PROVED and pd.isna(row["v_lower_bound"]):
        known = "no position of that kind balances lift and thrust, which is proved"
    elif row["v_wall"]:
        known = f"a follower in the V does best {wall_in_words(row['v_wall'])}, and better still beyond"
    else:
        known = "none was found, which is no proof"
    return f"There is no {V}, outboard, level and astern: {known}. The {GLOBAL} is the best of all."


def ranges_table(ranges: Sequence[LimitRange], label: str, objective: str) -> Table:
    """Put beside each other what is saved by each span law, with the intervals of the species' own ranges.

    Parameters
    ----------
    ranges : sequence of LimitRange
        One for each span law.
    label : str
        Of which optimum.
    objective : str
        The objective.
    """
    kinds = {"total": "total power"} | ({} if objective == "power" else {"cost": objective.replace("_", " ")})
    frame = pd.DataFrame({"span law": [one.span_law for one in ranges]})
    for name, words in kinds.items():
        values = [[getattr(one, f"saving_{name}{end}") for one in ranges] for end in ("", "_low", "_high")]
        frame[f"{words} saved"] = [percent(value, 1) if isfinite(value) else ABSENT for value in values[0]]
        frame[f"5 % to 95 % of the birds ({words})"] = [
            f"{percent(low, 1)} to {percent(high, 1)}" if isfinite(low) else ABSENT
            for low, high in zip(values[1], values[2], strict=True)
        ]
    samples, without = ranges[0].samples, [f"{one.samples_without} ({one.span_law})" for one in ranges]
    notes = [f"birds: {samples} sampled from the species' own ranges; found by descents, which prove nothing"]
    if any(one.samples_without for one in ranges):
        notes.append(f"without a {label}: {', '.join(without)}")
    notes.append("nothing yet decides between the two laws of the follower's span")
    return Table(f"How sure that is: saving at the {label}", frame, notes=tuple(notes))


def job_record(rows: Sequence[dict[str, Any]], ranges: Sequence[LimitRange] = ()) -> dict[str, Any]:
    """Return all that is known of one job as one dictionary fit for JSON.

    Parameters
    ----------
    rows : sequence of dict
        All rows of the job, best first, by the columns of ``solutions.parquet``.
    ranges : sequence of LimitRange
        Behind an endless wake, what is saved by each span law.

    Returns
    -------
    dict
        What is true of the job by column, under ``optima`` the columns of each optimum, and under ``ranges``, if there
        are any, the saving by each span law with its interval.
    """
    rows = [of.told(row) for row in rows]
    optima = [{name: row[name] for name in OF_AN_OPTIMUM} for row in rows if row["rank"] is not None]
    said = {**{name: rows[0][name] for name in OF_THE_JOB}, "optima": optima}
    told = [
        {
            name: None if isinstance(value, float) and not isfinite(value) else value
            for name, value in asdict(one).items()
        }
        for one in ranges
    ]
    return said | ({"ranges": told} if told else {})
