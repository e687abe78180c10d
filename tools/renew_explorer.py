"""Renew the optima that the explorer takes a follower to: those of every species of the library, in both models.

Run it after a change of the species or one that is meant to change results; some ten minutes.
"""

from pathlib import Path

import pandas as pd
from joblib import Parallel, delayed
from upwash.report.explorer import optima
from upwash.species import load_library

FILE = Path(optima.__file__).parent / optima.KEPT


def rows_of(species):
    """Solve one species for every model and objective."""
    bird = species.bird()
    places = {
        (model, objective): optima.solve_best_places(bird, model, objective)
        for model in optima.MODELS
        for objective in optima.OBJECTIVES
    }
    return optima.kept_rows(bird, species.slug, places)


def main(jobs=-1):
    """Solve the library and write the file."""
    found = Parallel(n_jobs=jobs)(delayed(rows_of)(species) for species in load_library())
    pd.DataFrame([row for rows in found for row in rows]).to_csv(FILE, index=False, lineterminator="\n")


if __name__ == "__main__":
    main()
