"""Results folders of the parts of a sweep become one, as if one run had written it, or it is said why not."""

import json
import shutil

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from upwash.batch import store
from upwash.batch.folder import ResultsFolder


@pytest.fixture
def shards(bench):
    """Two shards of forty jobs in a folder each, of which the first is gathered."""
    bench.sweep("slow", 40)
    for number in (1, 2):
        bench.run("--shard", f"{number}/2", "--results", f"part-{number}")
    bench("aggregate", "part-1")
    return bench


def merge(bench, *arguments, code=0):
    return bench("merge", "results/sweep", *arguments, code=code)


def test_gathered_parts_and_others_become_one_run(shards, undisturbed):
    assert merge(shards, "part-1", "part-2")[1].splitlines()[-1] == "results/sweep: 40 of 40 jobs"
    status = shards.status()
    assert (status["sweep"], status["jobs"], status["solved"], status["left"]) == ("sweep", 40, 40, 0)
    assert "0 done now, 40 before" in shards.run()[1]
    assert set(shards.solved().values()) == {1}
    assert json.loads(shards("check", "results/sweep", "--json", code=3)[0])["jobs"] == 40
    shards("aggregate", "results/sweep")
    assert shards.summary().equals(undisturbed)


def test_what_is_left_is_counted_and_done_by_a_run(shards, undisturbed):
    told = json.loads(merge(shards, "part-2", "--json")[0])
    jobs = shards.folder / "part-2" / "jobs"
    assert told["by_folder"] == {"part-2": len(list(jobs.glob("*.parquet")))}
    assert (told["jobs"], told["found"] + told["left"], told["twice"]) == (40, 40, 0)
    assert f"{told['left']} done now, {told['found']} before" in shards.run()[1]
    shards("aggregate", "results/sweep")
    assert shards.summary().equals(undisturbed)


def test_shards_of_different_counts_may_overlap(shards, undisturbed):
    shards.run("--shard", "1/3", "--results", "part-3")
    _, said = merge(shards, "part-1", "part-2", "part-3")
    assert " jobs, " in said and said.splitlines()[-1].endswith("in several of them")
    shards("aggregate", "results/sweep")
    assert shards.summary().equals(undisturbed)


def test_the_parts_stay_as_they_are_and_nothing_is_overwritten(shards):
    before = {path: path.read_bytes() for path in shards.folder.rglob("*") if path.is_file()}
    merge(shards, "part-1", "part-2")
    _, said = merge(shards, "part-1", "part-2", code=2)
    assert said.startswith("Error: results/sweep: expected no such folder yet")
    assert all(path.read_bytes() == data for path, data in before.items())
    shards("merge", "part-1", "part-2", code=2)
    assert not list((shards.folder / "results").glob(".*"))


def test_what_failed_in_one_and_is_solved_in_another_is_solved(bench):
    bench.sweep("failing_when_heavy", 4)
    bench.run("--results", "a", code=1)
    bench.fix()
    bench.run("--results", "b")
    for parts in (("a", "b"), ("b", "a")):
        shutil.rmtree(bench.results, ignore_errors=True)
        assert "4 of 4 jobs, 4 in several of them\n" in merge(bench, *parts)[1]
        assert bench.status()["solved"] == 4
    shutil.rmtree(bench.results)
    assert "4 of 4 jobs, 2 failed" in merge(bench, "a")[1]


def test_results_that_do_not_agree_are_refused(shards):
    shutil.copytree(shards.folder / "part-2", shards.folder / "part-3")
    path = next((shards.folder / "part-3" / "jobs").glob("*.parquet"))
    change(path, "cost", lambda cost: cost + 1e-12)
    merge(shards, "part-2", "part-3")
    shutil.rmtree(shards.results)
    change(path, "cost", lambda cost: cost + 1e-3)
    _, said = merge(shards, "part-2", "part-3", code=2)
    assert said.startswith(f"Error: part-2, part-3: expected one result of job {path.stem}, found two")
    assert ": cost 1" in said and len(said.splitlines()) == 1
    assert not shards.results.exists()


def test_a_lost_optimum_does_not_agree(shards):
    shutil.copytree(shards.folder / "part-2", shards.folder / "part-3")
    path = next((shards.folder / "part-3" / "jobs").glob("*.parquet"))
    table = pq.read_table(path)
    write(path, table.slice(0, 1))
    _, said = merge(shards, "part-2", "part-3", code=2)
    assert f"job {path.stem}" in said and "other rows" in said


def change(path, column, by):
    table = pq.read_table(path)
    place = table.schema.get_field_index(column)
    values = pa.array([by(value) for value in table.column(column).to_pylist()])
    write(path, table.set_column(place, table.schema.field(place), values))


def write(path, table):
    pq.write_table(table, path, write_page_checksum=True, **store.JOB_FILE_OPTIONS)


def test_parts_of_other_sweeps_are_refused_with_what_differs(shards):
    shards.sweep("slow", 39)
    shards.run("--results", "other")
    _, said = merge(shards, "part-1", "other", code=2)
    assert said.startswith("Error: other: expected the jobs of part-1, found 37 that it has not and 38 that")
    (shards.folder / "flocks.toml").write_text(
        'solver = "stub_solvers:infeasible"\nkind = "flock"\nspecies = "northern-bald-ibis"\n'
    )
    shards("run", "./flocks.toml", "--results", "flocks")
    _, said = merge(shards, "part-1", "flocks", code=2)
    assert said.startswith("Error: flocks: expected a pair sweep as in part-1, found a flock one")


def test_an_edited_comment_is_the_same_sweep(shards):
    path = shards.folder / "sweep.toml"
    path.write_text("# the same\n" + path.read_text())
    shards.run("--shard", "1/2", "--results", "part-3")
    merge(shards, "part-1", "part-3")


@pytest.mark.parametrize(
    ("parts", "error"),
    [
        (("part-1", "nowhere"), "'nowhere': expected a results folder, found no such folder"),
        (("part-1", "./part-1"), "part-1: expected each folder once"),
        ((), "Missing argument"),
    ],
)
def test_mistakes_are_one_line(shards, parts, error):
    _, said = merge(shards, *parts, code=2)
    assert said.startswith(f"Error: {error}") and len(said.splitlines()) == 1


def test_a_damaged_part_is_named_and_nothing_is_written(shards):
    path = next((shards.folder / "part-2" / "jobs").glob("*.parquet"))
    path.write_bytes(path.read_bytes()[:-50])
    _, said = merge(shards, "part-1", "part-2", code=2)
    assert said.startswith("Error: part-2: expected whole files") and path.name in said
    path = shards.folder / "part-1" / "solutions.parquet"
    path.write_bytes(path.read_bytes()[:-50])
    _, said = merge(shards, "part-1", "part-2", code=2)
    assert said.startswith("Error: part-1: expected whole files")
    assert not list((shards.folder / "results").iterdir())


def test_a_part_that_is_being_written_is_refused(shards):
    with ResultsFolder(shards.folder / "part-2").locked():
        _, said = merge(shards, "part-1", "part-2", code=2)
    assert said.startswith("Error: part-2: expected nobody to write there")
    merge(shards, "part-1", "part-2")


def test_a_folder_without_a_plan_is_refused(shards):
    (shards.folder / "part-1" / "plan.json").unlink()
    assert "part-1: expected plan.json" in merge(shards, "part-1", "part-2", code=2)[1]


def test_merged_folders_merge_again(shards, undisturbed):
    shards("merge", "half", "part-1")
    merge(shards, "half", "part-2")
    shards("aggregate", "results/sweep")
    assert shards.summary().equals(undisturbed)
