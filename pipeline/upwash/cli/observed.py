"""Observed birds: evaluate."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from upwash.aero.power import COST_FUNCTIONS
from upwash.cli.printing import as_json
from upwash.cli.solve import amplitude_option, phase_lock_option, settings_option
from upwash.cli.streams import at_work
from upwash.optimum.settings import WAKES
from upwash.place.choices import BOUNDS
from upwash.study.observed.choices import PHASE_SIGNS, PHASE_STARTS, PHASE_UNITS

if TYPE_CHECKING:
    import pandas as pd

    from upwash.study.observed.evaluation import Asked


@click.command()
@click.argument("species")
@click.argument("table", type=click.Path(path_type=Path, dir_okay=False))
@click.option(
    "--objective",
    type=click.Choice(list(COST_FUNCTIONS)),
    default="power",
    show_default=True,
    help="What a bird makes least where it may choose.",
)
@amplitude_option
@click.option(
    "--model",
    metavar="paper|limit",
    help="How wakes are resolved: as in the paper, which is usual, or converged.",
)
@settings_option
@click.option(
    "--bounds",
    type=click.Choice(BOUNDS),
    default="wide",
    show_default=True,
    help="Within which a bird's stroke is sought: as far as wings move, or as the paper searches.",
)
@click.option(
    "--columns",
    metavar="THEIRS=OURS,...",
    multiple=True,
    help="Other names of columns, as in behind_cm=x_m: a unit that a name ends in is converted.",
)
@click.option(
    "--phase-unit", type=click.Choice(list(PHASE_UNITS)), help="Unit of the phase; wingbeats if not given."
)
@click.option(
    "--phase-sign",
    type=click.Choice(PHASE_SIGNS),
    default="lag",
    show_default=True,
    help="Whether a positive phase says later than the leader, or earlier.",
)
@click.option(
    "--phase-at",
    type=click.Choice(list(PHASE_STARTS)),
    help="The phase is the follower's own, counted from there, when its leader begins its downstroke.",
)
@click.option(
    "--leader",
    metavar="SPECIES",
    help="The bird ahead, if it is another; it flies at the follower's speed, in its air.",
)
@phase_lock_option
@click.option("--pairs", is_flag=True, help="TABLE holds the positions of all birds at each time.")
@click.option(
    "--wake",
    type=click.Choice(WAKES),
    default="neighbour",
    show_default=True,
    help="With --pairs: whether the nearest bird ahead is felt, or all that are ahead.",
)
@click.option(
    "--heading",
    "heading_deg",
    type=float,
    metavar="DEG",
    help="With --pairs: compass bearing of the flight, of x east and y north; birds fly along -x if not given.",
)
@click.option("--sigma", type=float, metavar="B", help="Standard deviation of places, in semispans.")
@click.option("--sigma-m", type=float, metavar="M", help="The same in metres.")
@click.option("--sigma-phase", type=float, metavar="BEATS", help="The same of phases, in wingbeats.")
@click.option(
    "--jobs",
    type=click.IntRange(1, 1024),
    help="How many threads share the work; as many as there are processors if not given.",
)
@click.option(
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Write every row as Parquet, with units.",
)
@click.option("--csv", "as_csv", is_flag=True, help="Print every row as CSV.")
@as_json
def evaluate(
    table: Path, jobs: int | None, output: Path | None, as_csv: bool, json_output: bool, **chosen: Any
) -> None:
    """Say what observed birds save where they fly, and how far that is from the best.

    SPECIES is a name in the library or the path of a TOML file. TABLE is a CSV or Parquet file with a row for
    each bird: x_m behind its leader, y_m to the right of it, and maybe z_m above, phase (lag in wingbeats),
    speed_m_s, period_s, mass_kg; what is missing of height and phase is optimised. Other columns are passed
    through. species/observations.csv holds where birds were published to fly.

    \b
    Example:
      upwash evaluate northern-bald-ibis seen.csv --model limit --sigma-m 0.05
      upwash evaluate canada-goose species/observations.csv --model limit
      upwash evaluate mute-swan gps.csv --pairs --heading 210 --output swans.parquet
    """
    import os

    from upwash.errors import UpwashError
    from upwash.report.observed_answer import ROWS_SHOWN, first_rows, records, summary
    from upwash.species import load_species
    from upwash.study.observed.evaluation import Evaluation
    from upwash.study.observed.file import evaluation_file, read_birds, read_flights
    from upwash.study.observed.tally import EvaluationTally

    if as_csv and json_output:
        raise UpwashError("--csv, --json: expected one of them, found both; leave one out")
    asked, species = _asked(chosen), load_species(chosen["species"])
    evaluation, tally = Evaluation(asked, jobs or os.cpu_count() or 1), EvaluationTally()
    at_work("evaluating")
    shown: pd.DataFrame | None = None
    with ExitStack() as stack:
        said = {"species": chosen["species"], "objective": asked.objective, "bounds": asked.bounds}
        writer = stack.enter_context(evaluation_file(output, said)) if output else None
        pieces = (
            read_flights(table, asked.reading)
            if asked.pairs
            else read_birds(table, species.slug, evaluation.bird)
        )
        for piece in pieces:
            told = evaluation(piece)
            if as_csv:
                click.echo(told.to_csv(index=False, header=tally.rows == 0, lineterminator="\n"), nl=False)
            elif json_output:
                lines = [json.dumps(row, allow_nan=False, ensure_ascii=False) for row in records(told)]
                click.echo(("[\n" if tally.rows == 0 else ",\n") + ",\n".join(lines), nl=False)
            elif shown is None:
                shown = told.head(ROWS_SHOWN)
            if writer:
                writer.write(told)
            tally.add(told)
    if json_output:
        click.echo("\n]")
    if shown is not None:
        click.echo(first_rows(shown, f"{chosen['species']}, {table.name}"))
        if tally.rows > len(shown):
            click.echo(f"... and {tally.rows - len(shown)} more rows (--csv, --json or --output for all)")
        click.echo()
    click.echo(summary(tally), err=as_csv or json_output)
    for note in _notes(evaluation, tally):
        click.echo(note, err=True)
    if output:
        click.echo(str(output), err=as_csv or json_output)


def _notes(evaluation: Any, tally: Any) -> list[str]:
    """Return what is to be said beside the results."""
    notes = []
    if twice := tally.ids_twice():
        notes.append(f"id: {twice} rows share theirs with another; each was evaluated")
    if evaluation.optima_left_out:
        notes.append(
            "saving_at_v_optimum: told of the first 20 kinds of bird (mass, speed, period) alone; each takes a search"
        )
    return notes


def _asked(chosen: dict[str, Any]) -> Asked:
    """Return what a command line asks for."""
    from upwash.jobs.pair import Pair
    from upwash.species import load_species
    from upwash.study.observed.evaluation import Asked
    from upwash.study.observed.table import Reading
    from upwash.sweep.choices import OF_THE_BIRD
    from upwash.sweep.single import need_no_limits, settings_of, single_job

    asked = {
        name: chosen[name]
        for name in (
            "objective",
            "bounds",
            "pairs",
            "wake",
            "heading_deg",
            "sigma",
            "sigma_m",
            "sigma_phase",
            "amplitude",
            "phase_lock",
        )
    }
    leader = load_species(chosen["leader"]) if chosen["leader"] else None
    job = single_job(
        Pair,
        chosen["species"],
        chosen["settings"],
        chosen["amplitude"],
        chosen["model"],
        objective=chosen["objective"],
        seed=0,
        tolerance=1e-2,
        leader=chosen["leader"],
    )
    need_no_limits(job, "evaluate")
    fixed = {name: one.value for name, one in settings_of(chosen["settings"]).items() if name in OF_THE_BIRD}
    reading = Reading(
        _renamed(chosen["columns"]), chosen["phase_unit"], chosen["phase_sign"], chosen["phase_at"]
    )
    return Asked(
        load_species(chosen["species"]), job.model, reading=reading, fixed=fixed, leader=leader, **asked
    )


def _renamed(texts: tuple[str, ...]) -> dict[str, str]:
    """Read ``THEIRS=OURS,THEIRS=OURS``."""
    from upwash.errors import UpwashError

    found: dict[str, str] = {}
    for text in (part for one in texts for part in one.split(",")):
        theirs, equals, ours = (part.strip() for part in text.rpartition("="))
        if not (equals and theirs and ours):
            raise UpwashError(f"--columns: expected THEIRS=OURS, found {text!r}; write as in behind_m=x_m")
        found[theirs] = ours
    return found
