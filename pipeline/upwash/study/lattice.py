"""What an unsteady vortex lattice says of an ibis behind another, beside both models: a stored run, read."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.place.balance import Behind

PHASES = 8
"""Phases, in equal steps, at each place where all were flown."""

MIDDLE = 0.48
"""Wavelengths behind at which followers fly at several distances aside."""

MODELS = {
    "paper": WakeModel.named("paper"),
    "stroke law": WakeModel.named("limit"),
    "tip law": replace(WakeModel.named("limit"), span_law="tip"),
}


def followers(flights: pd.DataFrame) -> pd.DataFrame:
    """Return the followers that their leaders do not feel, on the grid that most have."""
    lone = flights[flights["role"] == "alone"].iloc[0]
    grid = ["chordwise", "spanwise", "steps", "beats"]
    return flights[(flights["role"] == "follower") & (flights[grid] == lone[grid]).all(axis=1)]


def phase_sweeps(flights: pd.DataFrame) -> Iterator[tuple[float, float, float, pd.DataFrame]]:
    """Give half-angle, distance behind and aside in m, and the followers at each place where all phases were flown."""
    found = followers(flights)
    # Others at the same place, in phase with the leader's path, are of the row of distances aside.
    found = found[np.isclose(found["phase"] * PHASES, np.round(found["phase"] * PHASES))]
    for _, group in found.groupby(["half_angle_deg", "x_m", "y_m"]):
        if len(group) == PHASES:
            angle, x, y = group[["half_angle_deg", "x_m", "y_m"]].to_numpy()[0].tolist()
            yield angle, x, y, group.sort_values("phase")


def best_phases(flights: pd.DataFrame, wavelength_m: float) -> pd.DataFrame:
    """Return the best phase at each place where all phases were flown, by the saving's first harmonic.

    Parameters
    ----------
    flights : DataFrame
        Rows of ``results/crosscheck/uvlm.parquet``.
    wavelength_m : float
        The birds' wavelength.

    Returns
    -------
    DataFrame
        ``half_angle_deg, x_wavelengths, y_m, best_phase`` in wingbeats, and ``best_saving, mean_saving,
        worst_saving`` of the phases flown.

    Examples
    --------
    >>> flown = pd.DataFrame({"role": "follower", "half_angle_deg": 60.0, "x_m": 1.0, "y_m": 0.9, "z_m": 0.0,
    ...     "phase": np.arange(8) / 8, "saving": 0.02 + 0.03 * np.cos(2 * np.pi * (np.arange(8) / 8 - 0.3)),
    ...     "chordwise": 3, "spanwise": 8, "steps": 40, "beats": 2})
    >>> lone = flown.iloc[:1].assign(role="alone")
    >>> round(float(best_phases(pd.concat([lone, flown]), 4.0)["best_phase"].iloc[0]), 3)
    0.3
    """
    rows = [
        {
            "half_angle_deg": angle,
            "x_wavelengths": x / wavelength_m,
            "y_m": y,
            "best_phase": float(-np.angle(np.fft.rfft(swept["saving"])[1]) / (2.0 * np.pi) % 1.0),
            "best_saving": swept["saving"].max(),
            "mean_saving": swept["saving"].mean(),
            "worst_saving": swept["saving"].min(),
        }
        for angle, x, y, swept in phase_sweeps(flights)
    ]
    return pd.DataFrame(rows).sort_values(["half_angle_deg", "x_wavelengths"], ascending=[False, True])


def aside(flights: pd.DataFrame, bird: Bird) -> pd.DataFrame:
    """Return what followers save at several distances aside, in phase with the leader's path, beside both models.

    Parameters
    ----------
    flights : DataFrame
        Rows of ``results/crosscheck/uvlm.parquet``.
    bird : Bird
        The bird that was flown; its amplitude follows from each half-angle.

    Returns
    -------
    DataFrame
        ``half_angle_deg, y_m, saving`` of the lattice's shaft power, and of the total power by each model; missing
        where no stroke balances.
    """
    found = followers(flights)
    spatial = found["x_m"] / bird.wavelength_m - found["phase"]
    found = found[np.isclose(found["x_m"], MIDDLE * bird.wavelength_m) & np.isclose(spatial, 0.0)]
    return beside_models(found.sort_values(["half_angle_deg", "y_m"], ascending=[False, True]), bird)


def beside_models(found: pd.DataFrame, bird: Bird) -> pd.DataFrame:
    """Return followers with the saving of total power by each model at their places."""
    shown = found[["half_angle_deg", "x_m", "y_m", "z_m", "phase", "saving"]].reset_index(drop=True)
    places = shown[["half_angle_deg", "x_m", "y_m", "z_m", "phase"]].to_numpy().tolist()
    for name, model in MODELS.items():
        shown[name] = [
            _model_saving(_flapping(bird, angle), model, (x, y, z, phase)) for angle, x, y, z, phase in places
        ]
    return shown


def _flapping(bird: Bird, half_angle_deg: float) -> Bird:
    amplitude = 2.0 * bird.semispan_m * math.sin(math.radians(half_angle_deg))
    return replace(bird, amplitude_m=amplitude)


def _model_saving(bird: Bird, model: WakeModel, place: tuple[float, float, float, float]) -> float:
    strokes = Behind(bird, "power", model=model).balances([place]).strokes
    return 1.0 - float(strokes[0].cost) if strokes else math.nan


def grids(flights: pd.DataFrame) -> pd.DataFrame:
    """Return what is saved at one place on each grid that was tried, the coarsest first."""
    finer = (
        flights[flights["role"] == "follower"]
        .groupby(["x_m", "y_m", "phase"])
        .filter(lambda group: len(group[["chordwise", "spanwise", "steps", "beats"]].drop_duplicates()) > 1)
    )
    shown = finer[["chordwise", "spanwise", "steps", "beats", "saving"]]
    return shown.sort_values(["chordwise", "spanwise", "steps", "beats"]).reset_index(drop=True)
