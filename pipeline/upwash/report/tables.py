"""The tables that commands print and the page shows, each made from rows of results.

Frames have the columns of ``solutions.parquet`` or, one row a job, of ``summary.parquet``.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf
from typing import Any

import pandas as pd

from upwash import columns as of
from upwash.aero.power import COST_FUNCTIONS
from upwash.batch.row_checks import RESIDUAL_LIMIT
from upwash.optimum.core_edge import BOTH, TURN, CoreEdge, edges_in
from upwash.optimum.proof import is_proved, wall_in_words
from upwash.paper.printed import PRINTED_VARIOUSLY, TABLE_1
from upwash.report.table import Table, shown
from upwash.report.words import least, model_in_words, power_of_ten, words_of
from upwash.study.quantities import with_quantities
from upwash.study.rows import Row

V, GLOBAL = "V optimum", "global optimum"
PROVED, OPEN = "proved to", "open"
PROOFS = {
    PROVED: " e: no other optimum in the V, or no position at all, costs less by more than the fraction e",
    OPEN: ": that is not proved; another may cost less by up to the gap",
}
"""What `proof` says, and what that means."""


def is_endless(row: Row) -> bool:
    """Whether the wake of a row has no end."""
    return bool(row["wavelengths"] == inf)


def has_other(row: Row) -> bool:
    """Whether the leader of a row is of another kind than its follower."""
    return isinstance(row["ahead_species"], str)


# What an optimum is described by: words, unit, how the value follows from its row, and whether in short too.
DESCRIPTION: tuple[tuple[str, str, Callable[[Row], Any], bool], ...] = (
    ("x, downstream of the leader", "m", lambda row: row["x_m"], True),
    ("", "wavelengths", lambda row: row["x_wavelengths"], False),
    ("y, to its right", "m", lambda row: row["y_m"], True),
    ("", "semispans", lambda row: row["y_semispans"], False),
    ("z, above it", "m", lambda row: row["z_m"], True),
    ("", "amplitudes h_L", lambda row: row["z_amplitudes"], False),
    ("h, tip-to-tip amplitude", "m", lambda row: row["amplitude_m"], True),
    ("", "amplitudes h_L", lambda row: None if has_other(row) else 1.0 - row["amplitude_reduction"], False),
    ("", "of its own alone", lambda row: 1.0 - row["amplitude_reduction"] if has_other(row) else None, False),
    ("R, upstroke span ratio", "", lambda row: row["upstroke_span_ratio"], True),
    ("κ, phase", "", lambda row: row["phase"], True),
    ("Φ, spatial phase x/λ − κ", "", lambda row: row["spatial_phase"] if is_endless(row) else None, False),
    ("placement", "", lambda row: row["placement"], True),
    ("tier", "", lambda row: row["tier"], True),
    ("station", "", lambda row: row["station"], True),
    ("self-generated lift", "N", lambda row: row["lift_self_n"], False),
    ("self-generated thrust", "N", lambda row: row["thrust_self_n"], False),
    ("self-generated force", "N", lambda row: hypot(row["lift_self_n"], row["thrust_self_n"]), True),
    ("total power", "W", lambda row: row["power_total_w"], True),
    ("energy per distance", "J/m", lambda row: row["power_total_w"] / row["speed_m_s"], False),
    ("saving of the cost", "%", lambda row: 100.0 * row["saving_cost"], False),
    ("saving of total power", "%", lambda row: 100.0 * row["saving_total"], True),
    ("saving of induced power", "%", lambda row: 100.0 * row["saving_induced"], False),
    ("saving of profile power", "%", lambda row: 100.0 * row["saving_profile"], False),
)


def table_1(solutions: pd.DataFrame) -> Table:
    """Compare the paper's Table 1 with the V optimum of least force.

    Parameters
    ----------
    solutions : DataFrame
        Optima of the paper's pair; those for other objectives are passed over.

    Returns
    -------
    Table
        One row a figure of the follower: the paper's, ours, and the difference over the paper's in percent.
    """
    best = best_optima(solutions[solutions["objective"] == "force"])[V]
    figures = TABLE_1.values()
    rows = [
        {
            "follower": figure.quantity,
            "unit": figure.unit,
            "paper": figure.values[0],
            "Upwash": figure.ours(best),
            "difference %": 100.0 * (figure.ours(best) / figure.values[0] - 1.0),
        }
        for figure in figures
    ]
    formats = {
        "paper": [f".{figure.decimals}f" for figure in figures],
        "Upwash": [f".{figure.decimals + 1}f" for figure in figures],
        "difference %": "+.2f",
    }
    return Table("Table 1 of the paper, and the V optimum of least force", pd.DataFrame(rows), formats)


def printed_variously(solutions: pd.DataFrame) -> Table:
    """Compare savings, and what the paper prints with several values, with the V optimum of least force.

    Parameters and result as for `table_1`; the paper's values are given as text.
    """
    best = best_optima(solutions[solutions["objective"] == "force"])[V]
    rows = []
    for figure in PRINTED_VARIOUSLY.values():
        places: dict[str, list[str]] = {place: [] for place in figure.places}
        for printed, place in zip(figure.printed, figure.places, strict=True):
            places[place].append(printed)
        printed = "; ".join(f"{' and '.join(values)} ({place})" for place, values in places.items())
        rows.append(
            {
                "follower": figure.quantity,
                "unit": figure.unit,
                "paper": printed,
                "Upwash": figure.ours(best),
            }
        )
    formats = {"Upwash": [f".{figure.decimals + 1}f" for figure in PRINTED_VARIOUSLY.values()]}
    return Table("Savings, and where the paper prints several values", pd.DataFrame(rows), formats)


def both_optima(solutions: pd.DataFrame, in_short: bool = False) -> Table:
    """Put the V optimum and the global optimum of each objective side by side, with the gap between them.

    Parameters
    ----------
    solutions : DataFrame
        Optima of one pair for one objective or several.
    in_short : bool
        Whether to leave out what follows from the rest.

    Returns
    -------
    Table
        One row a quantity; one column an optimum, or one for both where they are the same.
    """
    jobs = by_objective(solutions)
    columns: dict[str, Row] = {}
    for objective, rows in jobs.items():
        optima = best_optima(rows)
        if V in optima and optima[V]["is_global_optimum"]:
            optima = {f"V and {GLOBAL}": optima[V]}
        for label, row in optima.items():
            columns[label if len(jobs) == 1 else f"{words_of(objective)}: {label}"] = row
    best = {row["objective"]: row["cost"] for row in columns.values() if row["is_global_optimum"]}
    standing = (
        ("cost above the best's", "%", lambda row: 100.0 * (row["cost"] / best[row["objective"]] - 1.0)),
        ("imbalance of lift or thrust", "", imbalance),
        ("proof", "", proof),
    )
    described = [line[:3] for line in DESCRIPTION if line[3] or not in_short]
    cells = [
        {"quantity": words, "unit": unit, **{label: value(row) for label, row in columns.items()}}
        for words, unit, value in (*described, *standing)
        if any(value(row) is not None for row in columns.values())
    ]
    first = next(iter(columns.values()))
    title = f"{first['species']}: follower of {' and of '.join(least(name) for name in jobs)}"
    proofs = [str(cells[-1][label]) for label in columns]
    explained = [
        words + meaning for words, meaning in PROOFS.items() if any(words in told for told in proofs)
    ]
    # What holds of the V optimum holds of a job, so it is told once.
    walls = {row["v_wall"]: None for row in columns.values() if row["is_v_optimum"] and row["v_wall"]}
    explained += [
        f"a follower in the V does best {wall_in_words(wall)}, and better still beyond" for wall in walls
    ]
    model = model_in_words(first)
    if is_endless(first):
        model.append(
            "an endless wake is alike at any x: x is the distance asked for, and κ what follows from it"
        )
    return Table(title, pd.DataFrame(cells), {"%": ".2f"}, (*leader(first), *model, *explained))


def by_objective(solutions: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return the rows of each objective that has any, in the order in which cost functions are named."""
    parts = {name: solutions[solutions["objective"] == name] for name in COST_FUNCTIONS}
    return {name: rows for name, rows in parts.items() if len(rows)}


def leader(row: Row) -> tuple[str, ...]:
    """Describe the bird ahead on two lines: its lengths and stroke; its forces and power.

    A leader of another kind has a line of its own below those of the lone follower, whom savings are told of.
    """
    is_other = has_other(row)
    forces = {
        "weight": (row["weight_n"], "N"),
        "drag": (row["drag_n"], "N"),
        "total power": (row["leader_power_total_w"], "W"),
    }
    name = "follower alone" if is_other else "leader"
    lines = [f"{name}: {_listed(_lengths(row, 'leader_', '', '' if is_other else '_L'))};"]
    lines.append(f"{' ' * (len(name) + 2)}{_listed(forces)}")
    if is_other:
        ahead = {"mass": (row["ahead_mass_kg"], "kg"), **_lengths(row, "ahead_", "ahead_", "_L")}
        lines.append(f"leader, {row['ahead_species']}: {_listed(ahead)}")
        if row["phase_lock"]:
            lines.append("in step: the follower beats in its leader's period")
    if row["phase_lock"] is False:
        lines.append("each in its own beat: forces are averaged over all phases, and there is none to tell")
    return tuple(lines)


def _lengths(row: Row, stroke: str, rest: str, of: str) -> dict[str, tuple[float, str]]:
    """Return lengths and stroke of a bird by the prefixes of its columns; `of` is put to the symbols of the stroke."""
    return {
        "semispan b": (row[f"{rest}semispan_m"], "m"),
        "wavelength λ": (row["speed_m_s"] * row[f"{rest}period_s"], "m"),
        f"amplitude h{of}": (row[f"{stroke}amplitude_m"], "m"),
        f"upstroke span ratio R{of}": (row[f"{stroke}upstroke_span_ratio"], ""),
    }


def _listed(part: dict[str, tuple[float, str]]) -> str:
    return ", ".join(f"{name} {value:#.4g} {unit}".rstrip() for name, (value, unit) in part.items())


def best_optima(rows: pd.DataFrame) -> dict[str, Row]:
    """Return the V optimum and the global optimum of one job, `with_quantities`, if there are any."""
    labels = {V: "is_v_optimum", GLOBAL: "is_global_optimum"}
    chosen = {label: with_quantities(rows[rows[name].eq(True)]) for label, name in labels.items()}
    return {
        label: dict(zip(optima.columns, optima.iloc[0], strict=True))
        for label, optima in chosen.items()
        if len(optima)
    }


def imbalance(row: Row) -> str:
    """Say by how much lift and thrust miss weight and drag, or that it is within what checks allow."""
    worst = max(abs(row["residual_lift"]), abs(row["residual_thrust"]))
    return f"below {power_of_ten(RESIDUAL_LIMIT)}" if worst <= RESIDUAL_LIMIT else f"by {power_of_ten(worst)}"


def proof(row: Row) -> str:
    """Say what branch and bound has shown of a V optimum or a global optimum, in a few words."""
    region = "global" if row["is_global_optimum"] else "v"
    gap = row[f"{region}_certified_gap"]
    if pd.isna(gap):
        return "not examined"
    if is_proved(gap, row["tolerance"]):
        return f"{PROVED} {power_of_ten(gap)}"
    return f"{OPEN}, gap {power_of_ten(gap)}"


def basins(rows: pd.DataFrame) -> Table:
    """List all optima of one job with the evidence for each.

    Parameters
    ----------
    rows : DataFrame
        All optima of one job, best first.

    Returns
    -------
    Table
        One row an optimum. The core edges that it lies on are letters, explained in the notes.
    """
    best = rows["cost"].iloc[0]
    edges = [[_edge_in_words(edge) for edge in edges_in(text or "")] for text in rows["core_edges"]]
    letters = {
        edge: _letters(number) for number, edge in enumerate(sorted({one for some in edges for one in some}))
    }
    unit = COST_FUNCTIONS[rows["objective"].iloc[0]].unit
    where, places = shown(rows, (column for column in of.SOLUTIONS_COLUMNS if column.verified == of.FOUND))
    frame = pd.DataFrame(
        {
            "rank": rows["rank"].astype(int),
            "": ["V" if is_v else "" for is_v in rows["is_v_optimum"].astype(bool)],
            f"cost {unit}": rows["cost"],
            "above %": 100.0 * (rows["cost"] / best - 1.0),
            **where,
            "placement": rows["placement"],
            "tier": rows["tier"],
            "station": rows["station"],
            "hits": rows["hits"].astype(int),
            "bounds": [" ".join(split(text)) or "-" for text in rows["active_bounds"]],
            "edges": [" ".join(letters[edge] for edge in some) or "-" for some in edges],
            "stationarity": rows["stationarity"],
        }
    )
    formats = {f"cost {unit}": "#.6g", "above %": ".3f", "stationarity": ".0e", **places}
    count = f"{len(rows)} local optima of {words_of(rows['objective'].iloc[0])}"
    notes = [f"{letter}: {edge}" for edge, letter in letters.items()]
    head = [
        f"hits: of {int(rows['starts'].iloc[0])} starts; mu, of the bounds: |κ − ½|",
        *(["edges, cores of the leader's vortices that the follower's wingtips touch:"] if notes else []),
    ]
    return Table(count, frame, formats, (*head, *notes))


def _edge_in_words(edge: CoreEdge) -> str:
    """Say which wingtip rides which vortex."""
    if edge.filament == TURN:
        height, way = edge.state.split(" ")
        vortex = f"the vortex where the leader's {edge.ring} ends, {edge.shed} wavelengths downstream"
        return f"wing at {height} h on its {way}stroke on {vortex}"
    tip = {"left": "left wingtip", "right": "right wingtip", BOTH: "wingtips"}
    state = edge.state if edge.state in ("up", "down") else f"at {edge.state} h"
    shed_by = f"bird of row {edge.row}" if edge.row else "leader"
    point = tip.get(edge.point, f"span node {edge.point}")
    return f"{point} {state} on {edge.filament} of {edge.ring} ring ({shed_by} {edge.shed})"


def split(text: Any) -> list[str]:
    """Return the parts of a comma-separated text."""
    return [part.strip() for part in text.split(",")] if isinstance(text, str) and text else []


def _letters(number: int) -> str:
    """Return a, b, … z, aa, ab and so on."""
    head = _letters(number // 26 - 1) if number >= 26 else ""
    return head + chr(ord("a") + number % 26)
