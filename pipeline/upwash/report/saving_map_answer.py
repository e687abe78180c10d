"""A map of savings, told to a person: on how much of the plane birds save, and where most."""

from __future__ import annotations

from upwash.place.choices import STROKE
from upwash.report.words import percent, signed
from upwash.study.saving_map import NAMES, SavingMap
from upwash.study.told import NO_BALANCE, PAYS, SAVES


def saving_map_answer(found: SavingMap, species: str) -> str:
    """Return in some lines what a map shows."""
    outcome, count = found.values["outcome"], found.values["outcome"].size
    share = {word: float((outcome == word).sum()) / count for word in (SAVES, PAYS, NO_BALANCE)}
    free = ", ".join((*found.asked.free, STROKE))
    held = "".join(f", {NAMES[name]} {value:.3f}" for name, value in found.held.items())
    lines = [
        f"{species}: {len(found.second)} x {len(found.first)} places of the plane {found.asked.plane}{held}; "
        f"{free} optimised, stroke within {found.bounds} bounds",
        f"saves on {percent(share[SAVES])} of it, pays on {percent(share[PAYS])}, "
        f"cannot balance on {percent(share[NO_BALANCE])}",
    ]
    if best := found.best():
        lines.append(
            f"best of the map: saves {percent(best['saving_total'], 1)} {best['x_m']:.2f} m behind, "
            f"{best['y_m']:.2f} m aside, {signed(best['z_m'], 2)} m up, phase {best['phase']:.2f}"
        )
    if found.optimum is not None:
        x, y, z = found.optimum.position_m
        where = "in the plane" if found.shows_optimum() else "not in the plane"
        lines.append(
            f"V optimum within the paper's bounds: {x:.2f} m behind, {y:.2f} m aside, {signed(z, 2)} m up, "
            f"phase {found.optimum.phase:.2f}, {where}"
        )
    return "\n".join(lines)
