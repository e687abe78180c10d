"""A kind of job of the tests' own: as another one would be added, in a module of its own."""

from dataclasses import dataclass
from typing import ClassVar

from upwash.aero.checked import whole_from
from upwash.jobs.pair import Pair


@dataclass(frozen=True)
class Line(Pair):
    """As many birds in line as its own table says."""

    birds: int = 1

    name = "line"
    file = "lines.parquet"
    rows = Pair.rows.append(Pair.rows.field(0).with_name("flock_id"))
    choices: ClassVar = {"birds": whole_from(1, 9, "a line is short")}
    usual: ClassVar = {"birds": 3}

    @classmethod
    def from_inputs(cls, given):
        return cls(birds=given.get("birds") or 1)

    def inputs(self):
        return {}
