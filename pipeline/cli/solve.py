"""Single problems: optimum, flock, field, animate."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import click

from pipeline.aero.power import COST_FUNCTIONS
from pipeline.species import AMPLITUDE_CONVENTIONS

as_json = click.option("--json", "json_output", is_flag=True, help="Print JSON instead of text.")


def problem(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the argument and options that `pipeline.sweep.single.single_job` makes a job of."""
    options = (
        click.argument("species"),
        click.option(
            "--objective",
            type=click.Choice(list(COST_FUNCTIONS)),
            default="force",
            show_default=True,
            help="What is to be least.",
        ),
        click.option(
            "--amplitude",
            type=click.Choice(list(AMPLITUDE_CONVENTIONS)),
            default="stroke-angle",
            show_default=True,
            help="How the lone bird's amplitude is chosen.",
        ),
        click.option(
            "--set",
            "settings",
            metavar="NAME=VALUE",
            multiple=True,
            help="Set an input, in SI units, as in speed_m_s=12; may be repeated.",
        ),
        click.option(
            "--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the search."
        ),
        click.option(
            "--tolerance", type=float, default=1e-4, show_default=True, help="Gap to which to prove the best."
        ),
    )
    for option in reversed(options):
        command = option(command)
    return command


@click.command()
@problem
@click.option("--all", "show_all", is_flag=True, help="Print every optimum, with the evidence for it.")
@as_json
def optimum(show_all: bool, json_output: bool, **chosen: Any) -> None:
    r"""Find the best positions of one bird behind another, and prove how good they are.

    SPECIES is a name in the library or the path of a TOML file. That no follower can fly is a result like any
    other. JSON holds every optimum, by the columns of solutions.parquet.

    \b
    Example:
      upwash optimum northern-bald-ibis --objective power
      upwash optimum ./mybird.toml --set speed_m_s=12 --all
    """
    from pipeline.batch.job import solve
    from pipeline.batch.store import SOLUTIONS, table_of
    from pipeline.report.answer import answer, job_record
    from pipeline.sweep.single import single_job

    table = table_of(solve(single_job("pair", **chosen)), SOLUTIONS)
    if json_output:
        click.echo(json.dumps(job_record(table.to_pylist()), indent=2, allow_nan=False))
        return
    rows = table.to_pandas()
    click.echo(answer(rows, show_all))
    click.echo(f"solved in {rows['solve_time_s'].iloc[0]:.2f} s", err=True)
