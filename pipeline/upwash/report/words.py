"""Words and numbers as people read them: names of birds and of costs, percentages, signs."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from math import inf
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.aero.wake import NAMES
from upwash.species.library import LIBRARY_FOLDER, load_species
from upwash.study.rows import model_of

if TYPE_CHECKING:
    import pandas as pd


@cache
def common_name(species: str) -> str:
    """Return a species' name for people: the library's, or the name of its file with blanks."""
    path = LIBRARY_FOLDER / f"{species}.toml"
    return load_species(path).common_name if path.exists() else species.replace("-", " ").capitalize()


def words_of(name: str) -> str:
    """Return a name that programs use, as ``cost_of_transport``, as words."""
    return name.replace("_", " ")


def least(objective: str) -> str:
    """Return what is minimised, as in least cost of transport."""
    return f"least {words_of(objective)}"


def signed(value: float, digits: int = 3) -> str:
    """Return a number with its sign, a true minus, and so many decimals."""
    return f"{value:+.{digits}f}".replace("-", "−")


def percent(value: float, digits: int = 0) -> str:
    """Return a fraction as a percentage with a true minus and so many decimals."""
    return f"{100.0 * value:.{digits}f} %".replace("-", "−")


def power_of_ten(value: float) -> str:
    """Write a small number as 1.0e-4."""
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def true_minus(text: str) -> str:
    """Return a text with a true minus before its negative numbers."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", text)


def length_of_wake(row: Mapping[str, Any] | pd.Series) -> str:
    """Say how long a row's wakes are."""
    length = of.column("wavelengths").told(row["wavelengths"])
    return "endless" if isinstance(length, str) else f"{length} wavelength{'s' if length > 1 else ''}"


def model_in_words(row: Mapping[str, Any] | pd.Series) -> list[str]:
    """Say how the wakes of a row are resolved, on a line if otherwise than in the paper."""
    if row["model"] == NAMES[0]:
        return []
    name = f"the {row['model']} model" if row["model"] in NAMES else "as given"
    nodes = of.column("span_nodes").told(row["span_nodes"])
    parts = [
        f"{row['stroke_states']} {'steps' if row['stroke_rule'] == 'gauss' else 'states'} of a wingbeat",
        "the whole span" if isinstance(nodes, str) else f"{nodes} points of the span",
        f"a wake of {length_of_wake(row)}" if row["wavelengths"] < inf else "an endless wake",
        f"{row['core'].replace('rosenhead-moore', 'Rosenhead–Moore').replace('rankine', 'Rankine')} cores "
        f"of {row['core_radius_ratio']:g} b",
        f"span by the {row['span_law']}",
    ]
    lines = [f"wake: {name}: {', '.join(parts)}"]
    if row["wavelengths"] == inf:
        if line := model_of(row).coarseness(row["speed_m_s"] * row["period_s"] / row["semispan_m"]):
            lines.append(line)
        other = "tip" if row["span_law"] == "stroke" else "stroke"
        lines.append(
            f"by the other law of the span (--set span_law={other}) other places and savings are found"
        )
    return lines
