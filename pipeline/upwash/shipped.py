"""The files that come with the package: species, sweeps and kept results.

In a checkout, which may be installed editable, they stand at its top, where people look; a wheel carries the same files
inside the package.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

_PACKAGE = Path(__file__).parent

# setup.py copies the files there when it builds a wheel.
_INSIDE = "_shipped"


@cache
def checkout() -> Path | None:
    """Return the top of the checkout that the package runs from, or None where a wheel was installed."""
    top = _PACKAGE.parents[1]
    is_one = (top / "pyproject.toml").is_file() and top / "pipeline" / "upwash" == _PACKAGE
    return top if is_one else None


def shipped(name: str) -> Path:
    """Return a file or folder that comes with the package.

    Parameters
    ----------
    name : str
        Its path from the top of a checkout.

    Examples
    --------
    >>> (shipped("species") / "northern-bald-ibis.toml").is_file()
    True
    """
    return (checkout() or _PACKAGE / _INSIDE) / name
