"""A bird at a given place: the strokes with which it balances there, and what they cost.

A search chooses the place as well (`upwash.optimum`); here it is given, so two unknowns are left, amplitude and
upstroke span ratio, and two balances.  There may be none, one, or several solutions; all are found.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.endless import EndlessWake
from upwash.aero.compiled.exact_span import Core
from upwash.aero.compiled.lanes import ROWS
from upwash.aero.pose import Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.endless.problem import EndlessProblem
from upwash.optimum.problem import PairProblem
from upwash.place.choices import BOUNDS
from upwash.place.compiled import balances as compiled
from upwash.place.compiled.balances import MOST_BALANCES, StrokeBounds, find_balances
from upwash.place.compiled.felt import Felt, Room, make_room, settle

WIDE_AMPLITUDE = (0.01, 2.0)
"""In semispans; at the upper end the wings meet."""

WIDE_SPAN_RATIO = (0.05, 0.78)
"""From a wing all but folded to one that makes thrust no more."""

STEP_IN_CORES = 0.5
"""Longest step in amplitude at which balances are looked for, in core radii; tips move half as far."""

THIN_CORE, THIN_CORE_ON_SPAN = 0.1, 0.01
"""Core radii, in semispans, below which a wake may let lift fall where the span ratio rises: of one felt in points, in
whose core the velocity's slope rises with the inverse square of the radius, and of one felt on the whole span."""

MISSING = {
    compiled.LACKS_LIFT: "lift",
    compiled.EXCESS_LIFT: "less lift",
    compiled.LACKS_THRUST: "thrust",
    compiled.EXCESS_THRUST: "less thrust",
}
"""What a bird would need to balance where nothing does."""


@dataclass(frozen=True)
class Balance:
    """A stroke with which a bird balances.

    Attributes
    ----------
    stroke : Stroke
        How it flaps.
    cost : float
        Its cost over that of the lone bird.
    """

    stroke: Stroke
    cost: float


@dataclass(frozen=True)
class Balances:
    """What balances at a place.

    Attributes
    ----------
    strokes : tuple of Balance
        Every stroke that balances, the cheapest first.
    missing : str
        What a bird would need where nothing balances: ``lift``, ``thrust``, ``less lift`` or ``less thrust``; else "".
    missing_share : float
        How much of it, as a share of weight or drag, with the stroke that lacks least; 0 where something balances.
    """

    strokes: tuple[Balance, ...]
    missing: str
    missing_share: float


class Behind:
    """A follower behind one or more birds that all flap alike: what its place decides.

    Parameters
    ----------
    bird : Bird
        The follower, as it flies alone.
    objective : str
        Name of a cost function.
    ahead : Stroke, optional
        How the birds ahead flap; as they do alone if not given.
    model : WakeModel, optional
        The wake: one that ends and is felt in points by birds that are held in states, or an endless one that is felt
        on the whole span.
    bounds : str
        Within which the stroke is sought, one of `BOUNDS`.
    leader : Bird, optional
        The birds ahead; like the follower if not given.
    phase_lock : bool
        Whether all beat in step; else phases are averaged over, and a place has none (see `felt_places`).

    Raises
    ------
    ValueError
        If an input is out of range, or the model is of another kind.

    Examples
    --------
    >>> from upwash import load_species
    >>> ibis = Behind(load_species("northern-bald-ibis").bird(), "power")
    >>> found = ibis.balances([(1.2, 0.904, 0.0, 0.5)])
    >>> round(1.0 - found.strokes[0].cost, 3)
    0.003
    """

    def __init__(
        self,
        bird: Bird,
        objective: str = "power",
        ahead: Stroke | None = None,
        model: WakeModel | None = None,
        bounds: str = "wide",
        leader: Bird | None = None,
        phase_lock: bool = True,
    ) -> None:
        if bounds not in BOUNDS:
            raise ValueError(f"bounds: expected one of {', '.join(BOUNDS)}, found {bounds!r}")
        model = model or WakeModel()
        kind = EndlessProblem if model.is_endless else PairProblem

        def posed(objective: str) -> PairProblem:
            return kind(
                bird,
                objective,
                ahead,  # type: ignore[arg-type]
                model=model,
                leader=leader,  # type: ignore[arg-type]
                phase_lock=phase_lock,
            )

        problem = posed(objective)
        self.bird, self.objective, self.ahead, self.model = bird, objective, problem.ahead, model
        self.leader, self.phase_lock = problem.leader, phase_lock
        self.amplitude_limit_m, self.leader_cost = problem.amplitude_limit_m, problem.leader_cost
        power = problem if objective == "power" else posed("power")
        self.felt = felt_of(problem, power)
        self.bounds = _stroke_bounds(problem, bounds)
        self._rooms: dict[int, Room] = {}

    def balances(self, places: Sequence[tuple[float, float, float, float]]) -> Balances:
        """Return what balances at a place.

        Parameters
        ----------
        places : sequence of (x, y, z, phase)
            The place relative to each bird ahead, in m, and the lag behind it, in wingbeats.
        """
        found, missing = np.empty((MOST_BALANCES, 3)), np.empty(2)
        room = self.room(len(places))
        settle(self.felt_places(self.scaled(places)), self.felt, room)
        count = find_balances(self.bounds, self.felt, room, found, missing)
        b = self.bird.semispan_m
        strokes = tuple(Balance(Stroke(h * b, ratio), cost) for h, ratio, cost in found[:count].tolist())
        return Balances(strokes, MISSING.get(int(missing[0]), ""), float(missing[1]))

    def felt_places(self, places: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return places (x, y, z, phase) as they are felt: where phases are averaged, at none and at no distance."""
        if self.phase_lock:
            return places
        found = places.copy()
        found[:, 3] = 0.0
        if self.model.is_endless:
            found[:, 0] = 0.0
        return found

    def scaled(self, places: Sequence[tuple[float, float, float, float]]) -> NDArray[np.float64]:
        """Return places in semispans."""
        b = self.bird.semispan_m
        return np.array(places, dtype=float).reshape(-1, 4) / [b, b, b, 1.0]

    def room(self, birds_ahead: int) -> Room:
        """Return scratch for places behind so many birds, the same at each call."""
        if birds_ahead not in self._rooms:
            self._rooms[birds_ahead] = make_room(self.felt, birds_ahead)
        return self._rooms[birds_ahead]


def felt_of(problem: PairProblem, power: PairProblem) -> Felt:
    """Return what a follower feels, from the problem that searches its place as well, and that of least power."""
    if isinstance(problem, EndlessProblem):
        wake, lanes, states = problem.wake_felt, np.empty((ROWS, 0)), np.empty((2, 0), np.int64)
    else:
        wake, (lanes, states) = _NO_WAKE, _lanes_of(problem)
    return Felt(
        problem.model.is_endless,
        problem.wavelength,
        problem.constants,
        power.constants,
        lanes,
        states,
        problem.model.stroke_states if problem.phase_lock else 1,
        wake,
    )


_NO_WAKE = EndlessWake(
    1.0, Core(1.0, 0.0, 1.0), np.empty((2, 9, 0)), np.empty((2, 8, 0)), np.empty((5, 0)), 0
)


def _lanes_of(problem: PairProblem) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return lanes of whole strength, and the states of the bird ahead and of the follower in each."""
    count = problem.model.stroke_states
    if not problem.phase_lock:
        # Every two states last together for the same share of time: as one state that lasts for all of it.
        return problem.lanes, np.zeros((2, problem.lanes.shape[1]), np.int64)
    lanes = problem.lanes_weighed(np.ones((count, count)), np.zeros((count, count)))
    ahead = problem.wake().state
    per_state = lanes.shape[1] // count
    follower = np.repeat(np.arange(count), per_state)
    return lanes, np.array([np.resize(ahead, lanes.shape[1]), follower], np.int64)


def _stroke_bounds(problem: PairProblem, bounds: str) -> StrokeBounds:
    core = problem.model.core_radius_ratio * (problem.leader.semispan_m / problem.bird.semispan_m)
    thin = THIN_CORE_ON_SPAN if problem.model.is_endless else THIN_CORE
    ranges = *WIDE_AMPLITUDE, *WIDE_SPAN_RATIO
    if bounds == "paper":
        ranges = *problem.bounds[3].tolist(), *problem.bounds[4].tolist()
    return StrokeBounds(*ranges, STEP_IN_CORES * core, core < thin)
