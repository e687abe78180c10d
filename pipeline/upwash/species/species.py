"""A species: its sourced quantities, three conventions for its amplitude, and the bird for the physics."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from upwash.aero.atmosphere import CEILING_M, density_kg_m3
from upwash.aero.bird import Bird
from upwash.aero.checked import at_most, not_negative, rules_of
from upwash.aero.drag import DragPolar
from upwash.aero.power import BODY_DRAG_COEFFICIENT
from upwash.errors import UpwashError
from upwash.species.file import did_you_mean, printable
from upwash.species.groups import GROUPS, groups_of, outside
from upwash.species.quantity import HALF_ANGLE_DEG, Formation, Quantity

AMPLITUDE_CONVENTIONS = {
    "stroke-angle": "h = 2 b sin(stroke half-angle of the species' own file)",
    "strouhal": "h at the northern bald ibis's Strouhal number f h/U",
    "drag": "h whose thrust equals the drag of body and wing profile; take objective aerodynamic_power with it",
}

# Inputs of a bird that come straight from a species' quantities: input -> quantity.
_INPUT_QUANTITIES = {
    "mass_kg": "mass",
    "semispan_m": "wingspan",
    "speed_m_s": "speed",
    "period_s": "wingbeat_frequency",
    "density_kg_m3": "air_density",
    "gravity_m_s2": "gravity",
    "upstroke_span_ratio": "upstroke_span_ratio",
    "stroke_half_angle_deg": "stroke_half_angle",
    "wing_area_m2": "wing_area",
}
# Inputs that set nothing but the amplitude -> the convention under which they do.
_OF_CONVENTION = {
    "stroke_half_angle_deg": "stroke-angle",
    "wing_area_m2": "drag",
    "body_drag_coefficient": "drag",
}

ALTITUDE_M = not_negative & at_most(CEILING_M, "the standard atmosphere is told up to the tropopause")
"""What an altitude must be, in m above the sea."""

INPUT_RULES = {
    **rules_of(Bird),
    "stroke_half_angle_deg": HALF_ANGLE_DEG,
    **rules_of(DragPolar),
    "altitude_m": ALTITUDE_M,
}
"""What each input that may be set must be."""

OF_THE_AMPLITUDE = tuple(_OF_CONVENTION)
"""Inputs that set nothing but the amplitude."""


class ImpossibleAmplitude(UpwashError):
    """A convention asks for wingtips that rise and fall by more than the wingspan: a result, not a slip.

    Parameters
    ----------
    message : str
        One line that says so.
    amplitude_m : float
        The tip-to-tip amplitude asked for, in m.
    wingspan_m : float
        The most that it can be, in m.
    """

    def __init__(self, message: str, amplitude_m: float, wingspan_m: float) -> None:
        super().__init__(message, field="amplitude_m")
        self.amplitude_m = amplitude_m
        self.wingspan_m = wingspan_m


def _input_value(name: str, value: float) -> float:
    """A bird's input from the SI value of the quantity behind it."""
    if name == "semispan_m":
        return value / 2.0
    if name == "period_s":
        return 1.0 / value
    return value


@dataclass(frozen=True)
class Species:
    """One species as its file describes it.

    Parameters
    ----------
    slug : str
        The file's name without ``.toml``.
    common_name, scientific_name : str
        Names.
    quantities : mapping of str to Quantity
        Values in SI units (angles in degrees) with source, basis and range.
    formation : Formation or None
        How the species flies together, if known.
    note : str
        A remark on the species, or "".
    reference_amplitude_m, reference_wavelength_m : float
        Amplitude and wavelength of the lone northern bald ibis, in m: their ratio is its Strouhal number.
    """

    slug: str
    common_name: str
    scientific_name: str
    quantities: Mapping[str, Quantity]
    formation: Formation | None
    note: str
    reference_amplitude_m: float
    reference_wavelength_m: float

    def inputs(self) -> dict[str, float]:
        """Return the bird's inputs that the file fixes, in SI units, and what conventions for its amplitude need."""
        stated = {
            name: _input_value(name, self.quantities[of].value)
            for name, of in _INPUT_QUANTITIES.items()
            if of in self.quantities
        }
        return stated | {"body_drag_coefficient": BODY_DRAG_COEFFICIENT}

    def ranges(self, amplitude: str = "stroke-angle") -> dict[str, tuple[float, float]]:
        """Return the range (low, high) of each input that matters under an amplitude convention.

        Every name is an override that `bird` takes with that convention, so the ranges can be sampled.
        """
        _check_convention(amplitude)
        ranges = {}
        for name, of in _INPUT_QUANTITIES.items():
            if of in self.quantities and _OF_CONVENTION.get(name, amplitude) == amplitude:
                ends = (
                    _input_value(name, end) for end in (self.quantities[of].low, self.quantities[of].high)
                )
                low, high = sorted(ends)
                ranges[name] = (low, high)
        return ranges

    def amplitude_m(self, amplitude: str = "stroke-angle", **overrides: float) -> float:
        """Tip-to-tip amplitude of the lone bird under a convention, in m.

        Parameters
        ----------
        amplitude : str
            ``stroke-angle``: h = 2 b sin(half-angle), from the species' own file.
            ``strouhal``: h/λ = f h/U as for the northern bald ibis.
            ``drag``: the thrust is the drag of body and wing profile.
        **overrides : float
            Inputs that differ from the species' own, as for `bird`.

        Raises
        ------
        ImpossibleAmplitude
            If the amplitude exceeds the wingspan: the wings would need a half-angle of more than 90 degrees.
        UpwashError
            If the convention or an override is unknown, or an override is no positive number.
        """
        return self._bird_inputs(amplitude, overrides)["amplitude_m"]

    def half_angle_deg(self, amplitude: str = "stroke-angle") -> float:
        """Half of the wing's stroke angle under a convention, in degrees; raises as `amplitude_m` does."""
        if amplitude == "stroke-angle":
            return self.quantities["stroke_half_angle"].value
        return math.degrees(math.asin(self.amplitude_m(amplitude) / self.quantities["wingspan"].value))

    def bird(self, amplitude: str = "stroke-angle", **overrides: float) -> Bird:
        """Return the bird that the physics takes.

        Parameters
        ----------
        amplitude : str
            How the amplitude is chosen, see `amplitude_m`.
        **overrides : float
            Bird's fields that differ from the species' own, in SI units; ``stroke_half_angle_deg``,
            ``wing_area_m2`` and ``body_drag_coefficient``, which some conventions take the amplitude from; and
            ``altitude_m``, which stands for the density there. The amplitude follows from the inputs as
            overridden, unless ``amplitude_m`` itself is given.

        Returns
        -------
        Bird
            The species' bird, flying alone.

        Raises
        ------
        ImpossibleAmplitude
            If the amplitude exceeds the wingspan.
        UpwashError
            If the convention or an override is unknown, or a value makes no bird, or none that could be.
        """
        inputs = self._bird_inputs(amplitude, overrides)
        try:
            return Bird(**inputs)
        except ValueError as error:
            raise UpwashError(f"{self.slug}: {error}", field=getattr(error, "name", "")) from error

    def groups(self, amplitude: str = "stroke-angle") -> dict[str, float]:
        """Return the dimensionless groups, by the names of `upwash.species.groups.GROUPS`.

        Raises
        ------
        ImpossibleAmplitude
            If the amplitude exceeds the wingspan under this convention.
        """
        groups = groups_of(self._bird_inputs(amplitude, {}))
        if "wing_area" in self.quantities:
            wingspan = self.quantities["wingspan"].value
            groups["aspect_ratio"] = wingspan**2 / self.quantities["wing_area"].value
        return groups

    def _bird_inputs(self, amplitude: str, overrides: Mapping[str, float]) -> dict[str, float]:
        """All of Bird's fields that are fixed, the amplitude by a convention unless overridden."""
        _check_convention(amplitude)
        inputs = self.inputs()
        for name, value in overrides.items():
            if name not in INPUT_RULES:
                remedy = did_you_mean(name, INPUT_RULES)
                raise UpwashError(
                    f"{self.slug}: expected an input of a bird, found {printable(name)}; {remedy}", field=name
                )
            if expected := INPUT_RULES[name].broken_by(value):
                found = printable(value)
                message = f"{self.slug}: {name}: expected {expected}, found {found}; correct it"
                raise UpwashError(message, field=name)
            inputs[name] = float(value)
        self._refuse_contradictions(amplitude, overrides)
        if "altitude_m" in inputs:
            inputs["density_kg_m3"] = density_kg_m3(inputs.pop("altitude_m"))
        apart = {name: inputs.pop(name) for name in _OF_CONVENTION if name in inputs}
        wingspan = 2.0 * inputs["semispan_m"]
        if "amplitude_m" not in inputs:
            inputs["amplitude_m"] = self._by_convention(amplitude, inputs, apart)
        if inputs["amplitude_m"] > wingspan:
            self._refuse_implausible(
                {name: value for name, value in inputs.items() if name != "amplitude_m"}, overrides
            )
            origin = "" if "amplitude_m" in overrides else f" by convention {amplitude!r}"
            raise ImpossibleAmplitude(
                f"{self.slug}: amplitude_m{origin}: expected at most the wingspan, {wingspan:.4g}, that is "
                f"a half-angle of 90 degrees, found {inputs['amplitude_m']:.4g}; no wing can: choose another",
                amplitude_m=inputs["amplitude_m"],
                wingspan_m=wingspan,
            )
        self._refuse_implausible(inputs, overrides)
        return inputs

    def _refuse_contradictions(self, amplitude: str, overrides: Mapping[str, float]) -> None:
        """Complain of an input that would have no say, as another was given that decides."""
        for name, convention in _OF_CONVENTION.items():
            if name in overrides and ("amplitude_m" in overrides or amplitude != convention):
                raise UpwashError(
                    f"{self.slug}: {name}: expected amplitude = {convention!r} and no amplitude_m "
                    "beside it, since it sets the amplitude; leave one of them out",
                    field=name,
                )
        if {"altitude_m", "density_kg_m3"} <= set(overrides):
            raise UpwashError(
                f"{self.slug}: altitude_m: expected no density_kg_m3 beside it, since it stands for the density "
                "there; leave one of them out",
                field="altitude_m",
            )

    def _by_convention(
        self, amplitude: str, inputs: Mapping[str, float], apart: Mapping[str, float]
    ) -> float:
        """Return the amplitude that a convention gives to a bird of some inputs, and of those that set it alone."""
        if amplitude == "stroke-angle":
            return 2.0 * inputs["semispan_m"] * math.sin(math.radians(apart["stroke_half_angle_deg"]))
        if amplitude == "strouhal":
            # As a ratio of wavelengths, so that the ibis gets its own amplitude back to the last digit.
            wavelength = inputs["speed_m_s"] * inputs["period_s"]
            return self.reference_amplitude_m * (wavelength / self.reference_wavelength_m)
        if "wing_area_m2" not in apart:
            raise UpwashError(
                f"{self.slug}: wing_area: expected one, as amplitude = 'drag' takes the drag of the wing's profile "
                "from it, found none; add [wing_area] to the species file, or set wing_area_m2",
                field="wing_area_m2",
            )
        polar = DragPolar(apart["wing_area_m2"], apart["body_drag_coefficient"])
        own = ("mass_kg", "semispan_m", "speed_m_s", "density_kg_m3", "gravity_m_s2")
        drag = polar.drag_n(*(inputs[name] for name in own))
        # Thrust is proportional to amplitude.
        try:
            some = Bird(**inputs, amplitude_m=inputs["semispan_m"])
        except ValueError as error:
            raise UpwashError(f"{self.slug}: {error}", field=getattr(error, "name", "")) from error
        return inputs["semispan_m"] * drag / some.drag_n

    def _refuse_implausible(self, inputs: Mapping[str, float], overrides: Mapping[str, float]) -> None:
        """Complain of inputs that were set and with which it is no bird; its file was judged when it was read."""
        if not overrides:
            return
        for name, value in groups_of(inputs).items():
            group = GROUPS[name]
            if group.inputs and not group.possible[0] <= value <= group.possible[1]:
                changed = [one for one in overrides if one in group.inputs] or list(overrides)
                (sentence,) = outside({name: value}, "possible")
                raise UpwashError(f"{self.slug}, {', '.join(changed)}: {sentence}", field=changed[-1])


def _check_convention(amplitude: str) -> None:
    """Complain about an unknown amplitude convention."""
    if amplitude not in AMPLITUDE_CONVENTIONS:
        expected = " or ".join(f'"{name}"' for name in AMPLITUDE_CONVENTIONS)
        raise UpwashError(
            f"amplitude: expected {expected}, found {printable(amplitude)}; write one of these",
            field="amplitude",
        )
