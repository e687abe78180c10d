"""The best speeds of a bird alone and in flocks, for a person."""

from __future__ import annotations

import pandas as pd

from upwash.report.table import Table
from upwash.report.words import least
from upwash.study.best_speed import ALONE, FLOCK, FOLLOWER

WORDS = {"least-power": "Least power", "least-transport": "Least energy per distance (most range)"}


def speed_answer(rows: pd.DataFrame) -> str:
    """Say how fast a bird does best alone, behind another, and in flocks.

    Parameters
    ----------
    rows : DataFrame
        As `upwash.study.best_speed.best_speeds` returns.
    """
    first = rows.iloc[0]
    stroke = f"amplitude by {first['amplitude_convention']}"
    head = f"{first['species']}, {least(first['objective'])} at each speed; {stroke}"
    parts = [head]
    for criterion, group in rows.groupby("criterion", sort=False):
        parts += ["", speed_table(group, WORDS[str(criterion)]).text(), *_remarks(group)]
    return "\n".join(parts)


def speed_table(rows: pd.DataFrame, title: str = "") -> Table:
    """Return the table of one criterion."""
    frame = pd.DataFrame(
        {
            "flies": [_who(row) for _, row in rows.iterrows()],
            "speed m/s": rows["speed_m_s"].astype(float),
            "of alone": rows["speed_ratio"].astype(float),
            "power W": rows["power_w"].astype(float),
            "mean W": rows["power_mean_w"].astype(float),
            "J/m": rows["transport_j_m"].astype(float),
            "range of alone": rows["range_ratio"].astype(float),
            "saves %": 100.0 * rows["saving"].astype(float),
            "slope": [_slope(row) for _, row in rows.iterrows()],
            "proved": [_proof(row) for _, row in rows.iterrows()],
        }
    )
    formats = {
        "speed m/s": ".2f",
        "of alone": ".3f",
        "power W": ".3f",
        "mean W": ".3f",
        "J/m": ".4f",
        "range of alone": ".3f",
        "saves %": ".1f",
    }
    notes = (
        "power: of the lone bird, the follower, the first bird (no turns) or the mean (turns); mean: of all birds",
        "saves: against a lone bird at the same speed; proved: each follower's place there is the best of the V",
    )
    return Table(title, frame, formats, notes)


def _who(row: pd.Series) -> str:
    if row["who"] == ALONE:
        return "alone"
    if row["who"] == FOLLOWER:
        return "behind one other"
    assert row["who"] == FLOCK
    return f"flock of {row['birds']}, {'taking turns' if row['turns'] else 'no turns'}"


def _proof(row: pd.Series) -> str:
    if row["error"] or row["who"] == ALONE:
        return "-"
    return "yes" if row["proved"] else "open"


def _slope(row: pd.Series) -> str:
    if row["error"]:
        return "-"
    return "held" if row["bound"] else "0"


def _remarks(rows: pd.DataFrame) -> list[str]:
    """Say what holds a speed, and why there is none."""
    found = []
    for _, row in rows.iterrows():
        if row["error"]:
            found.append(f"{_who(row)}: {row['error']}")
        elif row["bound"]:
            found.append(f"{_who(row)}, held at {row['speed_m_s']:.2f} m/s: {row['bound']}")
    return found
