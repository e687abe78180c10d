"""The paper's claims where its equations are converged: what does not exist there, and measures of their own.

Most claims are measured in the limit as they are in the paper's model.  Those here look into the wake, or at the
search, and must know how either is resolved.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.endless import Window, endless_wind, endless_window
from upwash.aero.interaction import wake_force
from upwash.aero.pose import Pose
from upwash.aero.wake import WakeModel
from upwash.aero.wingbeat import wingbeat_steps
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.search import EndlessSearch
from upwash.paper.claim import Absence, Cases, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence
from upwash.paper.of_lone_bird import OTHER_RATIO, VANISHING
from upwash.paper.of_search import SAME_COST, SAME_PLACE_M, SEED, STARTS
from upwash.study.rows import pose_of

MOVED = 0.3
"""How far a follower is moved along the wake, in wavelengths, to see whether it feels it."""

UNFELT = 1e-9
"""A change of the wake's force over the weight that is none."""


def _no_distance(evidence: Evidence) -> str:
    """Say that distance is not felt, if so: moved along the wake with its phase, the follower feels the same."""
    bird, pose = evidence.bird, pose_of(evidence.v(evidence.mapped))
    moved = replace(pose, x_m=pose.x_m + MOVED * bird.wavelength_m, phase=(pose.phase + MOVED) % 1.0)
    here, there = (np.array(wake_force(bird, bird.stroke, at, evidence.model)) for at in (pose, moved))
    if np.max(np.abs(there - here)) > UNFELT * bird.weight_n:
        return ""
    return "Any distance is as good as any other, if the phase moves one wingbeat a wavelength with it."


def _no_states(evidence: Evidence) -> str:
    """Say that birds are not held in an up and a down state, if they are not."""
    model = evidence.model
    if model.stroke_rule == "held" and model.stroke_states == 2:
        return ""
    return "The wings move all the time: there is no up state and no down state."


ABOUT: Mapping[str, Absence] = {"distance": _no_distance, "states": _no_states}
"""What claims are about that a model may lack -> why it is not there."""


def _force_of(
    bird: Bird, pose: Pose, model: WakeModel, downstrokes: bool, upstroke_span_ratio: float | None = None
) -> NDArray[np.float64]:
    """Return lift and thrust that the runs of one half stroke of an endless wake give, in N."""
    ratio = bird.upstroke_span_ratio if upstroke_span_ratio is None else upstroke_span_ratio
    b, steps = bird.semispan_m, wingbeat_steps(model)
    shed = bird.amplitude_m, ratio, b, bird.wavelength_m, bird.circulation_m2_s, bird.circulation_ratio
    windows = tuple(_only(endless_window(on_down, *shed), downstrokes) for on_down in (True, False))
    half_span = b * ((1.0 - steps.flexed) + steps.flexed * pose.stroke.span_ratio)
    wind = endless_wind(
        (windows[0], windows[1]),
        pose.x_m / bird.wavelength_m - pose.phase,
        (pose.y_m, pose.z_m),
        pose.stroke.amplitude_m,
        half_span,
        bird.wavelength_m,
        model.core_radius_ratio * b,
        model,
        steps,
    )
    per_wind = bird.density_kg_m3 * bird.circulation_m2_s * steps.circulation(bird.circulation_ratio)
    return np.asarray((steps.weight * per_wind * 2.0 * half_span) @ wind)


def _only(window: Window, downstrokes: bool) -> Window:
    """Return a window in which the runs of one half stroke alone have circulation."""
    kept = window.is_downstroke == downstrokes
    # Downstrokes come first, in the tails too: one beyond each end of the window.
    tails = window.tails[:2] if downstrokes else window.tails[2:]
    return replace(window, circulation=np.where(kept, window.circulation, 0.0), tails=tails)


def _from_downstrokes(evidence: Evidence) -> Cases:
    """Share of the wake's lift and thrust at the V optimum that runs of downstrokes give, in percent."""
    shares = {}
    for objective in OBJECTIVES:
        row = evidence.v(objective)
        force = np.full(2, np.nan)
        if evidence.has_v(objective):
            force = _force_of(evidence.bird, pose_of(row), evidence.model, downstrokes=True)
        for words, part in (("lift", force[0]), ("thrust", force[1])):
            shares[f"{objective}, {words}"] = float(100.0 * part / row[f"{words}_wake_n"])
    return shares


def _passive_upstroke(evidence: Evidence) -> Cases:
    """What is left of the upstroke as R goes to 0: of its lift, over all lift; of its wake, over that at R_L."""
    bird, pose = evidence.bird, pose_of(evidence.v(evidence.mapped))
    left, whole = (
        np.linalg.norm(_force_of(bird, pose, evidence.model, False, ratio)) for ratio in (VANISHING, None)
    )
    return {"lift": float(1.0 - bird.lift_n(0.0) / bird.lift_n(VANISHING)), "wake": float(left / whole)}


def _same_product(evidence: Evidence) -> Cases:
    """Change in percent when R and the upstroke's circulation change and their product does not."""
    bird, pose = evidence.bird, pose_of(evidence.v(evidence.mapped))
    other = replace(
        bird,
        upstroke_span_ratio=OTHER_RATIO,
        circulation_ratio=bird.circulation_ratio * bird.upstroke_span_ratio / OTHER_RATIO,
    )
    before, after = (np.array(wake_force(one, one.stroke, pose, evidence.model)) for one in (bird, other))
    lift, thrust = 100.0 * np.abs(after / before - 1.0)
    return {
        "lone bird": 100.0 * abs(other.drag_n / bird.drag_n - 1.0),
        "lift from the wake": float(lift),
        "thrust from the wake": float(thrust),
    }


@cache
def _ends(bird: Bird, objective: str, model: WakeModel) -> tuple[list[tuple[Pose, float, int]], float]:
    """Ends of single descents: of spread starts, each with its cost and hits; and the cost of the paper's start."""
    problem = EndlessProblem(bird, objective, model=model)
    search = EndlessSearch(problem, SEED)
    basins = search.descend(search.random_starts(problem.bounds, STARTS))
    own = search.descend(problem.point(Pose(0.0, 0.0, 0.0, bird.stroke, 0.5))[None, :])
    unit = problem.leader_cost
    ends = [(problem.pose(basin.point), basin.cost * unit, basin.hits) for basin in basins]
    return ends, own[0].cost * unit if own else np.inf


def _reached(evidence: Evidence) -> Cases:
    """Share of the spread starts from which a single descent of ours ends at the V optimum, in percent."""
    shares = {}
    for objective in OBJECTIVES:
        row, (ends, _) = evidence.v(objective), _ends(evidence.bird, objective, evidence.model)
        hits = sum(
            number
            for pose, cost, number in ends
            if abs(pose.y_m - row["y_m"]) < SAME_PLACE_M
            and abs(pose.z_m - row["z_m"]) < SAME_PLACE_M
            and abs(cost / row["cost"] - 1.0) < SAME_COST
        )
        shares[objective] = 100.0 * hits / STARTS if evidence.has_v(objective) else np.nan
    return shares


def _from_paper_start(evidence: Evidence) -> Cases:
    """Cost at which a descent from the paper's start ends over that of the V optimum, less 1, in percent."""
    bird, model = evidence.bird, evidence.model
    return {
        objective: float(100.0 * (_ends(bird, objective, model)[1] / evidence.v(objective)["cost"] - 1.0))
        for objective in OBJECTIVES
    }


MEASURES: Measures = {
    "downstroke-wake-dominates": _from_downstrokes,
    "passive-upstroke": _passive_upstroke,
    "product-of-R-and-circulation": _same_product,
    "robust-to-starts": _reached,
    "printed-start": _from_paper_start,
}
"""Claim -> our value in each case, for evidence of the limit."""
