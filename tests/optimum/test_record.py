"""What is recorded of a pose: the same wherever it is asked, and what is known of a lone bird and of mirror images."""

from dataclasses import replace

import pytest
from upwash import FlockRules, Pose, Stroke, WakeModel, solve_flock
from upwash.columns import BIRD, EVIDENCE, FLOCK_COLUMNS, FOUND, JOB, OPTIMUM, RECOMPUTED, belonging, names
from upwash.optimum.record import Record, record

AHEAD = Stroke(1.0, 0.4)
POSE = Pose(1.8, 0.9, -0.1, Stroke(0.75, 0.35), 0.4)
ALL_UPSTREAM = FlockRules("vee", "all-upstream")


def test_its_fields_are_the_columns_that_are_found_or_follow():
    # What a jittering bird is left with is of a place of its own, and is told by `upwash.place.robust`.
    follows = {
        one.name
        for one in belonging(OPTIMUM, JOB)
        if one.verified in (FOUND, RECOMPUTED) and not one.name.startswith("robust_")
    }
    assert set(vars(record_of(None, None))) == set(Record.__dataclass_fields__) == follows
    assert not follows & set(
        names(one for one in FLOCK_COLUMNS if one.verified == EVIDENCE or one.belongs == BIRD)
    )


def record_of(ahead, pose, **more):
    from upwash import load_species

    bird = load_species("northern-bald-ibis").bird()
    return record(bird, "power", ahead, pose, WakeModel(), **more)


def test_a_bird_that_follows_none_is_the_lone_bird(ibis):
    alone = record_of(None, None)
    assert (alone.x_m, alone.phase, alone.placement) == (None, None, None)
    assert Stroke(alone.amplitude_m, alone.upstroke_span_ratio) == ibis.stroke
    assert alone.saving_total == alone.lift_wake_n == alone.thrust_wake_n == 0.0
    assert alone.cost == alone.cost_leader == alone.power_total_w
    assert (alone.lift_self_n, alone.thrust_self_n) == (ibis.weight_n, ibis.drag_n)
    assert ibis.self_force_n(ibis.stroke) == pytest.approx((ibis.weight_n, ibis.drag_n), rel=1e-14)


def test_to_the_left_everything_is_as_to_the_right_but_the_side():
    right, left = record_of(AHEAD, POSE), record_of(AHEAD, POSE.mirrored())
    assert left.y_m == -right.y_m
    for name, value in vars(right).items():
        if name != "y_m":
            assert getattr(left, name) == (
                value if isinstance(value, str) else pytest.approx(value, abs=1e-12)
            )


def test_every_wake_adds_its_force(ibis):
    alone, other = record_of(AHEAD, POSE), replace(POSE, x_m=3.5, y_m=1.7)
    both, second = record_of(AHEAD, POSE, others=[(AHEAD, other, ibis)]), record_of(AHEAD, other)
    assert both.lift_wake_n == pytest.approx(alone.lift_wake_n + second.lift_wake_n, rel=1e-12)
    assert both.thrust_wake_n == pytest.approx(alone.thrust_wake_n + second.thrust_wake_n, rel=1e-12)
    assert both.residual_lift == pytest.approx((both.lift_self_n + both.lift_wake_n) / both.weight_n - 1.0)


# From one of the four statements of this that there once were; all agreed.
KNOWN = {
    "x_m": 0.3249520715269999,
    "y_m": 5.659535358855018e-19,
    "z_m": 0.04455498481585888,
    "amplitude_m": 0.7728100640270779,
    "upstroke_span_ratio": 0.42125253657650186,
    "phase": 0.0,
    "weight_n": 12.740000000000002,
    "drag_n": 2.295754394763122,
    "lift_self_n": 12.968410439922248,
    "thrust_self_n": 1.6130646495804757,
    "lift_wake_n": -0.228410439928489,
    "thrust_wake_n": 0.6826897451614264,
    "power_induced_w": 4.610960500042793,
    "power_profile_w": 24.195969743707135,
    "power_parasite_w": 21.077073501492613,
    "power_total_w": 49.88400374524254,
    "leader_power_induced_w": 4.4499667254749555,
    "leader_power_profile_w": 34.43631592144683,
    "leader_power_parasite_w": 21.077073501492613,
    "leader_power_total_w": 59.9633561484144,
    "saving_induced": -0.03617864683036576,
    "saving_profile": 0.29737054919286643,
    "saving_total": 0.16809186560913314,
    "cost": 49.88400374524254,
    "cost_leader": 59.9633561484144,
    "residual_lift": 0.0,
    "residual_thrust": 0.0,
    "placement": "inboard",
    "tier": "level",
    "station": "abreast",
}


def test_the_record_of_a_known_optimum_is_what_it_was(ibis):
    stroke = Stroke(KNOWN["amplitude_m"], KNOWN["upstroke_span_ratio"])
    pose = Pose(KNOWN["x_m"], KNOWN["y_m"], KNOWN["z_m"], stroke, KNOWN["phase"])
    found = vars(record(ibis, "power", ibis.stroke, pose, WakeModel()))
    for name, value in KNOWN.items():
        is_text = isinstance(value, str)
        assert found[name] == (value if is_text else pytest.approx(value, rel=1e-12, abs=1e-11)), name


def test_the_rows_of_a_pair_and_of_a_flock_are_what_is_recorded(ibis, ibis_force):
    for optimum, row in zip(ibis_force.optima, ibis_force.rows(), strict=True):
        found = vars(record(ibis, "force", ibis.stroke, optimum.pose, WakeModel()))
        assert {name: row[name] for name in found} == found
    flock = solve_flock(ibis, 5, "force", rules=ALL_UPSTREAM)
    for member, row in zip(flock.members[1:], flock.rows()[1:], strict=True):
        leader = flock.members[member.leader - 1].place.pose
        others = [
            (one.stroke, member.place.pose.relative_to(one), ibis)
            for one in (flock.members[k - 1].place.pose for k in ALL_UPSTREAM.felt_by(member.number)[:-1])
        ]
        found = record(ibis, "force", leader.stroke, member.optimum.pose, WakeModel(), others)
        for name, value in vars(found).items():
            assert row[name] == (
                value if isinstance(value, str) else pytest.approx(value, rel=1e-12, abs=1e-12)
            )
