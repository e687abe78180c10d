"""The follower's problem behind a wake that ends and is felt on the whole span, in scaled variables.

The variables are those of a pair whose wake is felt in points.  The problem is posed once for each piece of phase,
see `upwash.aero.cut_wake.phase_pieces`; of two held states one piece stands for all phases.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled import cut_wake as force
from upwash.aero.compiled import exact_span as span
from upwash.aero.compiled.cut_wake import AT_END, AT_LEADER, CutWake
from upwash.aero.compiled.lanes import ROWS
from upwash.aero.cut_wake import Piece, cut_wake, phase_pieces
from upwash.aero.pose import Stroke
from upwash.aero.wake import WakeModel
from upwash.optimum.compiled import cut_edges as edges
from upwash.optimum.compiled import endless_enclosure as bounds
from upwash.optimum.compiled.cut_boxes import CutEnclosure, clear_cut_boxes
from upwash.optimum.compiled.cut_descent import FeltCutWake
from upwash.optimum.core_edge import BOTH, TURN, CoreEdge
from upwash.optimum.endless.bounds import ROUNDING
from upwash.optimum.problem import PairProblem, least_turn
from upwash.optimum.spacing import FREE, Spacing

FAR_OFF = 1e6
"""Where a station lies that fills an array and is none, in semispans."""


@dataclass(frozen=True)
class CutProblem(PairProblem):
    """One follower behind one leader whose wake ends, felt on the follower's whole span.

    Parameters
    ----------
    bird, objective, ahead, amplitude_limit_m, model, leader, phase_lock, spacing
        As for `PairProblem`; the model's span is exact.
    piece : int
        Number of the piece of phase.
    """

    wake_felt: CutWake = field(init=False, repr=False, compare=False)
    felt: FeltCutWake = field(init=False, repr=False, compare=False)
    enclosure: CutEnclosure = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        super().__post_init__()
        phases = self.phases if self.phase_lock else None
        wake = cut_wake(self.bird, self.ahead, self.model, phases, self.bird.weight_n, leader=self.leader)
        object.__setattr__(self, "wake_felt", wake)
        object.__setattr__(self, "felt", FeltCutWake(wake, *_edges(wake), self.walls))
        object.__setattr__(self, "enclosure", _enclosure(wake, self.walls))

    @property
    def phases(self) -> Piece:
        """The piece of phase."""
        return phase_pieces(self.model)[self.piece]

    @property
    def is_mirrored_in_phase(self) -> bool:
        """Whether the ends of the phase coordinate are planes of symmetry: of two held states."""
        return super().is_mirrored_in_phase and self.model.stroke_rule == "held"

    def phase(self, coordinate: float) -> float:
        """Phase κ in [0, 1) at a phase coordinate; with two held states the lesser of the two equal ones."""
        if self.is_mirrored_in_phase or not self.phase_lock:
            return super().phase(coordinate)
        return (self.phases.start + coordinate) % 1.0

    def coordinate(self, phase: float) -> float:
        """Phase coordinate of a phase κ in [0, 1); outside 0 to `phase_span` if the phase is not in this piece."""
        if self.is_mirrored_in_phase or not self.phase_lock:
            return super().coordinate(phase)
        return least_turn(phase - self.phases.start)

    def phase_span(self) -> float:
        """Greatest phase coordinate."""
        return self.phases.span if self.phase_lock else 0.0

    def clearing(self, bounds: NDArray[np.float64]) -> tuple[Any, tuple[Any, ...], float]:
        """Return the kernel that clears boxes, the wake as it takes it, and how far x of a box is below the bounds'."""
        within = self.enclosure._replace(least_x=float(bounds[0, 0]), greatest_x=float(bounds[0, 1]))
        return clear_cut_boxes, (within,), self.wake_felt.drift * float(bounds[5, 1])

    def edge_named(self, edge: int) -> CoreEdge:
        """Name a core edge: how high the wing is on which stroke, and which spanwise filament of the wake it meets."""
        column = self.felt.stations[:, self.felt.edges[edge]]
        height, z = column[edges.HEIGHT], column[edges.STATION_Z]
        is_down = column[edges.ON_DOWNSTROKE] > 0.0
        state = f"{height:+.3g} {'down' if is_down else 'up'}"
        x = column[edges.STATION_X] / self.wavelength
        return CoreEdge(BOTH, state, TURN, "upstroke" if z > 0.0 else "downstroke", f"{x:+.3g}")

    def _lanes(self) -> dict[str, NDArray[Any]]:
        return {"lanes": np.empty((ROWS, 0))}


def ending_problems(
    bird: Bird,
    objective: str,
    ahead: Stroke | None,
    amplitude_limit_m: float | None,
    model: WakeModel,
    *,
    leader: Bird | None = None,
    phase_lock: bool = True,
    spacing: Spacing = FREE,
) -> list[PairProblem]:
    """Pose a pair's problem behind a wake that ends, in each piece of its phase, by how the span feels it.

    Parameters
    ----------
    bird, objective, ahead, amplitude_limit_m, model, leader, phase_lock, spacing
        As for `PairProblem`.
    """
    kind = PairProblem if isinstance(model.span_nodes, int) else CutProblem
    first = kind(
        bird,
        objective,
        ahead,  # type: ignore[arg-type]
        amplitude_limit_m,  # type: ignore[arg-type]
        model,
        leader=leader,  # type: ignore[arg-type]
        phase_lock=phase_lock,
        spacing=spacing,
    )
    return first.pieces()


def _stations(wake: CutWake) -> list[dict[tuple[float, ...], list[Any]]]:
    """Return what begins and ends at each station of each part.

    Each part -> station (x, z, and how they change with the phase coordinate) -> half-width and circulation of the run
    that begins there and of that which ends there.  A station that two parts of one wake share is the first one's.
    """
    found: list[dict[tuple[float, ...], list[Any]]] = []
    first_of: dict[tuple[float, ...], dict[tuple[float, ...], list[Any]]] = {}
    for part, (runs, cuts) in enumerate(zip(wake.runs, wake.cuts, strict=True)):
        own: dict[tuple[float, ...], list[Any]] = {}
        for number, run in enumerate(runs.T):
            if run[span.FIRST_X] == run[span.LAST_X] and number not in cuts:
                continue
            rise = run[span.ALONG_Z] / run[span.ALONG_X]
            for which, x, z in ((0, span.FIRST_X, span.FIRST_Z), (1, span.LAST_X, span.LAST_Z)):
                is_cut = number == cuts[(AT_LEADER, AT_END)[which]]
                carried = (0.0, -rise * wake.drift) if is_cut else (wake.drift, 0.0)
                key = (round(run[x], 9), round(run[z], 9), *(round(each, 9) for each in carried))
                place = first_of.setdefault((float(wake.whole[part]), *key), own)
                ends = place.setdefault(key, [run[x], run[z], *carried, 0.0, 0.0, 0.0, 0.0])
                ends[4 + 2 * which : 6 + 2 * which] = run[span.HALF_WIDTH], run[span.STRENGTH]
        found.append(own)
    return found


def _edges(wake: CutWake) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return the stations of all parts, those of one core edge side by side, and where each edge begins."""
    if wake.core.least == 0.0:
        return np.empty((edges.ROWS, 0)), np.zeros(1, np.int64)
    of_edge: dict[tuple[float, ...], list[list[float]]] = {}
    for part, stations in enumerate(_stations(wake)):
        column = wake.parts[:, part].tolist()
        for key, station in stations.items():
            of_edge.setdefault((round(column[force.HEIGHT], 12), *key), []).append([*station, *column])
    counts = [len(columns) for columns in of_edge.values()]
    laid = [column for columns in of_edge.values() for column in columns]
    return np.ascontiguousarray(np.array(laid).T), np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)


def _enclosure(wake: CutWake, walls: NDArray[np.float64]) -> CutEnclosure:
    """Lay out what encloses the force."""
    carried, cut = [], []
    for stations in _stations(wake):
        whole, sliding = [], {}
        for x, z, _, carried_z, *runs in stations.values():
            column = _meeting(x, z, *runs)
            if carried_z == 0.0:
                whole.append(column)
            else:
                # Of the two cuts the one at the leader is where a run begins.
                sliding[AT_LEADER if runs[0] > 0.0 else AT_END] = column
        carried.append(whole)
        cut.append([sliding.get(which, _nothing()) for which in (AT_LEADER, AT_END)])
    room = max(map(len, carried))
    filled = [[*columns, *([_nothing()] * (room - len(columns)))] for columns in carried]
    weights = np.abs(wake.parts[force.STEADY]) + np.abs(wake.parts[force.SLIDING])
    # Each run's terms are of the size of the logarithm of a ratio of lengths, or of a width over the core.
    size = float(np.sum(weights)) * float(np.max(wake.runs[:, span.STRENGTH])) * wake.runs.shape[2] * 20.0
    return CutEnclosure(
        wake,
        np.ascontiguousarray(np.array(filled).transpose(0, 2, 1)),
        np.ascontiguousarray(np.array(cut).transpose(0, 2, 1)),
        ROUNDING * size,
        -np.inf,
        np.inf,
        walls,
    )


def _meeting(x: float, z: float, *runs: float) -> list[float]:
    """Return a station's column: what of the spanwise filaments that meet there is left."""
    (narrow, weak), (wide, strong) = sorted([runs[:2], runs[2:]])
    # The shared circulation leaves two strips, the rest a whole filament.
    size = 2.0 * min(weak, strong) * (wide - narrow)
    size += 2.0 * abs(strong - weak) * (wide if strong > weak else narrow)
    return [x, z, wide, narrow, strong, weak, size, narrow if weak == strong else 0.0]


def _nothing() -> list[float]:
    """Return the column of no station."""
    column = [0.0] * 8
    column[bounds.STATION_X] = FAR_OFF
    return column
