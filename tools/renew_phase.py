"""Renew results/reference/phase.csv: what the paper's bird saves in every phase, in the limit and in the paper's model.

``make reference`` does it, after a change that is meant to change results. Figures and tables of the page show it.
"""

from dataclasses import replace
from pathlib import Path

import pandas as pd
from upwash import SearchSettings, WakeModel, load_species
from upwash.study.phase_rule import phase_rules

KEPT = Path(__file__).parents[1] / "results" / "reference" / "phase.csv"
LIMIT = WakeModel.named("limit")
MODELS = (LIMIT, replace(LIMIT, span_law="tip"), WakeModel())


def solved() -> pd.DataFrame:
    """Solve the paper's bird in every phase, for least power."""
    bird = load_species("northern-bald-ibis").bird()
    return phase_rules(bird, "power", MODELS, SearchSettings(tolerance=1e-3))[1]


def as_csv(curve: pd.DataFrame) -> str:
    """Write the phases as CSV, numbers to six decimals."""
    return curve.round(6).to_csv(index=False, lineterminator="\n")


def main() -> None:
    """Solve, and keep what comes of it."""
    KEPT.write_text(as_csv(solved()), encoding="utf-8")


if __name__ == "__main__":
    main()
