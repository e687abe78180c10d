"""A flock as the batch layer stores it: by its columns, checked by recomputation, compared bird by bird."""

import pyarrow as pa
import pytest
from click.testing import CliRunner
from upwash import columns as of
from upwash.batch.check import of_rows
from upwash.batch.compare import compare
from upwash.batch.store import encode, provenance
from upwash.cli import main
from upwash.jobs.flock import Flock
from upwash.jobs.job import job_of as stored_job
from upwash.jobs.run import solve
from upwash.jobs.schema import table_of
from upwash.sweep.single import single_job

CHOICES = [
    {"shape": "echelon", "wake": "neighbour", "reading": "immediate"},
    {"shape": "vee", "wake": "neighbour", "reading": "lone"},
    {"shape": "vee", "wake": "all-upstream", "reading": "immediate"},
    {"shape": "alternating", "wake": "all-upstream", "reading": "immediate"},
]


def job_of(birds=5, wavelengths=1, **choice):
    return single_job(
        Flock,
        "northern-bald-ibis",
        (),
        "stroke-angle",
        objective="force",
        seed=0,
        tolerance=1e-4,
        birds=birds,
        wavelengths=wavelengths,
        **choice,
    )


def rows_of(**choice):
    return table_of(solve(job_of(**choice)), Flock.rows).to_pylist()


@pytest.mark.parametrize("choice", CHOICES, ids=lambda choice: "-".join(choice.values()))
def test_a_flock_passes_every_check(choice):
    assert of_rows(rows_of(**choice), "flock") == []


def test_a_flock_with_longer_wakes_does_too():
    assert of_rows(rows_of(birds=3, wavelengths=2, **CHOICES[2]), "flock") == []


def test_a_bird_that_is_moved_is_noticed():
    rows = rows_of(**CHOICES[0])
    rows[3]["y_m"] += 1e-3
    assert {one.column for one in of_rows(rows, "flock")} >= {"lift_wake_n", "y_flock_m"}


def test_the_first_bird_is_a_lone_bird():
    first = rows_of(**CHOICES[0])[0]
    assert (first["bird"], first["leader"], first["status"]) == (1, None, of.SOLVED)
    assert (first["x_flock_m"], first["y_flock_m"], first["z_flock_m"], first["phase_flock"]) == (0, 0, 0, 0)
    assert first["saving_total"] == first["lift_wake_n"] == first["thrust_wake_n"] == 0.0
    assert first["cost"] == first["cost_leader"]
    assert first["x_m"] is first["is_v_optimum"] is first["rank"] is None


def test_a_row_states_the_stroke_of_the_bird_that_is_followed():
    rows = rows_of(**CHOICES[2])
    for row in rows[1:]:
        ahead = rows[row["leader"] - 1]
        assert row["ahead_amplitude_m"] == ahead["amplitude_m"]
        assert row["ahead_upstroke_span_ratio"] == ahead["upstroke_span_ratio"]
    assert rows[0]["ahead_amplitude_m"] is rows[0]["ahead_upstroke_span_ratio"] is None


def test_every_row_gives_back_its_job():
    job = job_of(**CHOICES[2])
    assert {stored_job(row) for row in rows_of(**CHOICES[2])} == {job}


def test_a_stroke_ahead_that_is_not_the_leaders_is_noticed():
    for name in ("ahead_amplitude_m", "ahead_upstroke_span_ratio", "leader_amplitude_m"):
        rows = rows_of(**CHOICES[0])
        rows[3][name] *= 1.0 + 1e-9
        assert {one.column for one in of_rows(rows, "flock")} & {name, "job_id"}


def test_the_row_that_ends_a_flock_says_so_and_the_others_are_kept():
    rows = rows_of(birds=6, **CHOICES[3])
    assert [row["status"] for row in rows] == [of.SOLVED] * 3 + [of.INFEASIBLE]
    assert of.cause_of(rows[-1]["error"]) == "no V optimum"
    assert rows[-1]["x_m"] is rows[-1]["v_lower_bound"] is None
    assert rows[-1]["v_certified_gap"] is None


def test_two_runs_agree_though_rounding_reaches_the_next_link():
    rows = rows_of(**CHOICES[0])
    nearly = [dict(row) for row in rows]
    for row in nearly[2:]:
        row["ahead_amplitude_m"] *= 1.0 + 1e-9
    tables = [pa.Table.from_pylist(one, schema=Flock.rows) for one in (rows, nearly)]
    assert compare(*tables).agrees
    nearly[2]["ahead_amplitude_m"] *= 1.001
    assert not compare(tables[0], pa.Table.from_pylist(nearly, schema=Flock.rows)).agrees


class TestAStoredFlock:
    @pytest.fixture(scope="class")
    @classmethod
    def folder(cls, tmp_path_factory):
        """A results folder that holds a flock which ends early."""
        path = tmp_path_factory.mktemp("results")
        data = encode(solve(job_of(**CHOICES[3])), Flock.rows, provenance(""))
        (path / "flock.parquet").write_bytes(data)
        return str(path)

    @staticmethod
    def upwash(*arguments):
        result = CliRunner().invoke(main, arguments, prog_name="upwash")
        assert result.exit_code == 0, result.output
        return result.output

    def test_is_shown_bird_by_bird_and_says_why_it_ends(self, folder):
        text = self.upwash("show", folder, job_of(**CHOICES[3]).job_id)
        assert "wavelengths                 1" in text
        assert text.splitlines()[-1].startswith("bird 4: no V optimum: expected one outboard")
        birds = [line.split()[:2] for line in text.splitlines()[-5:-1]]
        assert birds == [["1", "-"], ["2", "1"], ["3", "2"], ["4", "3"]]

    def test_is_the_same_when_it_is_solved_again(self, folder):
        assert "agree in 4 rows" in self.upwash("rerun", folder, job_of(**CHOICES[3]).job_id)
