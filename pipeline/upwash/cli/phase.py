"""The phase rule: when to flap, against distance."""

from __future__ import annotations

import json
from typing import Any

import click

from upwash.cli.printing import as_json
from upwash.cli.solve import problem
from upwash.cli.streams import at_work

MODEL = "limit"


@click.command()
@problem(objective="power", model=MODEL)
@click.option(
    "--all", "show_all", is_flag=True, help="Print every phase that was tried, and not the best alone."
)
@click.option("--csv", "csv_output", is_flag=True, help="Print CSV instead of text.")
@as_json
def phase(show_all: bool, csv_output: bool, json_output: bool, **chosen: Any) -> None:
    """Find the best phase of a follower against its distance, in a V and straight behind its leader.

    SPECIES is a name in the library or the path of a TOML file. In a V the follower flies as far aside and as
    high as the V optimum; in line straight behind at its leader's height, with as much amplitude and as much
    flexion as wings have. Ibises flap spatially in phase in a V and in antiphase in line (Portugal et al.
    2014); whether this bird would is judged. The paper's model, in which phases are 0 or ½, cannot tell, so
    that the limit is usual here, by both laws of the follower's span.

    \b
    Example:
      upwash phase northern-bald-ibis
      upwash phase northern-bald-ibis --csv --all > phases.csv
    """
    from upwash.aero.bird import Bird
    from upwash.columns import told
    from upwash.errors import UpwashError
    from upwash.jobs.pair import Pair
    from upwash.report.phase_answer import phase_answer
    from upwash.study.phase_rule import phase_rules
    from upwash.sweep.single import jobs_within_ranges, need_no_limits

    if csv_output and json_output:
        raise UpwashError("--csv and --json: expected one of them, found both; leave one out")
    settings = chosen["settings"]
    given = {text.partition("=")[0].strip() for text in settings}
    if chosen["model"] is None and "model" not in given:
        chosen["model"] = MODEL
    jobs = [of_law[0] for of_law in jobs_within_ranges(0, 0, kind=Pair, **chosen).values()]
    # The paper's two states say the same by both laws.
    if "span_law" in given or jobs[0].model.stroke_states == 2:
        jobs = [
            job for job in jobs if f"span_law={job.model.span_law}" in "".join(settings).replace(" ", "")
        ] or jobs[-1:]
    need_no_limits(jobs[0], "phase")
    bird = jobs[0].bird
    if not isinstance(bird, Bird):
        raise UpwashError(
            f"{chosen['species']}: expected a stroke that wings can make, found none; set another"
        )
    at_work("solving")
    rule, curve = phase_rules(bird, jobs[0].objective, [job.model for job in jobs], jobs[0].search)
    rows = curve if show_all else rule
    if csv_output:
        click.echo(rows.to_csv(index=False, lineterminator="\n"), nl=False)
    elif json_output:
        records = rows.astype(object).where(rows.notna(), None).to_dict("records")
        told_rows = [told({str(name): value for name, value in row.items()}) for row in records]
        click.echo(json.dumps(told_rows, indent=2, allow_nan=False))
    else:
        click.echo(phase_answer(jobs[0].species, jobs[0].objective, rule, curve if show_all else None))
