"""What is measured of birds: where both models have them fly, what they save there, and how that goes with speed."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from upwash.aero.bird import Bird
from upwash.aero.power import COST_FUNCTIONS
from upwash.aero.wake import WakeModel
from upwash.literature.models import (
    CASES,
    IBIS,
    LEAST_POWER,
    Cases,
    best_phase,
    bird_of,
    v_optimum,
    wrapped,
)
from upwash.optimum.solution import Optimum

Measured = dict[str, Cases]
"""Model -> our value in each case; a model that cannot say has none."""

QUANTITIES: dict[str, Callable[[Bird, Optimum], float]] = {
    "distance behind, m": lambda _, v: v.pose.x_m,
    "distance behind, wingspans": lambda bird, v: v.pose.x_m / (2.0 * bird.semispan_m),
    "distance aside, m": lambda _, v: v.pose.y_m,
    "distance aside, wingspans": lambda bird, v: v.pose.y_m / (2.0 * bird.semispan_m),
    "wingtip spacing, m": lambda bird, v: v.pose.y_m - 2.0 * bird.semispan_m,
    "height, m": lambda _, v: v.pose.z_m,
    "spatial phase": lambda bird, v: wrapped(v.pose.x_m / bird.wavelength_m - v.pose.phase),
    "total saving, %": lambda _, v: 100.0 * v.saving_total,
    "induced saving, %": lambda _, v: 100.0 * v.saving_induced,
    "total cost, %": lambda _, v: -100.0 * v.saving_total,
}
"""What is asked of a V optimum -> how it follows."""

_FREE_BEHIND_AN_ENDLESS_WAKE = ("distance behind, m", "distance behind, wingspans")


def of_v(quantity: str, species: str, **changed: float) -> Measured:
    """Return a quantity of a species' V optimum in every case; not a number where there is no V."""
    bird = bird_of(species, **changed)
    measured: Measured = {}
    for model, cases in CASES.items():
        if model == "limit" and quantity in _FREE_BEHIND_AN_ENDLESS_WAKE:
            measured[model] = {}
            continue
        found = {case: v_optimum(bird, objective, wake) for case, (wake, objective) in cases.items()}
        measured[model] = {
            case: QUANTITIES[quantity](bird, v) if v else math.nan for case, v in found.items()
        }
    return measured


def _in_each(measure: Callable[[WakeModel], float]) -> Callable[[], Measured]:
    """Return a measure that is taken of each model for least power."""

    def measured() -> Measured:
        return {
            model: {case: measure(wake) for case, wake in cases.items()}
            for model, cases in LEAST_POWER.items()
        }

    return measured


def _saving_at(x_m: float, y_m: float) -> Callable[[], Measured]:
    """What an ibis saves at a place, level with its leader and in the best phase, in percent."""
    return _in_each(lambda wake: 100.0 * (1.0 - best_phase(bird_of(IBIS), wake, x_m, y_m)[1]))


def _phase_in_line(wake: WakeModel) -> float:
    """Distance in phase from the leader's path of the best place straight behind an ibis, 0 to ½."""
    bird = bird_of(IBIS)
    stations = np.linspace(1.0, 2.0 * bird.wavelength_m / bird.semispan_m * 0.6, 12) * bird.semispan_m
    found = []
    for x in stations.tolist():
        phase, cost = best_phase(bird, wake, x, 0.0)
        found.append((cost, abs(wrapped(x / bird.wavelength_m - phase))))
    return min(found)[1]


def _phase_per_wavelength() -> Measured:
    """Wingbeats by which the best phase moves from one station to the next, per wavelength."""
    bird, stations = bird_of(IBIS), (0.24, 0.48, 0.72, 0.96)
    measured: Measured = {}
    for model, cases in LEAST_POWER.items():
        measured[model] = {}
        for case, wake in cases.items():
            phases = [best_phase(bird, wake, share * bird.wavelength_m, 0.9)[0] for share in stations]
            steps = {
                f"{case}, {near} to {far} λ": ((after - before) % 1.0) / (far - near)
                for near, far, before, after in zip(stations, stations[1:], phases, phases[1:], strict=False)
            }
            measured[model] = {**measured[model], **steps}
    return measured


def _best_speed(wake: WakeModel) -> float:
    """By how much the airspeed of least energy per distance is above the lone ibis's in the V, in percent.

    To first order: the slope of what is saved over the curvature of the lone bird's cost, both at its best speed.
    """
    transport = COST_FUNCTIONS["cost_of_transport"]

    def alone(speed: float) -> float:
        bird = bird_of(IBIS, speed_m_s=speed)
        return math.log(transport.value(bird, bird.weight_n, bird.drag_n))

    def saved(speed: float) -> float:
        v = v_optimum(bird_of(IBIS, speed_m_s=speed), "power", wake)
        return math.log1p(-v.saving_total) if v else math.nan

    speeds = np.linspace(10.0, 20.0, 201)
    best = float(speeds[int(np.argmin([alone(speed) for speed in speeds.tolist()]))])
    step = 1.0
    bend = (alone(best + step) - 2.0 * alone(best) + alone(best - step)) / step**2
    slope = (saved(best + step) - saved(best - step)) / (2.0 * step)
    return 100.0 * -slope / bend / best


def _range_gain(species: str, birds: int) -> Callable[[], Measured]:
    """Range that birds gain who take the lead in turns, each follower saving what one does in the V, in percent."""

    def measured() -> Measured:
        saving = of_v("total saving, %", species)
        share = (birds - 1.0) / birds / 100.0
        return {
            model: {case: 100.0 * (1.0 / (1.0 - share * value) - 1.0) for case, value in cases.items()}
            for model, cases in saving.items()
        }

    return measured


def _phase_at_four_metres(wake: WakeModel) -> float:
    """Best lag of a Canada goose 4 m behind another, as far aside as in its V, in degrees."""
    bird = bird_of("canada-goose")
    v = v_optimum(bird, "power", wake)
    return 360.0 * best_phase(bird, wake, 4.0, v.pose.y_m)[0] if v else math.nan


MEASURES: dict[str, Callable[[], Measured]] = {
    "ibis at 1.2, 0.904 m": _saving_at(1.2, 0.904),
    "ibis at 1.2, 1.1 m": _saving_at(1.2, 1.1),
    "phase in line": _in_each(_phase_in_line),
    "phase per wavelength": _phase_per_wavelength,
    "best speed": _in_each(_best_speed),
    "range of 25 ibises": _range_gain(IBIS, 25),
    "range of 14 Canada geese": _range_gain("canada-goose", 14),
    "goose's phase at 4 m": _in_each(_phase_at_four_metres),
}
"""Name of a measure -> how it is taken; those of a V optimum are `of_v`."""
