"""In which models of the wake optima are searched and proved; what is refused before anything runs."""

from __future__ import annotations

from upwash.aero.checked import Rule
from upwash.aero.wake import WakeModel
from upwash.optimum.settings import FlockRules

_EXACT = Rule(
    "exact (behind an endless wake optima are searched and proved on the whole span)",
    lambda value: value == "exact",
)
_IN_POINTS = "with span_nodes exact optima are searched and proved in any way, with points"
_HELD = Rule(f"held ({_IN_POINTS} in held states)", lambda value: value == "held")
_RANKINE = Rule(f"rankine ({_IN_POINTS} with this core)", lambda value: value == "rankine")
_ONE_AHEAD = Rule(
    "neighbour (wakes are added up if they end and are felt in points by birds held in two states)",
    lambda value: value == "neighbour",
)


def need_solvable(model: WakeModel, rules: FlockRules | None = None) -> None:
    """Refuse a model of the wake in which no optimum can be searched and proved.

    Parameters
    ----------
    model : WakeModel
        The model.
    rules : FlockRules, optional
        How the flock is built, if it is one's.

    Raises
    ------
    ValueError
        If it is one; the message names the input.
    """
    if model.is_endless:
        _EXACT("span_nodes", model.span_nodes)
    elif model.span_nodes != "exact":
        _HELD("stroke_rule", model.stroke_rule)
        _RANKINE("core", model.core)
    if rules is not None and not adds_up(model):
        _ONE_AHEAD("wake", rules.wake)


def adds_up(model: WakeModel) -> bool:
    """Whether the wakes of several birds are added up, and birds improved together: as in the paper, if longer."""
    return not model.is_endless and model.span_nodes != "exact" and model.stroke_states == 2
