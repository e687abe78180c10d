"""Where birds were published to fly: the table of published observations, turned into places of followers."""

from __future__ import annotations

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.errors import UpwashError

COLUMNS = ("species", "study", "label", "quantity", "value", "low", "high", "unit", "basis", "this_model")
"""By these columns a table is known to hold published observations, one number a row."""

ASIDE = ("lateral_distance", "wingtip_spacing")
"""Quantities that say how far aside a bird flies: between bodies, or between wingtips."""


def is_published(frame: pd.DataFrame) -> bool:
    """Whether a table holds published observations and not a bird in each row."""
    return set(COLUMNS) <= set(frame.columns)


def published_places(species: str, bird: Bird, observations: pd.DataFrame) -> pd.DataFrame:
    """Return where a species was published to fly behind another bird.

    Parameters
    ----------
    species : str
        Name in the library.
    bird : Bird
        Its bird, by whose lengths some are published.
    observations : DataFrame
        As in ``species/observations.csv``.

    Returns
    -------
    DataFrame
        A row for each distance aside: ``study, label, quantity, basis`` of it, ``x_m``, ``y_m``, ``z_m``, and
        ``assumed``, of what no number is published: then a bird flies one wingspan behind, and level.  What comes of
        this very model is left out.

    Raises
    ------
    UpwashError
        If none is published of the species.

    Examples
    --------
    >>> from upwash import load_species
    >>> from upwash.study.observations import read_observations
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> published_places("northern-bald-ibis", ibis, read_observations())[["x_m", "y_m"]].round(3).values.tolist()
    [[1.2, 1.1], [1.2, 0.904], [1.2, 1.085]]
    """
    wingspan = 2.0 * bird.semispan_m
    unit = {"m": 1.0, "semispans": bird.semispan_m, "wingspans": wingspan, "wavelengths": bird.wavelength_m}
    is_ours = observations["this_model"].isin(["yes", True])
    rows = observations[(observations["species"] == species) & ~is_ours]
    value, low, high = (pd.to_numeric(rows[name], errors="coerce") for name in ("value", "low", "high"))
    rows = rows.assign(length=value.fillna((low + high) / 2.0) * rows["unit"].map(unit).astype(float))
    places = []
    for label, of_study in rows.dropna(subset="length").groupby("label", sort=False):
        lengths = of_study.set_index("quantity")["length"]
        behind, above = (
            lengths[name].iloc[0] if isinstance(lengths.get(name), pd.Series) else lengths.get(name, np.nan)
            for name in ("distance_behind", "vertical_distance")
        )
        assumed = [
            words
            for words, is_missing in (("one wingspan behind", np.isnan(behind)), ("level", np.isnan(above)))
            if is_missing
        ]
        for _, row in of_study[of_study["quantity"].isin(ASIDE)].iterrows():
            places.append(
                {
                    "study": row["study"],
                    "label": label,
                    "quantity": row["quantity"],
                    "basis": row["basis"],
                    "assumed": ", ".join(assumed),
                    "x_m": wingspan if np.isnan(behind) else float(behind),
                    "y_m": float(row["length"]) + (wingspan if row["quantity"] == "wingtip_spacing" else 0.0),
                    "z_m": 0.0 if np.isnan(above) else float(above),
                }
            )
    if not places:
        told = observations[observations["quantity"].isin(ASIDE) & observations["value"].notna() & ~is_ours]
        known = ", ".join(sorted(set(told["species"])))
        raise UpwashError(
            f"species: expected one of whose place aside a number is published ({known}), found {species}; "
            "name one of them, or a table with a row for each bird"
        )
    return pd.DataFrame(places)
