"""What is left of a saving while a bird drifts, for a person."""

from __future__ import annotations

import pandas as pd

from upwash.report.table import Table
from upwash.report.words import least, percent
from upwash.study.robustness import V_FORMATION

FEW_CENTIMETRES = 0.995
"""Lengths below, in m, are told in centimetres."""


def robust_answer(rows: pd.DataFrame) -> str:
    """Say how far the best place reaches, and what is left of its saving while the place jitters.

    Parameters
    ----------
    rows : DataFrame
        As `upwash.study.robustness.robustness` returns.
    """
    first = rows.iloc[0]
    best = f"the {V_FORMATION} optimum" if first["region"] == V_FORMATION else "the global optimum"
    head = (
        f"{first['species']}, {least(first['objective'])}: at rest {best} saves {percent(first['saving_still'], 1)} "
        f"of its power ({first['x_m']:.3f} m behind, {first['y_m']:.3f} m aside, {first['z_m']:+.3f} m high, "
        f"phase {first['phase']:.2f})."
    )
    lines = [head, _reach(first), "", drift_table(rows).text()]
    if first["region"] != V_FORMATION:
        lines[1:1] = [f"It has no {V_FORMATION} optimum, so that all places were compared."]
    return "\n".join(lines)


def _reach(row: pd.Series) -> str:
    """Say how far from the place half of the saving is left."""
    ends = [
        f"{_length(row[f'half_width_{axis}_m_{low}'])} {low} or {_length(row[f'half_width_{axis}_m_{high}'])} "
        + high
        for axis, low, high in (
            ("x", "nearer", "farther"),
            ("y", "inward", "outward"),
            ("z", "below", "above"),
        )
    ]
    phases = [row[f"half_width_phase_{side}"] for side in ("earlier", "later")]
    beats = " or ".join(
        f"{value:.3f} {side}" if pd.notna(value) else f"never {side}"
        for value, side in zip(phases, ("earlier", "later"), strict=True)
    )
    fold = ""
    if pd.notna(row["fold_m"]):
        fold = f" The stroke that balances there can be followed for {_length(row['fold_m'])}."
    return f"Half of that is left {'; '.join(ends)}; and in a phase {beats}.{fold}"


def _length(value: float) -> str:
    if pd.isna(value):
        return "beyond three semispans"
    return f"{100.0 * value:.2g} cm" if value < FEW_CENTIMETRES else f"{value:.2f} m"


def drift_table(rows: pd.DataFrame) -> Table:
    """Return what is left for each deviation, from `upwash.study.robustness.robustness`."""
    frame = pd.DataFrame(
        {
            "drift (σ) b": rows["sigma_ratio"],
            "drift (σ) m": rows["sigma_m"],
            "one stroke held %": 100.0 * rows["saving_held"].astype(float),
            "trimmed anew %": 100.0 * rows["saving_retrimmed"].astype(float),
            "balances at %": 100.0 * rows["balanced_share"].astype(float),
            "best x m": rows["robust_x_m"].astype(float),
            "y m": rows["robust_y_m"].astype(float),
            "z m": rows["robust_z_m"].astype(float),
            "κ": rows["robust_phase"].astype(float),
            "saves there %": 100.0 * rows["robust_saving_held"].astype(float),
        }
    )
    formats = dict.fromkeys(("one stroke held %", "trimmed anew %", "balances at %", "saves there %"), ".1f")
    formats |= dict.fromkeys(("drift (σ) b", "drift (σ) m", "κ"), ".3g") | dict.fromkeys(
        ("best x m", "y m"), ".3f"
    )
    notes = (
        "drift: standard deviation of the place in x, y and z, each by itself; b: semispan",
        "one stroke held: the bird flaps always alike, so that it balances in the mean; trimmed anew: at each place",
        "balances at: share of the places at which some stroke balances; the mean of those trimmed anew is of these",
        "best: where one stroke that is held saves most while the place drifts so"
        + ("" if rows["region"].iloc[0] != V_FORMATION else f", sought in the {V_FORMATION}"),
    )
    return Table("What is left of it while the place drifts", frame, {**formats, "z m": "+.3f"}, notes)
