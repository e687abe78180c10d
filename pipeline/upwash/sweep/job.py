"""One job: what is to be solved and how, as values; and the id that follows from its inputs and nothing else.

In a Parquet file a job is flat, one column an input: `Job.inputs` and `Job.of` are the border between the two.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.checked import one_of
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

_FLOATS = frozenset(column.name for column in of.COLUMNS if column.type == of.FLOAT)
_PAPER = WakeModel()

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
        Resolution and length of the wakes.
    search : SearchSettings
        Seed and tolerance of the search; the rest is as usual.
    flock : Flock or None
        The flock, or None for a pair.
    solver : str
        `BUILT_IN_SOLVER`, or ``package.module:function``.

    Raises
    ------
    ValueError
        If the search is limited otherwise than by seed and tolerance, which no column tells.
    """

    species: str
    objective: str
    amplitude_convention: str
    bird: Bird | NoBird
    model: WakeModel = _PAPER
    search: SearchSettings = SearchSettings()
    flock: Flock | None = None
    solver: str = BUILT_IN_SOLVER
    job_id: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        if self.search != SearchSettings(self.search.seed, self.search.tolerance):
            raise ValueError(
                f"search: expected a job's search to differ in seed and tolerance, found {self.search}"
            )
        object.__setattr__(self, "job_id", job_id(self.inputs()))

    @property
    def kind(self) -> str:
        """``pair`` or ``flock``."""
        return "flock" if self.flock else "pair"

    def inputs(self) -> dict[str, Cell]:
        """Return the inputs by column; what does not apply to a pair is None."""
        bird = self.bird
        values = (
            bird.inputs if isinstance(bird, NoBird) else tuple(getattr(bird, name) for name in BIRD_COLUMNS)
        )
        flock, model = self.flock, self.model
        found: dict[str, Cell] = dict(zip(BIRD_COLUMNS.values(), values, strict=True))
        found |= {
            "kind": self.kind,
            "species": self.species,
            "objective": self.objective,
            "amplitude_convention": self.amplitude_convention,
            "core_radius_ratio": model.core_radius_ratio,
            "stroke_states": model.stroke_states,
            "span_nodes": model.span_nodes,
            "seed": self.search.seed,
            "tolerance": self.search.tolerance,
            "solver": self.solver,
            "birds": flock.birds if flock else None,
            "shape": flock.rules.shape if flock else None,
            "wake": flock.rules.wake if flock else None,
            "reading": flock.rules.reading if flock else None,
            "wavelengths": model.wavelengths if flock or model.wavelengths != _PAPER.wavelengths else None,
        }
        # Of what the wake's model was given later, a job states what differs from the paper's: no old id changes.
        usual = {name: getattr(_PAPER, name) for name in vars(model) if name not in found}
        later = {name: getattr(model, name) for name, value in usual.items() if getattr(model, name) != value}
        return {name: found[name] for name in INPUTS} | later

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> Job:
        """Return the job whose inputs a row holds by column; what is absent or None is as usual.

        Raises
        ------
        ValueError
            If an input is out of range.
        """
        given = {name: row[name] for name in INPUTS if row.get(name) is not None}

        kind = one_of(KINDS)("kind", given["kind"])

        def some(*names: str) -> dict[str, Any]:
            return {name: given[name] for name in names if name in given}

        return cls(
            **some("species", "objective", "amplitude_convention", "solver"),
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
    0.0 and -0.0, are the same; inputs that do not apply (None) are left out, so that a new kind of input
    changes no id.
    """
    lines = [f"model_version={model_version}"]
    for name, value in inputs.items():
        if value is not None:
            lines.append(f"{name}={repr(float(value) + 0.0) if name in _FLOATS else json.dumps(value)}")
    return "\n".join(sorted(lines))


def job_id(inputs: Mapping[str, Any], model_version: int = MODEL_VERSION) -> str:
    """Return the id of the job with these inputs: 16 hexadecimal digits."""
    text = canonical_text(inputs, model_version)
    return hashlib.blake2b(text.encode(), digest_size=ID_BYTES).hexdigest()
