"""The paper's claims, judged."""

from __future__ import annotations

import json

import click

from upwash.cli.streams import at_work


@click.command()
@click.argument("results", metavar="RESULTS")
@click.option("--json", "json_output", is_flag=True, help="Print JSON instead of text.")
def claims(results: str, json_output: bool) -> None:
    """Judge each claim of the paper by our numbers.

    RESULTS is the gathered results folder of the sweep reproduce. Claims on flocks, on airspeed and in the
    limit need the results of the sweeps paper-flocks, group-speed and limit in folders of these names beside
    it; without them they are not run. The ledger is printed and kept as claims.parquet in RESULTS. That a
    claim fails is a finding and no error.

    \b
    Example:
      upwash claims results/reproduce
    """
    from upwash.batch.folder import ResultsFolder
    from upwash.paper import judge_claims, read_evidence
    from upwash.paper.ledger import ledger_records, write_claims
    from upwash.report.claims import ledger_text

    at_work("judging the claims")
    ledger = judge_claims(read_evidence(results))
    if json_output:
        click.echo(json.dumps(ledger_records(ledger), ensure_ascii=False, indent=2, allow_nan=False))
    else:
        click.echo(ledger_text(ledger))
    plan = ResultsFolder(results).plan()
    path = write_claims(ledger, results, plan.text if plan else "")
    click.echo(f"{path}: {len(ledger)} claims", err=True)
