"""The explorer: a page on which a follower is dragged about behind its leader."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from upwash.aero.power import COST_FUNCTIONS
from upwash.cli.solve import amplitude_option
from upwash.cli.streams import at_work


@click.command()
@click.argument("species", required=False, default="northern-bald-ibis")
@click.option(
    "--objective",
    type=click.Choice(list(COST_FUNCTIONS)),
    default="power",
    show_default=True,
    help="What is told as saved.",
)
@click.option(
    "--model",
    type=click.Choice(["paper", "limit"]),
    default="limit",
    show_default=True,
    help="The model that is shown first; the page has both.",
)
@amplitude_option
@click.option(
    "--set",
    "settings",
    metavar="NAME=VALUE",
    multiple=True,
    help="Set an input of SPECIES, in SI units, as in speed_m_s=12; may be repeated.",
)
@click.option(
    "--observed",
    metavar="TABLE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="CSV of your own birds, to be shown as dots: x_m behind and y_m right of the leader.",
)
@click.option(
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("explorer.html"),
    show_default=True,
    help="File to write.",
)
def explore(
    species: str,
    objective: str,
    model: str,
    amplitude: str,
    settings: tuple[str, ...],
    observed: Path | None,
    output: Path,
) -> None:
    """Write a page on which a follower is dragged about behind its leader and says what it saves there.

    The page is one file that needs no network, with every species of the library in it and SPECIES shown first:
    a name in the library or the path of a TOML file. Prints the name of the file. The best places of a bird that
    is no species' own are searched, which takes some seconds.

    \b
    Example:
      upwash explore northern-bald-ibis
      upwash explore ./mybird.toml --observed mybirds.csv --output mybird.html
    """
    from upwash.aero.bird import Bird
    from upwash.aero.wake import WakeModel
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.report.explorer.page import write_explorer
    from upwash.report.explorer.places import read_observed
    from upwash.species import load_species
    from upwash.sweep.single import need_no_limits, single_job

    job = single_job(Pair, species, settings, amplitude, model, objective=objective, seed=0, tolerance=1e-4)
    need_no_limits(job, "explore")
    assert isinstance(job.bird, Bird)  # otherwise `single_job` has complained
    wake = job.model
    start = replace(WakeModel.named(model), core_radius_ratio=wake.core_radius_ratio, span_law=wake.span_law)
    needed = start.resolving(job.bird.wavelength_m / job.bird.semispan_m)
    if wake not in (start, needed) or (model == "paper" and start.span_law != "tip"):
        raise UpwashError(
            "--set: expected inputs of the bird, core_radius_ratio or, in the limit, span_law, found another part of "
            "the wake's model; the page has both models, choose one by --model"
        )
    path = write_explorer(
        output,
        species=load_species(species),
        bird=job.bird,
        objective=objective,
        model=model,
        start=start,
        observed=read_observed(observed) if observed else (),
        solving=lambda: at_work("searching the best places"),
    )
    click.echo(path)
