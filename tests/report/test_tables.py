"""Tables say what the rows say: values, units, differences, gaps, proofs, in every form of writing."""

import io
import json

import numpy as np
import pandas as pd
import pytest
from upwash.paper.printed import PRINTED_VARIOUSLY, TABLE_1
from upwash.report.answer import answer, job_record
from upwash.report.flock_answer import birds_table
from upwash.report.reproduction import reproduction, reproduction_record
from upwash.report.table import Table, cell
from upwash.report.tables import basins, best_optima, both_optima, printed_variously, proof, table_1

from report import studies


def column(table, name, of):
    """Return a column of a table as a dictionary, by the column that says what each row is of."""
    return dict(zip(table.frame[of], table.frame[name], strict=True))


class TestCell:
    @pytest.mark.parametrize(
        ("value", "written"),
        [
            (None, "-"),
            (float("nan"), "-"),
            (pd.NA, "-"),
            (np.True_, "yes"),
            (False, "no"),
            (np.int64(12), "12"),
            ("level", "level"),
            (0.5, "0.50000"),
            (12345.0, "12345"),
            (-1e-15, "0.0000"),
        ],
    )
    def test_is_written_for_people(self, value, written):
        assert cell(value) == written

    def test_a_format_is_obeyed_to_the_letter(self):
        assert cell(1e-15, ".0e") == "1e-15"
        assert cell(0.66, "+.1f") == "+0.7"


class TestTable:
    @pytest.fixture
    def table(self):
        frame = pd.DataFrame({"what": ["a|b", "c"], "unit": ["m", "%"], "value": [1.0, None]})
        return Table("A table", frame, {"m": ".1f"}, ("A note.",))

    def test_text_aligns_words_to_the_left_and_numbers_to_the_right(self, table):
        lines = ["A table", "", "what  unit  value", "a|b   m       1.0", "c     %         -", "", "A note."]
        assert table.text().splitlines() == lines

    def test_markdown_keeps_its_columns_whatever_a_cell_holds(self, table):
        lines = ["**A table**", "", "| what | unit | value |", "|---|---|---:|", r"| a\|b | m | 1.0 |"]
        assert table.markdown().splitlines() == [*lines, "| c | % | - |", "", "- A note."]

    def test_csv_holds_every_digit(self):
        frame = pd.DataFrame({"value": [0.1 + 0.2, 1 / 3]})
        assert pd.read_csv(io.StringIO(Table("", frame).csv()))["value"].tolist() == frame["value"].tolist()

    def test_records_are_json_without_nan(self, table):
        records = json.loads(json.dumps(table.records(), allow_nan=False))
        assert records[1] == {"what": "c", "unit": "%", "value": None}

    def test_each_row_of_a_column_may_have_its_own_format(self):
        table = Table("", pd.DataFrame({"value": [1.0, 1.0]}), {"value": [".1f", ".3f"]})
        assert table.cells() == [["1.0"], ["1.000"]]


class TestTable1:
    def test_compares_each_figure_of_the_v_optimum_with_the_papers(self, two_optima):
        table = table_1(two_optima)
        ours, difference = (column(table, name, "follower") for name in ("Upwash", "difference %"))
        assert len(ours) == len(TABLE_1)
        assert ours["x_F, downstream of the leader"] == 1.8
        assert difference["x_F, downstream of the leader"] == pytest.approx(100 * (1.8 / 1.83 - 1))
        assert difference["I_z/T, self-generated lift"] == pytest.approx(100 * (12 / 12.17 - 1))

    def test_counts_height_as_the_paper_does_from_half_the_leaders_amplitude(self, two_optima):
        heights = [
            value
            for what, value in column(table_1(two_optima), "Upwash", "follower").items()
            if "z_F" in what
        ]
        assert heights == [pytest.approx(0.5 - 0.04)]

    def test_shows_the_papers_digits_and_one_more_of_ours(self, two_optima):
        row = next(line for line in table_1(two_optima).cells() if line[0].startswith("κ_F"))
        assert row[2:] == ["0.500", "0.5000", "+0.00"]

    def test_other_objectives_are_passed_over(self, two_optima):
        other = two_optima.assign(objective="power", x_m=9.0)
        assert table_1(pd.concat([other, two_optima])).text() == table_1(two_optima).text()

    def test_what_is_printed_variously_is_shown_as_printed(self, two_optima):
        table = printed_variously(two_optima)
        paper, ours = (list(table.frame[name]) for name in ("paper", "Upwash"))
        assert paper[0] == "0.882 (Table 1); 0.877 and 0.886 (text)"
        assert paper[1:] == ["9 and 8 (text)", "18 and 17 (text)", "11 (text)"]
        assert ours == pytest.approx([0.75, 10.0, 12.5, 10.0])
        assert list(PRINTED_VARIOUSLY) == ["y", "induced", "profile", "total"]


class TestBirds:
    def test_a_place_that_is_not_proved_the_best_is_said_to_be_open_and_what_that_means(self):
        flock = studies.frame(studies.flock_rows(3), "flock")
        flock = flock[flock["job_id"] == flock["job_id"].iloc[0]]
        for gap, words in ((5e-5, "proved"), (0.002, "open, gap 2.0e-3")):
            table = birds_table(flock.assign(v_certified_gap=[None, 5e-5, gap]))
            assert table.frame["proof"].tolist() == ["-", "proved", words]
            assert any(note.startswith("open: another place in the V") for note in table.notes) == (
                gap > 1e-3
            )


class TestBothOptima:
    def test_stand_side_by_side_with_the_gap_between_them(self, two_optima):
        table = both_optima(two_optima)
        assert list(table.frame.columns) == ["quantity", "unit", "V optimum", "global optimum"]
        v, best = (column(table, name, "quantity") for name in ("V optimum", "global optimum"))
        assert (v["placement"], best["placement"]) == ("outboard", "inboard")
        assert v["cost above the best's"] == pytest.approx(0.5)
        assert best["cost above the best's"] == 0.0
        assert v["imbalance of lift or thrust"] == "below 1.0e-9"

    def test_lengths_are_given_in_metres_and_in_the_birds_own(self, two_optima):
        frame = both_optima(two_optima).frame
        following = dict(
            zip(frame["quantity"], zip(frame["V optimum"][1:], frame["unit"][1:], strict=False), strict=False)
        )
        assert following["x, downstream of the leader"] == (pytest.approx(1.8 / 2.5), "wavelengths")
        assert following["y, to its right"] == (pytest.approx(1.5), "semispans")
        assert following["z, above it"] == (pytest.approx(-0.04), "amplitudes h_L")
        assert following["h, tip-to-tip amplitude"] == (pytest.approx(0.75), "amplitudes h_L")

    def test_one_column_where_they_are_one(self, one_optimum):
        assert list(both_optima(one_optimum).frame.columns)[2:] == ["V and global optimum"]

    def test_no_v_optimum_is_no_column(self, inboard_alone):
        assert list(both_optima(inboard_alone).frame.columns)[2:] == ["global optimum"]
        assert list(best_optima(inboard_alone)) == ["global optimum"]

    def test_several_objectives_stand_in_the_order_of_the_registry(self, two_optima):
        both = pd.concat([two_optima.assign(objective="power"), two_optima])
        heads = list(both_optima(both, in_short=True).frame.columns)[2:]
        assert heads == [
            "force: V optimum",
            "force: global optimum",
            "power: V optimum",
            "power: global optimum",
        ]
        assert len(both_optima(both, in_short=True).frame) < len(both_optima(both).frame)

    def test_an_imbalance_is_not_hidden(self, two_optima):
        table = both_optima(two_optima.assign(residual_thrust=-3e-7))
        assert column(table, "V optimum", "quantity")["imbalance of lift or thrust"] == "by 3.0e-7"


class TestProof:
    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"v_certified_gap": 1e-4 * (1 + 1e-9)}, "proved to 1.0e-4"),
            ({"v_certified_gap": 3e-5}, "proved to 3.0e-5"),
            ({"v_certified_gap": 2e-3}, "open, gap 2.0e-3"),
            ({"v_certified_gap": 2e-3, "v_wall": "y_lower"}, "open, gap 2.0e-3"),
            ({"v_certified_gap": None}, "not examined"),
            ({"v_certified_gap": 2e-3, "is_global_optimum": True}, "proved to 1.0e-4"),
        ],
    )
    def test_is_told_in_a_few_words(self, two_optima, changes, words):
        row = two_optima.iloc[1].to_dict() | changes
        assert proof(row) == words

    def test_each_word_that_is_used_is_explained(self, two_optima):
        beaten = both_optima(two_optima.assign(v_certified_gap=2e-3, v_wall="y_lower"))
        explained = [note.split(" ", 1)[0] for note in beaten.notes[2:]]
        assert explained == ["proved", "open:", "a"]
        assert "as close to its leader's side as still counts as outboard" in beaten.notes[-1]
        assert [note.split()[0] for note in both_optima(two_optima).notes[2:]] == ["proved"]


class TestBasins:
    def test_lists_every_optimum_with_its_evidence(self, two_optima):
        table = basins(two_optima)
        assert list(table.frame["rank"]) == [0, 1]
        assert list(table.frame[""]) == ["", "V"]
        assert list(table.frame["above %"]) == pytest.approx([0.0, 0.5])
        assert list(table.frame["cost N"]) == [12.0, 12.06]

    def test_core_edges_are_letters_with_a_legend(self, two_optima):
        edges = "both/up/starting/downstroke/down/2, left/down/right tip/upstroke/up, +0.333/+0.25/left tip/upstroke/7"
        edges += ", both/-0.497 down/turn/upstroke/+0.5"
        table = basins(two_optima.assign(core_edges=["", edges]))
        assert list(table.frame["edges"]) == ["-", "d a b c"]
        assert table.notes[-4:] == (
            "a: left wingtip down on right tip of upstroke ring (leader up)",
            "b: span node +0.333 at +0.25 h on left tip of upstroke ring (leader 7)",
            "c: wing at -0.497 h on its downstroke on the vortex where the leader's upstroke ends, "
            "+0.5 wavelengths downstream",
            "d: wingtips up on starting of downstroke ring (bird of row 2 down)",
        )

    def test_many_edges_do_not_run_out_of_letters(self, two_optima):
        many = [f"left/down/right tip/upstroke/{number:02}" for number in range(30)]
        rows = two_optima.assign(core_edges=[", ".join(many), many[29]])
        assert basins(rows).frame["edges"][1] == "ad"


class TestAnswer:
    def test_holds_both_optima_and_if_asked_all(self, two_optima):
        assert answer(two_optima) == both_optima(two_optima).text()
        assert answer(two_optima, show_all=True).endswith(basins(two_optima).text())

    @pytest.mark.parametrize(
        ("changes", "words"),
        [
            ({"v_lower_bound": None}, "which is proved"),
            (
                {"v_lower_bound": 12.3, "v_wall": "x_lower"},
                "a follower in the V does best as close behind its leader as still counts as astern",
            ),
            ({"v_lower_bound": 12.3}, "which is no proof"),
        ],
    )
    def test_says_plainly_that_there_is_no_v_optimum(self, inboard_alone, changes, words):
        said = answer(inboard_alone.assign(**changes)).splitlines()[-1]
        assert said.startswith("There is no V optimum")
        assert words in said

    @pytest.mark.parametrize(
        ("bound", "words"),
        [(None, "balances lift and thrust (this is proved)"), (12.0, "open: none was found")],
    )
    def test_says_plainly_that_no_follower_can_fly(self, two_optima, bound, words):
        error = "no balance: no position within the bounds balances lift and thrust"
        row = two_optima.iloc[:1].assign(status="infeasible", error=error, global_lower_bound=bound)
        row = row.assign(feasible=False, global_certified_gap=None)
        said = answer(row)
        assert said.startswith("northern-bald-ibis, least force: no optimum: no position within the bounds")
        assert words in said

    def test_a_record_holds_the_job_once_and_its_optima(self, two_optima):
        record = job_record(two_optima.astype(object).where(two_optima.notna(), None).to_dict("records"))
        assert json.loads(json.dumps(record, allow_nan=False)) == record
        assert [one["cost"] for one in record["optima"]] == [12.0, 12.06]
        assert record["v_lower_bound"] == 12.3
        assert "cost" not in record
        assert "v_lower_bound" not in record["optima"][0]


class TestReproduction:
    def test_says_that_the_papers_minimum_is_not_global_and_by_how_much(self, two_optima):
        said = reproduction(two_optima)
        assert "It is not" in said
        assert said.endswith("least force: 0.50 % less (inboard, level, astern; y = 0.250 m, not 0.750 m)")

    def test_would_say_that_it_is_global_if_it_were(self, one_optimum):
        said = reproduction(one_optimum)
        assert "It is not" not in said
        assert said.endswith("least force: the V optimum is the best (proved to 1.0e-4)")

    def test_record_says_the_same(self, two_optima, one_optimum):
        record = reproduction_record(two_optima)
        assert json.loads(json.dumps(record, allow_nan=False)) == record
        assert record["minimum_is_global"] == {"force": False}
        assert reproduction_record(one_optimum)["minimum_is_global"] == {"force": True}
        assert record["table_1"] == table_1(two_optima).records()
