"""When a follower should flap, in tables: the best phase against distance, and the rules that ibises keep."""

from __future__ import annotations

import pandas as pd

from upwash.report.table import ABSENT, Table
from upwash.report.words import least, percent
from upwash.study.phase_rule import IN_LINE, V, judge_rules

OBSERVED = "Portugal et al. (2014)"


def phase_answer(species: str, objective: str, rule: pd.DataFrame, curve: pd.DataFrame | None = None) -> str:
    """Say when a follower should flap, and whether ibises do so.

    Parameters
    ----------
    species, objective : str
        Whose rule, and of which cost.
    rule : DataFrame
        As `upwash.study.phase_rule.phase_rule` returns.
    curve : DataFrame, optional
        Every phase that was tried, to be listed too.
    """
    tables = [rule_table(species, objective, rule), verdict_table(rule)]
    if curve is not None:
        tables.append(_curve_table(curve))
    return "\n\n".join(table.text() for table in tables)


def rule_table(species: str, objective: str, rule: pd.DataFrame) -> Table:
    """Return the best and the worst phase at each distance, from `upwash.study.phase_rule.phase_rule`."""
    frame = pd.DataFrame(
        {
            "span law": rule["span_law"],
            "flying": rule["formation"],
            "x/λ": rule["x_wavelengths"],
            "y m": rule["y_m"],
            "best κ": [_beat(phase) for phase in rule["phase_best"]],
            "its Φ": _turns(rule["spatial_phase_best"]),
            "saves": _shares(rule["saving_best"]),
            "worst Φ": _turns(rule["spatial_phase_worst"]),
            "saves there": _worst(rule),
            "1st harmonic Φ": _turns(rule["harmonic_phase"]),
            "± cost": _shares(rule["harmonic_size"]),
        }
    )
    notes = [
        "κ: lag behind the leader in wingbeats; Φ = x/λ − κ: 0 where the wing retraces the path of the leader's",
        f"cannot fly: in some phases no stroke balances ({_grounded(rule)}); the middle of them is told",
        "1st harmonic: where the cost's is least, and how much it changes the cost; saving is of the cost",
    ]
    if not (rule["share_without_balance"] > 0.0).any():
        del notes[1]
    if not (rule["formation"] == V).any():
        notes.append(f"{least(objective)} has no V optimum, so that there is no place in a V to tell of")
    formats = {"x/λ": ".2f", "y m": ".3f"}
    return Table(f"{species}: best phase against distance, {least(objective)}", frame, formats, tuple(notes))


def verdict_table(rule: pd.DataFrame) -> Table:
    """Return the rules that ibises keep, and whether they come out, from `upwash.study.phase_rule.phase_rule`."""
    judged = [judge_rules(of_law).assign(law=law) for law, of_law in rule.groupby("span_law", sort=False)]
    frame = pd.concat(judged, ignore_index=True)
    shown = pd.DataFrame(
        {
            "rule": frame["rule"],
            "span law": frame["law"],
            "measured": frame["ours"],
            "value": frame["value"],
            "at most": frame["limit"],
            "comes out": ["yes" if holds else "no" for holds in frame["holds"]],
        }
    )
    note = f"ibises: {OBSERVED}; value: the one furthest from the rule over all distances"
    return Table(
        "What ibises do, and whether it comes out", shown, {"value": "+.3f", "at most": ".2f"}, (note,)
    )


def _curve_table(curve: pd.DataFrame) -> Table:
    shown = {
        "span law": curve["span_law"],
        "flying": curve["formation"],
        "x/λ": curve["x_wavelengths"],
        "κ": curve["phase"],
        "Φ": curve["spatial_phase"],
        "h m": curve["amplitude_m"],
        "R": curve["upstroke_span_ratio"],
        "saves": _shares(curve["saving_cost"]),
        "lacks": curve["missing"].replace("", ABSENT),
    }
    formats = {"x/λ": ".2f", "κ": ".3f", "Φ": "+.3f", "h m": ".3f", "R": ".3f"}
    return Table("Every phase that was tried", pd.DataFrame(shown), formats)


def _turns(phases: pd.Series) -> list[str]:
    """Write spatial phases; a rounded −½ is ½."""
    written = [ABSENT if pd.isna(phase) else f"{phase + 0.0:+.3f}".replace("-", "−") for phase in phases]
    return [{"−0.500": "+0.500", "−0.000": "+0.000"}.get(text, text) for text in written]


def _beat(phase: float) -> str:
    """Write a phase in [0, 1); one that is rounded to 1 is 0."""
    return ABSENT if pd.isna(phase) else f"{round(phase, 3) % 1.0:.3f}"


def _shares(values: pd.Series) -> list[str]:
    return [ABSENT if pd.isna(value) else percent(value, 1) for value in values]


def _worst(rule: pd.DataFrame) -> list[str]:
    shares = zip(rule["saving_worst"], rule["share_without_balance"], strict=True)
    return ["cannot fly" if grounded > 0.0 else percent(saving, 1) for saving, grounded in shares]


def _grounded(rule: pd.DataFrame) -> str:
    """Say in what share of the phases a bird cannot fly, in line where it is so."""
    grounded = rule[rule["share_without_balance"] > 0.0]
    shares = {
        (law, formation): group["share_without_balance"].max()
        for (law, formation), group in grounded.groupby(["span_law", "formation"], sort=False)
    }
    return ", ".join(
        f"{percent(share)} of them {formation if formation == IN_LINE else 'in the V'} by the {law} law"
        for (law, formation), share in shares.items()
    )
