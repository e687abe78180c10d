"""The job of one bird, as a command line asks for it: the same job, with the same id, as in a sweep."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from upwash.errors import UpwashError
from upwash.species import load_species
from upwash.species.file import did_you_mean, printable
from upwash.sweep.block import PARAMETERS, RESOLUTION, WHOLE, Block
from upwash.sweep.job import BUILT_IN_SOLVER, Job
from upwash.sweep.values import Setting, is_number

# Optima are searched with the paper's two stroke states alone.
SETTABLE = tuple(name for name in PARAMETERS if name != "stroke_states")


def single_job(kind: str, species: str, settings: Iterable[str], amplitude: str, **choices: Any) -> Job:
    """Make the job of one bird.

    Parameters
    ----------
    kind : str
        ``pair`` or ``flock``.
    species : str
        Name in the library, or path of a species file.
    settings : iterable of str
        Inputs that differ from the species' own, each ``NAME=VALUE`` in SI units, named as in a sweep file.
    amplitude : str
        Amplitude convention.
    **choices
        Objective, seed, tolerance and, of a flock, birds, shape, wake and reading.

    Raises
    ------
    UpwashError
        If the species, an input or a value is wrong, or they make no bird.
    """
    if not 0.0 < choices["tolerance"] < 1.0:
        expected = "expected a number between 0 and 1"
        raise UpwashError(f"--tolerance: {expected}, found {choices['tolerance']}; 1e-4 is usual")
    fixed: dict[str, Setting] = {}
    for name, setting in map(_setting, settings):
        if name in fixed:
            raise UpwashError(f"--set {name}: expected each input once, found it twice; leave one out")
        fixed[name] = setting
    bird = load_species(species)
    # A stroke that no wing can make is a result in a sweep; here it is a mistake, which this finds.
    bird.bird(amplitude, **{name: one.value for name, one in fixed.items() if name not in RESOLUTION})
    block = Block(
        kind=kind,
        solver=BUILT_IN_SOLVER,
        species=[bird],
        choices={"amplitude": [amplitude], **{name: [value] for name, value in choices.items()}},
        fixed=fixed,
        axes=[],
        sample=None,
        exclusions=[],
    )
    ((job, _),) = block.jobs()
    return job


def _setting(text: str) -> tuple[str, Setting]:
    """Read ``NAME=VALUE``."""
    name, equals, written = (part.strip() for part in text.partition("="))
    if not equals:
        raise UpwashError(f"--set: expected NAME=VALUE, found {printable(text)}; write as in speed_m_s=12")
    if name not in SETTABLE:
        remedy = did_you_mean(name, SETTABLE)
        raise UpwashError(f"--set: expected an input, found {printable(name)}; {remedy}")
    is_whole = name in WHOLE
    try:
        value = int(written) if is_whole else float(written)
    except ValueError:
        value = 0
    if not (is_number(value) and (value >= 2 if is_whole else value > 0)):
        expected = "a whole number of at least 2" if is_whole else "a positive, finite number"
        raise UpwashError(f"--set {name}: expected {expected}, found {printable(written)}; correct it")
    return name, Setting(value)
