"""Renew what is kept of a run of ``upwash reproduce``: results/reference/, the README's table, pictures in docs/.

``make reference`` does it, after a change that is meant to change results. What moved shows in the diff of
summary.csv, which says the same as summary.parquet.
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

import pandas as pd
import pyarrow as pa
from upwash import columns as of
from upwash.batch.store import read_table
from upwash.jobs.pair import Pair

ROOT = Path(__file__).parents[1]
REFERENCE = ROOT / "results" / "reference"
README = ROOT / "README.md"
PICTURES = [
    ROOT / "docs" / f"{name}.png"
    for name in ("optimal-position", "fixed-wings", "limit-place", "limit-phase")
]
BLOCK = re.compile(r"(?<=<!-- reproduce: begin -->\n```text\n).*(?=```\n<!-- reproduce: end -->)", re.DOTALL)

COMMAND = [sys.executable, "-c", "from upwash.cli import main; main(prog_name='upwash')", "reproduce"]

# The same, compared with itself: what is kept so far may be of an older schema, which could not be read.
UNCOMPARED = """\
import sys
from upwash.cli import main, reproduce
reproduce.REFERENCE = sys.argv[-1]
main(prog_name="upwash")
"""


def as_csv(summary: pa.Table) -> str:
    """Write what is compared of a summary as CSV: one line a column, one column a job."""
    jobs = summary.to_pylist()
    lines = [
        {"column": name, "unit": of.column(name).unit, **{job["objective"]: job[name] for job in jobs}}
        for name in summary.column_names
        if name == "job_id" or of.column(name).agreement.compared
    ]
    return pd.DataFrame(lines).to_csv(index=False, lineterminator="\n")


def main() -> None:
    """Run `upwash reproduce` in a folder of its own and keep what it leaves and prints."""
    with tempfile.TemporaryDirectory() as folder:
        results = Path(folder) / "reproduce"
        command = [sys.executable, "-c", UNCOMPARED, "reproduce", "--results", results]
        finished = subprocess.run(command, stdout=subprocess.PIPE, text=True)
        if finished.returncode:
            sys.exit(finished.returncode)
        summary = results / "summary.parquet"
        REFERENCE.mkdir(parents=True, exist_ok=True)
        (REFERENCE / "summary.parquet").write_bytes(summary.read_bytes())
        (REFERENCE / "summary.csv").write_text(as_csv(read_table(summary, Pair.summary)), encoding="utf-8")
        for picture in PICTURES:
            picture.write_bytes((results / "figures" / picture.name).read_bytes())
    text = README.read_text(encoding="utf-8")
    README.write_text(BLOCK.sub(lambda _: finished.stdout, text), encoding="utf-8")


if __name__ == "__main__":
    main()
