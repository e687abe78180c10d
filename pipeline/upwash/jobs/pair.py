"""One bird behind another: a job whose rows are the optima of one problem."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.jobs.bird import AHEAD, Companion, NoBird, wavelength_ratio
from upwash.jobs.jitter import NAMES, left_by_jitter, unlike_left
from upwash.jobs.kind import Answer, Kind
from upwash.jobs.schema import of_two, own_fields, schema_of
from upwash.jobs.stored import (
    Complaints,
    bounds_behind,
    is_v_formation,
    pose_of,
    pose_to_the_right,
)

if TYPE_CHECKING:
    from upwash.jobs.job import Job
    from upwash.optimum.problem import PairProblem
    from upwash.optimum.proof import Proof

NO_BALANCE = "no balance: no position within the bounds balances lift and thrust"
"""Why a pair is infeasible whose bird can be."""


@dataclass(frozen=True)
class Pair(Kind):
    """A follower behind a leader.

    Parameters
    ----------
    leader : Companion or None
        The bird ahead, if it is not like the job's own, which follows.
    phase_lock : bool
        Whether the follower beats in step with its leader.
    """

    leader: Companion | None = None
    phase_lock: bool = True

    name = "pair"
    file = "solutions.parquet"
    rows = schema_of(of.SOLUTIONS_COLUMNS)
    summary = schema_of(of.SUMMARY_COLUMNS)
    is_one_problem = True
    later = {"wavelengths": WakeModel().wavelengths}

    @classmethod
    def from_inputs(cls, given: Mapping[str, Any]) -> Self:
        leader = None
        if given.get("ahead_species") is not None:
            own = {name: given[column] for name, column in AHEAD.items()}
            leader = Companion.of(given["ahead_species"], own, given)
        return cls(leader, bool(given.get("phase_lock", True)))

    def inputs(self) -> of.Row:
        found: of.Row = {"phase_lock": self.phase_lock}
        if self.leader is not None:
            own = self.leader.own()
            found |= {"ahead_species": self.leader.species, **{AHEAD[name]: own[name] for name in AHEAD}}
        return found

    def wavelength_ratio(self, bird: Bird | NoBird) -> float:
        return wavelength_ratio(bird if self.leader is None else self.leader.bird)

    def solve(self, job: Job, bird: Bird) -> Answer:
        from upwash.optimum.pair import solve_pair

        solution = solve_pair(
            bird,
            job.objective,
            model=job.model,
            search=job.search,
            distance_m=job.distance_m,
            leader=self.ahead_of(bird),
            phase_lock=self.phase_lock,
            spacing=job.spacing,
        )
        if still := solution.v_optimum or solution.global_optimum:
            left = left_by_jitter(job, bird, still.pose, solution.v_optimum is not None)
            return of.SOLVED, "", [row | left for row in solution.rows()]
        return solution.status, NO_BALANCE, [solution.of_the_job()]

    @classmethod
    def summary_schema(cls, rows: pa.Schema) -> pa.Schema:
        return pa.schema([*cls.summary, *own_fields(rows)])

    @classmethod
    def _summary(cls, rows: pa.Table, starts: NDArray[np.intp]) -> pa.Table:
        """Return the V optimum's row of each job, with nulls where a job has none."""
        is_v = rows.column("is_v_optimum").fill_null(False).to_numpy()
        cost = rows.column("cost").to_numpy()
        job = np.repeat(np.arange(starts.size), np.diff([*starts, rows.num_rows]))
        chosen = starts.copy()
        chosen[job[is_v]] = np.flatnonzero(is_v)
        has_v = is_v[chosen]
        summary = rows.take(chosen)
        # What is true of the job stands in the row of one that has no V optimum too.
        own = [field.name for field in own_fields(rows.schema)]
        for name in (*of.names(of.belonging(of.OPTIMUM)), *own):
            place = summary.schema.get_field_index(name)
            values = summary.column(place).combine_chunks()
            only_v = pa.compute.if_else(has_v, values, pa.scalar(None, values.type))
            summary = summary.set_column(place, summary.schema.field(place), only_v)
        # The best of a job comes first.
        gap = pa.array(cost[chosen] / cost[starts] - 1.0, mask=~has_v)
        count = np.add.reduceat(rows.column("rank").is_valid().to_numpy().astype(np.int64), starts)
        return of_two(
            cls.summary_schema(rows.schema), summary, {"v_gap": gap, "optima_found": pa.array(count)}
        )

    def problems(self, job: Job, bird: Bird, rows: Sequence[of.Stored]) -> list[Sequence[PairProblem]]:
        from upwash.optimum.pair import pair_problems

        shared = pair_problems(
            bird,
            job.objective,
            model=job.model,
            distance_m=job.distance_m,
            leader=self.ahead_of(bird),
            phase_lock=self.phase_lock,
            spacing=job.spacing,
        )
        return [shared for _ in rows]

    def ahead_of(self, bird: Bird) -> Bird:
        return self.leader.bird if self.leader is not None else bird

    def felt(
        self, bird: Bird, row: of.Stored, rows: Sequence[of.Stored]
    ) -> Iterator[tuple[Stroke, Pose, Bird]]:
        leader = self.ahead_of(bird)
        yield leader.stroke, pose_of(row), leader

    def bounds(self, bird: Bird, row: of.Stored) -> dict[str, tuple[float, float]]:
        leader = self.ahead_of(bird)
        return bounds_behind(row, bird, leader.stroke, leader, bird.amplitude_m)

    def why_none(self, row: of.Stored, proof: Proof) -> str:
        return NO_BALANCE

    def whole(self, job: Job, rows: Sequence[of.Stored]) -> Complaints:
        """Optima are distinct and ranked by cost; the first is the global one, the best in the V the V optimum."""
        from upwash.optimum.verify import alike, stays_in_v

        if rows[0]["rank"] is None:
            return
        problems = self.problems(job, job.bird, rows[:1])[0] if isinstance(job.bird, Bird) else ()
        in_v = (
            row["rank"]
            for row in rows
            if is_v_formation(row) and (not problems or stays_in_v(problems[0], pose_to_the_right(row)))
        )
        best_v = next(in_v, None)
        for number, row in enumerate(rows):
            if row["rank"] != number:
                yield "rank", f"expected {number}, found {row['rank']}"
            if number and row["cost"] < rows[number - 1]["cost"]:
                yield "cost", f"expected no less than that of rank {number - 1}, found {row['cost']:.12g}"
            for name, expected in (("is_global_optimum", number == 0), ("is_v_optimum", number == best_v)):
                if row[name] is not expected:
                    yield name, f"expected {expected} at rank {number}, found {row[name]}"
        if isinstance(job.bird, Bird):
            still = rows[best_v or 0]
            yield from unlike_left(job, job.bird, rows[0], pose_to_the_right(still), best_v is not None)
            for name in NAMES:
                if any(row.get(name) != rows[0].get(name) for row in rows):
                    yield name, "expected the same in all rows of a job, found several values"
        poses = list(map(pose_to_the_right, rows))
        for first, second in sorted({pair for problem in problems for pair in alike(problem, poses)}):
            yield "rank", f"expected distinct optima, found that of rank {first} again at rank {second}"
        starts = {row["starts"] for row in rows}
        if len(starts) > 1:
            yield "starts", "expected the same in all rows of a job, found several values"
        elif (hits := sum(row["hits"] or 0 for row in rows)) > (rows[0]["starts"] or inf):
            yield "hits", f"expected no more in all than {rows[0]['starts']} starts, found {hits}"
        if any(row["v_certified_gap"] is not None for row in rows) and best_v is None:
            yield "v_certified_gap", "expected none without a V optimum, found one"
