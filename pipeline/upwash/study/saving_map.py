"""A map of what a follower saves: at each place of a plane the least cost, with the best of what is free there."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.pose import Pose
from upwash.aero.wake import WakeModel
from upwash.batch.store import TABLE_OPTIONS, provenance, replacing
from upwash.errors import UpwashError
from upwash.jobs.schema import schema_of
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.optimum.variables import STREAMWISE_REACH
from upwash.place.balance import Behind
from upwash.place.choices import COORDINATES, PLANES, STROKE
from upwash.place.least import least_over
from upwash.study.told import EVALUATION, of_places, of_strokes

SPANWISE = 3.0
"""Reach of a map to the side, in semispans."""

SIZE = 200
"""Places along each side."""

SAME = 1e-9
"""Costs that differ by a smaller share are one."""

NAMES = {"x": "x_m", "y": "y_m", "z": "z_m", "phase": "phase"}
"""Coordinates -> the columns that hold them."""

_TOLD = (
    *("x_m", "y_m", "z_m", "phase", "spatial_phase", "outcome", "reason"),
    *("saving_total", "saving_induced", "saving_profile", "cost", "amplitude_m", "upstroke_span_ratio"),
    *("amplitude_to_alone", "upstroke_span_ratio_to_alone", "solutions"),
    *("wings_overlap", "beyond_wake", "outside_paper_bounds"),
)
_BY_NAME = {column.name: column for column in EVALUATION}

MAP = tuple(_BY_NAME[name] for name in _TOLD)
"""Columns of a map, one row a place."""


@dataclass(frozen=True)
class Asked:
    """What is asked of a map.

    Parameters
    ----------
    plane : str
        A key of `PLANES`.
    over : iterable of str, optional
        What is free at each place, of `COORDINATES` and the stroke, which always is; height, phase and stroke if not
        given, as far as the plane does not show them.
    held : mapping of str to float, optional
        What other coordinates are, in m and wingbeats; as at the V optimum if not given.
    ranges : mapping of str to (float, float), optional
        From where to where the plane's sides go; over the range that is searched, and `SPANWISE` aside, if not given.
    size : int
        Places along each side.

    Raises
    ------
    UpwashError
        If they do not fit together.
    """

    plane: str = "xy"
    over: Iterable[str] | None = None
    held: Mapping[str, float] | None = None
    ranges: Mapping[str, tuple[float, float]] | None = None
    size: int = SIZE

    def __post_init__(self) -> None:
        if self.plane not in PLANES:
            raise UpwashError(f"plane: expected one of {', '.join(PLANES)}, found {self.plane!r}")
        if not (isinstance(self.size, int) and self.size >= 2):
            raise UpwashError(f"size: expected a whole number of at least 2, found {self.size!r}")
        for name in self.over or ():
            if name not in (*COORDINATES, STROKE):
                known = ", ".join((*COORDINATES, STROKE))
                raise UpwashError(f"over: expected some of {known}, found {name!r}")
            if name in self.sides:
                raise UpwashError(
                    f"over: expected what the plane {self.plane} does not show, found {name}; leave it out"
                )
        if self.over is not None and STROKE not in self.over:
            raise UpwashError(
                "over: expected the stroke among them, as it follows from the balances, found none; "
                "add stroke, or see `upwash field` for the force at one stroke"
            )
        for name, value in (self.held or {}).items():
            if name in (*self.sides, *self.free):
                raise UpwashError(
                    f"{NAMES[name]}: expected LOW,HIGH or nothing, as it varies here, found {value:g}; "
                    "name another plane, or leave it out of what is free (over)"
                )
            _check(name, value)
        for name, (low, high) in (self.ranges or {}).items():
            if name not in self.sides:
                raise UpwashError(
                    f"{NAMES[name]}: expected one number, as the plane {self.plane} does not show it, found "
                    f"{low:g},{high:g}"
                )
            if not low < high:
                raise UpwashError(f"{NAMES[name]}: expected the lower end first, found {low:g},{high:g}")
            _check(name, low)
            _check(name, high)

    @property
    def sides(self) -> tuple[str, str]:
        """The coordinates along the plane's two sides."""
        return PLANES[self.plane]

    @property
    def free(self) -> tuple[str, ...]:
        """The coordinates that are free."""
        over = ("z", "phase") if self.over is None else tuple(self.over)
        return tuple(name for name in COORDINATES if name in over and name not in self.sides)

    @property
    def fixed(self) -> tuple[str, ...]:
        """The coordinates that are neither shown nor free."""
        return tuple(name for name in COORDINATES if name not in (*self.sides, *self.free))


@dataclass(frozen=True)
class SavingMap:
    """What a follower saves over a plane.

    Attributes
    ----------
    bird, objective, model, bounds
        Of what it is.
    asked : Asked
        What was asked.
    first, second : (n,) ndarray of float
        Coordinates of the columns and of the rows, in m or wingbeats.
    held : dict of str to float
        The coordinates that are neither shown nor free.
    values : dict of str to (n, n) ndarray
        The columns of `MAP`, each over the plane: [row, column].
    optimum : Pose or None
        The V optimum by the paper's bounds; None if there is none, or it was not sought.
    """

    bird: Bird
    objective: str
    model: WakeModel
    bounds: str
    asked: Asked
    first: NDArray[np.float64]
    second: NDArray[np.float64]
    held: dict[str, float]
    values: dict[str, NDArray]
    optimum: Pose | None

    def frame(self) -> pd.DataFrame:
        """Return the map as a data frame, one row a place, row by row."""
        return pd.DataFrame({name: values.ravel() for name, values in self.values.items()})

    def to_xarray(self) -> Any:
        """Return the map as an xarray data set, labelled by the plane's coordinates, with units.

        Raises
        ------
        UpwashError
            If xarray is not installed.
        """
        try:
            import xarray
        except ImportError as error:
            raise UpwashError(
                "to_xarray: expected xarray, found it not installed; pip install 'upwash[xarray]'"
            ) from error
        first, second = (NAMES[name] for name in self.asked.sides)
        about = {column.name: {"units": column.unit, "long_name": column.description} for column in MAP}
        return xarray.Dataset(
            {
                name: ((second, first), values, about[name])
                for name, values in self.values.items()
                if name not in (first, second)
            },
            coords={first: (first, self.first, about[first]), second: (second, self.second, about[second])},
            attrs=self.said(),
        )

    def said(self) -> dict[str, str]:
        """Return what the map is of, as texts."""
        best = self.optimum
        return {
            "plane": self.asked.plane,
            "over": ",".join((*self.asked.free, STROKE)),
            "held": json.dumps({NAMES[name]: value for name, value in self.held.items()}),
            "objective": self.objective,
            "bounds": self.bounds,
            "model": str(self.model),
            "bird": str(self.bird),
            "v_optimum": json.dumps(
                None
                if best is None
                else dict(zip(NAMES.values(), (*best.position_m, best.phase), strict=True))
            ),
        }

    def best(self) -> dict[str, float] | None:
        """Return where on the map the cost is least, and what is saved there; None if nothing balances anywhere."""
        cost = self.values["cost"].ravel()
        if np.all(np.isnan(cost)):
            return None
        # Along an endless wake many places are equally good: of those the one in their middle.
        least = np.flatnonzero(cost <= np.nanmin(cost) * (1.0 + SAME))
        at = least[least.size // 2]
        return {name: float(self.values[name].ravel()[at]) for name in (*NAMES.values(), "saving_total")}

    def shows_optimum(self) -> bool:
        """Whether the V optimum lies in the plane."""
        if self.optimum is None:
            return False
        at = _coordinates(self.optimum)
        return all(math.isclose(at[name], value, abs_tol=1e-9) for name, value in self.held.items())

    def write(self, path: Path, said: Mapping[str, str]) -> None:
        """Write the map as Parquet, with units and what it is of, whole or not at all.

        Parameters
        ----------
        path : Path
            The file.
        said : mapping of str to str
            What its metadata say besides.
        """
        metadata = provenance("") | self.said() | dict(said)
        table = pa.Table.from_pandas(
            self.frame(), schema=schema_of(MAP).with_metadata(metadata), preserve_index=False
        )
        with replacing(path) as unfinished:
            pq.write_table(table, unfinished, **TABLE_OPTIONS | {"write_statistics": True})


def map_savings(
    bird: Bird,
    plane: str = "xy",
    *,
    over: Iterable[str] | None = None,
    held: Mapping[str, float] | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    size: int = SIZE,
    model: WakeModel | None = None,
    objective: str = "power",
    bounds: str = "wide",
    search: SearchSettings | None = None,
    finds_optimum: bool = True,
    jobs: int = 1,
    told: Callable[[int, int], None] | None = None,
) -> SavingMap:
    """Map what a follower saves: at each place of a plane the least cost, with the best of what is free there.

    Parameters
    ----------
    bird : Bird
        The bird that leads and follows.
    plane : str
        ``xy`` (from above), ``xz`` (from the side), ``yz`` (from behind) or ``xk`` (distance and phase).
    over : iterable of str, optional
        What is free at each place: some of ``x, y, z, phase`` and always ``stroke``; height, phase and stroke if not
        given, as far as the plane does not show them.  Heights are sought within half the leader's amplitude, x and y
        as far as a search goes.
    held : mapping of str to float, optional
        What the other coordinates are, as in ``{"z": 0.0}``, in m and wingbeats; as at the V optimum if not given.
    ranges : mapping of str to (float, float), optional
        From where to where the plane's sides go.
    size : int
        Places along each side.
    model : WakeModel, optional
        The wake; the paper's if not given.
    objective : str
        Name of the cost that is least.
    bounds : str
        ``wide`` or ``paper``: within which the stroke is sought.
    search : SearchSettings, optional
        How the V optimum is sought.
    finds_optimum : bool
        Whether it is sought though nothing depends on it.
    jobs : int
        How many threads share the work.
    told : callable, optional
        Called with how many pieces of work are done, and of how many.

    Returns
    -------
    SavingMap
        The same for any number of threads.

    Raises
    ------
    UpwashError
        If an option is wrong, in this model no optimum can be searched, or there is no V optimum to go through.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> found = map_savings(ibis, size=8, ranges={"x": (0.5, 3.5), "y": (0.6, 1.3)}, finds_optimum=False)
    >>> found.values["saving_total"].shape
    (8, 8)
    >>> found.frame()["outcome"].value_counts().to_dict()
    {'saves': 49, 'pays': 15}
    """
    asked, model = Asked(plane, over, held, ranges, size), model or WakeModel()
    try:
        behind = Behind(bird, objective, model=model, bounds=bounds)
        lacking = [name for name in asked.fixed if name not in (asked.held or {})]
        optimum = _v_optimum(bird, objective, model, search) if lacking or finds_optimum else None
        fixed = dict(asked.held or {})
        if lacking:
            if optimum is None:
                names = ", ".join(NAMES[name] for name in lacking)
                raise UpwashError(
                    f"{names}: expected a value, as there is no V optimum to take it of, found none"
                )
            fixed |= {name: value for name, value in _coordinates(optimum).items() if name in lacking}
        first, second = (_side(name, bird, asked) for name in asked.sides)
        places = np.zeros((size, size, len(COORDINATES)))
        for name, value in fixed.items():
            places[..., COORDINATES.index(name)] = value
        places[..., COORDINATES.index(asked.sides[0])] = first
        places[..., COORDINATES.index(asked.sides[1])] = second[:, None]
        found = least_over(behind, places, asked.free, jobs, told)
    except ValueError as error:
        raise UpwashError(str(error)) from error
    columns = of_places(behind, found.places) | of_strokes(behind, found)
    values = {column.name: columns[column.name].reshape(size, size) for column in MAP}
    return SavingMap(bird, objective, model, bounds, asked, first, second, fixed, values, optimum)


def _v_optimum(bird: Bird, objective: str, model: WakeModel, search: SearchSettings | None) -> Pose | None:
    solution = solve_pair(bird, objective, model=model, search=search or SearchSettings(tolerance=1e-2))
    return solution.v_optimum.pose if solution.v_optimum else None


def _coordinates(pose: Pose) -> dict[str, float]:
    return dict(zip(COORDINATES, (*pose.position_m, pose.phase), strict=True))


def _side(name: str, bird: Bird, asked: Asked) -> NDArray[np.float64]:
    """Return the coordinates along a side of a plane."""
    usual = {
        "x": (0.0, STREAMWISE_REACH * bird.wavelength_m),
        "y": (0.0, SPANWISE * bird.semispan_m),
        "z": (-bird.amplitude_m, bird.amplitude_m),
        "phase": (0.0, 1.0),
    }
    low, high = (asked.ranges or {}).get(name, usual[name])
    return np.linspace(low, high, asked.size)


def _check(name: str, value: float) -> None:
    """Refuse a coordinate that no follower has."""
    if not math.isfinite(value):
        raise UpwashError(f"{NAMES[name]}: expected a finite number, found {value}")
    if name == "x" and value < 0.0:
        raise UpwashError(f"x_m: expected distances behind the leader, found {value:g}, ahead of it")
    if name == "phase" and not 0.0 <= value <= 1.0:
        raise UpwashError(f"phase: expected wingbeats from 0 to 1, found {value:g}")
