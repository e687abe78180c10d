"""How uncertain an optimum is: what sampling a bird's inputs from their ranges does to each quantity.

The inputs are sampled evenly over their ranges, so an interval says what is possible given what is known of
the bird, not how likely it is.  Samples without a V optimum are counted; an interval is over the others.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import pandas as pd

from upwash.columns import FAILED, FLOAT, INTEGER, PROBLEM, Column, belonging
from upwash.study.quantities import QUANTITIES

KEYS = ("species", "objective", "amplitude_convention")
"""What tells the problems of a comparison apart."""

BIRD = tuple(column.name for column in belonging(PROBLEM) if column.type == FLOAT)
"""The bird and its air: what a study of uncertainty samples, or what follows from that."""

LOW, HIGH = 0.05, 0.95
"""The interval's ends, as shares of the samples below them."""

LEAST_SAMPLES = 8
"""Fewer samples with a V optimum give no interval."""

COUNTS = (
    Column("samples", "1", "samples of the bird's inputs", INTEGER),
    Column("samples_failed", "1", "samples whose job failed; in no interval", INTEGER),
    Column("samples_without_v", "1", "samples that have no V optimum; in no interval", INTEGER),
)


def interval_columns(columns: Iterable[Column]) -> tuple[Column, ...]:
    """Return the columns that hold the ends of some quantities' intervals."""
    return tuple(
        Column(
            f"{column.name}_{end}",
            column.unit,
            f"{share:.0%} quantile over the samples: {column.description}",
        )
        for column in columns
        for end, share in (("low", LOW), ("high", HIGH))
    )


def intervals(optima: pd.DataFrame) -> pd.DataFrame:
    """Return the interval of each of `QUANTITIES` for each problem of a study that samples the inputs.

    Parameters
    ----------
    optima : DataFrame
        One row a sample, as `upwash.study.quantities.optima_of_jobs` returns.

    Returns
    -------
    DataFrame
        By `KEYS`: the columns of `interval_columns` and of `COUNTS`.
    """
    groups = optima.assign(
        samples_failed=optima["status"] == FAILED,
        samples_without_v=(optima["status"] != FAILED) & ~optima["has_v"],
    ).groupby(list(KEYS))
    counts = groups[["samples_failed", "samples_without_v"]].sum()
    counts.insert(0, "samples", groups.size())
    return ends_of(optima, KEYS, [column.name for column in QUANTITIES]).join(counts, how="right")


def ends_of(samples: pd.DataFrame, keys: Sequence[str], names: Sequence[str]) -> pd.DataFrame:
    """Return the ends of some columns' intervals for each group of samples, NaN where there are too few."""
    groups = samples.groupby(list(keys))[list(names)]
    ends: dict[str, pd.Series] = {}
    few = groups.count() < LEAST_SAMPLES
    for end, share in (("low", LOW), ("high", HIGH)):
        quantiles = groups.quantile(share).mask(few)
        ends |= {f"{name}_{end}": quantiles[name] for name in names}
    return pd.DataFrame(ends)


def outside_of_samples(optima: pd.DataFrame, samples: pd.DataFrame) -> set[str]:
    """Return the species whose bird does not lie among their samples: it has changed since they were drawn.

    Parameters
    ----------
    optima, samples : DataFrame
        The birds themselves and their samples, as `upwash.study.quantities.optima_of_jobs` returns.
    """
    groups = samples.groupby(list(KEYS))[list(BIRD)]
    low, high = groups.min(), groups.max()
    # The outermost samples lie inside the range that they are drawn from.
    margin = 2.0 * (high - low).div(groups.size(), axis=0) + 1e-9 * high
    birds = optima.set_index(list(KEYS))[list(BIRD)]
    low, high, margin = (ends.reindex(birds.index) for ends in (low, high, margin))
    strays = ((birds < low - margin) | (birds > high + margin)).any(axis=1)
    return set(strays.index[strays].get_level_values("species"))
