"""What to know before trusting a species' numbers or comparing species, derived from the files themselves."""

from __future__ import annotations

from collections.abc import Sequence

from upwash.species.allometry import RULES
from upwash.species.groups import outside
from upwash.species.quantity import Quantity
from upwash.species.species import ImpossibleAmplitude, Species

# A value that rests on fewer birds or tracks than this says little of a species.
FEW = 3
AIR = ("air_density", "gravity")


def species_caveats(species: Species, reference: Species) -> list[str]:
    """Say what a species' numbers rest on.

    Parameters
    ----------
    species : Species
        The species.
    reference : Species
        The northern bald ibis, whose air the library shares.

    Returns
    -------
    list of str
        One sentence a caveat.
    """
    caveats = []
    own = {name: quantity for name, quantity in species.quantities.items() if name not in AIR}
    filled = [
        f"{name} {quantity.basis} ({quantity.rule or 'its source says how'})"
        for basis in ("assumed", "computed")
        for name, quantity in own.items()
        if quantity.basis == basis
    ]
    if filled:
        caveats.append(f"not measured: {', '.join(filled)}")
    few = [
        f"{name} ({quantity.sample})"
        for name, quantity in own.items()
        if quantity.sample and quantity.sample < FEW
    ]
    if few:
        caveats.append(f"rests on very few birds or tracks: {', '.join(few)}")
    for name in AIR:
        value, shared = species.quantities[name].value, reference.quantities[name].value
        if value != shared:
            caveats.append(
                f"{name} is {value:g}, not the {shared:g} that the library's species share: "
                "comparing it with them confounds bird and air"
            )
    angle = species.quantities["stroke_half_angle"]
    if angle.rule != "nudds-2004":
        allometric = _by_rule(species, "nudds-2004")
        caveats.append(
            f"stroke_half_angle is the species' own, {angle.value:.3g} degrees, where nudds-2004 would give "
            f'{allometric:.3g}: under amplitude = "stroke-angle" this sets it apart from rule-filled species'
        )
    try:
        species.amplitude_m("strouhal")
    except ImpossibleAmplitude as error:
        caveats.append(
            'amplitude = "strouhal" is impossible: its wingtips would travel '
            f"{error.amplitude_m / error.wingspan_m:.3g} wingspans, beyond a half-angle of 90 degrees"
        )
    return caveats + outside(species.groups(), "usual")


def comparison_caveats(library: Sequence[Species], reference: Species) -> list[str]:
    """Say what confounds a comparison of species.

    Parameters
    ----------
    library : sequence of Species
        The species to be compared.
    reference : Species
        The northern bald ibis.

    Returns
    -------
    list of str
        One sentence a caveat.
    """

    def of(name: str) -> list[Quantity]:
        return [species.quantities[name] for species in library]

    def filled(name: str, rule: str) -> str:
        return f"{sum(quantity.rule == rule for quantity in of(name))} of {len(library)}"

    known = [
        species
        for species in library
        if not species.quantities["wingbeat_frequency"].rule and _has_area(species)
    ]
    errors = [
        _by_rule(species, "pennycuick-1996") / species.quantities["wingbeat_frequency"].value - 1.0
        for species in known
    ]
    off = (
        f"; against the {len(errors)} known ones the rule is off by {min(errors):+.0%} to {max(errors):+.0%}"
        if errors
        else ""
    )
    impossible = []
    for species in library:
        try:
            species.amplitude_m("strouhal")
        except ImpossibleAmplitude:
            impossible.append(species.slug)
    angle, strouhal = reference.half_angle_deg(), reference.groups()["strouhal"]
    allometric = _by_rule(reference, "nudds-2004")
    caveats = [
        f"{filled('wingbeat_frequency', 'pennycuick-1996')} wingbeat frequencies are computed "
        f"(Pennycuick 1996){off}: use ±{RULES['pennycuick-1996'].spread:.0%}",
        f"{filled('upstroke_span_ratio', 'as-ibis')} upstroke span ratios are the northern bald ibis's, and "
        f"{filled('stroke_half_angle', 'nudds-2004')} stroke half-angles are computed (Nudds et al. 2004)",
        f"the ibis's half-angle of {angle:.3g} degrees gives a Strouhal number of {strouhal:.3g}, the "
        f"allometric angle would be {allometric:.3g}: compare species within one amplitude convention",
    ]
    if impossible:
        caveats.append(
            f'amplitude = "strouhal" is impossible, which is a result, for {", ".join(impossible)}'
        )
    return [
        *caveats,
        "ibises and greylag geese overlap wingtips, pink-footed geese leave a gap: "
        "do not demand one optimum of nature",
        "published savings are of induced power, heart rate, metabolic rate or range: compare like with like",
    ]


def _has_area(species: Species) -> bool:
    return "wing_area" in species.quantities


def _by_rule(species: Species, rule: str) -> float:
    """What a rule gives for a species, whether or not its file uses it."""
    return RULES[rule].formula(*(species.quantities[name].value for name in RULES[rule].needs))
