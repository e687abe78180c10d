"""Species side by side: one row a problem, and what the choice of objective changes.

Every frame here follows from the rows that a sweep over species left; a sweep that samples each species' own
ranges gives each number its interval.
"""

from __future__ import annotations

from typing import Any

import pandas as pd

from upwash.columns import INTEGER, SOLVED, TEXT, TRUTH, Column
from upwash.optimum.proof import OPEN, claims_of, percent, wall_in_words
from upwash.study.intervals import BIRD, COUNTS, KEYS, ends_of, interval_columns, intervals
from upwash.study.quantities import ALIKE, GROUPS, QUANTITIES, optima_of_jobs

NAMES = (
    Column("species", "", "species file, without .toml", TEXT),
    Column("objective", "", "name of the cost function", TEXT),
    Column("amplitude_convention", "", "how the leader's amplitude was chosen", TEXT),
)
ALIKE_V = (
    Column(
        "v_alike", "1", f"optima in a V that cost the V optimum's to within {ALIKE:.1%}, itself one", INTEGER
    ),
    Column("v_alike_saving_low", "1", "least share of the leader's total power saved among them"),
    Column("v_alike_saving_high", "1", "largest share of the leader's total power saved among them"),
)
BEST = (
    Column(
        "v_gap_bound",
        "1",
        "the V optimum is proved to cost no more than this above the cheapest, as a fraction",
    ),
    Column("best_placement", "", "of the best optimum found: outboard or inboard", TEXT),
    Column("best_tier", "", "of the best optimum found: level or stacked", TEXT),
    Column("best_station", "", "of the best optimum found: astern or abreast", TEXT),
    Column("best_x_semispans", "1", "best optimum found: downstream of the leader, in semispans"),
    Column("best_y_semispans", "1", "best optimum found: right of the leader, in semispans"),
    Column("best_z_semispans", "1", "best optimum found: above the leader, in semispans"),
    Column("best_saving_total", "1", "best optimum found: share of the leader's total power saved"),
)
COMPARISON = (
    *NAMES,
    Column("status", "", "solved, infeasible (there is no answer) or failed", TEXT),
    Column("has_v", "", "whether there is a V optimum", TRUTH),
    Column(
        "v_optimum_claim",
        "",
        "that the V optimum is the best of all local optima in the V: proved, open or not claimed",
        TEXT,
    ),
    Column("remark", "", "why there is no V optimum, or what to know of it", TEXT),
    *GROUPS,
    *QUANTITIES,
    *ALIKE_V,
    *BEST,
    *interval_columns(QUANTITIES),
    *COUNTS,
)
"""Columns of the comparison of species."""

OBJECTIVES = ("force", "power")
"""The two objectives that are set against each other."""


def compare(rows: pd.DataFrame, samples: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return species side by side.

    Parameters
    ----------
    rows : DataFrame
        All rows of a sweep over species, one job for each of `KEYS`.
    samples : DataFrame, optional
        All rows of a sweep over the same species that samples each one's inputs.

    Returns
    -------
    DataFrame
        The columns of `COMPARISON`, one row for each of `KEYS`; intervals are NaN without samples.
    """
    optima = optima_of_jobs(rows).sort_values(list(KEYS)).reset_index(drop=True)
    records = optima.to_dict("records")
    optima["v_optimum_claim"] = [claims_of(optimum).v_optimum for optimum in records]
    optima["remark"] = list(map(_remark, records))
    if samples is not None:
        optima = optima.join(intervals(optima_of_jobs(samples)), on=list(KEYS))
    return optima.reindex(columns=[column.name for column in COMPARISON])


def _remark(optimum: dict[Any, Any]) -> str:
    if optimum["status"] != SOLVED:
        return str(optimum["error"])
    remarks = []
    if not optimum["has_v"]:
        remarks.append("no V optimum")
    if optimum["v_wall"]:
        remarks.append(f"a follower in the V does best {wall_in_words(optimum['v_wall'])}")
    claims = claims_of(optimum)
    if claims.v_optimum == OPEN:
        remarks.append(f"V optimum proved to {percent(optimum['v_certified_gap'])} only")
    if claims.everywhere == OPEN:
        remarks.append(f"best optimum proved to {percent(optimum['global_certified_gap'])} only")
    return "; ".join(remarks)


def objectives_columns() -> tuple[Column, ...]:
    """Return the columns of the comparison of the objectives."""
    first, second = OBJECTIVES
    columns = [column for column in NAMES if column.name != "objective"]
    for column in QUANTITIES:
        columns += [
            Column(f"{column.name}_{first}", column.unit, f"by {first}: {column.description}"),
            Column(f"{column.name}_{second}", column.unit, f"by {second}: {column.description}"),
            Column(
                f"{column.name}_change", column.unit, f"by {second} less by {first}: {column.description}"
            ),
            *interval_columns(
                [Column(f"{column.name}_change", column.unit, f"change of {column.description}")]
            ),
        ]
    return tuple(columns)


def compare_objectives(rows: pd.DataFrame, samples: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return what changes if the follower minimises power instead of force.

    Parameters
    ----------
    rows, samples : DataFrame
        As for `compare`.

    Returns
    -------
    DataFrame
        The columns of `objectives_columns`, one row for each species and amplitude convention that has both.
        The interval of a change is over pairs of samples of the same bird.
    """
    keys = [name for name in KEYS if name != "objective"]
    changes = _changes(optima_of_jobs(rows), keys)
    if samples is not None:
        names = [f"{column.name}_change" for column in QUANTITIES]
        changes = changes.join(
            ends_of(_changes(optima_of_jobs(samples), [*keys, *BIRD]), keys, names), on=keys
        )
    columns = [column.name for column in objectives_columns()]
    return changes.sort_values(keys).reset_index(drop=True).reindex(columns=columns)


def _changes(optima: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Pair the optima of the same bird under both objectives."""
    first, second = OBJECTIVES
    names = [column.name for column in QUANTITIES]
    by_first, by_second = (
        optima[optima["objective"] == objective].set_index(keys)[names].add_suffix(f"_{objective}")
        for objective in OBJECTIVES
    )
    pairs = by_first.join(by_second, how="inner").reset_index()
    changes = {f"{name}_change": pairs[f"{name}_{second}"] - pairs[f"{name}_{first}"] for name in names}
    return pairs.assign(**changes)
