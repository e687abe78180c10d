"""In which models of the wake optima are searched and proved; what is refused before anything runs."""

from __future__ import annotations

from upwash.aero.checked import Rule
from upwash.aero.wake import FINENESS, WakeModel
from upwash.optimum.settings import FlockRules

_TWO_STATES = Rule("2 (flocks behind wakes that end are solved with two states)", lambda value: value == 2)
_EXACT = Rule(
    "exact (behind an endless wake optima are searched and proved on the whole span)",
    lambda value: value == "exact",
)
_BEHIND_ENDS = "behind a wake that ends optima are searched and proved"
_POINTS = Rule(
    f"a number of points ({_BEHIND_ENDS} with points)", lambda value: not FINENESS.broken_by(value)
)
_HELD = Rule(f"held ({_BEHIND_ENDS} in held states)", lambda value: value == "held")
_RANKINE = Rule(f"rankine ({_BEHIND_ENDS} with this core)", lambda value: value == "rankine")
_TIP = Rule(f"tip ({_BEHIND_ENDS} by this law, or in two states)", lambda value: value == "tip")
_ONE_AHEAD = Rule("neighbour (endless wakes are not added up)", lambda value: value == "neighbour")


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
    if not model.is_endless:
        if rules is not None:
            _TWO_STATES("stroke_states", model.stroke_states)
        _POINTS("span_nodes", model.span_nodes)
        _HELD("stroke_rule", model.stroke_rule)
        _RANKINE("core", model.core)
        if model.stroke_states > 2:
            _TIP("span_law", model.span_law)
        return
    _EXACT("span_nodes", model.span_nodes)
    if rules is not None:
        _ONE_AHEAD("wake", rules.wake)
