"""What a row of results stands for: its bird, the forces in each pair of stroke states, the optimum to show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from math import inf
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.interaction import state_forces
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel

Row = Mapping[str, Any] | pd.Series


def bird_of(row: Row) -> Bird:
    """Return the bird of a row: the lone leader, which sets weight, drag and circulation."""
    return Bird(
        mass_kg=row["mass_kg"],
        semispan_m=row["semispan_m"],
        speed_m_s=row["speed_m_s"],
        period_s=row["period_s"],
        density_kg_m3=row["density_kg_m3"],
        gravity_m_s2=row["gravity_m_s2"],
        amplitude_m=row["leader_amplitude_m"],
        upstroke_span_ratio=row["leader_upstroke_span_ratio"],
        circulation_ratio=row["circulation_ratio"],
    )


def pose_of(row: Row) -> Pose:
    """Return where and how the follower of a row flies, relative to the bird ahead."""
    stroke = Stroke(row["amplitude_m"], row["upstroke_span_ratio"])
    return Pose(row["x_m"], row["y_m"], row["z_m"], stroke, row["phase"])


def model_of(row: Row) -> WakeModel:
    """Return how the wakes of a row are resolved."""
    parts = of.told({entry.name: row[entry.name] for entry in fields(WakeModel)})
    return WakeModel(
        **parts | {"wavelengths": inf if parts["wavelengths"] == "endless" else parts["wavelengths"]}
    )


def objectives_of(rows: pd.DataFrame) -> list[str]:
    """Return the objectives that rows were solved for, in the order in which figures show them."""
    return [name for name in COST_FUNCTIONS if (rows["objective"] == name).any()]


def best(rows: pd.DataFrame, objective: str) -> pd.Series:
    """Return the optimum to show of a problem: the V optimum, or where there is none the global one."""
    of_it = rows[rows["objective"] == objective]
    in_v = of_it[of_it["is_v_optimum"].fillna(False).astype(bool)]
    return (in_v if len(in_v) else of_it.sort_values("rank")).iloc[0]


def state_forces_of(row: Row) -> NDArray[np.float64]:
    """Return the wake's force on a follower in each pair of stroke states.

    Returns
    -------
    (2, 2, 2) ndarray of float
        By the leader's state and the follower's (up, then down): lift and thrust, in N.
    """
    return state_forces(bird_of(row), bird_of(row).stroke, pose_of(row), model_of(row))
