"""Flocks: each bird flies where it flies best behind the one that it follows.

A flock is built bird by bird, from the front: each follower solves the pair's problem behind birds whose
place and stroke are settled, and takes its V optimum.  Weight, drag and circulation are those of the first
bird for all.  A follower without a V optimum ends the flock.

The paper bounds a follower's amplitude by h_L in a sentence that can be read in two ways: as that of the bird
ahead (`immediate`) or as that of a lone bird (`lone`).  The two give different flocks.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import lru_cache

from upwash.aero.bird import Bird
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.optimum.flock_solution import FlockSolution, Member, on_side
from upwash.optimum.flock_wake import Place, flock_problems
from upwash.optimum.pair import solve_pair
from upwash.optimum.pieces import solve_pieces
from upwash.optimum.solution import PairSolution

SHAPES = ("echelon", "vee", "alternating")
"""One line to the right; two lines from one leader; one line that turns to the other side at each bird."""

WAKES = ("neighbour", "all-upstream")
"""Whose wakes a bird feels: that of the bird it follows, or of every bird in a row ahead."""

READINGS = ("immediate", "lone")
"""Whose amplitude bounds a follower's: that of the bird it follows, or of a bird flying alone."""

LINKS_KEPT = 1024
"""Solved links that are kept in memory: flocks of other sizes and shapes have many in common."""


def solve_flock(
    bird: Bird,
    birds: int = 6,
    objective: str = "force",
    *,
    reading: str = "immediate",
    shape: str = "echelon",
    wake: str = "neighbour",
    wavelengths: int = 1,
    model: WakeModel | None = None,
    seed: int = 0,
    tolerance: float = 1e-4,
) -> FlockSolution:
    """Build a flock, each follower at its V optimum behind the birds that are settled.

    Parameters
    ----------
    bird : Bird
        The first bird.
    birds : int
        Birds in the flock, the first one included.
    objective : str
        Name of a cost function, least for each follower in turn.
    reading : str
        Whose amplitude bounds a follower's, one of `READINGS`.
    shape : str
        One of `SHAPES`.
    wake : str
        Whose wakes a bird feels, one of `WAKES`.
    wavelengths : int
        Length of each wake; the paper's is 1.
    model : WakeModel, optional
        Resolution of the wakes; must have two stroke states.
    seed : int
        Seed of the searches.
    tolerance : float
        Gap to which each V optimum is to be proved.

    Returns
    -------
    FlockSolution
        The birds, up to and including the first that has no place.

    Raises
    ------
    ValueError
        If a choice is unknown or an input out of range; the message names it.
    """
    for name, value, known in (
        ("reading", reading, READINGS),
        ("shape", shape, SHAPES),
        ("wake", wake, WAKES),
        ("objective", objective, tuple(COST_FUNCTIONS)),
    ):
        if value not in known:
            raise ValueError(f"{name}: expected one of {', '.join(known)}, found {value!r}")
    for name, number, least in (("birds", birds, 2), ("wavelengths", wavelengths, 1)):
        if isinstance(number, bool) or not isinstance(number, int) or number < least:
            raise ValueError(f"{name}: expected a whole number of at least {least}, found {number!r}")
    first = Place(0, 0.0, 0.0, 0.0, bird.amplitude_m, bird.upstroke_span_ratio, 0.0)
    members = [Member(1, 0, first)]
    model = model or WakeModel()
    while len(members) < birds and members[-1].place is not None:
        number = len(members) + 1
        leader, side = leader_of(number, shape), side_of(number, shape)
        ahead = _felt(members, number, shape, wake)
        limit = (first if reading == "lone" else ahead[-1]).amplitude_m
        solution = _solve_link(bird, objective, ahead, wavelengths, limit, model, seed, tolerance)
        members.append(_settle(number, leader, ahead[-1], side, solution))
    return FlockSolution(bird, objective, reading, shape, wake, wavelengths, model, tuple(members))


def leader_of(number: int, shape: str) -> int:
    """Return the number of the bird that a bird follows."""
    return max(1, number - 2) if shape == "vee" else number - 1


def side_of(number: int, shape: str) -> float:
    """Return the side of its leader on which a bird flies: 1 right, −1 left."""
    return -1.0 if shape != "echelon" and number % 2 else 1.0


def row_of(number: int, shape: str) -> int:
    """Return how many birds of its own line fly ahead of a bird."""
    return number // 2 if shape == "vee" else number - 1


def felt_by(number: int, shape: str, wake: str) -> list[int]:
    """Return the numbers of the birds whose wakes a bird feels, the one that it follows last.

    Of the others those on the bird's own side come before those on the other, so that the order mirrors as
    the birds do.
    """
    leader = leader_of(number, shape)
    if wake == "neighbour":
        return [leader]
    ahead = [one for one in range(1, number) if row_of(one, shape) < row_of(number, shape) and one != leader]
    return [*sorted(ahead, key=lambda one: (row_of(one, shape), (one - number) % 2)), leader]


def _felt(members: list[Member], number: int, shape: str, wake: str) -> tuple[Place, ...]:
    """Return the birds whose wakes a bird feels, its leader last; mirrored for one that flies to the left."""
    ahead = [members[one - 1].place for one in felt_by(number, shape, wake)]
    if side_of(number, shape) < 0.0:
        return tuple(place.mirrored() for place in ahead if place)
    return tuple(place for place in ahead if place)


def _solve_link(
    bird: Bird,
    objective: str,
    ahead: tuple[Place, ...],
    wavelengths: int,
    limit: float,
    model: WakeModel,
    seed: int,
    tolerance: float,
) -> PairSolution:
    """Solve a follower's problem; that of the pair where it is the pair's, whatever place the leader has."""
    if len(ahead) == 1:
        last = replace(ahead[0], row=0, x_m=0.0, y_m=0.0, z_m=0.0, phase=0.0)
        if wavelengths == 1:
            stroke = last.amplitude_m, last.upstroke_span_ratio
            return _pair_link(bird, objective, *stroke, limit, model, seed, tolerance)
        ahead = (last,)
    return _superposed_link(bird, objective, ahead, wavelengths, limit, model, seed, tolerance)


@lru_cache(LINKS_KEPT)
def _pair_link(
    bird: Bird,
    objective: str,
    amplitude: float,
    span_ratio: float,
    limit: float,
    model: WakeModel,
    seed: int,
    tolerance: float,
) -> PairSolution:
    return solve_pair(
        bird,
        objective,
        leader_amplitude_m=amplitude,
        leader_upstroke_span_ratio=span_ratio,
        amplitude_limit_m=limit,
        model=model,
        seed=seed,
        tolerance=tolerance,
    )


@lru_cache(LINKS_KEPT)
def _superposed_link(
    bird: Bird,
    objective: str,
    ahead: tuple[Place, ...],
    wavelengths: int,
    limit: float,
    model: WakeModel,
    seed: int,
    tolerance: float,
) -> PairSolution:
    problems = flock_problems(
        ahead, wavelengths, bird=bird, objective=objective, amplitude_limit_m=limit, model=model
    )
    return solve_pieces(problems, seed=seed, tolerance=tolerance, proves_all=False)


def _settle(number: int, leader: int, followed: Place, side: float, solution: PairSolution) -> Member:
    """Give a bird its place: the V optimum, on its side of the bird it follows."""
    best = solution.v_optimum
    if best is None:
        error = _why_none(leader, solution)
        return Member(number, leader, None, None, solution.proof, solution.solve_time_s, error)
    place = Place(
        followed.row + 1,
        followed.x_m + best.x_m,
        followed.y_m + best.y_m,
        followed.z_m + best.z_m,
        best.amplitude_m,
        best.upstroke_span_ratio,
        (followed.phase + best.phase) % 1.0,
    )
    if side < 0.0:
        place = place.mirrored()
    return Member(number, leader, place, on_side(best, side), solution.proof, solution.solve_time_s)


def _why_none(leader: int, solution: PairSolution) -> str:
    """Say why a bird has no V optimum, in one line."""
    proof = solution.proof
    if not solution.optima:
        is_proved = proof.global_lower_bound is not None and math.isinf(proof.global_lower_bound)
        found = "a proof that there is none" if is_proved else "none"
        return (
            f"no balance: expected a place behind bird {leader} where lift and thrust balance, found {found}"
        )
    expected = f"no V optimum: expected one outboard, level and astern of bird {leader}"
    if proof.v_wall:
        return f"{expected}, found the best such place on the wall {proof.v_wall}, beyond which it is better"
    if math.isinf(proof.v_lower_bound):
        return f"{expected}, found a proof that lift and thrust balance at no such place"
    return f"{expected}, found none"
