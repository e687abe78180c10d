"""Upwash: optimal formation flight of flapping birds from a minimal wake-vortex model.

The names below load when they are first used, so that ``import upwash`` (and with it ``upwash --help``)
costs nothing:

>>> from upwash import load_species, solve_pair  # doctest: +SKIP
>>> solve_pair(load_species("northern-bald-ibis").bird()).rows()[0]["saving_total"]  # doctest: +SKIP
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from upwash.aero.bird import Bird
    from upwash.aero.wake import WakeModel
    from upwash.optimum import solve_flock, solve_pair
    from upwash.species import load_species

__version__ = "0.1.0"
__all__ = ["Bird", "WakeModel", "load_species", "solve_flock", "solve_pair"]

_HOME = {
    "Bird": "upwash.aero.bird",
    "WakeModel": "upwash.aero.wake",
    "load_species": "upwash.species",
    "solve_flock": "upwash.optimum",
    "solve_pair": "upwash.optimum",
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
