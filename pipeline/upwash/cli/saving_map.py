"""A map of what a follower saves."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import click

from upwash.cli.printing import as_json
from upwash.cli.solve import problem
from upwash.cli.streams import at_work
from upwash.place.choices import BOUNDS, PLANES


@click.command()
@problem(objective="power")
@click.option(
    "--plane",
    type=click.Choice(list(PLANES)),
    default="xy",
    show_default=True,
    help="x behind the leader, y right of it, z above it, k the phase.",
)
@click.option(
    "--over",
    metavar="NAME,...",
    help="What is optimised at each place: some of x, y, z, phase, and stroke.  [default: z,phase,stroke]",
)
@click.option(
    "--bounds",
    type=click.Choice(BOUNDS),
    default="wide",
    show_default=True,
    help="Within which a stroke is sought: as far as wings move, or as the paper searches.",
)
@click.option("--x-m", metavar="M|LOW,HIGH", help="Range of x in the plane, or its value elsewhere.")
@click.option("--y-m", metavar="M|LOW,HIGH", help="The same of y.")
@click.option("--z-m", metavar="M|LOW,HIGH", help="The same of z.")
@click.option("--phase", metavar="BEATS|LOW,HIGH", help="The same of the phase, in wingbeats.")
@click.option(
    "--size", type=click.IntRange(2, 5_000), default=200, show_default=True, help="Places along each side."
)
@click.option(
    "--observed",
    metavar="TABLE",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Observed birds, drawn as dots: a table as for `upwash evaluate`, or what that wrote.",
)
@click.option(
    "--jobs",
    type=click.IntRange(1, 1024),
    help="How many threads share the work; as many as there are processors if not given.",
)
@click.option(
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("results/map"),
    show_default=True,
    help="Folder for the files.",
)
@click.option("--csv", "as_csv", is_flag=True, help="Print every place as CSV.")
@as_json
def map(
    plane: str,
    over: str | None,
    bounds: str,
    x_m: str | None,
    y_m: str | None,
    z_m: str | None,
    phase: str | None,
    size: int,
    observed: Path | None,
    jobs: int | None,
    output: Path,
    as_csv: bool,
    json_output: bool,
    **chosen: Any,
) -> None:
    """Map what a follower saves: at each place of a plane the least cost, with the best of what is free there.

    SPECIES is a name in the library or the path of a TOML file. What the plane does not show and what is not
    optimised is as at the V optimum, or as --x-m, --y-m, --z-m and --phase say. Writes the map as Parquet and
    as a figure (PDF and PNG) with the zones in which a bird pays or cannot balance, and prints their names.

    \b
    Example:
      upwash map northern-bald-ibis --model limit --observed seen.csv
      upwash map northern-bald-ibis --plane yz --x-m 1.2 --over phase,stroke --csv
    """
    import os

    from upwash.aero.bird import Bird
    from upwash.batch.store import cannot_write
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.report.figures.catalogue import save_all
    from upwash.report.figures.saving_map import draw_saving_map
    from upwash.report.saving_map_answer import saving_map_answer
    from upwash.report.table import Table
    from upwash.study.observed.file import read_places
    from upwash.study.saving_map import map_savings
    from upwash.sweep.single import need_no_limits, single_job

    if as_csv and json_output:
        raise UpwashError("--csv, --json: expected one of them, found both; leave one out")
    job = single_job(Pair, **chosen)
    need_no_limits(job, "map")
    assert isinstance(job.bird, Bird)  # otherwise `single_job` has complained
    held, ranges = _told({"x": x_m, "y": y_m, "z": z_m, "phase": phase})
    seen = read_places(observed, job.species, job.bird) if observed else None
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(output, error) from error
    at_work("mapping")
    with ExitStack() as stack:
        found = map_savings(
            job.bird,
            plane,
            over=None if over is None else [name.strip() for name in over.split(",")],
            held=held,
            ranges=ranges,
            size=size,
            model=job.model,
            objective=job.objective,
            bounds=bounds,
            search=job.search,
            jobs=jobs or os.cpu_count() or 1,
            told=_bar(stack),
        )
    at_work("drawing")
    inputs = job.inputs()
    stem = output / f"{job.species}-{job.objective}-{plane}-{inputs['model']}"
    table = stem.with_name(f"{stem.name}.parquet")
    found.write(table, {name: str(value) for name, value in inputs.items()})
    files = [
        table,
        *save_all(draw_saving_map(found, job.species, str(inputs["model"]), seen), stem, (".pdf", ".png")),
    ]
    prints_rows = as_csv or json_output
    if as_csv:
        click.echo(Table("", found.frame()).csv(), nl=False)
    elif json_output:
        click.echo(json.dumps(Table("", found.frame()).records(), allow_nan=False, ensure_ascii=False))
    click.echo(saving_map_answer(found, job.species), err=prints_rows)
    for file in files:
        click.echo(str(file), err=prints_rows)


def _told(texts: dict[str, str | None]) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """Read what is said of coordinates: the values of those that are held, and the ranges of those that are not."""
    from upwash.errors import UpwashError

    held, ranges = {}, {}
    for name, text in texts.items():
        if text is None:
            continue
        try:
            values = [float(part) for part in text.split(",")]
        except ValueError:
            values = []
        if len(values) == 1:
            held[name] = values[0]
        elif len(values) == 2:
            ranges[name] = (values[0], values[1])
        else:
            option = "--phase" if name == "phase" else f"--{name}-m"
            raise UpwashError(f"{option}: expected a number, or two with a comma between, found {text!r}")
    return held, ranges


def _bar(stack: ExitStack) -> Callable[[int, int], None] | None:
    """Return what shows on a terminal how far the map is; None elsewhere."""
    if not sys.stderr.isatty():
        return None
    bar = stack.enter_context(click.progressbar(length=1, label="mapping", file=sys.stderr))

    def show(done: int, of: int) -> None:
        # What neighbours tell is work that is found on the way.
        bar.length = of
        bar.update(done - bar.pos)

    return show
