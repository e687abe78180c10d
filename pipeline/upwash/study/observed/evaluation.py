"""What observed birds save: a table of places in, a table of savings out, row by row.

`evaluate` is the whole; `Evaluation` does the same piece by piece, so that a table of any length fits into memory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose
from upwash.aero.together import SHARED
from upwash.aero.wake import WakeModel
from upwash.columns import Column
from upwash.errors import UpwashError
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.place.balance import Behind
from upwash.place.survey import Birds, survey
from upwash.species import Species
from upwash.study.observed.pairs import LEADS, NEEDED, Pairs, one_ahead, pair_up
from upwash.study.observed.table import PLACE, Reading, Rows, read_rows
from upwash.study.told import EVALUATION, INVALID, LEADING, of_places, of_strokes

MOST_OPTIMA = 20
"""Of so many different birds (by mass, speed and wingbeat period) the V optimum is sought; each takes a search."""


@dataclass(frozen=True)
class Asked:
    """What is asked of observed birds.

    Parameters
    ----------
    bird : Bird or Species
        The bird that leads and follows; with a species, a mass, speed or period of a row also changes the amplitude,
        by its convention.
    model : WakeModel
        The wake.
    objective : str
        Name of the cost that a bird makes least.
    bounds : str
        ``wide`` or ``paper``: within which its stroke is sought.
    reading : Reading
        How the table is read.
    pairs : bool
        Whether the table holds positions of all birds at each time.
    wake : str
        Of such a table: ``neighbour`` or ``all-upstream``.
    heading_deg : float, optional
        Of such a table, see `pair_up`.
    sigma, sigma_m : float, optional
        Standard deviation of x, y and z in semispans, or in m.
    sigma_phase : float, optional
        Of the phase, in wingbeats.
    amplitude : str
        Amplitude convention of a species.
    fixed : mapping
        Inputs that differ from a species' own.
    finds_optimum : bool
        Whether the V optimum is sought as well.
    leader : Bird or Species, optional
        The bird ahead, if it is another; at the follower's speed and in its air.
    phase_lock : bool
        Whether birds beat in step, in the leader's period; else each in its own, averaged over all phases.
    """

    bird: Bird | Species
    model: WakeModel = field(default_factory=WakeModel)
    objective: str = "power"
    bounds: str = "wide"
    reading: Reading = field(default_factory=Reading)
    pairs: bool = False
    wake: str = "neighbour"
    heading_deg: float | None = None
    sigma: float | None = None
    sigma_m: float | None = None
    sigma_phase: float | None = None
    amplitude: str = "stroke-angle"
    fixed: Mapping[str, float] = field(default_factory=dict)
    finds_optimum: bool = True
    leader: Bird | Species | None = None
    phase_lock: bool = True

    def __post_init__(self) -> None:
        for name in ("sigma", "sigma_m", "sigma_phase"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0.0):
                raise UpwashError(
                    f"--{name.replace('_', '-')}: expected a number of at least 0, found {value}"
                )
        if self.sigma is not None and self.sigma_m is not None:
            raise UpwashError(
                "--sigma: expected it in semispans or by --sigma-m in metres, found both; leave one out"
            )
        if not self.pairs and (self.wake != "neighbour" or self.heading_deg is not None):
            raise UpwashError(
                "--wake, --heading: expected --pairs with them, as a row of another table has one bird ahead; add it"
            )

        if self.pairs and (self.leader is not None or not self.phase_lock):
            raise UpwashError(
                "--pairs: expected birds that are alike and beat in step, as each follows another, found a leader of "
                "its own or none in step; leave it out"
            )

    def leader_of(self, bird: Bird) -> Bird:
        """Return the bird ahead of a follower, at its speed and in its air.

        Raises
        ------
        UpwashError
            If there is no such bird.
        """
        if self.leader is None:
            return bird
        shared = {name: getattr(bird, name) for name in SHARED}
        if not isinstance(self.leader, Species):
            return replace(self.leader, **shared)
        own = self.leader.inputs()
        return self.leader.bird(
            self.amplitude, **{name: value for name, value in shared.items() if own[name] != value}
        )

    def bird_with(self, **inputs: float) -> Bird:
        """Return the bird, with what a row says of it.

        Raises
        ------
        UpwashError
            If these inputs make no bird.
        """
        if isinstance(self.bird, Species):
            return self.bird.bird(self.amplitude, **dict(self.fixed) | inputs)
        try:
            return replace(self.bird, **inputs)
        except ValueError as error:
            raise UpwashError(str(error)) from error


@dataclass(frozen=True)
class _Optimum:
    """The V optimum of a bird: its saving, and where it flies."""

    saving: float
    pose: Pose


class Evaluation:
    """Evaluates observed birds, one table or one piece of it after the other.

    Parameters
    ----------
    asked : Asked
        What is asked.
    jobs : int
        How many threads share the work.
    """

    def __init__(self, asked: Asked, jobs: int = 1) -> None:
        self.asked, self.jobs = asked, jobs
        self.bird = asked.bird_with()
        self._behind: dict[Bird, Behind] = {}
        self._optima: dict[Bird, _Optimum | None] = {}
        self.behind(self.bird)
        self.optima_left_out = False

    def __call__(self, frame: pd.DataFrame) -> pd.DataFrame:
        """Return a table's own columns and those of `EVALUATION`, in the order of its rows.

        Raises
        ------
        UpwashError
            If a column is missing, or all of the table is in another unit.
        """
        asked = self.asked
        semispan = self.bird.semispan_m
        rows = read_rows(frame, asked.reading, semispan, NEEDED if asked.pairs else PLACE)
        pairs = (
            pair_up(frame, rows, asked.reading, asked.wake, asked.heading_deg)
            if asked.pairs
            else one_ahead(rows)
        )
        told = {column.name: _nothing(column, len(frame)) for column in EVALUATION}
        told["leader"] = pairs.leader
        if not asked.pairs:
            told |= {name: rows.value(name) for name in (*PLACE, "z_m", "phase")}
        alone = (np.diff(pairs.first) == 0) & (rows.faults == "")
        unknown = np.isnan(pairs.places[:, 3])
        several = np.diff(pairs.first) > 1
        lacks_phase = (
            np.add.reduceat(np.append(unknown, False), pairs.first[:-1]) > 0 if len(frame) else several
        )
        rows.find(
            "expected the phase of each bird ahead, as several wakes are felt, found none",
            several & lacks_phase,
        )
        self._fill(rows, pairs, told)
        outcome, reason = told["outcome"], told["reason"]
        for where, what, why in (
            (rows.faults != "", INVALID, rows.faults),
            (alone, LEADING, np.full(len(frame), LEADS, dtype=object)),
        ):
            outcome[where], reason[where] = what, why[where]
        kept = frame.drop(columns=[name for name in told if name in frame])
        told_frame = pd.DataFrame(
            {name: pd.Series(values, index=frame.index, dtype=values.dtype) for name, values in told.items()}
        )
        if not asked.pairs:
            told_frame = told_frame.drop(columns="leader")
        return pd.concat([kept, told_frame], axis=1)

    def behind(self, bird: Bird) -> Behind:
        """Return the follower's problem of a bird."""
        if bird not in self._behind:
            if len(self._behind) > 200:
                self._behind.clear()
            try:
                self._behind[bird] = Behind(
                    bird,
                    self.asked.objective,
                    model=self.asked.model,
                    bounds=self.asked.bounds,
                    leader=self.asked.leader_of(bird),
                    phase_lock=self.asked.phase_lock,
                )
            except ValueError as error:
                raise UpwashError(str(error)) from error
        return self._behind[bird]

    def _fill(self, rows: Rows, pairs: Pairs, told: dict[str, NDArray]) -> None:
        """Evaluate the rows of each kind of bird together."""
        inputs = np.column_stack([rows.value(name) for name in ("mass_kg", "speed_m_s", "period_s")])
        good = np.flatnonzero((rows.faults == "") & (np.diff(pairs.first) > 0))
        if not good.size:
            return
        kinds, of_kind = np.unique(inputs[good], axis=0, return_inverse=True, equal_nan=True)
        for number, kind in enumerate(kinds):
            members = good[of_kind.ravel() == number]
            given = {
                name: float(value)
                for name, value in zip(("mass_kg", "speed_m_s", "period_s"), kind, strict=True)
                if np.isfinite(value)
            }
            try:
                bird = self.asked.bird_with(**given)
            except UpwashError as error:
                rows.faults[members] = str(error)
                continue
            self._fill_kind(self.behind(bird), members, rows, pairs, told)

    def _fill_kind(
        self, behind: Behind, members: NDArray[np.int64], rows: Rows, pairs: Pairs, told: dict[str, NDArray]
    ) -> None:
        counts = np.diff(pairs.first)[members]
        chosen = np.concatenate([np.arange(pairs.first[row], pairs.first[row + 1]) for row in members])
        places = pairs.places[chosen]
        first = np.concatenate([[0], np.cumsum(counts)])
        free_height, free_phase = (np.add.reduceat(np.isnan(places[:, k]), first[:-1]) > 0 for k in (2, 3))
        # Where the height of any bird is not known, all are taken to be level with it.
        known = places.copy()
        known[np.repeat(free_height, counts), 2] = 0.0
        known[np.repeat(free_phase, counts), 3] = 0.0
        # Where phases are averaged there is none to choose.
        free_phase &= behind.phase_lock
        errors = self._errors(members, rows, behind.bird)
        errors = None if errors is None else behind.felt_places(errors)
        birds = Birds(behind.felt_places(known), first, free_height, free_phase, errors)
        found = survey(behind, birds, self.jobs)
        at = known[first[:-1]]
        at[:, 2] += found.height_m
        at[:, 3] = (at[:, 3] + found.phase) % 1.0
        values = of_places(behind, at) | of_strokes(behind, found)
        values |= {
            "saving_total_low": found.low,
            "saving_total_high": found.high,
            "balanced_nearby": found.balanced_nearby,
            "saving_best_phase": np.where(free_phase, values["saving_total"], np.nan),
            "saving_mean_phase": found.mean_phase,
            "saving_worst_phase": found.worst_phase,
            "saving_mean_height": found.mean_height,
            "saving_worst_height": found.worst_height,
            "balanced_share": found.balanced_share,
        }
        values |= self._beside_optimum(behind, values)
        for name, column in values.items():
            told[name][members] = column

    def _errors(self, members: NDArray[np.int64], rows: Rows, bird: Bird) -> NDArray[np.float64] | None:
        """Return the standard deviations of each row's place, or None if none are asked for."""
        asked = self.asked
        length = asked.sigma * bird.semispan_m if asked.sigma is not None else asked.sigma_m
        names = ("sigma_x_m", "sigma_y_m", "sigma_z_m", "sigma_phase")
        if length is None and asked.sigma_phase is None and not any(name in rows.values for name in names):
            return None
        usual = [*[length or 0.0] * 3, asked.sigma_phase or 0.0]
        found = [
            np.where(np.isfinite(rows.value(name)[members]), rows.value(name)[members], one)
            for name, one in zip(names, usual, strict=True)
        ]
        return np.column_stack(found)

    def _beside_optimum(self, behind: Behind, values: Mapping[str, NDArray]) -> dict[str, NDArray]:
        optimum = self.optimum(behind.bird)
        if optimum is None:
            return {}
        pose, wavelength = optimum.pose, behind.leader.wavelength_m
        along = values["x_m"] - pose.x_m
        if behind.model.is_endless and not behind.phase_lock:
            along = np.zeros_like(along)
        elif behind.model.is_endless:
            apart = along / wavelength - (values["phase"] - pose.phase)
            along = wavelength * (apart - np.round(apart))
        across, up = np.abs(values["y_m"]) - abs(pose.y_m), values["z_m"] - pose.z_m
        count = len(along)
        return {
            "saving_at_v_optimum": np.full(count, optimum.saving),
            "share_of_attainable": values["saving_total"] / optimum.saving,
            "distance_to_optimum_m": np.sqrt(along**2 + across**2 + up**2),
        }

    def optimum(self, bird: Bird) -> _Optimum | None:
        """Return the V optimum of a bird, or None if it has none, or that of too many birds was sought."""
        if not self.asked.finds_optimum:
            return None
        if bird not in self._optima:
            if len(self._optima) >= MOST_OPTIMA:
                self.optima_left_out = True
                return None
            self._optima[bird] = self._sought(bird)
        return self._optima[bird]

    def _sought(self, bird: Bird) -> _Optimum | None:
        try:
            solution = solve_pair(
                bird,
                self.asked.objective,
                model=self.asked.model,
                search=SearchSettings(tolerance=1e-2),
                leader=self.asked.leader_of(bird),
                phase_lock=self.asked.phase_lock,
            )
        except ValueError:
            # Of this model no optimum can be searched.
            return None
        best = solution.v_optimum
        return _Optimum(best.saving_total, best.pose) if best else None


def evaluate(
    bird: Bird | Species,
    table: pd.DataFrame,
    *,
    model: WakeModel | None = None,
    objective: str = "power",
    bounds: str = "wide",
    reading: Reading | None = None,
    pairs: bool = False,
    wake: str = "neighbour",
    heading_deg: float | None = None,
    sigma: float | None = None,
    sigma_m: float | None = None,
    sigma_phase: float | None = None,
    finds_optimum: bool = True,
    leader: Bird | Species | None = None,
    phase_lock: bool = True,
    jobs: int = 1,
) -> pd.DataFrame:
    """Return what observed birds save where they fly.

    Parameters
    ----------
    bird : Bird or Species
        The bird that leads and follows; with a species, the mass, speed or period of a row also changes the amplitude,
        by its convention.
    table : DataFrame
        One row a bird: ``x_m`` behind its leader and ``y_m`` to the right of it, and maybe ``z_m`` above, ``phase``,
        ``speed_m_s``, ``period_s``, ``mass_kg``, standard deviations ``sigma_x_m`` … ``sigma_phase``, and any others.
        What is missing of height and phase is optimised.
    model : WakeModel, optional
        The wake; the paper's if not given.
    objective : str
        Name of the cost that a bird makes least.
    bounds : str
        ``wide`` or ``paper``: within which its stroke is sought.
    reading : Reading, optional
        Other names, units and conventions of the table.
    pairs, wake, heading_deg
        Whether the table holds positions of all birds at each time (``time``, ``bird``, ``x_m``, ``y_m`` …), whose
        wakes are felt then (``neighbour`` or ``all-upstream``), and where they fly to, see
        `upwash.study.observed.pairs.pair_up`.
    sigma, sigma_m, sigma_phase : float, optional
        Standard deviations of x, y, z, in semispans or in m, and of the phase in wingbeats: the saving is then told
        with its quantiles of 5 and 95 %.
    finds_optimum : bool
        Whether the V optimum is sought as well, and each bird compared with it.
    leader : Bird or Species, optional
        The bird ahead, if it is another; at the follower's speed and in its air.
    phase_lock : bool
        Whether birds beat in step, in the leader's period; else each in its own, averaged over all phases.
    jobs : int
        How many threads share the work.

    Returns
    -------
    DataFrame
        The table's columns, but for those of `EVALUATION`, which follow, in the order of its rows.

    Raises
    ------
    UpwashError
        If a column is missing, all of the table is in another unit, or an option is wrong.

    Examples
    --------
    >>> import pandas as pd
    >>> from upwash import load_species
    >>> seen = pd.DataFrame({"name": ["Amy", "Bob"], "x_m": [1.2, 1.2], "y_m": [0.9, -0.9], "z_m": [0.0, 0.0]})
    >>> told = evaluate(load_species("northern-bald-ibis").bird(), seen, finds_optimum=False)
    >>> told[["name", "outcome", "saving_total"]].round(3).to_dict("list")
    {'name': ['Amy', 'Bob'], 'outcome': ['saves', 'saves'], 'saving_total': [0.002, 0.002]}
    """
    asked = Asked(
        bird,
        model or WakeModel(),
        objective,
        bounds,
        reading or Reading(),
        pairs,
        wake,
        heading_deg,
        sigma,
        sigma_m,
        sigma_phase,
        finds_optimum=finds_optimum,
        leader=leader,
        phase_lock=phase_lock,
    )
    return Evaluation(asked, jobs)(table)


def _nothing(column: Column, count: int) -> NDArray:
    if column.type == of.FLOAT:
        return np.full(count, np.nan)
    if column.type == of.INTEGER:
        return np.zeros(count, np.int64)
    return np.full(count, None, dtype=object)
