"""Words and numbers as people read them: names of birds and of costs, percentages, signs."""

from __future__ import annotations

import re
from functools import cache

from upwash.species.library import LIBRARY_FOLDER, load_species


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
