"""One job: what is to be solved and how, as values; and the id that follows from its inputs and nothing else.

In a Parquet file a job is flat, one column an input: `Job.inputs` and `Job.of` are the border between the two.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.checked import REACH, WrongInput, one_of
from upwash.aero.wake import WakeModel
from upwash.optimum.settings import BIRDS, FlockRules, SearchSettings

MODEL_VERSION = 2
"""Raised by hand when a change of the code changes results: every job then gets a new id."""

BUILT_IN_SOLVER = "upwash"
"""The solver that every sweep uses unless it names another as ``package.module:function``."""

INPUTS = of.names(of.belonging(of.PROBLEM, of.SEARCH, of.FLOCK))
"""Columns that a job is made of."""

KINDS = ("pair", "flock")

ID_BYTES = 8

# Where a bird's fields are named otherwise in a file: there they tell the lone bird from the follower.
LEADERS = {"amplitude_m": "leader_amplitude_m", "upstroke_span_ratio": "leader_upstroke_span_ratio"}
BIRD_COLUMNS = {entry.name: LEADERS.get(entry.name, entry.name) for entry in fields(Bird)}

_FLOATS = frozenset(column.name for column in of.COLUMNS if column.type == of.FLOAT and not column.words)
_PAPER = WakeModel()

# Inputs that came later: a job states what of them differs from the paper's, so that no old id changes.
_LATER = {name: getattr(_PAPER, name) for name in ("stroke_rule", "core", "span_law")}
_LATER_OF_PAIRS = _LATER | {"wavelengths": _PAPER.wavelengths}

Cell = float | int | str | None


@dataclass(frozen=True, slots=True)
class NoBird:
    """Inputs that make no bird, which is a result and for the job to report.

    Parameters
    ----------
    inputs : tuple of float
        The fields of `upwash.aero.bird.Bird`, in order.
    why : str
        What is wrong with them.
    """

    inputs: tuple[float, ...]
    why: str


def bird_of(inputs: Mapping[str, float]) -> Bird | NoBird:
    """Return the bird of its fields, or that they make none.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> bird_of(vars(ibis)) == ibis
    True
    >>> bird_of(vars(ibis) | {"amplitude_m": 3.0}).why
    'amplitude_m: expected at most twice the semispan (1.2 m, a half-angle of 90°), found 3.0'
    """
    try:
        return Bird(**inputs)
    except ValueError as error:
        return NoBird(tuple(inputs[name] for name in BIRD_COLUMNS), str(error))


def wavelength_ratio(bird: Bird | NoBird) -> float:
    """Return the wavelength of a bird's wake over its semispan, whether it is a bird or not."""
    if isinstance(bird, Bird):
        return bird.wavelength_m / bird.semispan_m
    inputs = dict(zip(BIRD_COLUMNS, bird.inputs, strict=True))
    return inputs["speed_m_s"] * inputs["period_s"] / inputs["semispan_m"]


@dataclass(frozen=True)
class Flock:
    """A flock that is to be built.

    Parameters
    ----------
    birds : int
        How many birds, the first one included.
    rules : FlockRules
        How it is built.
    """

    birds: int
    rules: FlockRules = FlockRules()

    def __post_init__(self) -> None:
        BIRDS("birds", self.birds)


@dataclass(frozen=True)
class Job:
    """One problem to solve, and how.

    Parameters
    ----------
    species : str
        Name of the species file, without ``.toml``.
    objective : str
        Name of the cost function.
    amplitude_convention : str
        How the leader's amplitude was chosen: a convention of the species library, or ``given``.
    bird : Bird or NoBird
        The bird: in a pair the leader, in a flock the first; or inputs that make none.
    model : WakeModel
        How the wakes are resolved.
    search : SearchSettings
        Seed and tolerance of the search; the rest is as usual.
    flock : Flock or None
        The flock, or None for a pair.
    solver : str
        `BUILT_IN_SOLVER`, or ``package.module:function``.
    distance_m : float or None
        How far behind the one ahead a follower is said to fly where the wake is endless; half a wavelength if None.

    Raises
    ------
    ValueError
        If the search is limited otherwise than by seed and tolerance, which no column tells; or a distance is asked
        for behind a wake that ends.
    """

    species: str
    objective: str
    amplitude_convention: str
    bird: Bird | NoBird
    model: WakeModel = _PAPER
    search: SearchSettings = SearchSettings()
    flock: Flock | None = None
    solver: str = BUILT_IN_SOLVER
    distance_m: float | None = None
    job_id: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        if self.search != SearchSettings(self.search.seed, self.search.tolerance):
            raise ValueError(
                f"search: expected a job's search to differ in seed and tolerance, found {self.search}"
            )
        if self.distance_m is not None:
            object.__setattr__(self, "distance_m", REACH("distance_m", self.distance_m))
            if not self.model.is_endless:
                found = "as behind a wake that ends the distance is found"
                raise WrongInput("distance_m", f"none, {found}", self.distance_m)
        object.__setattr__(self, "job_id", job_id(self.inputs()))

    @property
    def kind(self) -> str:
        """``pair`` or ``flock``."""
        return "flock" if self.flock else "pair"

    def inputs(self) -> dict[str, Cell]:
        """Return the inputs by column, as JSON has them; what does not apply is None."""
        bird = self.bird
        values = (
            bird.inputs if isinstance(bird, NoBird) else tuple(getattr(bird, name) for name in BIRD_COLUMNS)
        )
        flock = self.flock
        found: dict[str, Any] = dict(zip(BIRD_COLUMNS.values(), values, strict=True))
        found |= {
            "kind": self.kind,
            "species": self.species,
            "objective": self.objective,
            "amplitude_convention": self.amplitude_convention,
            "seed": self.search.seed,
            "tolerance": self.search.tolerance,
            "solver": self.solver,
            "birds": flock.birds if flock else None,
            "shape": flock.rules.shape if flock else None,
            "wake": flock.rules.wake if flock else None,
            "reading": flock.rules.reading if flock else None,
            "distance_m": self.distance_m,
        }
        found |= of.told(vars(self.model)) | {"model": self.model.name(wavelength_ratio(bird))}
        return {name: found[name] for name in INPUTS}

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> Job:
        """Return the job whose inputs a row holds by column, as in Parquet or as in JSON; what is absent is as usual.

        Raises
        ------
        ValueError
            If an input is out of range.
        """
        given = of.told({name: row[name] for name in INPUTS if name in row})
        given = {name: value for name, value in given.items() if value is not None}
        if given.get("wavelengths") == "endless":
            given["wavelengths"] = math.inf
        kind = one_of(KINDS)("kind", given["kind"])

        def some(*names: str) -> dict[str, Any]:
            return {name: given[name] for name in names if name in given}

        return cls(
            **some("species", "objective", "amplitude_convention", "solver", "distance_m"),
            bird=bird_of({name: given[column] for name, column in BIRD_COLUMNS.items()}),
            model=WakeModel(**some(*(entry.name for entry in fields(WakeModel)))),
            search=SearchSettings(**some("seed", "tolerance")),
            flock=Flock(given["birds"], FlockRules(**some("shape", "wake", "reading")))
            if kind == "flock"
            else None,
        )


def canonical_text(inputs: Mapping[str, Any], model_version: int = MODEL_VERSION) -> str:
    """Write a job's inputs in the one way that its identity is taken from.

    One ``name=value`` a line, sorted by name; numbers by their shortest exact text, so that 1 and 1.0, or
    0.0 and -0.0, are the same; inputs that do not apply (None), and those that came later and are the paper's, are
    left out, so that a new kind of input changes no id. A model's name follows from its parts.
    """
    lines = [f"model_version={model_version}"]
    usual = _LATER_OF_PAIRS if inputs.get("kind") == "pair" else _LATER
    for name, value in inputs.items():
        if value is not None and name != "model" and usual.get(name) != value:
            lines.append(f"{name}={repr(float(value) + 0.0) if name in _FLOATS else json.dumps(value)}")
    return "\n".join(sorted(lines))


def job_id(inputs: Mapping[str, Any], model_version: int = MODEL_VERSION) -> str:
    """Return the id of the job with these inputs: 16 hexadecimal digits."""
    text = canonical_text(inputs, model_version)
    return hashlib.blake2b(text.encode(), digest_size=ID_BYTES).hexdigest()
