"""Which inputs matter: Sobol' indices of saving and position, from a sweep with a Saltelli design.

An index of first order is the share of an output's variance that an input causes alone, a total index the
share that it has a part in.  A point of the design is usable if all of its samples have the output: one that
failed, or has no V optimum, takes its point with it.  Both are counted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from upwash.columns import FAILED, INTEGER, TEXT, Column
from upwash.errors import UpwashError
from upwash.study.comparison import NAMES
from upwash.study.intervals import BIRD, KEYS
from upwash.study.quantities import optima_of_jobs

OUTPUTS = (
    "saving_total",
    "saving_induced",
    "saving_profile",
    "x_wavelengths",
    "y_semispans",
    "z_semispans",
    "best_saving_total",
    "has_v",
)
"""Whose variance is shared out: of the V optimum, of the best optimum, and whether there is a V at all."""

CONFIDENCE = 0.95
RESAMPLES = 1000
LEAST_POINTS = 8
"""Fewer usable points of the design give no index."""

# SALib takes 0 for "no seed".
BOOTSTRAP_SEED = 1
SAME = 1e-9
"""Values of an input are the same if they agree to so much, relatively: rounding."""

_CONFIDENCE = f"half width of its {CONFIDENCE:.0%} confidence interval, by bootstrap"
SENSITIVITY = (
    *NAMES,
    Column("output", "", "what varies", TEXT),
    Column("input", "", "what it varies with", TEXT),
    Column("first_order", "1", "share of the variance that the input causes alone"),
    Column("first_order_confidence", "1", _CONFIDENCE),
    Column("total", "1", "share of the variance that the input has a part in"),
    Column("total_confidence", "1", _CONFIDENCE),
    Column("variance", "1", "variance of the output over the usable points"),
    Column("points", "1", "base points of the design", INTEGER),
    Column("points_usable", "1", "base points all of whose samples have the output", INTEGER),
    Column("samples", "1", "samples of the design", INTEGER),
    Column("samples_failed", "1", "samples whose job failed", INTEGER),
    Column("samples_without_v", "1", "samples that have no V optimum", INTEGER),
)
"""Columns of the indices."""


@dataclass(frozen=True)
class Design:
    """A Saltelli design as found in the inputs of jobs.

    Parameters
    ----------
    inputs : list of str
        The D inputs that vary, in the design's order.
    jobs : ndarray of str
        Job ids, of shape (points, D + 2): those of A, of A with one column at a time from B, and of B.
    """

    inputs: list[str]
    jobs: NDArray[Any]


def sensitivity(rows: pd.DataFrame, jobs: list[str]) -> pd.DataFrame:
    """Return the Sobol' indices of each output with respect to each input.

    Parameters
    ----------
    rows : DataFrame
        All rows of a sweep that samples with method ``saltelli``.
    jobs : list of str
        Ids of the sweep's jobs in the order of the sweep, which is the design's.

    Returns
    -------
    DataFrame
        The columns of `SENSITIVITY`, one row for each problem, output and input. Indices are NaN where an
        output does not vary, or where fewer than `LEAST_POINTS` points are usable.

    Raises
    ------
    UpwashError
        If SALib is not installed, jobs are missing, or the jobs are no Saltelli design.
    """
    optima = optima_of_jobs(rows)
    missing = len(set(jobs) - set(optima.index))
    if missing:
        raise UpwashError(
            f"sensitivity: expected a result for each of the sweep's {len(jobs)} jobs, found {missing} "
            "without; run the sweep to its end"
        )
    rows_of_indices = [
        row
        for key, group in optima.loc[jobs].groupby(list(KEYS), sort=True)
        for row in _indices(dict(zip(KEYS, key, strict=True)), group)
    ]
    return pd.DataFrame(rows_of_indices, columns=[column.name for column in SENSITIVITY])


def _indices(key: dict[str, Any], optima: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Give the rows of one species, objective and amplitude convention."""
    design = design_of(optima)
    is_failed = optima["status"] == FAILED
    counts = {
        "points": len(design.jobs),
        "samples": len(optima),
        "samples_failed": int(is_failed.sum()),
        "samples_without_v": int((~is_failed & ~optima["has_v"]).sum()),
    }
    for output in OUTPUTS:
        values = optima[output].astype(float).mask(is_failed)
        points = values.loc[design.jobs.ravel()].to_numpy().reshape(design.jobs.shape)
        usable = points[~np.isnan(points).any(axis=1)]
        indices = _sobol(usable, design.inputs)
        for number, name in enumerate(design.inputs):
            yield {
                **key,
                "output": output,
                "input": name,
                **{index: of_each[number] for index, of_each in indices.items()},
                "variance": float(usable.var()) if usable.size else np.nan,
                "points_usable": len(usable),
                **counts,
            }


def _sobol(points: NDArray[Any], inputs: list[str]) -> dict[str, NDArray[np.float64]]:
    """Return the indices of an output whose values are given as (points, D + 2)."""
    names = {
        "first_order": "S1",
        "first_order_confidence": "S1_conf",
        "total": "ST",
        "total_confidence": "ST_conf",
    }
    if len(points) < LEAST_POINTS or np.ptp(points) <= SAME * np.abs(points).max():
        return {name: np.full(len(inputs), np.nan) for name in names}
    analyze = _salib()
    problem = {"num_vars": len(inputs), "names": inputs, "bounds": [[0.0, 1.0]] * len(inputs)}
    indices = analyze(
        problem,
        points.ravel(),
        calc_second_order=False,
        num_resamples=RESAMPLES,
        conf_level=CONFIDENCE,
        seed=BOOTSTRAP_SEED,
    )
    return {name: np.asarray(indices[theirs], dtype=float) for name, theirs in names.items()}


def _salib() -> Any:
    try:
        from SALib.analyze.sobol import analyze
    except ImportError as error:
        raise UpwashError(
            "sensitivity: expected SALib, found it not installed; pip install 'upwash[sensitivity]'"
        ) from error
    return analyze


def design_of(jobs: pd.DataFrame) -> Design:
    """Find the Saltelli design in the inputs of some jobs.

    Parameters
    ----------
    jobs : DataFrame
        By job id, in the design's order: the jobs of one species, objective and amplitude convention.

    Raises
    ------
    UpwashError
        If they are no such design.
    """
    inputs = _sampled_inputs(jobs)
    values = inputs.to_numpy(dtype=float)
    varying = np.ptp(values, axis=0) > SAME * np.abs(values).max(axis=0)
    names, values = list(inputs.columns[varying]), values[:, varying]
    count = len(names)
    what = "/".join(str(jobs[name].iloc[0]) for name in KEYS)
    error = UpwashError(
        f"sensitivity: expected the jobs of {what} to be one sample with method 'saltelli', found others; "
        "give each sample a sweep of its own"
    )
    if not count or len(values) % (count + 2):
        raise error
    points = values.reshape(-1, count + 2, count)
    first, last = points[:, :1], points[:, -1:]
    from_last = np.isclose(points[:, 1:-1], last, rtol=SAME, atol=0.0)
    from_first = np.isclose(points[:, 1:-1], first, rtol=SAME, atol=0.0)
    # Row j of each point has one input from its last row, the same in all points, the others from its first.
    exchanged = from_last.all(axis=0)
    if not (exchanged.sum(axis=0) == 1).all() or not (exchanged.sum(axis=1) == 1).all():
        raise error
    if not (from_first | exchanged).all():
        raise error
    order = exchanged.argmax(axis=1)
    return Design([names[number] for number in order], jobs.index.to_numpy().reshape(-1, count + 2))


def _sampled_inputs(jobs: pd.DataFrame) -> pd.DataFrame:
    """Return a bird's inputs as a sweep samples them: the amplitude as what its convention takes it from."""
    inputs = jobs[[name for name in BIRD if name != "leader_amplitude_m"]].copy()
    amplitude, convention = jobs["leader_amplitude_m"], jobs["amplitude_convention"].iloc[0]
    if convention == "stroke-angle":
        inputs["stroke_half_angle_deg"] = np.degrees(np.arcsin(amplitude / (2.0 * jobs["semispan_m"])))
    elif convention != "strouhal":
        inputs["leader_amplitude_m"] = amplitude
    return inputs
