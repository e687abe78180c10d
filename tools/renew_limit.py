"""Renew the table of docs/limit.md: what each species saves in the limit, by both laws of the follower's span.

It is solved here and takes some minutes. The table stands between two marks that bear its name.
"""

import re
import sys
from contextlib import suppress
from math import isfinite
from pathlib import Path

import pandas as pd
from upwash.jobs.pair import Pair
from upwash.report.table import Table
from upwash.report.words import common_name
from upwash.species import ImpossibleAmplitude
from upwash.species.library import library_paths
from upwash.study.limit_ranges import SAMPLES, SEED, LimitRange, limit_ranges, pair_in
from upwash.sweep.single import jobs_within_ranges

PAGE = Path(__file__).parents[1] / "docs" / "limit.md"
CONVENTIONS = ("stroke-angle", "strouhal")


def ranges_of(species: str, convention: str) -> list[LimitRange]:
    """Return what a species saves at the V optimum of least power, by each span law."""
    jobs = jobs_within_ranges(
        SAMPLES,
        SEED,
        kind=Pair,
        species=species,
        settings=[],
        amplitude=convention,
        model="limit",
        objective="power",
        seed=0,
        tolerance=1e-4,
    )
    birds = {law: [pair_in(job) for job in of_law] for law, of_law in jobs.items()}
    return limit_ranges(birds, "power", in_v=True)


def told(of_law: LimitRange) -> str:
    """Write a saving in percent with its interval, and in how many samples there is no V optimum, if in some."""
    if not isfinite(of_law.saving_total_low):
        return "no V"
    own = f"{100.0 * of_law.saving_total:.1f}" if isfinite(of_law.saving_total) else "no V"
    low, high = 100.0 * of_law.saving_total_low, 100.0 * of_law.saving_total_high
    lost = f", {of_law.samples_without} without" if of_law.samples_without else ""
    return f"{own} [{low:.1f},\N{NO-BREAK SPACE}{high:.1f}]{lost}"


def savings() -> Table:
    """Return what each species saves, under both amplitude conventions and by both span laws."""
    rows = []
    for species in (path.stem for path in library_paths()):
        row = {"species": common_name(species)}
        for convention in CONVENTIONS:
            row |= {f"{convention}, {law} law": "no such stroke" for law in ("stroke", "tip")}
            with suppress(ImpossibleAmplitude):
                row |= {
                    f"{convention}, {one.span_law} law": told(one) for one in ranges_of(species, convention)
                }
        print(row, file=sys.stderr)
        rows.append(row)
    return Table("", pd.DataFrame(rows))


def put(name: str, table: Table) -> None:
    """Put a table into the page."""
    text = PAGE.read_text(encoding="utf-8")
    body = table.markdown().partition("\n\n")[2]
    pattern = re.compile(rf"(?<=<!-- {name}: begin -->\n)(.*?)(?=<!-- {name}: end -->)", re.DOTALL)
    text, count = pattern.subn(lambda _: f"\n{body}\n\n", text)
    if count != 1:
        sys.exit(f"{PAGE}: expected one table named {name}, found {count}; mark its place")
    PAGE.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    put("savings", savings())
