"""How fast and how far: speed, migrate."""

from __future__ import annotations

import json
from typing import Any

import click

from upwash.cli.printing import as_json, say
from upwash.cli.solve import problem
from upwash.cli.streams import at_work
from upwash.optimum.settings import SHAPES

shape_option = click.option(
    "--shape",
    type=click.Choice(SHAPES),
    default="vee",
    show_default=True,
    help="One line, two from one leader, or one that changes sides.",
)
figure_option = click.option(
    "--figure",
    metavar="NAME",
    help="Draw it as well, as NAME.pdf and NAME.png; their names go to standard error.",
)
csv_option = click.option("--csv", "csv_output", is_flag=True, help="Print CSV instead of text.")


@click.command()
@problem(objective="power")
@click.option(
    "--birds", "sizes", default="1,2,6,12", show_default=True, metavar="N,...", help="Sizes of flocks."
)
@shape_option
@click.option("--turns", is_flag=True, help="Leave out flocks that take no turns at the front.")
@figure_option
@csv_option
@as_json
def speed(
    sizes: str,
    shape: str,
    turns: bool,
    figure: str | None,
    csv_output: bool,
    json_output: bool,
    **chosen: Any,
) -> None:
    """Find how fast a bird does best alone, behind another, and in flocks: least power, and most range.

    SPECIES is a name in the library or the path of a TOML file. At each speed every follower flies where it
    flies best in the V, and the best speed is that of the bird or flock as a whole. If the birds take turns at the
    front, the mean of their powers counts; if not, that of the first, which flies as if alone. With --amplitude drag
    take --objective aerodynamic_power, or the body's drag counts twice.

    \b
    Example:
      upwash speed northern-bald-ibis
      upwash speed northern-bald-ibis --amplitude drag --objective aerodynamic_power --set body_drag_coefficient=0.2
    """
    from upwash.errors import UpwashError
    from upwash.report.speed_answer import speed_answer
    from upwash.report.table import Table
    from upwash.study.best_speed import best_speeds
    from upwash.sweep.single import changing_bird

    if csv_output and json_output:
        raise UpwashError("--csv and --json: expected one of them, found both; leave one out")
    if any(one.partition("=")[0].strip() == "speed_m_s" for one in chosen["settings"]):
        raise UpwashError("--set speed_m_s: expected no speed, as it is what is sought; leave it out")
    numbers = sizes_of(sizes)
    asked = changing_bird(**chosen)
    warn_of_body_drag(asked.amplitude, asked.job.objective)
    at_work("solving")
    rows = best_speeds(
        asked.bird,
        asked.job.objective,
        model=asked.model,
        is_resolved=asked.is_resolved,
        sizes=numbers,
        shape=shape,
        turns_alone=turns,
        search=asked.job.search,
        species=asked.job.species,
        amplitude_convention=asked.job.amplitude_convention,
    )
    table = Table("", rows)
    if figure is not None:
        draw(figure, "draw_speeds", rows)
    if csv_output:
        click.echo(table.csv(), nl=False)
    elif json_output:
        click.echo(json.dumps(table.records(), indent=2, allow_nan=False, ensure_ascii=False))
    else:
        click.echo(speed_answer(rows))


def draw(name: str, how: str, rows: Any) -> None:
    """Draw rows as a figure, and say where it is.

    Raises
    ------
    UpwashError
        If it cannot be written there.
    """
    from pathlib import Path

    from upwash.batch.store import cannot_write
    from upwash.report.figures import journeys
    from upwash.report.figures.catalogue import save_all

    at_work("drawing")
    stem = Path(name)
    try:
        stem.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(stem.parent, error) from error
    for path in save_all(getattr(journeys, how)(rows), stem, (".pdf", ".png")):
        say(f"drew {path}")


def sizes_of(text: str) -> list[int]:
    """Read sizes of flocks with commas between.

    Raises
    ------
    UpwashError
        If one of them is none.
    """
    from upwash.errors import UpwashError
    from upwash.optimum.settings import BIRDS

    found = []
    for part in text.split(","):
        number = int(part) if part.strip().isdecimal() and len(part) < 6 else 0
        if number != 1 and (expected := BIRDS.broken_by(number)):
            raise UpwashError(
                f"--birds: expected 1 or {expected}, with commas between, found {part.strip()!r}; write as in 1,2,6"
            )
        if number not in found:
            found.append(number)
    return found


def warn_of_body_drag(amplitude: str, objective: str) -> None:
    """Say where the body's drag would count twice."""
    if amplitude == "drag" and objective not in ("aerodynamic_power", "force"):
        click.echo(
            "Warning: by amplitude 'drag' thrust pays for the body's drag already, and power counts it once more; "
            "take --objective aerodynamic_power",
            err=True,
        )


@click.command()
@problem(objective="power")
@click.option(
    "--birds",
    type=click.IntRange(1, 1000),
    default=12,
    show_default=True,
    help="Birds, the first one included.",
)
@shape_option
@click.option(
    "--fuel",
    type=float,
    default=0.3,
    show_default=True,
    metavar="SHARE",
    help="Fuel, as a share of the mass at take-off.",
)
@click.option(
    "--altitude",
    type=float,
    metavar="M",
    help="Altitude in the standard atmosphere; the species' own air if not given.",
)
@click.option(
    "--profile",
    metavar="TABLE",
    help="CSV of distance_m and altitude_m, along which it flies, instead of one altitude.",
)
@click.option(
    "--speed",
    "speed_rule",
    type=click.Choice(["adapted", "held"]),
    default="adapted",
    show_default=True,
    help="Airspeed of most range at each mass, or the species' own all the way.",
)
@click.option(
    "--wind",
    type=float,
    default=0.0,
    show_default=True,
    metavar="M_S",
    help="Tailwind; a headwind is negative.",
)
@click.option(
    "--efficiency",
    type=float,
    metavar="SHARE",
    help="Work over the energy burned for it.  [default: 0.23]",
)
@click.option(
    "--keep", metavar="FILE", help="Keep the flight here as it goes on, and go on with what is kept."
)
@click.option(
    "--workers", type=click.IntRange(1), default=1, show_default=True, help="Processes that prove places."
)
@figure_option
@csv_option
@as_json
def migrate(
    birds: int,
    shape: str,
    fuel: float,
    altitude: float | None,
    profile: str | None,
    speed_rule: str,
    wind: float,
    efficiency: float | None,
    keep: str | None,
    workers: int,
    figure: str | None,
    csv_output: bool,
    json_output: bool,
    **chosen: Any,
) -> None:
    """Fly a flock from take-off until its fuel is spent, and a bird alone beside it.

    SPECIES is a name in the library or the path of a TOML file; its mass is that at take-off. Mass falls as fuel is
    burned, each follower flies where it then flies best, and the birds take turns at the front. A flight also ends
    where a bird finds no place that balances, or none in the V. Options that set the wind or the air apply all the way.

    \b
    Example:
      upwash migrate northern-bald-ibis --birds 12 --fuel 0.3
      upwash migrate whooper-swan --amplitude drag --objective aerodynamic_power --set body_drag_coefficient=0.2
    """
    from dataclasses import asdict
    from pathlib import Path

    from upwash.aero.bird import Bird
    from upwash.batch.store import write_atomic
    from upwash.errors import UpwashError
    from upwash.report.migration_answer import migration_answer
    from upwash.report.table import Table
    from upwash.study import migration
    from upwash.sweep.single import changing_bird

    if csv_output and json_output:
        raise UpwashError("--csv and --json: expected one of them, found both; leave one out")
    if not 0.0 <= fuel < 1.0:
        raise UpwashError(
            f"--fuel: expected a share of the mass from 0 to below 1, found {fuel:g}; correct it"
        )
    if efficiency is not None and not 0.0 < efficiency < 1.0:
        raise UpwashError(
            f"--efficiency: expected a number between 0 and 1, found {efficiency:g}; correct it"
        )
    if not abs(wind) <= 100.0:
        raise UpwashError(f"--wind: expected -100 to 100 m/s, found {wind:g}; correct it")
    named = [one.partition("=")[0].strip() for one in chosen["settings"]]
    air = [
        option for option, given in (("--altitude", altitude), ("--profile", profile)) if given is not None
    ]
    air += [f"--set {name}" for name in named if name in ("altitude_m", "density_kg_m3")]
    if len(air) > 1:
        raise UpwashError(
            f"{' and '.join(air)}: expected the air to be told once, found it twice; leave one out"
        )
    along = profile_of(altitude, profile)
    settings = list(chosen.pop("settings"))
    asked = changing_bird(
        settings=[*settings, *([f"altitude_m={along.altitude_m(0.0)!r}"] if along else [])], **chosen
    )
    warn_of_body_drag(asked.amplitude, asked.job.objective)
    assert isinstance(asked.job.bird, Bird)
    journey = migration.Journey(
        asked.bird,
        asked.job.bird,
        asked.job.objective,
        asked.model,
        asked.is_resolved,
        birds,
        shape,
        fuel,
        speed_rule,
        wind,
        along,
        efficiency,
        asked.job.search,
        {"species": asked.job.species, "amplitude_convention": asked.job.amplitude_convention},
    )
    inputs = {
        "bird": asdict(asked.job.bird),
        "amplitude": asked.amplitude,
        "settings": sorted(settings),
        "objective": asked.job.objective,
        "model": str(asked.model),
        "birds": birds,
        "shape": shape,
        "fuel": fuel,
        "speed": speed_rule,
        "wind": wind,
        "profile": [list(point) for point in along.points] if along else None,
        "efficiency": efficiency,
        "search": asdict(asked.job.search),
    }
    known = None
    if keep is not None and Path(keep).is_file():
        known = migration.from_text(Path(keep).read_text(encoding="utf-8", errors="replace"), inputs, keep)

    def save(flights: dict[int, migration.Flown]) -> None:
        if keep is not None:
            write_atomic(Path(keep), migration.as_text(inputs, flights).encode())

    at_work("flying")
    rows = migration.migrate(journey, workers=workers, known=known, keep=save)
    table = Table("", rows)
    if figure is not None:
        draw(figure, "draw_flight", rows)
    if csv_output:
        click.echo(table.csv(), nl=False)
    elif json_output:
        click.echo(json.dumps(table.records(), indent=2, allow_nan=False, ensure_ascii=False))
    else:
        click.echo(migration_answer(rows))


def profile_of(altitude: float | None, path: str | None) -> Any:
    """Return the altitudes along which a flight goes; None if neither an altitude nor a table is given.

    Raises
    ------
    UpwashError
        If they are none.
    """
    import csv
    from pathlib import Path

    from upwash.errors import UpwashError
    from upwash.journey.flight import Profile
    from upwash.species.species import ALTITUDE_M

    if altitude is not None:
        if expected := ALTITUDE_M.broken_by(altitude):
            raise UpwashError(f"--altitude: expected {expected}, found {altitude:g}; correct it")
        return Profile(((0.0, altitude),))
    if path is None:
        return None
    try:
        text = Path(path).read_text(encoding="utf-8-sig")
    except (UnicodeDecodeError, ValueError) as error:
        raise UpwashError(f"{path}: expected CSV, found no text; save it as UTF-8") from error
    except FileNotFoundError as error:
        raise UpwashError(
            f"{path}: expected a table of altitudes (CSV), found no such file; check the path"
        ) from error
    reader = csv.DictReader(text.splitlines())
    names = ("distance_m", "altitude_m")
    if not set(names) <= set(reader.fieldnames or ()):
        found = ", ".join(reader.fieldnames or ()) or "none"
        raise UpwashError(
            f"{path}, line 1: expected columns distance_m and altitude_m, found {found}; add them"
        )
    points: list[tuple[float, float]] = []
    for row in reader:
        where = f"{path}, line {reader.line_num}"
        try:
            distance, high = (float(row[name]) for name in names)
        except (TypeError, ValueError) as error:
            raise UpwashError(f"{where}: expected two numbers, found {row!r}; correct them") from error
        if expected := ALTITUDE_M.broken_by(high):
            raise UpwashError(f"{where}: altitude_m: expected {expected}, found {high:g}; correct it")
        if (distance != 0.0) if not points else not (points[-1][0] < distance < 1e9):
            expected = "distances that grow" if points else "0 at take-off"
            raise UpwashError(f"{where}: distance_m: expected {expected}, found {distance:g}; correct it")
        points.append((distance, high))
    if not points:
        raise UpwashError(f"{path}: expected at least one altitude, found none; add a line")
    return Profile(tuple(points))
