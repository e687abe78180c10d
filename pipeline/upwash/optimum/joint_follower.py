"""One follower of a flock whose birds all move: its balance and core edges behind birds that fly elsewhere.

Its variables are those of the pair's problem, (x, y, z, h, R, t) relative to the bird that it follows.  What
the birds ahead do enters through the vortex rings of its lanes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from upwash.aero.lanes import core_edges, fill_rings
from upwash.aero.pose import Pose, Stroke
from upwash.optimum.compiled.pair_descent import FeltLanes
from upwash.optimum.compiled.problem import evaluate
from upwash.optimum.edges import NO_WALLS, distinct_edges, edge_distances
from upwash.optimum.flock_solution import FlockSolution
from upwash.optimum.flock_wake import FlockProblem, Place, amplitude_limit, flock_problems, superposed_wake
from upwash.optimum.variables import VARIABLE_COUNT

GENERIC = 1e-2
"""How far, in m, birds are moved about to tell edges that always coincide from edges that happen to."""

X, Z, AMPLITUDE, PHASE = 0, 2, 3, 5


class Follower:
    """One follower.

    Parameters
    ----------
    flock : FlockSolution
        The flock as it is; all of its birds have a place.
    number : int
        Number of the bird, at least 2.

    Attributes
    ----------
    leader : int
        Number of the bird that it follows.
    side : float
        Side of its leader on which it flies, 1 right and −1 left.
    felt : list of int
        Birds whose wakes it feels, its leader last.
    acting : list of tuple
        Variables of other followers on which its balance depends, as (bird, variable).
    problem : FlockProblem
        Its problem behind the birds as they are.
    start : (6,) ndarray of float
        Its variables as they are.
    group, representative : ndarray of int
        Its core edges, see `upwash.optimum.edges.distinct_edges`.
    """

    def __init__(self, flock: FlockSolution, number: int) -> None:
        self.flock, self.number = flock, number
        self.leader, self.side = flock.rules.leader_of(number), flock.rules.side_of(number)
        self.felt = flock.rules.felt_by(number)
        # A single wake is felt alike wherever the leader is; among several their distances matter too.
        first = AMPLITUDE if len(self.felt) == 1 else X
        self.acting = [(one, variable) for one in self.felt if one > 1 for variable in range(first, PHASE)]
        places = [one.place for one in flock.placed if one.place is not None]
        own = places[number - 1].pose.relative_to(places[self.leader - 1].pose)
        self.problem, coordinate = self.pose(places, own.phase % 1.0)
        b = flock.bird.semispan_m
        self.start = np.array(
            [
                own.x_m / b,
                self.side * own.y_m / b,
                own.z_m / b,
                own.stroke.amplitude_m / b,
                own.stroke.span_ratio,
                coordinate,
            ]
        )
        # At an optimum edges may happen to coincide; those of birds in general position always do.
        moved = [_moved(place, k) for k, place in enumerate(places)]
        self.group, self.representative = distinct_edges(self.lanes(moved), self.problem.bounds)

    def place(self, variables: NDArray[np.float64], places: Sequence[Place]) -> Place:
        """Return where and how it flies behind birds at their places."""
        followed, own = places[self.leader - 1], self.problem.pose(variables)
        return Place(followed.row + 1, (own if self.side > 0.0 else own.mirrored()).behind(followed.pose))

    def ahead(self, places: Sequence[Place]) -> tuple[Place, ...]:
        """Return the birds whose wakes it feels, mirrored if it flies to the left."""
        felt = (places[one - 1] for one in self.felt)
        return tuple(one if self.side > 0.0 else one.mirrored() for one in felt)

    def pose(self, places: Sequence[Place], phase: float) -> tuple[FlockProblem, float]:
        """Pose its problem behind birds at their places, in the piece that holds a phase.

        Returns
        -------
        problem : FlockProblem
            The piece.
        coordinate : float
            The phase's coordinate in it.
        """
        flock = self.flock
        ahead = places[self.leader - 1].pose.stroke
        limit = amplitude_limit(flock.bird, ahead, flock.bird, flock.rules)
        pieces = flock_problems(flock.bird, flock.objective, self.ahead(places), limit, flock.model)
        if len(pieces) == 1:
            return pieces[0], abs(phase - 0.5)
        for piece in pieces:
            coordinate = (phase - piece.phase_start) % 1.0
            if coordinate <= piece.phase_span():
                return piece, coordinate
        # Rounding can leave a phase a hair before the first piece.
        return pieces[0], 0.0

    def lanes(self, places: Sequence[Place]) -> NDArray[np.float64]:
        """Return its lanes behind birds at their places."""
        lanes = self.problem.lanes.copy()
        fill_rings(lanes, superposed_wake(self.flock.bird, self.ahead(places), self.flock.model))
        return lanes

    def balance(
        self, variables: NDArray[np.float64], lanes: NDArray[np.float64], sides: NDArray[np.float64] | None
    ) -> tuple[float, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return cost, residual and their slopes by its own variables.

        Parameters
        ----------
        variables : (6,) ndarray of float
            Its variables.
        lanes : ndarray of float
            From `lanes`.
        sides : (e,) ndarray of float or None
            For each core edge, 1 to take the node to lie inside and −1 outside; None to take it as it lies.
        """
        edges = core_edges(lanes)
        if sides is not None:
            edges = np.where(sides[self.group] > 0.0, np.inf, -1.0)
        residual, gradient, jacobian = np.empty(2), np.empty(VARIABLE_COUNT), np.empty((2, VARIABLE_COUNT))
        cost = evaluate(variables, lanes, edges, self.problem.constants, residual, gradient, jacobian)
        return cost, residual, gradient, jacobian

    def distances(
        self, variables: NDArray[np.float64], lanes: NDArray[np.float64], edges: NDArray[np.intp]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the distances to some core edges, negative inside, and their slopes by its own variables."""
        return edge_distances(FeltLanes(lanes, self.group, self.representative[edges], NO_WALLS), variables)


def _moved(place: Place, seed: int) -> Place:
    x, y, z, amplitude, ratio = np.random.default_rng(seed).uniform(0.0, GENERIC, 5)
    stroke = Stroke(place.pose.stroke.amplitude_m + amplitude, place.pose.stroke.span_ratio + ratio)
    return replace(place, pose=Pose(x, y, z, stroke, 0.0).behind(place.pose))
