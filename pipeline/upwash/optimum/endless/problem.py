"""The follower's problem behind an endless wake, in scaled variables.

The variables are (X, y, z, h, R): X = λΦ is the place in the frozen wake, with Φ = x/λ − κ the spatial phase, and takes
the place of the distance x and of the phase κ, which the force feels through it alone.  A sixth, without meaning and
without a range, keeps the arrays as wide as those of a pair behind a wake that ends.  Where the force is averaged over
all phases X has no range either.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from upwash.aero.checked import REACH
from upwash.aero.compiled.endless import LEAST_PHASE, EndlessWake
from upwash.aero.compiled.lanes import ROWS, X
from upwash.aero.endless import endless_wake_of
from upwash.aero.pose import Pose, Stroke
from upwash.optimum.compiled.endless_descent import FeltEndless
from upwash.optimum.compiled.endless_enclosure import EndlessEnclosure
from upwash.optimum.endless.bounds import edge_stations, endless_enclosure
from upwash.optimum.problem import ASTERN, PairProblem
from upwash.optimum.variables import AVERAGED_TABLE, ENDLESS_TABLE, Variable

DISTANCE = 0.5
"""How far behind the leader the follower is said to fly if nothing else is asked for, in wavelengths."""


@dataclass(frozen=True)
class EndlessProblem(PairProblem):
    """One follower behind one leader whose wake is endless.

    Parameters
    ----------
    bird, objective, ahead, amplitude_limit_m, model, piece, leader, phase_lock
        As for `PairProblem`; the model's wake is endless and its span exact, and there is one piece.
    distance_m : float, optional
        How far behind the leader the follower is said to fly, which changes nothing but the phase that goes with it:
        half a wavelength if not given.

    Raises
    ------
    ValueError
        If a value is out of range, or the model's span is told in points.
    """

    distance_is_free: ClassVar[bool] = True

    distance_m: float | None = None

    wake_felt: EndlessWake = field(init=False, repr=False, compare=False)
    enclosure: EndlessEnclosure = field(init=False, repr=False, compare=False)
    stations: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not (self.model.is_endless and self.model.span_nodes == "exact"):
            raise ValueError(
                "span_nodes: expected exact, as optima behind an endless wake are searched and proved, "
                f"found {self.model.span_nodes!r}"
            )
        super().__post_init__()
        if self.distance_m is not None:
            REACH("distance_m", self.distance_m)
        else:
            object.__setattr__(self, "distance_m", DISTANCE * self.leader.wavelength_m)
        object.__setattr__(self, "wake_felt", self._wake_felt())
        object.__setattr__(self, "enclosure", endless_enclosure(self.wake_felt))
        object.__setattr__(self, "stations", edge_stations(self.wake_felt))

    @property
    def variables(self) -> tuple[Variable, ...]:
        """What may vary."""
        return ENDLESS_TABLE if self.phase_lock else AVERAGED_TABLE

    @property
    def felt(self) -> FeltEndless:
        """The wake as the local solve takes it."""
        return FeltEndless(self.wake_felt, self.stations, self.walls)

    @property
    def is_symmetric(self) -> bool:
        """Whether (Φ, z) and (−Φ, −z) are alike: the follower is as long on its way up as down, and held as evenly."""
        return self.model.span_law == "stroke" and self.model.stroke_rule == "gauss"

    @property
    def distance_asked_m(self) -> float | None:
        """How far behind the follower flies, in m."""
        # The leader is known before the distance is put in.
        return DISTANCE * self.leader.wavelength_m if self.distance_m is None else self.distance_m

    @property
    def is_mirrored_in_phase(self) -> bool:
        """Whether the phase has ends that are planes of symmetry; it has none."""
        return False

    @property
    def phase_axis(self) -> tuple[int, float]:
        """The variable of the phase, and by how much it changes with the phase at the same distance."""
        return X, -self.wavelength

    def spatial_phase(self, point: NDArray[np.float64]) -> float:
        """Spatial phase Φ of a point, in (−½, ½]."""
        phase = float(point[0]) / self.wavelength
        return phase - float(np.ceil(phase - 0.5))

    def pose(self, point: NDArray[np.float64]) -> Pose:
        """Pose, in SI units and relative to the bird ahead, of a point, at the distance asked for."""
        _, y, z, amplitude, ratio, _ = (float(value) for value in point)
        assert self.distance_m is not None
        b = self.bird.semispan_m
        phase = (self.distance_m / self.leader.wavelength_m - self.spatial_phase(point)) % 1.0
        if not self.phase_lock:
            phase = 0.0
        return Pose(self.distance_m, y * b, z * b, Stroke(amplitude * b, ratio), phase)

    def point(self, pose: Pose) -> NDArray[np.float64]:
        """Return a pose in scaled variables."""
        b = self.bird.semispan_m
        phase = pose.spatial_phase(self.leader.wavelength_m) if self.phase_lock else 0.0
        place = phase * self.wavelength
        stroke = pose.stroke
        return self.wrapped(
            np.array([place, pose.y_m / b, pose.z_m / b, stroke.amplitude_m / b, stroke.span_ratio, 0.0])
        )

    def wrapped(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return a point whose X lies in the bounds, as it may be moved by whole wavelengths."""
        found = point.copy()
        found[0] -= self.wavelength * np.floor(point[0] / self.wavelength - LEAST_PHASE)
        return found

    def proof_bounds(self, bounds: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the part of some bounds that stands for all of them by symmetry."""
        found = bounds.copy()
        if self.phase_lock and self.is_symmetric and bounds[2, 0] == -bounds[2, 1]:
            found[0] = 0.0, 0.5 * self.wavelength
        return found

    def v_bounds(self) -> NDArray[np.float64]:
        """Bounds of the part that is outboard and level; empty if the distance asked for is not astern."""
        found = super().v_bounds()
        assert self.distance_m is not None
        astern = self.distance_m >= ASTERN * self.bird.semispan_m
        found[0] = self.bounds[0] if astern else (1.0, -1.0)
        return found

    def _lanes(self) -> dict[str, NDArray[Any]]:
        return {"lanes": np.empty((ROWS, 0))}

    def _wake_felt(self) -> EndlessWake:
        lock = self.phase_lock
        return endless_wake_of(
            self.bird, self.ahead, self.model, self.bird.weight_n, leader=self.leader, phase_lock=lock
        )
