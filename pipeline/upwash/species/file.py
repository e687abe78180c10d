"""Reading one species file: TOML in, quantities in SI units out, or one line on what is wrong."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from upwash.aero.checked import finite, positive
from upwash.errors import UpwashError
from upwash.species.allometry import AS_IBIS, RULES
from upwash.species.quantity import BASES, FORMATION_SHAPES, QUANTITIES, Formation, Kind, Quantity

# A value that a file states beside the rule that filled it may differ from the rule by rounding, not by more.
RULE_ROUNDING = 0.01

NAMES = ("common_name", "scientific_name")
QUANTITY_KEYS = ("value", "unit", "low", "high", "basis", "rule", "source", "sample", "note")
FORMATION_KEYS = ("shape", "basis", "source", "note")


@dataclass(frozen=True)
class SpeciesFile:
    """What one species file says."""

    common_name: str
    scientific_name: str
    quantities: dict[str, Quantity]
    formation: Formation | None
    note: str


class WrongFile(UpwashError):
    """A species file with something wrong in it.

    Parameters
    ----------
    path : Path
        The file.
    mistakes : list of str
        One line each, the first of which the message is.
    """

    def __init__(self, path: Path, mistakes: list[str]) -> None:
        more = len(mistakes) - 1
        rest = f" ({more} more: 'upwash species check {path}' says them all)" if more else ""
        super().__init__(mistakes[0] + rest)
        self.mistakes = mistakes


# What people ask for by another name -> what there is, and how to get at it.
OTHERWISE_NAMED = {
    "wingspan": "semispan_m, which is half of the wingspan",
    "wing_span": "semispan_m, which is half of the wingspan",
    "semispan": "wingspan, which is twice the semispan",
    "frequency": "period_s, which is one over the frequency",
    "wingbeat_frequency": "period_s, which is one over the frequency",
    "period": "wingbeat_frequency, which is one over the period",
    "wingbeat_period": "wingbeat_frequency, which is one over the period",
}


def printable(value: object) -> str:
    """A value from outside, short and on one line."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def did_you_mean(name: str, names: Iterable[str]) -> str:
    """Name what stands for a name among `names`, or the nearest of them, or list them all where none is near."""
    names = list(names)
    plain = re.sub(r"_(m|cm|s|hz)$", "", name.lower())
    if OTHERWISE_NAMED.get(plain, "").partition(",")[0] in names:
        return f"write {OTHERWISE_NAMED[plain]}"
    near = get_close_matches(name, names, n=1, cutoff=0.6)
    return f"did you mean {near[0]!r}?" if near else f"choose from {', '.join(names)}"


OF_SWEEPS = {"block", "exclude", "fixed", "flock", "grid", "kind", "objective", "sample", "species", "zip"}
"""Keys by which a sweep file is known where a species file was expected."""

NO_TOML = "write one ending in .toml, as the documentation shows"


def kind_of(path: Path) -> str:
    """Say what a file that is no TOML is, by its ending."""
    ending = path.suffix.lstrip(".")
    return f"a file of kind {ending.upper()}" if ending else "a file without an ending"


def file_here(name: str) -> str:
    """Return the remedy for a name that is unknown but is, or lacks only the ending of, a file right here."""
    for path in (Path(name), Path(f"{name}.toml")):
        if name and "\0" not in name and path.is_file():
            return f"a file in this folder is given by its path: ./{path}"
    return ""


def read_species_file(path: Path, ibis: Callable[[], Mapping[str, Quantity]]) -> SpeciesFile:
    """Read and check a species file.

    Parameters
    ----------
    path : Path
        The file.
    ibis : callable
        Returns the northern bald ibis's quantities; called only if a value is taken over from it.

    Returns
    -------
    SpeciesFile
        Its content, in SI units (angles in degrees).

    Raises
    ------
    UpwashError
        If it cannot be read, or something in it is missing, unknown, of the wrong kind or out of bounds;
        a `WrongFile` holds all such mistakes at once.
    """
    return _Reader(path, ibis).read()


class _Reader:
    """Checks one file; every complaint names the file, the table and the key."""

    def __init__(self, path: Path, ibis: Callable[[], Mapping[str, Quantity]]) -> None:
        self.path = path
        self.ibis = ibis
        self.tables: dict[str, dict[str, Any]] = {}
        self.mistakes: list[str] = []

    @contextmanager
    def noting(self) -> Iterator[None]:
        """Note a mistake and go on, so that one reading finds them all."""
        try:
            yield
        except UpwashError as error:
            if str(error) not in self.mistakes:
                self.mistakes.append(str(error))

    def error(self, where: str, expected: str, found: str, remedy: str) -> UpwashError:
        """Build the one line that says what is wrong, where, and what to do."""
        name = str(self.path) if str(self.path).isprintable() else printable(str(self.path))
        return UpwashError(f"{name}: {where}: expected {expected}, found {found}; {remedy}")

    def read(self) -> SpeciesFile:
        content = self.parse()
        if not set(NAMES) & set(content) and OF_SWEEPS & set(content):
            remedy = f"'upwash run {self.path}' solves it"
            raise self.error("file", "a species file", "a sweep file", remedy)
        known = [*NAMES, "note", *QUANTITIES, "formation"]
        self.refuse_unknown(content, known, "top level")
        names: dict[str, str] = {}
        for key in (*NAMES, "note"):
            with self.noting():
                names[key] = self.text(content, key, "top level", optional=key == "note")
        for name, kind in QUANTITIES.items():
            with self.noting():
                if self.needed(content, name, kind):
                    self.tables[name] = self.table(content, name)
        quantities: dict[str, Quantity] = {}
        # Rules compute from stated values, so those are read first.
        for name in sorted(self.tables, key=lambda name: "rule" in self.tables[name]):
            with self.noting():
                quantity = self.quantity(name, self.tables[name], quantities)
                if quantity:
                    quantities[name] = quantity
        formation = None
        with self.noting():
            formation = self.formation(content)
        if self.mistakes:
            raise WrongFile(self.path, self.mistakes)
        return SpeciesFile(
            quantities={name: quantities[name] for name in QUANTITIES if name in quantities},
            formation=formation,
            **names,
        )

    def parse(self) -> dict[str, Any]:
        if not self.path.is_file():
            found = "no such file" if not self.path.exists() else "something else"
            raise self.error(
                "file",
                "a species file (TOML)",
                found,
                "check the path, or list names by 'upwash species list'",
            )
        try:
            return tomllib.loads(self.path.read_text(encoding="utf-8-sig"))
        except OSError as error:
            raise self.error(
                "file", "a file that can be read", str(error.strerror), "check its permissions"
            ) from error
        except UnicodeDecodeError as error:
            raise self.error(
                "file", "text in UTF-8", f"a byte that is not, at {error.start}", "save it as UTF-8"
            ) from error
        except (ValueError, RecursionError) as error:
            if self.path.suffix.lower() != ".toml":
                raise self.error("file", "a species file (TOML)", kind_of(self.path), NO_TOML) from error
            found = "tables nested too deeply" if isinstance(error, RecursionError) else f"a mistake: {error}"
            remedy = "correct that line: text needs quotes, and each [table] may appear once"
            raise self.error("TOML syntax", "a valid TOML file", found, remedy) from error

    def refuse_unknown(self, table: Mapping[str, Any], known: Iterable[str], where: str) -> None:
        for key in table:
            if key not in known:
                raise self.error(
                    where, "only keys that Upwash knows", printable(key), did_you_mean(key, known)
                )

    def text(self, table: Mapping[str, Any], key: str, where: str, optional: bool = False) -> str:
        value = table.get(key, "")
        if key not in table and not optional:
            raise self.error(where, f'{key} = "..."', "no such key", f"add {key}")
        if (
            not isinstance(value, str)
            or (not optional and value.strip() in ("", "?"))
            or not value.isprintable()
        ):
            raise self.error(
                f"{where} {key}", "a line of text", printable(value), f"write {key} in quotes, on one line"
            )
        return value.strip()

    def needed(self, content: Mapping[str, Any], name: str, kind: Kind) -> bool:
        """Whether a quantity is there to be read; complain if it is not and must be."""
        if name in content:
            return True
        if kind.optional:
            return False
        by_rule = "".join(f', or with rule = "{rule}"' for rule in kind.rules)
        raise self.error(
            f"[{name}]", "this table", "none", f"add it with a value and its unit ({kind.unit}){by_rule}"
        )

    def table(self, content: Mapping[str, Any], name: str) -> dict[str, Any]:
        table = content[name]
        if not isinstance(table, dict):
            raise self.error(
                f"[{name}]",
                "a table",
                printable(table),
                f"write [{name}] on a line of its own, its keys below",
            )
        return table

    def quantity(self, name: str, table: Mapping[str, Any], known: Mapping[str, Quantity]) -> Quantity | None:
        """Read a quantity; a rule supplies what the table leaves out. None if a mistake in it is noted."""
        where, kind = f"[{name}]", QUANTITIES[name]
        self.refuse_unknown(table, QUANTITY_KEYS, where)
        filled = self.rule(name, table, known) if "rule" in table else None
        if "rule" in table and not filled:
            return None
        before = len(self.mistakes)
        numbers: list[float] = []
        for key in ("value", "low", "high"):
            with self.noting():
                taken = filled and key not in table
                numbers.append(getattr(filled, key) if taken else self.number(table, key, name))
        basis, source = (filled.basis, filled.source) if filled else ("", "")
        with self.noting():
            basis = self.choice(table, "basis", BASES, where) if "basis" in table or not filled else basis
        with self.noting():
            source = self.text(table, "source", where) if "source" in table or not filled else source
        if len(self.mistakes) > before:
            return None
        value, low, high = numbers
        if not low <= value <= high:
            raise self.error(
                where,
                "low <= value <= high",
                f"{low:g}, {value:g}, {high:g} {kind.unit}",
                "correct the one that is wrong",
            )
        if filled and not math.isclose(value, filled.value, rel_tol=RULE_ROUNDING):
            raise self.error(
                f"{where} value",
                f"{filled.value:.4g} {kind.unit} by rule {filled.rule!r}",
                f"{value:g}",
                "delete the value, or the rule if it is not the rule's",
            )
        if filled and basis != filled.basis:
            raise self.error(
                f"{where} basis", f"{filled.basis!r} with rule {filled.rule!r}", printable(basis), "delete it"
            )
        return Quantity(
            value=value,
            unit=kind.unit,
            low=low,
            high=high,
            basis=basis,
            source=source,
            rule=filled.rule if filled else "",
            sample=self.sample(table, where),
            note=self.text(table, "note", where, optional=True),
        )

    def number(self, table: Mapping[str, Any], key: str, name: str) -> float:
        """Read a number in the table's unit and return it in SI."""
        where, kind = f"[{name}] {key}", QUANTITIES[name]
        if key not in table:
            remedy = (
                "measure, cite or judge one"
                if key == "value"
                else "give the range to sample, low and high about the value"
            )
            raise self.error(f"[{name}]", f"{key} = a number", "no such key", remedy)
        unit = self.choice(table, "unit", kind.units, f"[{name}]")
        value = table[key]
        if finite.broken_by(value):
            remedy = f"write a number in {unit}, without quotes"
            raise self.error(where, positive.words, printable(value), remedy)
        converted = float(value) / kind.units[unit]
        if expected := kind.rule.broken_by(converted):
            found = f"{value} {unit}" if unit != kind.unit else printable(value)
            raise self.error(where, expected, found, f"correct it; the unit is {unit}")
        return converted

    def sample(self, table: Mapping[str, Any], where: str) -> int | None:
        value = table.get("sample")
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or value < 1):
            raise self.error(
                f"{where} sample",
                "a whole number of birds or tracks",
                printable(value),
                "correct or delete it",
            )
        return value

    def choice(self, table: Mapping[str, Any], key: str, choices: Iterable[str], where: str) -> str:
        value, quoted = table.get(key), " or ".join(f'"{choice}"' for choice in choices)
        if not isinstance(value, str) or value not in choices:
            found = printable(value) if key in table else "no such key"
            raise self.error(f"{where} {key}", quoted, found, "write one of these")
        return value

    def rule(self, name: str, table: Mapping[str, Any], known: Mapping[str, Quantity]) -> Quantity | None:
        """What the rule that a table names gives for this bird; None if it needs what is wrong itself."""
        where = f"[{name}] rule"
        kind = QUANTITIES[name]
        if not kind.rules:
            raise self.error(
                where, "no rule for this quantity", printable(table["rule"]), "state a value instead"
            )
        rule_name = self.choice(table, "rule", kind.rules, f"[{name}]")
        if rule_name == AS_IBIS:
            ibis = self.ibis()[name]
            return Quantity(
                ibis.value, ibis.unit, ibis.low, ibis.high, "assumed", "the northern bald ibis's", AS_IBIS
            )
        rule = RULES[rule_name]
        missing = [need for need in rule.needs if need not in known]
        if any(need in self.tables or not QUANTITIES[need].optional for need in missing):
            return None
        if missing:
            raise self.error(
                where,
                f"[{missing[0]}] to compute from",
                "none",
                f"add [{missing[0]}], or state a value instead",
            )
        value = rule.formula(*(known[need].value for need in rule.needs))
        low, high = value * (1.0 - rule.spread), value * (1.0 + rule.spread)
        for end in (low, high):
            if expected := kind.rule.broken_by(end):
                found = f"{value:.4g} ±{rule.spread:.0%}"
                raise self.error(where, expected, found, "state a value and its range instead")
        return Quantity(value, kind.unit, low, high, "computed", f"{rule.source}: {rule.words}", rule_name)

    def formation(self, content: Mapping[str, Any]) -> Formation | None:
        if "formation" not in content:
            return None
        table, where = self.table(content, "formation"), "[formation]"
        self.refuse_unknown(table, FORMATION_KEYS, where)
        return Formation(
            shape=self.choice(table, "shape", FORMATION_SHAPES, where),
            basis=self.choice(table, "basis", BASES, where),
            source=self.text(table, "source", where),
            note=self.text(table, "note", where, optional=True),
        )
