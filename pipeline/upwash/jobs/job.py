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
from upwash.columns import Cell, Row, Stored
from upwash.errors import UpwashError
from upwash.jobs.bird import BIRD_COLUMNS, NoBird, bird_of, inputs_of
from upwash.jobs.jitter import RULE, SIGMA, need_alike
from upwash.jobs.kind import Kind
from upwash.jobs.kinds import KINDS
from upwash.jobs.pair import Pair
from upwash.optimum.endless.problem import DISTANCE
from upwash.optimum.settings import SearchSettings
from upwash.optimum.spacing import FREE, Spacing

MODEL_VERSION = 2
"""Raised by hand when a change of the code changes results: every job then gets a new id."""

BUILT_IN_SOLVER = "upwash"
"""The solver that every sweep uses unless it names another as ``package.module:function``."""

INPUTS = of.names(of.belonging(of.PROBLEM, of.SEARCH, of.FLOCK, of.AHEAD, of.AHEAD_STROKE))
"""Columns that a job is made of."""

ID_BYTES = 8

_FLOATS = frozenset(column.name for column in of.COLUMNS if column.type == of.FLOAT and not column.words)
_PAPER = WakeModel()

# Inputs that came later: a job states what of them differs from the paper's, so that no old id changes.
_LATER = {name: getattr(_PAPER, name) for name in ("stroke_rule", "core", "span_law")} | {"phase_lock": True}


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
        The bird: in a pair the follower, in a flock the first; or inputs that make none.
    model : WakeModel
        How the wakes are resolved.
    search : SearchSettings
        Seed and tolerance of the search; the rest is as usual.
    kind : Kind
        What is asked for, with the inputs of its own: a pair, or a flock.
    solver : str
        `BUILT_IN_SOLVER`, or ``package.module:function``.
    distance_m : float or None
        How far behind the one ahead a follower is said to fly where the wake is endless; half a wavelength if None.
    spacing : Spacing
        What a follower keeps to.
    position_sigma_ratio : float or None
        By how much a place is to jitter, in semispans; not at all if None.

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
    kind: Kind = Pair()
    solver: str = BUILT_IN_SOLVER
    distance_m: float | None = None
    spacing: Spacing = FREE
    position_sigma_ratio: float | None = None
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
        if isinstance(self.bird, Bird) and self.spacing.names:
            ahead = self.kind.ahead_of(self.bird)
            asked = (self.distance_m or DISTANCE * ahead.wavelength_m) if self.model.is_endless else None
            self.spacing.need_room(self.bird.semispan_m, ahead.wavelength_m, asked, ahead.semispan_m)
        if self.position_sigma_ratio is not None:
            object.__setattr__(self, SIGMA, RULE(SIGMA, self.position_sigma_ratio))
        need_alike(self)
        object.__setattr__(self, "job_id", job_id(self.inputs()))

    def inputs(self) -> Row:
        """Return the inputs by column, as JSON has them; what does not apply is None."""
        found: Row = {
            **dict.fromkeys(INPUTS),
            **inputs_of(self.bird),
            "kind": self.kind.name,
            **self.kind.inputs(),
            "species": self.species,
            "objective": self.objective,
            "amplitude_convention": self.amplitude_convention,
            "seed": self.search.seed,
            "tolerance": self.search.tolerance,
            "solver": self.solver,
            "distance_m": self.distance_m,
            **vars(self.spacing),
            SIGMA: self.position_sigma_ratio,
        }
        found |= of.told(vars(self.model)) | {"model": self.model.name(self.kind.wavelength_ratio(self.bird))}
        return {name: found[name] for name in INPUTS}

    @classmethod
    def of(cls, row: Stored) -> Job:
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
        kind = KINDS[one_of(tuple(KINDS))("kind", given["kind"])]

        def some(*names: str) -> dict[str, Any]:
            return {name: given[name] for name in names if name in given}

        return cls(
            **some("species", "objective", "amplitude_convention", "solver", "distance_m", SIGMA),
            bird=bird_of({name: given[column] for name, column in BIRD_COLUMNS.items()}),
            model=WakeModel(**some(*(entry.name for entry in fields(WakeModel)))),
            search=SearchSettings(**some("seed", "tolerance")),
            kind=kind.from_inputs(given),
            spacing=Spacing(**some(*(entry.name for entry in fields(Spacing)))),
        )


def canonical_text(inputs: Mapping[str, Cell], model_version: int = MODEL_VERSION) -> str:
    """Write a job's inputs in the one way that its identity is taken from.

    One ``name=value`` a line, sorted by name; numbers by their shortest exact text, so that 1 and 1.0, or
    0.0 and -0.0, are the same; inputs that do not apply (None), and those that came later and are the paper's, are
    left out, so that a new sort of input changes no id. A model's name follows from its parts.
    """
    lines = [f"model_version={model_version}"]
    usual = _LATER | KINDS[str(inputs["kind"])].later
    for name, value in inputs.items():
        if value is not None and name != "model" and usual.get(name) != value:
            lines.append(f"{name}={repr(float(value) + 0.0) if name in _FLOATS else json.dumps(value)}")
    return "\n".join(sorted(lines))


def job_id(inputs: Mapping[str, Cell], model_version: int = MODEL_VERSION) -> str:
    """Return the id of the job with these inputs: 16 hexadecimal digits."""
    text = canonical_text(inputs, model_version)
    return hashlib.blake2b(text.encode(), digest_size=ID_BYTES).hexdigest()


def job_of(row: Stored) -> Job:
    """Return the job that a stored row came from, made of its inputs alone.

    Raises
    ------
    UpwashError
        If they are no inputs of a job.
    """
    try:
        return Job.of(row)
    except (ValueError, KeyError, TypeError) as error:
        found = " ".join(str(error).split())
        raise UpwashError(
            f"job {row.get('job_id')}: expected a job's inputs, found {found}; run it again"
        ) from error
