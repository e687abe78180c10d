"""The story that the page tells: its chapters in order, what each says, shows and tabulates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from upwash.report import species_tables
from upwash.report.figures import species_rows
from upwash.report.figures.flocks import papers_flocks, series
from upwash.report.flock_answer import open_explained, proof_in_v
from upwash.report.limit_tables import limit_optima
from upwash.report.phase_answer import rule_table, verdict_table
from upwash.report.table import Table
from upwash.report.tables import (
    GLOBAL,
    V,
    basins,
    best_optima,
    both_optima,
    by_objective,
    printed_variously,
    table_1,
)
from upwash.report.words import common_name, least, percent
from upwash.species.library import REFERENCE
from upwash.study.comparison import compare, compare_objectives
from upwash.study.mechanism import count_species, mechanism
from upwash.study.observations import compare_with_observations
from upwash.study.phase_rule import phase_rule
from upwash.study.rows import best, objectives_of
from upwash.study.sources import Sources


def _no_tables(sources: Sources) -> list[Table]:
    return []


@dataclass(frozen=True)
class Chapter:
    """One chapter of the page.

    Parameters
    ----------
    name, title, words : str
        Its anchor, its heading, and what it is about.
    figures : tuple of str
        Names of its figures.
    missing : str
        What it takes, if none of its figures can be drawn.
    sweep : str
        A sweep that gives it.
    tables : callable
        Sources -> its tables.
    """

    name: str
    title: str
    words: str
    figures: tuple[str, ...]
    missing: str
    sweep: str = "reproduce"
    tables: Callable[[Sources], list[Table]] = _no_tables

    def remedy(self, page: str) -> str:
        """Return the commands that add it to a page which a command made."""
        results = f"results/{self.sweep}"
        return f"upwash run {self.sweep}\nupwash aggregate {results}\n{page} {results}"


def _optima_tables(sources: Sources) -> list[Table]:
    pair = sources.pair
    if pair is None:
        return []
    optima = best_optima(pair[pair["objective"] == "force"])
    beside_the_paper = pair["species"].iloc[0] == REFERENCE and V in optima
    tables = [table_1(pair), printed_variously(pair)] if beside_the_paper else []
    return [*tables, both_optima(pair)]


def _basin_tables(sources: Sources) -> list[Table]:
    return [] if sources.pair is None else [basins(rows) for rows in by_objective(sources.pair).values()]


def _limit_tables(sources: Sources) -> list[Table]:
    if sources.limit is None:
        return []
    rule = phase_rule(sources.phase[sources.phase["model"] == "limit"])
    return [limit_optima(sources.limit), rule_table(REFERENCE, "power", rule), verdict_table(rule)]


def _flock_tables(sources: Sources) -> list[Table]:
    if sources.flock is None:
        return []
    tables = []
    for objective, reading, birds in series(papers_flocks(sources.flock)):
        frame = pd.DataFrame(
            {
                "bird": birds["bird"],
                "x m": birds["x_flock_m"],
                "y m": birds["y_flock_m"],
                "z m": birds["z_flock_m"],
                "phase": birds["phase_flock"],
                "h/h_1": birds["amplitude_ratio"],
                "R/R_1": birds["span_ratio_ratio"],
                "induced/first's": birds["induced_ratio"],
                "profile/first's": birds["profile_ratio"],
                "saving %": 100.0 * birds["saving_total"],
                "proof": birds.apply(proof_in_v, axis=1),
            }
        )
        formats = dict.fromkeys(frame.columns[1:], ".3f") | {"saving %": ".1f"}
        title = f"Flock of {least(objective)}, reading of the amplitude bound: {reading}"
        tables.append(Table(title, frame, formats, tuple(open_explained(birds))))
    return tables


def _species_tables(sources: Sources) -> list[Table]:
    if sources.species is None:
        return []
    rows, samples = sources.species, sources.samples
    compared = compare(rows, samples)
    return [
        *species_tables.comparison_tables(compared),
        species_tables.groups_table(compared),
        *species_tables.objectives_tables(compare_objectives(rows, samples)),
        species_tables.counts_table(count_species(mechanism(rows, samples))),
        *species_tables.observations_tables(compare_with_observations(rows, samples, sources.observations)),
    ]


CHAPTERS = (
    Chapter(
        "optimum",
        "Where a bird should fly behind another",
        "A follower may choose where it flies, how far and how flexed it flaps, and in which phase. It must carry its "
        "weight and overcome its drag, and the wake of the bird ahead can help with both. These are its best choices.",
        ("optimal-position",),
        "It takes a pair.",
        tables=_optima_tables,
    ),
    Chapter(
        "lone-bird",
        "What a bird leaves in the air",
        "Flapping leaves a chain of vortex rings. Their impulse carries and propels the bird that made them; the air "
        "they set moving is what a follower meets.",
        ("lone-wake", "configurations"),
        "It takes the bird of a pair.",
    ),
    Chapter(
        "why-there",
        "Why there",
        "Lift and thrust from the wake are large in few places, and seldom both in one. The best place is where "
        "what is missing to fly with a smaller stroke is made up in both at once, with the inner wingtip at a vortex's "
        "edge.",
        ("force-maps", "spacing-rule", "fixed-wings"),
        "It takes the optimum of a pair.",
    ),
    Chapter(
        "all-optima",
        "Not the only good place",
        "The problem has many local optima. All that were found are shown; a lower bound on the cost, proved by branch "
        "and bound, says that nothing better was missed.",
        ("optima-map",),
        "It takes all optima of a pair.",
        tables=_basin_tables,
    ),
    Chapter(
        "limit",
        "The same equations, converged",
        "The paper's model holds each wing in two positions, feels the wake at two points, and cuts it at one "
        "wavelength. Refined in all three until nothing changes any more, the same equations say something else: for "
        "least power the V is the best place of all and saves about a quarter as much, no distance is better than "
        "another, and a wing should retrace the path of its leader's, as ibises do.",
        ("limit-place", "limit-phase", "limit-claims", "refinement"),
        "It takes a pair in the limit by both laws of the follower's span, beside the pair of the paper's model.",
        "limit",
        _limit_tables,
    ),
    Chapter(
        "observed",
        "What birds save where they were seen",
        "Birds fly where they like, and drift. What is published of where they fly, evaluated as it stands: the "
        "paper's best place is a few centimetres wide, and no species was seen in it.",
        ("observed-saving",),
        "It takes what is kept with the code.",
    ),
    Chapter(
        "flock",
        "A flock",
        "A flock is a chain of pairs: each bird flies in the wake of the one ahead, at its own optimum there.",
        ("flock-formation", "flock-view", "flock-saving"),
        "It takes a study of flocks; run it, and name its folder too.",
        "paper-flocks",
        _flock_tables,
    ),
    Chapter(
        "species",
        "Other birds",
        "Does it hold for other birds? Each species of the library, by both costs and both conventions for its "
        "amplitude, beside what was published of it.",
        (*(picture.name for picture in species_rows.PICTURES), "species-groups", "species-observed"),
        "It takes a study of several species; run it, and name its folder too.",
        "cross-species",
        _species_tables,
    ),
    Chapter(
        "parameters",
        "What it depends on",
        "One input at a time, about the same bird.",
        ("speed-power", "parameter-saving"),
        "It takes a study that varies inputs; run it, and name its folder too.",
        "ibis-parameters",
    ),
)
"""The chapters in order."""


def short_answer(sources: Sources) -> list[str]:
    """Return what was found of the pair, one sentence or two for each objective."""
    pair = sources.pair
    if pair is None:
        return _in_the_limit(sources) or [
            "These results single out no bird whose optimum could be shown here."
        ]
    name = common_name(pair["species"].iloc[0]).lower()
    sentences = []
    for objective in objectives_of(pair):
        row = best(pair, objective)
        level = "below" if row["z_m"] < 0.0 else "above"
        sentence = (
            f"For {least(objective)} a {name} should fly {row['x_m']:.2f} m behind, "
            f"{abs(row['y_m']):.2f} m aside and {abs(row['z_m']):.2f} m {level} the bird ahead, lagging it by "
            f"{row['phase']:.2f} wingbeats. It then flaps "
            f"{percent(1.0 - row['amplitude_m'] / row['leader_amplitude_m'])} less far "
            f"and saves {percent(row['saving_total'], 1)} of its power."
        )
        optima = best_optima(pair[pair["objective"] == objective])
        if V not in optima:
            sentence += (
                " There is no optimum outboard, level and astern of its leader: this is the best of all."
            )
        elif not optima[V]["is_global_optimum"]:
            gap = optima[V]["cost"] / optima[GLOBAL]["cost"] - 1.0
            sentence += (
                f" That is the best place in a V, but not the best of all: one {optima[GLOBAL]['y_m']:.2f} m "
                f"aside ({optima[GLOBAL]['placement']}) costs {percent(gap / (1.0 + gap), 2)} less."
            )
        sentences.append(sentence)
    return sentences + _in_the_limit(sources)


def _in_the_limit(sources: Sources) -> list[str]:
    """Return what is found of a bird in the limit, in a sentence, if it was solved there."""
    if sources.limit is None:
        return []
    of_power = sources.limit[(sources.limit["objective"] == "power") & sources.limit["is_v_optimum"].eq(True)]
    rows = {row["span_law"]: row for _, row in of_power.sort_values("span_law", kind="stable").iterrows()}
    aside, saved = (
        " or ".join(words(row) for row in rows.values())
        for words in (
            lambda row: f"{row['y_m'] / row['semispan_m']:.2f}",
            lambda row: percent(row["saving_total"], 1),
        )
    )
    name, laws = common_name(of_power["species"].iloc[0]).lower(), " or the ".join(rows)
    return [
        f"Converged, in the limit, least power has a {name} fly {aside} semispans aside, at any distance, its wingtips "
        f"retracing the path of the leader's, and saves {saved} of its power, by the {laws} law of the follower's span."
    ]
