"""What each input of a job must be, whether a sweep file, a command line or a caller states it."""

from __future__ import annotations

from upwash.aero.checked import Rule, fraction, positive, rules_of, whole_from, within
from upwash.aero.wake import WakeModel
from upwash.species.species import INPUT_RULES

_SEED = whole_from(0, 2**63 - 1, "more than a column of whole numbers holds")

CHOICES: dict[str, Rule] = {
    "seed": _SEED,
    "tolerance": fraction & within(1e-12, 1.0, "costs are rounded to that"),
    "birds": whole_from(2, 1000, "a bird takes a search of its own, and no line of birds is longer"),
    "wavelengths": whole_from(
        1, 1000, "each adds its vortices to every force, and nothing is felt of the last"
    ),
}
"""Inputs that are numbers but no parameters."""

PARAMETERS: dict[str, Rule] = {
    **INPUT_RULES,
    **rules_of(WakeModel),
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
