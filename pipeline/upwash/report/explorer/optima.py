"""The best places that the explorer takes a follower to: kept of each species of the library, searched for others."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.optimum.pair import solve_pair

KEPT = "optima.csv"
"""Optima of the library's species; ``python tools/renew_explorer.py`` renews them."""

MODELS = ("paper", "limit")
OBJECTIVES = ("force", "power")
"""Costs whose optima are kept; the cost of transport has the optima of power."""

IN_THE_V, ANYWHERE = "v", "global"


@dataclass(frozen=True)
class BestPlace:
    """Where a follower does best, and how it flaps there.

    Attributes
    ----------
    kind : str
        ``v``, the best in the V formation, or ``global``, the best of all.
    x_m, y_m, z_m : float
        Behind, right of and above the leader, in m.
    phase : float
        Lag behind the leader, in wingbeats.
    amplitude_m, upstroke_span_ratio : float
        Its stroke.
    saving_total : float
        Share of the lone bird's power that it saves.
    """

    kind: str
    x_m: float
    y_m: float
    z_m: float
    phase: float
    amplitude_m: float
    upstroke_span_ratio: float
    saving_total: float


def solve_best_places(bird: Bird, model: str, objective: str) -> list[BestPlace]:
    """Search the best places of a bird behind another, and prove them.

    Parameters
    ----------
    bird : Bird
        Leader and follower.
    model : str
        ``paper`` or ``limit``.
    objective : str
        Name of a cost function.

    Returns
    -------
    list of BestPlace
        The V optimum and the global one; either may be missing.
    """
    wake = WakeModel.named(model).resolving(bird.wavelength_m / bird.semispan_m)
    found = solve_pair(bird, objective, model=wake)
    best = {IN_THE_V: found.v_optimum, ANYWHERE: found.global_optimum}
    return [
        BestPlace(
            kind,
            *one.pose.position_m,
            one.pose.phase % 1.0,
            one.pose.stroke.amplitude_m,
            one.pose.stroke.span_ratio,
            one.saving_total,
        )
        for kind, one in best.items()
        if one is not None
    ]


def _leader(bird: Bird) -> dict[str, float]:
    """Return a bird's inputs by column."""
    return {f"leader_{name}": value for name, value in asdict(bird).items()}


@cache
def _kept() -> pd.DataFrame:
    with (files("upwash.report.explorer") / KEPT).open(encoding="utf-8") as file:
        return pd.read_csv(file)


def best_places(
    bird: Bird, model: str, objective: str, solving: Callable[[], None] = lambda: None
) -> list[BestPlace]:
    """Return the best places of a bird: kept ones if it is a species' own, and else searched.

    Parameters
    ----------
    bird, model, objective
        As for `solve_best_places`.
    solving : callable
        Called before a search, which takes seconds.
    """
    weights, kept = COST_FUNCTIONS[objective], _kept()
    # At one airspeed the body's power is what it is, and a cost over the distance is the power over the speed.
    alike = "power" if weights.force == 0.0 and weights.induced == weights.profile else objective
    asked = _leader(bird) | {"model": model, "objective": alike}
    rows = kept[np.logical_and.reduce([kept[name] == value for name, value in asked.items()])]
    if rows.empty:
        solving()
        return solve_best_places(bird, model, objective)
    names = [entry.name for entry in fields(BestPlace)]
    # A bird for which there is no place at all keeps one row without any.
    return [BestPlace(**row) for row in rows[names].dropna().to_dict("records")]  # type: ignore[arg-type]


def kept_rows(
    bird: Bird, species: str, places: dict[tuple[str, str], list[BestPlace]]
) -> list[dict[str, Any]]:
    """Return what is kept of a species, by model and objective."""
    rows: list[dict[str, Any]] = []
    for (model, objective), found in places.items():
        key = {"species": species, "model": model, "objective": objective} | _leader(bird)
        rows += [key | asdict(one) for one in found] or [key]
    return rows
