"""How far a flock flies on its fuel, for a person."""

from __future__ import annotations

import pandas as pd

from upwash.report.table import Table
from upwash.report.words import least, percent


def migration_answer(rows: pd.DataFrame) -> str:
    """Say how far a bird flies alone and in its flock, and how the flock's flight goes.

    Parameters
    ----------
    rows : DataFrame
        As `upwash.study.migration.migrate` returns.
    """
    first, last = rows.iloc[0], rows.iloc[-1]
    wind = (
        "no wind"
        if first["wind_m_s"] == 0.0
        else f"{abs(first['wind_m_s']):g} m/s of " + ("tailwind" if first["wind_m_s"] > 0.0 else "headwind")
    )
    head = (
        f"{first['species']}, {least(first['objective'])} at each step; amplitude by {first['amplitude_convention']}, "
        f"speed {first['speed_rule']}, fuel {percent(first['fuel'])} of the mass at take-off, {wind}"
    )
    parts = [head, ""]
    ranges = {int(size): rows[rows["birds"] == size] for size in rows["birds"].unique()}
    for size, flown in ranges.items():
        end = flown.iloc[-1]
        who = "Alone" if size == 1 else f"In a flock of {size}, taking turns,"
        if pd.isna(end["mass_kg"]):
            parts.append(f"{who} it does not take off: {end['ended']}.")
            continue
        gain = ""
        if size > 1 and ranges[1]["distance_m"].iloc[-1] > 0.0:
            ratio = end["distance_m"] / ranges[1]["distance_m"].iloc[-1]
            gain = f", {ratio:.3f} of the range alone"
        spent = "" if pd.isna(end["energy_j_m"]) else f" and {end['energy_j_m']:.3f} J/m of work"
        parts.append(
            f"{who} it flies {end['distance_m'] / 1e3:.0f} km in {end['time_s'] / 3600.0:.1f} h{spent}{gain}: "
            f"{end['ended']} (error of the range about {end['error_m']:.2g} m)."
        )
    flock = ranges[max(ranges)]
    if not pd.isna(last["mass_kg"]):
        parts += ["", flight_table(flock).text()]
    return "\n".join(parts)


def flight_table(rows: pd.DataFrame) -> Table:
    """Return the steps of one flight at take-off, at each tenth of the fuel and at the end."""
    told = rows[(rows["proof"] != "") | (rows["birds"] == 1)]
    told = told if len(told) else rows.iloc[[0, -1]]
    frame = pd.DataFrame(
        {
            "distance km": told["distance_m"].astype(float) / 1e3,
            "time h": told["time_s"].astype(float) / 3600.0,
            "mass kg": told["mass_kg"].astype(float),
            "speed m/s": told["speed_m_s"].astype(float),
            "power W": told["power_w"].astype(float),
            "saves %": 100.0 * told["saving"].astype(float),
            "x m": told["x_m"].astype(float),
            "y m": told["y_m"].astype(float),
            "κ": told["phase"].astype(float),
            "place": told["proof"],
        }
    )
    formats = {
        "distance km": ".0f",
        "time h": ".1f",
        "mass kg": ".3f",
        "speed m/s": ".2f",
        "power W": ".2f",
        "saves %": ".1f",
        "x m": ".3f",
        "y m": ".3f",
        "κ": ".3f",
    }
    notes = (
        "power, saves: the mean of the flock, and against a lone bird then and there; x, y, κ: of bird 2",
    )
    return Table("The flock's flight" if rows["birds"].iloc[0] > 1 else "The flight", frame, formats, notes)
