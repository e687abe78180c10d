"""The paper: redo it, and judge its claims."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

from upwash.cli.printing import as_json, say
from upwash.cli.streams import at_work
from upwash.errors import FAILED_EXIT, CheckFailed
from upwash.shipped import shipped

if TYPE_CHECKING:
    from upwash.batch.folder import ResultsFolder
    from upwash.study.limit_ranges import LimitRange

SWEEP = "reproduce"
WORKERS = 2

REFERENCE = shipped("results/reference")


@click.command()
@click.option(
    "--results",
    metavar="DIR",
    default=f"results/{SWEEP}",
    show_default=True,
    help="Results folder of the pair; those of flocks, airspeeds and the limit are beside it.",
)
@as_json
def reproduce(results: str, json_output: bool) -> None:
    """Redo the paper, and print its table beside ours.

    Solves the paper's pair for both of its objectives, its flocks, the pair at other airspeeds, and the pair
    where the equations are converged; checks the results and compares those of the pair with what is kept
    with the code. Then lets the birds drift about their best places, judges the paper's claims, draws its
    figures, and writes a page that shows all of it. What is solved already is kept. Exit code 3 if a check
    fails.

    \b
    Example:
      upwash reproduce
    """
    from upwash.batch.compare import compare_folders
    from upwash.batch.folder import ResultsFolder
    from upwash.batch.store import read_table
    from upwash.paper import judge_claims, read_evidence
    from upwash.paper.evidence import LIMIT, beside
    from upwash.paper.ledger import tally, write_claims
    from upwash.report.claims import counts
    from upwash.report.page import write_page
    from upwash.report.reproduction import reproduction, reproduction_record
    from upwash.species.library import REFERENCE as SPECIES
    from upwash.study.drift import keep_drift
    from upwash.study.limit_ranges import keep_ranges
    from upwash.study.sources import read_study

    folder = ResultsFolder(results)
    others = beside(folder.path)
    text = solve_and_check(SWEEP, folder)
    for path in others:
        solve_and_check(path.name, ResultsFolder(path))
    solutions = read_table(folder.gathered(), folder.schema()).to_pandas()
    in_limit = next(path for path in others if path.name == LIMIT)
    at_work("letting the birds drift")
    for path in (folder.path, in_limit):
        keep_drift(path, read_study(path).rows)
    at_work("solving for birds within the species' ranges")
    keep_ranges(in_limit, SPECIES, "power", find_ranges)
    comparison = compare_folders(folder, ResultsFolder(REFERENCE))[0]
    at_work("judging the claims")
    ledger = judge_claims(read_evidence(results))
    claims = write_claims(ledger, results, text)
    at_work("drawing")
    page = write_page(results, *others)
    if json_output:
        record = {
            "results": results,
            **reproduction_record(solutions),
            "agrees_with_reference": comparison.agrees,
            "reference": asdict(comparison),
            "claims": {"file": str(claims), "verdicts": tally(ledger)},
            "page": str(page),
        }
        click.echo(json.dumps(record, ensure_ascii=False, indent=2, allow_nan=False))
    else:
        click.echo(reproduction(solutions))
    say(f"{claims}: {counts(ledger)}")
    say(f"{page}: the page about all of it, to be opened in a browser")
    for found in comparison.differences:
        values = f"found {found.first}, kept {found.second}"
        say(f"{found.column}, job {found.job_id}: {values} (may differ by {found.allowed})")
    if not comparison.agrees:
        remedy = f"see 'upwash diff {results} {REFERENCE}'"
        raise CheckFailed(f"{results}: expected what is kept in {REFERENCE}, found something else; {remedy}")
    say(f"{results}: agrees with {REFERENCE}")


def find_ranges() -> list[LimitRange]:
    """Find what the paper's bird saves in the limit, with its species' own ranges."""
    from upwash.jobs.pair import Pair
    from upwash.species.library import REFERENCE as SPECIES
    from upwash.study.limit_ranges import SAMPLES, SEED, limit_ranges, pair_in
    from upwash.sweep.single import jobs_within_ranges

    asked: dict[str, Any] = {
        "species": SPECIES,
        "settings": (),
        "amplitude": "stroke-angle",
        "model": "limit",
    }
    asked |= {"objective": "power", "seed": 0, "tolerance": 1e-4}
    jobs = jobs_within_ranges(SAMPLES, SEED, kind=Pair, **asked)
    birds = {law: [pair_in(one) for one in of_law] for law, of_law in jobs.items()}
    return limit_ranges(birds, "power", in_v=True)


def solve_and_check(sweep: str, folder: ResultsFolder) -> str:
    """Solve, gather and check a sweep, and return its text.

    Raises
    ------
    CheckFailed
        If the results are not what they must be.
    Exit
        With code 1, if a job failed.
    """
    from upwash.batch.aggregate import aggregate
    from upwash.batch.check import check
    from upwash.batch.folder import Plan
    from upwash.batch.runner import Options, run_sweep
    from upwash.sweep import read_sweep

    read = read_sweep(sweep)
    plan = Plan(read.name, read.kind, read.text, [job.job_id for job in read.jobs])
    at_work(f"solving {read.name}")
    tally = run_sweep(read.jobs, plan, folder, Options(workers=WORKERS), sys.stderr)
    if tally.failed:
        say(f"{folder}: {tally.failed} of {tally.jobs} jobs failed; see 'upwash status {folder}'")
        raise click.exceptions.Exit(FAILED_EXIT)
    at_work(f"gathering and checking {read.name}")
    aggregate(folder, say)
    checked = check(folder)
    for finding in checked.findings[1:]:
        say(str(finding))
    if checked.findings:
        raise CheckFailed(f"{folder}: {checked.findings[0]}")
    say(f"{folder}: {len(checked.jobs)} jobs solved and checked")
    return read.text
