"""The answer to a single flock: for a person tables, for a program one record."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import pandas as pd

from upwash import columns as of
from upwash.optimum.proof import OPEN, PROVED, is_proved
from upwash.optimum.rotation import take_turns
from upwash.report.table import ABSENT, Table, shown
from upwash.report.words import least, length_of_wake, model_in_words, power_of_ten

READINGS = {
    "immediate": "amplitude at most that of the bird ahead",
    "lone": "amplitude at most a lone bird's",
}
WAKES = {"neighbour": "the wake of the bird ahead", "all-upstream": "the wakes of all birds ahead"}

INPUTS = of.names(of.belonging(of.PROBLEM, of.SEARCH, of.FLOCK))
"""What is asked of a flock."""


OF_A_BIRD = tuple(
    column
    for column in of.FLOCK_COLUMNS
    if (column.belongs == of.BIRD and column.head)
    or (column.verified == of.FOUND and column.absent == of.NEVER)
)
"""Where a bird flies in its flock, and its stroke."""

SAVINGS = sorted(
    (column for column in of.FLOCK_COLUMNS if column.percent), key=lambda column: not column.listed
)
"""What it saves: in all, and then its parts."""


def flock_answer(rows: pd.DataFrame, chain: pd.DataFrame | None = None) -> str:
    """Say where each bird of a flock flies, what it saves, and what taking turns brings.

    Parameters
    ----------
    rows : DataFrame
        The rows of one flock, from the front.
    chain : DataFrame, optional
        Those of the chain that it was improved from as a whole.
    """
    parts = [birds_table(rows, chain).text()]
    # Birds of several kinds do not take turns.
    if (rows["status"] == of.SOLVED).sum() > 1 and not _kinds(rows.iloc[0]):
        parts.append(turns_table(rows).text())
    return "\n\n".join(parts)


def _kinds(row: Any) -> list[str]:
    """Return the species of all birds from the front, if they are not alike."""
    members = row["members"]
    behind = json.loads(members) if isinstance(members, str) else []
    return [row["species"], *(one["species"] for one in behind)] if behind else []


def birds_table(rows: pd.DataFrame, chain: pd.DataFrame | None = None) -> Table:
    """Describe a flock bird by bird; parameters as for `flock_answer`.

    Returns
    -------
    Table
        Positions and phase are relative to the first bird; costs and savings are shares of a lone bird's.
    """
    first, placed = rows.iloc[0], rows[rows["status"] == of.SOLVED]
    cost = 100.0 * placed["cost"] / placed["cost_leader"]
    # A phase that is rounded to a whole wingbeat is 0.
    placed = placed.astype({"leader": "Int64"}).assign(phase_flock=placed["phase_flock"].round(3) % 1.0)
    place, formats = shown(placed, OF_A_BIRD)
    savings, more = shown(placed, SAVINGS)
    columns = {**place, "cost %": cost, **savings}
    if kinds := _kinds(first):
        own = pd.Series([kinds[bird - 1] for bird in placed["bird"]], index=placed.index)
        columns = {"bird": columns.pop("bird"), "species": own, **columns}
    formats |= {"cost %": ".2f", **more}
    notes = []
    if chain is None:
        columns["proof"] = placed.apply(proof_in_v, axis=1)
        notes += open_explained(placed)
    else:
        before = chain[chain["status"] == of.SOLVED]
        given_up = cost.to_numpy() - 100.0 * (before["cost"] / before["cost_leader"]).to_numpy()
        columns["given up %"] = pd.Series(given_up, index=placed.index)
        formats["given up %"] = "+.3f"
        words = "all birds improved together" if (given_up != 0.0).any() else "nothing better found together"
        notes.append(f"{words}: mean cost {given_up.mean():+.3f} % of a lone bird's against bird by bird")
    for _, row in (rows if chain is None else chain).iterrows():
        if row["status"] != of.SOLVED:
            notes.append(f"bird {row['bird']}: {row['error']}")
    words = f"{first['species']}, {first['shape']}, {least(first['objective'])}"
    title = f"{words}; {WAKES[first['wake']]}, {length_of_wake(first)}; {READINGS[first['reading']]}"
    if not first["phase_lock"]:
        notes.append("each in its own beat: forces are averaged over all phases")
    if _kinds(first):
        notes.append("cost and savings are shares of what each bird spends alone at that speed")
    notes += model_in_words(first)
    return Table(title, pd.DataFrame(columns), formats, tuple(notes))


def turns_table(rows: pd.DataFrame) -> Table:
    """Say what a bird saves and how much further it gets when the flock takes turns, by size."""
    savings = rows.loc[rows["status"] == of.SOLVED, "saving_total"].tolist()
    turns = take_turns(savings)
    frame = pd.DataFrame(
        {
            "birds": [turn.birds for turn in turns],
            "saving %": [100.0 * turn.saving_mean for turn in turns],
            "further %": [100.0 * turn.range_gained for turn in turns],
        }
    )
    title = "Taking turns in the lead: what each bird saves, and how much further it gets than alone"
    return Table(title, frame, {"saving %": ".2f", "further %": ".2f"})


def flock_record(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return all that is known of one flock as one dictionary fit for JSON.

    Parameters
    ----------
    rows : sequence of dict
        Its rows, from the front, by the columns of ``flock.parquet``.

    Returns
    -------
    dict
        The job's inputs by column, under ``flock`` the other columns of each bird, and under ``turns`` what
        taking turns brings, by size, if they are alike.
    """
    rows = [of.told(row) for row in rows]
    shared = {"job_id", "flock_id", *INPUTS}
    is_alike = not _kinds(rows[0])
    savings = [row["saving_total"] for row in rows if row["status"] == of.SOLVED and is_alike]
    return {
        **{name: rows[0][name] for name in ("job_id", *INPUTS)},
        "flock": [{name: value for name, value in row.items() if name not in shared} for row in rows],
        "turns": [vars(turn) for turn in take_turns(savings)] if savings else [],
    }


def proof_in_v(bird: Any) -> str:
    """Say in a few words whether a bird's place is proved to be the best optimum of its V region."""
    gap = bird["v_certified_gap"]
    if pd.isna(gap):
        return ABSENT
    return PROVED if is_proved(gap, bird["tolerance"]) else f"{OPEN}, gap {power_of_ten(gap)}"


def open_explained(birds: pd.DataFrame) -> list[str]:
    """Explain what it means that a place is not proved to be the best, if one of some birds' is not."""
    claimed = birds[birds["v_certified_gap"].notna()]
    if all(map(is_proved, claimed["v_certified_gap"], claimed["tolerance"])):
        return []
    return [f"{OPEN}: another place in the V may cost less than this one, by up to the gap"]
