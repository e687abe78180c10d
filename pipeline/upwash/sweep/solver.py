"""A sweep's own solver: the function that ``package.module:function`` names."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

from upwash.errors import UpwashError


def own_solver(name: str) -> Callable[..., Any]:
    """Return the function that a sweep names as its solver.

    Parameters
    ----------
    name : str
        ``package.module:function``.

    Raises
    ------
    UpwashError
        If the module cannot be imported, or has no such function; the message is without a place.
    """
    module, _, function = name.partition(":")
    try:
        found = getattr(import_module(module), function, None)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise UpwashError(
            f"expected a module {module} that can be imported, found {reason}; "
            "install it, or put its folder on PYTHONPATH"
        ) from error
    if not callable(found):
        what = "something else" if found is not None else "none"
        raise UpwashError(f"expected a function {function} in {module}, found {what}; correct the name")
    return found
