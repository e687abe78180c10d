"""A results folder, looked at: status, check, show, rerun, diff."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import click

from upwash.cli.printing import as_json, print_json, say
from upwash.cli.streams import at_work
from upwash.errors import FAILED_EXIT

FINDINGS_SHOWN = 20

results = click.argument("results", metavar="RESULTS")


@click.command()
@results
@click.option("--jobs", "list_all", is_flag=True, help="List each job: id, how it ended, what it is.")
@as_json
def status(results: str, list_all: bool, json_output: bool) -> None:
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
        if json_output:
            print_json([asdict(one) for one in listed])
        for one in listed if not json_output else ():
            cause = f"  ({one.cause})" if one.cause else ""
            click.echo(f"{one.job_id}  {one.status:10}  {one.label}{cause}".rstrip())
        if any(one.status == "failed" for one in listed):
            raise click.exceptions.Exit(FAILED_EXIT)
        return
    found = status_of(ResultsFolder(results))
    if json_output:
        print_json(asdict(found))
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
@click.option("--prove", is_flag=True, help="Repeat the proofs, from the stored rows alone.")
@as_json
def check(results: str, prove: bool, json_output: bool) -> None:
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
    if json_output:
        counts = {"results": results, "jobs": jobs, "failed": failed}
        print_json({**counts, "findings": [asdict(one) for one in findings]})
    for finding in findings[1:FINDINGS_SHOWN]:
        say(str(finding))
    if findings:
        more = f" (and {len(findings) - 1} more)" if len(findings) > 1 else ""
        raise CheckFailed(f"{results}: {findings[0]}{more}")
    if failed:
        others = ", the others in order" if failed < jobs else ""
        say(f"{results}: {jobs} jobs, {failed} failed{others}; see 'upwash status {results}'")
        raise click.exceptions.Exit(FAILED_EXIT)
    say(f"{results}: {jobs} jobs, all in order{' and proved again' if prove else ''}")


@click.command()
@results
@click.argument("job")
@as_json
def show(results: str, job: str, json_output: bool) -> None:
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
    if json_output:
        print_json(rows)
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
def rerun(results: str, job: str, json_output: bool) -> None:
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
    _report([comparison], f"{results}, job {again.job_id}", ("stored", "now"), json_output)


@click.command()
@click.argument("first", metavar="A")
@click.argument("second", metavar="B")
@as_json
def diff(first: str, second: str, json_output: bool) -> None:
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
    _report(comparisons, f"{first} and {second}", (first, second), json_output)


def _report(comparisons: Any, what: str, names: tuple[str, str], json_output: bool) -> None:
    """Print what came of a comparison, and fail if that is not agreement."""
    from upwash.errors import CheckFailed

    if json_output:
        print_json([asdict(one) for one in comparisons])
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
    say(f"{what} agree in {comparisons[0].rows} rows")
