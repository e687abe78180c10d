"""Reading one sweep file: TOML in, jobs out, or one line about the first thing that is wrong."""

from __future__ import annotations

import os
import re
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from time import monotonic
from typing import Any

from upwash.errors import UpwashError
from upwash.jobs.job import BUILT_IN_SOLVER, ID_BYTES, Job
from upwash.jobs.kind import Kind
from upwash.jobs.kinds import KINDS
from upwash.jobs.own_solver import own_solver
from upwash.jobs.pair import Pair
from upwash.shipped import shipped
from upwash.species.file import NAMES, did_you_mean, file_here, printable
from upwash.sweep.block import Block
from upwash.sweep.block_reader import MAX_JOBS, BlockReader, block_keys
from upwash.sweep.entry import Entry, read_toml

SWEEP_FOLDER = shipped("sweeps")

FILE_KEYS = ("name", "description", "kind", "solver", "block")
# A sweep's name becomes a folder's: nothing in it may lead elsewhere, hide it, or be too long.
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,79}")
SOLVER = re.compile(rf"{BUILT_IN_SOLVER}|[A-Za-z_][\w.]*:[A-Za-z_]\w*")
TELL_EVERY_S = 5.0


@dataclass(frozen=True)
class Sweep:
    """A sweep file as read.

    Parameters
    ----------
    name : str
        Safe to use as a folder's name.
    text : str
        The file's own text.
    kind : type of Kind
        What its jobs are.
    count : int
        Number of jobs.
    varied : frozenset of str
        Inputs that are not the same in all jobs.
    blocks : tuple of Block
        What the jobs are made of.
    repeated : frozenset of str
        Ids of the jobs that more than one block asks for.
    """

    name: str
    text: str
    kind: type[Kind]
    count: int
    varied: frozenset[str]
    blocks: tuple[Block, ...]
    repeated: frozenset[str]

    def stream(self) -> Iterator[Job]:
        """Make the jobs, each once, in the order of the file; however many there are, none is kept."""
        given: set[str] = set()
        for block in self.blocks:
            for job, exclusion in block.jobs():
                if exclusion is None and job.job_id not in given:
                    if job.job_id in self.repeated:
                        given.add(job.job_id)
                    yield job

    @cached_property
    def jobs(self) -> list[Job]:
        """All jobs, each once, in the order of the file."""
        return list(self.stream())


def find_sweep(name_or_path: str | os.PathLike[str]) -> Path:
    """Return the file of a sweep.

    Parameters
    ----------
    name_or_path : str or path
        A name in sweeps/, or the path of a file: whatever ends in ``.toml`` or contains a path separator.

    Raises
    ------
    UpwashError
        If there is no sweep of that name.
    """
    text = os.fspath(name_or_path)
    if text.endswith(".toml") or "/" in text or os.sep in text:
        return Path(text)
    names = sorted(path.stem for path in SWEEP_FOLDER.glob("*.toml"))
    if text in names:
        return SWEEP_FOLDER / f"{text}.toml"
    expected = "expected a name in sweeps/ or the path of a TOML file"
    remedy = file_here(text) or did_you_mean(text, names)
    raise UpwashError(f"sweep: {expected}, found {printable(text)}; {remedy}", field="sweep")


def read_sweep(
    name_or_path: str | os.PathLike[str], tell: Callable[[str], None] = lambda line: None
) -> Sweep:
    """Read and check a sweep file as a whole, every job that it makes included.

    Parameters
    ----------
    name_or_path : str or path
        As for `find_sweep`.
    tell : callable
        Takes a line every few seconds where the jobs are very many.

    Raises
    ------
    UpwashError
        If it cannot be read, or anything in it is unknown, of the wrong kind, impossible or contradictory.
    """
    path = find_sweep(name_or_path)
    text, top = read_toml(path)
    if isinstance(top.value, dict) and set(NAMES) & set(top.value):
        shown = printable(str(path))
        remedy = f"write a sweep with species = {shown} in it, or 'upwash optimum {path}' for this bird alone"
        raise UpwashError(f"{path}: expected a sweep file, found a species file; {remedy}", field="sweep")
    keys = top.table((*FILE_KEYS, *block_keys()))
    name = keys.get("name", top.at(path.stem, "name"))
    if not NAME.fullmatch(name.text()):
        remedy = "it names the results folder: set name = to a plain one"
        raise name.unexpected("up to 80 letters, digits, dots, hyphens and underscores", remedy)
    keys.get("description", top.at("")).text()
    kind = KINDS[keys.get("kind", top.at(Pair.name)).one_of(KINDS)]
    solver = keys.get("solver", top.at(BUILT_IN_SOLVER))
    if not SOLVER.fullmatch(solver.text()):
        raise solver.unexpected("package.module:function")
    if solver.value != BUILT_IN_SOLVER:
        try:
            own_solver(solver.value)
        except UpwashError as error:
            raise solver.error(str(error)) from error
    reader = BlockReader(path.parent, kind, solver.value)
    tables = keys["block"].tables() if "block" in keys else [top.at({})]
    checked = [reader.block(table, keys) for table in tables]
    seen = _Seen(top, sum(block.size() for block, _ in checked), tell)
    for _, jobs in checked:
        for job in jobs:
            seen.add(job)
    count, repeated = seen.counted()
    if not 1 <= count <= MAX_JOBS:
        raise top.error(f"expected 1 to {MAX_JOBS} jobs, found {count}; split the sweep or add a [[block]]")
    blocks = tuple(block for block, _ in checked)
    return Sweep(name.value, text, kind, count, frozenset(seen.varied), blocks, repeated)


class _Seen:
    """What is kept of the jobs while they are checked: eight bytes each, and which of their inputs vary."""

    def __init__(self, top: Entry, expected: int, tell: Callable[[str], None]) -> None:
        self.top = top
        self.expected = expected
        self.tell = tell
        self.ids = array("Q")
        self.first: dict[str, Any] = {}
        self.varied: set[str] = set()
        self.told = monotonic()

    def add(self, job: Job) -> None:
        """Take note of a job."""
        self.ids.append(int(job.job_id, 16))
        inputs = job.inputs()
        self.first = self.first or inputs
        if inputs != self.first:
            self.varied.update(name for name, value in inputs.items() if value != self.first[name])
        if len(self.ids) % 1000 == 0 and monotonic() - self.told > TELL_EVERY_S:
            self.told = monotonic()
            self.tell(f"{self.top.file}: {len(self.ids)} of {self.expected} jobs checked")

    def counted(self) -> tuple[int, frozenset[str]]:
        """Return how many different jobs there are, and the ids of those that were seen more than once."""
        import numpy as np

        ids, times = np.unique(np.frombuffer(self.ids, dtype=np.uint64), return_counts=True)
        return len(ids), frozenset(f"{job_id:0{2 * ID_BYTES}x}" for job_id in ids[times > 1].tolist())
