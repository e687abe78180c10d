"""What is left of the best place's saving while a bird drifts."""

from __future__ import annotations

import json
from typing import Any

import click

from upwash.cli.printing import as_json
from upwash.cli.solve import problem
from upwash.cli.streams import at_work

USUAL = "0.05,0.1,0.2"


@click.command()
@problem(objective="power")
@click.option(
    "--sigma", metavar="B,...", help=f"Standard deviations of the place, in semispans.  [default: {USUAL}]"
)
@click.option("--sigma-m", metavar="M,...", help="The same in metres.")
@click.option(
    "--sigma-phase",
    type=float,
    default=0.0,
    show_default=True,
    metavar="BEATS",
    help="Standard deviation of the phase, in wingbeats.",
)
@click.option("--csv", "csv_output", is_flag=True, help="Print CSV instead of text.")
@as_json
def robust(
    sigma: str | None,
    sigma_m: str | None,
    sigma_phase: float,
    csv_output: bool,
    json_output: bool,
    **chosen: Any,
) -> None:
    """Say what is left of the best place's saving while a bird drifts about it, and which place leaves most.

    SPECIES is a name in the library or the path of a TOML file. The place jitters in x, y and z with
    independent normal errors. Either the bird flaps always alike, so that it balances in the mean, or it trims
    its stroke anew at each place. How far off the place half of the saving is left is told too.

    \b
    Example:
      upwash robust northern-bald-ibis
      upwash robust northern-bald-ibis --model limit --sigma-m 0.05,0.1
    """
    from upwash.aero.bird import Bird
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.report.robust_answer import robust_answer
    from upwash.report.table import Table
    from upwash.study.robustness import robustness
    from upwash.sweep.single import need_no_limits, single_job

    if csv_output and json_output:
        raise UpwashError("--csv and --json: expected one of them, found both; leave one out")
    if sigma is not None and sigma_m is not None:
        raise UpwashError("--sigma and --sigma-m: expected one of them, found both; leave one out")
    job = single_job(Pair, **chosen)
    need_no_limits(job, "robust")
    # A single job that makes no bird is refused.
    assert isinstance(job.bird, Bird)
    b = job.bird.semispan_m
    if sigma_m is not None:
        sigmas_m = _deviations("--sigma-m", sigma_m, b)
    else:
        sigmas_m = [b * one for one in _deviations("--sigma", sigma or USUAL, 1.0)]
    if not 0.0 <= sigma_phase <= 1.0:
        raise UpwashError(f"--sigma-phase: expected wingbeats from 0 to 1, found {sigma_phase}; correct it")
    at_work("solving")
    rows = robustness(
        job.bird,
        job.objective,
        model=job.model,
        sigmas_m=sigmas_m,
        sigma_phase=sigma_phase,
        search=job.search,
        species=job.species,
    )
    table = Table("", rows)
    if csv_output:
        click.echo(table.csv(), nl=False)
    elif json_output:
        click.echo(json.dumps(table.records(), indent=2, allow_nan=False, ensure_ascii=False))
    elif rows.empty:
        click.echo(
            f"{job.species}: no optimum, so that nothing is left to drift from; upwash optimum says why"
        )
    else:
        click.echo(robust_answer(rows))


def _deviations(option: str, text: str, semispan: float) -> list[float]:
    """Read a list of standard deviations, each up to a semispan.

    Raises
    ------
    UpwashError
        If one of them is none.
    """
    from upwash.errors import UpwashError

    found = []
    for part in text.split(","):
        try:
            value = float(part)
        except ValueError:
            value = float("nan")
        if not 0.0 <= value <= semispan:
            raise UpwashError(
                f"{option}: expected numbers from 0 to {semispan:g} (a semispan) with commas between, found "
                f"{part.strip()!r}; write as in 0.05,0.1"
            )
        found.append(value)
    return found
