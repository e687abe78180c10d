"""Where the paper says the follower flies, and how little that depends on the cost."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import nan

from upwash.aero.bird import Bird
from upwash.aero.pose import Pose
from upwash.aero.wake import ROLL_UP, WakeModel, spanwise_spacing_rule
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.paper.claim import Cases, Measure, Measures
from upwash.paper.evidence import OBJECTIVES, Evidence

OBSERVED_X_M, OBSERVED_Y_M = 1.2, 0.904
"""Northern bald ibises, Portugal et al. (2014), as the paper's Table 1 quotes them."""

OTHER_RATIOS = (0.3, 0.5)
"""Upstroke span ratios of other leaders: the paper's bounds on the follower's."""

ALIKE = 0.05
"""Largest difference that the table of claims counts as almost none."""


def _over_the_rule(evidence: Evidence) -> Cases:
    """Spanwise position over that of the spacing rule, less 1, in percent."""
    excess = {}
    for objective in OBJECTIVES:
        row = evidence.v(objective)
        rule = spanwise_spacing_rule(row["semispan_m"], row["upstroke_span_ratio"])
        excess[objective] = 100.0 * (row["y_m"] / rule - 1.0)
    return excess


def _beyond_filament(evidence: Evidence) -> Cases:
    """How far the follower's inner wingtip is outboard of the leader's downstroke filament, in semispans."""
    beyond = {}
    for objective in OBJECTIVES:
        row = evidence.v(objective)
        aside = float(row["y_m"] / row["semispan_m"]) - ROLL_UP
        beyond[f"{objective}, raised"] = aside - float(row["upstroke_span_ratio"])
        beyond[f"{objective}, lowered"] = aside - 1.0
    return beyond


@cache
def _v_of(bird: Bird, objective: str, model: WakeModel) -> Pose | None:
    """Return the V optimum of a bird that is not the paper's, by search alone."""
    v = solve_pair(bird, objective, model=model, search=SearchSettings(most_boxes=1)).v_optimum
    return v.pose if v else None


def _over_the_rule_elsewhere(evidence: Evidence) -> Cases:
    """As `_over_the_rule`, for leaders of other upstroke span ratios."""
    excess = {}
    for objective in OBJECTIVES:
        for ratio in OTHER_RATIOS:
            bird = replace(evidence.bird, upstroke_span_ratio=ratio)
            pose = _v_of(bird, objective, evidence.model)
            rule = spanwise_spacing_rule(bird.semispan_m, pose.stroke.span_ratio) if pose else nan
            excess[f"{objective}, R_L {100.0 * ratio:.0f} %"] = (
                100.0 * (pose.y_m / rule - 1.0) if pose else nan
            )
    return excess


def _over(column: str, observed: float) -> Measure:
    def measure(evidence: Evidence) -> Cases:
        return {objective: value / observed for objective, value in evidence.of_v(column).items()}

    return measure


def _difference(columns: dict[str, str], factor: float = 1.0) -> Measure:
    """Least power's V optimum less least force's."""

    def measure(evidence: Evidence) -> Cases:
        force, power = evidence.v("force"), evidence.v("power")
        return {words: factor * float(power[name] - force[name]) for name, words in columns.items()}

    return measure


MEASURES: Measures = {
    "x-half-wavelength": lambda evidence: evidence.of_v("x_wavelengths"),
    "antiphase": lambda evidence: evidence.of_v("phase"),
    "path-coherence": lambda evidence: evidence.of_v("path_phase"),
    "spacing-rule": _over_the_rule,
    "spacing-rule-exceeded": _over_the_rule,
    "spacing-rule-elsewhere": _over_the_rule_elsewhere,
    "wingtips-outside-filament": _beyond_filament,
    "observed-y": _over("y_m", OBSERVED_Y_M),
    "observed-x": _over("x_m", OBSERVED_X_M),
    "observed-z": lambda evidence: evidence.of_v("z_amplitudes"),
    "objectives-alike-position": _difference(
        {"x_wavelengths": "x in λ", "y_semispans": "y in b", "z_amplitudes": "z in h_L"}
    ),
    "objectives-alike-stroke": _difference(
        {"amplitude_reduction": "h over h_L", "span_ratio_reduction": "R over R_L"}
    ),
    "objectives-alike-saving": _difference(
        {"saving_total": "total", "saving_induced": "induced", "saving_profile": "profile"}, factor=100.0
    ),
    "lift-and-thrust-assisted": lambda evidence: {
        f"{objective}, {words}": float(evidence.v(objective)[column])
        for objective in OBJECTIVES
        for words, column in (("lift", "lift_wake_n"), ("thrust", "thrust_wake_n"))
    },
}
"""Claim -> our value in each case."""

FACTS: Measures = {
    "objectives-alike-position": lambda evidence: {
        "metres": abs(float(evidence.v("power")["z_m"] - evidence.v("force")["z_m"]))
    },
    "objectives-alike-stroke": lambda _: {"alike": ALIKE},
}
"""Claim -> other numbers of ours that its reason names."""
