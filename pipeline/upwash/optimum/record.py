"""What follows from a pose: forces, powers, savings, cost, what is missing to balance, and labels.

A search finds a pose; everything here follows from it and from the inputs, by the plain statement of the model.
Search, flock, check and tests all ask this one place.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from upwash.aero.bird import Bird
from upwash.aero.interaction import wake_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS, induced_power_w, parasite_power_w, profile_power_w
from upwash.aero.together import in_step
from upwash.aero.wake import WakeModel
from upwash.aero.wake_energy import wake_power_w
from upwash.optimum.problem import ASTERN, LEVEL, OUTBOARD

V_LABELS = ("outboard", "level", "astern")
"""Placement, tier and station of a follower in a V."""


@dataclass(frozen=True)
class Record:
    """What is recorded of a bird; the fields are the columns of the results of the same names.

    Position, phase and labels are relative to the bird that it follows, and None of a bird that follows none.
    """

    x_m: float | None
    y_m: float | None
    z_m: float | None
    amplitude_m: float
    upstroke_span_ratio: float
    phase: float | None
    spatial_phase: float | None
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
    power_wake_w: float
    leader_power_induced_w: float
    leader_power_profile_w: float
    leader_power_parasite_w: float
    leader_power_total_w: float
    leader_power_wake_w: float
    saving_induced: float
    saving_profile: float
    saving_total: float
    cost: float
    cost_leader: float
    residual_lift: float
    residual_thrust: float
    placement: str | None
    tier: str | None
    station: str | None


def labels(bird: Bird, position_m: tuple[float, float, float]) -> tuple[str, str, str]:
    """Return placement, tier and station of a follower at a position relative to its leader, in m.

    Examples
    --------
    >>> from upwash import load_species
    >>> labels(load_species("northern-bald-ibis").bird(), (1.8, -0.9, -0.1))
    ('outboard', 'level', 'astern')
    """
    x, y, z = position_m
    return (
        "outboard" if abs(y) >= OUTBOARD * bird.semispan_m else "inboard",
        "level" if abs(z) <= LEVEL * bird.amplitude_m else "stacked",
        "astern" if x >= ASTERN * bird.semispan_m else "abreast",
    )


def record(
    bird: Bird,
    objective: str,
    ahead: Stroke | None,
    pose: Pose | None,
    model: WakeModel,
    others: Iterable[tuple[Stroke, Pose, Bird]] = (),
    *,
    leader: Bird | None = None,
    phase_lock: bool = True,
) -> Record:
    """Return what follows from how and where a bird flies.

    Parameters
    ----------
    bird : Bird
        The bird, as it flies alone: what it spends then is what savings are shares of.
    objective : str
        Name of a cost function.
    ahead : Stroke or None
        How the bird that it follows flaps.
    pose : Pose or None
        Where it flies relative to that bird, and how it flaps; with `ahead`, None of a bird that follows none and
        flies as one alone.
    model : WakeModel
        Resolution of the wakes.
    others : iterable of (Stroke, Pose, Bird)
        Of each other bird whose wake it feels, how that one flaps, its own pose relative to it, and the bird.
    leader : Bird, optional
        The bird that it follows; like itself if not given.
    phase_lock : bool
        Whether it beats in step with the birds ahead; else it has no phase.

    Examples
    --------
    >>> from upwash import Pose, Stroke, WakeModel, load_species
    >>> ibis = load_species("northern-bald-ibis").bird()
    >>> found = record(ibis, "force", ibis.stroke, Pose(1.8, 0.9, -0.1, Stroke(0.75, 0.35), 0.5), WakeModel())
    >>> found.placement, round(found.lift_wake_n, 2), round(found.saving_total, 2)
    ('outboard', 0.4, 0.11)
    >>> record(ibis, "force", None, None, WakeModel()).saving_total
    0.0
    """
    stroke = pose.stroke if pose else bird.stroke
    leader = leader or bird
    flown = in_step(bird, leader, phase_lock)
    # Alone a bird makes its weight and its drag, by their definition.
    lift, thrust = flown.self_force_n(stroke) if pose else (bird.weight_n, bird.drag_n)
    lift_wake = thrust_wake = 0.0
    for shed, felt, by in [*([(ahead, pose, leader)] if ahead and pose else []), *others]:
        force = wake_force(bird, shed, felt, model, leader=by, phase_lock=phase_lock)
        lift_wake, thrust_wake = lift_wake + force[0], thrust_wake + force[1]
    own = induced_power_w(bird, lift), profile_power_w(bird, thrust), parasite_power_w(bird)
    alone = induced_power_w(bird, bird.weight_n), profile_power_w(bird, bird.drag_n), parasite_power_w(bird)
    cost = COST_FUNCTIONS[objective].value
    placement, tier, station = labels(bird, pose.position_m) if pose else (None, None, None)
    return Record(
        x_m=pose.x_m if pose else None,
        y_m=pose.y_m if pose else None,
        z_m=pose.z_m if pose else None,
        amplitude_m=stroke.amplitude_m,
        upstroke_span_ratio=stroke.span_ratio,
        phase=pose.phase if pose and phase_lock else None,
        spatial_phase=pose.spatial_phase(leader.wavelength_m) if pose and phase_lock else None,
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
        power_wake_w=wake_power_w(flown, stroke, model),
        leader_power_induced_w=alone[0],
        leader_power_profile_w=alone[1],
        leader_power_parasite_w=alone[2],
        leader_power_total_w=sum(alone),
        leader_power_wake_w=wake_power_w(bird, bird.stroke, model),
        saving_induced=1.0 - own[0] / alone[0],
        saving_profile=1.0 - own[1] / alone[1],
        saving_total=1.0 - sum(own) / sum(alone),
        cost=cost(bird, lift, thrust),
        cost_leader=cost(bird, bird.weight_n, bird.drag_n),
        residual_lift=(lift + lift_wake) / bird.weight_n - 1.0,
        residual_thrust=(thrust + thrust_wake) / bird.drag_n - 1.0,
        placement=placement,
        tier=tier,
        station=station,
    )
