"""What birds save where they were published to fly, by both models, and where that is kept with the code."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from upwash.aero.wake import WakeModel
from upwash.shipped import shipped
from upwash.species import load_species
from upwash.study.observations import read_observations
from upwash.study.observed.evaluation import evaluate
from upwash.study.observed.published import published_places

KEPT = shipped("results/reference/observed.csv")
"""The savings of all species of which a place is published."""

SPECIES = (
    "northern-bald-ibis",
    "pink-footed-goose",
    "canada-goose",
    "greylag-goose",
    "dunlin",
    "common-starling",
)
"""The species of which a place is published."""

SAVINGS = (
    *("species", "study", "label", "quantity", "basis", "assumed", "model", "x_m", "y_m", "z_m", "phase"),
    *("outcome", "saving_total", "saving_mean_phase", "saving_worst_phase", "saving_at_v_optimum"),
)
"""Columns of what is kept: with the best phase, and over all phases."""


def published_savings(species: Iterable[str], models: Iterable[str] = ("paper", "limit")) -> pd.DataFrame:
    """Return what birds save where they were published to fly, for least power.

    Parameters
    ----------
    species : iterable of str
        Names in the library.
    models : iterable of str
        Named models of the wake.

    Returns
    -------
    DataFrame
        By the columns of `SAVINGS`.
    """
    observations, parts = read_observations(), []
    for name in species:
        bird = load_species(name).bird()
        places = published_places(name, bird, observations)
        for model in models:
            told = evaluate(bird, places, model=WakeModel.named(model))
            parts.append(told.assign(species=name, model=model)[list(SAVINGS)])
    return pd.concat(parts, ignore_index=True)


def read_published_savings() -> pd.DataFrame:
    """Return what `published_savings` gave of all species of which a place is published, as it is kept."""
    return pd.read_csv(KEPT, keep_default_na=False, na_values=[""]).fillna({"assumed": ""})
