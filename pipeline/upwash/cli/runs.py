"""Sweeps over many: run, merge, status, aggregate, check, show, rerun, diff."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from textwrap import indent
from typing import Any

import click

from upwash.cli.streams import at_work

FAILED_EXIT = 1
FINDINGS_SHOWN = 20

as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON.")
results = click.argument("results", metavar="RESULTS")


def _say(line: str) -> None:
    """Write a line for a person, apart from the results."""
    click.echo(line, err=True)


def _print_json(value: Any) -> None:
    click.echo(json.dumps(value, indent=2, allow_nan=False))


def _print_foresight(plan_ahead: Callable[..., Any]) -> None:
    """Print what is foreseen as JSON, job by job as they come."""
    before = "["

    def show(job: Any) -> None:
        nonlocal before
        click.echo(f"{before}\n{indent(json.dumps(asdict(job), indent=2), '    ')}", nl=False)
        before = ","

    click.echo('{\n  "jobs": ', nl=False)
    foresight = asdict(plan_ahead(show, _say))
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
    as_json: bool,
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
    read = read_sweep(sweep, _say)
    folder = ResultsFolder(results or f"results/{read.name}")
    if dry_run:
        from upwash.batch.dry_run import foresee

        at_work("looking at what is left to do")
        plan_ahead = partial(foresee, read, folder, shard, retry_failed, workers)
        if as_json:
            _print_foresight(plan_ahead)
        else:
            foresight = plan_ahead(
                lambda job: click.echo(
                    f"{job.job_id}  {'run ' if job.runs else 'keep'}  {job.label}  ({job.reason})"
                ),
                _say,
            )
            _say(foresight.words())
        return
    from upwash.batch.runner import Interrupted, Options, run_sweep

    plan = Plan(read.name, read.kind, read.text, [job.job_id for job in read.jobs])
    options = Options(workers, backend, scheduler or "", shard, retry_failed, fail_fast)
    try:
        at_work("solving")
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
@click.argument("out", metavar="OUT")
@click.argument("parts", metavar="PART...", nargs=-1, required=True)
@as_json
def merge(out: str, parts: tuple[str, ...], as_json: bool) -> None:
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
    if as_json:
        _print_json({"results": out, **asdict(merged), "left": merged.left})
        return
    for part, jobs in merged.by_folder.items():
        _say(f"{part}: {jobs} jobs")
    more = [(merged.twice, "in several of them"), (merged.failed, "failed"), (merged.left, "left")]
    more += [(merged.others, "that the sweep does not name")]
    words = "".join(f", {count} {what}" for count, what in more if count)
    _say(f"{out}: {merged.found} of {merged.jobs} jobs{words}")


@click.command()
@results
@click.option("--jobs", "list_all", is_flag=True, help="List each job: id, how it ended, what it is.")
@as_json
def status(results: str, list_all: bool, as_json: bool) -> None:
    """Say how far a sweep has come.

    Exit code 1 if some jobs failed.

    \b
    Example:
      upwash status results/reproduce
    """
    from upwash.batch.folder import ResultsFolder
    from upwash.batch.listing import list_jobs
    from upwash.batch.progress import duration
    from upwash.batch.status import status_of

    if list_all:
        listed = list_jobs(ResultsFolder(results))
        if as_json:
            _print_json([asdict(one) for one in listed])
        for one in listed if not as_json else ():
            cause = f"  ({one.cause})" if one.cause else ""
            click.echo(f"{one.job_id}  {one.status:10}  {one.label}{cause}".rstrip())
        if any(one.status == "failed" for one in listed):
            raise click.exceptions.Exit(FAILED_EXIT)
        return
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
    gathered = gather(ResultsFolder(results), _say)
    if as_json:
        _print_json(asdict(gathered))
    else:
        missing = f", {gathered.missing} without a result yet" if gathered.missing else ""
        retired = f", {gathered.retired} that the sweep does not name set apart" if gathered.retired else ""
        _say(f"{results}: gathered {gathered.jobs} jobs{missing}{retired}")
    after_aggregate(results, _say)


@click.command()
@results
@click.option("--prove", is_flag=True, help="Repeat the proofs, from the stored rows alone.")
@as_json
def check(results: str, prove: bool, as_json: bool) -> None:
    """Check that a results folder holds what it must.

    Schema, units, versions, one result a job; balances, bounds, ranks and labels; forces, powers, costs and
    the evidence for each optimum computed anew from where it lies; one proof a job that fits its costs; the
    summary against its rows. With --prove the proofs are repeated too. Exit code 3 if anything does not hold,
    and else 1 if some jobs failed.

    \b
    Example:
      upwash check results/reproduce
      upwash check results/reproduce --prove
    """
    from upwash.batch.check import check as look_at
    from upwash.batch.folder import ResultsFolder
    from upwash.errors import CheckFailed

    at_work("checking")
    checked = look_at(ResultsFolder(results), prove)
    findings, jobs, failed = checked.findings, len(checked.jobs), len(checked.failed)
    if as_json:
        counts = {"results": results, "jobs": jobs, "failed": failed}
        _print_json({**counts, "findings": [asdict(one) for one in findings]})
    for finding in findings[1:FINDINGS_SHOWN]:
        _say(str(finding))
    if findings:
        more = f" (and {len(findings) - 1} more)" if len(findings) > 1 else ""
        raise CheckFailed(f"{results}: {findings[0]}{more}")
    if failed:
        others = ", the others in order" if failed < jobs else ""
        _say(f"{results}: {jobs} jobs, {failed} failed{others}; see 'upwash status {results}'")
        raise click.exceptions.Exit(FAILED_EXIT)
    _say(f"{results}: {jobs} jobs, all in order{' and proved again' if prove else ''}")


@click.command()
@results
@click.argument("job")
@as_json
def show(results: str, job: str, as_json: bool) -> None:
    """Show one job: its inputs, and each of its optima.

    JOB is its id, or the beginning of it.

    \b
    Example:
      upwash show results/reproduce 20f1
    """
    from upwash import columns as of
    from upwash.batch.folder import ResultsFolder
    from upwash.batch.lookup import rows_of

    rows = [of.told(row) for row in rows_of(ResultsFolder(results), job)]
    if as_json:
        _print_json(rows)
        return
    columns = [column for column in of.COLUMNS if column.name in rows[0]]
    table = [column.name for column in columns if of.OPTIMA in column.listed]
    # What tells the optima apart comes first.
    table.sort(key=lambda name: of.column(name).verified not in (of.CHAIN, of.RANKING))
    # What a solver of the user's own adds comes last.
    table += [name for name in rows[0] if name not in of.names(of.COLUMNS)]
    for column in columns:
        name, value = column.name, rows[0][column.name]
        if name not in table and value not in (None, "") and all(row[name] == value for row in rows):
            unit = column.unit if column.unit != "1" else ""
            click.echo(f"{name:28}{_cell(value)} {unit}".rstrip())
    shown = [name for name in table if any(row[name] is not None for row in rows)]
    lines = [shown, *([_cell(row[name]) for name in shown] for row in rows)] if shown else []
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    for line in lines:
        click.echo("  ".join(cell.rjust(width) for cell, width in zip(line, widths, strict=True)))
    for row in rows if len(rows) > 1 else ():
        if row["error"]:
            click.echo(f"bird {row['bird']}: {row['error']}")


def _cell(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        return f"{value:.6g}"
    return "-" if value is None else str(value)


@click.command()
@results
@click.argument("job")
@as_json
def rerun(results: str, job: str, as_json: bool) -> None:
    """Solve one stored job again, from its own inputs alone, and compare.

    JOB is its id, or the beginning of it. Nothing is written. Exit code 3 if the results do not agree.

    \b
    Example:
      upwash rerun results/reproduce 20f1
    """
    from upwash.batch.compare import compare
    from upwash.batch.folder import ResultsFolder
    from upwash.batch.lookup import rows_of
    from upwash.jobs.job import job_of
    from upwash.jobs.run import run_job, schema_of_rows
    from upwash.jobs.schema import table_of

    stored = rows_of(ResultsFolder(results), job)
    at_work("solving")
    again = job_of(stored[0])
    schema = schema_of_rows(again)
    rows = [{name: row.get(name) for name in schema.names} for row in stored]
    comparison = compare(table_of(rows, schema), table_of(run_job(again).rows, schema))
    _report([comparison], f"{results}, job {again.job_id}", ("stored", "now"), as_json)


@click.command()
@click.argument("first", metavar="A")
@click.argument("second", metavar="B")
@as_json
def diff(first: str, second: str, as_json: bool) -> None:
    """Compare two results folders, job by job.

    Jobs are the same if their physical inputs are, whatever their ids. Each column has its own tolerance.
    Exit code 3 if the folders do not agree.

    \b
    Example:
      upwash diff results/reproduce results/reference
    """
    from upwash.batch.compare import compare_folders
    from upwash.batch.folder import ResultsFolder

    at_work("comparing")
    comparisons = compare_folders(ResultsFolder(first), ResultsFolder(second))
    _report(comparisons, f"{first} and {second}", (first, second), as_json)


def _report(comparisons: Any, what: str, names: tuple[str, str], as_json: bool) -> None:
    """Print what came of a comparison, and fail if that is not agreement."""
    from upwash.errors import CheckFailed

    if as_json:
        _print_json([asdict(one) for one in comparisons])
    else:
        for one in comparisons:
            for name, jobs in zip(names, (one.only_first, one.only_second), strict=True):
                if jobs:
                    shown = ", ".join(jobs[:3]) + (", ..." if len(jobs) > 3 else "")
                    click.echo(f"only in {name}: {len(jobs)} jobs ({shown})")
            for found in one.differences:
                values = f"{_cell(found.first)} and {_cell(found.second)}"
                rows = f"{found.rows} of {one.rows} rows"
                click.echo(
                    f"{found.column}: {rows}, most in job {found.job_id}: {values} (allowed {found.allowed})"
                )
    if not all(one.agrees for one in comparisons):
        raise CheckFailed(f"{what}: expected agreement, found differences in rows or columns, listed above")
    _say(f"{what} agree in {comparisons[0].rows} rows")
