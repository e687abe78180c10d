"""Flocks: each bird flies where it flies best behind the one that it follows.

A flock is built bird by bird, from the front: each follower solves the pair's problem behind birds whose
place and stroke are settled, and takes its V optimum.  Birds are like the first one, or each of its own kind; in step
all beat in the first one's period.  A follower without a V optimum ends the flock.

The paper bounds a follower's amplitude by h_L in a sentence that can be read in two ways: as that of the bird
ahead (`immediate`) or as that of a lone bird (`lone`).  The two give different flocks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any

from upwash.aero.bird import Bird
from upwash.aero.checked import one_of
from upwash.aero.pose import Pose
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.together import in_step
from upwash.aero.wake import WakeModel
from upwash.optimum.cut_problem import ending_problems
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.endless.solve import solve_endless_pair
from upwash.optimum.flock_solution import FlockSolution, Member, on_side
from upwash.optimum.flock_wake import FlockProblem, Place, amplitude_limit, flock_problems
from upwash.optimum.pieces import solve_pieces
from upwash.optimum.problem import PairProblem
from upwash.optimum.proof import Proof, wall_in_words
from upwash.optimum.settings import BIRDS, FlockRules, SearchSettings
from upwash.optimum.solution import PairSolution
from upwash.optimum.solvable import adds_up, need_solvable
from upwash.optimum.spacing import FREE, Spacing

LINKS_KEPT = 1024
"""Solved links that are kept in memory: flocks of other sizes and shapes have many in common."""


def solve_flock(
    bird: Bird,
    birds: int = 6,
    objective: str = "force",
    *,
    rules: FlockRules | None = None,
    model: WakeModel | None = None,
    search: SearchSettings | None = None,
    distance_m: float | None = None,
    members: Sequence[Bird] = (),
    phase_lock: bool = True,
    spacing: Spacing | None = None,
) -> FlockSolution:
    """Build a flock, each follower at its V optimum behind the birds that are settled.

    Parameters
    ----------
    bird : Bird
        The first bird.
    birds : int
        Birds in the flock, the first one included; has no say where there are members.
    objective : str
        Name of a cost function, least for each follower in turn.
    rules : FlockRules, optional
        Shape of the flock, whose wakes a bird feels, and whose amplitude bounds a follower's.
    model : WakeModel, optional
        How the wakes are resolved: as for `upwash.solve_pair`; those of all birds ahead are felt only if they end and
        are felt in points by birds that are held in two states.
    search : SearchSettings, optional
        How long to search, and how closely to prove.
    distance_m : float, optional
        How far behind the one ahead each bird is said to fly where wakes are endless; half a wavelength if not given.
    members : sequence of Bird
        The birds behind the first, front to back, at its speed and in its air; all like it if there are none.
    phase_lock : bool
        Whether all beat in step, in the first bird's period; else each keeps its own, and wakes are averaged over all
        phases.
    spacing : Spacing, optional
        What each bird keeps to of the one that it follows.

    Returns
    -------
    FlockSolution
        The birds, up to and including the first that has no place.

    Raises
    ------
    ValueError
        If a choice is unknown or an input out of range; the message names it.

    Examples
    --------
    >>> from upwash import load_species
    >>> flock = solve_flock(load_species("northern-bald-ibis").bird(), 3, "power")
    >>> [round(row["saving_total"], 2) for row in flock.rows()]
    [0.0, 0.17, 0.18]
    """
    one_of(COST_FUNCTIONS)("objective", objective)
    BIRDS("birds", 1 + len(members) if members else birds)
    kinds = (bird, *members) if members else (bird,) * birds
    rules, model, search = rules or FlockRules(), model or WakeModel(), search or SearchSettings()
    need_solvable(model, rules)
    placed = [Member(1, 0, Place(0, Pose(0.0, 0.0, 0.0, bird.stroke, 0.0), bird))]
    while len(placed) < len(kinds) and placed[-1].place is not None:
        number = len(placed) + 1
        own, ahead = kinds[number - 1], _felt(placed, number, rules)
        problems = link_problems(own, objective, ahead, rules, model, distance_m, phase_lock, spacing or FREE)
        flown = in_step(own, bird, phase_lock)
        placed.append(_settle(number, rules, ahead[-1], _solve_link(problems, search), flown))
    return FlockSolution(kinds, objective, rules, model, tuple(placed), phase_lock)


def _felt(members: list[Member], number: int, rules: FlockRules) -> tuple[Place, ...]:
    """Return the birds whose wakes a bird feels, its leader last; mirrored for one that flies to the left."""
    ahead = [members[one - 1].place for one in rules.felt_by(number)]
    if rules.side_of(number) < 0.0:
        return tuple(place.mirrored() for place in ahead if place)
    return tuple(place for place in ahead if place)


def link_problems(
    bird: Bird,
    objective: str,
    ahead: tuple[Place, ...],
    rules: FlockRules,
    model: WakeModel,
    distance_m: float | None = None,
    phase_lock: bool = True,
    spacing: Spacing = FREE,
) -> tuple[PairProblem, ...]:
    """Pose a follower's problem behind birds that are settled, in one piece of phase or several.

    Parameters
    ----------
    bird : Bird
        The follower.
    objective, model, distance_m, phase_lock, spacing
        As for `solve_flock`.
    ahead : tuple of Place
        Every bird whose wake is felt, the one that is followed last; if there is one, its place does not matter.
    rules : FlockRules
        Whose amplitude bounds a follower's.

    Returns
    -------
    tuple of PairProblem
        The problem of the pair where it is that.
    """
    stroke, leader = ahead[-1].pose.stroke, ahead[-1].bird or bird
    limit = amplitude_limit(bird, stroke, leader, rules)
    if len(ahead) == 1:
        pair: dict[str, Any] = {"leader": leader, "phase_lock": phase_lock, "spacing": spacing}
        if model.is_endless:
            return (EndlessProblem(bird, objective, stroke, limit, model, **pair, distance_m=distance_m),)
        if model.wavelengths == 1 or not adds_up(model):
            return tuple(ending_problems(bird, objective, stroke, limit, model, **pair))
        ahead = (Place(0, Pose(0.0, 0.0, 0.0, stroke, 0.0), leader),)
    return tuple(flock_problems(bird, objective, ahead, limit, model, phase_lock, spacing))


@lru_cache(LINKS_KEPT)
def _solve_link(problems: tuple[PairProblem, ...], search: SearchSettings) -> PairSolution:
    if isinstance(problems[0], EndlessProblem):
        return solve_endless_pair(problems[0], search)
    return solve_pieces(problems, search, proves_all=not isinstance(problems[0], FlockProblem))


def _settle(number: int, rules: FlockRules, followed: Place, solution: PairSolution, flown: Bird) -> Member:
    """Give a bird its place: the V optimum, on its side of the bird it follows; `flown` is the bird as it beats."""
    best, leader, side = solution.v_optimum, rules.leader_of(number), rules.side_of(number)
    if best is None:
        error = why_none(leader, solution.proof)
        return Member(number, leader, None, None, solution.proof, solution.solve_time_s, error)
    place = Place(followed.row + 1, best.pose.behind(followed.pose), flown)
    if side < 0.0:
        place = place.mirrored()
    return Member(number, leader, place, on_side(best, side), solution.proof, solution.solve_time_s)


def why_none(leader: int, proof: Proof) -> str:
    """Say why a bird that was to follow `leader` has no V optimum, in one line, by the proof of its problem."""
    if not proof.feasible:
        is_proved = proof.global_lower_bound is not None and math.isinf(proof.global_lower_bound)
        found = "a proof that there is none" if is_proved else "none"
        return (
            f"no balance: expected a place behind bird {leader} where lift and thrust balance, found {found}"
        )
    expected = f"no V optimum: expected one outboard, level and astern of bird {leader}"
    if proof.v_wall:
        return f"{expected}, found the best such place {wall_in_words(proof.v_wall)}, and better ones beyond"
    if math.isinf(proof.v_lower_bound):
        return f"{expected}, found a proof that lift and thrust balance at no such place"
    return f"{expected}, found none"
