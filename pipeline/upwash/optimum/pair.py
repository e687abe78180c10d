"""One bird behind another: the follower's problem, posed and solved."""

from __future__ import annotations

from typing import Any

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.optimum.certify import MOST_BOXES
from upwash.optimum.pieces import STARTS, solve_pieces
from upwash.optimum.problem import PairProblem
from upwash.optimum.solution import PairSolution


def solve_pair(
    bird: Bird,
    objective: str = "force",
    *,
    leader_amplitude_m: float | None = None,
    leader_upstroke_span_ratio: float | None = None,
    amplitude_limit_m: float | None = None,
    model: WakeModel | None = None,
    seed: int = 0,
    tolerance: float = 1e-4,
    starts: int = STARTS,
    most_boxes: int = MOST_BOXES,
) -> PairSolution:
    """Find where and how a follower should fly behind a leader, with all other optima, and prove the best.

    Parameters
    ----------
    bird : Bird
        The bird; in a flock the first one, which sets weight, drag and circulation.
    objective : str
        Name of a cost function.
    leader_amplitude_m, leader_upstroke_span_ratio : float, optional
        Stroke of the bird immediately ahead; the bird's own if not given.
    amplitude_limit_m : float, optional
        Largest amplitude of the follower; that of the bird immediately ahead if not given.
    model : WakeModel, optional
        Resolution of the wake; must have two stroke states.
    seed : int
        Seed of the random starts.
    tolerance : float
        Gap to which the best is to be proved.
    starts : int
        Random starts in each kind of place (outboard or inboard, astern or abreast) and, again, in the V region;
        the search around the best optima adds to them.
    most_boxes : int
        Budget of boxes of each proof.

    Returns
    -------
    PairSolution
        The optima, best first, and the proof.

    Raises
    ------
    ValueError
        If an input is out of range; the message names it.
    """
    model = model or WakeModel()
    if model.stroke_states != 2:
        raise ValueError(
            f"stroke_states: expected 2, the states in which optima can be searched and proved, "
            f"found {model.stroke_states}"
        )
    if not 0.0 < tolerance < 1.0:
        raise ValueError(f"tolerance: expected a number between 0 and 1, found {tolerance!r}")
    stroke_ahead = {
        "leader_amplitude_m": leader_amplitude_m,
        "leader_upstroke_span_ratio": leader_upstroke_span_ratio,
        "amplitude_limit_m": amplitude_limit_m,
    }
    given: dict[str, Any] = {name: value for name, value in stroke_ahead.items() if value is not None}
    problem = PairProblem(bird, objective, model=model, **given)
    return solve_pieces([problem], seed=seed, tolerance=tolerance, starts=starts, most_boxes=most_boxes)
