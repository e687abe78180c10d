"""A flock, built bird by bird: a job whose rows are its birds, each with a problem of its own."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.checked import WrongInput
from upwash.aero.pose import Pose, Stroke
from upwash.aero.together import in_step
from upwash.aero.wake import WakeModel
from upwash.jobs.bird import Companion, NoBird, wavelength_ratio
from upwash.jobs.jitter import NAMES
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
    members : tuple of Companion
        The birds behind the first, front to back; none if all are like it.
    phase_lock : bool
        Whether all beat in step.
    """

    birds: int
    rules: FlockRules = FlockRules()
    members: tuple[Companion, ...] = ()
    phase_lock: bool = True

    name = "flock"
    file = "flock.parquet"
    rows = schema_of(of.FLOCK_COLUMNS)
    summary = schema_of(of.FLOCK_SUMMARY_COLUMNS)
    is_one_problem = False
    choices = {"birds": BIRDS, **FLOCK_CHOICES}
    usual = {"birds": 6, "shape": "echelon", "wake": "neighbour", "reading": "immediate"}
    companions = ("members",)
    parts = ("wavelengths",)

    def __post_init__(self) -> None:
        BIRDS("birds", self.birds)
        if self.members and len(self.members) != self.birds - 1:
            raise WrongInput("members", f"{self.birds - 1}, for {self.birds} birds", len(self.members))

    @classmethod
    def from_inputs(cls, given: Mapping[str, Any]) -> Self:
        rules = FlockRules(**{name: given[name] for name in FLOCK_CHOICES if name in given})
        members = tuple(
            Companion.of(one.pop("species"), one, given) for one in json.loads(given.get("members") or "[]")
        )
        return cls(given["birds"], rules, members, bool(given.get("phase_lock", True)))

    def inputs(self) -> of.Row:
        found: of.Row = {"birds": self.birds, **vars(self.rules), "phase_lock": self.phase_lock}
        if self.members:
            found["members"] = json.dumps([{"species": one.species, **one.own()} for one in self.members])
        return found

    def kinds(self, bird: Bird) -> tuple[Bird, ...]:
        """Return all birds as they fly alone, given the first."""
        return (bird, *(one.bird for one in self.members)) if self.members else (bird,) * self.birds

    def kind_of(self, bird: Bird, row: of.Stored) -> Bird:
        return self.kinds(bird)[row["bird"] - 1]

    def wavelength_ratio(self, bird: Bird | NoBird) -> float:
        if not isinstance(bird, Bird):
            return wavelength_ratio(bird)
        return max(wavelength_ratio(self._flown(bird, number)) for number in range(1, self.birds))

    def _flown(self, bird: Bird, number: int) -> Bird:
        """Return a bird as it beats."""
        return in_step(self.kinds(bird)[number - 1], bird, self.phase_lock)

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
            members=self.kinds(bird)[1:],
            phase_lock=self.phase_lock,
            spacing=job.spacing,
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
            pose = place_of(rows[number - 1])
            place = Place(self.rules.row_of(number), pose, self._flown(bird, number))
            ahead.append(place if self.rules.side_of(row["bird"]) > 0.0 else place.mirrored())
        own, lock = self.kind_of(bird, row), self.phase_lock
        asked = job.model, job.distance_m, lock, job.spacing
        return link_problems(own, job.objective, tuple(ahead), self.rules, *asked)

    def felt(
        self, bird: Bird, row: of.Stored, rows: Sequence[of.Stored]
    ) -> Iterator[tuple[Stroke, Pose, Bird]]:
        if row["bird"] == 1:
            return
        yield stroke_of(row, "ahead_"), pose_of(row), self._flown(bird, row["leader"])
        for number in self.rules.felt_by(row["bird"])[:-1]:
            other = rows[number - 1]
            pose = place_of(row).relative_to(place_of(other))
            yield stroke_of(other), pose, self._flown(bird, number)

    def bounds(self, bird: Bird, row: of.Stored) -> dict[str, tuple[float, float]]:
        from upwash.optimum.flock_wake import amplitude_limit

        own, ahead = self.kind_of(bird, row), stroke_of(row, "ahead_")
        leader = self._flown(bird, row["leader"])
        found = bounds_behind(row, own, ahead, leader, amplitude_limit(own, ahead, leader, self.rules))
        # A flock's birds may fly on either side of the one ahead.
        inner, outer = found["y_m"]
        return found | {"y_m": (-outer, -inner) if row["y_m"] < 0.0 else (inner, outer)}

    def why_none(self, row: of.Stored, proof: Proof) -> str:
        from upwash.optimum.flock import why_none

        return why_none(row["leader"], proof)

    def whole(self, job: Job, rows: Sequence[of.Stored]) -> Complaints:
        """Each bird follows the one that the shape says, and stands there, on its side; none jitters."""
        for row in rows:
            for name in NAMES:
                if row.get(name) is not None:
                    yield name, f"expected none, as birds of flocks are told no jitter, found {row[name]}"
        for row in rows if rows[0]["status"] == of.SOLVED else ():
            for name, value in self.links(row, rows).items():
                # Places add up, the rest is the same value.
                agreement = AGREEMENT if "_flock" in name else of.EXACT
                yield from unlike(row, {name: value}, agreement, "by the flock's shape and the birds ahead")

    def links(self, row: of.Stored, rows: Sequence[of.Stored]) -> of.Row:
        """Return what shape and birds ahead make of a bird's number, place and flags, by column."""
        number = row["bird"]
        if number == 1:
            own: of.Row = dict.fromkeys(("x_flock_m", "y_flock_m", "z_flock_m"), 0.0)
            own |= {"phase_flock": 0.0 if self.phase_lock else None}
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
        phase: of.Row = {"phase_flock": None}
        told = row["phase_flock"]
        if self.phase_lock and None not in (ahead["phase_flock"], row["phase"]):
            lag = ahead["phase_flock"] + row["phase"]
            # By rounding a phase may be next to 0 or next to 1.
            turns = round(told - lag) if told is not None and 0.0 <= told < 1.0 else -math.floor(lag)
            phase["phase_flock"] = lag + turns
        return links | {
            **{f"{axis}_flock_m": ahead[f"{axis}_flock_m"] + row[f"{axis}_m"] for axis in "xyz"},
            **phase,
            "y_m": side * abs(row["y_m"]),
            "is_v_optimum": True,
            "is_global_optimum": row["rank"] == 0,
        }


def flock_of(job: Job) -> FlockSolution:
    """Return the flock of a job that is one, of inputs that make a bird."""
    if not isinstance(job.bird, Bird) or not isinstance(job.kind, Flock):
        raise ValueError(f"expected the job of a flock, found {job}")
    return job.kind.solution(job, job.bird)
