"""Sweeps over many: run, status, aggregate, check, show, rerun, diff."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import Any

import click

FAILED_EXIT = 1

as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
results = click.argument("results", metavar="RESULTS")


def _say(line: str) -> None:
    """Write a line for a person, apart from the results."""
    click.echo(line, err=True)


def _print_json(value: Any) -> None:
    click.echo(json.dumps(value, indent=2, allow_nan=False))


class ShardType(click.ParamType):
    """Part i of n, as in 3/16."""

    name = "i/n"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read ``i/n``."""
        from pipeline.batch.folder import Shard

        if isinstance(value, Shard):
            return value
        number, _, count = str(value).partition("/")
        if not (number.isdecimal() and count.isdecimal() and 1 <= int(number) <= int(count)):
            self.fail(f"expected i/n with 1 <= i <= n, as in 3/16, found {value!r}", param, ctx)
        return Shard(int(number), int(count))


@click.command()
@click.argument("sweep")
@click.option("--results", metavar="DIR", help="Results folder.  [default: results/NAME-OF-THE-SWEEP]")
@click.option("--dry-run", is_flag=True, help="List each job and why it would run; write nothing.")
@click.option("--workers", type=click.IntRange(1), default=2, show_default=True, help="Worker processes.")
@click.option("--backend", type=click.Choice(["loky", "dask"]), default="loky", show_default=True)
@click.option("--scheduler", metavar="ADDRESS", help="Address of the dask scheduler, as in tcp://host:8786.")
@click.option("--shard", type=ShardType(), default="1/1", show_default=True, help="Do part i of n only.")
@click.option("--retry-failed", is_flag=True, help="Do failed jobs again.")
@click.option("--fail-fast", is_flag=True, help="Stop at the first failure.")
@as_json
def run(
    sweep: str,
    results: str | None,
    dry_run: bool,
    workers: int,
    backend: str,
    scheduler: str | None,
    shard: Any,
    retry_failed: bool,
    fail_fast: bool,
    as_json: bool,
) -> None:
    r"""Solve every job of a sweep that has no result yet.

    SWEEP is a name in sweeps/ or the path of a TOML file. Interrupt it at will: what is finished is kept, and
    the same command goes on from there.

    \b
    Example:
      upwash run reproduce
    """
    from pipeline.batch.folder import Plan, ResultsFolder
    from pipeline.errors import UpwashError
    from pipeline.sweep import read_sweep

    if (backend == "dask") != bool(scheduler):
        raise UpwashError(
            "--backend dask and --scheduler ADDRESS: expected both or neither, found one; add the other"
        )
    read = read_sweep(sweep)
    folder = ResultsFolder(results or f"results/{read.name}")
    if dry_run:
        from pipeline.batch.dry_run import foresee

        foresight = foresee(read.jobs, folder, shard, retry_failed, workers)
        if as_json:
            _print_json(asdict(foresight))
        else:
            for job in foresight.jobs:
                click.echo(f"{job.job_id}  {'run ' if job.runs else 'keep'}  {job.label}  ({job.reason})")
            _say(foresight.words())
        return
    from pipeline.batch.runner import Interrupted, Options, run_sweep

    plan = Plan(read.name, read.jobs[0].kind, read.text, [job.job_id for job in read.jobs])
    options = Options(workers, backend, scheduler or "", shard, retry_failed, fail_fast)
    try:
        tally = run_sweep(read.jobs, plan, folder, options, sys.stderr)
    except Interrupted as interrupt:
        tally = interrupt.tally
        _say(
            f"Interrupted: {tally.kept + tally.done} of {tally.jobs} jobs are done and kept in {folder}; "
            "run the same command again to go on"
        )
        raise click.exceptions.Exit(130) from None
    if as_json:
        _print_json({"results": str(folder), **asdict(tally), "left": tally.left})
    else:
        failed = f", {tally.failed} failed" if tally.failed else ""
        left = f", {tally.left} left" if tally.left else ""
        _say(f"{folder}: {tally.jobs} jobs, {tally.done} done now, {tally.kept} before{failed}{left}")
    if tally.failed:
        _say("see 'upwash status' for the causes; --retry-failed does them again")
        raise click.exceptions.Exit(FAILED_EXIT)


@click.command()
@results
@as_json
def status(results: str, as_json: bool) -> None:
    r"""Say how far a sweep has come.

    Exit code 1 if some jobs failed.

    \b
    Example:
      upwash status results/reproduce
    """
    from pipeline.batch.folder import ResultsFolder
    from pipeline.batch.progress import duration
    from pipeline.batch.status import status_of

    found = status_of(ResultsFolder(results))
    if as_json:
        _print_json(asdict(found))
    else:
        ended = [f"{found.solved} solved", f"{found.infeasible} infeasible", f"{found.failed} failed"]
        click.echo(f"{found.jobs} jobs: {', '.join([*ended, f'{found.left} left'])}")
        for cause, count in found.causes.items():
            click.echo(f"  {count} x {cause}")
        if found.others:
            click.echo(f"{found.others} results of jobs that the sweep does not name")
        if found.jobs_per_s and found.seconds_left is not None:
            click.echo(f"running: {found.jobs_per_s:.3g} jobs/s, {duration(found.seconds_left)} left")
        else:
            click.echo("running" if found.is_running else "not running")
    if found.failed:
        raise click.exceptions.Exit(FAILED_EXIT)


@click.command()
@results
@as_json
def aggregate(results: str, as_json: bool) -> None:
    r"""Gather the jobs' files into solutions.parquet (flock.parquet) and summary.parquet.

    \b
    Example:
      upwash aggregate results/reproduce
    """
    from pipeline.batch.aggregate import aggregate as gather
    from pipeline.batch.folder import ResultsFolder

    gathered = gather(ResultsFolder(results), _say)
    if as_json:
        _print_json(asdict(gathered))
    else:
        missing = f", {gathered.missing} without a result yet" if gathered.missing else ""
        retired = f", {gathered.retired} that the sweep does not name set apart" if gathered.retired else ""
        _say(f"{results}: gathered {gathered.jobs} jobs{missing}{retired}")
