"""What a job's stored rows claim, put to the physics again: are these optima, is that proved.

Beside `upwash.batch.job` the only module of the batch layer that meets the physics.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from upwash import columns as of
from upwash.aero.pose import Pose, Stroke
from upwash.batch.job import Row, job_of
from upwash.sweep.job import Flock, Job, NoBird

if TYPE_CHECKING:
    from upwash.aero.bird import Bird
    from upwash.optimum.problem import PairProblem
    from upwash.optimum.settings import FlockRules


def problems_of(rows: Sequence[Row]) -> list[Sequence[PairProblem]]:
    """Pose the problem of each row again, from what is stored: in one piece of phase or several.

    Parameters
    ----------
    rows : sequence of dict
        All rows of a pair, or of a flock; of a pair the summary's row will do.

    Returns
    -------
    list of sequences of PairProblem
        For each row; none for one that has no problem: that of a bird that leads, or that cannot be.
    """
    from upwash.optimum.pair import pair_problem

    job = job_of(rows[0])
    bird = job.bird
    if isinstance(bird, NoBird) or rows[0]["status"] == of.FAILED:
        return [[] for _ in rows]
    if not job.flock:
        shared = [pair_problem(bird, job.objective, model=job.model, distance_m=job.distance_m)]
        return [shared for _ in rows]
    return [_link(bird, job, job.flock.rules, row, rows) for row in rows]


def _link(bird: Bird, job: Job, rules: FlockRules, row: Row, rows: Sequence[Row]) -> Sequence[PairProblem]:
    """Pose the problem of a flock's bird, to the right of the one that it follows, as it was solved."""
    from upwash.optimum.flock import link_problems
    from upwash.optimum.flock_wake import Place

    if row["bird"] == 1:
        return []
    ahead = []
    for number in rules.felt_by(row["bird"]):
        one = rows[number - 1]
        x, y, z = (one[f"{axis}_flock_m"] for axis in "xyz")
        place = Place(rules.row_of(number), Pose(x, y, z, _stroke(one), one["phase_flock"]))
        ahead.append(place if rules.side_of(row["bird"]) > 0.0 else place.mirrored())
    limit = bird.amplitude_m if rules.reading == "lone" else ahead[-1].pose.stroke.amplitude_m
    return link_problems(bird, job.objective, tuple(ahead), limit, job.model, job.distance_m)


def _stroke(row: Row) -> Stroke:
    return Stroke(row["amplitude_m"], row["upstroke_span_ratio"])


def _pose(row: Row) -> Pose:
    """Return where a row's bird flies, to the right of the one that it follows."""
    y = row["y_m"] if row["kind"] == "pair" else abs(row["y_m"])
    return Pose(row["x_m"], y, row["z_m"], _stroke(row), row["phase"])


def evidence_of(rows: Sequence[Row]) -> list[Row]:
    """Return the evidence that each row must state, by column; nothing for a row that has no optimum."""
    from upwash.optimum.core_edge import other_side
    from upwash.optimum.verify import examine

    found: list[Row] = []
    for row, problems in zip(rows, problems_of(rows), strict=True):
        if row["x_m"] is None or not problems:
            found.append({})
            continue
        # Where two pieces of phase meet, the evidence is that of the one that the search came from.
        examined = examine(problems, _pose(row))
        if not examined:
            # Of two phases that are alike the lesser is kept.
            found.append({"phase": 1.0 - row["phase"]})
            continue
        own = next((one for one in examined if one["active_bounds"] == row["active_bounds"]), examined[0])
        if row["y_m"] < 0.0:
            own = own | {"core_edges": other_side(own["core_edges"])}
        found.append(own)
    return found


def stays_in_v(row: Row) -> bool:
    """Whether a row's optimum, which is in a V, is held there by more than the steps of the wingbeat."""
    from upwash.optimum.verify import stays_in_v as stays

    (problems,) = problems_of([row])
    return not problems or stays(problems[0], _pose(row))


def alike(rows: Sequence[Row]) -> list[tuple[int, int]]:
    """Return which optima of a pair are one and the same, as pairs of ranks."""
    from upwash.optimum.verify import alike as same

    problems = problems_of(rows)[0]
    return same(problems[0], [_pose(row) for row in rows]) if problems else []


def makes_a_bird(row: Row) -> bool:
    """Whether the inputs that a row holds are those of a bird that can fly."""
    return not isinstance(job_of(row).bird, NoBird)


def why_infeasible(row: Row) -> str | None:
    """Return what an infeasible row's error must say; None if it does not say what was proved."""
    from upwash.batch.job import NO_BALANCE
    from upwash.optimum.flock import why_none
    from upwash.optimum.proof import Proof

    if row.get("bird") is None and isinstance(bird := job_of(row).bird, NoBird):
        return bird.why
    if row["feasible"] is None or row["v_wall"] is None:
        return None
    if row["kind"] == "pair":
        return NO_BALANCE
    # A bound that is not there is infinite: there is nothing that costs less.
    proof: dict[str, Any] = {
        name: math.inf if row[name] is None else row[name] for name in of.names(of.belonging(of.PROOF))
    }
    return why_none(row["leader"], Proof(**proof, tolerance=row["tolerance"]))


def disproved(rows: Sequence[Row]) -> Iterator[tuple[str, str]]:
    """Prove again what the rows of a job claim to be proved; give the columns that fail, and how.

    Parameters
    ----------
    rows : sequence of dict
        All rows of a pair, or of a flock; of a pair the summary's row will do.
    """
    for row, problems in zip(rows, problems_of(rows), strict=True):
        if problems and "v_wall" in row:
            yield from _disproved(row, problems)
            if row["kind"] == "pair":
                return


def _disproved(row: Row, problems: Sequence[PairProblem]) -> Iterator[tuple[str, str]]:
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


def links_of(row: Row, rows: Sequence[Row]) -> Row:
    """Return what a flock's shape and the birds ahead make of a bird's number, place and flags, by column."""
    job, number = job_of(rows[0]), row["bird"]
    rules = (job.flock or Flock(2)).rules
    if number == 1:
        own: Row = {f"{axis}_flock_m": 0.0 for axis in "xyz"} | {"phase_flock": 0.0}
        return own | {name: rows[0][f"leader_{name}"] for name in ("amplitude_m", "upstroke_span_ratio")}
    ahead = rows[rules.leader_of(number) - 1]
    stroke = {
        "ahead_amplitude_m": ahead["amplitude_m"],
        "ahead_upstroke_span_ratio": ahead["upstroke_span_ratio"],
    }
    links: Row = {"leader": ahead["bird"], **stroke}
    if row["status"] != of.SOLVED:
        return links
    side = rules.side_of(number)
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


def walls() -> tuple[str, ...]:
    """Return the names of the walls of the V region."""
    from upwash.optimum.proof import WALLS

    return tuple(WALLS)
