"""The best speed: the lone bird's in closed form, a flock's against a fine sweep, and what holds it elsewhere."""

import math

import numpy as np
import pytest
from upwash import FlockRules, SearchSettings, WakeModel, load_species, solve_flock
from upwash.errors import UpwashError
from upwash.journey.line import Line, Lines, line_of
from upwash.journey.speed import (
    FLAT,
    LEAST_POWER,
    LEAST_TRANSPORT,
    NoSpeed,
    SpeedSearch,
    speed_range,
    states_needed,
)

IBIS = load_species("northern-bald-ibis")
QUICK = SearchSettings(tolerance=1e-2)


def at(speed):
    return IBIS.bird(speed_m_s=float(speed))


def by_drag(speed):
    return IBIS.bird("drag", speed_m_s=float(speed), body_drag_coefficient=0.2)


def search(birds=at, objective="power", model=None, **options):
    lines = Lines(objective, model or WakeModel())
    return SpeedSearch(birds, speed_range(birds, UpwashError), lines, QUICK, **options)


def mean_of_two(sought):
    return lambda line: sought.lines.flock_power_w(line, 2, "vee")


class TestALoneBird:
    def test_of_the_papers_powers_flies_at_the_speeds_of_the_closed_form(self):
        # P = a/U + c + d U³: least power at (a/3d)^(1/4); P/U least where 2a/U³ + c/U² = 2dU.
        alone = at(10.0)
        power = [search().lines.power_w(at(speed), at(speed).stroke) for speed in (5.5, 10.0, 20.0)]
        columns = np.array([[1.0 / speed, 1.0, speed**3] for speed in (5.5, 10.0, 20.0)])
        a, c, d = np.linalg.solve(columns, power)
        best = search().alone(LEAST_POWER)
        assert best.speed_m_s == pytest.approx((a / (3.0 * d)) ** 0.25, rel=1e-7)
        assert abs(best.slope) < FLAT
        furthest = search().alone(LEAST_TRANSPORT).speed_m_s
        assert 2.0 * a / furthest**3 + c / furthest**2 == pytest.approx(2.0 * d * furthest, rel=1e-6)
        assert alone.weight_n == pytest.approx(12.74)

    def test_with_a_tailwind_flies_slower_for_range_and_alike_for_power(self):
        still, windy = (
            search(by_drag, "aerodynamic_power"),
            search(by_drag, "aerodynamic_power", tailwind_m_s=5.0),
        )
        assert windy.alone(LEAST_TRANSPORT).speed_m_s < still.alone(LEAST_TRANSPORT).speed_m_s
        assert windy.alone(LEAST_POWER).speed_m_s == still.alone(LEAST_POWER).speed_m_s

    def test_whose_power_only_falls_is_held_by_the_end_of_its_range(self):
        sought = search(at, "aerodynamic_power")
        best = sought.alone(LEAST_POWER)
        assert best.speed_m_s == pytest.approx(sought.within.high, rel=1e-6)
        assert best.bound == f"no bird beyond: {sought.within.above.partition(';')[0]}"

    def test_that_cannot_fly_at_all_says_why(self):
        def heavy(speed):
            return IBIS.bird(mass_kg=1e6, speed_m_s=float(speed))

        with pytest.raises(NoSpeed, match="W/"):
            speed_range(heavy, UpwashError)

    def test_against_a_wind_faster_than_it_flies_there_is_no_speed(self):
        with pytest.raises(NoSpeed, match="wind: expected a headwind slower than the bird can fly"):
            search(tailwind_m_s=-300.0).alone(LEAST_TRANSPORT)


@pytest.mark.thorough
@pytest.mark.parametrize("birds", [at, by_drag], ids=["stroke-angle", "drag"])
def test_a_pairs_best_speed_is_the_minimum_of_a_fine_sweep(birds):
    objective = "power" if birds is at else "aerodynamic_power"
    sought = search(birds, objective, depth=1)
    share = mean_of_two(sought)
    best = sought.best(LEAST_TRANSPORT, share, 1)
    assert abs(best.slope) < FLAT or best.bound
    assert best.is_proved
    assert sought.lines.imbalance(best.line) < 1e-9
    costs = []
    for ratio in np.exp(np.linspace(-0.03, 0.03, 9)):
        # By the whole search, which knows nothing of other speeds.
        flock = solve_flock(birds(best.speed_m_s * ratio), 2, objective, search=QUICK)
        line = line_of(flock)
        costs.append(share(line) / line.bird.speed_m_s)
    least = share(best.line) / best.speed_m_s
    assert costs[4] == pytest.approx(least, rel=1e-8)
    assert min(costs) >= least * (1.0 - 1e-8)


def test_the_best_speed_does_not_hang_on_the_seed_or_on_what_was_asked_before():
    sought = search(depth=3)
    share = mean_of_two(sought)
    first = sought.best(LEAST_POWER, share, 1)
    later = SpeedSearch(at, sought.within, sought.lines, SearchSettings(seed=5, tolerance=1e-2), depth=1)
    again = later.best(LEAST_POWER, mean_of_two(later), 1)
    assert again.speed_m_s == pytest.approx(first.speed_m_s, rel=1e-5)
    assert again.power_w == pytest.approx(first.power_w, rel=1e-8)


def test_behind_an_endless_wake_the_steps_are_the_same_at_each_speed():
    lines = states_needed(at, [20.0], Lines("power", WakeModel.named("limit")))
    assert lines.model.stroke_states == 42
    few = Lines("power", WakeModel())
    assert states_needed(at, [20.0], few) == few


class TestALine:
    def test_followed_to_another_speed_is_the_one_found_there(self):
        lines = Lines("power", WakeModel())
        start = lines.looked_for(at(14.0), 2)
        found = lines.followed(start, at, 14.0, 15.0)
        proved = line_of(lines.proved(at(15.0), 2, QUICK))
        assert lines.powers_w(found) == pytest.approx(lines.powers_w(proved), rel=1e-9)
        back = lines.followed(found, at, 15.0, 14.0)
        assert lines.powers_w(back) == pytest.approx(lines.powers_w(start), rel=1e-9)

    def test_ends_where_a_bird_has_no_place(self):
        lines = Lines("power", WakeModel())
        found = lines.looked_for(at(8.0), 4)
        assert len(found.poses) == 2
        assert found.cut(3) is None
        assert len(lines.proved(at(8.0), 4, QUICK).placed) == 3

    def test_makes_flocks_of_any_shape(self):
        lines = Lines("power", WakeModel())
        line = lines.looked_for(at(15.0), 3)
        rows = lines.powers_w(line)
        assert lines.flock_power_w(line, 1, "vee") == pytest.approx(rows[0])
        assert lines.flock_power_w(line, 4, "echelon") == pytest.approx(math.fsum(rows) / 4)
        assert lines.flock_power_w(line, 5, "vee") == pytest.approx((rows[0] + 2 * rows[1] + 2 * rows[2]) / 5)
        flock = solve_flock(at(15.0), 5, "power", rules=FlockRules("vee"), search=QUICK)
        assert flock.total_cost() / 5 == pytest.approx(lines.flock_power_w(line, 5, "vee"), rel=1e-9)

    def test_of_nobody_but_the_first_is_a_lone_bird(self):
        lines = Lines("force", WakeModel())
        alone = Line(at(15.0), ())
        assert lines.powers_w(alone) == [pytest.approx(59.963, abs=5e-4)]
