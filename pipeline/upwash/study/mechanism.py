"""How a follower saves, species by species: the paper's statements about the mechanism, beyond its ibis.

The paper finds that the follower reduces its amplitude more than its upstroke span ratio, and saves a larger
share of its profile power than of its induced power.
"""

from __future__ import annotations

from collections.abc import Callable

import pandas as pd

from upwash.columns import INTEGER, TEXT, TRUTH, Column
from upwash.study.comparison import NAMES
from upwash.study.intervals import HIGH, KEYS, LEAST_SAMPLES, LOW
from upwash.study.quantities import optima_of_jobs

# Statement -> what it says, and whether it holds of optima.
STATEMENTS: dict[str, tuple[str, Callable[[pd.DataFrame], pd.Series]]] = {
    "amplitude_over_flexion": (
        "the amplitude is reduced by a larger fraction than the upstroke span ratio",
        lambda optima: optima["amplitude_reduction"] > optima["span_ratio_reduction"],
    ),
    "profile_over_induced": (
        "a larger fraction of profile power is saved than of induced power",
        lambda optima: optima["saving_profile"] > optima["saving_induced"],
    ),
    "profile_over_induced_in_watts": (
        "more profile power is saved than induced power",
        lambda optima: optima["profile_share"] > 0.5,
    ),
}

MECHANISM = (
    *NAMES,
    Column("has_v", "", "whether there is a V optimum to ask", TRUTH),
    *(
        column
        for name, (words, _) in STATEMENTS.items()
        for column in (
            Column(name, "", f"whether {words}", TRUTH),
            Column(f"{name}_share", "1", f"share of the samples with a V optimum in which {words}"),
        )
    ),
)
"""Columns of the statements, species by species."""

COUNTS = (
    Column("objective", "", "name of the cost function", TEXT),
    Column("amplitude_convention", "", "how the leader's amplitude was chosen", TEXT),
    Column("statement", "", "what is asked", TEXT),
    Column("holds", "1", "species of which it holds", INTEGER),
    Column("fails", "1", "species of which it fails", INTEGER),
    Column("without_v", "1", "species without a V optimum", INTEGER),
    Column("exceptions", "", "species of which it fails", TEXT),
    Column(
        "undecided",
        "",
        f"species of which it holds in {LOW:.0%} to {HIGH:.0%} of the samples: their ranges leave it open",
        TEXT,
    ),
)
"""Columns of the counts of species."""


def mechanism(rows: pd.DataFrame, samples: pd.DataFrame | None = None) -> pd.DataFrame:
    """Return which statements hold of which species.

    Parameters
    ----------
    rows, samples : DataFrame
        As for `upwash.study.comparison.compare`.

    Returns
    -------
    DataFrame
        The columns of `MECHANISM`; no answer where there is no V optimum, no share without samples.
    """
    optima = _answered(rows).sort_values(list(KEYS)).reset_index(drop=True)
    if samples is not None:
        names = list(STATEMENTS)
        groups = _answered(samples).groupby(list(KEYS))[names]
        shares = groups.mean().astype(float).mask(groups.count() < LEAST_SAMPLES)
        optima = optima.join(shares.add_suffix("_share"), on=list(KEYS))
    return optima.reindex(columns=[column.name for column in MECHANISM])


def _answered(rows: pd.DataFrame) -> pd.DataFrame:
    optima = optima_of_jobs(rows)
    for name, (_, holds) in STATEMENTS.items():
        optima[name] = holds(optima).astype("boolean").where(optima["has_v"])
    return optima


def count_species(answers: pd.DataFrame) -> pd.DataFrame:
    """Return of how many species each statement holds, and of which it does not.

    Parameters
    ----------
    answers : DataFrame
        As `mechanism` returns.

    Returns
    -------
    DataFrame
        The columns of `COUNTS`, one row for each objective, amplitude convention and statement.
    """
    rows = []
    for (objective, convention), group in answers.groupby(["objective", "amplitude_convention"]):
        for name, (words, _) in STATEMENTS.items():
            fails = group.loc[group[name].eq(False).fillna(False), "species"]
            is_open = group[f"{name}_share"].between(LOW, HIGH)
            rows.append(
                {
                    "objective": objective,
                    "amplitude_convention": convention,
                    "statement": words,
                    "holds": int(group[name].eq(True).sum()),
                    "fails": len(fails),
                    "without_v": int((~group["has_v"]).sum()),
                    "exceptions": ", ".join(fails),
                    "undecided": ", ".join(group.loc[is_open, "species"]),
                }
            )
    return pd.DataFrame(rows, columns=[column.name for column in COUNTS])
