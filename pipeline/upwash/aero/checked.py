"""What an input must be: rules that are put together, say themselves in words, and hold wherever the input comes from.

A class of inputs declares the rule of each field beside it, so that a file, a command line and a call from Python are
held to the same:

>>> from dataclasses import dataclass, field
>>> @dataclass(frozen=True)
... class Egg:
...     mass_kg: float = field(metadata=must_be(positive & at_most(2.0, "no egg is heavier")))
...     def __post_init__(self) -> None:
...         check_fields(self)
>>> Egg(1)
Egg(mass_kg=1.0)
>>> rules_of(Egg)["mass_kg"].broken_by(3.0)
'at most 2 (no egg is heavier)'
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, fields, replace
from functools import cache
from numbers import Integral, Real
from typing import Any

_KEY = "must be"


class WrongInput(ValueError):
    """An input that is not what it must be.

    Parameters
    ----------
    name : str
        The input.
    expected : str
        What was expected, in words.
    value : object
        What was found.

    Examples
    --------
    >>> str(WrongInput("mass_kg", "a positive, finite number", -1.0))
    'mass_kg: expected a positive, finite number, found -1.0'
    """

    def __init__(self, name: str, expected: str, value: object) -> None:
        super().__init__(f"{name}: expected {expected}, found {value!r}")
        self.name = name
        self.expected = expected
        self.value = value


@dataclass(frozen=True)
class Rule:
    """What a value must be.

    Rules are put together by ``&``, the second being asked only where the first holds, and by ``|``.

    Parameters
    ----------
    words : str
        What is expected, as in "expected a whole number, found 2.5".
    holds : callable
        Whether it holds for a value.
    becomes : callable, optional
        What a value that fits is made into, as in 1 into 1.0.
    then : tuple of (str, callable)
        The words of what must hold as well, and whether it does.

    Examples
    --------
    >>> nodes = one_of(["exact"]) | whole_from(2)
    >>> nodes("span_nodes", "exact"), nodes("span_nodes", 5)
    ('exact', 5)
    >>> nodes("span_nodes", 1)
    Traceback (most recent call last):
    upwash.aero.checked.WrongInput: span_nodes: expected exact or a whole number of at least 2, found 1
    """

    words: str
    holds: Callable[[Any], bool]
    becomes: Callable[[Any], Any] | None = None
    then: tuple[tuple[str, Callable[[Any], bool]], ...] = ()

    def broken_by(self, value: object) -> str:
        """Return what was expected instead of a value, or "" if it fits."""
        if not self.holds(value):
            return self.words
        for words, holds in self.then:
            if not holds(value):
                return words
        return ""

    def __call__(self, name: str, value: Any) -> Any:
        """Return a value that fits, or raise a `WrongInput` that names the input."""
        expected = self.broken_by(value)
        if expected:
            raise WrongInput(name, expected, value)
        return self.becomes(value) if self.becomes else value

    def __and__(self, other: Rule) -> Rule:
        """Return the rule that both make."""
        return replace(self, then=(*self.then, (other.words, other.holds), *other.then))

    def __or__(self, other: Rule) -> Rule:
        """Return the rule that a value fits if it fits one of the two."""
        limits = [
            (
                words,
                lambda value, one=one, another=another, holds=holds: (
                    not one.holds(value) or holds(value) or not another.broken_by(value)
                ),
            )
            for one, another in ((self, other), (other, self))
            for words, holds in one.then
        ]

        def become(value: Any) -> Any:
            fitting = other if self.broken_by(value) else self
            return fitting.becomes(value) if fitting.becomes else value

        return Rule(
            f"{self.words} or {other.words}",
            lambda value: self.holds(value) or other.holds(value),
            become,
            tuple(limits),
        )


def _is_finite(value: object) -> bool:
    if type(value) is float:
        return math.isfinite(value)
    if isinstance(value, bool) or not isinstance(value, Real):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def _is_whole(value: object) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


def _because(why: str) -> str:
    return f" ({why})" if why else ""


finite = Rule("a finite number", _is_finite, float)
"""Any number but infinity and NaN; true and false are none."""

positive = Rule("a positive, finite number", lambda value: _is_finite(value) and value > 0, float)
"""A number above 0."""

not_negative = Rule(
    "a finite number that is not negative", lambda value: _is_finite(value) and value >= 0, float
)
"""0 or a number above it."""

ratio = Rule("a ratio strictly between 0 and 1", lambda value: _is_finite(value) and 0 < value < 1, float)
"""A number above 0 and below 1."""

fraction = replace(ratio, words="a number between 0 and 1")
"""The same of something that is no ratio."""


def at_most(most: float, why: str = "") -> Rule:
    """Return the rule that a number is no more than another, and why."""
    shown = most if isinstance(most, int) else f"{most:.12g}"
    return Rule(f"at most {shown}{_because(why)}", lambda value: value <= most)


def below(limit: float, why: str = "") -> Rule:
    """Return the rule that a number is less than another, and why."""
    return Rule(f"below {limit:.4g}{_because(why)}", lambda value: value < limit)


def whole_from(least: int, most: float = math.inf, why: str = "") -> Rule:
    """Return the rule of a whole number of at least `least`, and of at most `most` for a reason.

    Examples
    --------
    >>> whole_from(2, 1000, "more take hours")("birds", 10**9)
    Traceback (most recent call last):
    upwash.aero.checked.WrongInput: birds: expected at most 1000 (more take hours), found 1000000000
    """
    rule = Rule(f"a whole number of at least {least}", lambda value: _is_whole(value) and value >= least, int)
    return rule & at_most(most, why) if most < math.inf else rule


def within(least: float, most: float, why: str) -> Rule:
    """Return the rule that a number lies between two others, themselves included, and why."""
    return Rule(f"{least:g} to {most:g}{_because(why)}", lambda value: least <= value <= most)


REACH = positive & within(1e-9, 1e9, "no bird comes near these ends: look at the unit")
"""What any quantity of a bird must be, in SI units; beyond, products of inputs lose digits, overflow or vanish."""


def one_of(known: Iterable[str]) -> Rule:
    """Return the rule that a text is one of some."""
    known = tuple(known)
    words = f"one of {', '.join(known)}" if len(known) > 1 else known[0]
    return Rule(words, lambda value: isinstance(value, str) and value in known)


def must_be(rule: Rule) -> dict[str, Rule]:
    """Return the metadata by which a dataclass's field declares its rule."""
    return {_KEY: rule}


@cache
def rules_of(kind: type) -> dict[str, Rule]:
    """Return the rule of each field of a dataclass that declares one."""
    return {entry.name: entry.metadata[_KEY] for entry in fields(kind) if _KEY in entry.metadata}


def check_fields(value: Any) -> None:
    """Hold each field of a dataclass to its rule, and put what it becomes in its place.

    Raises
    ------
    WrongInput
        If a field breaks its rule.
    """
    for name, rule in rules_of(value.__class__).items():
        object.__setattr__(value, name, rule(name, getattr(value, name)))
