"""The story that the page tells: its chapters in order, what each says, shows and tabulates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from upwash.paper.evidence import PAPER_BIRD
from upwash.report import species_tables
from upwash.report.figures import species_rows
from upwash.report.figures.flocks import papers_flocks, series
from upwash.report.first_screen import (
    between,
    costs_of,
    drift_left,
    lead,
    metres,
    optima_in,
    pose_in_words,
    straight_behind,
)
from upwash.report.flock_answer import open_explained, proof_in_v
from upwash.report.limit_tables import limit_optima
from upwash.report.phase_answer import rule_table, verdict_table
from upwash.report.switches import LIMIT, PAPER, Said
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
from upwash.report.words import least, percent
from upwash.species.library import REFERENCE
from upwash.study.comparison import compare, compare_objectives
from upwash.study.drift import TOLD_M
from upwash.study.mechanism import count_species, mechanism
from upwash.study.observations import compare_with_observations
from upwash.study.phase_rule import phase_rule
from upwash.study.rows import Row, bird_of
from upwash.study.sources import Sources


@dataclass(frozen=True)
class Tabled:
    """A table, and the settings of the switches for which it holds; all, if empty."""

    table: Table
    costs: tuple[str, ...] = ()
    models: tuple[str, ...] = ()


def _no_tables(sources: Sources) -> list[Tabled]:
    return []


@dataclass(frozen=True)
class Chapter:
    """One chapter of the page.

    Parameters
    ----------
    name, title : str
        Its anchor and its heading.
    words : callable
        Sources -> what it says, for each setting of the page's switches.
    figures, more : tuple of str
        Names of the figures that are seen at once, and of those that are folded away.
    sweep, needs : str
        A sweep that gives it, and what that is.
    tables : callable
        Sources -> its tables.
    """

    name: str
    title: str
    words: Callable[[Sources], list[Said]]
    figures: tuple[str, ...]
    more: tuple[str, ...] = ()
    sweep: str = "reproduce"
    needs: str = "a pair"
    tables: Callable[[Sources], list[Tabled]] = _no_tables

    def remedy(self, page: str) -> str:
        """Return the commands that add it to a page which a command made."""
        results = f"results/{self.sweep}"
        return f"upwash run {self.sweep}\nupwash aggregate {results}\n{page} {results}"


def _optima_tables(sources: Sources) -> list[Tabled]:
    pair = sources.pair
    if pair is None:
        return []
    tables = []
    if bird_of(pair.iloc[0]) == PAPER_BIRD and V in best_optima(pair[pair["objective"] == "force"]):
        tables = [Tabled(table(pair), ("force",)) for table in (table_1, printed_variously)]
    tables += [Tabled(both_optima(rows), (cost,)) for cost, rows in by_objective(pair).items()]
    if sources.limit is not None:
        tables.append(Tabled(limit_optima(sources.limit), models=(LIMIT,)))
    return [Tabled(one.table, one.costs, one.models or (PAPER,)) for one in tables]


def _basin_tables(sources: Sources) -> list[Tabled]:
    if sources.pair is None:
        return []
    return [Tabled(basins(rows), (cost,), (PAPER,)) for cost, rows in by_objective(sources.pair).items()]


def _limit_tables(sources: Sources) -> list[Tabled]:
    if sources.limit is None:
        return []
    rule = phase_rule(sources.phase[sources.phase["model"] == "limit"])
    tables = limit_optima(sources.limit), rule_table(REFERENCE, "power", rule), verdict_table(rule)
    return [Tabled(table) for table in tables]


def _flock_tables(sources: Sources) -> list[Tabled]:
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
        tables.append(Tabled(Table(title, frame, formats, tuple(open_explained(birds))), (objective,)))
    return tables


def _species_tables(sources: Sources) -> list[Tabled]:
    if sources.species is None:
        return []
    rows, samples = sources.species, sources.samples
    compared = compare(rows, samples)
    tables = (
        *species_tables.comparison_tables(compared),
        species_tables.groups_table(compared),
        *species_tables.objectives_tables(compare_objectives(rows, samples)),
        species_tables.counts_table(count_species(mechanism(rows, samples))),
        *species_tables.observations_tables(compare_with_observations(rows, samples, sources.observations)),
    )
    return [Tabled(table) for table in tables]


def _just(text: str) -> Callable[[Sources], list[Said]]:
    """Return the words of a chapter that says the same whatever the results."""
    return lambda sources: [Said(text)]


def _limit_words(sources: Sources) -> list[Said]:
    said = [
        Said(
            "The paper's model holds each wing in two positions, feels the wake at two points of the span, and cuts it "
            "at one wavelength. Refined in all three until nothing changes, the same equations say something else."
        )
    ]
    for cost in costs_of(sources):
        optima = list(optima_in(sources.limit, cost).values())
        paper = [one[V] for one in optima_in(sources.pair, cost).values() if V in one]
        rows = [one[V] for one in optima if V in one]
        if optima and len(rows) < len(optima):
            said.append(Said(f"{least(cost).capitalize()} has no V optimum left there.", (cost,)))
        elif rows and paper:
            share = percent(max(row["saving_total"] for row in rows) / paper[0]["saving_total"])
            is_best = all(row["is_global_optimum"] for row in rows)
            best = "The V is then the best place of all. It" if is_best else "The V"
            said.append(
                Said(
                    f"{best} saves {between([row['saving_total'] for row in rows])} of the power, at most {share} of "
                    "what the paper's model gives; no distance is better than another; and a wing should retrace the "
                    "path of its leader's, as ibises do.",
                    (cost,),
                )
            )
    return said


def _drift_words(sources: Sources) -> list[Said]:
    said = [
        Said(
            "No bird keeps its place to the centimetre. Here the place jitters in all three directions while the bird "
            "flaps always alike."
        )
    ]
    for cost in costs_of(sources):
        left = drift_left(sources, cost)
        told = [
            f"the {model}'s {between([row['saving_still'] for row in rows])} become "
            f"{between([row['saving_held'] for row in rows])}"
            for model, rows in left.items()
        ]
        if told:
            said.append(Said(f"At {100.0 * TOLD_M:.0f} cm {' and '.join(told)}.", (cost,)))
    return said


def _optima_words(sources: Sources) -> list[Said]:
    said = [
        Said(
            "The paper takes its V for the best place of all. A lower bound on the cost, proved by branch and bound, "
            "says that no better place was missed.",
            models=(PAPER,),
        )
    ]
    for cost in costs_of(sources):
        for optima in optima_in(sources.pair, cost).values():
            said.append(Said(_best_of_all(cost, optima), (cost,), (PAPER,)))
        laws = optima_in(sources.limit, cost)
        if laws and all(V in one and one[V]["is_global_optimum"] for one in laws.values()):
            said.append(Said("In the limit the V is the best place of all.", (cost,), (LIMIT,)))
        elif laws:
            rows = [one[GLOBAL] for one in laws.values()]
            aside = metres([row["y_m"] for row in rows])
            said.append(Said(f"In the limit the best place of all is {aside} aside.", (cost,), (LIMIT,)))
    return said


def _best_of_all(cost: str, optima: dict[str, Row]) -> str:
    """Say how much better another place is than the V optimum, and what the model leaves out there."""
    row = optima[GLOBAL]
    if V not in optima:
        text = f"{least(cost).capitalize()} has no V optimum."
    elif optima[V]["is_global_optimum"]:
        return f"For {least(cost)} it is."
    else:
        gap = 1.0 - row["cost"] / optima[V]["cost"]
        text = f"For {least(cost)} it is not: another place costs {percent(gap, 2)} less."
    text += f" The best of all is {row['x_m']:.2f} m behind and {row['y_m']:.2f} m aside."
    if straight_behind(row):
        text += " That is straight behind the leader's body, whose own wake the model leaves out."
    return text


def _where_words(sources: Sources) -> list[Said]:
    return [
        Said(
            "A follower may choose where it flies, how far and how flexed it flaps, and in which phase. It must carry "
            "its weight and overcome its drag, and the wake of the bird ahead can help with both."
        ),
        *lead(sources),
        *(
            Said(pose_in_words(optima[V]), (cost,), (PAPER,))
            for cost in costs_of(sources)
            for optima in optima_in(sources.pair, cost).values()
            if V in optima
        ),
    ]


CHAPTERS = (
    Chapter(
        "limit",
        "The same equations, refined",
        _limit_words,
        ("limit-place",),
        ("limit-phase", "limit-claims", "refinement"),
        "limit",
        "a pair in the limit by both laws of the wing's span",
        _limit_tables,
    ),
    Chapter(
        "drift",
        "What is left when the bird drifts",
        _drift_words,
        ("drift",),
        needs="the paper's pair, let drift by upwash reproduce",
    ),
    Chapter(
        "all-optima",
        "Not the only good place",
        _optima_words,
        ("optima-map",),
        needs="all optima of a pair",
        tables=_basin_tables,
    ),
    Chapter(
        "optimum",
        "Where a bird should fly behind another",
        _where_words,
        ("optimal-position",),
        tables=_optima_tables,
    ),
    Chapter(
        "observed",
        "What birds save where they were seen",
        _just(
            "Birds fly where they like, and drift. What is published of where they fly, evaluated as it stands: the "
            "paper's best place is a few centimetres wide, and no species was seen in it."
        ),
        ("observed-saving",),
        needs="what is kept with the code",
    ),
    Chapter(
        "why-there",
        "Why there",
        _just(
            "Flapping leaves a chain of vortex rings in the air. Lift and thrust from them are large in few places, "
            "and seldom both in one. The best place is where what is missing to fly with a smaller stroke is made up "
            "in both at once, with the inner wingtip at a vortex's edge."
        ),
        (),
        ("spacing-rule", "lone-wake", "configurations", "force-maps", "fixed-wings"),
        needs="the optimum of a pair",
    ),
    Chapter(
        "flock",
        "A flock",
        _just(
            "A flock is a chain of pairs: each bird flies in the wake of the one ahead, at its own optimum in the "
            "paper's model."
        ),
        ("flock-view",),
        ("flock-formation", "flock-saving"),
        "paper-flocks",
        "flocks",
        _flock_tables,
    ),
    Chapter(
        "species",
        "Other birds",
        _just(
            "Each species of the library, by both costs and both conventions for its amplitude, in the paper's model."
        ),
        (species_rows.PICTURES[0].name,),
        (*(picture.name for picture in species_rows.PICTURES[1:]), "species-groups", "species-observed"),
        "cross-species",
        "several species",
        _species_tables,
    ),
    Chapter(
        "parameters",
        "What it depends on",
        _just("One input at a time, about the same bird, in the paper's model."),
        (),
        ("speed-power", "parameter-saving"),
        "ibis-parameters",
        "inputs that are varied",
    ),
)
"""The chapters, what is news before the rest."""
