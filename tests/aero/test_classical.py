"""Where wings do not flap the model must give Prandtl's and Munk's results: its kernels against closed forms.

The limit model's own force with h → 0 and R → 1 is a wing of uniform loading behind a rolled-up pair of vortices;
`upwash.aero.fixed_wing` sums the same kernel for wings of elliptic loading.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from upwash import Pose, Stroke, WakeModel, load_species, wake_force
from upwash.aero.endless import endless_window
from upwash.aero.fixed_wing import FixedWing
from upwash.aero.induction import velocity
from upwash.aero.wake import ROLL_UP, wake_at_phases

IBIS = load_species("northern-bald-ibis").bird()
B, WAVELENGTH = IBIS.semispan_m, IBIS.wavelength_m
CORE = 0.171 * B
STILL = Stroke(1e-9, 1.0 - 1e-12)
"""A stroke that hardly is one."""
LIMIT = WakeModel.named("limit")

ELLIPTIC = FixedWing(B, IBIS.weight_n, IBIS.speed_m_s, IBIS.density_kg_m3)
ROLLED_UP = replace(ELLIPTIC, wake="pair")
PAPERS = replace(ELLIPTIC, loading="uniform", wake="pair")


def steady_saving(y, x=0.5, bird=IBIS, model=LIMIT):
    """Return what the limit model saves, over an elliptic wing's drag at the lift of uniform loading."""
    pose = Pose(x * bird.wavelength_m, y * bird.semispan_m, 0.0, STILL, 0.0)
    _, thrust = wake_force(bird, STILL, pose, model)
    return thrust / (2.0 * bird.density_kg_m3 * bird.circulation_m2_s**2 / math.pi)


def beside_pair(y):
    """Integrate the wind of a straight pair at ±π/4 with Rankine cores over a span of 2, over the same drag."""

    def wind(eta):
        near, far = eta - ROLL_UP, eta + ROLL_UP
        return near / max(near * near, 0.171**2) - far / max(far * far, 0.171**2)

    edges = [ROLL_UP + side * 0.171 for side in (-1.0, 0.0, 1.0)]
    total, _ = quad(wind, y - 1.0, y + 1.0, points=[e for e in edges if y - 1.0 < e < y + 1.0] or None)
    return 0.25 * total


def behind_elliptic(y):
    """Return the saving of an elliptic wing beside the flat sheet of another, by Prandtl's wind."""

    def share(angle):
        eta = abs(y + math.sin(angle))
        return math.cos(angle) ** 2 * (eta / math.sqrt(eta * eta - 1.0) - 1.0 if eta > 1.0 else -1.0)

    edge = [math.asin(1.0 - y)] if abs(1.0 - y) < 1.0 else None
    return 4.0 / math.pi * quad(share, -0.5 * math.pi, 0.5 * math.pi, points=edge, limit=500)[0]


def beside_vortices(y):
    """Return the saving of an elliptic wing beside a thin pair at ±π/4: by the Hilbert transform of its loading."""

    def transform(eta):
        return eta if abs(eta) <= 1.0 else eta - math.copysign(math.sqrt(eta * eta - 1.0), eta)

    return 4.0 / math.pi * (transform(y - ROLL_UP) - transform(y + ROLL_UP))


def best_y(saving, low=1.2, high=2.6):
    found = minimize_scalar(
        lambda y: -saving(y), bounds=(low, high), method="bounded", options={"xatol": 1e-7}
    )
    return found.x, -found.fun


class TestUpwash:
    """Γ/(2π) ln[s²/(s² − 4a²)]: the upwash beside vortices at ±a on a wing from s − a to s + a."""

    @pytest.mark.parametrize("distance", [2.2, 2.5, 4.0, 9.0])
    def test_beside_a_pair_of_vortices(self, distance):
        closed = math.log(distance**2 / (distance**2 - 4.0)) / (2.0 * math.pi)
        window = endless_window(True, 0.0, 1.0, 1.0 / ROLL_UP, 6.25, 1.0)
        mean = window.mean_wind(np.zeros(1), distance, np.zeros(1), np.ones(1), 1e-6, LIMIT)[0, 1]
        assert 2.0 * mean == pytest.approx(closed, abs=1e-6)
        wing = FixedWing(1.0, 2.0, 1.0, 1.0, loading="uniform")
        assert wing.circulation_m2_s == 1.0
        assert wing.drag_saved_n(wing, y_m=distance) == pytest.approx(closed, rel=3e-7)

    def test_flat_rings_cancel_where_they_meet(self):
        chain = wake_at_phases([0.0], 0.0, 1.0, 1.0, 6.25, 1.0, 1.0, WakeModel(wavelengths=3))
        one = wake_at_phases([0.0], 0.0, 1.0, 1.0, 3 * 6.25, 1.0, 1.0)
        points = np.random.default_rng(3).uniform([-2.0, 0.0, -1.0], [20.0, 3.0, 1.0], (40, 3))
        difference = velocity(points, chain.rings, chain.circulation, 0.171) - velocity(
            points, one.rings, one.circulation, 0.171
        )
        assert np.abs(difference).max() < 1e-13


class TestUniformLoading:
    """The paper's wing in steady flight."""

    @pytest.mark.parametrize("y", [0.0, 0.7, 1.2, 1.7, 1.81, 2.0, 2.6, 4.0])
    def test_limit_model_gives_the_closed_form(self, y):
        assert steady_saving(y) == pytest.approx(beside_pair(y), abs=2e-6)

    def test_so_does_the_fixed_wing(self):
        for y in (1.2, 1.81, 2.6):
            found = PAPERS.saving_behind(PAPERS, y_m=y * B, core_radius_m=CORE)
            assert found == pytest.approx(beside_pair(y), abs=1e-7)

    def test_saves_half_the_drag_at_most(self):
        y, saving = best_y(steady_saving)
        assert y == pytest.approx(1.81, abs=0.005)
        assert saving == pytest.approx(0.537, abs=5e-4)

    def test_two_points_say_more_than_twice_as_much(self):
        ring = {"wake_length_m": WAVELENGTH, "core_radius_m": CORE}

        def saving(nodes):
            return lambda y: PAPERS.saving_behind(PAPERS, 0.5 * WAVELENGTH, y * B, nodes=nodes, **ring)

        # The inner wingtip rides the core's edge, and stands for half the wing.
        y, most = best_y(saving(2), 1.9, 2.0)
        assert y == pytest.approx(1.0 + ROLL_UP + 0.171, abs=2e-4)
        assert most == pytest.approx(1.336, abs=1e-3)
        for nodes, place, value in ((33, 1.83, 0.506), ("exact", 1.81, 0.505)):
            y, most = best_y(saving(nodes))
            assert y == pytest.approx(place, abs=0.005)
            assert most == pytest.approx(value, abs=5e-4)

    def test_two_points_are_the_papers_model_in_steady_flight(self):
        for y in (1.5, 1.9, 1.956):
            by_wing = PAPERS.saving_behind(
                PAPERS, 0.5 * WAVELENGTH, y * B, wake_length_m=WAVELENGTH, core_radius_m=CORE, nodes=2
            )
            assert by_wing == pytest.approx(steady_saving(y, model=WakeModel()), rel=1e-9)

    @pytest.mark.parametrize(
        ("x", "points_lost"), [(0.24, 0.054), (0.48, 0.032), (0.72, 0.046), (0.96, 0.198)]
    )
    def test_a_wake_of_one_wavelength_gives_less_than_an_endless_one(self, x, points_lost):
        cut = steady_saving(1.81, x, model=replace(LIMIT, wavelengths=1))
        assert steady_saving(1.81) - cut == pytest.approx(points_lost, abs=1e-3)


class TestEllipticLoading:
    """Prandtl (1924), Munk (1923): one elliptic wing beside another."""

    @pytest.mark.parametrize(
        ("y", "saving"),
        [(1.6, 0.60), (1.82, 0.69), (2.0, 0.55), (2.2, 0.33), (2.5, 0.22), (3.0, 0.14), (4.0, 0.07)],
    )
    def test_table(self, y, saving):
        found = ELLIPTIC.saving_behind(ELLIPTIC, y_m=y * B)
        assert found == pytest.approx(behind_elliptic(y), abs=1e-3)
        assert round(found, 2) == saving

    def test_best_at_an_overlap_of_a_tenth_of_the_span(self):
        grid = np.arange(1.74, 1.91, 0.02)
        found = [ELLIPTIC.saving_behind(ELLIPTIC, y_m=y * B) for y in grid]
        # A parabola through all of them.
        curve = np.polynomial.Polynomial.fit(grid, found, 2)
        best = float(curve.deriv().roots()[0])
        assert best == pytest.approx(best_y(behind_elliptic)[0], abs=0.01)
        assert best == pytest.approx(1.82, abs=0.01)

    @pytest.mark.parametrize("y", [1.3, 1.5, 1.7, 1.785, 1.9, 2.2])
    def test_beside_a_rolled_up_pair(self, y):
        found = ROLLED_UP.saving_behind(ROLLED_UP, y_m=y * B)
        assert found == pytest.approx(beside_vortices(y), abs=1e-4)

    def test_best_with_the_tip_on_the_rolled_up_vortex(self):
        y, saving = best_y(lambda y: ROLLED_UP.saving_behind(ROLLED_UP, y_m=y * B))
        assert y == pytest.approx(1.0 + ROLL_UP, abs=1e-3)
        # All of the induced drag, and a little more: vortices without a core are too good to be true.
        assert saving == pytest.approx(1.0155, abs=1e-3)

    def test_alone_it_pays_what_prandtl_says(self):
        # In its own far wake the wind is twice that at the wing, and downward.
        assert ELLIPTIC.saving_behind(ELLIPTIC, y_m=0.0) == pytest.approx(-2.0, abs=1e-3)
        alone = (
            2.0
            * ELLIPTIC.lift_n**2
            / (math.pi * ELLIPTIC.density_kg_m3 * ELLIPTIC.speed_m_s**2 * (2.0 * ELLIPTIC.semispan_m) ** 2)
        )
        assert ELLIPTIC.induced_drag_n == pytest.approx(alone, rel=1e-12)

    def test_in_points_it_is_not_told(self):
        with pytest.raises(ValueError, match="nodes: expected exact"):
            ELLIPTIC.saving_behind(ELLIPTIC, y_m=B, nodes=2)


class TestStagger:
    """Munk (1923): what both wings save together does not depend on how far one is behind the other."""

    @pytest.mark.parametrize("wing", [ELLIPTIC, PAPERS], ids=["elliptic", "the paper's"])
    @pytest.mark.parametrize("x", [0.0, 0.3, 1.0, 5.0])
    def test_together_they_save_the_same(self, wing, x):
        where = {"y_m": 1.81 * B, "core_radius_m": CORE}
        together = wing.saving_behind(wing, x * B, **where) + wing.saving_behind(wing, -x * B, **where)
        assert together == pytest.approx(wing.saving_behind(wing, **where), abs=1e-8)

    @pytest.mark.parametrize("x", [0.1, 0.24, 0.5, 1.0])
    @pytest.mark.parametrize("z", [0.0, 0.2])
    def test_by_the_limit_model_with_two_wavelengths_of_wake_beyond(self, x, z):
        """The follower's gain at +x and the leader's at −x, by the model's force itself."""

        def saved(place, model):
            pose = Pose(place * WAVELENGTH, 1.81 * B, z * B, STILL, 0.0)
            return wake_force(IBIS, STILL, pose, model)[1]

        drag = saved(0.0, LIMIT) / steady_saving(1.81)
        long, longer, short = (replace(LIMIT, wavelengths=count) for count in (3, 5, 1))
        assert x + 2.0 <= long.wavelengths
        together = saved(x, long) + saved(-x, long)
        assert together == pytest.approx(2.0 * saved(0.0, long), abs=1e-3 * drag)
        # How much it is depends on the wake's end a little longer.
        assert saved(x, longer) + saved(-x, longer) == pytest.approx(saved(0.0, LIMIT), abs=1e-3 * drag)
        # It is no matter of course: each for itself depends on x, and a wake of one wavelength is too short.
        assert saved(0.1, long) < 0.85 * saved(1.0, long)
        assert saved(x, short) + saved(-x, short) != pytest.approx(together, rel=1e-2)


class TestSpeed:
    """At fixed lift the drag saved goes with 1/U², and the best place stays."""

    def test_drag_saved_falls_with_the_square_of_speed(self):
        saved = {}
        for speed in (10.0, 15.0, 25.0):
            bird = load_species("northern-bald-ibis").bird(speed_m_s=speed)
            pose = Pose(1.0, 1.81 * B, 0.0, STILL, 0.0)
            saved[speed] = wake_force(bird, STILL, pose, LIMIT)[1] * speed**2
        assert saved[10.0] == pytest.approx(saved[15.0], rel=1e-5)
        assert saved[25.0] == pytest.approx(saved[15.0], rel=1e-5)

    def test_so_do_elliptic_wings(self):
        slow, fast = (replace(ELLIPTIC, speed_m_s=speed) for speed in (10.0, 20.0))
        where = {"x_m": 1.0, "y_m": 1.1}
        assert slow.drag_saved_n(slow, **where) == pytest.approx(
            4.0 * fast.drag_saved_n(fast, **where), rel=1e-12
        )

    def test_best_overlap_does_not_depend_on_it(self):
        best = [
            best_y(lambda y, bird=bird: steady_saving(y, bird=bird))[0]
            for bird in (load_species("northern-bald-ibis").bird(speed_m_s=speed) for speed in (10.0, 25.0))
        ]
        assert best[0] == pytest.approx(best[1], abs=1e-5)
