"""Finished jobs are gathered while a run goes on: files stay few, and nothing is lost or there twice."""

import errno
import json
import os
import shutil
import subprocess
import sys

import pyarrow.parquet as pq
import pytest
from upwash.batch import gather
from upwash.batch.folder import ResultsFolder, Shard, jobs_in, shard_of
from upwash.batch.merging import JobFiles
from upwash.batch.store import Damaged

# A server that imports everything once and forks for each line: the command, which is killed at the n-th step of its
# first gathering that changes the disk.
KILLED_AT = """\
import json, os, signal, sys
from upwash.batch import aggregate, gather, runner
gather.MOST_JOB_FILES, gather.MOST_PARTS = 5, 3
def counted(step):
    def then(*arguments, **options):
        global left
        left -= 1
        if left == 0:
            os.kill(os.getpid(), signal.SIGKILL)
        return step(*arguments, **options)
    return then
def watched(gathering):
    def then(*arguments):
        steps = {name: getattr(os, name) for name in ("open", "fsync", "replace", "unlink")}
        for name, step in steps.items():
            setattr(os, name, counted(step))
        try:
            return gathering(*arguments)
        finally:
            for name, step in steps.items():
                setattr(os, name, step)
    return then
gather.Gathering._gather = watched(gather.Gathering._gather)
aggregate._write_tables = watched(aggregate._write_tables)
from upwash.cli import main
answers = os.fdopen(os.dup(1), "w", buffering=1)
for line in sys.stdin:
    left, folder, arguments = json.loads(line)
    child = os.fork()
    if not child:
        os.dup2(os.open(os.devnull, os.O_RDWR), 0)
        os.dup2(0, 1)
        os.dup2(0, 2)
        os.chdir(folder)
        try:
            main(arguments)
        except SystemExit as end:
            os._exit(end.code or 0)
        finally:
            os._exit(99)
    print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), file=answers)
"""


@pytest.fixture
def few(monkeypatch):
    """Gather after a few jobs already."""
    monkeypatch.setattr(gather, "MOST_JOB_FILES", 5)
    monkeypatch.setattr(gather, "MOST_PARTS", 3)


def parts(bench):
    return ResultsFolder(bench.results).part_files()


@pytest.fixture
def killed(bench):
    """Return a function that runs the command to the n-th step of gathering, or its end; it tells if it was killed."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-W", "ignore", "-c", KILLED_AT], **pipes) as server:

        def run(step, *arguments):
            server.stdin.write(json.dumps([step, str(bench.folder), arguments]) + "\n")
            server.stdin.flush()
            code = int(server.stdout.readline())
            assert code in (0, -9)
            return code == -9

        yield run


def test_files_are_few_and_the_tables_the_same(bench, few, undisturbed):
    bench.sweep("slow", 40)
    bench.run()
    assert len(bench.job_files()) < 5 and len(parts(bench)) < 9
    assert sum(map(jobs_in, parts(bench))) + len(bench.job_files()) == 40
    assert bench.status()["solved"] == 40
    assert "0 done now, 40 before" in bench.run()[1]
    # The stub's figures mean nothing, and each is looked at.
    assert json.loads(bench("check", "results/sweep", "--json", code=3)[0])["jobs"] == 40
    (job_id, *_) = bench.solved()
    assert job_id in bench("show", "results/sweep", job_id)[0]
    _, said = bench("diff", "results/sweep", "results/sweep", code=2)
    assert "expected summary.parquet" in said
    bench("aggregate", "results/sweep")
    assert not bench.job_files() and not (bench.results / "parts").exists()
    assert bench.summary().equals(undisturbed)
    bench.sweep("slow", 41)
    bench.run()
    _, said = bench("diff", "results/sweep", "results/sweep", code=2)
    assert "found 39 not gathered yet" in said
    assert bench.status()["others"] == 38


def test_cheap_jobs_share_a_file_from_the_start(bench, monkeypatch):
    monkeypatch.setattr(gather, "MOST_PARTS", 4)
    bench.sweep("two_optima", 3000)
    bench.run()
    assert len(bench.job_files()) < 1000 and 0 < len(parts(bench)) <= 8
    assert set(bench.solved().values()) == {1} and len(bench.solved()) == 3000
    size = sum(path.stat().st_size for path in parts(bench)) / sum(map(jobs_in, parts(bench)))
    assert size < 2000
    assert "0 done now, 3000 before" in bench.run()[1]
    bench("aggregate", "results/sweep")
    ids = bench.summary().column("job_id").to_pylist()
    assert len(ids) == 3000 and ids == sorted(set(ids))


def test_a_bad_job_among_cheap_ones_fails_alone(bench):
    bench.sweep("unknown_column_when_heavy", 1000)
    bench.run(code=1)
    status = bench.status(code=1)
    assert (status["solved"], status["failed"], status["causes"]) == (500, 500, {"BrokenContract": 500})


@pytest.mark.thorough
def test_kill_9_at_any_step_of_gathering_loses_and_repeats_nothing(bench, killed, undisturbed):
    bench.sweep("slow", 40)
    kills = 0
    for step in range(1, 12):
        kills += killed(step, "run", "./sweep.toml", "--workers", "1")
    assert kills >= 6
    finished = bench.status()["solved"]
    before = bench.solved()
    assert f"{40 - finished} done now, {finished} before" in bench.run()[1]
    assert sum((bench.solved() - before).values()) == 40 - finished
    kills = sum(killed(step, "aggregate", "results/sweep") for step in range(1, 12))
    assert kills >= 4
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)
    assert not (bench.results / "corrupt").exists()


@pytest.fixture
def gathered(bench, few):
    """Forty jobs, most of them in parts."""
    bench.sweep("slow", 40)
    bench.run()
    return bench


def test_a_part_that_is_there_twice_counts_once(gathered, undisturbed):
    path = parts(gathered)[0]
    shutil.copy(path, path.with_name(f"{path.stem}f{path.suffix}"))
    status = gathered.status()
    assert (status["jobs"], status["solved"], status["left"], status["others"]) == (40, 40, 0, 0)
    gathered("aggregate", "results/sweep")
    assert gathered.summary().equals(undisturbed)


@pytest.mark.parametrize("command", [["run", "./sweep.toml"], ["aggregate", "results/sweep"]])
def test_a_torn_part_is_named_set_aside_and_its_jobs_redone(gathered, undisturbed, command):
    path = parts(gathered)[0]
    torn = set(pq.read_table(path).column("job_id").to_pylist())
    path.write_bytes(path.read_bytes()[:-1000])
    before = gathered.solved()
    assert gathered.status()["left"] == len(torn)
    _, said = gathered(*command)
    assert f"{path.name}: damaged; set aside as" in said
    gathered.run()
    assert gathered.solved() - before == dict.fromkeys(torn, 1)
    gathered("aggregate", "results/sweep")
    assert gathered.summary().equals(undisturbed)


def test_what_failed_in_a_part_gives_way_to_what_is_solved_later(bench, few):
    bench.sweep("failing_when_heavy", 40)
    bench.run(code=1)
    assert bench.status(code=1)["failed"] == 20
    bench.fix()
    assert "20 done now, 20 before" in bench.run("--retry-failed")[1]
    assert bench.status()["solved"] == 40
    bench("aggregate", "results/sweep")
    assert bench.summary().column("status").to_pylist() == ["solved"] * 40


def test_a_file_that_is_torn_or_gone_is_passed_over_unless_all_are_needed(bench):
    bench.sweep("two_optima", 3)
    bench.run()
    folder, (whole, torn, gone) = ResultsFolder(bench.results), bench.job_files()
    torn.write_bytes(torn.read_bytes()[:100])
    gone.unlink()
    ids = [path.stem for path in (whole, torn, gone)]
    rows = JobFiles(folder, ids, folder.schema()).below(None)
    assert rows.column("job_id").unique().to_pylist() == [whole.stem]
    with pytest.raises(Damaged):
        JobFiles(folder, ids, folder.schema(), strict=True).below(None)


def test_a_shard_gathers_what_is_its_own(bench, few, undisturbed):
    bench.sweep("slow", 40)
    bench.run("--shard", "1/2")
    first = set(parts(bench))
    bench.run("--shard", "2/2")
    # Whoever else is at work may be gathering those.
    assert first < set(parts(bench)) and len(bench.job_files()) <= 2
    assert {shard_of(path) for path in parts(bench)} == {"1-of-2", "2-of-2"}
    # Parts of other counts of shards lie beside them.
    assert "0 done now" in bench.run("--shard", "2/3")[1]
    bench.run()
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)


def test_a_shard_goes_on_beside_a_torn_part(bench, few, undisturbed):
    bench.sweep("slow", 40)
    bench.run("--shard", "1/2")
    path = parts(bench)[0]
    path.write_bytes(path.read_bytes()[:1000])
    bench.run("--shard", "1/2")
    bench.run("--shard", "2/2")
    assert bench.status()["left"] == 0
    bench("aggregate", "results/sweep")
    assert bench.summary().equals(undisturbed)


def test_parts_are_merged_by_their_size(tmp_path):
    folder = ResultsFolder(tmp_path)
    for jobs in (16, 255, 256, 4095, 4096):
        folder.new_part(jobs, Shard(3, 7)).touch()
    (folder.parts / "notes.parquet").touch()
    found = folder.part_files()
    assert [jobs_in(path) for path in found] == [4096, 4095, 256, 255, 16]
    assert {shard_of(path) for path in found} == {"3-of-7"}
    assert [gather._size(path) for path in found] == [3, 2, 2, 1, 1]


def test_a_job_that_is_named_again_is_in_a_table_at_every_moment(bench, monkeypatch):
    for jobs in (3, 2):
        bench.sweep("two_optima", jobs)
        bench.run()
        bench("aggregate", "results/sweep")
    bench.sweep("two_optima", 3)
    bench.run()
    replace, placed = os.replace, []

    def fill_the_disk_after_the_first(source, target):
        if placed:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        placed.append(target.name)
        replace(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", fill_the_disk_after_the_first)
        bench("aggregate", "results/sweep", code=2)
    assert placed == ["retired.parquet"]
    assert "0 done now, 3 before" in bench.run()[1]
    assert set(bench.solved().values()) == {1}
