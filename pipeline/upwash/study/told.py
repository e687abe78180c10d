"""What is told of a follower at a place: the columns, and what follows from the strokes that balance there."""

from __future__ import annotations

from functools import partial
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from upwash import columns as of
from upwash.columns import Column
from upwash.optimum.variables import LEAST_AMPLITUDE, SPAN_RATIO_BOUNDS
from upwash.place.balance import MISSING, Behind

SAVES, PAYS, NO_BALANCE, LEADING, INVALID = "saves", "pays", "no-balance", "leads", "invalid"
OUTCOMES = (SAVES, PAYS, NO_BALANCE, LEADING, INVALID)
"""What may come out for a bird."""

_saving = partial(Column, unit="1", format=".2f", percent=True)
_ratio = partial(Column, unit="1")
_truth = partial(Column, unit="", type=of.TRUTH)

EVALUATION = (
    Column("leader", "", "nearest bird ahead, in a table of all birds", type=of.TEXT),
    *(of.column(name) for name in ("x_m", "y_m", "z_m", "phase", "spatial_phase")),
    Column("outcome", "", "saves, pays, no-balance, leads or invalid", type=of.TEXT),
    Column("reason", "", "why nothing balances, or what is wrong with the row", type=of.TEXT),
    of.column("saving_total"),
    of.column("saving_induced"),
    of.column("saving_profile"),
    _saving(
        "saving_total_low", head="low", description="saving with the place off by its errors: quantile of 5 %"
    ),
    _saving("saving_total_high", head="high", description="the same: quantile of 95 %"),
    _ratio(
        "balanced_nearby", description="share of the places within the errors at which something balances"
    ),
    _saving("saving_best_phase", description="saving with the best phase, where none is given"),
    _saving(
        "saving_mean_phase",
        head="mean",
        description="mean saving over the phases that balance, where none is given",
    ),
    _saving("saving_worst_phase", head="worst", description="least saving over those phases"),
    _saving(
        "saving_mean_height",
        description="mean saving within half the leader's amplitude, where z_m is missing",
    ),
    _saving("saving_worst_height", description="least saving over those heights that balance"),
    _ratio("balanced_share", description="share of those phases and heights at which something balances"),
    of.column("cost"),
    of.column("amplitude_m"),
    of.column("upstroke_span_ratio"),
    _ratio(
        "amplitude_to_alone",
        head="h/alone",
        format=".3f",
        description="needed amplitude over that of the bird alone",
    ),
    _ratio(
        "upstroke_span_ratio_to_alone", description="needed upstroke span ratio over that of the bird alone"
    ),
    Column("solutions", "1", "strokes that balance; the cheapest is told", type=of.INTEGER),
    _saving(
        "saving_at_v_optimum", description="saving at the V optimum, the same bird's and by the same model"
    ),
    _ratio("share_of_attainable", description="saving over that at the V optimum"),
    Column(
        "distance_to_optimum_m",
        "m",
        "from the V optimum; along the wake by the spatial phase where the wake is endless",
    ),
    _truth(
        "wings_overlap",
        description="nearer than a wingspan aside, so that the wings overlap across the flight path",
    ),
    _truth("beyond_wake", description="behind the end of the wake"),
    _truth("outside_paper_bounds", description="stroke beyond the bounds that the paper searches"),
)
"""Columns of what is evaluated, after those of the table that are passed through."""


class Balanced(Protocol):
    """What balances at n places: how many strokes, what is missing, and the cheapest stroke."""

    @property
    def count(self) -> NDArray[np.int64]:
        """How many strokes balance, (n,)."""

    @property
    def missing(self) -> NDArray[np.int64]:
        """What keeps the others from balancing, keys of `MISSING`, (n,)."""

    @property
    def missing_share(self) -> NDArray[np.float64]:
        """How much of it, over weight or drag, (n,)."""

    @property
    def amplitude_m(self) -> NDArray[np.float64]:
        """Amplitude of the cheapest stroke, (n,)."""

    @property
    def span_ratio(self) -> NDArray[np.float64]:
        """Its upstroke span ratio, (n,)."""

    @property
    def cost(self) -> NDArray[np.float64]:
        """Its cost over that of the lone bird, (n,)."""


def of_places(behind: Behind, places: NDArray[np.float64]) -> dict[str, NDArray]:
    """Return what is told of places alone.

    Parameters
    ----------
    behind : Behind
        The follower.
    places : (n, 4) ndarray of float
        x, y, z in m and the phase.
    """
    x, y, z, phase = places.T
    spatial = x / behind.leader.wavelength_m - phase
    spatial -= np.ceil(spatial - 0.5)
    if not behind.phase_lock:
        phase = spatial = np.full(len(x), np.nan)
    return {
        "x_m": x,
        "y_m": y,
        "z_m": z,
        "phase": phase,
        "spatial_phase": spatial,
        "wings_overlap": np.abs(y) < behind.bird.semispan_m + behind.leader.semispan_m,
        "beyond_wake": x > behind.model.wavelengths * behind.leader.wavelength_m,
    }


def of_strokes(behind: Behind, found: Balanced) -> dict[str, NDArray]:
    """Return what follows from the strokes that balance: outcome, savings, cost and the cheapest stroke."""
    power, bird, b = behind.felt.power, behind.bird, behind.bird.semispan_m
    lift = power.lift_fixed + power.lift_ratio * found.span_ratio
    thrust = found.amplitude_m / b * (power.thrust_fixed + power.thrust_ratio * found.span_ratio)
    saving = 1.0 - (power.cost_lift2 * lift**2 + power.cost_thrust * thrust + power.cost_fixed)
    outcome = np.where(saving > 0.0, SAVES, PAYS).astype(object)
    outcome[found.count == 0] = NO_BALANCE
    return {
        "outcome": outcome,
        "reason": _reasons(found),
        "saving_total": saving,
        "saving_induced": 1.0 - lift**2,
        "saving_profile": 1.0 - thrust / power.drag,
        "cost": found.cost * behind.leader_cost,
        "amplitude_m": found.amplitude_m,
        "upstroke_span_ratio": found.span_ratio,
        "amplitude_to_alone": found.amplitude_m / bird.amplitude_m,
        "upstroke_span_ratio_to_alone": found.span_ratio / bird.upstroke_span_ratio,
        "solutions": found.count,
        "outside_paper_bounds": _outside(behind, found),
    }


def _reasons(found: Balanced) -> NDArray[np.object_]:
    reasons = np.full(len(found.count), None, dtype=object)
    for row in np.flatnonzero(found.count == 0):
        what = MISSING[int(found.missing[row])]
        of_what = "weight" if what.endswith("lift") else "drag"
        amount = f"{100.0 * found.missing_share[row]:.2g} % of the {of_what}"
        if what.startswith("less "):
            reasons[row] = f"too much {what.removeprefix('less ')}, by {amount}"
        else:
            reasons[row] = f"short of {what}, by {amount}"
    return reasons


def _outside(behind: Behind, found: Balanced) -> NDArray[np.object_]:
    """Return whether strokes are beyond the paper's bounds; None where there is none."""
    limit, slack = behind.amplitude_limit_m, 1e-9
    low, high = SPAN_RATIO_BOUNDS
    outside = (found.amplitude_m < (LEAST_AMPLITUDE - slack) * limit) | (
        found.amplitude_m > (1.0 + slack) * limit
    )
    outside |= (found.span_ratio < low - slack) | (found.span_ratio > high + slack)
    told = outside.astype(object)
    told[found.count == 0] = None
    return told
