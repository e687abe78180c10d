"""The follower's problem in scaled variables: what may vary, within which bounds, and what must balance.

Lengths are in the follower's semispans, forces in its weights, costs in its cost when it flies alone, so birds of any
mass pose the same problem.  The variables are (x, y, z, h, R, t): position of the follower relative to its leader, its
amplitude, its upstroke span ratio and the phase coordinate t.  With two stroke states t is μ = |κ − ½| and covers all
phases; with more, the problem is posed once for each piece of phase in which the weights are linear.

Two equalities, lift and thrust, hold at every solution; the cost depends on (h, R) alone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.lanes import PHASE, SLIDING, STEADY, Y
from upwash.aero.cut_wake import phase_pieces
from upwash.aero.interaction import mean_phase_weights, phase_piece
from upwash.aero.lanes import wake_lanes
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import (
    COST_FUNCTIONS,
    CostFunction,
    induced_power_w,
    parasite_power_w,
)
from upwash.aero.together import in_step, need_shared
from upwash.aero.wake import Wake, WakeModel, vortex_wake
from upwash.aero.wingbeat import wingbeat_steps
from upwash.optimum.compiled.boxes import clear_boxes
from upwash.optimum.compiled.problem import Constants
from upwash.optimum.spacing import FREE, Spacing
from upwash.optimum.variables import TABLE, Given, Variable, bounds_of


@dataclass(frozen=True)
class PairProblem:
    """One follower behind one leader.

    Parameters
    ----------
    bird : Bird
        The follower, as it flies alone: its weight, drag, circulation, span and what it costs.
    objective : str
        Name of a cost function in `upwash.aero.power.COST_FUNCTIONS`.
    ahead : Stroke, optional
        How the bird immediately ahead flaps; as that bird does alone if not given.
    amplitude_limit_m : float, optional
        Largest amplitude of the follower; if not given the share of its own that the bird ahead has of its own.
    model : WakeModel
        Resolution of the wake; its core is in semispans of the bird that sheds it.
    piece : int, optional
        Piece of phase, κ = piece/N + t.
    leader : Bird, optional
        The bird immediately ahead, which sheds the wake, as it flies alone but for its period; like the follower if
        not given.
    phase_lock : bool
        Whether the follower beats in step with its leader, in its period and at a phase of choice; else it keeps its
        own period, and the force is averaged over all phases.
    spacing : Spacing, optional
        What the follower keeps to.

    Raises
    ------
    ValueError
        If the objective is unknown or a value is out of range.
    """

    bird: Bird
    objective: str = "force"
    # None stands for the bird's own until __post_init__ puts it in.
    ahead: Stroke = None  # type: ignore[assignment]
    amplitude_limit_m: float = None  # type: ignore[assignment]
    model: WakeModel = field(default_factory=WakeModel)
    piece: int = 1
    leader: Bird = None  # type: ignore[assignment]
    phase_lock: bool = True
    spacing: Spacing = FREE

    distance_is_free: ClassVar[bool] = False

    lanes: NDArray[np.float64] = field(init=False, repr=False, compare=False)
    first_lanes: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    ring_of_lane: NDArray[np.int64] = field(init=False, repr=False, compare=False)
    constants: Constants = field(init=False, repr=False, compare=False)
    bounds: NDArray[np.float64] = field(init=False, repr=False, compare=False)
    wall_names: tuple[str, ...] = field(init=False, repr=False, compare=False)
    walls: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        bird = self.bird
        if self.objective not in COST_FUNCTIONS:
            raise ValueError(
                f"objective: expected one of {', '.join(sorted(COST_FUNCTIONS))}, found {self.objective!r}"
            )
        if self.leader is None:
            object.__setattr__(self, "leader", bird)
        need_shared(bird, self.leader)
        if self.ahead is None:
            object.__setattr__(self, "ahead", self.leader.stroke)
        if self.amplitude_limit_m is None:
            limit = self.ahead.amplitude_m * (bird.amplitude_m / self.leader.amplitude_m)
            object.__setattr__(self, "amplitude_limit_m", limit)
        # A bird's own rules hold for the bird ahead and for the limit.
        replace(self.leader, amplitude_m=self.ahead.amplitude_m, upstroke_span_ratio=self.ahead.span_ratio)
        replace(bird, amplitude_m=self.amplitude_limit_m)
        b, asked = bird.semispan_m, self.distance_asked_m
        if self.spacing.names:
            self.spacing.need_room(b, self.leader.wavelength_m, asked, self.leader.semispan_m)
        for name, value in zip(("wall_names", "walls"), self.spacing.walls(b, asked), strict=True):
            object.__setattr__(self, name, value)
        for name, value in self._lanes().items():
            object.__setattr__(self, name, value)
        object.__setattr__(self, "constants", self._constants())
        object.__setattr__(self, "bounds", self._bounds())

    def pieces(self) -> list[PairProblem]:
        """Return the problem in each piece of phase; one stands for all of two held states, or of their mean."""
        if not self.phase_lock or (self.model.stroke_states == 2 and self.model.stroke_rule == "held"):
            return [self]
        return [replace(self, piece=piece) for piece in range(len(phase_pieces(self.model)))]

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What may vary."""
        return TABLE

    @property
    def cost_function(self) -> CostFunction:
        """The cost function that `objective` names."""
        return COST_FUNCTIONS[self.objective]

    @property
    def leader_cost(self) -> float:
        """Cost of the follower when it flies alone, in its unit: the unit of cost in the scaled problem."""
        return self.cost_function.value(self.bird, self.bird.weight_n, self.bird.drag_n)

    @property
    def leader_height(self) -> float:
        """Amplitude of the bird ahead, in the follower's semispans."""
        return self.ahead.amplitude_m / self.bird.semispan_m

    @property
    def wavelength(self) -> float:
        """Wavelength of the wake, in the follower's semispans."""
        return self.leader.wavelength_m / self.bird.semispan_m

    def phase(self, coordinate: float) -> float:
        """Phase κ in [0, 1) at a phase coordinate; with two stroke states the lesser of the two equal ones."""
        if not self.phase_lock:
            return 0.0
        if self.is_mirrored_in_phase:
            return 0.5 - coordinate
        return (self.piece / self.model.stroke_states + coordinate) % 1.0

    def coordinate(self, phase: float) -> float:
        """Phase coordinate of a phase κ in [0, 1); outside 0 to `phase_span` if the phase is not in this piece."""
        if not self.phase_lock:
            return 0.0
        if self.is_mirrored_in_phase:
            return 0.5 - phase
        return least_turn(phase - self.piece / self.model.stroke_states)

    @property
    def distance_asked_m(self) -> float | None:
        """How far behind the follower flies, in m, where that is given; None where it is found."""
        return None

    @property
    def is_mirrored_in_phase(self) -> bool:
        """Whether the ends of the phase coordinate are planes of symmetry."""
        return self.phase_lock and self.model.stroke_states == 2 and self.piece == 1

    @property
    def phase_axis(self) -> tuple[int, float]:
        """The variable of the phase, and by how much it changes with the phase, all else but it being held."""
        return PHASE, -1.0 if self.is_mirrored_in_phase else 1.0

    def mirrors(self, variable: int, side: int) -> bool:
        """Whether a bound, the lower (0) or the upper (1), is a plane of symmetry: straight behind, or of the phase."""
        if variable == PHASE:
            return self.is_mirrored_in_phase
        return variable == Y and side == 0 and self.bounds[Y, 0] == 0.0

    def wake(self) -> Wake:
        """Vortex rings that the follower feels, in semispans; their states are the rows of `phase_ramp`."""
        return vortex_wake(
            self.leader_height,
            self.ahead.span_ratio,
            self.leader.semispan_m / self.bird.semispan_m,
            self.wavelength,
            self.leader.circulation_m2_s / self.bird.semispan_m,
            self.leader.circulation_ratio,
            self.model,
        )

    def phase_ramp(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Phase weights β₀ and β₁ of the wake's states (rows) and the follower's, linear in the coordinate."""
        if not self.phase_lock:
            mean = mean_phase_weights(self.model.stroke_states)
            return mean, np.zeros_like(mean)
        return phase_piece(self.piece, self.model.stroke_states)

    def phase_span(self) -> float:
        """Greatest phase coordinate."""
        return 1.0 / self.model.stroke_states if self.phase_lock else 0.0

    def clearing(self, bounds: NDArray[np.float64]) -> tuple[Any, tuple[Any, ...], float]:
        """Return the kernel that clears boxes, the wake as it takes it, and how far x of a box is below the bounds'."""
        return clear_boxes, (self.lanes, self.first_lanes), 0.0

    def ring_parts(self, ring: int) -> tuple[str, ...]:
        """Say of a ring of `wake` by which stroke and in which state it was shed."""
        wake = self.wake()
        stroke, state = "upstroke" if wake.is_upstroke[ring] else "downstroke", wake.state[ring]
        return stroke, ("up", "down")[state] if self.model.stroke_states == 2 else str(state)

    def pose(self, point: NDArray[np.float64]) -> Pose:
        """Pose, in SI units and relative to the bird ahead, of a point of the scaled problem."""
        x, y, z, amplitude, ratio, coordinate = (float(value) for value in point)
        b = self.bird.semispan_m
        return Pose(x * b, y * b, z * b, Stroke(amplitude * b, ratio), self.phase(coordinate))

    def others(self, pose: Pose) -> list[tuple[Stroke, Pose, Bird]]:
        """Of each bird other than the one ahead whose wake is felt: how it flaps, a pose relative to it, the bird."""
        return []

    def lanes_weighed(self, steady: NDArray[np.float64], sliding: NDArray[np.float64]) -> NDArray[np.float64]:
        """Lay out the lanes of `wake` with phase weights β₀ and β₁, as for `upwash.aero.lanes.wake_lanes`."""
        bird, states = self.bird, self.model.stroke_states
        unit = 2.0 * bird.density_kg_m3 * bird.semispan_m * bird.circulation_m2_s / bird.weight_n
        model = self.model.of_points()
        follower = unit * wingbeat_steps(model).circulation(bird.circulation_ratio)
        return wake_lanes(self.wake(), steady, sliding, follower, states, model.span_nodes, model.span_law)

    def _lanes(self) -> dict[str, NDArray[Any]]:
        """Return the lanes, where those of each of the follower's states begin, and the ring of each."""
        lanes, states = self.lanes_weighed(*self.phase_ramp()), self.model.stroke_states
        lane = np.arange(lanes.shape[1])
        # With many states most of them never meet in one piece of phase.
        is_felt = np.any(lanes[[STEADY, SLIDING]] != 0.0, axis=0) if states > 2 else lane >= 0
        begins = lane[:: lanes.shape[1] // states]
        return {
            "lanes": np.ascontiguousarray(lanes[:, is_felt]),
            "first_lanes": np.array([*(np.count_nonzero(is_felt[:k]) for k in begins), is_felt.sum()]),
            "ring_of_lane": lane[is_felt] % len(self.wake().circulation),
        }

    def _constants(self) -> Constants:
        bird, cost = self.bird, self.cost_function
        alone = bird.lift_span(bird.upstroke_span_ratio)
        flown = in_step(bird, self.leader, self.phase_lock)
        thrust_unit = 1.0 / (flown.wavelength_m / flown.semispan_m * alone)
        scale = 1.0 / (self.leader_cost * (bird.speed_m_s if cost.per_metre else 1.0))
        return Constants(
            lift_fixed=bird.lift_span(0.0) / alone,
            lift_ratio=(bird.lift_span(1.0) - bird.lift_span(0.0)) / alone,
            thrust_fixed=bird.thrust_span(0.0) * thrust_unit,
            thrust_ratio=(bird.thrust_span(1.0) - bird.thrust_span(0.0)) * thrust_unit,
            drag=bird.drag_n / bird.weight_n,
            cost_force=cost.force * bird.weight_n * scale,
            cost_lift2=cost.induced * induced_power_w(bird, bird.weight_n) * scale,
            cost_thrust=cost.profile * bird.speed_m_s * bird.weight_n * scale,
            cost_fixed=cost.parasite * parasite_power_w(bird) * scale,
        )

    def _bounds(self) -> NDArray[np.float64]:
        limit = self.amplitude_limit_m / self.bird.semispan_m
        widest = max(1.0, self.leader.semispan_m / self.bird.semispan_m)
        box = self.spacing.box(self.bird.semispan_m, self.distance_asked_m, self.leader.semispan_m)
        given = Given(self.wavelength, self.leader_height, limit, self.phase_span(), widest, box)
        return bounds_of(self.variables, given)

    def v_bounds(self) -> NDArray[np.float64]:
        """Bounds of the part of the problem that is outboard, level and astern, where a V optimum is sought.

        Returns
        -------
        (6, 2) ndarray of float
            As `bounds`; an empty range (lower above upper) means that the problem has no such part.
        """
        found = self.bounds.copy()
        found[0, 0] = max(found[0, 0], ASTERN)
        found[1, 0] = max(found[1, 0], OUTBOARD)
        level = LEVEL * self.bird.amplitude_m / self.bird.semispan_m
        found[2, 0], found[2, 1] = max(found[2, 0], -level), min(found[2, 1], level)
        return found


def least_turn(lag: float) -> float:
    """Return a lag in wingbeats as a number from 0 to 1; what is below 0 by rounding stays there."""
    return (lag + TURN_ROUNDING) % 1.0 - TURN_ROUNDING


TURN_ROUNDING = 1e-9
"""By how much a phase may lie before its piece, in wingbeats."""

ASTERN = 1.0
"""Least streamwise distance, in its own semispans, of a follower that its leader does not feel."""

OUTBOARD = 1.0
"""Least spanwise distance, in its own semispans, of a follower outboard of its leader."""

LEVEL = 0.5
"""Largest vertical distance, in amplitudes of its own when it flies alone, of a follower level with its leader."""
