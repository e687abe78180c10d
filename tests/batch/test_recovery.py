"""Each recovery from the broken state itself: what a killed process, a power cut or a careless hand leaves behind."""

import json
import os
import shutil
import time

import pyarrow.parquet as pq
import pytest
from conftest import kill, wait_until
from upwash.batch import gather
from upwash.batch.folder import ResultsFolder, Shard
from upwash.batch.journal import Stretch, journal_line, read_journals
from upwash.batch.row_checks import RESIDUAL_LIMIT, residuals


class TestJournal:
    def test_that_was_cut_in_mid_line_is_gone_on_with_on_a_line_of_its_own(self, bench):
        bench.sweep("two_optima", 3)
        bench.run()
        path = bench.results / "journal-1-of-1.csv"
        before = read_journals(ResultsFolder(bench.results))
        assert (len(before.begun), sum(entry.jobs for entry in before.done)) == (1, 3)
        path.write_bytes(path.read_bytes().rstrip(b"\n")[:-9])
        torn = path.read_bytes().splitlines()[-1]
        bench.sweep("two_optima", 5)
        bench.run()
        after = read_journals(ResultsFolder(bench.results))
        assert len(after.begun) == 2
        # The last batch of three jobs is told no more; two jobs are new.
        assert sum(entry.jobs for entry in after.done) == sum(entry.jobs for entry in before.done[:-1]) + 2
        assert torn in path.read_bytes().splitlines()

    @pytest.mark.parametrize(
        "rest", ["", "done,", "done,12,x,3\n", "run,yesterday,3\n", "\x00\x00\n", "run,1,2,3\n"]
    )
    def test_lines_that_say_nothing_are_passed_over(self, tmp_path, rest):
        line = journal_line(Stretch(5.0, 2, 0.25))
        (tmp_path / "journal-1-of-2.csv").write_text("run,4.000,9\n" + rest + "\n" + line)
        found = read_journals(ResultsFolder(tmp_path))
        assert (found.begun, found.done) == ([4.0], [Stretch(5.0, 2, 0.25)])

    def test_that_is_gone_costs_nothing_but_the_rate(self, bench):
        bench.sweep("two_optima", 3)
        bench.run()
        (bench.results / "journal-1-of-1.csv").unlink()
        assert bench.status()["solved"] == 3
        assert "0 done now, 3 before" in bench.run()[1]


def test_failed_jobs_are_done_again_and_infeasible_ones_are_not(bench):
    bench.sweep("mixed", 6)
    bench.run(code=1)
    status = bench.status(code=1)
    assert (status["solved"], status["infeasible"], status["failed"]) == (2, 2, 2)
    before = bench.solved()
    assert "0 done now, 6 before, 2 failed" in bench.run(code=1)[1]
    assert bench.solved() == before
    bench.fix()
    assert "2 done now, 4 before" in bench.run("--retry-failed")[1]
    again = bench.solved() - before
    assert set(again.values()) == {1} and len(again) == 2
    status = bench.status()
    assert (status["solved"], status["infeasible"], status["failed"]) == (4, 2, 0)


def test_a_failure_that_lies_beside_a_result_does_not_count(bench):
    bench.sweep("failing_when_heavy", 4)
    bench.run(code=1)
    failures = {path: path.read_bytes() for path in bench.job_files()}
    bench.fix()
    bench.run("--retry-failed")
    bench("aggregate", "results/sweep")
    for path, data in failures.items():
        path.write_bytes(data)
    assert bench.status()["solved"] == 4
    assert "0 done now, 4 before" in bench.run("--retry-failed")[1]
    path = next(path for path in failures if b"ZeroDivisionError" in failures[path])
    assert json.loads(bench("show", "results/sweep", path.stem, "--json")[0])[0]["status"] == "solved"
    bench("aggregate", "results/sweep")
    assert bench.summary().column("status").to_pylist() == ["solved"] * 4


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("name", ["residual_lift", "residual_thrust"])
def test_an_imbalance_of_either_sign_does_not_pass(name, sign):
    balanced = {"residual_lift": 0.0, "residual_thrust": 0.0}
    assert [*residuals([balanced | {name: sign * 0.99 * RESIDUAL_LIMIT}])] == []
    found = [*residuals([balanced | {name: sign * 1.01 * RESIDUAL_LIMIT}])]
    assert [column for column, _ in found] == [name]


class TestLock:
    @pytest.mark.parametrize("shard", ["1/1", "1/2"])
    def test_of_a_killed_process_holds_nobody_up(self, bench, shard):
        bench.sweep("waiting_when_heavy", 12)
        process = bench.start("run", "./sweep.toml", "--shard", shard)
        wait_until(lambda: bench.job_files())
        with_lock = [path for path in bench.results.iterdir() if path.name.startswith(".lock")]
        assert len(with_lock) == (1 if shard == "1/1" else 2)
        assert bench.status()["is_running"]
        kill(process)
        assert all(path.exists() for path in with_lock)
        assert not bench.status()["is_running"]
        bench.fix()
        bench.run("--shard", shard)
        bench("aggregate", "results/sweep")

    def test_of_one_shard_keeps_the_same_shard_out_and_no_other(self, bench):
        bench.sweep("two_optima", 12)
        bench.run("--shard", "1/2")
        folder = ResultsFolder(bench.results)
        with folder.locked(Shard(1, 2)):
            assert "expected nobody else" in bench.run("--shard", "1/2", code=2)[1]
            bench.run("--shard", "2/2")
            assert "expected nobody else" in bench("aggregate", "results/sweep", code=2)[1]
        bench.run("--shard", "1/2")


class TestJobFile:
    @pytest.fixture
    def done(self, bench):
        bench.sweep("two_optima", 3)
        bench.run()
        return bench

    @pytest.mark.parametrize(
        "tear",
        [
            lambda data: b"",
            lambda data: data[:1],
            lambda data: data[:-1],
            lambda data: data[:4000] + bytes(len(data) - 4000),
        ],
        ids=["empty", "a byte", "all but a byte", "zeros at the end"],
    )
    def test_that_a_power_cut_tore_is_noticed_by_all_and_done_again(self, done, tear):
        path = done.job_files()[0]
        path.write_bytes(tear(path.read_bytes()))
        assert done.status()["left"] == 1
        assert done.run("--dry-run")[1].endswith("by the 3 done so far)\n")
        assert "1 of 3 jobs would run" in done.run("--dry-run")[1]
        assert path.name in done("check", "results/sweep", code=3)[1]
        _, said = done.run()
        assert f"jobs/{path.name}: damaged; set aside" in said and "1 done now, 2 before" in said
        assert done.status()["left"] == 0

    def test_that_holds_another_jobs_rows_is_set_aside(self, done):
        first, second, _ = done.job_files()
        shutil.copy(first, second)
        before = done.solved()
        assert f"jobs/{second.name}: damaged; set aside" in done.run()[1]
        assert done.solved() - before == {second.stem: 1}

    def test_that_is_damaged_twice_is_kept_twice(self, done):
        path = done.job_files()[0]
        for _ in range(2):
            path.write_bytes(b"torn")
            done.run()
        assert sorted(os.listdir(done.results / "corrupt")) == [path.name, f"{path.name}.1"]

    def test_beside_its_row_in_a_table_counts_once(self, done):
        kept = {path: path.read_bytes() for path in done.job_files()}
        done("aggregate", "results/sweep")
        whole = done.summary()
        for path, data in kept.items():
            path.write_bytes(data)
        status = done.status()
        assert (status["jobs"], status["solved"], status["others"]) == (3, 3, 0)
        assert "0 done now, 3 before" in done.run()[1]
        done("aggregate", "results/sweep")
        assert done.summary().equals(whole)
        assert pq.read_table(done.results / "solutions.parquet").num_rows == 6


def test_half_written_files_are_removed_and_are_no_results(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    folder = ResultsFolder(bench.results)
    folder.parts.mkdir()
    places = (folder.path, folder.jobs, folder.parts)
    left = [place / f".{name}.0123abcd.tmp" for place in places for name in ("a.parquet", "plan.json")]
    for path in left:
        path.write_bytes(b"half")
    assert bench.status()["solved"] == 3
    bench.run()
    assert not any(path.exists() for path in left)


def test_a_damaged_plan_is_told_and_its_remedy_works(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    plan = bench.results / "plan.json"
    for content in ("", "{", "[]", '{"sweep": "x"}', '{"sweep": "x", "kind": "pair", "text": "", "jobs": 3}'):
        plan.write_text(content)
        _, said = bench("status", "results/sweep", code=2)
        assert "expected the plan of a sweep, found a damaged file; delete it and run the sweep again" in said
        assert len(said.splitlines()) == 1
    plan.unlink()
    assert "0 done now, 3 before" in bench.run()[1]
    assert bench.status()["solved"] == 3


@pytest.mark.parametrize("name", ["summary.parquet", "solutions.parquet"])
def test_a_table_that_was_deleted_comes_back(bench, name):
    bench.sweep("two_optima", 3)
    bench.run()
    bench("aggregate", "results/sweep")
    whole = bench.summary()
    (bench.results / name).unlink()
    before = bench.solved()
    bench.run()
    # What a job's rows come to follows from them, and they follow from the job.
    assert len(bench.solved() - before) == (3 if name == "solutions.parquet" else 0)
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(whole)


@pytest.mark.parametrize(
    ("jobs", "job_files", "part_sizes"), [(3, 3, []), (4, 0, [4]), (7, 3, [4]), (12, 0, [12])]
)
def test_files_are_gathered_as_soon_as_there_are_so_many(bench, monkeypatch, jobs, job_files, part_sizes):
    monkeypatch.setattr(gather, "MOST_JOB_FILES", 4)
    monkeypatch.setattr(gather, "MOST_PARTS", 3)
    bench.sweep("two_optima", jobs)
    bench.run("--workers", "1")
    found = [gather.jobs_in(path) for path in ResultsFolder(bench.results).part_files()]
    assert (len(bench.job_files()), found) == (job_files, part_sizes)


class TestOptions:
    """Each option of a command changes something, on both of its sides."""

    @pytest.mark.parametrize("workers", [1, 2, 3])
    def test_so_many_workers_are_at_work(self, bench, workers):
        bench.sweep("lasting", 12)
        before = bench.log.read_text().split() if bench.log.exists() else []
        begun = sum(word.startswith("begun:") for word in before)
        bench.marker.write_text(f"{begun} {workers}")
        bench.run("--workers", str(workers))
        at_work = most = 0
        for word in bench.log.read_text().split()[len(before) :]:
            at_work += 1 if word.startswith("begun:") else -1
            most = max(most, at_work)
        assert most == workers

    def test_results_go_where_they_are_asked_to(self, bench):
        bench.sweep("two_optima", 2)
        bench.run("--results", "elsewhere")
        assert os.listdir(bench.folder / "elsewhere" / "jobs") and not bench.results.exists()
        bench.run()
        assert bench.job_files()

    def test_fail_fast_is_not_the_rule(self, bench):
        bench.sweep("failing_when_heavy", 8)
        bench.run(code=1)
        assert bench.status(code=1)["left"] == 0

    def test_parts_of_a_sweep_are_apart_and_make_it_whole(self, bench):
        bench.sweep("two_optima", 20)
        seen = []
        for number in (1, 2, 3):
            lines = bench.run("--dry-run", "--shard", f"{number}/3")[0].splitlines()
            seen += [line.split()[0] for line in lines]
            assert 0 < len(lines) < 20
        whole = [line.split()[0] for line in bench.run("--dry-run")[0].splitlines()]
        assert sorted(seen) == sorted(whole) and len(set(seen)) == 20

    @pytest.mark.parametrize(
        ("command", "keys"),
        [
            (("run", "./sweep.toml"), {"results", "jobs", "kept", "done", "failed", "left"}),
            (("status", "results/sweep"), {"solved", "left", "causes", "jobs_per_s"}),
            (("aggregate", "results/sweep"), {"jobs", "missing", "retired"}),
            (("merge", "merged", "results/sweep"), {"results", "jobs", "found", "by_folder", "left"}),
        ],
    )
    def test_json_is_for_machines_and_words_are_for_people(self, bench, command, keys):
        bench.sweep("two_optima", 2)
        bench.run()
        out, _ = bench(*command, "--json")
        assert keys <= json.loads(out).keys()
        shutil.rmtree(bench.folder / "merged", ignore_errors=True)
        out, said = bench(*command)
        assert not out.startswith("{") and "2" in out + said

    def test_the_rate_is_told_while_a_run_is_at_work(self, bench):
        bench.sweep("slow", 4)
        bench.run()
        with ResultsFolder(bench.results).locked():
            status = bench.status()
            assert status["is_running"] and status["jobs_per_s"] > 0 and status["seconds_left"] == 0
            bench.sweep("slow", 8)
        journal = bench.results / "journal-1-of-1.csv"
        now = time.time()
        journal.write_text(f"run,{now - 100:.3f},9\n" + journal_line(Stretch(now - 50, 5, 1.0)) * 4)
        with ResultsFolder(bench.results).locked():
            # Twenty jobs in a hundred seconds.
            assert bench.status()["jobs_per_s"] == pytest.approx(0.2, rel=0.2)
        old, late = journal_line(Stretch(now - 1900, 100, 1.0)), journal_line(Stretch(now - 300, 6, 1.0))
        journal.write_text(f"run,{now - 9000:.3f},9\n" + old + f"run,{now - 2000:.3f},9\n" + old + late)
        with ResultsFolder(bench.results).locked():
            # What was done of late counts, and earlier runs do not.
            assert bench.status()["jobs_per_s"] == pytest.approx(6 / 600, rel=0.1)
        status = bench.status()
        assert (status["is_running"], status["jobs_per_s"], status["seconds_left"]) == (False, None, None)
