"""A Parquet file is there whole or not at all, says what it holds, and is not believed once a bit changes."""

import errno
import hashlib
import json
import os
import random
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from upwash import columns as of
from upwash.batch import store
from upwash.batch.bundle import encode
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.pair import Pair
from upwash.jobs.run import run_job
from upwash.sweep import Job, read_sweep

IDS = Path(__file__).parents[1] / "job_ids.json"

# Schema version -> digest of the names, types and units of all columns.
FORMS = {1: "a06206cb2947ec88", 2: "de3bf20536199c9e", 3: "18ff8695d50be27a"}

SCHEMAS = {
    "solutions": Pair.rows,
    "flock": Flock.rows,
    "summary": Pair.summary,
    "flock summary": Flock.summary,
}


@pytest.fixture(scope="module")
def job():
    return read_sweep("reproduce").jobs[0]


def job_inputs(job, **changed):
    return {name: value for name, value in job.inputs().items() if value is not None} | changed


def data_of(job, sweep_text="the sweep's text", seconds=0.1):
    """Return the file of a job whose solver is one of the tests' own."""
    easy = Job.of(job_inputs(job, solver="stub_solvers:two_optima"))
    return encode([replace(run_job(easy), seconds=seconds)], sweep_text).data


@pytest.fixture
def job_file(job, tmp_path):
    path = tmp_path / "job.parquet"
    store.write_atomic(path, data_of(job))
    return path


class TestSchema:
    def test_a_changed_column_has_a_new_schema_version(self):
        # If this fails, raise SCHEMA_VERSION and add a line: by it, results on people's disks tell whether
        # they can still be read.
        form = [(c.name, c.type, c.unit) for c in (*of.SOLUTIONS_COLUMNS, *of.FLOCK_COLUMNS)]
        digest = hashlib.sha256(json.dumps(form).encode()).hexdigest()[:16]
        assert FORMS[of.SCHEMA_VERSION] == digest

    @pytest.mark.parametrize("name", SCHEMAS)
    def test_every_column_states_its_unit_and_meaning(self, name):
        for field in SCHEMAS[name]:
            unit, description = field.metadata[b"unit"].decode(), field.metadata[b"description"].decode()
            assert description, field.name
            assert bool(unit) == (field.type in (pa.float64(), pa.int64())), field.name

    @pytest.mark.parametrize(
        ("ending", "unit"),
        [("_kg", "kg"), ("_m", "m"), ("_m_s", "m/s"), ("_m_s2", "m/s2"), ("_kg_m3", "kg/m3")]
        + [
            ("_n", "N"),
            ("_w", "W"),
            ("_s", "s"),
            ("_per_m", "1/m"),
            ("_per_m2", "1/m2"),
            ("_deg", "deg"),
            ("_per_deg", "1/deg"),
        ],
    )
    def test_a_name_ends_in_the_unit_of_its_column(self, ending, unit):
        longest = {c.name: max((e for e in ENDINGS if c.name.endswith(e)), key=len, default="") for c in ALL}
        named = [c for c in ALL if longest[c.name] == ending]
        assert named and all(c.unit == unit for c in named)

    def test_the_inputs_of_a_job_are_columns_of_its_rows(self):
        inputs = set(Job.of(json.loads(IDS.read_text())[0]).inputs())
        pair_only = set(of.names(of.belonging(of.AHEAD)))
        assert inputs - pair_only <= set(Flock.rows.names)
        flock_only = {"birds", "shape", "wake", "reading", "members"}
        assert inputs - flock_only <= set(Pair.rows.names)

    def test_units_and_provenance_survive_the_round_trip(self, job_file):
        table = store.read_table(job_file, Pair.rows)
        assert table.schema.field("power_total_w").metadata[b"unit"] == b"W"
        metadata = store.metadata_of(table.schema)
        assert metadata["sweep"] == "the sweep's text"
        assert metadata["schema_version"] == str(of.SCHEMA_VERSION)
        assert metadata["code_version"].startswith("0.")
        assert json.loads(metadata["package_versions"])["pyarrow"] == pa.__version__

    def test_a_file_of_an_older_schema_version_is_read_as_one_of_this(self, job_file):
        table = pq.read_table(job_file)
        later = [name for name in Pair.rows.names if of.column(name).since > of.OLDEST_READ]
        older = table.drop_columns(later).replace_schema_metadata(
            {**table.schema.metadata, b"schema_version": str(of.OLDEST_READ).encode()}
        )
        assert len(later) > 10
        pq.write_table(older, job_file)
        read = store.read_table(job_file, Pair.rows)
        assert read.schema.equals(Pair.rows)
        assert all(set(read.column(name).to_pylist()) == {of.column(name).before} for name in later)
        assert read.drop_columns(later).equals(older)
        # What this version writes has them all.
        pq.write_table(older.replace_schema_metadata(table.schema.metadata), job_file)
        with pytest.raises(store.Damaged, match="not those of schema version"):
            store.read_table(job_file, Pair.rows)
        # And nothing older has fewer of the others.
        pq.write_table(older.drop_columns(["cost"]), job_file)
        with pytest.raises(store.Damaged):
            store.read_table(job_file, Pair.rows)

    def test_a_file_of_another_schema_version_is_told_apart_from_a_damaged_one(self, job_file, monkeypatch):
        monkeypatch.setattr(of, "SCHEMA_VERSION", of.SCHEMA_VERSION + 1)
        other = pa.schema([*Pair.rows, pa.field("another", pa.string())])
        with pytest.raises(UpwashError, match="expected schema version"):
            store.read_table(job_file, other)


ALL = (*of.SUMMARY_COLUMNS, *of.FLOCK_COLUMNS)
ENDINGS = ("_kg", "_m", "_m_s", "_m_s2", "_kg_m3", "_n", "_w", "_s", "_per_m", "_per_m2", "_deg", "_per_deg")


class TestDamage:
    def test_a_file_cut_anywhere_is_damaged(self, job_file):
        data = job_file.read_bytes()
        for length in range(0, len(data), 97):
            with pytest.raises(store.Damaged):
                store.read_table(job_file, Pair.rows, data[:length])

    def test_no_flipped_bit_goes_unnoticed_and_changes_what_is_read(self, job_file):
        data, whole = job_file.read_bytes(), store.read_table(job_file, Pair.rows)
        chance = random.Random(1)
        noticed = 0
        for _ in range(1500):
            place = chance.randrange(len(data))
            flipped = bytearray(data)
            flipped[place] ^= 1 << chance.randrange(8)
            try:
                read = store.read_table(job_file, Pair.rows, bytes(flipped))
            except (store.Damaged, UpwashError):
                noticed += 1
            else:
                # Whoever reads on has read the truth.
                assert read.equals(whole), place
        assert noticed > 1000

    def test_something_else_is_damaged(self, job_file):
        pq.write_table(
            pa.table({"a": [1]}).replace_schema_metadata({"schema_version": str(of.SCHEMA_VERSION)}), job_file
        )
        with pytest.raises(store.Damaged, match="columns"):
            store.read_table(job_file, Pair.rows)


class TestWriting:
    def test_the_old_file_stays_until_the_new_one_is_whole(self, tmp_path, monkeypatch):
        path = tmp_path / "file"
        store.write_atomic(path, b"old")
        monkeypatch.setattr(os, "fsync", failing_with(errno.EIO))
        with pytest.raises(UpwashError, match="Input/output error"):
            store.write_atomic(path, b"new")
        assert path.read_bytes() == b"old"
        assert os.listdir(tmp_path) == ["file"]

    def test_a_disk_that_is_full_costs_one_clear_line_and_leaves_nothing_behind(self, tmp_path):
        # A limit on the size of files stands in for the disk: writing beyond it fails half way.
        script = (
            "import resource, signal\nfrom pathlib import Path\n"
            "from upwash.batch.store import write_atomic\n"
            "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
            "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))\n"
            "write_atomic(Path('small'), b'x' * 1000)\n"
            "write_atomic(Path('large'), b'x' * 1001)\n"
        )
        told = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
        assert "UpwashError: large: expected to write it, found: File too large" in told.stderr
        assert os.listdir(tmp_path) == ["small"]

    def test_equal_rows_make_equal_bytes(self, job):
        assert data_of(job, seconds=0.1) == data_of(job, seconds=0.2)


def failing_with(number):
    def fail(*_):
        raise OSError(number, os.strerror(number))

    return fail


class TestRowsOfAnyKind:
    @pytest.fixture(autouse=True)
    def _unfixed(self, logs):
        (logs / "fixed").unlink(missing_ok=True)

    @pytest.mark.parametrize(
        ("solver", "error"),
        [
            (
                "failing_when_heavy",
                "ZeroDivisionError: a bird too heavy, over two lines (stub_solvers.py, line",
            ),
            ("exiting", "SystemExit: 3"),
            (
                "unknown_column",
                "BrokenContract: ValueError: rows: expected columns of the schema, found wingspan_in_feet",
            ),
            ("wrong_type", "BrokenContract: ArrowInvalid"),
            ("not_there", "BrokenContract: expected a function not_there in stub_solvers, found none"),
        ],
    )
    def test_whatever_goes_wrong_is_a_row_with_inputs_seed_and_error(self, job, solver, error):
        bad = Job.of(job_inputs(job, solver=f"stub_solvers:{solver}", seed=7))
        bundle = encode([run_job(bad)], "")
        (result,) = bundle.results
        (found,) = store.read_table(None, Pair.rows, bundle.data).to_pylist()
        assert result.status == found["status"] == "failed"
        assert found["error"].startswith(error) and "\n" not in found["error"]
        assert (found["job_id"], found["mass_kg"], found["seed"]) == (bad.job_id, job.bird.mass_kg, 7)
        assert found["x_m"] is None and found["rank"] is None

    def test_no_answer_is_a_row_that_says_so(self, job):
        lost = Job.of(job_inputs(job, solver="stub_solvers:infeasible"))
        (found,) = run_job(lost).rows
        assert (found["status"], found["error"]) == ("infeasible", "nowhere to fly")

    def test_an_amplitude_beyond_the_wingspan_is_infeasible(self, job):
        wild = Job.of(job_inputs(job, leader_amplitude_m=3.0))
        (found,) = run_job(wild).rows
        assert found["status"] == "infeasible"
        assert found["error"].startswith("amplitude_m: expected at most twice the semispan")

    def test_numbers_that_are_not_finite_are_absent(self, job):
        endless = Job.of(job_inputs(job, solver="stub_solvers:endless"))
        (found,) = run_job(endless).rows
        assert (found["v_lower_bound"], found["stationarity"]) == (None, None)
