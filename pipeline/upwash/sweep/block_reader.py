"""Reading one block of a sweep file: what it varies, and its jobs as they are checked."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from upwash.aero.checked import Rule, finite, whole_from
from upwash.aero.power import COST_FUNCTIONS
from upwash.errors import UpwashError
from upwash.jobs.job import Job
from upwash.jobs.kind import Kind
from upwash.jobs.kinds import KINDS
from upwash.jobs.pair import Pair
from upwash.species import AMPLITUDE_CONVENTIONS, Species, load_library, load_species
from upwash.species.file import did_you_mean
from upwash.sweep.block import Axis, Block, Condition, Sample
from upwash.sweep.choices import (
    CHOICES,
    LEADER,
    MEMBERS,
    MODEL,
    NOT_TOLD,
    PARAMETERS,
    PHASE_LOCK,
    SPEED,
    SPEED_OF,
    UNSCALED,
    WORDED,
    rule_of,
)
from upwash.sweep.entry import Entry
from upwash.sweep.speeds import CHOSEN, SPEEDS
from upwash.sweep.values import MAX_POINTS, SAMPLERS, Setting, is_number, sampling_range, settings

DEFAULTS: dict[str, Any] = {"objective": "force", "amplitude": "stroke-angle", "seed": 0, "tolerance": 1e-4}
SAMPLE_KEYS = ("method", "count", "seed", "within", "parameters", "ranges")
TEXT_INPUTS = ("species", LEADER, "objective", "amplitude")
MAX_JOBS = 1_000_000
SAMPLES = whole_from(1, MAX_POINTS, "a sweep has no more jobs")


def block_keys() -> tuple[str, ...]:
    """Return the keys of a block; some kinds of jobs have a table of their own."""
    of_kinds = (kind.name for kind in KINDS.values() if kind.choices)
    return (
        "species",
        *DEFAULTS,
        LEADER,
        SPEED_OF,
        PHASE_LOCK,
        SPEED,
        MODEL,
        "fixed",
        "grid",
        "zip",
        "sample",
        "exclude",
        *of_kinds,
    )


@dataclass(frozen=True)
class _Varied:
    """A parameter, where it stands, and its values."""

    entry: Entry
    settings: list[Setting]

    @property
    def name(self) -> str:
        return str(self.entry.path[-1])


class BlockReader:
    """Makes the jobs of one block after another; species are loaded once."""

    def __init__(self, folder: Path, kind: type[Kind], solver: str) -> None:
        self.folder = folder
        self.kind = kind
        self.solver = solver
        self.loaded: dict[str, Species] = {}

    def block(self, table: Entry, shared: dict[str, Entry]) -> tuple[Block, Iterator[Job]]:
        """Return a block, and its jobs as they are checked; what it leaves out is taken from the top of the file."""
        own = table.table(known := block_keys())
        keys = {key: entry for key, entry in shared.items() if key in known} | own
        # A key of the block replaces the file's; only the fixed values add up.
        fixed = {
            one.name: one for place in (shared, own) for one in _varied(place.get("fixed"), only_one=True)
        }
        axes = [*map(_zip, _tables(keys.get("zip"))), *([one] for one in _varied(keys.get("grid")))]
        axes += [[_Varied(one, _checked_settings(name, one, False))] for name, one in self.named(keys)]
        sample = _sample(keys["sample"]) if "sample" in keys else None
        _refuse_repeated([*fixed.values(), *(one for axis in axes for one in axis)], sample, keys)
        block = Block(
            kind=self.kind,
            solver=self.solver,
            species=self.first_birds(table, keys),
            choices=self.choices(table, keys),
            fixed={name: one.settings[0] for name, one in fixed.items()},
            axes=[_points(axis) for axis in axes],
            sample=sample,
            exclusions=[self.exclusion(entry) for entry in _tables(keys.get("exclude"))],
        )
        if sample and sample.parameters:
            _check_own_ranges(block, keys["sample"])
        if block.size() > MAX_JOBS:
            raise table.error(f"expected at most {MAX_JOBS} jobs, found {block.size()}; shorten the lists")
        places = [one.entry for one in (*fixed.values(), *(one for axis in axes for one in axis))]
        return block, _checked_jobs(block, table, keys, places)

    def species(self, table: Entry, keys: dict[str, Entry]) -> list[Species]:
        """Return the birds."""
        if "species" not in keys:
            raise table.error('expected species = "a-name", a list of names or "all", found none; add it')
        if keys["species"].value == "all":
            return load_library()
        return [self.load(entry) for entry in keys["species"].each()]

    def first_birds(self, table: Entry, keys: dict[str, Entry]) -> list[Species]:
        """Return the birds that jobs are of: the species, or the first member of a flock."""
        members = self.own_table(keys).get(MEMBERS)
        if members is None:
            return self.species(table, keys)
        if "species" in keys:
            raise members.error("expected either species or the members of a flock, found both; delete one")
        return [self.load(members.each()[0])]

    def companions(self, keys: dict[str, Entry]) -> dict[str, list[Any]]:
        """Return what says which birds fly together, by its key."""
        choices: dict[str, list[Any]] = {}
        if PHASE_LOCK in keys:
            choices[PHASE_LOCK] = [entry.truth() for entry in keys[PHASE_LOCK].each()]
        of_a_pair = [name for name in (LEADER, SPEED_OF) if name in keys]
        if of_a_pair and self.kind.name != Pair.name:
            raise keys[of_a_pair[0]].error(
                "expected no such key in a sweep of flocks, whose birds are told by [flock] members; delete it"
            )
        if SPEED_OF in keys and LEADER not in keys:
            raise keys[SPEED_OF].error("expected a leader beside it, whose speed may differ; add leader =")
        if LEADER in keys:
            entry = keys[LEADER]
            choices[LEADER] = (
                load_library() if entry.value == "all" else [self.load(one) for one in entry.each()]
            )
        if SPEED_OF in keys:
            choices[SPEED_OF] = [entry.one_of(SPEEDS) for entry in keys[SPEED_OF].each()]
        return choices

    def load(self, entry: Entry) -> Species:
        """Load one species; a path is taken from the sweep file's own folder."""
        name = entry.text()
        if name not in self.loaded:
            try:
                self.loaded[name] = load_species(self.folder / name if name.endswith(".toml") else name)
            except UpwashError as error:
                raise entry.error(str(error)) from error
        return self.loaded[name]

    def choices(self, table: Entry, keys: dict[str, Entry]) -> dict[str, list[Any]]:
        """Return the values of every input of a job that is not a parameter."""
        given = {key: keys.get(key, table.at(default)).each() for key, default in DEFAULTS.items()}
        choices: dict[str, list[Any]] = {
            "objective": [entry.one_of(COST_FUNCTIONS) for entry in given["objective"]],
            "amplitude": [entry.one_of(AMPLITUDE_CONVENTIONS) for entry in given["amplitude"]],
            **{name: [entry.by(CHOICES[name]) for entry in given[name]] for name in ("seed", "tolerance")},
        }
        for other in KINDS.keys() & keys.keys() - {self.kind.name}:
            message = (
                f'expected no such table in a sweep of {self.kind.name}s; write kind = "{other}" at the top'
            )
            raise keys[other].error(message)
        choices |= self.companions(keys)
        if SPEED in keys:
            choices[SPEED] = [entry.one_of(CHOSEN) for entry in keys[SPEED].each()]
        own = self.own_table(keys)
        if MEMBERS in own:
            choices[MEMBERS] = [[self.load(one) for one in own[MEMBERS].each()[1:]]]
            if not choices[MEMBERS][0]:
                raise own[MEMBERS].unexpected("the names of two birds or more, the first one's first")
            if "birds" in own:
                raise own["birds"].error("expected no number beside the members, which tell it; delete it")
        for key, usual in self.kind.usual.items():
            rule = self.kind.choices[key]
            choices[key] = [
                entry.by(rule) if isinstance(rule, Rule) else entry.one_of(rule)
                for entry in own.get(key, table.at(usual)).each()
            ]
        return choices

    def own_table(self, keys: dict[str, Entry]) -> dict[str, Entry]:
        """Return what the table of the sweep's kind holds, if there is one."""
        kind = self.kind
        known = (*kind.choices, *kind.companions, *kind.parts)
        return keys[kind.name].table(known) if kind.name in keys else {}

    def named(self, keys: dict[str, Entry]) -> Iterator[tuple[str, Entry]]:
        """Give the parameters that have a key elsewhere than in the tables of parameters: of the wake's model."""
        if MODEL in keys:
            yield MODEL, keys[MODEL]
        own = self.own_table(keys)
        yield from ((name, own[name]) for name in self.kind.parts if name in own)

    def exclusion(self, entry: Entry) -> dict[str, Condition]:
        """Return the conditions that a job must all meet to be left out."""
        told = (name for name in PARAMETERS if name not in NOT_TOLD)
        leader = [LEADER] if self.kind.name == Pair.name else []
        names = ("species", *DEFAULTS, *leader, *self.kind.choices, *told)
        words = [name for name, rule in self.kind.choices.items() if not isinstance(rule, Rule)]
        texts = {*TEXT_INPUTS, *WORDED, *words}
        conditions = {name: _condition(below, name in texts) for name, below in entry.table(names).items()}
        if not conditions:
            raise entry.error("expected at least one condition, found none; write parameter = value")
        return conditions


def _tables(entry: Entry | None) -> list[Entry]:
    return entry.tables() if entry else []


def _varied(entry: Entry | None, only_one: bool = False) -> list[_Varied]:
    """Read a table of parameters and check each value on its own."""
    return [
        _Varied(below, _checked_settings(name, below, only_one))
        for name, below in (entry.table(PARAMETERS) if entry else {}).items()
    ]


def _checked_settings(name: str, entry: Entry, only_one: bool) -> list[Setting]:
    try:
        values = settings(entry.value, only_one, name in WORDED)
    except ValueError as error:
        raise entry.error(str(error)) from error
    for setting in values:
        if name in UNSCALED and setting.relative:
            raise entry.unexpected(
                "values, as there is nothing that factors could be of", "leave out relative"
            )
        if expected := rule_of(name, setting.relative).broken_by(setting.value):
            raise entry.error(f"expected {expected}, found {setting.value!r}; correct it")
    return values


def _zip(entry: Entry) -> list[_Varied]:
    """Read lists that are taken side by side."""
    axis = _varied(entry)
    if len({len(one.settings) for one in axis}) != 1:
        found = ", ".join(f"{one.name} {len(one.settings)}" for one in axis) or "no list"
        raise entry.error(f"expected lists of equal length, found {found}; even them out")
    return axis


def _points(axis: list[_Varied]) -> Axis:
    names = tuple(one.name for one in axis)
    return Axis(names, list(zip(*(one.settings for one in axis), strict=True)))


def _sample(entry: Entry) -> Sample:
    keys = entry.table(SAMPLE_KEYS)
    for needed in ("method", "count"):
        if needed not in keys:
            raise entry.error(f"expected the key {needed}, found none; add it")
    method, count = keys["method"].one_of(SAMPLERS), keys["count"].by(SAMPLES)
    seed = keys["seed"].by(CHOICES["seed"]) if "seed" in keys else 0
    if method != "latin-hypercube" and count & (count - 1):
        nearest = 1 << count.bit_length()
        raise keys["count"].unexpected(f"a power of two for {method}", f"take {nearest // 2} or {nearest}")
    if ("ranges" in keys) == ("within" in keys):
        raise entry.error('expected either within = "species" or [sample.ranges]; write one of them')
    if "within" in keys:
        keys["within"].one_of(["species"])
        named = keys["parameters"].each() if "parameters" in keys else []
        return Sample(method, count, seed, None, tuple(one.one_of(PARAMETERS) for one in named))
    if "parameters" in keys:
        raise keys["parameters"].error("expected no such key beside ranges, which name them; delete it")
    ranges = {}
    for name, below in keys["ranges"].table([name for name in PARAMETERS if name not in UNSCALED]).items():
        try:
            ranges[name] = low, high, relative = sampling_range(below.value)
        except ValueError as error:
            raise below.error(str(error)) from error
        for end in (low, high):
            if expected := rule_of(name, relative).broken_by(end):
                raise below.error(f"expected {expected}, found {end!r}; correct it")
    if not ranges:
        raise keys["ranges"].error("expected at least one range, found none; write parameter = [low, high]")
    return Sample(method, count, seed, ranges)


def _check_own_ranges(block: Block, entry: Entry) -> None:
    """Complain about a parameter that a species has no range for."""
    assert block.sample is not None
    for species in block.species:
        for convention in block.choices["amplitude"]:
            known = species.ranges(convention)
            for name in block.sample.parameters:
                if name not in known:
                    expected = f"parameters with a range of {species.slug}'s own under {convention!r}"
                    below = entry.at(name, "parameters")
                    raise below.unexpected(expected, did_you_mean(name, known))


def _refuse_repeated(varied: list[_Varied], sample: Sample | None, keys: dict[str, Entry]) -> None:
    """Complain about a parameter that is set in two places of one block."""
    sampled = (sample.ranges or sample.parameters) if sample else ()
    seen = dict.fromkeys(sampled, "sample")
    for one in varied:
        if one.name in seen:
            raise one.entry.error(
                f"expected each parameter once, found it in {seen[one.name]} too; delete one"
            )
        seen[one.name] = str(("the keys of the file", *one.entry.path)[-2])


def _condition(entry: Entry, is_text: bool) -> Condition:
    value = entry.value
    if isinstance(value, dict) and not is_text:
        bounds: dict[str, Any] = {
            key: below.by(finite) for key, below in entry.table(("above", "below")).items()
        }
        if bounds:
            return Condition(**bounds)
    elif all(isinstance(one.value, str) if is_text else is_number(one.value) for one in entry.each()):
        return Condition(values=tuple(one.value for one in entry.each()))
    numbers = "a number, a list of them or { above = a, below = b }"
    raise entry.unexpected("a name or a list of names" if is_text else numbers)


def _checked_jobs(block: Block, table: Entry, keys: dict[str, Entry], places: list[Entry]) -> Iterator[Job]:
    """Make a block's jobs; a value that makes no bird is blamed on its line."""
    used = set()
    try:
        for job, exclusion in block.jobs():
            used.add(exclusion)
            if exclusion is None:
                yield job
    except UpwashError as error:
        named = [place for place in places if place.path[-1] == error.field]
        where = named[0] if named else keys["sample"] if block.sample else table
        raise where.error(str(error)) from error
    for number, entry in enumerate(_tables(keys.get("exclude"))):
        if number not in used:
            raise entry.error("expected to exclude some job, found none that fits; correct or delete it")
    if None not in used:
        raise keys["exclude"].error("expected to leave some job, found all excluded; loosen the conditions")
