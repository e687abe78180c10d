"""How fast and how far: speed, migrate."""

from __future__ import annotations

import json
from typing import Any

import click

from upwash.cli.printing import as_json
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
csv_option = click.option("--csv", "csv_output", is_flag=True, help="Print CSV instead of text.")


@click.command()
@problem(objective="power")
@click.option(
    "--birds", "sizes", default="1,2,6,12", show_default=True, metavar="N,...", help="Sizes of flocks."
)
@shape_option
@click.option("--turns", is_flag=True, help="Leave out flocks that take no turns at the front.")
@csv_option
@as_json
def speed(sizes: str, shape: str, turns: bool, csv_output: bool, json_output: bool, **chosen: Any) -> None:
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
    if csv_output:
        click.echo(table.csv(), nl=False)
    elif json_output:
        click.echo(json.dumps(table.records(), indent=2, allow_nan=False, ensure_ascii=False))
    else:
        click.echo(speed_answer(rows))


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
