"""The inputs of a job's bird, which may make none."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

from upwash.aero.bird import Bird
from upwash.aero.together import SHARED

# Where a bird's fields are named otherwise in a file: there they tell the lone bird from the follower.
LEADERS = {"amplitude_m": "leader_amplitude_m", "upstroke_span_ratio": "leader_upstroke_span_ratio"}
BIRD_COLUMNS = {entry.name: LEADERS.get(entry.name, entry.name) for entry in fields(Bird)}
"""Field of a bird -> the column that holds it."""


AHEAD = {name: f"ahead_{name}" for name in BIRD_COLUMNS if name not in SHARED}
"""Field of the bird ahead in a pair -> the column that holds it; what the two share is not told twice."""


@dataclass(frozen=True, slots=True)
class Companion:
    """Another bird of a job.

    Parameters
    ----------
    species : str
        Name of its species file, without ``.toml``.
    bird : Bird
        The bird, at the speed and in the air of the job's.
    """

    species: str
    bird: Bird

    def own(self) -> dict[str, float]:
        """Return its inputs that it does not share with the job's bird, by field."""
        return {name: getattr(self.bird, name) for name in AHEAD}

    @classmethod
    def of(cls, species: str, own: Mapping[str, float], beside: Mapping[str, float]) -> Companion:
        """Return a companion of its own inputs, and of those that it shares with another bird; both by field.

        Raises
        ------
        ValueError
            If they make no bird.
        """
        return cls(species, Bird(**own, **{name: beside[name] for name in SHARED}))


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


def inputs_of(bird: Bird | NoBird) -> dict[str, float]:
    """Return a bird's inputs by column, whether they make one or not."""
    values = bird.inputs if isinstance(bird, NoBird) else (getattr(bird, name) for name in BIRD_COLUMNS)
    return dict(zip(BIRD_COLUMNS.values(), values, strict=True))


def wavelength_ratio(bird: Bird | NoBird) -> float:
    """Return the wavelength of a bird's wake over its semispan, whether it is a bird or not."""
    if isinstance(bird, Bird):
        return bird.wavelength_m / bird.semispan_m
    inputs = inputs_of(bird)
    return inputs["speed_m_s"] * inputs["period_s"] / inputs["semispan_m"]
