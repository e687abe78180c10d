"""What a search returns: optima in SI units with their forces, powers, savings, labels and evidence."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import induced_power_w, parasite_power_w, profile_power_w
from upwash.optimum.evidence import Evidence, describe_edge
from upwash.optimum.problem import ASTERN, LEVEL, OUTBOARD, PairProblem
from upwash.optimum.proof import Proof

if TYPE_CHECKING:
    import pandas as pd

    from upwash.optimum.search import Basin

V_LABELS = ("outboard", "level", "astern")
"""Placement, tier and station of a follower in a V."""


def labels(problem: PairProblem, x: float, y: float, z: float) -> tuple[str, str, str]:
    """Return placement, tier and station of a follower at a scaled position relative to its leader."""
    height = LEVEL * problem.bird.amplitude_m / problem.bird.semispan_m
    return (
        "outboard" if y >= OUTBOARD else "inboard",
        "level" if abs(z) <= height else "stacked",
        "astern" if x >= ASTERN else "abreast",
    )


@dataclass(frozen=True)
class Optimum:
    """One local optimum; the fields are the columns of the results of the same names.

    Forces are recomputed from the stored position and stroke by the plain statement of the model, not taken from the
    solver.
    """

    x_m: float
    y_m: float
    z_m: float
    amplitude_m: float
    upstroke_span_ratio: float
    phase: float
    weight_n: float
    drag_n: float
    lift_self_n: float
    thrust_self_n: float
    lift_wake_n: float
    thrust_wake_n: float
    power_induced_w: float
    power_profile_w: float
    power_parasite_w: float
    power_total_w: float
    leader_power_induced_w: float
    leader_power_profile_w: float
    leader_power_parasite_w: float
    leader_power_total_w: float
    saving_induced: float
    saving_profile: float
    saving_total: float
    cost: float
    cost_leader: float
    residual_lift: float
    residual_thrust: float
    rank: int
    hits: int
    starts: int
    placement: str
    tier: str
    station: str
    is_v_optimum: bool
    is_global_optimum: bool
    active_bounds: str
    core_edges: str
    stationarity: float
    curvature: float | None
    multiplier_lift: float
    multiplier_thrust: float

    @property
    def pose(self) -> Pose:
        """Where and how the follower flies, relative to the bird ahead."""
        stroke = Stroke(self.amplitude_m, self.upstroke_span_ratio)
        return Pose(self.x_m, self.y_m, self.z_m, stroke, self.phase)


@dataclass(frozen=True)
class PairSolution:
    """All optima of one follower, best first, and the proof.

    Attributes
    ----------
    status : str
        ``solved``, or ``infeasible`` when no follower within the bounds can balance.
    optima : tuple of Optimum
        Best first.
    proof : Proof
        What was shown of the best.
    solve_time_s : float
        Wall time, in s.
    """

    status: str
    optima: tuple[Optimum, ...]
    proof: Proof
    solve_time_s: float

    @property
    def global_optimum(self) -> Optimum | None:
        """The best optimum of all, if there is one."""
        return self.optima[0] if self.optima else None

    @property
    def v_optimum(self) -> Optimum | None:
        """The best optimum that is outboard, level and astern, if there is one."""
        return next((optimum for optimum in self.optima if optimum.is_v_optimum), None)

    def rows(self) -> list[dict[str, Any]]:
        """Return one dictionary per optimum, by the columns of the results."""
        shared = self.proof.columns() | {"solve_time_s": self.solve_time_s}
        return [asdict(optimum) | shared for optimum in self.optima]

    def frame(self) -> pd.DataFrame:
        """Return the rows as a pandas DataFrame."""
        import pandas as pd

        return pd.DataFrame(self.rows())


def describe_optimum(
    problem: PairProblem,
    basin: Basin,
    evidence: Evidence,
    edge_names: list[tuple[int, int]],
    *,
    rank: int,
    starts: int,
    is_v_optimum: bool,
) -> Optimum:
    """Turn a basin into an optimum in SI units.

    Parameters
    ----------
    problem : PairProblem
        The problem.
    basin : Basin
        The local optimum in scaled variables.
    evidence : Evidence
        What holds there.
    edge_names : list of (lane, filament)
        A lane and a filament of each core edge it lies on.
    rank, starts : int
        Its place among the optima of the job; starts of the search.
    is_v_optimum : bool
        Whether it is the best of those in a V.
    """
    bird = problem.bird
    pose = problem.pose(basin.point)
    lift_wake, thrust_wake = problem.wake_force_n(pose)
    lift, thrust = bird.self_force_n(pose.stroke)
    own = induced_power_w(bird, lift), profile_power_w(bird, thrust), parasite_power_w(bird)
    alone = (
        induced_power_w(bird, bird.weight_n),
        profile_power_w(bird, bird.drag_n),
        parasite_power_w(bird),
    )
    placement, tier, station = labels(problem, *(float(value) for value in basin.point[:3]))
    return Optimum(
        x_m=pose.x_m,
        y_m=pose.y_m,
        z_m=pose.z_m,
        amplitude_m=pose.stroke.amplitude_m,
        upstroke_span_ratio=pose.stroke.span_ratio,
        phase=pose.phase,
        weight_n=bird.weight_n,
        drag_n=bird.drag_n,
        lift_self_n=lift,
        thrust_self_n=thrust,
        lift_wake_n=lift_wake,
        thrust_wake_n=thrust_wake,
        power_induced_w=own[0],
        power_profile_w=own[1],
        power_parasite_w=own[2],
        power_total_w=sum(own),
        leader_power_induced_w=alone[0],
        leader_power_profile_w=alone[1],
        leader_power_parasite_w=alone[2],
        leader_power_total_w=sum(alone),
        saving_induced=1.0 - own[0] / alone[0],
        saving_profile=1.0 - own[1] / alone[1],
        saving_total=1.0 - sum(own) / sum(alone),
        cost=problem.cost_function.value(bird, lift, thrust),
        cost_leader=problem.leader_cost,
        residual_lift=(lift + lift_wake) / bird.weight_n - 1.0,
        residual_thrust=(thrust + thrust_wake) / bird.drag_n - 1.0,
        rank=rank,
        hits=basin.hits,
        starts=starts,
        placement=placement,
        tier=tier,
        station=station,
        is_v_optimum=is_v_optimum,
        is_global_optimum=rank == 0,
        active_bounds=",".join(evidence.active_bounds),
        core_edges=", ".join(describe_edge(problem, *name) for name in edge_names),
        stationarity=evidence.stationarity,
        curvature=evidence.curvature,
        multiplier_lift=evidence.multiplier_lift,
        multiplier_thrust=evidence.multiplier_thrust,
    )
