"""A flock, built bird by bird: a job whose rows are its birds, each with a problem of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.jobs.kind import Answer, Kind
from upwash.jobs.schema import of_two, schema_of
from upwash.jobs.stored import (
    AGREEMENT,
    Complaints,
    bounds_behind,
    place_of,
    pose_of,
    stroke_of,
    unlike,
)
from upwash.optimum.settings import BIRDS, FLOCK_CHOICES, FlockRules
from upwash.optimum.solvable import need_solvable

if TYPE_CHECKING:
    from upwash.jobs.job import Job
    from upwash.optimum.flock_solution import FlockSolution
    from upwash.optimum.problem import PairProblem
    from upwash.optimum.proof import Proof


@dataclass(frozen=True)
class Flock(Kind):
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

    name = "flock"
    file = "flock.parquet"
    rows = schema_of(of.FLOCK_COLUMNS)
    summary = schema_of(of.FLOCK_SUMMARY_COLUMNS)
    is_one_problem = False
    choices = {"birds": BIRDS, **FLOCK_CHOICES}
    usual = {"birds": 6, "shape": "echelon", "wake": "neighbour", "reading": "immediate"}
    parts = ("wavelengths",)

    def __post_init__(self) -> None:
        BIRDS("birds", self.birds)

    @classmethod
    def from_inputs(cls, given: Mapping[str, Any]) -> Self:
        return cls(
            given["birds"], FlockRules(**{name: given[name] for name in FLOCK_CHOICES if name in given})
        )

    def inputs(self) -> of.Row:
        return {"birds": self.birds, **vars(self.rules)}

    def need_solvable(self, model: WakeModel) -> None:
        need_solvable(model, self.rules)

    def solve(self, job: Job, bird: Bird) -> Answer:
        return of.SOLVED, "", self.solution(job, bird).rows()

    def solution(self, job: Job, bird: Bird) -> FlockSolution:
        """Return the flock of a job."""
        from upwash.optimum.flock import solve_flock

        return solve_flock(
            bird,
            self.birds,
            job.objective,
            rules=self.rules,
            model=job.model,
            search=job.search,
            distance_m=job.distance_m,
        )

    @classmethod
    def _summary(cls, rows: pa.Table, starts: NDArray[np.intp]) -> pa.Table:
        """Return means over the birds of each flock, and how it ended."""
        status = np.array([of.STATUSES.index(one) for one in rows.column("status").to_pylist()])
        worst = [
            start + int(np.argmax(part))
            for start, part in zip(starts, np.split(status, starts[1:]), strict=True)
        ]
        is_placed = status == of.STATUSES.index(of.SOLVED)
        placed = np.add.reduceat(is_placed.astype(np.int64), starts)

        def mean(name: str) -> pa.Array:
            values = np.where(is_placed, rows.column(name).to_numpy(), 0.0)
            return pa.array(np.add.reduceat(values, starts) / np.maximum(placed, 1), mask=placed == 0)

        ended = {name: rows.column(name).take(pa.array(worst)) for name in ("status", "error")}
        means = {"cost_mean": mean("cost"), "saving_total_mean": mean("saving_total")}
        return of_two(cls.summary, rows.take(starts), {"birds_placed": pa.array(placed), **ended, **means})

    def problems(self, job: Job, bird: Bird, rows: Sequence[of.Stored]) -> list[Sequence[PairProblem]]:
        return [self._link(job, bird, row, rows) for row in rows]

    def _link(self, job: Job, bird: Bird, row: of.Stored, rows: Sequence[of.Stored]) -> Sequence[PairProblem]:
        """Pose the problem of a bird, to the right of the one that it follows, as it was solved."""
        from upwash.optimum.flock import link_problems
        from upwash.optimum.flock_wake import Place

        if row["bird"] == 1:
            return []
        ahead = []
        for number in self.rules.felt_by(row["bird"]):
            place = Place(self.rules.row_of(number), place_of(rows[number - 1]))
            ahead.append(place if self.rules.side_of(row["bird"]) > 0.0 else place.mirrored())
        limit = bird.amplitude_m if self.rules.reading == "lone" else ahead[-1].pose.stroke.amplitude_m
        return link_problems(bird, job.objective, tuple(ahead), limit, job.model, job.distance_m)

    def felt(self, row: of.Stored, rows: Sequence[of.Stored]) -> Iterator[tuple[Stroke, Pose]]:
        if row["bird"] == 1:
            return
        yield stroke_of(row, "ahead_"), pose_of(row)
        for number in self.rules.felt_by(row["bird"])[:-1]:
            other = rows[number - 1]
            yield stroke_of(other), place_of(row).relative_to(place_of(other))

    def bounds(self, row: of.Stored) -> dict[str, tuple[float, float]]:
        ahead = stroke_of(row, "ahead_")
        limit = row["leader_amplitude_m"] if self.rules.reading == "lone" else ahead.amplitude_m
        found = bounds_behind(row, ahead, limit)
        # A flock's birds may fly on either side of the one ahead.
        return found | {"y_m": (-found["y_m"][1], found["y_m"][1])}

    def why_none(self, row: of.Stored, proof: Proof) -> str:
        from upwash.optimum.flock import why_none

        return why_none(row["leader"], proof)

    def whole(self, job: Job, rows: Sequence[of.Stored]) -> Complaints:
        """Each bird follows the one that the shape says, and stands there, on its side."""
        for row in rows if rows[0]["status"] == of.SOLVED else ():
            for name, value in self.links(row, rows).items():
                # Places add up, the rest is the same value.
                agreement = AGREEMENT if "_flock" in name else of.EXACT
                yield from unlike(row, {name: value}, agreement, "by the flock's shape and the birds ahead")

    def links(self, row: of.Stored, rows: Sequence[of.Stored]) -> of.Row:
        """Return what shape and birds ahead make of a bird's number, place and flags, by column."""
        number = row["bird"]
        if number == 1:
            own: of.Row = dict.fromkeys(("x_flock_m", "y_flock_m", "z_flock_m", "phase_flock"), 0.0)
            return own | {name: rows[0][f"leader_{name}"] for name in ("amplitude_m", "upstroke_span_ratio")}
        ahead = rows[self.rules.leader_of(number) - 1]
        stroke = {
            "ahead_amplitude_m": ahead["amplitude_m"],
            "ahead_upstroke_span_ratio": ahead["upstroke_span_ratio"],
        }
        links: of.Row = {"leader": ahead["bird"], **stroke}
        if row["status"] != of.SOLVED:
            return links
        side = self.rules.side_of(number)
        lag = ahead["phase_flock"] + row["phase"]
        # By rounding a phase may be next to 0 or next to 1.
        turns = round(row["phase_flock"] - lag) if 0.0 <= row["phase_flock"] < 1.0 else -math.floor(lag)
        return links | {
            **{f"{axis}_flock_m": ahead[f"{axis}_flock_m"] + row[f"{axis}_m"] for axis in "xyz"},
            "phase_flock": lag + turns,
            "y_m": side * abs(row["y_m"]),
            "is_v_optimum": True,
            "is_global_optimum": row["rank"] == 0,
        }


def flock_of(job: Job) -> FlockSolution:
    """Return the flock of a job that is one, of inputs that make a bird."""
    if not isinstance(job.bird, Bird) or not isinstance(job.kind, Flock):
        raise ValueError(f"expected the job of a flock, found {job}")
    return job.kind.solution(job, job.bird)
