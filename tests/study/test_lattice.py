"""The stored flights of the vortex lattice: trimmed, as fine as said, and told on their page as they are."""

import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from upwash.species import load_species
from upwash.study.lattice import aside, best_phases, followers, grids

ROOT = Path(__file__).parents[2]
FLIGHTS = ROOT / "results" / "crosscheck" / "uvlm.parquet"


@pytest.fixture(scope="module")
def flights():
    return pq.read_table(FLIGHTS).to_pandas()


@pytest.fixture(scope="module")
def bird():
    return load_species("northern-bald-ibis").bird()


def test_every_flight_is_trimmed_to_the_models_weight_and_drag(flights, bird):
    assert np.abs(flights["lift_n"] / bird.weight_n - 1.0).max() < 1e-3
    assert np.abs(flights["thrust_n"] / bird.drag_n - 1.0).max() < 1e-3


def test_savings_are_of_the_bird_alone_on_the_same_grid(flights):
    grid = ["half_angle_deg", "chordwise", "spanwise", "steps", "beats"]
    alone = flights[flights["role"] == "alone"].set_index(grid)["power_w"]
    for row in flights[flights["role"] != "alone"].itertuples():
        expected = 1.0 - row.power_w / alone[tuple(getattr(row, name) for name in grid)]
        assert row.saving == pytest.approx(expected, abs=1e-12)


def test_places_phases_and_grids_are_as_many_as_the_page_says(flights):
    assert len(followers(flights)) >= 60
    assert len(grids(flights)) == 5
    assert (flights["role"] == "together").sum() == 1


def test_the_best_phase_is_the_distance_in_wavelengths(flights, bird):
    found = best_phases(flights, bird.wavelength_m)
    wide = found[found["half_angle_deg"] == 60.0]
    assert len(wide) == 4
    apart = wide["best_phase"] - wide["x_wavelengths"]
    assert np.abs(apart - np.round(apart)).max() < 0.05


def test_a_leader_hardly_feels_its_follower(flights):
    both = flights[flights["role"] == "together"].iloc[0]
    one = followers(flights)
    one = one[np.isclose(one["x_m"], both["x_m"]) & (one["z_m"] == both["z_m"])].iloc[0]
    assert abs(both["leader_saving"]) < 0.005
    assert abs(both["saving"] - one["saving"]) < 0.005


def test_the_page_shows_what_is_stored(flights, bird, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "tools")
    sys.modules.pop("renew_lattice", None)
    import renew_lattice

    text = (ROOT / "docs" / "lattice.md").read_text(encoding="utf-8")
    for name, table in renew_lattice.tables(flights, bird).items():
        written = renew_lattice.between(name).search(text)
        assert written is not None and written[0].strip() == table.markdown().partition("\n\n")[2].strip(), (
            name
        )


def test_models_are_set_beside_it_at_the_same_places(flights, bird):
    found = aside(flights, bird)
    assert list(found.groupby("half_angle_deg").size()) == [9, 9]
    assert found[["paper", "stroke law", "tip law"]].notna().any().all()
