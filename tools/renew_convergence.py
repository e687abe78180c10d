"""Renew the tables of docs/convergence.md: how far the limit is converged, for the northern bald ibis.

    python tools/renew_convergence.py [results/refinement]

Each table stands between two marks that bear its name. It takes some minutes. With results of the sweep refinement, run
and aggregated, the table of finer strokes, spans and wakes is renewed as well.
"""

import math
import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd
from renew_comparison import between
from upwash import load_species
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.report.table import Table
from upwash.study.convergence import (
    LIMIT,
    STEPS,
    force_errors,
    long_wakes,
    random_poses,
    savings,
    with_orders,
)

PAGE = Path(__file__).parents[1] / "docs" / "convergence.md"
PLACES = 20
FINEST_STEPS = 512
LAWS, RULES = ("stroke", "tip"), ("held", "gauss")
POINTS = (2, 4, 8, 16, 32)
COARSE = [
    WakeModel(wavelengths=math.inf),
    WakeModel(wavelengths=math.inf, span_nodes="exact"),
    *(replace(LIMIT, span_nodes=points) for points in POINTS),
    LIMIT,
]
DISTANCES, LENGTHS = (0.1, 0.3, 0.5, 0.75, 1.0, 1.5, 2.5, 4.0), (1, 2, 4, 8, 16)
IN_THE_V = Stroke(0.95, 0.4)


def stepped(steps: tuple[int, ...]) -> list[list[WakeModel]]:
    """Return models of so many steps, by each span law and each rule."""
    return [
        [replace(LIMIT, stroke_states=n, stroke_rule=rule, span_law=law) for n in steps]
        for law in LAWS
        for rule in RULES
    ]


def force_table(bird: Bird) -> Table:
    """Return the errors of the force against the number of steps, and the order at which they fall."""
    models = [model for group in stepped(STEPS) for model in group]
    frame = force_errors(bird, random_poses(bird, PLACES), models)
    frame = with_orders(frame, {"lift_error": 0.0, "thrust_error": 0.0}, ("span_law", "stroke_rule"))
    shown = {
        "span_law": "span law",
        "stroke_rule": "rule",
        "stroke_states": "steps",
        "lift_error": "lift %",
        "lift_error_order": "order",
        "thrust_error": "thrust %",
        "thrust_error_order": "order ",
    }
    frame = frame.assign(lift_error=100.0 * frame["lift_error"], thrust_error=100.0 * frame["thrust_error"])
    formats = {"lift %": ".2g", "thrust %": ".2g", "order": ".1f", "order ": ".1f"}
    return Table("", frame[list(shown)].rename(columns=shown), formats)


def points_table(bird: Bird) -> Table:
    """Return the errors of coarser forces behind an endless wake."""
    frame = force_errors(bird, random_poses(bird, PLACES), COARSE)
    told = [f"{row.stroke_states} {row.stroke_rule}" for row in frame.itertuples()]
    shown = pd.DataFrame(
        {
            "steps": told,
            "points across the span": frame["span_nodes"].astype(str),
            "span law": frame["span_law"],
            "lift %": 100.0 * frame["lift_error"],
            "thrust %": 100.0 * frame["thrust_error"],
        }
    )
    return Table("", shown, {"lift %": ".3g", "thrust %": ".3g"})


def savings_table(bird: Bird, objective: str) -> Table:
    """Return what the best follower saves, and where it flies, against the number of steps."""
    frames = [savings(bird, objective, group) for group in stepped((*STEPS, FINEST_STEPS))]
    frame = pd.concat(frames, ignore_index=True)
    shown = {
        "span_law": "span law",
        "stroke_rule": "rule",
        "stroke_states": "steps",
        "saving": "saving %",
        "spatial_phase": "Φ",
        "y_semispans": "y/b",
        "z_amplitudes": "z/h",
    }
    frame = frame.assign(saving=100.0 * frame["saving"])
    formats = {"saving %": ".4f", "Φ": ".3f", "y/b": ".3f", "z/h": ".3f"}
    return Table("", frame[list(shown)].rename(columns=shown).round({"Φ": 6, "z/h": 6}), formats)


def long_wakes_table(bird: Bird) -> Table:
    """Return by how much the thrust behind wakes that begin at the leader differs from the endless wake's."""
    pose = Pose(0.5 * bird.wavelength_m, 1.81 * bird.semispan_m, 0.0, IN_THE_V, 0.5)
    gaps = long_wakes(bird, pose, DISTANCES, LENGTHS)
    frame = 100.0 * gaps.pivot(index="x_wavelengths", columns="wavelengths", values="thrust_gap")
    frame.columns = [f"wake of {length} λ, %" for length in frame.columns]
    frame.insert(0, "x/λ", frame.index)
    return Table("", frame, dict.fromkeys(frame.columns[1:], ".2f") | {"x/λ": ".2f"})


def refinement_table(rows: pd.DataFrame, objective: str) -> Table:
    """Return the best place of all and the best V of each job of one objective, the coarsest first.

    What is saved is a share of the cost: of power, or of force.
    """
    rows = rows.assign(saving=1.0 - rows["cost"] / rows["cost_leader"])
    rows = rows[rows["objective"] == objective].sort_values(
        ["wavelengths", "stroke_states", "stroke_rule", "span_nodes", "span_law", "rank"],
        key=lambda column: column.map({"held": 0, "gauss": 1}) if column.name == "stroke_rule" else column,
    )
    lines = []
    for _, job in rows.groupby("job_id", sort=False):
        best, in_v = job.iloc[0], job[job["is_v_optimum"].fillna(value=False).astype(bool)]
        points = "exact" if pd.isna(best["span_nodes"]) else f"{best['span_nodes']:.0f}"
        length = "endless" if math.isinf(best["wavelengths"]) else f"{best['wavelengths']:.0f}"
        line = {
            "wake, λ": length,
            "states": f"{best['stroke_states']:.0f} {best['stroke_rule']}, {best['span_law']}",
            "points": points,
            "best saves %": 100.0 * best["saving"],
            "at x/λ, y/b, z/h": _place(best),
        }
        if len(in_v):
            line |= {"V saves %": 100.0 * in_v.iloc[0]["saving"], "V at": _place(in_v.iloc[0])}
        lines.append(line)
    digits = ".1f" if objective == "power" else ".2f"
    return Table("", pd.DataFrame(lines), {"best saves %": digits, "V saves %": digits})


def _place(row: pd.Series) -> str:
    x = (
        "any"
        if math.isinf(row["wavelengths"])
        else f"{row['x_m'] / (row['speed_m_s'] * row['period_s']):.2f}"
    )
    y, z = row["y_m"] / row["semispan_m"], row["z_m"] / row["leader_amplitude_m"]
    return f"{x}, {y:.2f}, {z + 0.0:.2f}".replace("-0.00", "0.00")


def tables(bird: Bird) -> dict[str, Table]:
    """Return the page's tables by their names."""
    return {
        "forces": force_table(bird),
        "points": points_table(bird),
        "savings-power": savings_table(bird, "power"),
        "savings-force": savings_table(bird, "force"),
        "long-wakes": long_wakes_table(bird),
    }


def main(results: str | None = None) -> None:
    """Put the tables into the page."""
    text = PAGE.read_text(encoding="utf-8")
    found = tables(load_species("northern-bald-ibis").bird())
    if results:
        rows = pd.read_parquet(Path(results) / "solutions.parquet")
        found["refinement"] = refinement_table(rows, "power")
        found["refinement-force"] = refinement_table(rows, "force")
    for name, table in found.items():
        body = table.markdown().partition("\n\n")[2]
        text, count = between(name).subn(lambda _, body=body: f"\n{body}\n\n", text)
        if count != 1:
            sys.exit(f"{PAGE}: expected one table named {name}, found {count}; mark its place")
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
