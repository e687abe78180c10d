"""Sweeps over many: run, merge, aggregate."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from textwrap import indent
from typing import Any

import click

from upwash.cli.printing import as_json, print_json, say
from upwash.cli.streams import at_work
from upwash.errors import FAILED_EXIT


def _print_foresight(plan_ahead: Callable[..., Any]) -> None:
    """Print what is foreseen as JSON, job by job as they come."""
    before = "["

    def show(job: Any) -> None:
        nonlocal before
        click.echo(f"{before}\n{indent(json.dumps(asdict(job), indent=2), '    ')}", nl=False)
        before = ","

    click.echo('{\n  "jobs": ', nl=False)
    foresight = asdict(plan_ahead(show, say))
    del foresight["jobs"]
    none = "[" if before == "[" else ""
    click.echo(f"{none}\n  ],{json.dumps(foresight, indent=2, allow_nan=False)[1:]}")


class ShardType(click.ParamType):
    """Part i of n, as in 3/16."""

    name = "i/n"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Read ``i/n``."""
        from upwash.batch.folder import Shard

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
@click.option(
    "--workers", type=click.IntRange(1, 1024), default=2, show_default=True, help="Worker processes."
)
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
    json_output: bool,
) -> None:
    """Solve every job of a sweep that has no result yet.

    SWEEP is a name in sweeps/ or the path of a TOML file. Interrupt it at will: what is finished is kept, and
    the same command goes on from there.

    \b
    Example:
      upwash run reproduce
    """
    from upwash.batch.folder import Plan, ResultsFolder
    from upwash.errors import UpwashError
    from upwash.sweep import read_sweep

    if (backend == "dask") != bool(scheduler):
        raise UpwashError(
            "--backend dask and --scheduler ADDRESS: expected both or neither, found one; add the other"
        )
    at_work(f"reading {sweep}")
    read = read_sweep(sweep, say)
    folder = ResultsFolder(results or f"results/{read.name}")
    if dry_run:
        from upwash.batch.dry_run import foresee

        at_work("looking at what is left to do")
        plan_ahead = partial(foresee, read, folder, shard, retry_failed, workers)
        if json_output:
            _print_foresight(plan_ahead)
        else:
            foresight = plan_ahead(
                lambda job: click.echo(
                    f"{job.job_id}  {'run ' if job.runs else 'keep'}  {job.label}  ({job.reason})"
                ),
                say,
            )
            say(foresight.words())
        return
    from upwash.batch.runner import Interrupted, Options, run_sweep

    plan = Plan(read.name, read.kind, read.text, [job.job_id for job in read.jobs])
    options = Options(workers, backend, scheduler or "", shard, retry_failed, fail_fast)
    try:
        at_work("solving")
        tally = run_sweep(read.jobs, plan, folder, options, sys.stderr)
    except Interrupted as interrupt:
        tally = interrupt.tally
        say(
            f"Interrupted: {tally.kept + tally.done} of {tally.jobs} jobs are done and kept in {folder}; "
            "run the same command again to go on"
        )
        raise click.exceptions.Exit(130) from None
    if json_output:
        print_json({"results": str(folder), **asdict(tally), "left": tally.left})
    else:
        failed = f", {tally.failed} failed" if tally.failed else ""
        left = f", {tally.left} left" if tally.left else ""
        say(f"{folder}: {tally.jobs} jobs, {tally.done} done now, {tally.kept} before{failed}{left}")
    if tally.failed:
        say("see 'upwash status' for the causes; --retry-failed does them again")
        raise click.exceptions.Exit(FAILED_EXIT)


@click.command()
@click.argument("out", metavar="OUT")
@click.argument("parts", metavar="PART...", nargs=-1, required=True)
@as_json
def merge(out: str, parts: tuple[str, ...], json_output: bool) -> None:
    """Make one results folder of those that the parts of a sweep wrote.

    PARTs are results folders of one sweep, gathered or not; they stay as they are. OUT is made new. A job that
    failed in one and is solved in another is solved; two results of a job that do not agree are refused.

    \b
    Example:
      upwash merge results/whole results/part-1 results/part-2
    """
    from upwash.batch.folder import ResultsFolder
    from upwash.batch.merge import merge as make_one

    at_work("merging")
    merged = make_one(ResultsFolder(out), [ResultsFolder(part) for part in parts])
    if json_output:
        print_json({"results": out, **asdict(merged), "left": merged.left})
        return
    for part, jobs in merged.by_folder.items():
        say(f"{part}: {jobs} jobs")
    more = [(merged.twice, "in several of them"), (merged.failed, "failed"), (merged.left, "left")]
    more += [(merged.others, "that the sweep does not name")]
    words = "".join(f", {count} {what}" for count, what in more if count)
    say(f"{out}: {merged.found} of {merged.jobs} jobs{words}")


@click.command()
@click.argument("results", metavar="RESULTS")
@as_json
def aggregate(results: str, json_output: bool) -> None:
    """Gather the jobs' files into solutions.parquet (flock.parquet) and summary.parquet.

    A sweep over species, over samples of their ranges or for sensitivity indices gets its tables as well, in
    RESULTS/tables.

    \b
    Example:
      upwash aggregate results/reproduce
    """
    from upwash.batch.aggregate import aggregate as gather
    from upwash.batch.folder import ResultsFolder
    from upwash.report.study_tables import after_aggregate

    at_work("gathering")
    gathered = gather(ResultsFolder(results), say)
    if json_output:
        print_json(asdict(gathered))
    else:
        missing = f", {gathered.missing} without a result yet" if gathered.missing else ""
        retired = f", {gathered.retired} that the sweep does not name set apart" if gathered.retired else ""
        say(f"{results}: gathered {gathered.jobs} jobs{missing}{retired}")
    after_aggregate(results, say)
