"""The page's first screen: a headline, a sentence, the V to scale, and three numbers with what they mean."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import pandas as pd

from upwash.aero.wake import ROLL_UP
from upwash.optimum.proof import is_proved, wall_in_words
from upwash.paper.claim import FAILS
from upwash.report.switches import LIMIT, PAPER, Said
from upwash.report.tables import GLOBAL, V, best_optima
from upwash.report.words import common_name, least, percent, words_of
from upwash.study.drift import TOLD_M
from upwash.study.rows import Row, objectives_of
from upwash.study.sources import Sources

STRAIGHT_BEHIND = 0.25
"""A place nearer than this to the leader's line, in semispans, is called straight behind."""


@dataclass(frozen=True)
class Number:
    """A number of the first screen: the same thing in each setting of the switches.

    Parameters
    ----------
    name, title : str
        Its name, and what it is of.
    values, notes : list of Said
        The number, and what it means.
    """

    name: str
    title: str
    values: list[Said]
    notes: list[Said]


def optima_in(frame: pd.DataFrame | None, cost: str) -> dict[str, dict[str, Row]]:
    """Return the V optimum and the global one of each law of the span; the paper's model knows the law of the tip."""
    if frame is None:
        return {}
    rows = frame[frame["objective"] == cost]
    return {str(law): best_optima(of_law) for law, of_law in rows.groupby("span_law", sort=True)}


def bird_in_words(sources: Sources) -> str:
    """Return whose results these are, as in a northern bald ibis; empty if of no single bird."""
    frame = sources.pair if sources.pair is not None else sources.limit
    if frame is None:
        return ""
    name = common_name(str(frame["species"].iloc[0])).lower()
    return f"{'an' if name[:1] in 'aeiou' else 'a'} {name}"


def costs_of(sources: Sources) -> list[str]:
    """Return the costs that were made least for one bird, in either model."""
    frames = [frame for frame in (sources.pair, sources.limit) if frame is not None]
    return list(dict.fromkeys(name for frame in frames for name in objectives_of(frame)))


def between(values: list[float], digits: int = 1) -> str:
    """Write some fractions as one percentage or two, as in 4.1–4.4 %."""
    low, high = (f"{100.0 * value:.{digits}f}".replace("-", "−") for value in (min(values), max(values)))
    return f"{low} %" if low == high else f"{low}{dash(values)}{high} %"


def metres(values: list[float]) -> str:
    """Write some lengths as one or two, as in 0.83–1.08 m."""
    low, high = (f"{value:.2f}".replace("-", "−") for value in (min(values), max(values)))
    return f"{low} m" if low == high else f"{low}{dash(values)}{high} m"


def dash(values: list[float]) -> str:
    """Return what stands between the ends of a range: a dash, if nobody could take it for a minus."""
    return "–" if min(values) >= 0.0 else " to "


def headline(sources: Sources) -> list[Said]:
    """Return the page's headline for each cost; none if the results are of no single bird."""
    bird, said = bird_in_words(sources), []
    for cost in costs_of(sources):
        paper = [one[V] for one in optima_in(sources.pair, cost).values() if V in one]
        limit = [one[V] for one in optima_in(sources.limit, cost).values() if V in one]
        of_paper = between([row["saving_total"] for row in paper], 0) if paper else ""
        of_limit = between([row["saving_total"] for row in limit], 0) if limit else ""
        if of_limit and of_paper:
            text = f"Flying in a V saves {bird} {of_limit} of its power, not {of_paper}"
        elif of_paper and sources.limit is not None and cost in objectives_of(sources.limit):
            text = (
                f"Flown for {least(cost)}, the V that saves {bird} {of_paper} does not survive a finer model"
            )
        elif of_paper or of_limit:
            text = f"Flying in a V saves {bird} {of_paper or of_limit} of its power"
        else:
            text = f"Flown for {least(cost)}, {bird} finds no best place in a V"
        said.append(Said(text, (cost,)))
    return said


def lead(sources: Sources) -> list[Said]:
    """Return one sentence for each cost and model: where the follower should fly."""
    said = []
    for cost in costs_of(sources):
        in_limit = optima_in(sources.limit, cost)
        if optima := next(iter(optima_in(sources.pair, cost).values()), {}):
            said.append(Said(_paper_sentence(cost, optima, list(in_limit.values())), (cost,), (PAPER,)))
        if in_limit:
            said.append(Said(_limit_sentence(cost, list(in_limit.values())), (cost,), (LIMIT,)))
    return said


def _paper_sentence(cost: str, optima: dict[str, Row], in_limit: list[dict[str, Row]]) -> str:
    row = optima.get(V, optima[GLOBAL])
    kind = "in a V" if V in optima else "of all, as there is none in a V,"
    text = (
        f"In the paper's model the best place {kind} is {row['x_m']:.2f} m behind and {row['y_m']:.2f} m aside of the "
        "bird ahead"
    )
    rows = [one[V] for one in in_limit if V in one]
    if in_limit and len(rows) == len(in_limit):
        text += (
            f"; refined, its equations want it {metres([row['y_m'] for row in rows])} aside, at any distance"
        )
    elif in_limit:
        text += f"; refined, its equations have no V optimum of {least(cost)}"
    return text + "."


def pose_in_words(row: Row) -> str:
    """Say how a follower of the paper's model flies at its place: how high, in what phase, and how it flaps."""
    less = 1.0 - float(row["amplitude_m"] / row["leader_amplitude_m"])
    return (
        f"There it flies {height_in_words(row['z_m'])}, lags it by {row['phase']:.2f} wingbeats, and flaps "
        f"{percent(abs(less))} {'less' if less >= 0.0 else 'more'} far."
    )


def height_in_words(z_m: float) -> str:
    """Write a height relative to the leader."""
    if abs(z_m) < 0.005:
        return "level with the bird ahead"
    return f"{abs(z_m):.2f} m {'below' if z_m < 0.0 else 'above'} the bird ahead"


def _limit_sentence(cost: str, optima: list[dict[str, Row]]) -> str:
    rows = [one[V] for one in optima if V in one]
    if len(rows) == len(optima):
        aside = metres([row["y_m"] for row in rows])
        return (
            f"Refined until nothing changes any more, the paper's equations want it {aside} aside at any distance, its "
            "wingtips on the path that the leader's left in the air."
        )
    rows = [one[GLOBAL] for one in optima]
    wall = next((row["v_wall"] for row in rows if row["v_wall"]), "")
    beyond = f": in the V it does best {wall_in_words(wall)}, and better still beyond" if wall else ""
    return (
        f"Refined until nothing changes any more, the paper's equations have no V optimum of {least(cost)}{beyond}. "
        f"The best of all is {metres([row['y_m'] for row in rows])} aside and saves "
        f"{between([row['saving_cost'] for row in rows])} of the {words_of(cost)}."
    )


def numbers(sources: Sources) -> list[Number]:
    """Return the numbers of the first screen; one whose results are not there is left out."""
    found = [_paper_number(sources), _limit_number(sources), _drift_number(sources)]
    return [number for number in found if number.values]


def _paper_number(sources: Sources) -> Number:
    number = Number("paper", "saved in the paper's model", [], [])
    for cost in costs_of(sources):
        for optima in optima_in(sources.pair, cost).values():
            if V not in optima:
                number.values.append(Said("no V", (cost,)))
                number.notes.append(Said("no place in a V is best", (cost,)))
                continue
            row = optima[V]
            gap = row["v_certified_gap"]
            sure = " (proved)" if not pd.isna(gap) and is_proved(gap, row["tolerance"]) else ""
            number.values.append(Said(percent(row["saving_total"], 1), (cost,)))
            number.notes.append(Said(f"of its power, at the best place in a V{sure}", (cost,)))
    return number


def _limit_number(sources: Sources) -> Number:
    number = Number("limit", "saved in the limit", [], [])
    for cost in costs_of(sources):
        optima = list(optima_in(sources.limit, cost).values())
        if not optima:
            continue
        rows = [one[V] for one in optima if V in one]
        if len(rows) < len(optima):
            number.values.append(Said("no V", (cost,)))
            number.notes.append(Said(f"{least(cost)} has no V optimum there", (cost,)))
            continue
        number.values.append(Said(between([row["saving_total"] for row in rows]), (cost,)))
        notes = ["the same equations, refined until nothing changes", _range(sources, cost)]
        number.notes.append(Said("; ".join(filter(None, notes)), (cost,)))
    return number


def _range(sources: Sources, cost: str) -> str:
    if sources.ranges is None:
        return ""
    rows = sources.ranges[sources.ranges["objective"] == cost]
    if rows.empty or rows["saving_total_low"].isna().all():
        return ""
    ends = [float(rows["saving_total_low"].min()), float(rows["saving_total_high"].max())]
    return f"{between(ends)} for other birds of its kind"


def drift_left(sources: Sources, cost: str) -> dict[str, list[dict[str, Any]]]:
    """Return what is left while the bird drifts by `TOLD_M`, by model."""
    if sources.drift is None:
        return {}
    rows = sources.drift[
        (sources.drift["objective"] == cost) & sources.drift["sigma_m"].sub(TOLD_M).abs().lt(1e-9)
    ]
    jobs = {
        model: set(frame["job_id"])
        for model, frame in ((PAPER, sources.pair), (LIMIT, sources.limit))
        if frame is not None
    }
    left: dict[str, list[dict[str, Any]]] = {
        model: rows[rows["job_id"].isin(ids) & rows["saving_held"].notna()].to_dict("records")  # type: ignore[misc]
        for model, ids in jobs.items()
    }
    return {model: found for model, found in left.items() if found}


def _drift_number(sources: Sources) -> Number:
    number = Number("drift", f"left if it drifts by {100.0 * TOLD_M:.0f} cm", [], [])
    for cost in costs_of(sources):
        left = drift_left(sources, cost)
        for model, rows in left.items():
            held, still = (between([row[f"saving_{name}"] for row in rows]) for name in ("held", "still"))
            of_whom = "the paper's" if model == PAPER else "the limit's"
            number.values.append(Said(held, (cost,), (model,)))
            number.notes.append(Said(f"of {of_whom} {still}, flapping always alike", (cost,), (model,)))
        if left and LIMIT not in left and sources.limit is not None:
            number.values.append(Said("no V", (cost,), (LIMIT,)))
            number.notes.append(Said("nothing to drift from", (cost,), (LIMIT,)))
    return number


def how_sure(sources: Sources) -> list[Said]:
    """Say how sure that is, and how many of the paper's claims fail."""
    if not costs_of(sources):
        return []
    text = "How sure: the best places are those of the model, and of no measured bird."
    if sources.claims is not None:
        count, fails = len(sources.claims), int((sources.claims["verdict"] == FAILS).sum())
        in_limit = int((sources.claims["limit_verdict"] == FAILS).sum())
        text += f" Of {count} claims of the paper {fails} fail in its own model, {in_limit} in the limit."
    return [Said(text)]


def straight_behind(row: Row) -> bool:
    """Whether a place is straight behind the leader, where a body's wake is missing."""
    return abs(float(row["y_m"])) < STRAIGHT_BEHIND * float(row["semispan_m"])


def scenes(sources: Sources) -> dict[str, dict[str, Any]]:
    """Return what the moving picture draws, lengths in semispans, for each cost and model."""
    return {f"{cost} {model}": scene for cost, model, scene in _scenes(sources)}


def _scenes(sources: Sources) -> Iterator[tuple[str, str, dict[str, Any]]]:
    for cost in costs_of(sources):
        for model, frame in ((PAPER, sources.pair), (LIMIT, sources.limit)):
            for optima in list(optima_in(frame, cost).values())[:1]:
                row = optima.get(V, optima[GLOBAL])
                b, wavelength = row["semispan_m"], row["speed_m_s"] * row["period_s"]
                place = f"{row['y_m']:.2f} m aside"
                behind = "at any distance behind" if model == LIMIT else f"{row['x_m']:.2f} m behind"
                yield (
                    cost,
                    model,
                    {
                        "x": _short(row["x_m"] / b),
                        "y": _short(row["y_m"] / b),
                        "phase": _short(row["phase"]),
                        "ratio": _short(row["upstroke_span_ratio"]),
                        "leader_ratio": _short(row["leader_upstroke_span_ratio"]),
                        "wavelength": _short(wavelength / b),
                        "length": None if model == LIMIT else float(row["wavelengths"]),
                        "half_width": _short(ROLL_UP),
                        "metre": _short(1.0 / b),
                        "label": f"The follower {behind} and {place}"
                        + ("" if V in optima else "; there is no best place in a V"),
                    },
                )


def _short(value: float) -> float:
    return round(float(value), 4)
