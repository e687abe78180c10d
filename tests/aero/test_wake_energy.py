"""The energy of the rings, against a straight pair's closed form and against the velocity's own, summed over space."""

import math
from dataclasses import replace

import numpy as np
import pytest
from upwash import Bird, Stroke, WakeModel, load_species
from upwash.aero import wake_energy
from upwash.aero.induction import velocity
from upwash.aero.power import induced_power_w
from upwash.aero.span_integral import ring_velocity
from upwash.aero.wake import ROLL_UP, wake_at_phases
from upwash.aero.wake_energy import wake_power_w

IBIS = load_species("northern-bald-ibis").bird()
STILL = Stroke(1e-9, 1.0 - 1e-12)


def chain(bird: Bird, stroke: Stroke, images: int):
    """Return the rings of a chain around the wavelength from 0 on, and their circulation."""
    wake = wake_at_phases(
        [0.0],
        stroke.amplitude_m,
        stroke.span_ratio,
        bird.semispan_m,
        bird.wavelength_m,
        bird.circulation_m2_s,
        bird.circulation_ratio,
        WakeModel(wavelengths=2 * images + 1),
    )
    rings = wake.rings.copy()
    rings[:, :2] -= images * bird.wavelength_m
    return rings, wake.circulation


def energy_in_a_box(bird: Bird, stroke: Stroke, step: float, size: float, core: str) -> float:
    """Sum ρ/2 v² over one wavelength of a box whose half-width and half-height are given, in m; over the period."""
    rings, circulation = chain(bird, stroke, 4)
    counts = [round(length / step) for length in (bird.wavelength_m, size, 2.0 * size)]
    x, y, z = (
        (np.arange(count) + 0.5) * length / count
        for count, length in zip(counts, (bird.wavelength_m, size, 2.0 * size), strict=True)
    )
    total = 0.0
    for station in x:
        points = np.stack(np.broadcast_arrays(station, y[:, None], z - size), axis=-1).reshape(-1, 3)
        core_radius = 0.171 * bird.semispan_m
        if core == "rankine":
            wind = velocity(points, rings, circulation, core_radius)
        else:
            wind = ring_velocity(points, rings, circulation, core_radius, core)
        total += float((wind**2).sum())
    cell = bird.wavelength_m * size * 2.0 * size / math.prod(counts)
    # The left half has as much.
    return bird.density_kg_m3 * total * cell / bird.period_s


@pytest.mark.parametrize(("core", "of_core"), [("rankine", 0.25), ("rosenhead-moore", -0.5)])
def test_a_steady_wake_has_the_energy_of_a_straight_pair(core, of_core):
    width, radius = 2.0 * ROLL_UP * IBIS.semispan_m, 0.171 * IBIS.semispan_m
    per_metre = IBIS.density_kg_m3 * IBIS.circulation_m2_s**2 / (2.0 * math.pi)
    closed = per_metre * (math.log(width / radius) + of_core) * IBIS.speed_m_s
    assert wake_power_w(IBIS, STILL, WakeModel(core=core)) == pytest.approx(closed, rel=1e-4)


@pytest.mark.parametrize(("core", "within"), [("rankine", 0.015), ("rosenhead-moore", 0.04)])
@pytest.mark.parametrize("stroke", [IBIS.stroke, Stroke(0.7, 0.35)])
def test_a_flapping_wake_has_the_energy_of_its_velocity(core, within, stroke):
    inside = energy_in_a_box(IBIS, stroke, 0.06, 2.4, core)
    # Outside, the mean wake is a straight pair's dipole.
    moment = IBIS.circulation_m2_s * ROLL_UP * IBIS.semispan_m * (1.0 + stroke.span_ratio)
    outside = IBIS.density_kg_m3 * moment**2 / (8.0 * math.pi * 2.4**2) * IBIS.speed_m_s
    found = wake_power_w(IBIS, stroke, WakeModel(core=core))
    assert found == pytest.approx(inside + outside, rel=within)


def test_more_images_change_nothing_that_counts(monkeypatch):
    found = wake_power_w(IBIS, IBIS.stroke)
    monkeypatch.setattr(wake_energy, "IMAGES", 300)
    assert wake_power_w.__wrapped__(IBIS, IBIS.stroke) == pytest.approx(found, rel=3e-5)


def test_it_goes_with_the_square_of_circulation():
    twice = replace(IBIS, mass_kg=2.0 * IBIS.mass_kg)
    assert wake_power_w(twice, IBIS.stroke) == pytest.approx(4.0 * wake_power_w(IBIS, IBIS.stroke), rel=1e-12)


def test_a_passive_upstroke_leaves_downstrokes_alone():
    passive = replace(IBIS, circulation_ratio=0.0)
    narrow, wide = (wake_power_w(passive, Stroke(1.0, ratio)) for ratio in (0.3, 0.5))
    assert narrow == wide > 0.0


def test_the_ibiss_rings_carry_more_than_its_induced_power():
    rings, induced = wake_power_w(IBIS, IBIS.stroke), induced_power_w(IBIS, IBIS.weight_n)
    assert rings == pytest.approx(6.164, abs=1e-3)
    assert induced == pytest.approx(4.450, abs=1e-3)
