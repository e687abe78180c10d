"""When a follower should flap: its best phase against its distance, in a V and in line, and what ibises do.

Portugal et al. (2014) found ibises in a V spatially in phase (their wingtips retrace the path of the leader's) and
those straight behind another spatially in antiphase.  Here a follower keeps its place aside and its height, takes every
phase in turn, and flaps as it must to balance there, with as much amplitude as two wings have.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.columns import TEXT, Column
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.place.balance import Behind

V, IN_LINE = "V", "in line"
"""Formations: at the place aside of the V optimum, and straight behind at the leader's height."""

DISTANCES = (0.25, 0.5, 0.75, 1.0)
"""How far behind, in wavelengths."""

PHASES = 48
"""Phases of a wingbeat that are tried at each distance."""

SHARPNESS = 1e-4
"""How closely the best phase is found, in wingbeats."""

CURVE = (
    of.column("model"),
    of.column("span_law"),
    Column("formation", "", f"{V} or {IN_LINE}", TEXT),
    of.column("x_m"),
    Column(
        "x_wavelengths", "1", "follower downstream of its leader, in wavelengths", format=".2f", head="x/λ"
    ),
    of.column("y_m"),
    of.column("z_m"),
    of.column("phase"),
    of.column("spatial_phase"),
    Column("amplitude_m", "m", "amplitude with which it balances there; absent if none does"),
    Column(
        "upstroke_span_ratio", "1", "upstroke span ratio with which it balances there; absent if none does"
    ),
    Column(
        "saving_cost",
        "1",
        "share of the lone bird's cost saved there, negative if it pays; absent if it cannot fly",
    ),
    Column(
        "missing",
        "",
        "what it would need to balance: lift, thrust, less lift or less thrust; empty if it flies",
        TEXT,
    ),
)
"""Columns of `phase_curve`, one row a formation, distance and phase."""

RULE = (
    *CURVE[:7],
    Column("phase_best", "1", "phase in which it saves most, or pays least", format=".3f"),
    Column(
        "spatial_phase_best", "1", "spatial phase x/lambda - kappa of that, from -0.5 to 0.5", format="+.3f"
    ),
    Column("saving_best", "1", "share of the lone bird's cost saved then", percent=True, format=".1f"),
    Column(
        "spatial_phase_worst",
        "1",
        "spatial phase in which it pays most, or the middle of those in which it cannot fly",
    ),
    Column(
        "saving_worst",
        "1",
        "share of the lone bird's cost saved in the worst phase; absent if it cannot fly there",
    ),
    Column("share_without_balance", "1", "share of all phases in which it cannot fly"),
    Column("harmonic_phase", "1", "spatial phase at which the first harmonic of the cost is least"),
    Column("harmonic_size", "1", "amplitude of that harmonic, as a share of the lone bird's cost"),
    Column("as_observed", "", "whether that is as ibises do, nearly enough to count as that", of.TRUTH),
)
"""Columns of `phase_rule`, one row a formation and distance."""


def phase_curve(
    bird: Bird,
    objective: str,
    model: WakeModel,
    places: Mapping[str, tuple[float, float]],
    distances: Iterable[float] = DISTANCES,
    count: int = PHASES,
) -> pd.DataFrame:
    """Return what a follower saves in every phase, at several distances.

    Parameters
    ----------
    bird : Bird
        The bird.
    objective : str
        Name of a cost function.
    model : WakeModel
        The wake.
    places : mapping
        Formation -> y and z, in m.
    distances : iterable of float
        How far behind, in wavelengths.
    count : int
        Phases of a wingbeat; the best of each distance and formation is added to them.

    Returns
    -------
    DataFrame
        The columns of `CURVE`.
    """
    behind = Behind(bird, objective, model=model, bounds="wide")
    rows = []
    for formation, (y, z) in places.items():
        for distance in distances:
            follower = _Follower(behind, formation, distance, y, z)
            tried = [follower.row(phase) for phase in np.arange(count) / count]
            costs = np.array([-row["saving_cost"] for row in tried])
            if np.isfinite(costs).any():
                tried.append(
                    follower.row(follower.best_near(float(np.nanargmin(costs)) / count, 1.0 / count))
                )
            rows += tried
    frame = pd.DataFrame(rows, columns=[column.name for column in CURVE])
    # One model by either span law.
    name = replace(model, span_law="stroke").name(bird.wavelength_m / bird.semispan_m)
    return frame.assign(model=name if model.is_endless else model.name(1.0), span_law=model.span_law)


@dataclass(frozen=True)
class _Follower:
    """A follower at one place, of which the phase is free."""

    behind: Behind
    formation: str
    distance: float
    y_m: float
    z_m: float

    def row(self, phase: float) -> dict[str, Any]:
        """Return what it saves in one phase, by the columns of `CURVE`."""
        wavelength = self.behind.bird.wavelength_m
        phase = phase % 1.0
        found = self.behind.balances([(self.distance * wavelength, self.y_m, self.z_m, phase)])
        best = found.strokes[0] if found.strokes else None
        return {
            "formation": self.formation,
            "x_m": self.distance * wavelength,
            "x_wavelengths": self.distance,
            "y_m": self.y_m,
            "z_m": self.z_m,
            "phase": phase,
            "spatial_phase": wrapped(self.distance - phase),
            "amplitude_m": best.stroke.amplitude_m if best else np.nan,
            "upstroke_span_ratio": best.stroke.span_ratio if best else np.nan,
            "saving_cost": 1.0 - best.cost if best else np.nan,
            "missing": found.missing,
        }

    def best_near(self, phase: float, step: float) -> float:
        """Return the best phase within a step of one that is known to be nearly the best."""

        def cost(at: float) -> float:
            saving = float(self.row(at)["saving_cost"])
            # Where it cannot fly is worse than anywhere.
            return -saving if np.isfinite(saving) else np.inf

        found = minimize_scalar(
            cost, bounds=(phase - step, phase + step), method="bounded", options={"xatol": SHARPNESS}
        )
        return float(found.x) if found.fun <= cost(phase) else phase


def wrapped(phase: float) -> float:
    """Return a phase between −½ and ½."""
    return float(phase - np.ceil(phase - 0.5))


def phase_rule(curve: pd.DataFrame) -> pd.DataFrame:
    """Return the best and the worst phase at each distance, and the first harmonic of the cost.

    Parameters
    ----------
    curve : DataFrame
        As `phase_curve` returns.

    Returns
    -------
    DataFrame
        The columns of `RULE`.
    """
    rows = []
    for _, group in curve.groupby(["model", "span_law", "formation", "x_wavelengths"], sort=False):
        flies = group[group["saving_cost"].notna()]
        grounded = group[group["saving_cost"].isna()]
        row: dict[str, Any] = {column.name: group.iloc[0][column.name] for column in RULE[:7]}
        row["share_without_balance"] = len(grounded) / len(group)
        if len(flies):
            best = flies.sort_values("saving_cost", kind="stable").iloc[-1]
            row |= {"phase_best": best["phase"], "spatial_phase_best": best["spatial_phase"]}
            row["saving_best"] = best["saving_cost"]
            row["harmonic_phase"], row["harmonic_size"] = _first_harmonic(
                flies["spatial_phase"].to_numpy(float), -flies["saving_cost"].to_numpy(float)
            )
        if len(grounded):
            row["spatial_phase_worst"] = _middle(grounded["spatial_phase"].to_numpy(float))
        else:
            worst = flies.sort_values("saving_cost", kind="stable").iloc[0]
            row |= {"spatial_phase_worst": worst["spatial_phase"], "saving_worst": worst["saving_cost"]}
        row["as_observed"] = bool(judge_rules(pd.DataFrame([{**_ABSENT, **row}]))["holds"].all())
        rows.append(row)
    return pd.DataFrame(rows, columns=[column.name for column in RULE])


_ABSENT = {column.name: np.nan for column in RULE}


def phase_rules(
    bird: Bird, objective: str, models: Iterable[WakeModel], search: SearchSettings
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the phase rule of a bird in some models of the wake, and all the phases that were tried.

    In a V it flies where its V optimum is; without one, the V is left out.

    Parameters
    ----------
    bird : Bird
        The bird.
    objective : str
        Name of a cost function.
    models : iterable of WakeModel
        The wakes.
    search : SearchSettings
        How to search for the V optimum.

    Returns
    -------
    tuple of DataFrame
        The columns of `RULE`, and those of `CURVE`.
    """
    curves = []
    for model in models:
        v = solve_pair(bird, objective, model=model, search=search).v_optimum
        places = {V: (float(v.pose.y_m), float(v.pose.z_m))} if v else {}
        curves.append(phase_curve(bird, objective, model, {**places, IN_LINE: (0.0, 0.0)}))
    curve = pd.concat(curves, ignore_index=True)
    return phase_rule(curve), curve


def _middle(phases: NDArray[np.float64]) -> float:
    """Return the middle of some phases on the circle."""
    return wrapped(float(np.angle(np.mean(np.exp(2j * np.pi * phases)))) / (2.0 * np.pi))


def _first_harmonic(phases: NDArray[np.float64], cost: NDArray[np.float64]) -> tuple[float, float]:
    """Return where the first harmonic of a cost is least, and its size, fitted where there is a cost."""
    if len(phases) < 3:
        return np.nan, np.nan
    angle = 2.0 * np.pi * phases
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    (_, cosine, sine), *_ = np.linalg.lstsq(design, cost, rcond=None)
    return wrapped(float(np.arctan2(-sine, -cosine)) / (2.0 * np.pi)), float(np.hypot(cosine, sine))


# Portugal et al. (2014) say in phase and in antiphase: how near a model must come to count as that.
NEAR_IN_V, NEAR_IN_LINE, NEAR_WORST = 0.06, 0.2, 0.1

VERDICTS = (
    Column("rule", "", "what was observed, or goes with it", TEXT),
    Column("ours", "", "what is measured for it", TEXT),
    Column("value", "1", "our value, the one furthest from the rule over all distances", format=".3f"),
    Column("limit", "1", "how far from the rule it may be", format=".2f"),
    Column("holds", "", "whether it is no further", of.TRUTH),
)
"""Columns of `judge_rules`."""


def judge_rules(rule: pd.DataFrame) -> pd.DataFrame:
    """Judge the observed phase rules by the phases that are best, at all distances.

    Parameters
    ----------
    rule : DataFrame
        As `phase_rule` returns.

    Returns
    -------
    DataFrame
        The columns of `VERDICTS`; a rule on a formation that is not there is left out.
    """
    rows: list[tuple[str, str, float, float]] = []
    of_v, in_line = (rule[rule["formation"] == formation] for formation in (V, IN_LINE))
    if len(of_v):
        away = of_v["spatial_phase_best"].abs().max(skipna=False)
        rows.append(("in a V in phase", "|Φ| of the best phase", away, NEAR_IN_V))
    if len(in_line):
        from_half = (0.5 - in_line["spatial_phase_best"].abs()).max(skipna=False)
        worst = in_line["spatial_phase_worst"].abs().max(skipna=False)
        saving = in_line["saving_best"].max()
        rows += [
            ("in line in antiphase", "½ − |Φ| of the best phase", from_half, NEAR_IN_LINE),
            ("in line worst in phase", "|Φ| of the worst phase, or of no balance", worst, NEAR_WORST),
            ("in line always at a cost", "saving in the best phase", saving, 0.0),
        ]
    frame = pd.DataFrame(rows, columns=[column.name for column in VERDICTS[:-1]])
    return frame.assign(holds=frame["value"] <= frame["limit"])
