"""What a sweep file may say of a number: a value, a list, an even or geometric row, a sample of a range."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

SAMPLERS = ("latin-hypercube", "sobol", "saltelli")
MAX_POINTS = 1_000_000
LARGEST = 2**63 - 1
"""Of the whole numbers, which TOML and Parquet keep in 64 bits."""

_ROWS = ("linspace", "geomspace")


@dataclass(frozen=True, slots=True)
class Setting:
    """A value of a parameter: in its own unit, or as a factor on the species' own value, or a word."""

    value: Any
    relative: bool = False


def is_number(value: Any) -> bool:
    """Whether a value read from TOML is a number that a column can hold; true and false are none."""
    if isinstance(value, bool):
        return False
    return (
        isinstance(value, int) and abs(value) <= LARGEST or isinstance(value, float) and math.isfinite(value)
    )


def settings(spec: Any, only_one: bool = False, worded: bool = False) -> list[Setting]:
    """Read the values of one parameter.

    Parameters
    ----------
    spec : object
        A number; or a list of them; or a table with one of ``value``, ``values``, ``linspace`` and
        ``geomspace`` (as ``[first, last, count]``), and perhaps ``relative = true``.
    only_one : bool
        Whether just a single value makes sense here.
    worded : bool
        Whether a value may be a word.

    Raises
    ------
    ValueError
        If it is none of these; the message says "expected …, found …; remedy".
    """
    relative = False
    if isinstance(spec, dict):
        form, spec, relative = _open_table(spec, only_one)
        values = _row(form, spec) if form in _ROWS else spec if form == "values" else [spec]
    else:
        values = spec if isinstance(spec, list) and not only_one else [spec]
    if not isinstance(values, list) or not values or not all(_is_value(one, worded) for one in values):
        expected = "a finite number" if only_one else "finite numbers"
        raise ValueError(
            f"expected {expected}, found {values if only_one else spec!r}; write {_forms(only_one)}"
        )
    if len(values) > MAX_POINTS:
        raise ValueError(f"expected at most {MAX_POINTS} values, found {len(values)}; shorten the list")
    return [Setting(value, relative) for value in values]


def _is_value(value: Any, worded: bool) -> bool:
    return is_number(value) or (worded and isinstance(value, str))


def sampling_range(spec: Any) -> tuple[float, float, bool]:
    """Read a range to sample: ``[low, high]``, or ``{ range = [low, high], relative = true }``.

    Returns
    -------
    tuple
        Low, high, and whether they are factors on the species' own value.
    """
    relative = False
    ends = spec
    if isinstance(spec, dict):
        unknown = sorted(set(spec) - {"range", "relative"})
        relative = spec.get("relative", False)
        ends = spec.get("range") if not unknown and isinstance(relative, bool) else None
    if not (
        isinstance(ends, list) and len(ends) == 2 and all(map(is_number, ends)) and 0 < ends[0] < ends[1]
    ):
        remedy = "write [low, high] or { range = [low, high], relative = true }"
        raise ValueError(f"expected a range of positive numbers, low first, found {spec!r}; {remedy}")
    return float(ends[0]), float(ends[1]), relative


def unit_sample(method: str, count: int, dimensions: int, seed: int) -> NDArray[np.float64]:
    """Return points of the unit cube.

    Parameters
    ----------
    method : str
        One of `SAMPLERS`. ``sobol`` is scrambled; ``saltelli`` is the design for Sobol' sensitivity indices:
        for each point of a base sample A and its partner in B, the row of A, then A with one column at a time
        from B, then B.
    count : int
        Points; of the base sample if ``saltelli``. A power of two, unless it is a latin hypercube.
    dimensions : int
        Length of each point.
    seed : int
        Seed of the scrambling.

    Returns
    -------
    (n, dimensions) ndarray of float
        `count` points, or ``count * (dimensions + 2)`` for ``saltelli``.
    """
    import numpy as np
    from scipy.stats import qmc

    if method == "latin-hypercube":
        return qmc.LatinHypercube(dimensions, rng=seed).random(count)
    if method == "sobol":
        return qmc.Sobol(dimensions, scramble=True, rng=seed).random(count)
    pairs = qmc.Sobol(2 * dimensions, scramble=True, rng=seed).random(count)
    first, second = pairs[:, :dimensions], pairs[:, dimensions:]
    points = np.repeat(first[:, None, :], dimensions + 2, axis=1)
    for column in range(dimensions):
        points[:, 1 + column, column] = second[:, column]
    points[:, -1] = second
    return points.reshape(-1, dimensions)


def _open_table(spec: dict[str, Any], only_one: bool) -> tuple[str, Any, bool]:
    forms = ("value",) if only_one else ("value", "values", *_ROWS)
    named = [form for form in forms if form in spec]
    relative = spec.get("relative", False)
    if len(named) != 1 or set(spec) - {named[0], "relative"} or not isinstance(relative, bool):
        raise ValueError(
            f"expected {_forms(only_one)}, found keys {', '.join(map(str, spec)) or 'none'}; keep one form"
        )
    return named[0], spec[named[0]], relative


def _row(form: str, spec: Any) -> list[float]:
    import numpy as np

    if not (isinstance(spec, list) and len(spec) == 3 and all(map(is_number, spec))):
        raise ValueError(f"expected {form} = [first, last, count], found {spec!r}; write three numbers")
    first, last, count = spec
    if not isinstance(count, int) or not 2 <= count <= MAX_POINTS:
        expected = f"a count from 2 to {MAX_POINTS} as the third number of {form}"
        raise ValueError(f"expected {expected}, found {count!r}; correct it")
    if form == "geomspace" and not (first > 0 and last > 0):
        raise ValueError(
            f"expected geomspace between positive numbers, found {spec!r}; use linspace or other ends"
        )
    return (np.linspace if form == "linspace" else np.geomspace)(first, last, count).tolist()


def _forms(only_one: bool) -> str:
    one = "a number or { value = 1.1, relative = true }"
    return (
        one
        if only_one
        else "a list, { linspace = [a, b, n] } or { geomspace = [a, b, n] }, with relative = true for factors"
    )
