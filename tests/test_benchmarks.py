"""The benchmarks: contenders answer alike, a missing peer is named, and the record holds the machine."""

import json
import sys

import numpy as np
import pyarrow.parquet as pq
import pytest

from benchmarks import field, force_map, place, saving_map, wake_force
from benchmarks.contest import Contender, Contest, measure
from benchmarks.record import store, table


@pytest.fixture(autouse=True)
def _without_peers(monkeypatch):
    """Let no peer be installed: what their packages warn of is not ours to answer for."""
    monkeypatch.setitem(sys.modules, "pterasoftware", None)


def answering(name, value, **options):
    """Return a contender whose work is nothing and whose answer is a number."""
    return Contender(name, answer=lambda: np.array([value, 2.0]), **options)


@pytest.fixture(scope="module")
def rows():
    absent = Contender("a peer", missing="No module named 'peer'")
    return measure(
        Contest("nothing", "pause", [answering("Upwash", 2.0), answering("other", 2.5), absent]), 0.0
    )


@pytest.mark.parametrize("module", [field, wake_force, force_map])
def test_all_contenders_of_a_contest_compute_the_same(module, monkeypatch):
    monkeypatch.setattr(field, "POINTS", 500)
    monkeypatch.setattr(force_map, "SIZE", 30)
    ours, *others = [one for one in module.contest().contenders if not one.missing]
    ours.run()
    for one in others:
        one.run()
        assert one.answer() == pytest.approx(ours.answer(), rel=1e-6, abs=1e-8)


def test_a_peer_that_is_not_installed_is_reported_and_not_fatal(monkeypatch):
    monkeypatch.setattr(field, "POINTS", 10)
    missing = {one.name: one.missing for one in field.contest().contenders if one.missing}
    assert list(missing) == ["PteraSoftware, compiled"]
    assert "make bench" in missing["PteraSoftware, compiled"]


def test_a_contender_is_set_against_the_first(rows):
    ours, other, absent = rows
    assert ours["ratio"] == 1.0 and ours["difference"] == 0.0
    assert other["ratio"] == other["time_best_s"] / ours["time_best_s"]
    assert other["difference"] == 0.25
    assert ours["samples"] == other["samples"] >= 3
    assert absent["missing"] and "time_best_s" not in absent


def test_the_table_names_every_contender(rows):
    lines = table(rows).splitlines()
    assert [line.split("  ")[1] for line in lines[2:4]] == ["Upwash", "other"]
    assert lines[4].endswith("missing: No module named 'peer'")


def test_the_record_holds_the_machine_the_versions_and_who_was_missing(rows, tmp_path):
    path = store(rows, tmp_path / "bench")
    kept = pq.read_table(path)
    assert path.name == "nothing.parquet" and kept.num_rows == 3
    assert kept["processor"][0].as_py() and kept["cores"][0].as_py() >= 1
    assert {"python", "numba", "numpy"} <= set(json.loads(kept.schema.metadata[b"package_versions"]))
    assert [row["time_best_s"] is None for row in kept.to_pylist()] == [False, False, True]
    assert all(kept.schema.field(name).metadata[b"description"] for name in kept.column_names)


def test_all_strokes_hold_the_one_that_a_root_finder_comes_to(monkeypatch):
    monkeypatch.setattr(place, "PLACES_OF_PEERS", 5)
    ours, scipy, _ = place.contest().contenders
    assert np.all(ours.answer() <= scipy.answer() + 1e-9)
    assert ours.answer() == pytest.approx(scipy.answer(), rel=1e-8)


def test_a_map_misses_nothing_that_a_grid_has():
    ours, grid, _ = saving_map.contest().contenders
    assert np.all(ours.answer() <= grid.answer() + 1e-9)
