"""What each input of a job must be, whether a sweep file, a command line or a caller states it."""

from __future__ import annotations

from upwash.aero.checked import Rule, positive, rules_of, whole_from
from upwash.aero.wake import FINENESS, LENGTH, WakeModel
from upwash.optimum.settings import BIRDS, SearchSettings
from upwash.species.species import INPUT_RULES

CHOICES: dict[str, Rule] = {
    **{name: rules_of(SearchSettings)[name] for name in ("seed", "tolerance")},
    "birds": BIRDS,
    "wavelengths": LENGTH,
}
"""Inputs that are numbers but no parameters; how long wakes are is told of a flock, in its own table."""

PARAMETERS: dict[str, Rule] = {
    **INPUT_RULES,
    "core_radius_ratio": rules_of(WakeModel)["core_radius_ratio"],
    "span_nodes": FINENESS,
    "stroke_states": whole_from(
        2, 2, "optima are searched and proved with two states; more serve maps of forces"
    ),
}
"""Parameters of bird and wake, which a sweep may vary."""

WHOLE = ("stroke_states", "span_nodes")
"""Parameters that are counts: no sweep takes a factor of them."""


def rule_of(name: str, relative: bool = False) -> Rule:
    """Return what a parameter must be, or what a factor on a species' own value must be."""
    return positive if relative else PARAMETERS[name]
