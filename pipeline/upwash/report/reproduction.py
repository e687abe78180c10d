"""What redoing the paper comes to: its Table 1 beside ours, both optima, whether its minimum is global."""

from __future__ import annotations

from typing import Any

import pandas as pd

from upwash.report.tables import (
    GLOBAL,
    V,
    best_optima,
    both_optima,
    by_objective,
    printed_variously,
    proof,
    table_1,
)
from upwash.report.words import least
from upwash.study.rows import Row


def reproduction(solutions: pd.DataFrame) -> str:
    """Put the paper's pair beside ours, in tables and sentences.

    Parameters
    ----------
    solutions : DataFrame
        All optima of the paper's pair, for ``force`` and any other objectives.
    """
    tables = table_1(solutions), printed_variously(solutions), both_optima(solutions, in_short=True)
    return "\n\n".join([*(table.text() for table in tables), "\n".join(_verdict(solutions))])


def reproduction_record(solutions: pd.DataFrame) -> dict[str, Any]:
    """Return what `reproduction` says as a dictionary fit for JSON; rows as for it."""
    return {
        "table_1": table_1(solutions).records(),
        "printed_variously": printed_variously(solutions).records(),
        "optima": both_optima(solutions).records(),
        "minimum_is_global": {
            objective: bool(optima[V]["is_global_optimum"])
            for objective, optima in _by_objective(solutions).items()
        },
    }


def _by_objective(solutions: pd.DataFrame) -> dict[str, dict[str, Row]]:
    return {name: best_optima(rows) for name, rows in by_objective(solutions).items()}


def _verdict(solutions: pd.DataFrame) -> list[str]:
    """Say for each objective whether the V optimum, which is the paper's point, is the best of all."""
    optima = _by_objective(solutions)
    claim = 'The paper suggests "that the attained minimum is global".'
    if all(best[V]["is_global_optimum"] for best in optima.values()):
        lines = [f"{claim} No better optimum than Table 1's, the V optimum, was found:"]
    else:
        lines = [
            f"{claim} It is not: Table 1 is the V optimum,",
            "the best that is outboard, level and astern; within the paper's own bounds another costs less:",
        ]
    return [*lines, *(f"  {least(objective)}: {_best(best)}" for objective, best in optima.items())]


def _best(optima: dict[str, Row]) -> str:
    """Say by how much, where, and how surely another optimum is better than the V optimum."""
    v, best = optima[V], optima[GLOBAL]
    if v["is_global_optimum"]:
        return f"the V optimum is the best ({proof(v)})"
    place = ", ".join(best[name] for name in ("placement", "tier", "station"))
    saved = 100.0 * (1.0 - best["cost"] / v["cost"])
    return f"{saved:.2f} % less ({place}; y = {best['y_m']:.3f} m, not {v['y_m']:.3f} m)"
