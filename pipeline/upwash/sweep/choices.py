"""What each input of a job must be, whether a sweep file, a command line or a caller states it."""

from __future__ import annotations

from upwash import columns as of
from upwash.aero.checked import REACH, Rule, one_of, positive, rules_of
from upwash.aero.wake import LENGTH, NAMES, WakeModel
from upwash.jobs.jitter import RULE, SIGMA
from upwash.optimum.settings import SearchSettings
from upwash.optimum.spacing import UNITS, Spacing
from upwash.species.species import INPUT_RULES, OF_THE_AMPLITUDE

CHOICES: dict[str, Rule] = {name: rules_of(SearchSettings)[name] for name in ("seed", "tolerance")}
"""How to search."""

LEADER, SPEED_OF, PHASE_LOCK, MEMBERS = "leader", "speed_of", "phase_lock", "members"
"""Keys of birds that need not be alike: the bird ahead in a pair, whose speed both fly at, whether they beat in step;
and the birds of a flock."""

SPEED = "speed"
"""Key of the speed that a bird chooses: its own, or the lone bird's best."""

MODEL = "model"
"""The parameter that names a model of the wake, of which others then are parts."""

# As a file writes them: an endless wake by its word.
PARTS: dict[str, Rule] = rules_of(WakeModel) | {
    "wavelengths": one_of(of.column("wavelengths").words.values()) | LENGTH
}
"""Parts of a model of the wake."""

PARAMETERS: dict[str, Rule] = {
    **INPUT_RULES,
    MODEL: one_of(NAMES),
    **PARTS,
    "distance_m": REACH,
    **rules_of(Spacing),
    SIGMA: RULE,
}
"""Parameters of bird and wake, which a sweep may vary."""

OF_THE_BIRD = tuple(INPUT_RULES)
"""Those of the bird."""

STROKE_ANGLE, ALTITUDE = "stroke_half_angle_deg", "altitude_m"

NOT_TOLD = (ALTITUDE, *(name for name in OF_THE_AMPLITUDE if name != STROKE_ANGLE))
"""Parameters that no job tells, but the density or the amplitude that follows from them."""

UNSCALED = (
    MODEL,
    *(name for name in PARTS if name != "core_radius_ratio"),
    "distance_m",
    ALTITUDE,
    *UNITS,
    SIGMA,
)
"""Parameters of which no sweep takes a factor: they are words or counts, or have no value of the species' own."""

WORDED = frozenset(
    column.name
    for column in of.COLUMNS
    if column.name in PARAMETERS and (column.type == of.TEXT or column.words)
)
"""Parameters whose values are words, or may be."""


def rule_of(name: str, relative: bool = False) -> Rule:
    """Return what a parameter must be, or what a factor on a species' own value must be."""
    return positive if relative else PARAMETERS[name]
