"""The command ``upwash reproduce``: a fresh run prints the README's table and gives the kept results."""

import json
import re
import shutil
from contextlib import chdir

import pandas as pd
import pyarrow as pa
import pytest
from click.testing import CliRunner
from renew_claims import kept
from renew_reference import BLOCK, README, REFERENCE, as_csv
from upwash.batch.store import TableWriter, metadata_of, read_table
from upwash.cli import main
from upwash.cli import reproduce as module
from upwash.jobs.pair import Pair
from upwash.paper.ledger import tally
from upwash.report.claims import counts
from upwash.report.figures import FIGURES
from upwash.report.shown import BY_COST


@pytest.fixture
def results(paper_redone, tmp_path):
    """A copy of the fresh results: the folder of the pair, those of flocks and airspeeds beside it."""
    return shutil.copytree(paper_redone[0] / "results", tmp_path / "results") / "reproduce"


@pytest.fixture
def undrawn(monkeypatch):
    """Leave the figures that are there already, to save time where they do not matter."""
    monkeypatch.setattr("upwash.report.page.draw_all", lambda sources, settings, folder: {})


@pytest.fixture
def unjudged(monkeypatch):
    """Take the kept verdicts for those on results that are other than the kept ones, to save time as well."""
    monkeypatch.setattr("upwash.paper.judge_claims", lambda evidence: kept())


@pytest.fixture
def reference(tmp_path, monkeypatch):
    """A copy of the kept results, in their place."""
    copy = shutil.copytree(REFERENCE, tmp_path / "reference")
    monkeypatch.setattr(module, "REFERENCE", copy)
    return copy


def again(results, *options):
    """Run the command in this process, in a folder that holds results already."""
    with chdir(results.parents[1]):
        return CliRunner().invoke(main, ["reproduce", *options], prog_name="upwash")


def contents(folder):
    """Return the bytes of every file in a folder, by its name there."""
    return {
        path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()
    }


def multiply(path, schema, column, factor):
    """Multiply a column of a stored table, and write the table as if nothing had happened."""
    table = read_table(path, schema)
    place = table.schema.get_field_index(column)
    values = [value * factor for value in table.column(column).to_pylist()]
    metadata = metadata_of(table.schema)
    writer = TableWriter(path, schema)
    writer.write(table.set_column(place, schema.field(place), pa.array(values)).replace_schema_metadata())
    writer.close(metadata)


class TestFreshRun:
    def test_agrees_with_what_is_kept(self, paper_redone):
        folder, finished = paper_redone
        assert finished.returncode == 0, finished.stderr
        assert f"agrees with {REFERENCE}" in finished.stderr
        names = {path.name for path in (folder / "results" / "reproduce").iterdir()}
        assert {"solutions.parquet", "summary.parquet", "drift.parquet"} <= names
        drift = pd.read_parquet(folder / "results" / "reproduce" / "drift.parquet")
        of_power = drift[(drift["objective"] == "power") & (drift["sigma_m"] == 0.1)].iloc[0]
        assert f"{of_power['saving_still']:.1%} {of_power['saving_held']:.1%}" == "16.6% 1.6%"
        ranges = pd.read_parquet(folder / "results" / "limit" / "ranges.parquet")
        assert list(ranges["span_law"]) == ["stroke", "tip"]
        assert (ranges["saving_total_low"] < ranges["saving_total_high"]).all()

    def test_prints_exactly_what_the_readme_shows(self, paper_redone):
        assert BLOCK.search(README.read_text(encoding="utf-8"))[0] == paper_redone[1].stdout

    def test_flocks_and_airspeeds_are_solved_beside_the_pair_and_the_claims_on_them_judged(
        self, paper_redone
    ):
        folder, finished = paper_redone
        assert sorted(path.name for path in (folder / "results").iterdir()) == [
            "group-speed",
            "limit",
            "paper-flocks",
            "reproduce",
        ]
        for name, jobs in (("reproduce", 2), ("paper-flocks", 4), ("group-speed", 11), ("limit", 4)):
            assert f"results/{name}: {jobs} jobs solved and checked" in finished.stderr
        verdicts = pd.read_parquet(folder / "results" / "reproduce" / "claims.parquet")
        for column in ("verdict", "limit_verdict"):
            assert list(verdicts[column]) == list(kept()[column])
        assert f"claims.parquet: {counts(kept())}\n" in finished.stderr

    def test_it_ends_with_a_page_that_shows_every_figure_of_the_paper(self, paper_redone):
        folder, finished = paper_redone
        assert "results/reproduce/index.html: the page about all of it" in finished.stderr
        page = (folder / "results" / "reproduce" / "index.html").read_text(encoding="utf-8")
        drawn = [name for name in FIGURES if not name.startswith(("species", "refinement"))]
        assert page.count("<img ") == len(drawn) + len(BY_COST)
        for name in drawn:
            for shown in [f"{name}-{cost}" for cost in ("force", "power")] if name in BY_COST else [name]:
                assert f'<h3 id="{shown}">' in page
            for ending in ("pdf", "png", "svg"):
                assert (folder / "results" / "reproduce" / "figures" / f"{name}.{ending}").exists()

    @pytest.mark.thorough
    def test_a_second_run_gives_the_same_bytes_and_solves_nothing(self, results):
        before, claims = contents(results), pd.read_parquet(results / "claims.parquet")
        result = again(results)
        assert result.exit_code == 0
        assert not re.search(r"\d of \d+ jobs", result.stderr)
        after = contents(results)
        assert set(before) == set(after)
        # The ledger's file names the commit of the code that judged, which may have moved on.
        changed = {name for name in after if after[name] != before[name]} - {"claims.parquet"}
        assert changed == set()
        assert pd.read_parquet(results / "claims.parquet").equals(claims)

    def test_the_kept_table_for_people_is_the_kept_table(self):
        kept = read_table(REFERENCE / "summary.parquet", Pair.summary)
        assert (REFERENCE / "summary.csv").read_text(encoding="utf-8") == as_csv(kept)

    def test_json_says_the_same(self, results, undrawn):
        result = again(results, "--json")
        assert result.exit_code == 0
        said = json.loads(result.stdout, parse_constant=pytest.fail)
        assert said["agrees_with_reference"] is True
        assert said["minimum_is_global"] == {"force": False, "power": False}
        assert [one["paper"] for one in said["table_1"]] == [
            1.83,
            0.882,
            0.457,
            0.347,
            0.751,
            0.5,
            12.17,
            1.89,
        ]
        assert max(abs(one["difference %"]) for one in said["table_1"]) < 1.5
        assert said["page"] == "results/reproduce/index.html"
        assert said["claims"]["file"] == "results/reproduce/claims.parquet"
        assert said["claims"]["verdicts"] == tally(kept())


class TestReadme:
    def test_tells_how_many_claims_hold(self):
        assert counts(kept()) in " ".join(README.read_text(encoding="utf-8").split())


class TestChecks:
    def test_results_that_are_not_those_kept_are_shown_and_named(
        self, paper_redone, results, reference, undrawn, unjudged
    ):
        multiply(reference / "summary.parquet", Pair.summary, "cost", 1.0 + 1e-6)
        result = again(results)
        assert result.exit_code == 3
        assert result.stdout == paper_redone[1].stdout
        assert "\ncost, job " in f"\n{result.stderr}"
        assert "upwash diff" in result.stderr.splitlines()[-1]

    def test_the_last_digits_may_differ(self, results, reference, undrawn, unjudged):
        multiply(reference / "summary.parquet", Pair.summary, "cost", 1.0 + 1e-9)
        assert again(results).exit_code == 0

    def test_results_that_do_not_hold_are_not_shown(self, results):
        multiply(results / "solutions.parquet", Pair.rows, "power_total_w", 1.001)
        result = again(results)
        assert (result.exit_code, result.stdout) == (3, "")
        assert "power_total_w: expected" in result.stderr.splitlines()[-1]

    def test_a_job_that_fails_is_exit_1(self, tmp_path, monkeypatch):
        sweep = tmp_path / "sweep.toml"
        sweep.write_text('species = "northern-bald-ibis"\nsolver = "json:loads"\n', encoding="utf-8")
        monkeypatch.setattr(module, "SWEEP", str(sweep))
        result = again(tmp_path / "results" / "reproduce", "--results", "failing")
        assert (result.exit_code, result.stdout) == (1, "")
        assert "1 of 1 jobs failed; see 'upwash status failing'" in result.stderr
