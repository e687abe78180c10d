"""The commands ``upwash species``: list, show and check species files, and start a new one."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from upwash.cli.printing import as_json
from upwash.errors import UpwashError

if TYPE_CHECKING:
    from upwash.species import Species

# What the table of `list` shows of each quantity, by its symbol in the nomenclature.
SYMBOLS = {
    "M": "mass",
    "B": "wingspan",
    "U": "speed",
    "f": "wingbeat_frequency",
    "θ": "stroke_half_angle",
    "R": "upstroke_span_ratio",
}


@click.group()
def species() -> None:
    """List, show, check or start species files.

    \b
    Example:
      upwash species show northern-bald-ibis
    """


@species.command("list")
@as_json
def list_species(json_output: bool) -> None:
    """List the library, and how each value is known.

    \b
    Example:
      upwash species list
    """
    from upwash.species import load_library

    library = load_library()
    if json_output:
        click.echo(json.dumps([_summary(one) for one in library], ensure_ascii=False, indent=2))
        return
    wide = [
        max(len(getattr(one, field)) for one in library)
        for field in ("slug", "common_name", "scientific_name")
    ]
    titles = ("species", "common name", "scientific name")
    click.echo("  ".join(f"{title:<{width}}" for title, width in zip(titles, wide, strict=True)), nl=False)
    click.echo(f"  {'mass kg':>8}  {'span m':>6}  {' '.join(SYMBOLS)}")
    for one in library:
        names = (one.slug, one.common_name, one.scientific_name)
        click.echo("  ".join(f"{name:<{width}}" for name, width in zip(names, wide, strict=True)), nl=False)
        mass, wingspan = one.quantities["mass"].value, one.quantities["wingspan"].value
        known = " ".join(one.quantities[name].basis[0] for name in SYMBOLS.values())
        click.echo(f"  {mass:>8.3f}  {wingspan:>6.2f}  {known}")
    symbols = ", ".join(f"{symbol} {name.replace('_', ' ')}" for symbol, name in SYMBOLS.items())
    click.echo(f"{symbols}: m measured, g given by the paper, c computed, a assumed", err=True)


@species.command()
@click.argument("name", metavar="SPECIES")
@as_json
def show(name: str, json_output: bool) -> None:
    """Show a species: every value with its source, what follows from it, and what to beware of.

    SPECIES is a name in the library or the path of a TOML file.

    \b
    Example:
      upwash species show mute-swan
      upwash species show ./mybird.toml --json
    """
    from upwash.species import load_species
    from upwash.species.caveats import species_caveats
    from upwash.species.groups import GROUPS
    from upwash.species.library import REFERENCE

    one = load_species(name)
    caveats = species_caveats(one, load_species(REFERENCE))
    if json_output:
        click.echo(json.dumps(_details(one) | {"caveats": caveats}, ensure_ascii=False, indent=2))
        return
    click.echo(f"{one.common_name} ({one.scientific_name})")
    if one.note:
        click.echo(one.note)
    if one.formation:
        click.echo(f"flies in: {one.formation.shape} ({one.formation.basis}: {one.formation.source})")
    click.echo(f"\n{'quantity':<20}{'value':>9}  {'unit':<7}{'range':<17}basis")
    for label, quantity in one.quantities.items():
        unit = "" if quantity.unit == "1" else quantity.unit
        basis = quantity.basis + (f" by {quantity.rule}" if quantity.rule else "")
        span = f"{quantity.low:.4g} to {quantity.high:.4g}"
        sample = f", sample of {quantity.sample}" if quantity.sample else ""
        click.echo(f"{label:<20}{quantity.value:>9.5g}  {unit:<7}{span:<17}{basis}{sample}")
        for line in filter(None, (quantity.source, quantity.note)):
            click.echo(f"    {line}")
    click.echo()
    for convention, values in _conventions(one).items():
        if values is None:
            click.echo(f"{convention:<14}impossible")
            continue
        groups = ", ".join(f"{GROUPS[name].symbol} = {values[name]:.4g}" for name in GROUPS if name in values)
        angle = values["half_angle_deg"]
        click.echo(f"{convention:<14}h = {values['amplitude_m']:.4g} m, half-angle {angle:.3g} deg")
        click.echo(f"{'':<14}{groups}")
    for caveat in caveats:
        click.echo(f"Warning: {caveat}", err=True)


@species.command()
@click.argument("files", metavar="[FILE]...", nargs=-1)
@as_json
def check(files: tuple[str, ...], json_output: bool) -> None:
    """Check species files: units, ranges, rules, dimensionless groups; warn of what is not measured.

    All that is wrong in a file is said at once. Without a FILE the whole library is checked. A FILE may also
    be a name in the library. The exit code is 2 if a file is wrong; warnings leave it 0.

    \b
    Example:
      upwash species check
      upwash species check ./mybird.toml
    """
    from upwash.species import load_species
    from upwash.species.caveats import comparison_caveats, species_caveats
    from upwash.species.file import WrongFile
    from upwash.species.library import REFERENCE, library_paths

    reference = load_species(REFERENCE)
    reports: list[dict[str, Any]] = []
    good = []
    for name in files or [str(path) for path in library_paths()]:
        try:
            one = load_species(name)
            caveats = species_caveats(one, reference)
        except UpwashError as error:
            mistakes = error.mistakes if isinstance(error, WrongFile) else [str(error)]
            wrong = {"error": mistakes[0], "errors": mistakes, "warnings": []}
            reports.append({"file": name, "ok": False, **wrong})
            for mistake in mistakes:
                click.echo(f"Error: {mistake}", err=True)
            continue
        good.append(one)
        reports.append({"file": name, "ok": True, "error": None, "errors": [], "warnings": caveats})
        if not json_output:
            click.echo(f"ok  {one.slug}")
        for caveat in caveats:
            click.echo(f"Warning: {one.slug}: {caveat}", err=True)
    comparison = comparison_caveats(good, reference) if len(good) > 1 else []
    for caveat in comparison:
        click.echo(f"Before comparing species: {caveat}", err=True)
    if json_output:
        click.echo(json.dumps({"files": reports, "comparison": comparison}, ensure_ascii=False, indent=2))
    if len(good) < len(reports):
        raise click.exceptions.Exit(UpwashError.exit_code)


@species.command()
@click.argument("name")
@click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path(),
    show_default=".",
    help="Where to write the file.",
)
def new(name: str, folder: Path) -> None:
    """Write a commented species file to fill in; an existing file is never touched.

    \b
    Example:
      upwash species new "Common shelduck"
    """
    from upwash.species.template import write_template

    path = write_template(name, folder)
    click.echo(path)
    click.echo(f'Next: replace each "?" in it, then run: upwash species check {path}', err=True)


def _summary(one: Species) -> dict[str, Any]:
    """What `list` says of a species."""
    return {
        "slug": one.slug,
        "common_name": one.common_name,
        "scientific_name": one.scientific_name,
        "mass_kg": one.quantities["mass"].value,
        "wingspan_m": one.quantities["wingspan"].value,
        "basis": {name: quantity.basis for name, quantity in one.quantities.items()},
    }


def _details(one: Species) -> dict[str, Any]:
    """What `show` says of a species."""
    return {
        "slug": one.slug,
        "common_name": one.common_name,
        "scientific_name": one.scientific_name,
        "note": one.note,
        "formation": asdict(one.formation) if one.formation else None,
        "quantities": {name: asdict(quantity) for name, quantity in one.quantities.items()},
        "amplitude": _conventions(one),
    }


def _conventions(one: Species) -> dict[str, dict[str, float] | None]:
    """Amplitude, half-angle and dimensionless groups under each convention; None where it is impossible."""
    from upwash.species import AMPLITUDE_CONVENTIONS, ImpossibleAmplitude

    values: dict[str, dict[str, float] | None] = {}
    for convention in AMPLITUDE_CONVENTIONS:
        try:
            values[convention] = {
                "amplitude_m": one.amplitude_m(convention),
                "half_angle_deg": one.half_angle_deg(convention),
            } | one.groups(convention)
        except ImpossibleAmplitude:
            values[convention] = None
    return values
