"""All birds of a flock at once: what may vary, what must balance, and what the flock costs as a whole.

A bird's stroke shapes the wake that the birds behind it feel, so their balances depend on it.  The first bird
flies alone, and its own balance leaves it nothing to choose.

The problem is continuous and piecewise smooth, as the pair's is.  It is evaluated within one pattern of
sides, which states for every core edge whether the follower's node is taken to lie inside or outside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.flock_wake import Place
from upwash.optimum.joint_follower import AMPLITUDE, PHASE, Follower, Z
from upwash.optimum.variables import LEAST_AMPLITUDE, SCALE, VARIABLE_COUNT

STEP = 1e-6
"""Step of the central differences by what the birds ahead do, in scaled variables."""

Sides = list[NDArray[np.float64]]
"""For each follower, core edge by core edge: 1 if the node is taken to lie inside, −1 if outside."""

Edges = list[NDArray[np.intp]]
"""For each follower, numbers of core edges."""


@dataclass(frozen=True)
class Evaluation:
    """What a flock of n followers costs, how it balances, and how far it is from core edges.

    Slopes are by all variables, in units of `SCALE`.

    Attributes
    ----------
    costs : (n,) ndarray of float
        Cost of each follower over that of the lone bird.
    gradient : (6 n,) ndarray of float
        Slopes of their sum.
    residual, residual_slopes : (2 n,), (2 n, 6 n) ndarray of float
        Lift and thrust balance of each follower.
    distance, distance_slopes : (e,), (e, 6 n) ndarray of float
        Distances of the edges that were asked for, positive on the side that the pattern states.
    """

    costs: NDArray[np.float64]
    gradient: NDArray[np.float64]
    residual: NDArray[np.float64]
    residual_slopes: NDArray[np.float64]
    distance: NDArray[np.float64]
    distance_slopes: NDArray[np.float64]


class JointProblem:
    """A flock as one problem in the variables of all its followers.

    Parameters
    ----------
    flock : FlockSolution
        The flock as it is; all of its birds have a place.

    Attributes
    ----------
    followers : list of Follower
        Its n followers.
    start : (n, VARIABLE_COUNT) ndarray of float
        Their variables as they are.
    bounds : (n, 6, 2) ndarray of float
        Bounds.  Where a bird feels more than one wake, its phase is held as it is.
    coupling, least : (c, 6 n), (c,) ndarray of float
        Bounds that the stroke of the bird ahead sets: coupling · variables / SCALE ≥ least.
    """

    def __init__(self, flock: FlockSolution) -> None:
        self.flock = flock
        self.followers = [Follower(flock, number) for number in range(2, len(flock.placed) + 1)]
        self.start = np.array([one.start for one in self.followers])
        self.bounds = self._bounds()
        self.coupling, self.least = self._coupling()

    def places(self, variables: NDArray[np.float64]) -> list[Place]:
        """Return where and how every bird flies, the first one included."""
        first = self.flock.members[0].place
        assert first is not None
        places = [first]
        for follower, own in zip(self.followers, variables, strict=True):
            places.append(follower.place(own, places))
        return places

    def distances(self, variables: NDArray[np.float64]) -> list[NDArray[np.float64]]:
        """Return each follower's distance to each of its core edges, negative inside."""
        places = self.places(variables)
        return [
            one.distances(own, one.lanes(places), np.arange(len(one.representative)))[0]
            for one, own in zip(self.followers, variables, strict=True)
        ]

    def evaluate(
        self, variables: NDArray[np.float64], sides: Sides | None = None, near: Edges | None = None
    ) -> Evaluation:
        """Evaluate a flock, within a pattern of sides or, if none is given, as it is.

        Parameters
        ----------
        variables : (n, VARIABLE_COUNT) ndarray of float
            The followers' variables.
        sides : list of ndarray, optional
            The pattern.
        near : list of ndarray, optional
            Which core edges to report on.
        """
        places, n = self.places(variables), len(self.followers)
        costs, gradient = np.empty(n), np.zeros((n, VARIABLE_COUNT))
        residual, residual_slopes = np.empty((n, 2)), np.zeros((n, 2, n, VARIABLE_COUNT))
        distance, distance_slopes = [np.empty(0)], [np.empty((0, n, VARIABLE_COUNT))]
        moved = self._moved(variables)
        for k, (follower, own) in enumerate(zip(self.followers, variables, strict=True)):
            side = sides[k] if sides is not None else None
            edges = near[k] if near is not None else np.empty(0, dtype=np.intp)
            lanes = follower.lanes(places)
            costs[k], residual[k], gradient[k], residual_slopes[k, :, k] = follower.balance(own, lanes, side)
            found, by_own = follower.distances(own, lanes, edges)
            by_all = np.zeros((len(edges), n, VARIABLE_COUNT))
            by_all[:, k] = by_own
            for bird, variable in follower.acting:
                there = [follower.lanes(moved[bird, variable, step]) for step in (STEP, -STEP)]
                ahead, behind = (follower.balance(own, one, side)[1] for one in there)
                residual_slopes[k, :, bird - 2, variable] = (ahead - behind) / (2.0 * STEP)
                ahead, behind = (follower.distances(own, one, edges)[0] for one in there)
                by_all[:, bird - 2, variable] = (ahead - behind) / (2.0 * STEP)
            outward = -side[edges] if side is not None else -np.ones(len(edges))
            distance.append(outward * found)
            distance_slopes.append(outward[:, None, None] * by_all)
        return Evaluation(
            costs,
            (gradient * SCALE).ravel(),
            residual.ravel(),
            (residual_slopes * SCALE).reshape(2 * n, 6 * n),
            np.concatenate(distance),
            (np.concatenate(distance_slopes) * SCALE).reshape(-1, 6 * n),
        )

    def _moved(self, variables: NDArray[np.float64]) -> dict[tuple[int, int, float], list[Place]]:
        """Return the places of all birds with one variable of one of them moved."""
        found = {}
        for bird, variable in sorted({one for follower in self.followers for one in follower.acting}):
            for step in (STEP, -STEP):
                there = variables.copy()
                there[bird - 2, variable] += step
                found[bird, variable, step] = self.places(there)
        return found

    def _bounds(self) -> NDArray[np.float64]:
        found = np.stack([one.problem.bounds for one in self.followers])
        alone = self.flock.bird.amplitude_m / self.flock.bird.semispan_m
        # What the bird ahead limits is a coupling; here is the most that it can be.
        found[:, Z] = [-alone, alone]
        found[:, AMPLITUDE] = [LEAST_AMPLITUDE * alone if self.flock.rules.reading == "lone" else 0.0, alone]
        for k, follower in enumerate(self.followers):
            if len(follower.felt) > 1:
                found[k, PHASE] = self.start[k, PHASE]
        return found

    def _coupling(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return |z| ≤ h ahead and, in the immediate reading, ¼ h ahead ≤ h ≤ h ahead."""
        rows, least = [], []
        alone = self.flock.bird.amplitude_m / self.flock.bird.semispan_m
        terms = [(Z, 1.0, 1.0), (Z, -1.0, 1.0)]
        if self.flock.rules.reading == "immediate":
            terms += [(AMPLITUDE, -1.0, 1.0), (AMPLITUDE, 1.0, -LEAST_AMPLITUDE)]
        for k, follower in enumerate(self.followers):
            for variable, own, ahead in terms:
                row = np.zeros((len(self.followers), VARIABLE_COUNT))
                row[k, variable] = own
                if follower.leader > 1:
                    row[follower.leader - 2, AMPLITUDE] += ahead
                rows.append((row * SCALE).ravel())
                least.append(0.0 if follower.leader > 1 else -ahead * alone)
        return np.array(rows), np.array(least)
