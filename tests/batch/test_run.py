"""Running a sweep: resume, retries, shards, forecasts, what is told while it runs."""

import json
import os
import pty
import shutil
import subprocess
import time
from collections import Counter
from contextlib import contextmanager
from types import SimpleNamespace

import pyarrow.parquet as pq
import pytest
from conftest import wait_until
from upwash import kernel
from upwash.batch import estimate, merging, runner
from upwash.batch.store import write_atomic
from upwash.errors import EnvironmentFault
from upwash.jobs import run as run_module
from upwash.jobs.pair import Pair
from upwash.jobs.run import compiling
from upwash.sweep import read_sweep


def test_a_second_run_does_nothing_and_a_larger_sweep_only_what_is_new(bench):
    bench.sweep("two_optima", 3)
    assert "3 done now, 0 before" in bench.run()[1]
    assert "0 done now, 3 before" in bench.run()[1]
    # 1.1, 1.25, 1.4 kg; then 1.175 and 1.325 kg between them.
    bench.sweep("two_optima", 5)
    assert "2 done now, 3 before" in bench.run()[1]
    assert set(bench.solved().values()) == {1}


def test_name_order_comments_and_place_of_a_sweep_rerun_nothing(bench, tmp_path):
    bench.sweep("two_optima", 3)
    bench.run()
    text = '# the same birds\nspecies = "northern-bald-ibis"\nsolver = "stub_solvers:two_optima"\n'
    (tmp_path / "other.toml").write_text(text + "[zip]\nmass_kg = [1.4, 1.25, 1.1]\n")
    assert "0 done now, 3 before" in bench("run", "./other.toml", "--results", "results/sweep")[1]


def test_failures_are_rows_and_are_done_again_only_on_request(bench):
    bench.sweep("failing_when_heavy", 4)
    _, said = bench.run(code=1)
    assert said.count("failed: ZeroDivisionError: a bird too heavy, over two lines") == 2
    status = bench.status(code=1)
    assert (status["solved"], status["failed"], status["causes"]) == (2, 2, {"ZeroDivisionError": 2})
    assert "0 done now, 4 before, 2 failed" in bench.run(code=1)[1]
    bench("aggregate", "results/sweep")
    assert bench.status(code=1)["causes"] == {"ZeroDivisionError": 2}
    assert "0 done now, 4 before, 2 failed" in bench.run(code=1)[1]
    bench.fix()
    assert "2 done now, 2 before" in bench.run("--retry-failed")[1]
    assert bench.status()["solved"] == 4
    bench("aggregate", "results/sweep")
    assert bench.summary().column("status").to_pylist() == ["solved"] * 4


def test_fail_fast_stops_at_the_first_failure(bench):
    bench.sweep("failing_when_heavy", 40)
    _, said = bench.run("--fail-fast", "--workers", "1", code=1)
    assert said.count(" failed: ") == 1
    status = bench.status(code=1)
    assert status["failed"] == 1 and status["left"] > 10


def test_no_answer_is_no_failure(bench):
    bench.sweep("infeasible", 2)
    bench.run()
    status = bench.status()
    assert (status["infeasible"], status["causes"]) == (2, {"infeasible: nowhere to fly": 2})
    bench("aggregate", "results/sweep")
    assert set(bench.summary().column("error").to_pylist()) == {"nowhere to fly"}


@pytest.mark.thorough
def test_shards_share_the_jobs_and_merge(bench, undisturbed):
    bench.sweep("slow", 40)
    both = [bench.start("run", "./sweep.toml", "--shard", f"{number}/3") for number in (1, 2)]
    for process in both:
        _, said = process.communicate(timeout=120)
        assert process.returncode == 0, said
    status = bench.status()
    assert 0 < status["left"] < 30
    bench.run("--shard", "3/3")
    assert set(bench.solved().values()) == {1}
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)


def test_the_number_of_workers_does_not_change_the_results(bench, undisturbed):
    bench.sweep("slow", 40)
    bench.run("--workers", "1")
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)


def test_a_dry_run_foresees_each_job_and_writes_nothing(bench):
    bench.sweep("failing_when_heavy", 4)
    out, said = bench.run("--dry-run")
    assert [line.split()[1] for line in out.splitlines()] == ["run"] * 4
    assert all(line.endswith("(new)") for line in out.splitlines())
    assert "4 of 4 jobs would run" in said
    assert os.listdir(bench.folder) == ["sweep.toml"]
    bench.run(code=1)
    before = {path: path.stat().st_mtime_ns for path in bench.results.rglob("*")}
    plan = json.loads(bench.run("--dry-run", "--json")[0])
    reasons = [(job["runs"], job["reason"]) for job in plan["jobs"]]
    failed = "failed before: ZeroDivisionError; --retry-failed does it again"
    assert reasons == [(False, "done: solved")] * 2 + [(False, failed)] * 2
    again = json.loads(bench.run("--dry-run", "--retry-failed", "--json")[0])
    assert again["to_run"] == 2 and again["from_experience"]
    assert again["judged_by"] == "by the 4 done so far"
    assert before == {path: path.stat().st_mtime_ns for path in bench.results.rglob("*")}


class TestEstimate:
    def test_is_measured_by_what_the_folder_holds(self, bench):
        bench.sweep("slow", 4)
        assert json.loads(bench.run("--dry-run", "--json")[0])["seconds"] is None
        assert (
            "how long that takes is not known: no job of it was done here before" in bench.run("--dry-run")[1]
        )
        bench.run()
        bench.sweep("slow", 100)
        told = json.loads(bench.run("--dry-run", "--json", "--workers", "3")[0])
        # A job sleeps for 0.02 s; of 100 four are done.
        assert told["to_run"] == 96 and told["seconds"] > 96 * 0.02 / 3
        fewer = json.loads(bench.run("--dry-run", "--json", "--workers", "1")[0])
        assert fewer["seconds"] == pytest.approx(3 * told["seconds"])
        bench("aggregate", "results/sweep")
        gathered = json.loads(bench.run("--dry-run", "--json", "--workers", "3")[0])
        assert gathered["judged_by"] == "by the 4 done so far" and gathered["seconds"] > 0

    def test_is_measured_on_the_spot_where_nothing_is_there(self, bench, reproduced, monkeypatch):
        solved = []
        # A job takes a tenth of a second, however busy the machine is.
        clock = SimpleNamespace(perf_counter=lambda: 0.1 * len(solved))
        monkeypatch.setattr(estimate, "time", clock)
        monkeypatch.setattr(run_module, "run_job", solved.append)
        monkeypatch.setattr(estimate, "TRIAL_S", 0.25)
        (bench.folder / "ibis.toml").write_text(IBISES)
        told = json.loads(bench("run", "./ibis.toml", "--dry-run", "--json")[0])
        assert len(solved) == 3 and len({job.job_id for job in solved}) == 3
        assert told["seconds"] == pytest.approx(40 * 0.1 / 2)
        assert told["judged_by"] == "by 3 solved just now on this machine" and not told["from_experience"]
        assert os.listdir(bench.folder) == ["ibis.toml"]

    def test_is_not_made_before_the_search_is_compiled(self, bench, monkeypatch):
        monkeypatch.setattr(run_module, "compiling", lambda job: "compiling: a while")
        (bench.folder / "ibis.toml").write_text(IBISES)
        _, said = bench("run", "./ibis.toml", "--dry-run")
        assert "40 of 40 jobs would run; how long that takes is not known: the search is not compiled" in said


IBISES = """\
species = "northern-bald-ibis"
[grid]
mass_kg = { linspace = [1.1, 1.4, 40] }
"""


def test_a_run_that_goes_on_says_at_once_what_is_left_and_counts_all_jobs(bench):
    bench.sweep("two_optima", 3)
    assert "left to do" not in bench.run()[1]
    bench.sweep("two_optima", 9)
    first, *_, last, summary = bench.run()[1].splitlines()
    assert first == "results/sweep: 3 of 9 jobs are done, 6 left to do"
    assert last.startswith("9 of 9 jobs, ")
    assert summary == "results/sweep: 9 jobs, 6 done now, 3 before"


class TestListingJobs:
    def test_says_of_each_how_it_ended_and_what_it_is(self, bench):
        bench.sweep("failing_when_heavy", 4)
        bench.run(code=1)
        bench.sweep("failing_when_heavy", 7)
        bench.run("--dry-run")
        bench.run("--shard", "1/2", code=1)
        listed = json.loads(bench("status", "results/sweep", "--jobs", "--json", code=1)[0])
        status = bench.status(code=1)
        statuses = Counter(job["status"] for job in listed)
        assert statuses == {name: status[name] for name in ("solved", "failed", "left")}
        assert status["left"]
        lines = bench("status", "results/sweep", "--jobs", code=1)[0].splitlines()
        assert [line.split()[:2] for line in lines] == [[job["job_id"], job["status"]] for job in listed]
        assert lines[0].endswith("solved      northern-bald-ibis force mass_kg=1.1")
        assert lines[-1].endswith("failed      northern-bald-ibis force mass_kg=1.4  (ZeroDivisionError)")

    def test_is_the_same_once_gathered_and_where_the_hint_says(self, bench):
        bench.sweep("two_optima", 3)
        bench.run()
        before = bench("status", "results/sweep", "--jobs")[0]
        bench("aggregate", "results/sweep")
        assert bench("status", "results/sweep", "--jobs")[0] == before
        assert (
            "'upwash status results/sweep --jobs' lists them"
            in bench("show", "results/sweep", "zz", code=2)[1]
        )


def test_a_dry_run_says_what_has_changed(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    text = (bench.folder / "sweep.toml").read_text()
    (bench.folder / "sweep.toml").write_text(text + "[fixed]\nspeed_m_s = 14.5\n")
    changes = [job["reason"] for job in json.loads(bench.run("--dry-run", "--json")[0])["jobs"]]
    assert changes == ["changed: speed_m_s 15.0 -> 14.5"] * 3
    bench("aggregate", "results/sweep")
    assert [job["reason"] for job in json.loads(bench.run("--dry-run", "--json")[0])["jobs"]] == changes


def test_results_of_jobs_no_longer_named_are_kept_apart_and_come_back(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    bench("aggregate", "results/sweep")
    whole = bench.summary()
    bench.sweep("two_optima", 2)
    assert "0 done now, 2 before" in bench.run()[1]
    bench("aggregate", "results/sweep")
    assert bench.summary().num_rows == 2
    assert bench.status()["others"] == 1
    bench.sweep("two_optima", 3)
    assert "0 done now, 3 before" in bench.run()[1]
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(whole)
    assert set(bench.solved().values()) == {1}


@pytest.mark.parametrize("when", ["before gathering", "after gathering"])
def test_damaged_files_are_named_set_aside_and_redone(bench, when):
    bench.sweep("two_optima", 6)
    bench.run()
    cut, flipped, *others = bench.job_files()
    if when == "after gathering":
        bench("aggregate", "results/sweep")
        bench.sweep("two_optima", 11)
        bench.run()
        cut, flipped, *others = bench.job_files()
    cut.write_bytes(cut.read_bytes()[:1000])
    flip_a_bit(flipped)
    before = bench.solved()
    _, said = bench.run()
    for path in (cut, flipped):
        assert f"{path.relative_to(bench.folder)}: damaged; set aside as" in said
    again = bench.solved() - before
    assert again == {cut.stem: 1, flipped.stem: 1}
    assert sorted(path.name for path in (bench.results / "corrupt").iterdir()) == [cut.name, flipped.name]
    bench("aggregate", "results/sweep")
    assert bench.status()["left"] == 0


def test_a_dry_run_sees_damage_wherever_it_is_in_a_file(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    flipped = bench.job_files()[1]
    flip_a_bit(flipped)
    foreseen = json.loads(bench.run("--dry-run", "--json")[0])["jobs"]
    assert [job["job_id"] for job in foreseen if job["runs"]] == [flipped.stem]


def test_a_bit_flipped_in_a_gathered_table_costs_its_part_alone(bench, monkeypatch):
    bench.sweep("two_optima", 6)
    bench.run()
    # Pieces of two jobs, so that a small table has several.
    monkeypatch.setattr(merging, "JOBS_PER_PIECE", 2)
    bench("aggregate", "results/sweep")
    whole = bench.summary()
    path = bench.results / "solutions.parquet"
    with pq.ParquetFile(path) as file:
        assert file.num_row_groups == 3
        spoilt = set(file.read_row_group(1, columns=["job_id"]).column(0).to_pylist())
    flip_a_bit(path, row_group=1)
    before = bench.solved()
    _, said = bench.run()
    assert (
        "solutions.parquet: 1 of 3 parts damaged; a copy is results/sweep/corrupt/solutions.parquet" in said
    )
    assert bench.solved() - before == dict.fromkeys(spoilt, 1)
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(whole)


def test_a_gathered_table_cut_short_is_set_aside_and_redone(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    bench("aggregate", "results/sweep")
    whole = bench.summary()
    path = bench.results / "solutions.parquet"
    path.write_bytes(path.read_bytes()[:-100])
    assert bench.status()["left"] == 3
    _, said = bench.run()
    assert "solutions.parquet: damaged; set aside" in said and "3 done now" in said
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(whole)


def flip_a_bit(path, row_group=0):
    """Flip a bit of what is stored of a column; what is told beside the columns bears no checksum."""
    with pq.ParquetFile(path) as file:
        column = file.metadata.row_group(row_group).column(file.schema_arrow.get_field_index("cost"))
    begin = column.dictionary_page_offset or column.data_page_offset
    data = bytearray(path.read_bytes())
    data[begin + column.total_compressed_size - 4] ^= 16
    path.write_bytes(data)


@pytest.fixture
def small_disk(tmp_path):
    """A disk of half a megabyte."""
    mounted = tmp_path / "disk"
    mounted.mkdir()
    mount = shutil.which("mount")
    if os.geteuid() or not mount:
        pytest.skip("only root can mount a small disk")
    command = [mount, "-t", "tmpfs", "-o", "size=512k", "tmpfs", str(mounted)]
    if subprocess.run(command, capture_output=True).returncode:
        pytest.skip("this system does not allow a small disk")
    yield mounted
    subprocess.run(["umount", str(mounted)], check=True)


def test_a_disk_that_fills_stops_the_run_and_loses_nothing(bench, small_disk):
    bench.sweep("two_optima", 40)
    where = ("--results", str(small_disk / "results"))
    _, said = bench.run(*where, code=2)
    last = said.splitlines()[-1]
    assert (
        last.startswith("Error: ")
        and "No space left on device" in last
        and "run the same command again" in last
    )
    jobs = small_disk / "results" / "jobs"
    kept = {path.stem for path in jobs.glob("*.parquet")}
    assert 5 < len(kept) < 40
    assert len(list(jobs.iterdir())) == len(kept), "a torn file was left behind"
    subprocess.run(["mount", "-o", "remount,size=20m", str(small_disk)], check=True)
    before = bench.solved()
    bench.run(*where)
    assert not kept & (bench.solved() - before).keys()
    assert len(list(jobs.glob("*.parquet"))) == 40


def test_a_folder_that_may_not_be_written_is_one_clear_line(bench, small_disk):
    where = ("--results", str(small_disk / "results"))
    bench.sweep("two_optima", 2)
    bench.run(*where)
    subprocess.run(["mount", "-o", "remount,ro", str(small_disk)], check=True)
    bench.sweep("two_optima", 3)
    for folder in ("results", "another"):
        _, said = bench.run("--results", str(small_disk / folder), code=2)
        assert said.startswith(f"Error: {small_disk / folder}: expected to ")
        assert "Read-only file system" in said and len(said.splitlines()) == 1
    for command in (["aggregate"], ["run", "./sweep.toml", "--dry-run", "--results"]):
        bench(*command, str(small_disk / "results"), code=2 if command == ["aggregate"] else 0)
    subprocess.run(["mount", "-o", "remount,rw", str(small_disk)], check=True)
    assert "1 done now, 2 before" in bench.run(*where)[1]


def test_a_folder_that_turns_read_only_stops_the_run_and_loses_nothing(bench):
    bench.sweep("waiting_when_heavy", 6)
    process = bench.start("run", "./sweep.toml")
    wait_until(lambda: len(bench.job_files()) == 3)
    jobs = bench.results / "jobs"
    with protected(jobs):
        bench.fix()
        _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    last = said.splitlines()[-1]
    assert last.startswith("Error: ") and "expected to write it, found: " in last
    assert {path.name for path in jobs.iterdir()} == {path.name for path in bench.job_files()}
    assert len(bench.job_files()) == 3
    assert "3 done now, 3 before" in bench.run()[1]


@contextmanager
def protected(folder):
    """Make a folder read-only, even to root."""
    if os.geteuid():
        folder.chmod(0o500)
    elif subprocess.run(["chattr", "+i", str(folder)], capture_output=True).returncode:
        pytest.skip("this file system cannot protect a folder from root")
    try:
        yield
    finally:
        if os.geteuid():
            folder.chmod(0o700)
        else:
            subprocess.run(["chattr", "-i", str(folder)], check=True)


@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_fault_of_the_machine_is_no_result_of_a_job(bench, workers):
    bench.sweep("on_a_full_disk_when_heavy", 6)
    _, said = bench.run("--workers", workers, code=2)
    told = (
        "/scratch/of/the/solver: expected to use it, found: No space left on device; make room on that disk"
    )
    assert said.splitlines()[-1] == f"Error: {told}"
    assert bench.status()["failed"] == 0
    bench.marker.touch()
    assert "failed" not in bench.run()[1]
    assert bench.status()["solved"] == 6


def test_what_one_job_lacks_is_its_failure(bench):
    bench.sweep("without_its_file", 2)
    bench.run(code=1)
    assert bench.status(code=1)["causes"] == {"FileNotFoundError": 2}


@pytest.mark.parametrize(
    "fault", [PermissionError(13, "Permission denied", "/lib"), ImportError("libblas is gone")]
)
def test_what_the_system_refuses_the_built_in_solver_is_a_fault_of_the_machine(monkeypatch, fault):
    def refused(kind, job, bird):
        raise fault

    monkeypatch.setattr(Pair, "solve", refused)
    with pytest.raises(EnvironmentFault, match=r"expected .*, found: "):
        run_module.run_job(read_sweep("reproduce").jobs[0])


def test_progress_is_plain_lines_unless_on_a_terminal(bench):
    bench.sweep("trivial", 60)
    _, said = bench.run()
    lines = [line for line in said.splitlines() if " of 60 jobs" in line]
    assert lines[-1].startswith("60 of 60 jobs, ")
    assert len(lines) <= 25 and "\r" not in said
    shutil.rmtree(bench.results)
    terminal, end = pty.openpty()
    process = bench.start("run", "./sweep.toml", stderr=end)
    os.close(end)
    shown = b""
    while chunk := read_terminal(terminal):
        shown += chunk
    process.stdout.close()
    os.close(terminal)
    assert process.wait() == 0
    assert b"\r[" in shown and b"[##############################] 60 of 60 jobs" in shown


def read_terminal(terminal):
    try:
        return os.read(terminal, 65536)
    except OSError:
        return b""


def test_a_workers_arrays_and_loops_have_one_thread(bench):
    bench.sweep("threads", 2)
    bench.run()
    assert bench.solved() == {f"{name}_NUM_THREADS=1": 2 for name in ("OMP", "OPENBLAS", "NUMBA")}


def test_results_do_not_pile_up_before_a_slow_disk(bench, monkeypatch):
    monkeypatch.setattr(runner, "MAX_BATCH", 2)
    monkeypatch.setattr(runner, "MAX_FLYING", 6)
    ahead = []

    def slowly(path, *rest, **options):
        time.sleep(0.02)
        ahead.append(sum(bench.solved().values()) - len(bench.job_files()))
        write_atomic(path, *rest, **options)

    monkeypatch.setattr(runner, "write_atomic", slowly)
    bench.sweep("two_optima", 40)
    bench.run()
    assert set(bench.solved().values()) == {1} and len(ahead) == 40
    assert max(ahead) < 6 + 2


class TestCompiling:
    def test_is_known_to_be_done_once_a_job_has_been_solved(self, reproduced, tmp_path, monkeypatch):
        job = read_sweep("reproduce").jobs[0]
        assert not compiling(job)
        monkeypatch.setattr(kernel, "cache_folders", lambda: (tmp_path,))
        assert compiling(job)

    def test_is_done_by_one_worker_while_the_others_wait(self, bench, monkeypatch):
        bench.sweep("told_at_both_ends", 6)
        # Workers that are still starting would begin one after another anyhow.
        bench.run("--results", "warm")
        monkeypatch.setattr(runner, "compiling", lambda job: "compiling: a while")
        # So would a solver that is not ours, whose first job is a trial: it is taken for ours.
        monkeypatch.setattr(runner, "BUILT_IN_SOLVER", "stub_solvers:told_at_both_ends")
        before = len(bench.log.read_text().split())
        _, said = bench.run()
        assert said.splitlines()[0] == "compiling: a while"
        begun, ended, *others = bench.log.read_text().split()[before:]
        assert ended == begun.replace("begun", "ended") and len(others) == 10

    def test_concerns_the_built_in_solver_alone(self, bench, tmp_path, monkeypatch):
        monkeypatch.setattr(kernel, "cache_folders", lambda: (tmp_path,))
        bench.sweep("trivial", 2)
        assert "compiling" not in bench.run()[1]


def test_hostile_names_stay_inside_the_folder(bench, tmp_path):
    hostile = tmp_path / "two\nlines ../x \x1b[2J"
    hostile.mkdir(parents=True)
    bench.sweep("two_optima", 2)
    bench.run("--results", str(hostile / "deep" / "er"))
    assert sorted(path.name for path in (hostile / "deep" / "er").iterdir()) == [
        ".lock",
        "jobs",
        "journal-1-of-1.csv",
        "plan.json",
    ]
    _, said = bench.run("--results", "x" * 300, code=2)
    assert len(said.splitlines()) == 1 and "File name too long" in said
