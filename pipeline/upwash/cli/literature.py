"""What others published, beside both models."""

from __future__ import annotations

import json

import click

from upwash.cli.streams import at_work


@click.command()
@click.option("--fresh", is_flag=True, help="Solve and judge anew, which takes half a minute.")
@click.option("--json", "json_output", is_flag=True, help="Print JSON instead of text.")
@click.option("--csv", "csv_output", is_flag=True, help="Print CSV instead of text.")
def literature(fresh: bool, json_output: bool, csv_output: bool) -> None:
    """Set what others measured, computed and derived beside the paper's model and the limit.

    Each entry has a verdict for both models, its source, how sure its number is, and one line of why. What a
    model contradicts comes first. The ledger that is printed comes with Upwash; with --fresh it is judged by
    solving both models for every bird that it names. That a model fails is a finding and no error.

    \b
    Example:
      upwash literature --csv
    """
    from upwash.literature.ledger import judge_literature, read_kept, records
    from upwash.report.literature import literature_text

    if json_output and csv_output:
        raise click.UsageError("--json or --csv: expected one of them, found both; choose one")
    if fresh:
        at_work("solving both models for the birds of the literature")
    ledger = judge_literature() if fresh else read_kept()
    if json_output:
        click.echo(json.dumps(records(ledger), ensure_ascii=False, indent=2, allow_nan=False))
    elif csv_output:
        click.echo(ledger.to_csv(index=False, lineterminator="\n"), nl=False)
    else:
        click.echo(literature_text(ledger))
