"""Where the paper says the follower flies, and how little that depends on the cost."""

from __future__ import annotations

from collections.abc import Callable

from upwash.aero.wake import spanwise_spacing_rule
from upwash.paper.claim import Cases, Claim, at_least, between, near
from upwash.paper.evidence import OBJECTIVES, Evidence

OBSERVED_X_M, OBSERVED_Y_M = 1.2, 0.904
"""Northern bald ibises, Portugal et al. (2014), as the paper's Table 1 quotes them."""

ALIKE = 0.05
"""Largest difference, in the length given or over the leader's stroke, that counts as almost none."""


def _over_the_rule(evidence: Evidence) -> Cases:
    """Spanwise position over that of the spacing rule, less 1, in percent."""
    found = {}
    for objective in OBJECTIVES:
        row = evidence.v(objective)
        rule = spanwise_spacing_rule(row["semispan_m"], row["upstroke_span_ratio"])
        found[objective] = 100.0 * (row["y_m"] / rule - 1.0)
    return found


def _over(column: str, observed: float) -> Callable[[Evidence], Cases]:
    def measure(evidence: Evidence) -> Cases:
        return {objective: value / observed for objective, value in evidence.of_v(column).items()}

    return measure


def _difference(columns: dict[str, str], factor: float = 1.0) -> Callable[[Evidence], Cases]:
    """Least power's V optimum less least force's."""

    def measure(evidence: Evidence) -> Cases:
        force, power = evidence.v("force"), evidence.v("power")
        return {words: factor * float(power[name] - force[name]) for name, words in columns.items()}

    return measure


CLAIMS = (
    Claim(
        "x-half-wavelength",
        "Wingtip path coherence; Fig. 3a",
        "the follower flies slightly less than half a wavelength behind",
        "slightly less than 0.5",
        "λ",
        between(0.45, 0.5),
        lambda evidence: evidence.of_v("x_wavelengths"),
        "It flies just upstream of where the wake's thrust turns into drag.",
    ),
    Claim(
        "antiphase",
        "Wingtip path coherence; Table 1",
        "the follower flaps in antiphase to the leader",
        "0.5",
        "",
        near(0.5, 0.005),
        lambda evidence: evidence.of_v("phase"),
        "Exactly: the force is linear in |κ − ½|, and both optima lie at its end.",
    ),
    Claim(
        "path-coherence",
        "Wingtip path coherence; Fig. 3b",
        "the follower's wingtips retrace the path of the leader's",
        "align closely",
        "wingbeats",
        near(0.0, ALIKE),
        lambda evidence: evidence.of_v("path_phase"),
        "Phase less x/λ: what is missing to retrace the path.",
    ),
    Claim(
        "spacing-rule",
        "Eq. optimal_spanwise_dist",
        "the spacing rule gives y_F to within 1 %",
        "within 1",
        "%",
        near(0.0, 1.0),
        _over_the_rule,
        "Each cost with its own R_F.",
    ),
    Claim(
        "spacing-rule-exceeded",
        "Optimal spanwise spacing",
        "y_F is marginally larger than the rule's",
        "marginally larger",
        "%",
        between(0.0, 1.0),
        _over_the_rule,
        "Ours over the rule's, less 1.",
    ),
    Claim(
        "observed-y",
        "Table 1; Optimal spanwise spacing",
        "y_F is just slightly below the 0.904 m of flying ibises",
        "0.877/0.904 = 0.97",
        "",
        between(0.95, 1.0),
        _over("y_m", OBSERVED_Y_M),
        "Ours over observed.",
    ),
    Claim(
        "observed-x",
        "Table 1; Wingtip path coherence",
        "x_F is moderately larger than the 1.2 m of flying ibises",
        "1.83/1.2 = 1.53",
        "",
        near(1.53, 0.1),
        _over("x_m", OBSERVED_X_M),
        "Ours over observed: half as far again, as in the paper.",
    ),
    Claim(
        "observed-z",
        "Table 1",
        "the follower flies close to the leader's height",
        "0.88 z_L, 6 % of h_L below",
        "h_L",
        near(0.0, 0.1),
        lambda evidence: evidence.of_v("z_amplitudes"),
        "Near with least force; with least power lower, {power:.2f} h_L.",
    ),
    Claim(
        "objectives-alike-position",
        "Results; Fig. 3a,b",
        "least force and least power give almost the same position",
        "almost identical",
        "",
        near(0.0, ALIKE),
        _difference({"x_wavelengths": "x in λ", "y_semispans": "y in b", "z_amplitudes": "z in h_L"}),
        "Alike seen from above; in height they are {metres:.2f} m apart.",
        facts=lambda evidence: {
            "metres": abs(float(evidence.v("power")["z_m"] - evidence.v("force")["z_m"]))
        },
    ),
    Claim(
        "objectives-alike-stroke",
        "Results",
        "least force and least power give almost the same stroke",
        "almost identical",
        "",
        near(0.0, ALIKE),
        _difference({"amplitude_reduction": "h over h_L", "span_ratio_reduction": "R over R_L"}),
        f"With least power the bird flaps less and flexes its wing less, each by about the {ALIKE:g} of the leader's "
        "that is taken here for almost none.",
    ),
    Claim(
        "objectives-alike-saving",
        "Results; Discussion",
        "least force and least power save almost the same",
        "almost identical",
        "points",
        near(0.0, 1.0),
        _difference(
            {"saving_total": "total", "saving_induced": "induced", "saving_profile": "profile"}, factor=100.0
        ),
        "Near positions, other savings: least power gives up lift for thrust and saves {total:.1f} points more in all.",
    ),
    Claim(
        "lift-and-thrust-assisted",
        "Discussion",
        "the wake both lifts the follower and pulls it forward",
        "both effects operative",
        "N",
        at_least(0.0),
        lambda evidence: {
            f"{objective}, {words}": float(evidence.v(objective)[column])
            for objective in OBJECTIVES
            for words, column in (("lift", "lift_wake_n"), ("thrust", "thrust_wake_n"))
        },
        "Wake-induced lift and thrust, averaged over the wingbeat.",
    ),
)
