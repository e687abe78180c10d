"""A value of a TOML file that knows where it stands, so that every complaint about it can name the line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from upwash.aero.checked import Rule
from upwash.errors import UpwashError
from upwash.species.file import NO_TOML, did_you_mean, kind_of, printable
from upwash.sweep.toml_lines import key_lines, line_of


@dataclass(frozen=True)
class Entry:
    """A value and its place.

    Parameters
    ----------
    value : object
        As read from TOML.
    path : tuple
        Keys, and indices in arrays of tables, that lead to it from the top of the file.
    file : str
        The file, fit to be printed.
    lines : dict
        Line of each path of the file.
    """

    value: Any
    path: tuple[str | int, ...]
    file: str
    lines: dict[tuple[str | int, ...], int]

    def at(self, value: Any, *below: str | int) -> Entry:
        """Return a value that stands at a place below this one."""
        return Entry(value, (*self.path, *below), self.file, self.lines)

    def error(self, message: str) -> UpwashError:
        """Build the one line that says what is wrong and where; the message adds what to do."""
        names = [printable(name).strip("'") for name in self.path if isinstance(name, str)]
        key = f" {'.'.join(names)}:" if names else ""
        where = f"{self.file}, line {line_of(self.path, self.lines)}"
        return UpwashError(f"{where}:{key} {message}", field=str(self.path[-1]) if self.path else "")

    def unexpected(self, expected: str, remedy: str = "correct it") -> UpwashError:
        """Complain that the value is not what was expected."""
        return self.error(f"expected {expected}, found {printable(self.value)}; {remedy}")

    def table(self, known: Iterable[str] | None = None) -> dict[str, Entry]:
        """Return the entries of a table; with `known`, refuse any other key."""
        if not isinstance(self.value, dict):
            raise self.unexpected("a table", f"write [{self.path[-1]}] on a line of its own, its keys below")
        entries = {key: self.at(value, key) for key, value in self.value.items()}
        for key, entry in entries.items():
            if known is not None and key not in known:
                raise entry.error(f"expected a key that Upwash knows; {did_you_mean(key, known)}")
        return entries

    def tables(self) -> list[Entry]:
        """Return the tables of an array of tables, or the one table that stands in its place."""
        if isinstance(self.value, dict):
            return [self]
        if not isinstance(self.value, list) or not all(isinstance(table, dict) for table in self.value):
            raise self.unexpected("tables", f"head each with [[{self.path[-1]}]]")
        return [self.at(table, number) for number, table in enumerate(self.value)]

    def each(self) -> list[Entry]:
        """Return the values of a list, or the one value that stands in its place."""
        values = self.value if isinstance(self.value, list) else [self.value]
        if not values:
            raise self.unexpected("at least one value", "give one, or delete the key")
        return [self.at(value) for value in values]

    def text(self) -> str:
        """Return a text."""
        if not isinstance(self.value, str):
            raise self.unexpected("text", "put it in quotes")
        return self.value

    def truth(self) -> bool:
        """Return true or false."""
        if not isinstance(self.value, bool):
            raise self.unexpected("true or false")
        return self.value

    def one_of(self, names: Iterable[str]) -> str:
        """Return a text that is one of some names."""
        names = list(names)
        if not isinstance(self.value, str) or self.value not in names:
            raise self.unexpected(f"one of {', '.join(names)}", did_you_mean(str(self.value), names))
        return self.value

    def by(self, rule: Rule) -> Any:
        """Return the value, which must be what a rule says."""
        if expected := rule.broken_by(self.value):
            raise self.unexpected(expected)
        return rule.becomes(self.value) if rule.becomes else self.value


def read_toml(path: Path) -> tuple[str, Entry]:
    """Read a TOML file.

    Returns
    -------
    tuple
        Its text, and its content as the entry at the top.

    Raises
    ------
    UpwashError
        If it cannot be read, or is not valid TOML.
    """
    shown = str(path) if str(path).isprintable() else printable(str(path))
    if not path.is_file():
        found = "something else" if path.exists() else "no such file"
        raise UpwashError(f"{shown}: expected a TOML file, found {found}; check the path")
    try:
        raw = path.read_bytes()
    except OSError as error:
        found = f"one that cannot ({error.strerror})"
        raise UpwashError(f"{shown}: expected a file that can be read, found {found}; fix that") from error
    try:
        text = raw.decode("utf-8-sig").replace("\r\n", "\n")
        content = tomllib.loads(text)
    except UnicodeDecodeError as error:
        line = raw[: error.start].count(b"\n") + 1
        message = "expected text in UTF-8, found a byte that is not; save it as UTF-8"
        raise UpwashError(f"{shown}, line {line}: {message}") from error
    except RecursionError as error:
        message = "expected TOML, found values nested too deeply; flatten them"
        raise UpwashError(f"{shown}, line 1: {message}") from error
    except ValueError as error:
        if path.suffix.lower() != ".toml":
            raise UpwashError(f"{shown}: expected a TOML file, found {kind_of(path)}; {NO_TOML}") from error
        place = re.search(r"at line (\d+)", str(error))
        line = int(place[1]) if place else text.count("\n") + 1
        what = re.sub(r" \(at .*\)$", "", str(error))
        remedy = "correct that line: text needs quotes, and each key and [table] may appear once"
        raise UpwashError(
            f"{shown}, line {line}: expected valid TOML, found a mistake ({what}); {remedy}"
        ) from error
    return text, Entry(content, (), shown, key_lines(text))
