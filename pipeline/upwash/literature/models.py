"""The two models, solved for the birds that the literature is about: what the ledger measures in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import Optimum
from upwash.place.balance import Balance, Behind
from upwash.species.library import load_species

Cases = Mapping[str, float]
"""Case -> our value in it."""

_LIMIT = WakeModel.named("limit")

CASES: dict[str, dict[str, tuple[WakeModel, str]]] = {
    "paper": {
        "least force": (WakeModel.named("paper"), "force"),
        "least power": (WakeModel.named("paper"), "power"),
    },
    "limit": {
        "stroke law": (_LIMIT, "power"),
        "tip law": (replace(_LIMIT, span_law="tip"), "power"),
    },
}
"""Model -> case -> the wake and what is least. In the limit least force has no V, and the span law is least known."""

LEAST_POWER = {
    model: {case: wake for case, (wake, objective) in cases.items() if objective == "power"}
    for model, cases in CASES.items()
}
"""Model -> case -> the wake, where power is least."""

IBIS = "northern-bald-ibis"

# Verdicts are on what is found; proofs are the sweeps' business, and take most of a job's time.
_SEARCH = SearchSettings(most_boxes=1)

PHASES = 96
"""Phases that are tried at a given place."""


@cache
def bird_of(species: str, **changed: Any) -> Bird:
    """Return a species' bird, its amplitude by its stroke angle."""
    return load_species(species).bird(**changed)


@cache
def v_optimum(bird: Bird, objective: str, wake: WakeModel) -> Optimum | None:
    """Return the V optimum, or None if there is none."""
    return solve_pair(bird, objective, model=wake, search=_SEARCH).v_optimum


@cache
def _behind(bird: Bird, wake: WakeModel) -> Behind:
    return Behind(bird, "power", model=wake)


def balances_at(
    bird: Bird, wake: WakeModel, x_m: float, y_m: float, z_m: float = 0.0
) -> list[tuple[float, Balance | None]]:
    """Return the cheapest stroke with which a bird balances at a place, phase by phase, by least power.

    Returns
    -------
    list of (float, Balance or None)
        Each phase, and the cheapest balance there if there is one.
    """
    behind = _behind(bird, wake)
    phases = (np.arange(PHASES) / PHASES).tolist()
    return [(phase, next(iter(behind.balances([(x_m, y_m, z_m, phase)]).strokes), None)) for phase in phases]


@cache
def best_phase(bird: Bird, wake: WakeModel, x_m: float, y_m: float, z_m: float = 0.0) -> tuple[float, float]:
    """Return the phase with which least power is spent at a place, and the cost there over the lone bird's.

    Both are not a number where no phase balances.
    """
    found = [(b.cost, phase) for phase, b in balances_at(bird, wake, x_m, y_m, z_m) if b]
    return min(found)[::-1] if found else (float("nan"), float("nan"))


def wrapped(phase: float) -> float:
    """Return a phase in [−½, ½)."""
    return (phase + 0.5) % 1.0 - 0.5
