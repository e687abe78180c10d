"""The ledger of the literature: judged anew it is what is kept, it holds every observation, no verdict is cheap."""

import json
import math
from dataclasses import replace
from io import StringIO

import pandas as pd
import pytest
from click.testing import CliRunner
from renew_literature import PAGE, page
from upwash.cli import main
from upwash.literature import ledger as room
from upwash.literature.ledger import (
    CANNOT_FACE,
    CONDITION,
    CONTRADICTS,
    FAILS,
    HOLDS,
    KEPT,
    LEDGER_COLUMNS,
    MODELS,
    NUMBER,
    OUTSIDE,
    SAME_SIGN,
    SAYS_LITTLE,
    SIGN,
    VERDICTS,
    judge_literature,
    observation_names,
    read_entries,
    read_kept,
)
from upwash.report.literature import CONTRADICTED
from upwash.study.observations import read_observations

pytestmark = pytest.mark.thorough

ENTRIES = {entry.row_id: entry for entry in read_entries()}


@pytest.fixture(scope="module")
def fresh():
    """The ledger judged anew."""
    return judge_literature()


class TestKept:
    def test_no_verdict_has_changed_unannounced(self, fresh):
        kept = read_kept()
        assert fresh["row_id"].tolist() == kept["row_id"].tolist()
        for model in MODELS:
            changed = fresh[f"{model}_verdict"] != kept[f"{model}_verdict"]
            assert fresh.loc[changed, "row_id"].tolist() == [], "make reference, and say what changed"

    def test_what_is_said_is_what_the_table_says(self):
        for row in read_kept().itertuples():
            entry = ENTRIES[row.row_id]
            for name in ("topic", "says", "published", "unit", "source", "sure", "why"):
                assert getattr(row, name) == getattr(entry, name), row.row_id

    def test_the_page_shows_it(self):
        assert PAGE.read_text(encoding="utf-8") == page()

    def test_contradictions_stand_first(self):
        kept = read_kept()
        contradicted = [CONTRADICTS in (row.paper_verdict, row.limit_verdict) for row in kept.itertuples()]
        count = sum(contradicted)
        assert count >= 2 and all(contradicted[:count])
        assert {"terns-fly-faster", "pigeon-pays"} <= set(kept["row_id"][:count])
        # On the page they are the first topic after what the verdicts mean.
        assert page().index(f"## {CONTRADICTED}") == page().index("## ")


class TestEntries:
    def test_there_are_forty_and_each_says_who_and_how_sure_and_why(self):
        assert len(ENTRIES) >= 40
        assert len(ENTRIES) == len(read_entries())
        for entry in ENTRIES.values():
            assert entry.source and entry.says and entry.why.endswith("."), entry.row_id
            assert entry.sure in {"read", "quoted", "recalled", "derived", "computed"}, entry.row_id

    def test_every_observation_is_in_it_once(self):
        observations = read_observations()
        names = observation_names(observations)
        others = {name for name, own in zip(names, observations["this_model"], strict=True) if not own}
        said = [entry.observation for entry in ENTRIES.values() if entry.observation]
        assert sorted(said) == sorted(others)

    def test_what_is_accepted_is_what_was_published_or_lies_around_it(self):
        observations = read_observations()
        named = dict(zip(observation_names(observations), observations.to_dict("records"), strict=True))
        for entry in ENTRIES.values():
            row = named.get(entry.observation)
            if entry.kind == NUMBER and row is not None and not math.isnan(row["value"]):
                assert (entry.low + entry.high) / 2.0 == pytest.approx(row["value"], abs=1e-9), entry.row_id

    def test_none_holds_by_an_interval_wider_than_the_effect(self):
        for row in read_kept().itertuples():
            entry = ENTRIES[row.row_id]
            for verdict in (row.paper_verdict, row.limit_verdict):
                if verdict in (HOLDS, CONDITION) and entry.kind == NUMBER:
                    assert entry.high - entry.low <= entry.effect, row.row_id

    def test_what_no_model_can_face_is_a_row_that_says_so(self):
        for name in ("nash", "ground-effect", "lattice-one-way", "pigeon-frequency", "in-line-stability"):
            assert ENTRIES[name].kind == OUTSIDE


class TestVerdicts:
    ENTRY = replace(ENTRIES["ibis-overlap"], low=1.0, high=2.0, effect=1.5)

    @pytest.mark.parametrize(
        ("cases", "verdict"),
        [
            ({}, CANNOT_FACE),
            ({"a": 1.5}, HOLDS),
            ({"a": 1.5, "b": 2.5}, CONDITION),
            ({"a": 0.5, "b": 2.5}, FAILS),
            ({"a": math.nan}, FAILS),
        ],
    )
    def test_of_a_number(self, cases, verdict):
        assert self.ENTRY.verdict(cases) == verdict

    def test_a_number_that_is_known_worse_than_it_is_large_says_little(self):
        wide = replace(self.ENTRY, effect=0.9)
        assert wide.verdict({"a": 1.5}) == wide.verdict({"a": 1.5, "b": 9.0}) == SAYS_LITTLE
        assert wide.verdict({"a": 9.0}) == FAILS

    @pytest.mark.parametrize(
        ("cases", "verdict"),
        [({"a": 1.0, "b": 9.0}, SAME_SIGN), ({"a": -1.0}, CONTRADICTS), ({"a": -1.0, "b": 1.0}, CONDITION)],
    )
    def test_of_a_sign(self, cases, verdict):
        entry = replace(self.ENTRY, kind=SIGN, low=0.0, high=math.inf)
        assert entry.verdict(cases) == verdict


def run(*arguments):
    return CliRunner().invoke(main, ["literature", *arguments], prog_name="upwash")


class TestCommand:
    def test_prints_all_of_it(self):
        result = run()
        assert result.exit_code == 0, result.output
        assert result.stdout.startswith(CONTRADICTED)
        assert all(name in result.stdout for name in ENTRIES)
        assert f"{len(ENTRIES)} entries. " in result.stdout

    def test_json_and_csv_are_the_same_rows(self):
        rows = json.loads(run("--json").stdout, parse_constant=pytest.fail)
        assert list(rows[0]) == [column.name for column in LEDGER_COLUMNS]
        table = pd.read_csv(StringIO(run("--csv").stdout), keep_default_na=False)
        assert table["row_id"].tolist() == [row["row_id"] for row in rows]
        assert {row[f"{model}_verdict"] for row in rows for model in MODELS} <= set(VERDICTS)

    def test_both_at_once_are_a_mistake(self):
        result = run("--json", "--csv")
        assert (result.exit_code, result.stdout) == (2, "")

    def test_fresh_judges_anew(self, monkeypatch):
        kept = read_kept().head(3)
        monkeypatch.setattr(room, "judge_literature", lambda: kept)
        assert len(json.loads(run("--fresh", "--json").stdout)) == 3

    def test_without_the_kept_ledger_it_says_so_in_a_line(self, monkeypatch, tmp_path):
        assert KEPT.is_file()
        monkeypatch.setattr(room, "KEPT", tmp_path / "gone.csv")
        result = run()
        assert (result.exit_code, result.stdout) == (2, "")
        assert "gone.csv" in result.stderr and len(result.stderr.splitlines()) == 1
