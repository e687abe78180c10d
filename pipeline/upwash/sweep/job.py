"""One job: every input that its result depends on, and the id that follows from them and nothing else."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field, fields
from typing import Any

MODEL_VERSION = 2
"""Raised by hand when a change of the code changes results: every job then gets a new id."""

BUILT_IN_SOLVER = "upwash"
"""The solver that every sweep uses unless it names another as ``package.module:function``."""

FLOCK_CHOICES = {
    "shape": ("echelon", "vee", "alternating"),
    "wake": ("neighbour", "all-upstream"),
    "reading": ("immediate", "lone"),
}
"""What a flock's shape, wake and reading of the amplitude bound may be."""

ID_BYTES = 8


@dataclass(frozen=True, slots=True)
class Job:
    """One problem to solve: a bird, a cost, and how the solver is set.

    Every field but the id is an input column of the job's rows, and part of its identity.

    Parameters
    ----------
    kind : str
        ``pair``: one bird behind another; ``flock``: a chain of them.
    species : str
        Name of the species file, without ``.toml``.
    objective : str
        Name of the cost function.
    amplitude_convention : str
        How the leader's amplitude was chosen: a convention of the species library, or ``given``.
    mass_kg, semispan_m, speed_m_s, period_s, density_kg_m3, gravity_m_s2, circulation_ratio : float
        The bird and its air, as for `upwash.aero.bird.Bird`.
    leader_amplitude_m, leader_upstroke_span_ratio : float
        The leader's stroke.
    core_radius_ratio, stroke_states, span_nodes : float, int, int
        Resolution of the wake, as for `upwash.aero.wake.WakeModel`.
    seed : int
        Seed of the search.
    tolerance : float
        Relative gap to which the optimum is to be proved.
    solver : str
        `BUILT_IN_SOLVER`, or ``package.module:function``.
    birds : int, optional
        Birds in the flock. This and the next four are set for flocks alone.
    shape, wake, reading : str, optional
        Shape of the flock, which wakes a bird feels, and the reading of its amplitude bound.
    wavelengths : int, optional
        Length of each wake.
    """

    kind: str
    species: str
    objective: str
    amplitude_convention: str
    mass_kg: float
    semispan_m: float
    speed_m_s: float
    period_s: float
    density_kg_m3: float
    gravity_m_s2: float
    leader_amplitude_m: float
    leader_upstroke_span_ratio: float
    circulation_ratio: float
    core_radius_ratio: float
    stroke_states: int
    span_nodes: int
    seed: int
    tolerance: float
    solver: str = BUILT_IN_SOLVER
    birds: int | None = None
    shape: str | None = None
    wake: str | None = None
    reading: str | None = None
    wavelengths: int | None = None
    job_id: str = field(init=False, compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "job_id", job_id(self.inputs()))

    def inputs(self) -> dict[str, Any]:
        """Return the inputs by column name."""
        return {name: getattr(self, name) for name in INPUTS}


INPUTS = tuple(entry.name for entry in fields(Job) if entry.init)
_FLOATS = frozenset(entry.name for entry in fields(Job) if entry.type == "float")


def canonical_text(inputs: dict[str, Any], model_version: int = MODEL_VERSION) -> str:
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


def job_id(inputs: dict[str, Any], model_version: int = MODEL_VERSION) -> str:
    """Return the id of the job with these inputs: 16 hexadecimal digits."""
    text = canonical_text(inputs, model_version)
    return hashlib.blake2b(text.encode(), digest_size=ID_BYTES).hexdigest()
