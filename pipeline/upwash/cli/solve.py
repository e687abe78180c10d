"""Single problems: optimum, flock."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import click

from upwash.aero.power import COST_FUNCTIONS
from upwash.cli.printing import as_json
from upwash.cli.streams import at_work
from upwash.optimum.settings import FLOCK_CHOICES
from upwash.species import AMPLITUDE_CONVENTIONS
from upwash.sweep.speeds import SPEEDS

amplitude_option = click.option(
    "--amplitude",
    type=click.Choice(list(AMPLITUDE_CONVENTIONS)),
    default="stroke-angle",
    show_default=True,
    help="How the lone bird's amplitude is chosen.",
)
spacing_options = (
    click.option("--x-min-m", type=float, metavar="M", help="Least distance behind that a follower keeps."),
    click.option(
        "--wingtip-gap-min-m",
        type=float,
        metavar="M",
        help="Least gap between wingtips, across the flight: |y| less the wingspan; negative where they overlap.",
    ),
    click.option(
        "--distance-min-m", type=float, metavar="M", help="Least distance from the bird ahead, in all."
    ),
    click.option(
        "--bearing-max-deg",
        type=float,
        metavar="DEG",
        help="Greatest angle, seen from above, from the follower's flight to the bird ahead, so that it sees it.",
    ),
)
SPACING = ("x_min_m", "wingtip_gap_min_m", "distance_min_m", "bearing_max_deg")


def spacing(command: Callable[..., Any]) -> Callable[..., Any]:
    """Give a command the options that limit a follower's place."""
    for option in reversed(spacing_options):
        command = option(command)
    return command


settings_option = click.option(
    "--set",
    "settings",
    metavar="NAME=VALUE",
    multiple=True,
    help="Set an input, in SI units, or a part of the model, as in speed_m_s=12; may be repeated.",
)


def problem(
    objective: str = "force", model: str = "paper"
) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Give a command the argument and options that `upwash.sweep.single.single_job` makes a job of.

    Parameters
    ----------
    objective, model : str
        What is usual; that of the model is told in words and put in by the command.
    """
    options = (
        click.argument("species"),
        click.option(
            "--objective",
            type=click.Choice(list(COST_FUNCTIONS)),
            default=objective,
            show_default=True,
            help="What is to be least.",
        ),
        amplitude_option,
        click.option(
            "--model",
            metavar="paper|limit",
            help=f"How wakes are resolved: as in the paper, or converged.  [default: {model}]",
        ),
        settings_option,
        click.option(
            "--seed", type=click.IntRange(0), default=0, show_default=True, help="Seed of the search."
        ),
        click.option(
            "--tolerance", type=float, default=1e-4, show_default=True, help="Gap to which to prove the best."
        ),
    )

    def with_options(command: Callable[..., Any]) -> Callable[..., Any]:
        for option in reversed(options):
            command = option(command)
        return command

    return with_options


phase_lock_option = click.option(
    "--phase-lock/--no-phase-lock",
    default=True,
    show_default=True,
    help="Whether birds beat in step, in the period of the one ahead, or each in its own, averaged over all phases.",
)


@click.command()
@problem()
@click.option(
    "--leader", metavar="SPECIES", help="The bird ahead, if it is another; it shares airspeed and air."
)
@click.option(
    "--speed-of",
    type=click.Choice(SPEEDS),
    default=SPEEDS[0],
    show_default=True,
    help="Whose own airspeed both fly at, if the leader is another bird.",
)
@phase_lock_option
@click.option(
    "--distance-m",
    type=float,
    metavar="M",
    help="How far behind, where the wake is endless and that is free; half a wavelength if not given.",
)
@spacing
@click.option("--all", "show_all", is_flag=True, help="Print every optimum, with the evidence for it.")
@as_json
def optimum(distance_m: float | None, show_all: bool, json_output: bool, **chosen: Any) -> None:
    """Find the best positions of one bird behind another, and prove how good they are.

    SPECIES, the follower, is a name in the library or the path of a TOML file; its leader is alike if no other is
    named. Savings are of the follower flying alone at that speed. That no follower can fly is a result like any
    other. Behind an endless wake what is saved is told for both laws of the follower's span, with the interval
    that the species' own ranges give. JSON holds every optimum, by the columns of solutions.parquet.

    \b
    Example:
      upwash optimum northern-bald-ibis --objective power
      upwash optimum ./mybird.toml --set speed_m_s=12 --all
      upwash optimum northern-bald-ibis --model limit --objective power --distance-m 1.2
      upwash optimum common-starling --leader mute-swan --no-phase-lock --objective power
    """
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.jobs.run import solve
    from upwash.jobs.schema import table_of
    from upwash.report.answer import answer, job_record
    from upwash.study.limit_ranges import SAMPLES, SEED, limit_ranges, pair_in
    from upwash.sweep.single import jobs_within_ranges, single_job

    limits = {name: chosen.pop(name) for name in SPACING}
    asked = chosen | {"parts": {"distance_m": distance_m} | limits}
    job = single_job(Pair, **asked)
    at_work("solving")
    table = table_of(solve(job), job.kind.rows)
    rows, ranges = table.to_pandas(), []
    if job.model.is_endless and rows["rank"].notna().any():
        at_work("solving for birds within the species' ranges")
        # A limit that leaves room to the bird itself may leave none to one within its species' ranges.
        jobs = {}
        with suppress(UpwashError):
            jobs = jobs_within_ranges(SAMPLES, SEED, kind=Pair, **asked)
        birds = {law: [pair_in(one) for one in of_law] for law, of_law in jobs.items()}
        in_v = bool(rows["is_v_optimum"].eq(True).any())
        ranges = limit_ranges(birds, job.objective, in_v, job.distance_m, job.spacing)
    if json_output:
        click.echo(json.dumps(job_record(table.to_pylist(), ranges), indent=2, allow_nan=False))
        return
    click.echo(answer(rows, show_all, ranges))
    click.echo(f"solved in {rows['solve_time_s'].iloc[0]:.2f} s", err=True)


@click.command()
@problem()
@click.option(
    "--birds", type=click.IntRange(2), default=6, show_default=True, help="Birds, the first one included."
)
@click.option(
    "--shape",
    type=click.Choice(FLOCK_CHOICES["shape"]),
    default="echelon",
    show_default=True,
    help="One line, two from one leader, or one that changes sides.",
)
@click.option(
    "--wake",
    type=click.Choice(FLOCK_CHOICES["wake"]),
    default="neighbour",
    show_default=True,
    help="Whether a bird feels the wake of the bird that it follows, or of every bird ahead.",
)
@click.option(
    "--wavelengths", metavar="N", help="Length of each wake, a number or endless; the model's if not given."
)
@click.option(
    "--reading",
    type=click.Choice(FLOCK_CHOICES["reading"]),
    default="immediate",
    show_default=True,
    help="Whose amplitude bounds a bird's: that of the bird that it follows, or a lone bird's.",
)
@click.option(
    "--member",
    "members",
    metavar="SPECIES",
    multiple=True,
    help="A bird behind the first, from the front; repeat for each. All are like the first if none is named.",
)
@phase_lock_option
@spacing
@click.option("--joint", is_flag=True, help="Improve all birds together, for the sum of their costs.")
@as_json
def flock(wavelengths: str | None, joint: bool, json_output: bool, **chosen: Any) -> None:
    """Chain pairs into a flock: each bird flies where it flies best behind those ahead of it.

    SPECIES is a name in the library or the path of a TOML file. A bird for which there is no place ends the
    flock, and the last line says why. JSON holds every bird, by the columns of flock.parquet.

    \b
    Example:
      upwash flock northern-bald-ibis --birds 6 --objective power
      upwash flock northern-bald-ibis --shape vee --wake all-upstream --joint
      upwash flock greylag-goose --member barnacle-goose --member barnacle-goose --objective power
    """
    from upwash.errors import UpwashError
    from upwash.jobs.flock import Flock, flock_of
    from upwash.jobs.run import inputs_of, solve
    from upwash.jobs.schema import table_of
    from upwash.optimum.solvable import adds_up
    from upwash.report.flock_answer import flock_answer, flock_record
    from upwash.sweep.single import single_job

    limits = {name: chosen.pop(name) for name in SPACING}
    job = single_job(Flock, parts={"wavelengths": wavelengths} | limits, **chosen)
    if joint and not adds_up(job.model):
        expected = "wakes that end and are felt in points by birds that are held in two states"
        raise UpwashError(f"--joint: expected {expected}, found another model; leave out --joint")
    if joint and (chosen["members"] or not chosen["phase_lock"]):
        remedy = "leave out --joint"
        raise UpwashError(f"--joint: expected birds that are alike and beat in step, found others; {remedy}")
    if joint and job.spacing.names:
        found = ", ".join(job.spacing.names)
        raise UpwashError(
            f"--joint: expected birds that keep to nothing, found {found}; leave one of them out"
        )
    at_work("solving")
    chain = table_of(solve(job), job.kind.rows)
    improved = None
    if joint:
        from upwash.optimum.joint import improve_together

        solution = improve_together(flock_of(job))
        improved = table_of([inputs_of(job) | row for row in solution.flock.rows()], job.kind.rows)
    if json_output:
        record = flock_record((improved or chain).to_pylist())
        if improved:
            record |= {"stationarity": solution.stationarity, "given_up": [0.0, *solution.given_up]}
        click.echo(json.dumps(record, indent=2, allow_nan=False))
    elif improved:
        click.echo(flock_answer(improved.to_pandas(), chain.to_pandas()))
    else:
        click.echo(flock_answer(chain.to_pandas()))
