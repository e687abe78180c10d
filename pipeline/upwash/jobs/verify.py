"""What a job's stored rows claim, put to the physics again: are these optima, is that proved."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, replace
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.jobs.bird import NoBird
from upwash.jobs.job import Job, job_of
from upwash.jobs.stored import Complaints, pose_to_the_right

if TYPE_CHECKING:
    from upwash.optimum.problem import PairProblem


def problems_of(rows: Sequence[of.Stored]) -> list[Sequence[PairProblem]]:
    """Pose the problem of each row again, from what is stored: in one piece of phase or several.

    Parameters
    ----------
    rows : sequence of mapping
        All rows of one job; of a pair the summary's row will do.

    Returns
    -------
    list of sequences of PairProblem
        For each row; none for one that has no problem: that of a bird that leads, or that cannot be.
    """
    job = job_of(rows[0])
    if isinstance(job.bird, NoBird) or rows[0]["status"] == of.FAILED:
        return [[] for _ in rows]
    return job.kind.problems(job, job.bird, rows)


def recompute(rows: Sequence[of.Stored]) -> list[of.Row]:
    """Return what the forces, powers, savings, costs and labels of one job's solved rows must be.

    By the plain statement of the physics, not by the compiled one that the search used.

    Parameters
    ----------
    rows : sequence of mapping
        All rows of one job.

    Returns
    -------
    list of dict
        For each row, column -> value; nothing for a row that has no solution.
    """
    job = job_of(rows[0])
    return [_expected(job, row, rows) if row["status"] == of.SOLVED else {} for row in rows]


def _expected(job: Job, row: of.Stored, rows: Sequence[of.Stored]) -> of.Row:
    from upwash.optimum.record import record

    if isinstance(job.bird, NoBird):
        raise ValueError(f"{job.bird.why}: no bird")
    bird, felt = job.kind.kind_of(job.bird, row), list(job.kind.felt(job.bird, row, rows))
    ahead, pose, leader = felt.pop(0) if felt else (None, None, None)
    lock = job.kind.phase_lock
    found = vars(record(bird, job.objective, ahead, pose, job.model, felt, leader=leader, phase_lock=lock))
    return {name: value for name, value in found.items() if value is not None or name in PHASES}


def bounds_of(rows: Sequence[of.Stored]) -> list[dict[str, tuple[float, float]]]:
    """Return the bounds of the variables of each of a job's rows, by column; none of one that found no place."""
    job = job_of(rows[0])
    if isinstance(job.bird, NoBird):
        return [{} for _ in rows]
    return [job.kind.bounds(job.bird, row) if row.get("x_m") is not None else {} for row in rows]


PHASES = ("phase", "spatial_phase")
"""What a bird that keeps its own beat must not be told to have."""


def evidence_of(rows: Sequence[of.Stored]) -> list[of.Row]:
    """Return the evidence that each row must state, by column; nothing for a row that has no optimum."""
    from upwash.optimum.core_edge import other_side
    from upwash.optimum.verify import examine

    found: list[of.Row] = []
    for row, problems in zip(rows, problems_of(rows), strict=True):
        if row["x_m"] is None or not problems:
            found.append({})
            continue
        # Where two pieces of phase meet, the evidence is that of the one that the search came from.
        examined = examine(problems, pose_to_the_right(row))
        if not examined:
            # Of two phases that are alike the lesser is kept.
            found.append({"phase": 1.0 - row["phase"]})
            continue
        own = next((one for one in examined if one.active_bounds == row["active_bounds"]), examined[0])
        if row["y_m"] < 0.0:
            own = replace(own, core_edges=other_side(own.core_edges))
        found.append(asdict(own))
    return found


def makes_a_bird(row: of.Stored) -> bool:
    """Whether the inputs that a row holds are those of a bird that can fly."""
    return not isinstance(job_of(row).bird, NoBird)


def why_infeasible(row: of.Stored) -> str | None:
    """Return what an infeasible row's error must say; None if it does not say what was proved."""
    from upwash.optimum.proof import Proof

    job = job_of(row)
    if row.get("bird") is None and isinstance(job.bird, NoBird):
        return job.bird.why
    if row["feasible"] is None or row["v_wall"] is None:
        return None
    # A bound that is not there is infinite: there is nothing that costs less.
    proof: dict[str, Any] = {
        name: math.inf if row[name] is None else row[name] for name in of.names(of.belonging(of.PROOF))
    }
    return job.kind.why_none(row, Proof(**proof, tolerance=row["tolerance"]))


def disproved(rows: Sequence[of.Stored]) -> Complaints:
    """Prove again what the rows of a job claim to be proved; give the columns that fail, and how.

    Parameters
    ----------
    rows : sequence of dict
        All rows of one job; of a pair the summary's row will do.
    """
    kind = job_of(rows[0]).kind
    for row, problems in zip(rows, problems_of(rows), strict=True):
        if problems and "v_wall" in row:
            yield from _disproved(row, problems)
            if kind.is_one_problem:
                return


def _disproved(row: of.Stored, problems: Sequence[PairProblem]) -> Complaints:
    from upwash.optimum.verify import best_on_wall, refute_bound

    for region, where in (("v", "in the V region"), ("global", "anywhere")):
        bound, label = row[f"{region}_lower_bound"], f"is_{region}_optimum"
        # A flock's bird with more than one ahead is proved in its V region alone.
        if region == "global" and ((bound is None and row["feasible"]) or bound == 0.0):
            continue
        gap = row["v_region_certified_gap" if region == "v" else "global_certified_gap"]
        best = bound * (1.0 + gap) if bound is not None and gap is not None else None
        refuted = refute_bound(problems, bound, best, row["tolerance"], in_v=region == "v")
        if refuted is None:
            continue
        if refuted.cost == math.inf and gap is None:
            yield f"{region}_lower_bound", f"expected none, as it is proved that no follower {where} balances"
            continue
        if refuted.cost == math.inf:
            found = f"found {gap:.3g}, though the proof closes to {row['tolerance']:.3g}"
            yield f"{region}_certified_gap", f"expected a gap that a proof leaves open, {found}"
            continue
        if bound is None:
            expected = f"expected no follower {where} that balances"
        elif refuted.cost is None or refuted.cost < bound:
            expected = f"expected no follower {where} that costs less than {bound:.9g}"
        else:
            expected = f"expected no follower {where} that costs less than the best, {best or math.inf:.9g}"
            yield label, f"{expected}, found one that costs {refuted.cost:.9g}"
            continue
        found = "no proof of that" if refuted.cost is None else f"one that costs {refuted.cost:.9g}"
        yield f"{region}_lower_bound", f"{expected}, found {found}"
    if row["v_wall"]:
        told = row["v_lower_bound"] * (1.0 + row["v_region_certified_gap"])
        met = best_on_wall(problems, row["v_wall"])
        if not met <= told * (1.0 + ON_WALL):
            expected = f"expected a follower on {row['v_wall']} that costs {told:.9g}"
            yield "v_wall", f"{expected}, found none below {met:.9g}"


ON_WALL = 1e-6
"""By how much the best follower that is met on a wall may cost more than the one that is told to lie there."""


def walls() -> tuple[str, ...]:
    """Return the names of the walls of the V region."""
    from upwash.optimum.proof import WALLS

    return tuple(WALLS)
