"""The ibis in an unsteady vortex lattice: a code of higher fidelity beside the model's answers, by ``make uvlm``.

A lone ibis flaps rectangular wings that twist (PteraSoftware, rings of its own wake prescribed) and is trimmed by
incidence and twist to the model's weight and drag.  Followers flap the same way in the wake of a leader that does not
feel them; each is trimmed anew, and what it saves is the drop of its shaft power.  One run flies both together, so that
each feels the other; a few repeat one place on finer grids.  What comes out is kept in ``results/crosscheck/``, for
docs/lattice.md and its figure; no test and no result depends on running this.
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pterasoftware as ptera
import upwash
from joblib import Parallel, delayed
from numpy.typing import NDArray
from pterasoftware import _aerodynamics_functions as kernels
from pterasoftware.unsteady_ring_vortex_lattice_method import UnsteadyRingVortexLatticeMethodSolver
from upwash.batch.store import code_version, encode, write_atomic
from upwash.columns import INTEGER, TEXT, Column
from upwash.jobs.schema import schema_of

from benchmarks import machine

RESULT = Path(__file__).parents[1] / "results" / "crosscheck" / "uvlm.parquet"
SPECIES = "northern-bald-ibis"
WORKERS = 2

ROOT_GAP_M = 1e-3
"""From the plane of symmetry to each wing: the two are wings of their own, so that they can turn about their roots."""

ASPECT = 4.0
"""Semispan over chord: the paper's."""

CORE_RATIO = 0.1
"""Radius of a vortex core over the semispan."""

TRIMMED = 1e-3
"""Largest share of weight or drag that a trimmed bird lacks."""

MOST_TRIMS = 15

STARTS = {60.0: (3.5, 48.0), 32.0: (3.1, 21.5)}
"""Stroke half-angle in degrees -> controls where its trim begins: the paper's, and that of Strouhal number 0.17."""

PAPER_PLACE = (1.83, 0.882, -0.063, 0.5)
"""The paper's Table 1, least power: behind, to the right, above, in m; and phase."""

PHASES = tuple(np.arange(8) / 8)
STATIONS = (0.24, 0.48, 0.72, 0.96)
"""Distances behind at which all phases are flown, in wavelengths."""

ASIDE_M = (0.3, 0.5, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.4)
SEEN_M = ((1.2, 0.904), (1.2, 1.1))
"""Where ibises were seen: behind, aside."""


@dataclass(frozen=True)
class Grid:
    """How finely birds are resolved: panels along chord and half-span, steps a wingbeat, wingbeats."""

    chordwise: int = 3
    spanwise: int = 8
    steps: int = 40
    beats: int = 2


FINER = (Grid(chordwise=5), Grid(spanwise=12), Grid(steps=60), Grid(beats=3))


def flapping(
    bird: upwash.Bird,
    half_angle_deg: float,
    controls: NDArray[np.float64],
    grid: Grid,
    place: tuple[float, ...],
) -> Any:
    """Return a flapping bird: its wings turn about the flight axis, highest at phase 0, and twist against the stroke.

    Parameters
    ----------
    bird : Bird
        Its span, speed and period.
    half_angle_deg : float
        To which its wings rise and fall.
    controls : (2,) ndarray of float
        Incidence of the wings, and amplitude of the twist at their tips, in degrees.
    grid : Grid
        How finely.
    place : (4,) tuple of float
        Behind the first bird, to the right of it and above it in m, and by how many wingbeats it lags.
    """
    incidence, twist = controls
    *where, phase = place
    section, moving = ptera.geometry.wing_cross_section.WingCrossSection, ptera.movements
    wings, movements = [], []
    for mirror in (
        {},
        {"mirror_only": True, "symmetryNormal_G": (0.0, 1.0, 0.0), "symmetryPoint_G_Cg": (0.0, 0.0, 0.0)},
    ):
        foil: dict[str, Any] = {
            "airfoil": ptera.geometry.airfoil.Airfoil(name="naca0012"),
            "chord": bird.semispan_m / ASPECT,
        }
        root = section(num_spanwise_panels=grid.spanwise, spanwise_spacing="cosine", **foil)
        tip = section(num_spanwise_panels=None, Lp_Wcsp_Lpp=(0.0, bird.semispan_m - ROOT_GAP_M, 0.0), **foil)
        wing = ptera.geometry.wing.Wing(
            wing_cross_sections=[root, tip],
            Ler_Gs_Cgs=(0.0, ROOT_GAP_M, 0.0),
            angles_Gs_to_Wn_ixyz=(0.0, incidence, 0.0),
            num_chordwise_panels=grid.chordwise,
            chordwise_spacing="uniform",
            **mirror,
        )
        wings.append(wing)
        cross = moving.wing_cross_section_movement.WingCrossSectionMovement
        twisting = cross(
            base_wing_cross_section=tip,
            ampAngles_Wcsp_to_Wcs_ixyz=(0.0, abs(twist), 0.0),
            periodAngles_Wcsp_to_Wcs_ixyz=(0.0, bird.period_s if twist else 0.0, 0.0),
            # The leading edge turns down as the tip falls.
            phaseAngles_Wcsp_to_Wcs_ixyz=(
                0.0,
                _turned((180.0 if twist > 0 else 0.0) - 360.0 * phase) if twist else 0.0,
                0.0,
            ),
        )
        movements.append(
            moving.wing_movement.WingMovement(
                base_wing=wing,
                wing_cross_section_movements=[cross(base_wing_cross_section=root), twisting],
                ampAngles_Gs_to_Wn_ixyz=(half_angle_deg, 0.0, 0.0),
                periodAngles_Gs_to_Wn_ixyz=(bird.period_s, 0.0, 0.0),
                phaseAngles_Gs_to_Wn_ixyz=(_turned(90.0 - 360.0 * phase), 0.0, 0.0),
            )
        )
    airplane = ptera.geometry.airplane.Airplane(
        wings=wings, Cg_GP1_CgP1=where, s_ref=1.0, c_ref=1.0, b_ref=1.0
    )
    return moving.airplane_movement.AirplaneMovement(base_airplane=airplane, wing_movements=movements)


def _turned(angle_deg: float) -> float:
    """Return an angle in (−180, 180]."""
    return 180.0 - (180.0 - angle_deg) % 360.0


@dataclass(frozen=True)
class Wake:
    """A leader's bound and shed rings at each step of a wingbeat, for a follower that it does not feel.

    Attributes
    ----------
    corners : tuple of (4, n, 3) ndarray of float
        Of each step the corners of all rings, in m from the leader.
    circulation : tuple of (n,) ndarray of float
        Of each step the circulation of each ring, in m²/s.
    core_m : float
        Radius of the rings' cores.
    place_m : (3,) ndarray of float
        Of the follower: behind, to the right, above.
    """

    corners: tuple[NDArray[np.float64], ...]
    circulation: tuple[NDArray[np.float64], ...]
    core_m: float
    place_m: NDArray[np.float64]

    def velocity(self, step: int, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the velocity in m/s at points around the follower, (n, 3), at one of its steps."""
        at = step % len(self.corners)
        strength = self.circulation[at]
        cores = np.full(len(strength), self.core_m)
        return kernels.collapsed_velocities_from_ring_vortices(
            points + self.place_m, *self.corners[at], strength, cores, np.zeros(4, np.int64)
        )


class Lattice(UnsteadyRingVortexLatticeMethodSolver):
    """The lattice, which notes force and shaft power of each bird, and may feel a wake that does not feel it."""

    def __init__(self, movement: Any, core_m: float, wake: Wake | None) -> None:
        super().__init__(ptera.problems.UnsteadyProblem(movement=movement, only_final_results=True))
        self.core_m, self.wake = core_m, wake
        self.loads: list[NDArray[np.float64]] = []
        self.bound: list[NDArray[np.float64]] = []

    def _collapse_geometry(self) -> None:
        super()._collapse_geometry()
        self._currentStackBoundRc0s[:] = self.core_m
        self._currentStackWakeRc0s[:] = self.core_m

    def _calculate_freestream_wing_influences(self) -> None:
        super()._calculate_freestream_wing_influences()
        if self.wake is not None:
            gust = self.wake.velocity(self._current_step, self.stackCpp_GP1_CgP1)
            self._currentStackFreestreamWingInfluences__E += np.einsum(
                "ij,ij->i", self.stackUnitNormals_GP1, gust
            )

    def _calculate_induced_velocity(self, points: Any, *counts: Any) -> NDArray[np.float64]:
        own = super()._calculate_induced_velocity(points, *counts)
        return own if self.wake is None else own + self.wake.velocity(self._current_step, np.asarray(points))

    def _update_next_step_hook(self, step: int) -> None:
        self.bound.append(self._current_bound_vortex_strengths.copy())
        if step < self.first_results_step:
            return
        # A panel moves against its apparent wind; what its wing does is minus the work of the air on it.
        velocity = -self._calculate_current_movement_velocities_at_collocation_points()
        forces = np.array([panel.forces_GP1 for panel in self.panels])
        power = -np.einsum("ij,ij->i", forces, velocity)
        each = np.column_stack([forces[:, 2], -forces[:, 0], power])
        self.loads.append(each.reshape(self.num_airplanes, -1, 3).sum(axis=1))

    def mean_loads(self) -> NDArray[np.float64]:
        """Return lift and thrust in N and shaft power in W of each bird in the last wingbeat, (birds, 3)."""
        return np.mean(self.loads, axis=0)

    def wake_behind(self, steps: int, place_m: tuple[float, ...]) -> Wake:
        """Return what a bird at a place feels of the last wingbeat, flown over and over."""
        corners, circulation = [], []
        for at in range(self.num_steps - steps, self.num_steps):
            bound = [getattr(self, f"_listStack{one}brvp_GP1_CgP1")[at] for one in ("Br", "Fr", "Fl", "Bl")]
            shed = [getattr(self, f"listStack{one}wrvp_GP1_CgP1")[at] for one in ("Br", "Fr", "Fl", "Bl")]
            corners.append(np.concatenate([bound, shed], axis=1))
            circulation.append(np.concatenate([self.bound[at], self._list_wake_vortex_strengths[at]]))
        return Wake(tuple(corners), tuple(circulation), self.core_m, np.array(place_m))


@dataclass(frozen=True)
class Flight:
    """Ibises that fly level together, how they flap, how finely they are resolved, and a wake that they fly in."""

    half_angle_deg: float
    grid: Grid = Grid()
    places: tuple[tuple[float, ...], ...] = ((0.0, 0.0, 0.0, 0.0),)
    wake: Wake | None = None

    def fly(self, controls: NDArray[np.float64]) -> Lattice:
        """Let them fly with their controls, (birds, 2), and return the lattice that has run."""
        numba.set_num_threads(1)
        bird = upwash.load_species(SPECIES).bird()
        point = ptera.operating_point.OperatingPoint(
            rho=bird.density_kg_m3, vCg__E=bird.speed_m_s, alpha=0.0, nu=1.5e-5
        )
        moving = ptera.movements
        movement = moving.movement.Movement(
            airplane_movements=[
                flapping(bird, self.half_angle_deg, *one, self.grid, place)
                for one, place in zip(controls[:, None], self.places, strict=True)
            ],
            operating_point_movement=moving.operating_point_movement.OperatingPointMovement(
                base_operating_point=point
            ),
            delta_time=bird.period_s / self.grid.steps,
            num_cycles=self.grid.beats,
        )
        lattice = Lattice(movement, CORE_RATIO * bird.semispan_m, self.wake)
        lattice.run(prescribed_wake=True, calculate_streamlines=False, show_progress=False)
        return lattice

    def trimmed(self, controls: NDArray[np.float64], slope: NDArray[np.float64] | None = None) -> Trim:
        """Find the controls with which each bird's lift is its weight, and its thrust its drag.

        Parameters
        ----------
        controls : (birds, 2) ndarray of float
            Where to begin.
        slope : (2, 2) ndarray of float, optional
            Change of lift over weight and thrust over drag with each control of a bird; by differences if not given.

        Raises
        ------
        RuntimeError
            If they are not trimmed after `MOST_TRIMS` steps.
        """
        bird = upwash.load_species(SPECIES).bird()
        needed = np.array([bird.weight_n, bird.drag_n])

        def lacking(lattice: Lattice) -> NDArray[np.float64]:
            return (lattice.mean_loads()[:, :2] / needed - 1.0).ravel()

        at = np.array(controls, dtype=float)
        lattice = self.fly(at)
        lack = lacking(lattice)
        if slope is None:
            slope = np.stack([lacking(self.fly(at + change)) - lack for change in np.eye(2)], axis=1)
        full = np.kron(np.eye(len(at)), slope)
        for _ in range(MOST_TRIMS):
            if np.abs(lack).max() < TRIMMED:
                return Trim(at, full[:2, :2], lattice)
            step = -np.linalg.solve(full, lack)
            at = at + step.reshape(at.shape)
            lattice = self.fly(at)
            before, lack = lack, lacking(lattice)
            # Broyden's way: along the step, the slope is what was just seen.
            full = full + np.outer(lack - before - full @ step, step) / (step @ step)
        raise RuntimeError(
            f"{self.places}: expected to be trimmed in {MOST_TRIMS} steps, still lacking {lack}"
        )


@dataclass(frozen=True)
class Trim:
    """A trimmed flight: with what, how forces change with that, and the lattice that has run."""

    controls: NDArray[np.float64]
    slope: NDArray[np.float64]
    lattice: Lattice


@dataclass(frozen=True)
class Alone:
    """A lone bird that is trimmed, and the leader that it is: its wake once it has flown a wingbeat more."""

    half_angle_deg: float
    grid: Grid
    controls: NDArray[np.float64]
    slope: NDArray[np.float64]
    power_w: float
    wake: Wake

    @classmethod
    def of(cls, half_angle_deg: float, grid: Grid) -> tuple[Alone, Trim]:
        """Trim a lone bird; return it and its trimmed flight."""
        trim = Flight(half_angle_deg, grid).trimmed(np.array([STARTS[half_angle_deg]]))
        longer = replace(grid, beats=grid.beats + 1)
        wake = Flight(half_angle_deg, longer).fly(trim.controls).wake_behind(grid.steps, (0.0, 0.0, 0.0))
        power = float(trim.lattice.mean_loads()[0, 2])
        return cls(half_angle_deg, grid, trim.controls, trim.slope, power, wake), trim


SCHEMA = schema_of(
    [
        Column(
            "role",
            "",
            "alone, follower (its leader does not feel it), or together (each feels the other)",
            TEXT,
        ),
        Column("half_angle_deg", "deg", "to which wings rise and fall"),
        Column("chordwise", "1", "panels along the chord", INTEGER),
        Column("spanwise", "1", "panels along a half-span", INTEGER),
        Column("steps", "1", "time steps a wingbeat", INTEGER),
        Column("beats", "1", "wingbeats flown, of which the last counts", INTEGER),
        Column("x_m", "m", "behind the leader"),
        Column("y_m", "m", "to the right of the leader"),
        Column("z_m", "m", "above the leader"),
        Column("phase", "wingbeat", "by which the follower lags"),
        Column("incidence_deg", "deg", "of the wings"),
        Column("twist_deg", "deg", "amplitude of the twist at the wingtips"),
        Column("lift_n", "N", "mean over the last wingbeat"),
        Column("thrust_n", "N", "mean over the last wingbeat"),
        Column("power_w", "W", "mean shaft power over the last wingbeat"),
        Column("saving", "1", "share of its shaft power alone that is saved"),
        Column("leader_saving", "1", "the same of the leader, where it feels the follower"),
        Column("cpu_s", "s", "processor time"),
    ]
)


def row_of(role: str, alone: Alone, place: tuple[float, ...], trim: Trim, cpu_s: float) -> dict[str, Any]:
    """Return what is kept of a trimmed flight, of its last bird."""
    loads = trim.lattice.mean_loads()
    savings = 1.0 - loads[:, 2] / alone.power_w
    values = {
        "role": role,
        "half_angle_deg": alone.half_angle_deg,
        **asdict(alone.grid),
        **dict(zip(("x_m", "y_m", "z_m", "phase"), map(float, place), strict=True)),
        **dict(zip(("incidence_deg", "twist_deg"), map(float, trim.controls[-1]), strict=True)),
        **dict(zip(("lift_n", "thrust_n", "power_w"), map(float, loads[-1]), strict=True)),
        "saving": float(savings[-1]),
        "leader_saving": float(savings[0]) if len(loads) > 1 else None,
        "cpu_s": cpu_s,
    }
    return values


def behind(alone: Alone, place: tuple[float, ...], together: bool = False) -> dict[str, Any]:
    """Fly a follower at a place, with a leader that feels it or does not, and return its row."""
    begun = time.process_time()
    if together:
        both = Flight(alone.half_angle_deg, alone.grid, ((0.0, 0.0, 0.0, 0.0), place))
        trim = both.trimmed(np.repeat(alone.controls, 2, axis=0), alone.slope)
    else:
        own = (0.0, 0.0, 0.0, place[3])
        wake = replace(alone.wake, place_m=np.array(place[:3]))
        trim = Flight(alone.half_angle_deg, alone.grid, (own,), wake).trimmed(alone.controls, alone.slope)
    return row_of("together" if together else "follower", alone, place, trim, time.process_time() - begun)


def lone(half_angle_deg: float, grid: Grid) -> tuple[Alone, dict[str, Any]]:
    """Trim a lone bird; return it and its row."""
    begun = time.process_time()
    alone, trim = Alone.of(half_angle_deg, grid)
    return alone, row_of("alone", alone, (0.0, 0.0, 0.0, 0.0), trim, time.process_time() - begun)


def finer(grid: Grid) -> list[dict[str, Any]]:
    """Fly the paper's place on another grid; return the lone bird's row and the follower's."""
    alone, row = lone(60.0, grid)
    return [row, behind(alone, PAPER_PLACE)]


def places(half_angle_deg: float, wavelength_m: float) -> list[tuple[float, ...]]:
    """Return where followers of one half-angle fly."""
    middle = 0.48
    asked = [(middle * wavelength_m, y, 0.0, middle) for y in ASIDE_M]
    asked += [(*seen, 0.0, seen[0] / wavelength_m) for seen in SEEN_M]
    stations = STATIONS if half_angle_deg == 60.0 else (middle,)
    aside = 0.9 if half_angle_deg == 60.0 else 1.1
    asked += [(station * wavelength_m, aside, 0.0, phase) for station in stations for phase in PHASES]
    return asked + ([PAPER_PLACE] if half_angle_deg == 60.0 else [])


def main() -> None:
    """Fly all of it, print what follows, and keep it."""
    began = time.monotonic()
    wavelength = upwash.load_species(SPECIES).bird().wavelength_m
    with Parallel(n_jobs=WORKERS, verbose=5) as parallel:
        birds = parallel(delayed(lone)(angle, Grid()) for angle in STARTS)
        tasks = [
            delayed(behind)(alone, place)
            for alone, _ in birds
            for place in places(alone.half_angle_deg, wavelength)
        ]
        followers = parallel([delayed(behind)(birds[0][0], PAPER_PLACE, together=True), *tasks])
        grids = parallel(delayed(finer)(grid) for grid in FINER)
    rows = [row for _, row in birds] + followers + [row for pair in grids for row in pair]
    metadata = {
        "code_version": code_version(),
        "package_versions": json.dumps(machine.versions()),
        "machine": json.dumps(machine.description()),
        "species": SPECIES,
        "core_ratio": str(CORE_RATIO),
        "aspect": str(ASPECT),
        "trimmed": str(TRIMMED),
        "wall_time_s": f"{time.monotonic() - began:.0f}",
    }
    RESULT.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(RESULT, encode(rows, SCHEMA, metadata))
    print(f"{RESULT}: {len(rows)} flights in {time.monotonic() - began:.0f} s")


if __name__ == "__main__":
    main()
