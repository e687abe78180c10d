"""The least cost at each place of a plane: against a fine scan, in any order, by any number of threads."""

import numpy as np
import pytest
from upwash import WakeModel, load_species
from upwash.place.balance import Behind
from upwash.place.held import HeldPlaces
from upwash.place.least import least_over

IBIS = load_species("northern-bald-ibis").bird()
LIMIT = WakeModel.named("limit")
MODELS = {"paper": WakeModel(), "limit": LIMIT, "four states": WakeModel(stroke_states=4, span_law="tip")}


def plane_of(x, y, z=0.0, phase=0.0):
    """Return places over a plane of x and y."""
    places = np.zeros((len(y), len(x), 4))
    places[..., 0], places[..., 1], places[..., 2], places[..., 3] = x, np.array(y)[:, None], z, phase
    return places


def scanned(behind, place, heights, phases):
    """Return the least cost at a place over a grid of heights and phases, each with all strokes that balance."""
    height, lag = (axis.ravel() for axis in np.meshgrid(heights, phases))
    at = np.empty((height.size, 4))
    at[:, :2], at[:, 2], at[:, 3] = np.array(place[:2]) / IBIS.semispan_m, height, lag
    return np.min(HeldPlaces(behind, ()).balanced(at)[:, 2])


@pytest.mark.parametrize(
    ("model", "fineness"), [("paper", (41, 40)), ("limit", (15, 24)), ("four states", (21, 32))]
)
def test_no_place_of_a_fine_scan_costs_less(model, fineness):
    behind = Behind(IBIS, model=MODELS[model])
    x, y = (0.3, 1.2, 1.78, 3.2), (0.05, 0.55, 0.89, 1.15)
    found = least_over(behind, plane_of(x, y), ("z", "phase"))
    half = 0.5 * IBIS.amplitude_m / IBIS.semispan_m
    heights, phases = np.linspace(-half, half, fineness[0]), np.arange(fineness[1]) / fineness[1]
    rows = range(16) if model != "limit" else range(1, 16, 4)
    scan = np.array([scanned(behind, found.places[row], heights, phases) for row in rows])
    cost = found.cost[list(rows)]
    assert np.all(cost <= scan + 1e-9)
    # A grid misses the edge on which the best may lie, by little.
    assert np.max(scan - cost) < 5e-3 and np.median(scan - cost) < 1e-3
    assert np.all(np.abs(found.places[:, 2]) <= 0.5 * IBIS.amplitude_m * (1.0 + 1e-12))


@pytest.mark.parametrize("model", ["paper", "limit"])
def test_what_is_told_balances_there_and_costs_what_is_told(model):
    behind = Behind(IBIS, model=MODELS[model])
    found = least_over(behind, plane_of((0.7, 1.6), (0.2, 1.0)), ("z", "phase"))
    for row, place in enumerate(found.places):
        balances = behind.balances([tuple(place)])
        assert len(balances.strokes) == found.count[row]
        assert balances.strokes[0].cost == pytest.approx(found.cost[row], abs=1e-10)
        assert balances.strokes[0].stroke.amplitude_m == pytest.approx(found.amplitude_m[row], abs=1e-8)


@pytest.mark.parametrize("model", ["paper", "limit"])
def test_neither_threads_nor_pieces_nor_order_change_anything(model, monkeypatch):
    behind = Behind(IBIS, model=MODELS[model])
    places = plane_of(np.linspace(0.2, 3.5, 5), np.linspace(0.0, 1.4, 5))
    # In the limit the phase is held, so that places differ along x.
    free = ("z", "phase") if model == "paper" else ("z",)
    expected = least_over(behind, places, free)
    monkeypatch.setattr("upwash.place.least.PLACES_AT_ONCE", 3)
    in_threads = least_over(behind, places, free, threads=3)
    backwards = least_over(behind, places[::-1, ::-1].copy(), free)
    for name in ("places", "count", "missing", "missing_share", "amplitude_m", "span_ratio", "cost"):
        one = getattr(expected, name)
        np.testing.assert_array_equal(one, getattr(in_threads, name), err_msg=name)
    np.testing.assert_allclose(backwards.cost[::-1], expected.cost, rtol=1e-8, equal_nan=True)


def test_neighbours_tell_what_a_place_does_not_find_by_itself(monkeypatch):
    behind = Behind(IBIS)
    places = plane_of(np.linspace(0.2, 3.5, 12), np.linspace(0.0, 1.4, 12))
    together = least_over(behind, places, ("z", "phase"))
    monkeypatch.setattr("upwash.place.least.STARTS", 1)
    few = least_over(behind, places, ("z", "phase"))
    monkeypatch.setattr("upwash.place.least.MOST_ROUNDS", 0)
    alone = least_over(behind, places, ("z", "phase"))
    assert np.all(few.cost <= alone.cost + 1e-12) and np.any(few.cost < alone.cost - 1e-6)
    assert np.all(together.cost <= few.cost + 1e-6)


class TestFree:
    def test_more_freedom_costs_no_more(self):
        behind = Behind(IBIS)
        places = plane_of((0.8, 1.7), (0.6, 0.9), z=0.1, phase=0.4)
        costs = [
            np.nan_to_num(least_over(behind, places, free).cost, nan=np.inf)
            for free in ((), ("phase",), ("z", "phase"), ("y", "z", "phase"))
        ]
        for less, more in zip(costs, costs[1:], strict=False):
            assert np.all(more <= less + 1e-9)
        assert np.all(costs[0] > costs[-1])

    def test_what_is_held_stays(self):
        found = least_over(Behind(IBIS), plane_of((0.8, 1.7), (0.6, 0.9), z=0.1, phase=0.4), ())
        assert np.all(found.places[:, 2] == 0.1) and np.all(found.places[:, 3] == 0.4)
        found = least_over(Behind(IBIS), plane_of((0.8, 1.7), (0.6, 0.9), z=0.1, phase=0.4), ("x",))
        assert np.all(
            found.places[:, 1:] == plane_of((0, 0), (0.6, 0.9), z=0.1, phase=0.4).reshape(-1, 4)[:, 1:]
        )
        assert np.all(found.places[:, 0] >= 0.0)

    def test_behind_an_endless_wake_distance_and_phase_are_one(self):
        behind, wavelength = Behind(IBIS, model=LIMIT), IBIS.wavelength_m
        places = plane_of((0.4, 1.5, 2.9), (0.9, 1.1))
        by_phase, by_distance, by_both = (
            least_over(behind, places, free) for free in (("phase",), ("x",), ("x", "phase"))
        )
        assert by_distance.cost == pytest.approx(by_phase.cost, abs=1e-12)
        assert by_both.cost == pytest.approx(by_phase.cost, abs=1e-12)
        spatial = [
            (found.places[:, 0] / wavelength - found.places[:, 3]) % 1.0 for found in (by_phase, by_distance)
        ]
        assert np.cos(2 * np.pi * spatial[0]) == pytest.approx(np.cos(2 * np.pi * spatial[1]), abs=1e-9)
        # All distances are alike, and each has the phase that goes with it.
        assert by_phase.places[:, 0].tolist() == places[..., 0].ravel().tolist()
        assert np.ptp(by_phase.cost.reshape(2, 3), axis=1).max() == 0.0
        assert len(np.unique(by_phase.places[:, 3])) >= 3


def test_where_nothing_balances_it_says_what_is_missing():
    behind = Behind(IBIS, model=LIMIT)
    found = least_over(behind, plane_of((1.875, 1.9), (0.0, 1.1), phase=0.5), ())
    assert found.count.tolist() == [0, 0, 1, 1]
    assert found.missing_share[:2] == pytest.approx(0.11, abs=0.01)
    assert np.all(np.isnan(found.cost[:2])) and np.all(np.isfinite(found.cost[2:]))


def test_progress_is_told():
    told = []
    least_over(
        Behind(IBIS),
        plane_of((0.8, 1.7), (0.6, 0.9)),
        ("z", "phase"),
        told=lambda done, of: told.append((done, of)),
    )
    assert told and all(done <= of for done, of in told) and told[-1][0] == told[-1][1]
