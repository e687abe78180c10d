"""Upwash: optimal formation flight of flapping birds from a minimal wake-vortex model.

The names below load when they are first used, so that ``import upwash`` (and with it ``upwash --help``)
costs nothing:

>>> from upwash import load_species, solve_pair
>>> solution = solve_pair(load_species("northern-bald-ibis").bird(), "power")
>>> print(f"{solution.v_optimum.saving_total:.1%}")
16.6%
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from upwash.aero.bird import Bird
    from upwash.aero.interaction import wake_force
    from upwash.aero.pose import Pose, Stroke
    from upwash.aero.wake import WakeModel
    from upwash.optimum.flock import solve_flock
    from upwash.optimum.pair import solve_pair
    from upwash.optimum.settings import FlockRules, SearchSettings
    from upwash.optimum.spacing import Spacing
    from upwash.species import load_species
    from upwash.study.observed.evaluation import evaluate
    from upwash.study.saving_map import map_savings

__version__ = "0.1.0"
__all__ = [
    "Bird",
    "FlockRules",
    "Pose",
    "SearchSettings",
    "Spacing",
    "Stroke",
    "WakeModel",
    "evaluate",
    "load_species",
    "map_savings",
    "solve_flock",
    "solve_pair",
    "wake_force",
]

_HOME = {
    "Bird": "upwash.aero.bird",
    "FlockRules": "upwash.optimum.settings",
    "Pose": "upwash.aero.pose",
    "SearchSettings": "upwash.optimum.settings",
    "Spacing": "upwash.optimum.spacing",
    "Stroke": "upwash.aero.pose",
    "WakeModel": "upwash.aero.wake",
    "evaluate": "upwash.study.observed.evaluation",
    "load_species": "upwash.species",
    "map_savings": "upwash.study.saving_map",
    "solve_flock": "upwash.optimum.flock",
    "solve_pair": "upwash.optimum.pair",
    "wake_force": "upwash.aero.interaction",
}


def __getattr__(name: str) -> Any:
    """Import a public name from the module it lives in, on first use."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOME[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
