"""Renew the ledger of the literature: results/reference/literature.csv, and docs/literature.md that shows it.

``make reference`` does it. A changed verdict shows in the diff of literature.csv; a test judges anew and compares.
"""

from pathlib import Path

from upwash.literature.ledger import KEPT, VERDICTS, judge_literature, read_kept
from upwash.report.literature import literature_markdown

PAGE = Path(__file__).parents[1] / "docs" / "literature.md"

HEAD = """\
# What others found, beside both models

Birds that were observed, wings that do not flap, and a code of higher fidelity: each published number beside what the
paper's model and [the limit](limit.md) say. Two cases are told of each model: least force and least power by the
paper's, least power under the stroke law and the tip law in the limit, where least force has no V and the span law is
what is least known. Birds are those of the library, their amplitude by stroke angle, at the V optimum unless another
place is named.

How sure a number is: **read** in the original or its abstract, **quoted** by a source that was read, **recalled**
from memory, **derived** from first principles and recomputed here, **computed** once by someone and not redone here,
unless said otherwise.

A number is accepted within a range that is no wider than the effect that it tells of; where a publication's own range
is wider, nothing is won by agreeing with it. The verdicts:

{verdicts}

No entry is a validation. Nobody has measured the mechanical power of a bird in formation; published savings are
computed for fixed wings or inferred from heart rates, and the numbers of the unsteady lattice (PteraSoftware 5.1.0,
an ibis trimmed to the model's weight and drag, its wake prescribed) come from an earlier run whose lift is good to 2 to
5 % and whose thrust to 5 to 15 %; [flown anew](lattice.md), with wings of another twist, it says much the same.

`upwash literature` prints this ledger, with `--json` or `--csv`; `--fresh` solves and judges it anew. The table of
entries is `pipeline/upwash/literature/literature.csv`, observations are those of `species/observations.csv`, and a
test fails when a verdict is no longer the one shown here.
"""


def page() -> str:
    """Return the page that shows the kept ledger."""
    verdicts = "\n".join(f"- **{verdict}**: {meaning};" for verdict, meaning in VERDICTS.items())
    return f"{HEAD.format(verdicts=verdicts[:-1] + '.')}\n{literature_markdown(read_kept())}\n"


def main() -> None:
    """Judge, and keep what comes of it."""
    KEPT.write_text(judge_literature().to_csv(index=False, lineterminator="\n"), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
