"""Pictures: the force map of a plane, a flapping flock, the figures and the page of a sweep."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from upwash.cli.printing import as_json
from upwash.cli.solve import problem
from upwash.cli.streams import at_work
from upwash.optimum.settings import FLOCK_CHOICES

if TYPE_CHECKING:
    import pandas as pd

    from upwash.jobs.kind import Kind

PLANES = ("xy", "xz", "xk")
OPTIMA = {"v": "is_v_optimum", "global": "is_global_optimum"}


@click.command()
@problem()
@click.option(
    "--plane",
    type=click.Choice(PLANES),
    default="xy",
    show_default=True,
    help="x downstream, y right, z up, k the phase.",
)
@click.option(
    "--optimum",
    type=click.Choice(list(OPTIMA)),
    default="v",
    show_default=True,
    help="Through which optimum: of the V formation, or of all.",
)
@click.option(
    "--size", type=click.IntRange(2, 10_000), default=500, show_default=True, help="Points along each side."
)
@click.option(
    "--output",
    metavar="DIR",
    type=click.Path(path_type=Path, file_okay=False),
    default=Path("results/field"),
    show_default=True,
    help="Folder for the files.",
)
@as_json
def field(plane: str, optimum: str, size: int, output: Path, json_output: bool, **chosen: Any) -> None:
    """Map the force on a follower over a plane through its optimum: own force and the wake's together.

    Writes the map as Parquet and as a figure (PDF and PNG), and prints their names. SPECIES is a name in the
    library or the path of a TOML file.

    \b
    Example:
      upwash field northern-bald-ibis --plane xz --size 1000
    """
    from upwash.batch.store import cannot_write
    from upwash.report.figures.catalogue import save_all
    from upwash.report.figures.force_maps import draw_plane
    from upwash.study.field import plane_through, ratios, write_field

    row = _optimum(optimum, chosen)
    found = plane_through(row, plane, size)
    try:
        output.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise cannot_write(output, error) from error
    at_work("drawing")
    stem = output / f"{row['species']}-{row['objective']}-{plane}"
    table = stem.with_name(f"{stem.name}.parquet")
    write_field(found, row, table)
    paths = [table, *save_all(draw_plane(found, row), stem, (".pdf", ".png"))]
    reach = {name: [float(one.min()), float(one.max())] for name, one in ratios(found, row).items()}
    if json_output:
        files = {path.suffix[1:]: str(path) for path in paths}
        place = {name: float(row[name]) for name in ("x_m", "y_m", "z_m", "phase")}
        click.echo(
            json.dumps(
                {
                    "plane": plane,
                    "size": size,
                    "optimum": place,
                    "lift_over_weight": reach["lift"],
                    "thrust_over_drag": reach["thrust"],
                    "files": files,
                },
                indent=2,
            )
        )
        return
    click.echo(
        "\n".join(
            [
                f"lift over weight {reach['lift'][0]:.3f} to {reach['lift'][1]:.3f}",
                f"thrust over drag {reach['thrust'][0]:.3f} to {reach['thrust'][1]:.3f}",
                *map(str, paths),
            ]
        )
    )


def _optimum(label: str, chosen: dict[str, Any]) -> pd.Series:
    """Solve one bird's pair and return the optimum asked for."""
    from upwash.columns import SOLVED
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.report.answer import answer

    rows = _solved(Pair, chosen)
    if rows["status"].iloc[0] != SOLVED:
        raise UpwashError(answer(rows))
    found = rows[rows[OPTIMA[label]].eq(True)]
    if found.empty:
        expected = "an optimum that is outboard, level and astern"
        raise UpwashError(f"{rows['species'].iloc[0]}: expected {expected}, found none; try --optimum global")
    return found.iloc[0]


def _solved(kind: type[Kind], chosen: dict[str, Any]) -> pd.DataFrame:
    """Solve the problem that a command line states and return its rows."""
    from upwash.jobs.run import solve
    from upwash.jobs.schema import table_of
    from upwash.sweep.single import single_job

    job = single_job(kind, **chosen)
    at_work("solving")
    return table_of(solve(job), job.kind.rows).to_pandas()


@click.command()
@problem()
@click.option("--birds", type=click.IntRange(2, 24), default=4, show_default=True, help="Birds in the flock.")
@click.option(
    "--shape",
    type=click.Choice(FLOCK_CHOICES["shape"]),
    default="echelon",
    show_default=True,
    help="One line, two from one leader, or sides in turn.",
)
@click.option(
    "--output",
    metavar="FILE",
    type=click.Path(path_type=Path, dir_okay=False),
    default=Path("flock.gif"),
    show_default=True,
    help="File to write: .gif, or .mp4 where ffmpeg is installed.",
)
def animate(birds: int, shape: str, output: Path, **chosen: Any) -> None:
    """Animate a flock flapping in its wakes: one wingbeat that repeats, each bird in its own phase.

    Every follower flies at the V optimum behind the bird ahead. Prints the name of the file. SPECIES is a
    name in the library or the path of a TOML file.

    \b
    Example:
      upwash animate northern-bald-ibis --birds 6 --output ibises.gif
    """
    from upwash.columns import SOLVED
    from upwash.errors import UpwashError
    from upwash.jobs.flock import Flock
    from upwash.report.animation import check_ending, write_animation

    check_ending(output)
    flock = {"birds": birds, "shape": shape, "wake": "neighbour", "reading": "immediate"}
    rows = _solved(Flock, chosen | flock)
    placed = rows[(rows["status"] == SOLVED) & rows["x_flock_m"].notna()]
    if len(placed) < 2:
        raise UpwashError(f"{rows['species'].iloc[0]}: {rows['error'].dropna().iloc[-1]}")
    if len(placed) < birds:
        click.echo(f"{len(placed)} of {birds} birds: {rows['error'].dropna().iloc[-1]}", err=True)
    at_work("drawing")
    write_animation(placed, output)
    click.echo(output)


@click.command()
@click.argument("results", metavar="RESULTS...", nargs=-1, required=True)
def page(results: tuple[str, ...]) -> None:
    """Draw the figures of a gathered results folder and write the page that tells its story.

    The page is index.html in the first folder, one file that needs no network. What that folder does not
    hold, such as a flock or other species, is taken from the other folders. Prints the name of the page.

    \b
    Example:
      upwash page results/reproduce results/flock results/cross-species
    """
    from upwash.report.page import write_page

    at_work("drawing")
    click.echo(write_page(*results))
