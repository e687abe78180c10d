"""What is measured of wings that do not flap, and of flapping ones as a code of higher fidelity has them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np

from upwash.aero.fixed_wing import FixedWing
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import CORE_RADIUS_RATIO
from upwash.aero.wake_energy import wake_power_w
from upwash.literature.models import IBIS, LEAST_POWER, best_phase, bird_of, v_optimum, wrapped
from upwash.literature.of_birds import Measured
from upwash.place.balance import Behind

TABLE_1 = Pose(1.83, 0.882, -0.063, Stroke(0.751, 0.347), 0.5)
"""The follower of the paper's Table 1."""


def _elliptic() -> FixedWing:
    bird = bird_of(IBIS)
    return FixedWing(bird.semispan_m, bird.weight_n, bird.speed_m_s, bird.density_kg_m3)


def _uniform() -> FixedWing:
    """The wing that both models have: of uniform loading, its vortices rolled up."""
    return replace(_elliptic(), loading="uniform", wake="pair")


def _steady(y: float, x: float | None = None, nodes: int | str = "exact", length: float = math.inf) -> float:
    """What a wing of uniform loading saves; x and the wake's length in wavelengths, y in semispans."""
    bird, wing = bird_of(IBIS), _uniform()
    return wing.saving_behind(
        wing,
        math.inf if x is None else x * bird.wavelength_m,
        y * bird.semispan_m,
        wake_length_m=length * bird.wavelength_m,
        core_radius_m=CORE_RADIUS_RATIO * bird.semispan_m,
        nodes=nodes,
    )


def _two_points(y: float) -> float:
    return _steady(y, 0.5, 2, 1.0)


@cache
def _best_aside(saving: Callable[[float], float]) -> tuple[float, float]:
    """Return the best distance aside, in semispans, and the saving there."""
    aside = np.linspace(1.2, 2.6, 701).tolist()
    found = [(saving(y), y) for y in aside]
    value, y = max(found)
    return y, value


def _best(index: int) -> Callable[[], Measured]:
    def measured() -> Measured:
        return {
            "paper": {"two points": _best_aside(_two_points)[index]},
            "limit": {"uniform loading": _best_aside(_steady)[index]},
        }

    return measured


def _elliptic_at(y: float) -> Callable[[], Measured]:
    def measured() -> Measured:
        wing = _elliptic()
        saving = wing.saving_behind(wing, y_m=y * wing.semispan_m)
        return {"paper": {}, "limit": {"by its kernel": saving}}

    return measured


@cache
def _best_elliptic() -> float:
    """Vertex of a parabola through the savings around the best place, in semispans."""
    wing = _elliptic()
    grid = np.arange(1.74, 1.91, 0.02)
    found = [wing.saving_behind(wing, y_m=y * wing.semispan_m) for y in grid.tolist()]
    return float(np.polynomial.Polynomial.fit(grid, found, 2).deriv().roots()[0])


def _best_beside_pair() -> Measured:
    wing = replace(_elliptic(), wake="pair")
    aside = np.linspace(1.7, 1.9, 41)
    found = [wing.saving_behind(wing, y_m=y * wing.semispan_m) for y in aside.tolist()]
    return {"paper": {}, "limit": {"by its kernel": float(aside[int(np.argmax(found))])}}


def _cut(*stations: float) -> Callable[[], Measured]:
    """Points of saving that a wake cut at a wavelength loses against an endless one."""

    def measured() -> Measured:
        lost = {f"{x} λ": 100.0 * (_steady(1.81) - _steady(1.81, x, length=1.0)) for x in stations}
        return {"paper": {}, "limit": lost}

    return measured


def _stagger() -> Measured:
    """Spread over x of what both wings save together, over its mean, in percent."""

    def spread(nodes: int | str, length: float) -> float:
        together = [
            _steady(1.81, x, nodes, length) + _steady(1.81, -x, nodes, length) for x in (0.1, 0.3, 0.5, 0.9)
        ]
        return 100.0 * float(np.ptp(together) / np.mean(together))

    return {"paper": {"two points": spread(2, 1.0)}, "limit": {"uniform loading": spread("exact", math.inf)}}


def _overlap_against_speed() -> Measured:
    """How far the best overlap moves from 10 to 20 m/s, in percent of the span."""
    shift: Measured = {}
    for model, nodes in (("paper", 2), ("limit", "exact")):
        best = []
        for speed in (10.0, 20.0):
            # At one wingbeat period the wavelength goes with speed.
            share = speed / bird_of(IBIS).speed_m_s
            length = share if model == "paper" else math.inf

            def saving(
                y: float, share: float = share, length: float = length, nodes: int | str = nodes
            ) -> float:
                return _steady(y, 0.5 * share, nodes, length)

            best.append(_best_aside(saving)[0])
        shift[model] = {"best": 50.0 * abs(best[1] - best[0])}
    return shift


def _overlap() -> Measured:
    """Best overlap of the wingtips, in percent of the span."""
    measured = _best(0)()
    found: Measured = {
        model: {case: 50.0 * (2.0 - y) for case, y in cases.items()} for model, cases in measured.items()
    }
    found["limit"] = {**found["limit"], "elliptic loading": 50.0 * (2.0 - _best_elliptic())}
    return found


def _against_speed() -> Measured:
    """Exponent of airspeed in the induced drag that is saved at fixed lift and fixed wake."""
    slow, fast = (replace(_uniform(), speed_m_s=speed) for speed in (10.0, 20.0))

    def exponent(nodes: int | str) -> float:
        b = slow.semispan_m
        saved = [
            wing.drag_saved_n(wing, 1.0, 1.9 * b, core_radius_m=CORE_RADIUS_RATIO * b, nodes=nodes)
            for wing in (slow, fast)
        ]
        return math.log(saved[1] / saved[0]) / math.log(2.0)

    return {"paper": {"two points": exponent(2)}, "limit": {"uniform loading": exponent("exact")}}


def _small_behind_large() -> Measured:
    """What a wing saves behind one of twice its span and eight times its weight, less what the large one saves."""
    large = _elliptic()
    small = replace(large, semispan_m=0.5 * large.semispan_m, lift_n=large.lift_n / 8.0)

    def most(wing: FixedWing, ahead: FixedWing) -> float:
        aside = np.linspace(0.7, 1.1, 21) * (wing.semispan_m + ahead.semispan_m)
        return max(wing.saving_behind(ahead, y_m=y) for y in aside.tolist())

    return {"paper": {}, "limit": {"elliptic wings": 100.0 * (most(small, large) - most(large, small))}}


def _lattice_phase(share: float) -> Callable[[], Measured]:
    """Best phase at a share of a wavelength behind, 0.9 m aside; of all that are one phase, that nearest the share."""

    def measured() -> Measured:
        bird = bird_of(IBIS)
        x_m = share * bird.wavelength_m
        return {
            model: {
                case: share + wrapped(best_phase(bird, wake, x_m, 0.9)[0] - share)
                for case, wake in cases.items()
            }
            for model, cases in LEAST_POWER.items()
        }

    return measured


def _aside(half_angle_deg: float) -> Callable[[], Measured]:
    def measured() -> Measured:
        bird = bird_of(IBIS, stroke_half_angle_deg=half_angle_deg)
        found: Measured = {}
        for model, cases in LEAST_POWER.items():
            v = {case: v_optimum(bird, "power", wake) for case, wake in cases.items()}
            found[model] = {case: each.pose.y_m if each else math.nan for case, each in v.items()}
        return found

    return measured


def _saving_at_table_1() -> Measured:
    """What the ibis saves at Table 1's place and phase with the stroke that balances there, in percent."""
    found: Measured = {}
    for model, cases in LEAST_POWER.items():
        found[model] = {}
        for case, wake in cases.items():
            strokes = (
                Behind(bird_of(IBIS), "power", model=wake).balances([(*TABLE_1.position_m, 0.5)]).strokes
            )
            found[model] = {**found[model], case: 100.0 * (1.0 - strokes[0].cost) if strokes else math.nan}
    return found


def _near_the_middle() -> Measured:
    """What the ibis saves 0.3 m aside, in the best phase, in percent."""
    return {
        model: {
            case: 100.0 * (1.0 - best_phase(bird_of(IBIS), wake, TABLE_1.x_m, 0.3)[1])
            for case, wake in cases.items()
        }
        for model, cases in LEAST_POWER.items()
    }


def _lone_wake() -> Measured:
    bird = bird_of(IBIS)
    rings = wake_power_w(bird, bird.stroke)
    return {"paper": {"rings": rings}, "limit": {"rings": rings}}


MEASURES: dict[str, Callable[[], Measured]] = {
    **{f"elliptic at {y:g} b": _elliptic_at(y) for y in (1.6, 1.82, 2.0, 2.2, 2.5, 3.0, 4.0)},
    "elliptic, best": lambda: {"paper": {}, "limit": {"by its kernel": _best_elliptic()}},
    "beside a pair, best": _best_beside_pair,
    "uniform, best": _best(0),
    "uniform, saving": _best(1),
    "two points, best": lambda: {"paper": {"two points": _best_aside(_two_points)[0]}, "limit": {}},
    "two points, saving": lambda: {"paper": {"two points": _best_aside(_two_points)[1]}, "limit": {}},
    "cut wake, inside": _cut(0.24, 0.48, 0.72),
    "cut wake, end": _cut(0.96),
    "stagger": _stagger,
    "overlap": _overlap,
    "overlap against speed": _overlap_against_speed,
    "saved against speed": _against_speed,
    "small behind large": _small_behind_large,
    **{f"lattice's phase at {x:g} λ": _lattice_phase(x) for x in (0.24, 0.48, 0.72, 0.96)},
    "aside at 60°": _aside(60.0),
    "aside at 32°": _aside(32.0),
    "at Table 1's place": _saving_at_table_1,
    "0.3 m aside": _near_the_middle,
    "lone wake": _lone_wake,
}
"""Name of a measure -> how it is taken."""
