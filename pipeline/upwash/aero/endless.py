"""The endless wake: what a follower far downstream of its leader feels of a wake that repeats itself for ever.

Frozen in the air, at X = x − λθ, the wake repeats with the wavelength λ and continues both ways, so place and phase of
the follower enter through the spatial phase Φ = x/λ − κ alone.  The sum over all its runs is taken in two parts: those
in a window of four wavelengths on each side of its middle, run by run, and what is beyond, in the mean.

Each kind of run (downstroke or upstroke) of circulation G and half-width w that follow one another at a distance λ from
x_c − λ/2 on has the far potential of

    G/2 of a straight vortex pair that starts at x_c, and ∓G h/λ of a point source (here one along the span) there,

and of their second derivatives; with D = ∂/∂x, I the potential of a spanwise segment at x_c and m its tilt (1 where
it rises downstream),

    φ = −½ ∂_z D⁻¹ I + m (h/λ) I + (λ²/64 + h²/16) D ∂_z I − m (h λ/32) D² I − m (h λ/48 − h³/24λ) ∂_z² I.

The first two are the mean of the runs, the others come from their length (a run of λ/2 in a cell of λ; 1/2 cosh(λD/4)
is the sum of all) and from their tilt.  What is left out falls with the fifth power of the distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from upwash.aero.bird import Bird
from upwash.aero.compiled.endless import LEAST_PHASE, EndlessWake
from upwash.aero.compiled.exact_span import Core
from upwash.aero.pose import Stroke
from upwash.aero.span_integral import ring_velocity, span_antiderivative, span_nodes
from upwash.aero.wake import ROLL_UP, WakeModel
from upwash.aero.wingbeat import Steps, wingbeat_steps

REACH = 4
"""Wavelengths of single runs on each side of the window's middle."""


@dataclass(frozen=True)
class Tail:
    """One kind of run beyond one end of the window, in the mean.

    Attributes
    ----------
    side : float
        1 downstream, −1 upstream.
    start : float
        Distance x_c from the window's middle, in the unit of length.
    half_width : float
        Half-width of the runs.
    circulation : float
        Circulation of the runs.
    source, curved, stretched, spread : float
        Coefficients of I, D ∂_z I, D² I and of the sum D² I + ∂_z² I in the potential, seen along `side`.
    """

    side: float
    start: float
    half_width: float
    circulation: float
    source: float
    curved: float
    stretched: float
    spread: float

    def antiderivative(
        self, x: ArrayLike, y: ArrayLike, z: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the antiderivative over y of its v_x and v_z, as `span_antiderivative` does for rings.

        Along the span, I becomes e asinh(e/√q) − n at each end e = y ± w, with q = ξ² + z² and n² = q + e², whose
        derivative by q is −n/2q; D⁻¹ of I's second derivative over y becomes −log(n − ξ).
        """
        x, y, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float), np.asarray(z, float))
        xi = self.side * x - self.start
        moments = np.zeros((4, *x.shape))
        for corner in (1.0, -1.0):
            n = np.sqrt(xi * xi + z * z + (y + corner * self.half_width) ** 2)
            moments += corner * np.array([n, 1.0 / n, 1.0 / n**3, np.log(n - xi)])
        return self._slopes(xi, z, moments)

    def velocity(
        self, x: ArrayLike, y: ArrayLike, z: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return its v_x and v_z: the same, of the corners' slopes over y."""
        x, y, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(y, float), np.asarray(z, float))
        xi = self.side * x - self.start
        moments = np.zeros((4, *x.shape))
        for corner in (1.0, -1.0):
            e = y + corner * self.half_width
            n = np.sqrt(xi * xi + z * z + e * e)
            moments += corner * e * np.array([1.0 / n, -1.0 / n**3, -3.0 / n**5, 1.0 / (n * (n - xi))])
        return self._slopes(xi, z, moments)

    def _slopes(
        self, xi: NDArray[np.float64], z: NDArray[np.float64], moments: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the potential's slopes over x and z, linear in what the corners contribute."""
        n, per_n, per_n3, log = moments
        q = xi * xi + z * z
        g1 = -n / (2.0 * q)
        g2 = -per_n / (4.0 * q) + n / (2.0 * q**2)
        g3 = per_n3 / (8.0 * q) + per_n / (2.0 * q**2) - n / q**3
        i_x, i_z = 2.0 * xi * g1, 2.0 * z * g1
        i_xxx, i_xxz = 12.0 * xi * g2 + 8.0 * xi**3 * g3, 4.0 * z * g2 + 8.0 * xi**2 * z * g3
        i_xzz = 4.0 * xi * g2 + 8.0 * xi * z**2 * g3
        by_x = -0.5 * i_z + self.source * i_x + self.curved * i_xxz
        by_x += self.stretched * i_xxx + self.spread * xi * per_n3
        by_z = 0.5 * (i_x - log) + self.source * i_z + self.curved * i_xzz
        by_z += self.stretched * i_xxz + self.spread * z * per_n3
        strength = self.circulation / (4.0 * math.pi)
        return self.side * strength * by_x, strength * by_z


@dataclass(frozen=True)
class Window:
    """The endless wake as seen from the middle of a window.

    Attributes
    ----------
    middle : float
        Where the middle lies in the frozen wake, in wavelengths: X/λ.
    rings : (n, 6) ndarray of float
        Runs within the window, the downstrokes' first, as in `upwash.aero.wake.Wake`.
    circulation : (n,) ndarray of float
        Their circulation.
    is_downstroke : (n,) ndarray of bool
        Their kind.
    tails : tuple of Tail
        What is beyond.
    """

    middle: float
    rings: NDArray[np.float64]
    circulation: NDArray[np.float64]
    is_downstroke: NDArray[np.bool_]
    tails: tuple[Tail, ...]

    def mean_wind(
        self,
        x: NDArray[np.float64],
        y: float,
        z: NDArray[np.float64],
        half_span: NDArray[np.float64],
        core_radius: float,
        model: WakeModel,
    ) -> NDArray[np.float64]:
        """Return v_x and v_z of the whole wake, averaged over spans.

        Parameters
        ----------
        x, z : (n,) ndarray of float
            Station, from the window's middle, and height of each span.
        y : float
            Where they are centred.
        half_span : (n,) ndarray of float
            Half their lengths.
        core_radius : float
            Radius of the filaments' cores.
        model : WakeModel
            The core and the points across the span.

        Returns
        -------
        (n, 2) ndarray of float
        """
        if not isinstance(model.span_nodes, int):
            total = np.zeros((2, *x.shape))
            for sign in (1.0, -1.0):
                at = x, y + sign * half_span, z
                total += sign * np.array(
                    span_antiderivative(*at, self.rings, self.circulation, core_radius, model.core)
                )
                for tail in self.tails:
                    total += sign * np.array(tail.antiderivative(*at))
            return (total / (2.0 * half_span)).T
        mean = np.zeros((*x.shape, 2))
        for node, weight in zip(*span_nodes(model.span_nodes), strict=True):
            at = x, y + node * half_span, z
            points = np.stack(np.broadcast_arrays(*at), axis=-1)
            wind = ring_velocity(points, self.rings, self.circulation, core_radius, model.core)
            mean += weight * wind[:, [0, 2]]
            for tail in self.tails:
                mean += weight * np.array(tail.velocity(*at)).T
        return mean


def endless_window(
    on_downstroke: bool,
    amplitude: float,
    upstroke_span_ratio: float,
    semispan: float,
    wavelength: float,
    circulation: float,
    circulation_ratio: float = 1.0,
    reach: int = REACH,
) -> Window:
    """Return the endless wake as a follower feels it on its downstroke or on its upstroke.

    The window's middle is where a downstroke ends (X = 0) or begins (X = −λ/2) in the frozen wake: there the
    follower is on the same half stroke, within three quarters of a wavelength, for all spatial phases from −¼ to ¾.

    Parameters
    ----------
    on_downstroke : bool
        Whether the follower is on its downstroke.
    amplitude, upstroke_span_ratio : float
        The leader's stroke.
    semispan, wavelength, circulation, circulation_ratio
        As for `upwash.aero.wake.vortex_wake`.
    reach : int
        Wavelengths of single runs on each side of the middle.
    """
    half, quarter = 0.5 * wavelength, 0.25 * wavelength
    rings, strengths, kinds, tails = [], [], [], []
    for is_down in (True, False):
        tilt = 1.0 if is_down else -1.0
        half_width = ROLL_UP * semispan * (1.0 if is_down else upstroke_span_ratio)
        strength = circulation * (1.0 if is_down else circulation_ratio)
        # The run of this kind that is nearest to the middle is centred a quarter of a wavelength up- or downstream.
        centre = -quarter if is_down == on_downstroke else quarter
        rise = tilt * 0.5 * amplitude
        begin = centre - quarter if centre > 0.0 else centre - quarter + wavelength
        for number in range(2 * reach):
            first = begin + (number - reach) * wavelength
            rings.append([first, first + half, -rise, rise, 0.0, half_width])
            strengths.append(strength)
            kinds.append(is_down)
        for side in (1.0, -1.0):
            slope = side * tilt * amplitude
            # From its end at reach · λ on, the window lacks this kind after a quarter or three of a wavelength.
            lacks = quarter if (centre > 0.0) == (side > 0.0) else 3.0 * quarter
            stretched = -slope * wavelength / 32.0
            spread = -slope * wavelength / 48.0 + slope * amplitude**2 / (24.0 * wavelength)
            tails.append(
                Tail(
                    side,
                    reach * wavelength + lacks - half,
                    half_width,
                    strength,
                    slope / wavelength,
                    wavelength**2 / 64.0 + amplitude**2 / 16.0,
                    stretched - spread,
                    spread,
                )
            )
    middle = 0.0 if on_downstroke else -0.5
    return Window(middle, np.array(rings), np.array(strengths), np.array(kinds), tuple(tails))


def wrapped_phase(spatial_phase: float) -> float:
    """Return a spatial phase in the range that the windows are made for, −¼ to ¾."""
    return spatial_phase - math.floor(spatial_phase - LEAST_PHASE)


def endless_wind(
    windows: tuple[Window, Window],
    spatial_phase: float,
    place: tuple[float, float],
    amplitude: float,
    half_span: NDArray[np.float64],
    wavelength: float,
    core_radius: float,
    model: WakeModel,
    steps: Steps,
) -> NDArray[np.float64]:
    """Return the wind of an endless wake, averaged over the follower's span, in each step of its wingbeat.

    Parameters
    ----------
    windows : tuple of two Window
        For the follower's downstroke and its upstroke.
    spatial_phase : float
        Φ = x/λ − κ, any number.
    place : tuple of 2 float
        y and z of the follower.
    amplitude : float
        Its amplitude.
    half_span : (n,) ndarray of float
        Its half-span in each step.
    wavelength, core_radius : float
        Lengths.
    model : WakeModel
        The core and the points across the span.
    steps : Steps
        The follower's steps.

    Returns
    -------
    (n, 2) ndarray of float
        Mean v_x and v_z in each step.
    """
    phase = wrapped_phase(spatial_phase)
    wind = np.empty((steps.phase.size, 2))
    for window, chosen in zip(windows, (steps.is_downstroke, ~steps.is_downstroke), strict=True):
        x = wavelength * (phase - steps.phase_in_stroke[chosen] - window.middle - steps.lag[chosen])
        height = place[1] + amplitude * steps.height[chosen]
        wind[chosen] = window.mean_wind(x, place[0], height, half_span[chosen], core_radius, model)
    return wind


def endless_wake_of(
    bird: Bird,
    ahead: Stroke,
    model: WakeModel,
    unit_n: float = 1.0,
    *,
    leader: Bird | None = None,
    phase_lock: bool = True,
) -> EndlessWake:
    """Lay out the endless wake of a bird for the compiled force: lengths in the follower's semispans, forces in a unit.

    Parameters
    ----------
    bird, ahead, model, leader, phase_lock
        As for `upwash.aero.interaction.wake_force`; the span must be felt as a whole.
    unit_n : float
        The unit of force, in N.
    """
    leader = leader or bird
    steps, b = wingbeat_steps(model, phase_lock), bird.semispan_m
    wavelength, semispan = leader.wavelength_m / b, leader.semispan_m / b
    # In the follower's own circulation, so that of like birds it is 1.
    circulation = leader.circulation_m2_s / bird.circulation_m2_s
    shed = (
        ahead.amplitude_m / b,
        ahead.span_ratio,
        semispan,
        wavelength,
        circulation,
        leader.circulation_ratio,
    )
    unit = bird.density_kg_m3 * bird.circulation_m2_s**2 / unit_n
    return compiled_endless_wake(
        (endless_window(True, *shed), endless_window(False, *shed)),
        steps,
        unit * steps.circulation(bird.circulation_ratio),
        wavelength,
        model.core_radius_ratio * semispan,
        model.core,
    )


def compiled_endless_wake(
    windows: tuple[Window, Window],
    steps: Steps,
    per_wind: NDArray[np.float64],
    wavelength: float,
    core_radius: float,
    core: str,
) -> EndlessWake:
    """Lay out an endless wake for the compiled force.

    Parameters
    ----------
    windows : tuple of two Window
        For the follower's downstroke and its upstroke, in semispans, with their circulation in any unit.
    steps : Steps
        The follower's steps.
    per_wind : (n,) ndarray of float
        Force per ∫ v dy in each step, without the step's weight.
    wavelength, core_radius : float
        In semispans.
    core : str
        ``rankine`` or ``rosenhead-moore``.
    """
    runs = np.empty((2, 9, windows[0].circulation.size))
    tails = np.empty((2, 8, len(windows[0].tails)))
    for number, window in enumerate(windows):
        first_x, last_x, first_z, last_z, _, half_width = window.rings.T
        length = np.hypot(last_x - first_x, last_z - first_z)
        runs[number] = [
            first_x,
            last_x,
            first_z,
            last_z,
            half_width,
            (last_x - first_x) / length,
            (last_z - first_z) / length,
            window.circulation / (4.0 * math.pi),
            window.is_downstroke,
        ]
        for k, tail in enumerate(window.tails):
            tails[number, :, k] = [
                tail.side,
                tail.start,
                tail.half_width,
                tail.circulation / (4.0 * math.pi),
                tail.source,
                tail.curved,
                tail.stretched,
                tail.spread,
            ]
    order = np.concatenate([np.flatnonzero(steps.is_downstroke), np.flatnonzero(~steps.is_downstroke)])
    middle = np.where(steps.is_downstroke, windows[0].middle, windows[1].middle)
    rows = [
        -steps.phase_in_stroke - middle - steps.lag,
        steps.height,
        1.0 - steps.flexed,
        steps.flexed,
        steps.weight * per_wind,
    ]
    core2 = core_radius * core_radius
    return EndlessWake(
        wavelength,
        Core(core2, 0.0, 1.0 / core2) if core == "rankine" else Core(0.0, core2, 1.0 / core2),
        runs,
        tails,
        np.ascontiguousarray(np.array(rows)[:, order]),
        int(np.count_nonzero(steps.is_downstroke)),
    )
