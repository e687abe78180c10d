"""How uncertain a saving in the limit is: what each span law and the bird's own ranges do to it.

Nothing yet decides between the two laws of the follower's span, and no bird is known to a percent, so that a saving
there is an interval.  Its ends are found by descents and not proved: there is one basin of least power.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.batch.store import encode, provenance, write_atomic
from upwash.columns import INTEGER, Column, column, names
from upwash.jobs.schema import schema_of
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.record import V_LABELS
from upwash.optimum.solution import record_in
from upwash.optimum.spacing import FREE, Spacing
from upwash.study.intervals import HIGH, LOW

SAMPLES, SEED = 32, 1
"""As in the sweep ``uncertainty``."""

STARTS, OWN_STARTS = 16, 64
"""Descents in each sample, and for the bird itself: of least force there are several basins of nearly one cost."""


FILE = "ranges.parquet"
"""File of the ranges, in a results folder."""

_OF_POWER, _OF_COST = (
    tuple(
        Column(f"saving_{name}{end}", "1", f"saving of {words}: {of_whom}")
        for end, of_whom in (
            ("", "of the bird itself"),
            ("_low", f"{LOW:.0%} quantile over the samples"),
            ("_high", f"{HIGH:.0%} quantile over the samples"),
        )
    )
    for name, words in (("total", "total power"), ("cost", "the cost"))
)
RANGES = (
    column("species"),
    column("objective"),
    column("span_law"),
    *_OF_POWER,
    *_OF_COST,
    Column("samples", "1", "samples of the bird's inputs", INTEGER),
    Column("samples_without", "1", "samples without such an optimum", INTEGER),
)
"""Columns of the file, one row a span law."""


class PairIn(NamedTuple):
    """A follower and its leader, and the wake.

    Attributes
    ----------
    bird : object
        The follower; one that is no `Bird` cannot fly.
    model : WakeModel
        The wake.
    leader : object
        The bird ahead.
    phase_lock : bool
        Whether they beat in step.
    """

    bird: Any
    model: WakeModel
    leader: Any
    phase_lock: bool


def pair_in(job: Any) -> PairIn:
    """Return the birds of a pair's job."""
    leader = job.kind.leader.bird if job.kind.leader else job.bird
    return PairIn(job.bird, job.model, leader, job.kind.phase_lock)


@dataclass(frozen=True)
class LimitRange:
    """What is saved by one span law.

    Attributes
    ----------
    span_law : str
        The law.
    saving_total, saving_cost : float
        Of the bird itself, as shares of the lone bird's power and cost; NaN if it has no such optimum.
    saving_total_low, saving_total_high, saving_cost_low, saving_cost_high : float
        5 % and 95 % quantiles over the samples; NaN if none has such an optimum.
    samples, samples_without : int
        Samples, and those that have no such optimum.
    """

    span_law: str
    saving_total: float
    saving_total_low: float
    saving_total_high: float
    saving_cost: float
    saving_cost_low: float
    saving_cost_high: float
    samples: int
    samples_without: int


def limit_ranges(
    birds: Mapping[str, Sequence[PairIn]],
    objective: str,
    in_v: bool,
    distance_m: float | None = None,
    spacing: Spacing = FREE,
) -> list[LimitRange]:
    """Return what is saved behind an endless wake, by each span law.

    Parameters
    ----------
    birds : mapping
        Span law -> the bird itself behind its leader, then its samples behind theirs.
    objective : str
        Name of a cost function.
    in_v : bool
        Whether the optimum is the best in a V, or the best of all.
    distance_m : float, optional
        How far behind, which decides whether that is astern; half a wavelength if not given.
    spacing : Spacing
        What the follower keeps to.
    """
    ranges = []
    for law, of_law in birds.items():
        own, *samples = (
            _savings(pair, objective, in_v, distance_m, spacing, STARTS if number else OWN_STARTS)
            for number, pair in enumerate(of_law)
        )
        frame = pd.DataFrame(samples, columns=["total", "cost"]).dropna()
        ends = {
            f"saving_{name}_{end}": float(frame[name].quantile(share)) if len(frame) else np.nan
            for name in frame
            for end, share in (("low", LOW), ("high", HIGH))
        }
        ranges.append(
            LimitRange(
                law,
                saving_total=own[0],
                saving_cost=own[1],
                samples=len(samples),
                samples_without=len(samples) - len(frame),
                **ends,
            )
        )
    return ranges


def keep_ranges(
    folder: Path, species: str, objective: str, find: Callable[[], Sequence[LimitRange]]
) -> pd.DataFrame:
    """Return the ranges at the V optimum; what a results folder holds already is not computed anew.

    Parameters
    ----------
    folder : Path
        The folder, whose file `FILE` is written.
    species, objective : str
        Whose ranges, and of which cost.
    find : callable
        Finds them, as `limit_ranges` does.
    """
    known = read_ranges(folder)
    if known is not None and (known[["species", "objective"]] == [species, objective]).all(axis=None):
        return known
    same = {"species": species, "objective": objective}
    rows = [same | {name: _known(value) for name, value in asdict(one).items()} for one in find()]
    write_atomic(folder / FILE, encode(rows, schema_of(RANGES), provenance("")))
    return pd.DataFrame(rows, columns=names(RANGES))


def _known(value: Any) -> Any:
    return None if isinstance(value, float) and np.isnan(value) else value


def read_ranges(folder: Path) -> pd.DataFrame | None:
    """Return the ranges that are kept in a results folder, or None."""
    path = folder / FILE
    return pd.read_parquet(path) if path.exists() else None


def _savings(
    pair: PairIn, objective: str, in_v: bool, distance_m: float | None, spacing: Spacing, starts: int
) -> tuple[float, float]:
    """Return the savings of total power and of the cost at one bird's best place; NaN if there is none."""
    if not isinstance(pair.bird, Bird):
        return np.nan, np.nan
    problem = EndlessProblem(
        pair.bird,
        objective,
        model=pair.model,
        leader=pair.leader,
        phase_lock=pair.phase_lock,
        distance_m=distance_m,
        spacing=spacing,
    )
    search = EndlessSearch(problem, SEED)
    bounds = problem.v_bounds() if in_v else problem.bounds
    if np.any(bounds[:, 0] > bounds[:, 1]):
        return np.nan, np.nan
    for basin in search.descend(search.random_starts(bounds, starts)):
        found = record_in(problem, problem.pose(basin.point))
        if not in_v or (found.placement, found.tier, found.station) == V_LABELS:
            return found.saving_total, 1.0 - found.cost / found.cost_leader
    return np.nan, np.nan
