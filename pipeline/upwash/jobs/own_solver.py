"""A sweep's own solver: the function that ``package.module:function`` names, and what it must keep to.

It takes a `Job` and returns how that ended (one of `upwash.columns.STATUSES`), what went wrong or "", and its
rows: dicts by the names of the columns of `solutions.parquet`. Columns of its own it declares in its attribute
``columns``, a list of `upwash.columns.Column`.
"""

from __future__ import annotations

import inspect
import os
import re
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib import import_module
from typing import Any

from upwash import columns as of
from upwash.errors import UpwashError

COLUMN_NAME = re.compile(r"[a-z][a-z0-9_]{0,62}")
TYPES = (of.FLOAT, of.INTEGER, of.TEXT, of.TRUTH)


class BrokenContract(Exception):
    """What a solver returned is not what it must return."""


@cache
def own_solver(name: str) -> Callable[..., Any]:
    """Return the function that a sweep names as its solver; its module may lie in the current folder.

    Parameters
    ----------
    name : str
        ``package.module:function``.

    Raises
    ------
    UpwashError
        If the module cannot be imported, or has no such function, or that does not take a job or declares
        columns that cannot be; the message is without a place.
    """
    module, _, function = name.partition(":")
    make_importable(os.getcwd())
    try:
        found = getattr(import_module(module), function, None)
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise UpwashError(
            f"expected a module {module} that can be imported, found {reason}; "
            "install it, run in its folder, or put that on PYTHONPATH"
        ) from error
    if not callable(found):
        what = "something else" if found is not None else "none"
        raise UpwashError(f"expected a function {function} in {module}, found {what}; correct the name")
    try:
        inspect.signature(found).bind("job")
    except TypeError as error:
        remedy = f"write def {function}(job)"
        raise UpwashError(f"expected {name} to take one argument, a job, found {error}; {remedy}") from error
    except ValueError:
        pass  # of a function that is not written in Python nothing is known
    own_columns(found, name)
    return found


def make_importable(folder: str) -> None:
    """Let modules in a folder be imported, after all that are installed."""
    if folder not in sys.path:
        sys.path.append(folder)


def own_columns(solver: Callable[..., Any], name: str = "the solver") -> tuple[of.Column, ...]:
    """Return the columns that a solver declares as its own.

    Raises
    ------
    UpwashError
        If one is no `upwash.columns.Column`, has a name that cannot be or is taken, or lacks unit or description.
    """
    columns = getattr(solver, "columns", ())
    if not isinstance(columns, list | tuple) or not all(isinstance(one, of.Column) for one in columns):
        remedy = 'write solve.columns = [Column("name_unit", "unit", "what it says")]'
        raise UpwashError(
            f"expected the columns of {name} to be a list of upwash.columns.Column, found {columns!r}; {remedy}"
        )
    taken = set(of.names(of.COLUMNS))
    for column in columns:
        where = f"column {column.name!r} of {name}"
        if not COLUMN_NAME.fullmatch(str(column.name)):
            raise UpwashError(f"{where}: expected a name of small letters, digits and _; give it another")
        if column.name in taken:
            raise UpwashError(f"{where}: expected a name that no other column has; give it another")
        if column.type not in TYPES:
            raise UpwashError(
                f"{where}: expected a type of {', '.join(TYPES)}, found {column.type!r}; correct it"
            )
        if not column.description or (column.type in (of.FLOAT, of.INTEGER) and not column.unit):
            remedy = "say what it is; the unit of a pure number is 1"
            raise UpwashError(
                f"{where}: expected a description and, of numbers, a unit, found none; {remedy}"
            )
        taken.add(column.name)
    return tuple(columns)


def kept_to_contract(answer: Any) -> tuple[str, str, list[of.Row]]:
    """Return what a solver returned, if that is status, error and rows.

    Raises
    ------
    BrokenContract
        If it is not.
    """
    if not isinstance(answer, tuple) or len(answer) != 3:
        raise BrokenContract(f"expected status, error and rows, found {_short(answer)}")
    status, error, rows = answer
    if status not in of.STATUSES:
        raise BrokenContract(f"expected a status of {', '.join(of.STATUSES)}, found {_short(status)}")
    if not isinstance(error or "", str):
        raise BrokenContract(f'expected a line on what went wrong, or "", found {_short(error)}')
    if status != of.SOLVED and not error:
        raise BrokenContract(f"expected to learn why a job is {status}, found no error text")
    if not isinstance(rows, list | tuple) or not all(isinstance(row, Mapping) for row in rows):
        raise BrokenContract(f"expected a list of rows, each a dict by column, found {_short(rows)}")
    if status == of.SOLVED and not rows:
        raise BrokenContract("expected at least one row of a job that is solved, found none")
    return status, error or "", [dict(row) for row in rows]


def _short(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else text[:57] + "..."
