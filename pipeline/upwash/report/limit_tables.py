"""What is found behind an endless wake, by each law of the follower's span, as a table."""

from __future__ import annotations

import pandas as pd

from upwash.report.table import ABSENT, Table
from upwash.report.tables import GLOBAL, V, best_optima, by_objective, proof
from upwash.report.words import common_name, signed, words_of


def limit_optima(limit: pd.DataFrame) -> Table:
    """Put the best place of one bird by each objective and span law side by side.

    Parameters
    ----------
    limit : DataFrame
        All optima of one bird behind an endless wake.

    Returns
    -------
    Table
        One row an objective and span law: the V optimum, or where there is none the best of all.
    """
    rows = []
    for objective, of_it in by_objective(limit).items():
        for law, of_law in of_it.groupby("span_law", sort=True):
            optima = best_optima(of_law)
            label = V if V in optima else GLOBAL
            row = optima[label]
            rows.append(
                {
                    "least": words_of(objective),
                    "span law": law,
                    "optimum": label if V in optima else f"{label}, no V",
                    "y/b": row["y_semispans"],
                    "z/h_L": row["z_amplitudes"] + 0.0,
                    "Φ": signed(round(row["spatial_phase"], 3) + 0.0),
                    "h/h_L": 1.0 - row["amplitude_reduction"],
                    "R": row["upstroke_span_ratio"],
                    "power saved %": 100.0 * row["saving_total"],
                    "cost saved %": 100.0 * row["saving_cost"],
                    "proof": proof(row),
                }
            )
    frame = pd.DataFrame(rows).fillna(ABSENT)
    formats = {
        "y/b": ".3f",
        "z/h_L": ".3f",
        "h/h_L": ".3f",
        "R": ".3f",
        "power saved %": ".1f",
        "cost saved %": ".1f",
    }
    name = common_name(str(limit["species"].iloc[0]))
    notes = (
        "behind an endless wake any distance is as good as any other: the phase is κ = x/λ − Φ",
        "nothing yet decides between the two laws of the follower's span; what the bird's own ranges do to what is "
        "saved, 'upwash optimum --model limit' tells",
    )
    return Table(
        f"{name} in the limit: the best place by each law of the follower's span", frame, formats, notes
    )
