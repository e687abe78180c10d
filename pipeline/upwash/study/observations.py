"""Optima beside what was published of birds in formation: agreement and disagreement, like with like.

An observation is compared with the one quantity that means the same; one that measures something else, such
as a heart rate, keeps its row and is compared with nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from upwash.columns import TEXT, TRUTH, Column
from upwash.errors import UpwashError
from upwash.species.library import LIBRARY_FOLDER
from upwash.study.comparison import NAMES
from upwash.study.intervals import KEYS, ends_of
from upwash.study.quantities import optima_of_jobs

OBSERVATIONS = LIBRARY_FOLDER / "observations.csv"
"""The published observations."""

AGREES, NEAR, ABOVE, BELOW, NOT_COMPARED = "agrees", "near", "above", "below", "not compared"
"""Verdicts on our value beside the observed one: the ranges meet; a length is off by less than the radius of
a vortex core, below which the model's wake has no structure; it is larger; smaller; nothing compares."""

OBSERVED = (
    NAMES[0],
    Column("study", "", "the original work", TEXT),
    Column("quantity", "", "what was observed", TEXT),
    Column("metric", "", "what exactly was measured, of what", TEXT),
    Column("basis", "", "measured on birds, or computed by theory", TEXT),
    Column("this_model", "", "whether the number is the paper's own, from this very model", TRUTH),
    Column("unit", "", "unit of the values in this row", TEXT),
    Column("observed", "as in unit", "published value"),
    Column("observed_low", "as in unit", "least of the published range; absent if it has no lower end"),
    Column("observed_high", "as in unit", "largest of the published range; absent if it has no upper end"),
    *NAMES[1:],
    Column("ours", "as in unit", "our value at the V optimum"),
    Column("ours_low", "as in unit", "lower end of its uncertainty interval"),
    Column("ours_high", "as in unit", "upper end of its uncertainty interval"),
    Column("difference", "as in unit", "our value less the nearest that the publication allows"),
    Column(
        "verdict",
        "",
        "agrees (the ranges meet), near (by a core radius), above, below, or not compared",
        TEXT,
    ),
    Column("remark", "", "why nothing is compared, or the publication's caveat", TEXT),
)
"""Columns of the comparison with observations."""

_UNIT_M: dict[str, Callable[[pd.DataFrame], pd.Series]] = {
    "m": lambda optima: optima["semispan_m"] / optima["semispan_m"],
    "wingspans": lambda optima: 2.0 * optima["semispan_m"],
    "semispans": lambda optima: optima["semispan_m"],
    "wavelengths": lambda optima: optima["speed_m_s"] * optima["period_s"],
}
"""Units of published lengths -> their length, in m, for each bird."""

_LENGTHS = {"x_m": "x_semispans", "y_m": "y_semispans", "z_m": "z_semispans"}


COPIED = ("species", "study", "quantity", "metric", "basis", "this_model", "unit")
"""Columns of an observation that stay as they are beside ours."""


def read_observations() -> pd.DataFrame:
    """Return the published observations, text that is not there being empty."""
    try:
        observations = pd.read_csv(OBSERVATIONS, true_values=["yes"], false_values=["no"])
    except OSError as error:
        raise UpwashError(
            f"{OBSERVATIONS}: expected the published observations, found no such file; install Upwash from a "
            "checkout of its repository (make install)"
        ) from error
    texts = observations.columns.difference(["value", "low", "high", "this_model"])
    return observations.assign(**{name: observations[name].fillna("") for name in texts})


def our_values(observation: pd.Series, optima: pd.DataFrame) -> pd.Series:
    """Return of each V optimum what an observation is of, in the observation's unit.

    Parameters
    ----------
    observation : Series
        A row of `read_observations` with something to compare.
    optima : DataFrame
        As `upwash.study.quantities.optima_of_jobs` returns.
    """
    name = observation["compare"]
    if name == "phase":
        # What is seen of flying birds is the phase of the paths of their wingtips.
        return optima["path_phase"]
    if name not in _LENGTHS:
        return 100.0 * optima[name]
    is_spacing = observation["quantity"] == "wingtip_spacing"
    scaled = optima["tip_spacing_semispans" if is_spacing else _LENGTHS[name]]
    return scaled * optima["semispan_m"] / _UNIT_M[observation["unit"]](optima)


def compare_with_observations(
    rows: pd.DataFrame, samples: pd.DataFrame | None = None, observations: pd.DataFrame | None = None
) -> pd.DataFrame:
    """Return our V optima beside every published observation.

    Parameters
    ----------
    rows, samples : DataFrame
        As for `upwash.study.comparison.compare`.
    observations : DataFrame, optional
        As `read_observations` returns, and that if not given.

    Returns
    -------
    DataFrame
        The columns of `OBSERVED`: one row for each observation, objective and amplitude convention, or one
        for an observation that is compared with nothing.
    """
    observed = read_observations() if observations is None else observations
    optima = optima_of_jobs(rows).sort_values(list(KEYS))
    sampled = None if samples is None else optima_of_jobs(samples)
    rows_beside = [row for _, line in observed.iterrows() for row in _beside(line, optima, sampled)]
    return pd.DataFrame(rows_beside, columns=[column.name for column in OBSERVED])


def _beside(
    observation: pd.Series, optima: pd.DataFrame, samples: pd.DataFrame | None
) -> list[dict[str, Any]]:
    """Return the rows of one observation."""
    row = {name: observation[name] for name in COPIED}
    row |= {"observed": observation["value"], "remark": observation["note"]}
    row |= {f"observed_{end}": observation[end] for end in ("low", "high")}
    of_species = optima[optima["species"] == observation["species"]]
    why_not = _why_not_compared(observation, of_species)
    if why_not:
        return [row | {"verdict": NOT_COMPARED, "remark": why_not}]
    low, high = _published_range(observation)
    ours = our_values(observation, of_species)
    ends = None
    if samples is not None:
        sampled = samples[samples["species"] == observation["species"]]
        ends = ends_of(sampled.assign(ours=our_values(observation, sampled)), KEYS, ["ours"])
    beside = []
    for (_, optimum), value in zip(of_species.iterrows(), ours, strict=True):
        key = tuple(optimum[name] for name in KEYS)
        compared = row | {name: optimum[name] for name in KEYS[1:]} | {"ours": value}
        interval = (value, value)
        if ends is not None and key in ends.index and ends.loc[key].notna().all():
            interval = (ends.loc[key, "ours_low"], ends.loc[key, "ours_high"])
            compared |= {"ours_low": interval[0], "ours_high": interval[1]}
        if optimum["has_v"]:
            difference = value - np.clip(value, low, high)
            core_radius = _core_radius(observation, optimum)
            verdict = _verdict(difference, interval, (low, high), core_radius)
            compared |= {"difference": difference, "verdict": verdict}
        else:
            compared |= {"verdict": NOT_COMPARED, "remark": "no V optimum"}
        beside.append(compared)
    return beside


def _verdict(
    difference: float, ours: tuple[float, float], published: tuple[float, float], core_radius: float
) -> str:
    if ours[0] <= published[1] and ours[1] >= published[0]:
        return AGREES
    if abs(difference) < core_radius:
        return NEAR
    return ABOVE if difference > 0.0 else BELOW


def _core_radius(observation: pd.Series, optimum: pd.Series) -> float:
    """Return the radius of a vortex core in the unit of an observed length; 0 for what is no length."""
    if observation["compare"] not in _LENGTHS:
        return 0.0
    radius_m = optimum["core_radius_ratio"] * optimum["semispan_m"]
    return float(radius_m / _UNIT_M[observation["unit"]](optimum.to_frame().T).iloc[0])


def _published_range(observation: pd.Series) -> tuple[float, float]:
    """Return the published range; a value alone has no width, and one end alone leaves the other open."""
    value, low, high = (observation[name] for name in ("value", "low", "high"))
    if np.isnan(low) and np.isnan(high):
        return value, value
    return -np.inf if np.isnan(low) else low, np.inf if np.isnan(high) else high


def _why_not_compared(observation: pd.Series, optima: pd.DataFrame) -> str:
    """Say why nothing can be compared with an observation; empty if something can."""
    if not observation["compare"]:
        return f"nothing in the model is the same: {observation['metric']}"
    if observation[["value", "low", "high"]].isna().all():
        return f"no number published: {observation['note']}"
    if optima.empty:
        return "no such species in the sweep"
    return ""
