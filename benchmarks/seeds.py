"""Whether the search can be relied on: the same pair from many seeds, and birds drawn at random.

A seed counts if it found the global optimum and the V optimum and closed both proofs, every cost being within 1e-9
of the best that any seed found.  A random bird counts if both proofs are closed: half of them fly behind a bird that
has the stroke of an optimum found before, as in a flock.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from upwash.aero.bird import Bird
from upwash.columns import INTEGER, TEXT, TRUTH, Column
from upwash.jobs.schema import schema_of
from upwash.optimum.pair import solve_pair
from upwash.optimum.proof import OPEN
from upwash.optimum.settings import SearchSettings
from upwash.optimum.solution import PairSolution

from benchmarks.wake_force import IBIS

PARTS = ("seeds", "birds")
OBJECTIVES = ("force", "power")
TOLERANCE = 1e-4
SAME_COST = 1e-9
NEAR_BEST = 1.01

# The groups that a force-optimal pair depends on: W/(ρ b² U²), λ/b, h/b and R, each with its range.
GROUPS = {"loading": (0.04, 0.3), "wavelength": (2.5, 8.0), "height": (0.6, 1.8), "span_ratio": (0.35, 0.5)}

SCHEMA = schema_of(
    [
        Column("contest", "", "seeds: one bird from many seeds; birds: random birds", TEXT),
        Column("objective", "", "cost function", TEXT),
        Column("seed", "1", "seed of the search", INTEGER),
        Column(
            "follows", "", "lone: the bird ahead flies as if alone; flock: as an optimum found before", TEXT
        ),
        Column("loading", "1", "W/(ρ b² U²)"),
        Column("wavelength", "1", "λ/b"),
        Column("height", "1", "h/b"),
        Column("span_ratio", "1", "R"),
        Column("leader_height", "1", "amplitude of the bird ahead, in semispans"),
        Column("leader_span_ratio", "1", "upstroke span ratio of the bird ahead"),
        Column("status", "", "solved, or infeasible: no follower can balance", TEXT),
        Column("optima", "1", "number of optima found", INTEGER),
        Column("optima_near_best", "1", "number of those that cost at most 1 % more than the best", INTEGER),
        Column("global_cost", "1", "cost of the best optimum over that of the lone bird"),
        Column("v_cost", "1", "cost of the V optimum over that of the lone bird; null if there is none"),
        Column("global_gap", "1", "cost of the best optimum over its proved bound, less 1"),
        Column("v_gap", "1", "cost of the V optimum over its proved bound, less 1"),
        Column("v_wall", "", "walls on which the V region's best point lies, if it is no optimum", TEXT),
        Column("boxes", "1", "boxes that the proofs examined", INTEGER),
        Column(
            "is_closed", "", "whether both proofs, of the V region and of all, reached the tolerance", TRUTH
        ),
        Column("stationarity", "1", "largest stationarity measure of the optima"),
        Column("solve_time_s", "s", "wall time"),
        Column("processor", "", "model of the processor", TEXT),
        Column("cores", "1", "number of the processor's cores", INTEGER),
        Column("system", "", "operating system", TEXT),
    ]
)


@dataclass(frozen=True)
class Task:
    """One job of a study: a bird, and from which seed it is solved for which objective."""

    contest: str
    bird: Bird
    objective: str
    seed: int
    is_in_flock: bool = False


def bird_of(loading: float, wavelength: float, height: float, span_ratio: float) -> Bird:
    """Return a bird with the given groups; what does not matter is the ibis's."""
    b, speed = IBIS.semispan_m, IBIS.speed_m_s
    weight = loading * IBIS.density_kg_m3 * b**2 * speed**2
    return Bird(
        mass_kg=weight / IBIS.gravity_m_s2,
        semispan_m=b,
        speed_m_s=speed,
        period_s=wavelength * b / speed,
        density_kg_m3=IBIS.density_kg_m3,
        gravity_m_s2=IBIS.gravity_m_s2,
        amplitude_m=height * b,
        upstroke_span_ratio=span_ratio,
    )


def tasks(seeds: int, birds: int) -> Iterator[Task]:
    """List the ibis from so many seeds for each objective, and so many random birds."""
    for objective, seed in product(OBJECTIVES, range(seeds)):
        yield Task("seeds", IBIS, objective, seed)
    low, high = np.array(list(GROUPS.values())).T
    for number, fractions in enumerate(np.random.default_rng(0).random((birds, len(GROUPS)))):
        bird = bird_of(*(float(value) for value in low + fractions * (high - low)))
        # Both kinds of leader see both objectives.
        yield Task("birds", bird, OBJECTIVES[number // 2 % 2], 0, is_in_flock=number % 2 == 1)


def solved(task: Task) -> dict[str, Any]:
    """Solve a task and return its row."""
    bird, b = task.bird, task.bird.semispan_m
    leader, search = bird.stroke, SearchSettings(task.seed, TOLERANCE)
    if task.is_in_flock:
        before = solve_pair(bird, task.objective, search=search)
        ahead = before.v_optimum or before.global_optimum
        if ahead:
            leader = ahead.pose.stroke
    solution = solve_pair(bird, task.objective, ahead=leader, search=search)
    return {
        "contest": task.contest,
        "objective": task.objective,
        "seed": task.seed,
        "follows": "flock" if task.is_in_flock else "lone",
        "loading": bird.weight_n / (bird.density_kg_m3 * b**2 * bird.speed_m_s**2),
        "wavelength": bird.wavelength_m / b,
        "height": bird.amplitude_m / b,
        "span_ratio": bird.upstroke_span_ratio,
        "leader_height": leader.amplitude_m / b,
        "leader_span_ratio": leader.span_ratio,
    } | outcome(solution)


def outcome(solution: PairSolution) -> dict[str, Any]:
    """Return what a study keeps of a solution."""
    best, v_best, proof = solution.global_optimum, solution.v_optimum, solution.proof
    return {
        "status": solution.status,
        "optima": len(solution.optima),
        "optima_near_best": sum(one.cost <= NEAR_BEST * best.cost for one in solution.optima) if best else 0,
        "global_cost": best.cost / best.cost_leader if best else None,
        "v_cost": v_best.cost / v_best.cost_leader if v_best else None,
        "global_gap": proof.global_certified_gap,
        "v_gap": proof.v_certified_gap,
        "v_wall": proof.v_wall,
        "boxes": proof.certificate_boxes,
        "is_closed": OPEN not in (proof.claims.v_region, proof.claims.everywhere),
        "stationarity": max((one.stationarity for one in solution.optima), default=None),
        "solve_time_s": solution.solve_time_s,
    }


def study(seeds: int, birds: int, workers: int) -> list[dict[str, Any]]:
    """Solve all tasks; the rows are in the order of the tasks, whatever the number of workers."""
    solve_pair(IBIS, search=SearchSettings(starts=1, most_boxes=1))  # compiles what is not compiled yet
    return Parallel(n_jobs=workers)(delayed(solved)(task) for task in tasks(seeds, birds))


def report(rows: list[dict[str, Any]]) -> str:
    """Return the counts to read."""
    lines = []
    for objective in OBJECTIVES:
        of_seeds = [row for row in rows if (row["contest"], row["objective"]) == ("seeds", objective)]
        if of_seeds:
            lines += [f"ibis, {objective}: {len(of_seeds)} seeds", *seed_counts(of_seeds)]
    of_birds = [row for row in rows if row["contest"] == "birds"]
    for follows in ("lone", "flock"):
        some = [row for row in of_birds if row["follows"] == follows]
        if some:
            lines += [f"random birds behind a {follows} bird: {len(some)}", *bird_counts(some)]
    return "\n".join(lines)


def seed_counts(rows: list[dict[str, Any]]) -> list[str]:
    """Count the seeds of one objective that found what any found, and those that proved it."""
    lines = []
    for name, column in (("global optimum", "global_cost"), ("V optimum", "v_cost")):
        costs = np.array([np.nan if row[column] is None else row[column] for row in rows])
        least = np.nanmin(costs)
        has_found = costs <= least * (1.0 + SAME_COST)
        spread = np.max(costs[has_found]) / least - 1.0
        lines.append(f"  {name:16} found by {has_found.sum()}, costs within {spread:.1e}")
    for words, column in (("optima", "optima"), ("within 1 %", "optima_near_best")):
        counts = np.array([row[column] for row in rows])
        lines.append(
            f"  {words:16} {counts.min()} to {counts.max()}; {counts.max()} in {(counts == counts.max()).sum()}"
        )
    return [*lines, *closure(rows)]


def bird_counts(rows: list[dict[str, Any]]) -> list[str]:
    """Count the birds of each outcome, and name those whose proof stayed open."""
    infeasible = sum(row["status"] == "infeasible" for row in rows)
    has_v = sum(row["v_cost"] is not None for row in rows)
    lines = [f"  with a V optimum {has_v}, without a feasible follower {infeasible}", *closure(rows)]
    for row in rows:
        if not row["is_closed"]:
            groups = ", ".join(f"{name} {row[name]:.4g}" for name in GROUPS)
            lines.append(
                f"  open: {row['objective']}, {groups}; gaps {row['global_gap']}, {row['v_gap']}; "
                f"{row['boxes']} boxes"
            )
    return lines


def closure(rows: list[dict[str, Any]]) -> list[str]:
    """Return how many proofs are closed, what they took, and how stationary the optima are."""
    closed = sum(row["is_closed"] for row in rows)
    boxes = np.array([row["boxes"] for row in rows])
    times = np.array([row["solve_time_s"] for row in rows])
    stationarity = max((row["stationarity"] for row in rows if row["stationarity"] is not None), default=0.0)
    return [
        f"  both proofs      closed to {TOLERANCE:g} in {closed} of {len(rows)}",
        f"  boxes            median {np.median(boxes):.0f}, most {boxes.max()}",
        f"  time a job       median {np.median(times):.2f} s, most {times.max():.2f} s",
        f"  stationarity     at most {stationarity:.1e}",
    ]
