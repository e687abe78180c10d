"""Figure: where the follower of each species flies, in wavelengths, wings and amplitudes."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from upwash.report.figures.drawing import FAINT, PAGE_WIDTH_IN, letter, styled
from upwash.report.figures.species_rows import add_legend, draw_rows, guide, name_rows, order_of, row_height
from upwash.study.comparison import compare

NAME = "species-position"
TITLE = "Species: where to fly"
NEEDS = ("species",)
MAY_TAKE = ("samples",)
CAPTION = (
    "The V optimum of each species, the lightest at the bottom: downstream in (a) wavelengths and (b) "
    "semispans, (c) to the side in semispans and (d) up in the leader's amplitudes. Filled: amplitude from "
    "the species' own stroke angle; hollow: from the ibis's Strouhal number. Thin lines, if any: 5 to 95 % "
    "of the samples of each bird's uncertain inputs. A species without a mark has no V optimum, or no such "
    "stroke is possible. Dashed: half a wavelength, and level with the leader."
)
PANELS = (
    ("x_wavelengths", "x/λ", "Downstream", 0.5),
    ("x_semispans", "x/b", "Downstream", None),
    ("y_semispans", "y/b", "To the side", None),
    ("z_amplitudes", "z/$h_L$", "Up", 0.0),
)


def describe(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> str:
    """Say in words what the figure shows."""
    found = compare(species, samples)
    x, y = found["x_wavelengths"].dropna(), found["y_semispans"].dropna()
    return (
        f"The positions of {found['species'].nunique()} species: {x.min():.2f} to {x.max():.2f} wavelengths "
        f"downstream, half of them within {x.quantile(0.25):.2f} to {x.quantile(0.75):.2f}, and "
        f"{y.min():.2f} to {y.max():.2f} semispans aside."
    )


@styled
def draw(species: pd.DataFrame, samples: pd.DataFrame | None = None) -> Figure:
    """Draw the positions of all species.

    Parameters
    ----------
    species : DataFrame
        All optima of several species.
    samples : DataFrame, optional
        All optima of a study that samples the species' inputs.

    Returns
    -------
    Figure
        The figure.
    """
    found, order = compare(species, samples), order_of(species)
    figure = Figure(figsize=(PAGE_WIDTH_IN, 1.3 + row_height(species)), layout="constrained")
    panels = figure.subplots(1, len(PANELS), sharey=True)
    guide(panels, order)
    for axes, (column, symbol, title, mark), name in zip(panels, PANELS, "abcd", strict=True):
        draw_rows(axes, found, column, order)
        if mark is not None:
            axes.axvline(mark, color=FAINT, linewidth=0.7, linestyle="--")
        axes.set_xlabel(symbol)
        letter(axes, name, title)
    name_rows(panels[0], order)
    add_legend(figure, found)
    return figure
