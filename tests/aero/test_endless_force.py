"""The force of an endless wake on a whole span: against published check values, brute force and quadrature."""

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from upwash.aero.compiled.endless import endless_force_jacobian, fill_endless_force
from upwash.aero.endless import Window, compiled_endless_wake, endless_window
from upwash.aero.induction import velocity
from upwash.aero.interaction import phase_weights, wake_force
from upwash.aero.pose import Pose, Stroke
from upwash.aero.span_integral import ring_velocity, span_antiderivative
from upwash.aero.wake import WakeModel, vortex_wake, wake_at_phases
from upwash.aero.wingbeat import wingbeat_steps

LIMIT = WakeModel.named("limit")
TIP = replace(LIMIT, stroke_rule="held", span_law="tip")
SOFT = replace(LIMIT, core="rosenhead-moore")
WIDE = replace(LIMIT, core_radius_ratio=0.4)
EACH_MODEL = pytest.mark.parametrize("model", [LIMIT, TIP, SOFT, WIDE], ids=["limit", "tip", "soft", "wide"])


gauss = functools.cache(np.polynomial.legendre.leggauss)


def force_of(bird, ahead_amplitude, ahead_ratio, place, amplitude, ratio, phase, model=None):
    """Return lift and thrust in N of a place in m, a stroke and a phase."""
    pose = Pose(*place, Stroke(amplitude, ratio), phase)
    return wake_force(bird, Stroke(ahead_amplitude, ahead_ratio), pose, model)


def random_followers(bird, count, seed=0):
    """Return followers in semispans: spatial phase, y, z, amplitude, upstroke span ratio."""
    tall = bird.amplitude_m / bird.semispan_m
    low, high = [-0.25, 0.0, -tall, 0.25 * tall, 0.3], [0.75, 4.0, tall, tall, 0.5]
    return np.random.default_rng(seed).uniform(low, high, (count, 5))


def plain_force(bird, follower, model):
    """Return lift and thrust in N by the plain statement of the model."""
    phase, y, z, amplitude, ratio = follower
    b = bird.semispan_m
    place = phase * bird.wavelength_m, y * b, z * b
    ahead = bird.amplitude_m, bird.upstroke_span_ratio
    return np.array(force_of(bird, *ahead, place, amplitude * b, ratio, 0.0, model))


def compiled_wake(bird, model):
    """Lay out the bird's own wake, lengths in semispans and forces in N."""
    b = bird.semispan_m
    shed = (bird.amplitude_m / b, bird.upstroke_span_ratio, 1.0, bird.wavelength_m / b, 1.0)
    windows = [endless_window(down, *shed, bird.circulation_ratio) for down in (True, False)]
    steps = wingbeat_steps(model)
    per_wind = bird.density_kg_m3 * bird.circulation_m2_s**2 * steps.circulation(bird.circulation_ratio)
    return compiled_endless_wake(
        tuple(windows), steps, per_wind, bird.wavelength_m / b, model.core_radius_ratio, model.core
    )


def compiled_force(follower, wake):
    jacobian = np.full((2, 5), np.nan)
    force = endless_force_jacobian(follower, wake, np.empty((4, wake.steps.shape[1])), jacobian)
    return np.array(force), jacobian


@pytest.mark.parametrize(
    ("follower", "held", "tip", "stroke"),
    [
        ((1.83, 0.882, -0.063, 0.751, 0.347, 0.5), (0.010293, 0.153551), (0.01053, 0.15272), (0.01907, 0.05919)),
        ((1.2, 0.904, 0.0, 0.95, 0.39, 0.32), (-0.005853, 0.162493), (-0.00404, 0.16260), (0.00838, 0.07085)),
        ((0.1, 0.825, -0.0145, 0.954, 0.398, 0.05), (0.022553, 0.175491), (0.02232, 0.17470), (0.03912, 0.04341)),
    ],
)  # fmt: skip
def test_an_independent_implementation_finds_the_same_forces(ibis, follower, held, tip, stroke):
    x, y, z, amplitude, ratio, phase = follower
    for model, expected, digits in (
        (TIP, held, 1e-6),
        (replace(LIMIT, stroke_states=512, span_law="tip"), tip, 2e-5),
        (replace(LIMIT, stroke_states=512), stroke, 2e-5),
    ):
        force = force_of(ibis, ibis.amplitude_m, 0.4, (x, y, z), amplitude, ratio, phase, model)
        assert force == pytest.approx(expected, abs=digits)


def brute_force(bird, follower, model, images, points):
    """Sum the rings of many wavelengths at many points of the span, by the velocity of filaments."""
    phase, y, z, amplitude, ratio = follower
    b, wavelength, steps = bird.semispan_m, bird.wavelength_m, wingbeat_steps(model)
    chain = vortex_wake(
        bird.amplitude_m, bird.upstroke_span_ratio, b, wavelength, bird.circulation_m2_s, bird.circulation_ratio
    )  # fmt: skip
    # One wavelength as it lies at the end of an upstroke, repeated both ways.
    rings, circulation = chain.rings[chain.state == 0], chain.circulation[chain.state == 0]
    shifts = [n * wavelength * np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]) for n in range(-images - 1, images)]
    rings, circulation = np.concatenate([rings + s for s in shifts]), np.tile(circulation, len(shifts))
    nodes, weights = gauss(points)
    total = np.zeros(2)
    for k in range(steps.phase.size):
        half_span = b * (1.0 - steps.flexed[k] + steps.flexed[k] * ratio)
        at = np.empty((points, 3))
        at[:, 0] = wavelength * ((phase - steps.phase[k] + 0.5) % 1.0 - 0.5)
        at[:, 1] = y * b + half_span * nodes
        at[:, 2] = z * b + amplitude * b * steps.height[k]
        wind = weights @ velocity(at, rings, circulation, model.core_radius_ratio * b)[:, [0, 2]]
        wing = bird.circulation_m2_s * steps.circulation(bird.circulation_ratio)[k]
        total += steps.weight[k] * bird.density_kg_m3 * wing * half_span * wind
    return total


@pytest.mark.parametrize("model", [LIMIT, TIP], ids=["limit", "tip"])
def test_sixty_images_and_1200_points_make_the_same_force(ibis, model):
    for follower in random_followers(ibis, 10, seed=len(model.span_law)):
        expected = brute_force(ibis, follower, model, 60, 1200)
        assert plain_force(ibis, follower, model) == pytest.approx(expected, abs=2e-6)


@EACH_MODEL
@pytest.mark.parametrize("ratio", [1.0, 0.5, 0.0])
def test_the_compiled_force_is_the_force_of_the_model(ibis, model, ratio):
    bird = replace(ibis, circulation_ratio=ratio)
    wake = compiled_wake(bird, model)
    for follower in random_followers(bird, 15):
        force, _ = compiled_force(follower, wake)
        assert force == pytest.approx(plain_force(bird, follower, model), rel=1e-12, abs=1e-13)


def test_many_followers_at_once_feel_what_each_feels(ibis):
    wake, followers = compiled_wake(ibis, LIMIT), random_followers(ibis, 30)
    forces = np.empty((30, 2))
    fill_endless_force(followers, wake, forces)
    assert forces == pytest.approx(np.array([compiled_force(each, wake)[0] for each in followers]), rel=1e-14)


def distance_from_edges(follower, wake):
    """Return how near a follower comes to where its Jacobian jumps: the core edges of the spanwise filaments."""
    nearest = math.inf
    for window in range(2):
        chosen = slice(0, wake.downstroke_steps) if window == 0 else slice(wake.downstroke_steps, None)
        x = wake.wavelength * (follower[0] + wake.steps[0, chosen])
        z = follower[2] + wake.steps[1, chosen] * follower[3]
        for station in (0, 1):
            distance = np.hypot(
                x[:, None] - wake.runs[window, station], z[:, None] - wake.runs[window, 2 + station]
            )
            nearest = min(nearest, np.min(np.abs(distance - math.sqrt(wake.core.least))))
    return nearest


@EACH_MODEL
def test_the_jacobian_agrees_with_central_differences(slack_ibis, model):
    wake, step, tried = compiled_wake(slack_ibis, model), 1e-4, 0
    for follower in random_followers(slack_ibis, 400, seed=2):
        if wake.core.least > 0.0 and distance_from_edges(follower, wake) < 20 * step:
            continue
        tried += 1
        _, jacobian = compiled_force(follower, wake)
        for variable in range(5):
            shift = step / (6.0 if variable == 0 else 1.0) * np.eye(5)[variable]
            near, far = (
                compiled_force(follower + k * shift, wake)[0] - compiled_force(follower - k * shift, wake)[0]
                for k in (1, 2)
            )
            slope = (8.0 * near - far) / (12.0 * np.max(shift))
            assert slope == pytest.approx(jacobian[:, variable], rel=1e-6, abs=1e-7 * slack_ibis.weight_n)
    assert tried >= 15


def core_edges(x, z, rings, core_radius):
    """Return the places along y where a line of constant x and z enters or leaves the core of a tip filament."""
    first_x, last_x, first_z, last_z, _, half_width = rings.T
    run = np.hypot(last_x - first_x, last_z - first_z)
    d = ((last_z - first_z) * (x - first_x) - (last_x - first_x) * (z - first_z)) / run
    chord = np.sqrt(np.maximum(core_radius**2 - d**2, 0.0))
    return np.concatenate([side * half_width + way * chord for side in (1, -1) for way in (1, -1)])


def broken_gauss(low, high, breaks, points):
    """Return so many Gauss–Legendre nodes, and weights, between each two of the places where a range is broken."""
    ends = np.unique(np.concatenate([[low, high], breaks[(breaks > low) & (breaks < high)]]))
    nodes, weights = gauss(points)
    middle, half = 0.5 * (ends[1:] + ends[:-1])[:, None], 0.5 * np.diff(ends)[:, None]
    return (middle + half * nodes).ravel(), (half * weights).ravel()


@pytest.mark.parametrize("core", ["rankine", "rosenhead-moore"])
def test_the_closed_form_is_the_integral_over_the_span(ibis, core):
    rng = np.random.default_rng(4)
    wake = vortex_wake(ibis.amplitude_m, 0.4, 0.6, ibis.wavelength_m, ibis.circulation_m2_s)
    rings, circulation = wake.rings[wake.state == 0], wake.circulation[wake.state == 0]
    for _ in range(20):
        x, z, y, span = rng.uniform([0.0, -1.0, -1.0, 0.2], [4.0, 1.0, 2.0, 0.6])
        nodes, weights = broken_gauss(y - span, y + span, core_edges(x, z, rings, 0.1), 500)
        at = np.stack(np.broadcast_arrays(x, nodes, z), axis=-1)
        wind = ring_velocity(at, rings, circulation, 0.1, core)[:, [0, 2]]
        right, left = (
            np.array(span_antiderivative(x, y + side * span, z, rings, circulation, 0.1, core))
            for side in (1, -1)
        )
        force = ibis.density_kg_m3 * ibis.circulation_m2_s
        assert force * (right - left) == pytest.approx(force * (weights @ wind), abs=1e-7)


def test_velocity_by_the_closed_form_is_the_sum_over_filaments(ibis):
    rng = np.random.default_rng(5)
    wake = vortex_wake(ibis.amplitude_m, 0.4, 0.6, ibis.wavelength_m, ibis.circulation_m2_s)
    points = rng.uniform([0.0, -1.0, -1.0], [4.0, 1.0, 1.0], (300, 3))
    expected = velocity(points, wake.rings, wake.circulation, 0.1026)
    assert ring_velocity(points, wake.rings, wake.circulation, 0.1026) == pytest.approx(expected, abs=1e-12)


def test_at_the_paper_s_resolution_the_general_statement_is_the_paper_s(ibis):
    """Wakes at any phases, rings by the closed form's velocity: N = 2, M = 2, one wavelength."""
    rng = np.random.default_rng(6)
    ahead, b = (ibis.amplitude_m, 0.4), ibis.semispan_m
    wake = wake_at_phases([0.0, 0.5], *ahead, b, ibis.wavelength_m, ibis.circulation_m2_s)
    for _ in range(20):
        place = rng.uniform([0.0, 0.0, -1.0], [5.0, 2.4, 1.0])
        amplitude, ratio, phase = rng.uniform([0.3, 0.3, 0.0], [1.0, 0.5, 1.0])
        weights, force = phase_weights(phase), np.zeros(2)
        for leader in range(2):
            for k, (span, height) in enumerate(((ratio * b, 0.5), (b, -0.5))):
                tips = place + np.array([[0.0, side * span, height * amplitude] for side in (1, -1)])
                of_state = wake.state == leader
                wind = ring_velocity(tips, wake.rings[of_state], wake.circulation[of_state], 0.171 * b)
                own = ibis.density_kg_m3 * ibis.circulation_m2_s * span
                force += weights[leader, k] * own * wind.sum(axis=0)[[0, 2]]
        assert force_of(ibis, *ahead, place, amplitude, ratio, phase) == pytest.approx(
            force, rel=1e-13, abs=1e-14
        )


def wind_error(bird, reach, is_cut=False):
    """Return the largest error of the thrust, in drags, of so many wavelengths of single runs on each side."""
    shed = (bird.amplitude_m, 0.4, bird.semispan_m, bird.wavelength_m, bird.circulation_m2_s)
    rng, worst = np.random.default_rng(7), 0.0
    for down in (True, False):
        exact, near = endless_window(down, *shed, reach=40), endless_window(down, *shed, reach=reach)
        if is_cut:
            near = replace(near, tails=())
        x = bird.wavelength_m * rng.uniform(-0.5, 0.5, 200)
        z, span = rng.uniform(-1.0, 1.0, 200), np.full(200, bird.semispan_m)
        for y in (0.0, 0.9, 1.8):
            winds = [window.mean_wind(x, y, z, span, 0.1026, LIMIT)[:, 1] for window in (exact, near)]
            worst = max(worst, np.max(np.abs(winds[1] - winds[0])))
    return worst * 2.0 * bird.semispan_m * bird.density_kg_m3 * bird.circulation_m2_s / bird.drag_n


def test_what_is_beyond_the_window_matters_and_its_mean_is_enough(ibis):
    errors = {reach: wind_error(ibis, reach) for reach in (1, 2, 4, 8)}
    assert errors[4] < 3e-7
    # The first term left out falls with the fifth power of the distance.
    assert errors[8] < errors[4] / 2**4 and errors[4] < errors[2] / 2**4
    assert wind_error(ibis, 4, is_cut=True) > 300 * errors[4]


def test_the_leading_tail_alone_is_as_good_as_is_known(ibis):
    """Without second derivatives: 1e-4 of the drag with one image on each side, 1e-5 with two, 3e-6 with three."""

    def leading(window: Window) -> Window:
        return replace(
            window, tails=tuple(replace(t, curved=0.0, stretched=0.0, spread=0.0) for t in window.tails)
        )

    shed = (ibis.amplitude_m, 0.4, ibis.semispan_m, ibis.wavelength_m, ibis.circulation_m2_s)
    rng, steps = np.random.default_rng(8), wingbeat_steps(LIMIT)
    for reach, known in ((2, 6e-5), (4, 3e-6), (8, 2e-7)):
        worst = 0.0
        for _ in range(20):
            y, z, phase = rng.uniform([0.0, -1.0, 0.0], [2.0, 1.0, 1.0])
            force = np.zeros(2)
            for down in (True, False):
                chosen = steps.is_downstroke == down
                exact = endless_window(down, *shed, reach=40)
                near = leading(endless_window(down, *shed, reach=reach))
                x = ibis.wavelength_m * ((phase - steps.phase[chosen] - exact.middle + 0.5) % 1.0 - 0.5)
                height, span = z + steps.height[chosen], np.full(x.size, 0.6 if down else 0.24)
                difference = np.subtract(
                    *(w.mean_wind(x, y, height, span, 0.1026, LIMIT) for w in (exact, near))
                )
                force += (
                    1.2 * ibis.density_kg_m3 * ibis.circulation_m2_s * (steps.weight[chosen] @ difference)
                )
            worst = max(worst, abs(force[1]))
        assert worst / ibis.drag_n < known


def test_forwards_and_upwards_are_alike(ibis):
    """F(Φ, y, z) = F(−Φ, y, −z) for the stroke law, up to what the window leaves out."""
    for follower in random_followers(ibis, 20, seed=9):
        follower[0] = abs(follower[0]) % 0.25
        mirrored = follower * [-1.0, 1.0, -1.0, 1.0, 1.0]
        assert plain_force(ibis, mirrored, LIMIT) == pytest.approx(
            plain_force(ibis, follower, LIMIT), abs=1e-6
        )


def test_spatial_phase_is_all_that_counts_of_place_and_time(ibis):
    ahead = ibis.amplitude_m, 0.4
    here = force_of(ibis, *ahead, (1.0, 0.9, 0.1), 0.9, 0.4, 0.3, LIMIT)
    for beats in (0.25, 1.0, -2.6):
        there = 1.0 + beats * ibis.wavelength_m, 0.9, 0.1
        assert force_of(ibis, *ahead, there, 0.9, 0.4, 0.3 + beats, LIMIT) == pytest.approx(here, abs=1e-6)


def rankine_pair_thrust(bird, y, core):
    """Thrust of a wing in the wind of two infinite vortices, π/4 of a semispan to each side."""
    b = bird.semispan_m

    def swirl(e):
        return 0.5 * min(abs(e) / core, 1.0) ** 2 + max(math.log(abs(e) / core), 0.0)

    edges = [
        swirl(y + side * b + vortex) for side in (1, -1) for vortex in (-math.pi / 4 * b, math.pi / 4 * b)
    ]
    wind = bird.circulation_m2_s / (2.0 * math.pi) * (edges[0] - edges[1] - edges[2] + edges[3])
    return bird.density_kg_m3 * bird.circulation_m2_s * wind


@pytest.mark.parametrize("y", [0.0, 0.7, 1.1, 1.5])
def test_without_flapping_the_wake_is_two_straight_vortices(make_ibis, y):
    glider = make_ibis(amplitude_m=1e-4, upstroke_span_ratio=0.7853)
    level = replace(glider, upstroke_span_ratio=0.7853)
    # Steady flight needs an unflexed wing behind unflexed rings; the latter are set here.
    force = force_of(level, 1e-6, 1.0 - 1e-9, (1.0, y, 0.0), 1e-6, 1.0 - 1e-9, 0.3, LIMIT)
    assert force[1] == pytest.approx(rankine_pair_thrust(level, y, 0.171 * 0.6), rel=1e-3)
    assert abs(force[0]) < 1e-6 * level.weight_n


@pytest.mark.parametrize("core", ["rankine", "rosenhead-moore"])
@pytest.mark.parametrize("wavelengths", [1, 3, math.inf])
@pytest.mark.parametrize("rule", ["held", "gauss"])
def test_many_points_across_the_span_tend_to_the_exact_integral(ibis, core, wavelengths, rule):
    model = WakeModel(8, rule, "exact", wavelengths, core)
    at = ibis.amplitude_m, 0.4, (1.1, 0.8, 0.1), 0.9, 0.4, 0.2
    exact = force_of(ibis, *at, model)
    errors = [
        np.max(np.abs(np.subtract(force_of(ibis, *at, replace(model, span_nodes=m)), exact)))
        for m in (9, 901)
    ]
    assert errors[1] < 3e-6 and errors[1] < errors[0] / 100


def test_a_longer_wake_tends_to_one_that_never_ends_but_for_its_beginning(ibis):
    """Two wavelengths from both ends, the cut wake feels endless."""
    model = replace(LIMIT, stroke_states=8)
    at = ibis.amplitude_m, 0.4, (2.5 * ibis.wavelength_m, 0.9, 0.0), 0.9, 0.4, 0.5
    endless = np.array(force_of(ibis, *at, model))
    errors = [np.max(np.abs(force_of(ibis, *at, replace(model, wavelengths=n)) - endless)) for n in (3, 5, 9)]
    assert errors[0] > errors[1] and errors[1] < 2e-3 * ibis.drag_n and errors[2] < errors[1] * 1.01
