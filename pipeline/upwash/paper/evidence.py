"""What claims are judged by: the paper's pair, its flocks, and the pair at other airspeeds and in the limit."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import pi, sin
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.field_map import PLANES, force_map
from upwash.aero.wake import NAMES, WakeModel
from upwash.errors import UpwashError
from upwash.study.field import grid
from upwash.study.quantities import with_quantities
from upwash.study.rows import Row, bird_of, model_of, pose_of, state_forces_of
from upwash.study.sources import read_study

PAPER_BIRD = Bird(
    mass_kg=1.3,
    semispan_m=0.6,
    speed_m_s=15.0,
    period_s=0.25,
    density_kg_m3=1.29,
    gravity_m_s2=9.8,
    amplitude_m=2.0 * 0.6 * sin(pi / 3.0),
    upstroke_span_ratio=0.4,
)
"""The northern bald ibis of the paper's Results."""

OBJECTIVES = ("force", "power")
READINGS = ("immediate", "lone")
BIRDS = 6
"""The paper's cost functions; the two readings of its bound on a flock's amplitudes; the birds of its flock."""

FLOCKS, SPEEDS, LIMIT = "paper-flocks", "group-speed", "limit"
"""Sweeps whose results, beside those of the pair, tell of flocks, of other airspeeds, and of the pair in the limit."""

LAWS = ("stroke", "tip")
"""Span laws, between which nothing yet decides."""

LEAST_SPEEDS = 5
"""Airspeeds from which the best one can be told."""

MAP_SIZE = 241
"""Points along each side of a force map."""

# Column of the results -> what it must be for the bird to be the paper's.
_INPUTS = {
    "mass_kg": PAPER_BIRD.mass_kg,
    "semispan_m": PAPER_BIRD.semispan_m,
    "speed_m_s": PAPER_BIRD.speed_m_s,
    "period_s": PAPER_BIRD.period_s,
    "density_kg_m3": PAPER_BIRD.density_kg_m3,
    "gravity_m_s2": PAPER_BIRD.gravity_m_s2,
    "leader_amplitude_m": PAPER_BIRD.amplitude_m,
    "leader_upstroke_span_ratio": PAPER_BIRD.upstroke_span_ratio,
    "circulation_ratio": PAPER_BIRD.circulation_ratio,
}


@dataclass(frozen=True)
class ForceRatios:
    """Net force over a plane through an optimum, and the optimum's own without the wake's.

    Attributes
    ----------
    lift, thrust : (m, n) ndarray of float
        Vertical force over weight, thrust over drag; rows are y, z or phase, columns x from 0 to 1.5 λ.
    own_lift, own_thrust : float
        The follower's own part of each.
    """

    lift: NDArray[np.float64]
    thrust: NDArray[np.float64]
    own_lift: float
    own_thrust: float


@dataclass(frozen=True)
class Evidence:
    """The frames that claims are measured in.

    Attributes
    ----------
    pair : DataFrame
        All optima of the pair, for each of `OBJECTIVES`.
    flocks : dict
        Objective and reading -> a flock of `BIRDS` in an echelon, one row a bird from the first.
    speeds : DataFrame or None
        All optima of the pair for least power at several airspeeds.
    limit : dict
        Span law -> all optima of the pair in the limit, for each of `OBJECTIVES`.
    """

    pair: pd.DataFrame
    flocks: Mapping[tuple[str, str], pd.DataFrame] = field(default_factory=dict)
    speeds: pd.DataFrame | None = None
    limit: Mapping[str, pd.DataFrame] = field(default_factory=dict)

    def missing(self, name: str) -> str:
        """Say what has to be run before a field of this evidence can be used; empty if nothing."""
        frame = getattr(self, name)
        if frame is not None and len(frame):
            return ""
        sweep = {"flocks": FLOCKS, "speeds": SPEEDS, "limit": LIMIT}[name]
        return f"needs results/{sweep} beside these results: run and aggregate the sweep {sweep}"

    @cached_property
    def bird(self) -> Bird:
        """The bird of the pair."""
        return bird_of(self.pair.iloc[0])

    @cached_property
    def model(self) -> WakeModel:
        """How the wakes of the pair are resolved."""
        return model_of(self.pair.iloc[0])

    @cached_property
    def in_limit(self) -> dict[str, Evidence]:
        """Span law -> the evidence of the pair in the limit, in the place of the paper's."""
        return {law: Evidence(rows) for law, rows in self.limit.items()}

    @cached_property
    def _labelled(self) -> dict[tuple[str, str], dict[str, Any]]:
        """Objective and label -> the optimum's row, or one without values where there is no such optimum."""
        rows = with_quantities(self.pair)
        found = {
            (objective, label): rows[(rows["objective"] == objective) & rows[label].eq(True)]
            for objective in OBJECTIVES
            for label in ("is_v_optimum", "is_global_optimum")
        }
        nothing = dict.fromkeys(rows.columns, np.nan)
        return {key: dict(optima.iloc[0]) if len(optima) else nothing for key, optima in found.items()}

    def has_v(self, objective: str) -> bool:
        """Whether there is a V optimum."""
        return bool(pd.notna(self.v(objective)["cost"]))

    @property
    def without_v(self) -> list[str]:
        """Objectives that have no V optimum."""
        return [objective for objective in OBJECTIVES if not self.has_v(objective)]

    @property
    def mapped(self) -> str:
        """Objective through whose V optimum the paper's maps go: least force, where it has one."""
        return next(objective for objective in OBJECTIVES if self.has_v(objective))

    def v(self, objective: str) -> Row:
        """Return the V optimum, with the columns of `upwash.study.quantities`; NaN in each if there is none."""
        return self._labelled[objective, "is_v_optimum"]

    def best(self, objective: str) -> Row:
        """Return the global optimum, with the columns of `upwash.study.quantities`."""
        return self._labelled[objective, "is_global_optimum"]

    def of_v(self, column: str, factor: float = 1.0) -> dict[str, float]:
        """Return a column of the V optimum for each objective."""
        return {objective: factor * float(self.v(objective)[column]) for objective in OBJECTIVES}

    def flock_cases(self, column: str) -> dict[str, NDArray[np.float64]]:
        """Return a column of each flock, one value a bird."""
        return {
            f"{objective}, {reading}": flock[column].to_numpy(float)
            for (objective, reading), flock in self.flocks.items()
        }

    @cached_property
    def forces(self) -> dict[str, NDArray[np.float64]]:
        """Wake-induced lift and thrust at the V optimum in each pair of stroke states, (2, 2, 2) in N."""
        return {objective: state_forces_of(self.v(objective)) for objective in OBJECTIVES}

    def wake_over(
        self, objective: str, plane: str, x_m: ArrayLike, across: ArrayLike, **place: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return wake-induced lift and thrust over a plane, with the stroke of a V optimum.

        Parameters
        ----------
        objective : str
            Whose V optimum.
        plane : str
            ``xy``, ``xz`` or ``xk``.
        x_m, across : array_like of float
            Coordinates of its columns and rows; y and z in m.
        **place : float
            Position ``x``, ``y`` or ``z`` in m that differs from the optimum's.

        Returns
        -------
        tuple of (m, n) ndarray of float
            Lift and thrust, in N; NaN if there is no such V optimum.
        """
        if not self.has_v(objective):
            nothing = np.full((np.size(across), np.size(x_m)), np.nan)
            return nothing, nothing
        bird, pose = self.bird, pose_of(self.v(objective))
        x, y, z = (place.get(axis, value) for axis, value in zip("xyz", pose.position_m, strict=True))
        pose = replace(pose, x_m=x, y_m=y, z_m=z)
        plane_map = force_map(bird, bird.stroke, pose, plane, x_m, across, self.model)
        lift, thrust = bird.self_force_n(pose.stroke)
        return plane_map.lift_n - lift, plane_map.thrust_n - thrust

    @cached_property
    def maps(self) -> dict[str, ForceRatios]:
        """Net force in the three planes through the V optimum of least force, as the paper maps it.

        Where least force has no V optimum, through that of least power.
        """
        bird, row = self.bird, self.v(self.mapped)
        own_lift, own_thrust = row["lift_self_n"] / bird.weight_n, row["thrust_self_n"] / bird.drag_n
        maps = {}
        for plane in PLANES:
            streamwise, across = grid(bird, plane, MAP_SIZE)
            lift, thrust = self.wake_over(self.mapped, plane, streamwise, across)
            maps[plane] = ForceRatios(
                own_lift + lift / bird.weight_n, own_thrust + thrust / bird.drag_n, own_lift, own_thrust
            )
        return maps


def beside(results: Path) -> list[Path]:
    """Return where the results of flocks, airspeeds and the limit are, or would be, for those of the pair."""
    parent = results.parent if results.name not in ("", "..") else results.resolve().parent
    return [parent / name for name in (FLOCKS, SPEEDS, LIMIT)]


def read_evidence(results: str | Path) -> Evidence:
    """Read the evidence from a results folder and, where they are, those beside it that it needs.

    Raises
    ------
    UpwashError
        If there is no such gathered folder, or it does not hold the paper's pair.
    """
    folder = Path(results)
    others = [path for path in beside(folder) if path.is_dir() and path.resolve() != folder.resolve()]
    studies = [read_study(path) for path in (folder, *others)]
    try:
        return gather_evidence([study.rows for study in studies])
    except UpwashError as error:
        raise UpwashError(f"{results}: {error}") from error


def gather_evidence(frames: Iterable[pd.DataFrame]) -> Evidence:
    """Find the evidence in frames of results.

    Parameters
    ----------
    frames : iterable of DataFrame
        Rows of ``solutions.parquet`` or ``flock.parquet``; what is not of the paper's bird is passed over.

    Raises
    ------
    UpwashError
        If the paper's pair is not among them with a V optimum for each of its objectives.
    """
    frames = [frame for frame in frames if len(frame)]
    of_pairs = [frame for frame in frames if "bird" not in frame]
    pairs = pd.concat(of_pairs, ignore_index=True) if of_pairs else pd.DataFrame(columns=["model", *_INPUTS])
    # A job may be in more than one of them.
    pairs = pairs.drop_duplicates(["job_id", "rank"]) if of_pairs else pairs
    pair = _of_paper(pairs)
    pair = pair[pair["status"] == of.SOLVED] if len(pair) else pair
    pair = _first_job_of_each(pair, "objective") if len(pair) else pair
    for objective in OBJECTIVES:
        if pair.empty or not (pair["is_v_optimum"].eq(True) & (pair["objective"] == objective)).any():
            raise UpwashError(
                f"expected the V optimum of the paper's pair for least {objective}, found none; "
                "run and aggregate the sweep reproduce"
            )
    flocks = _flocks([frame for frame in frames if "bird" in frame])
    return Evidence(pair, flocks, _speeds(pairs), _limit(pairs))


def _of_paper(rows: pd.DataFrame, free: tuple[str, ...] = ()) -> pd.DataFrame:
    """Return the rows whose inputs are the paper's, but for those that are free."""
    return _of_bird(rows[rows["model"] == NAMES[0]], free)


def _of_bird(rows: pd.DataFrame, free: tuple[str, ...] = ()) -> pd.DataFrame:
    """Return the rows whose bird is the paper's, but for what is free."""
    same = pd.Series(True, index=rows.index)
    for name, value in _INPUTS.items():
        if name not in free:
            same &= np.isclose(rows[name].astype(float), value, rtol=1e-9, atol=0.0)
    return rows[same]


def _first_job_of_each(rows: pd.DataFrame, column: str) -> pd.DataFrame:
    """Return the rows of one job for each value of a column: jobs may differ in seed and tolerance alone."""
    return rows[rows["job_id"].isin(rows.drop_duplicates(column)["job_id"])]


def _flocks(frames: list[pd.DataFrame]) -> dict[tuple[str, str], pd.DataFrame]:
    """Return the complete flocks that are built as the paper's."""
    flocks: dict[tuple[str, str], pd.DataFrame] = {}
    for frame in frames:
        for _, flock in frame.groupby("flock_id", sort=False):
            flock = flock.sort_values("bird", ignore_index=True)
            first = flock.iloc[0]
            is_whole = len(flock) == BIRDS and bool((flock["status"] == of.SOLVED).all())
            is_chain = (first["shape"], first["wake"]) == ("echelon", "neighbour")
            if is_whole and is_chain and len(_of_paper(flock.head(1))):
                flocks.setdefault((first["objective"], first["reading"]), flock)
    wanted = [(objective, reading) for objective in OBJECTIVES for reading in READINGS]
    # Half of the flocks would give claims that hold in every case that was looked at.
    return {key: flocks[key] for key in wanted} if set(wanted) <= set(flocks) else {}


def _speeds(pairs: pd.DataFrame) -> pd.DataFrame | None:
    """Return the pairs that differ from the paper's in airspeed alone, for least power."""
    rows = _of_paper(pairs, free=("speed_m_s",))
    if rows.empty:
        return None
    rows = rows[(rows["objective"] == "power") & (rows["status"] == of.SOLVED)]
    with_v = rows[rows["is_v_optimum"].eq(True)]
    rows = _first_job_of_each(rows[rows["job_id"].isin(with_v["job_id"])], "speed_m_s")
    return rows if rows["speed_m_s"].nunique() >= LEAST_SPEEDS else None


def _limit(pairs: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the optima of the paper's pair in the limit by span law, if all are there."""
    rows = _of_bird(pairs)
    rows = (
        rows[(rows["status"] == of.SOLVED) & np.isinf(rows["wavelengths"].astype(float))]
        if len(rows)
        else rows
    )
    limit = WakeModel.named("limit").resolving(PAPER_BIRD.wavelength_m / PAPER_BIRD.semispan_m)
    wanted = {law: replace(limit, span_law=law) for law in LAWS}
    models = [model_of(row) for _, row in rows.iterrows()]
    found = {}
    for law, model in wanted.items():
        of_law = rows[[one == model for one in models]] if len(rows) else rows
        of_law = _first_job_of_each(of_law, "objective") if len(of_law) else of_law
        if set(OBJECTIVES) <= set(of_law["objective"] if len(of_law) else ()):
            found[law] = of_law
    return found if len(found) == len(LAWS) else {}
