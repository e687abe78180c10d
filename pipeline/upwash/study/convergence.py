"""How far the limit is converged: forces and savings against steps, points of the span and length of the wake."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.interaction import wake_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.optimum.variables import LEAST_AMPLITUDE, SPAN_RATIO_BOUNDS

LIMIT = WakeModel.named("limit")
STEPS = (16, 32, 64, 128, 256)
"""Numbers of steps that are tried."""

FINEST = replace(LIMIT, stroke_states=960)
"""Taken for converged, by either span law: 960 Gauss–Legendre points."""

ASIDE = 2.5
"""How far aside of the leader places are drawn, in semispans."""

STARTS = 64
"""Starts of a search for the best of one model."""


def random_poses(bird: Bird, count: int, seed: int = 0) -> list[Pose]:
    """Return places and strokes of followers, drawn evenly: within a wavelength, to 2.5 semispans aside, level or not.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> random_poses(ibis, 2) == random_poses(ibis, 2)
    True
    """
    rng = np.random.default_rng(seed)
    poses = []
    for x, y, z, amplitude, ratio, phase in rng.random((count, 6)).tolist():
        low, high = SPAN_RATIO_BOUNDS
        stroke = Stroke(
            bird.amplitude_m * (LEAST_AMPLITUDE + (1.0 - LEAST_AMPLITUDE) * amplitude),
            low + (high - low) * ratio,
        )
        place = x * bird.wavelength_m, y * ASIDE * bird.semispan_m, (z - 0.5) * bird.amplitude_m
        poses.append(Pose(*place, stroke, phase))
    return poses


def force_errors(
    bird: Bird, poses: Sequence[Pose], models: Iterable[WakeModel], converged: WakeModel = FINEST
) -> pd.DataFrame:
    """Return how far the wake's force by each model is from the converged one.

    Parameters
    ----------
    bird : Bird
        The bird.
    poses : sequence of Pose
        Where and how it flies.
    models : iterable of WakeModel
        The models that are tried.
    converged : WakeModel
        What is taken for true; its span law is made that of each model.

    Returns
    -------
    DataFrame
        One row a model: its parts, and the root mean square error of lift and of thrust over that of the true ones.
    """
    truth: dict[str, np.ndarray] = {}
    rows = []
    for model in models:
        if model.span_law not in truth:
            truth[model.span_law] = _forces(bird, poses, replace(converged, span_law=model.span_law))
        true = truth[model.span_law]
        error = np.sqrt(np.mean((_forces(bird, poses, model) - true) ** 2, axis=0))
        lift, thrust = error / np.sqrt(np.mean(true**2, axis=0))
        rows.append(vars(model) | {"lift_error": float(lift), "thrust_error": float(thrust)})
    return pd.DataFrame(rows)


def savings(bird: Bird, objective: str, models: Iterable[WakeModel]) -> pd.DataFrame:
    """Return what the best follower behind an endless wake saves by each model.

    Parameters
    ----------
    bird : Bird
        The bird.
    objective : str
        Name of a cost.
    models : iterable of WakeModel
        Models with an endless wake and the exact span.

    Returns
    -------
    DataFrame
        One row a model: its parts, the cost that the best saves over the lone bird's, and its place: spatial phase,
        y over the semispan, z over the amplitude.  The best is that of 64 starts, and of one at the best of the model
        before.
    """
    rows: list[dict[str, object]] = []
    known: list[np.ndarray] = []
    for model in models:
        problem = EndlessProblem(bird, objective, model=model)
        search = EndlessSearch(problem)
        search.explore(np.concatenate([*known, search.random_starts(problem.bounds, STARTS)]))
        best = search.basins[0]
        known = [best.point[None, :]]
        rows.append(
            vars(model)
            | {
                "saving": 1.0 - best.cost,
                "spatial_phase": problem.spatial_phase(best.point),
                "y_semispans": float(best.point[1]),
                "z_amplitudes": float(best.point[2]) / problem.leader_height,
            }
        )
    return pd.DataFrame(rows)


def with_orders(frame: pd.DataFrame, columns: Mapping[str, float | None], by: Sequence[str]) -> pd.DataFrame:
    """Add the order at which columns converge with the number of steps: log2 of the ratio of errors when it doubles.

    Parameters
    ----------
    frame : DataFrame
        Rows of `force_errors` or `savings`.
    columns : mapping
        Column -> what it converges to, or None for that of the last row of a group, which then has no error.
    by : sequence of str
        Columns that tell groups apart; within one, rows follow one another by doubled `stroke_states`.

    Returns
    -------
    DataFrame
        With a column more for each, ``…_order``; NaN in the first row of a group and where there is no error.
    """
    frame = frame.copy()
    for name, end in columns.items():
        groups = frame.groupby(list(by), sort=False)[name]
        error = (frame[name] - (groups.transform("last") if end is None else end)).abs()
        before = error.groupby([frame[key] for key in by], sort=False).shift()
        with np.errstate(divide="ignore", invalid="ignore"):
            order = np.log2(before / error)
        frame[f"{name}_order"] = order.where(np.isfinite(order))
    return frame


def long_wakes(
    bird: Bird, pose: Pose, distances: Iterable[float], wavelengths: Iterable[int], model: WakeModel = LIMIT
) -> pd.DataFrame:
    """Return what a follower feels behind wakes that begin at the leader, against what it feels of the endless one.

    Parameters
    ----------
    bird : Bird
        The bird.
    pose : Pose
        A follower; at each distance its phase is such that it flies in the same spatial phase.
    distances : iterable of float
        Distances behind the leader, in wavelengths.
    wavelengths : iterable of int
        Lengths of wakes; a wake that would end before the follower is left out.
    model : WakeModel
        How else the wake is resolved.

    Returns
    -------
    DataFrame
        One row a distance and a length: thrust over the endless wake's, less 1, and lift less the endless wake's, over
        that thrust.
    """
    spatial = pose.x_m / bird.wavelength_m - pose.phase
    endless = replace(model, wavelengths=math.inf)
    rows = []
    for distance in distances:
        at = replace(pose, x_m=distance * bird.wavelength_m, phase=(distance - spatial) % 1.0)
        lift, thrust = wake_force(bird, bird.stroke, at, endless)
        for length in wavelengths:
            if length <= distance:
                continue
            ending = wake_force(bird, bird.stroke, at, replace(model, wavelengths=length))
            rows.append(
                {
                    "x_wavelengths": distance,
                    "wavelengths": length,
                    "thrust_gap": ending[1] / thrust - 1.0,
                    "lift_gap": (ending[0] - lift) / thrust,
                }
            )
    return pd.DataFrame(rows)


def _forces(bird: Bird, poses: Sequence[Pose], model: WakeModel) -> np.ndarray:
    return np.array([wake_force(bird, bird.stroke, pose, model) for pose in poses])
