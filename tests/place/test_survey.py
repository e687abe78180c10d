"""Many birds at their places: the best, the mean and the worst of what is not known of each, and errors."""

import numpy as np
import pytest
from upwash import WakeModel, load_species
from upwash.place.balance import Behind
from upwash.place.survey import Birds, survey

IBIS = load_species("northern-bald-ibis").bird()
MODELS = [WakeModel(), WakeModel.named("limit")]
PLACES = np.array([[1.2, 0.904, 0.05, 0.2], [1.9, 0.6, -0.1, 0.7], [0.8, 1.2, 0.1, 0.45]])


def birds(height_is_free, phase_is_free, errors=None):
    """Return three birds, of which height and phase may be free."""
    places = PLACES.copy()
    places[:, 2] *= not height_is_free
    places[:, 3] *= not phase_is_free
    count = len(places)
    return Birds(
        places,
        np.arange(count + 1),
        np.full(count, height_is_free),
        np.full(count, phase_is_free),
        errors,
    )


def savings(behind, places):
    """Return the saving of power at each of some places, one by one."""
    found = [behind.balances([place]).strokes for place in places]
    return np.array([1.0 - strokes[0].cost if strokes else -np.inf for strokes in found])


@pytest.mark.parametrize("model", MODELS, ids=["paper", "limit"])
def test_of_a_known_place_it_finds_what_balances_there(model):
    behind = Behind(IBIS, model=model)
    found = survey(behind, birds(False, False))
    assert 1.0 - found.cost == pytest.approx(savings(behind, PLACES), abs=1e-12)
    assert np.all(found.count == 1)
    assert np.all(np.isnan(found.mean_phase)) and np.all(np.isnan(found.mean_height))


@pytest.mark.parametrize("model", MODELS, ids=["paper", "limit"])
def test_the_best_and_worst_phase_are_those_of_a_fine_scan(model):
    behind = Behind(IBIS, model=model)
    found = survey(behind, birds(False, True))
    for row, (x, y, z, _) in enumerate(PLACES):
        scan = savings(behind, [(x, y, z, phase) for phase in np.arange(200) / 200])
        assert 1.0 - found.cost[row] >= np.max(scan) - 1e-12
        # The scan steps over the peak, which may be a kink.
        assert 1.0 - found.cost[row] == pytest.approx(np.max(scan), abs=5e-5)
        assert found.worst_phase[row] <= np.min(scan) + 1e-12
        assert found.worst_phase[row] == pytest.approx(np.min(scan), abs=5e-4)
        assert found.mean_phase[row] == pytest.approx(np.mean(scan), abs=1e-4)
        best = savings(behind, [(x, y, z, found.phase[row])])
        assert 1.0 - found.cost[row] == pytest.approx(best[0], abs=1e-12)


def test_the_best_height_is_that_of_a_fine_scan():
    behind = Behind(IBIS)
    found = survey(behind, birds(True, False))
    half = 0.5 * IBIS.amplitude_m
    for row, (x, y, _, phase) in enumerate(PLACES):
        scan = savings(behind, [(x, y, z, phase) for z in np.linspace(-half, half, 401)])
        assert 1.0 - found.cost[row] >= np.max(scan) - 1e-9
        assert 1.0 - found.cost[row] == pytest.approx(np.max(scan), abs=2e-4)
        assert found.worst_height[row] == pytest.approx(np.min(scan), abs=2e-4)
        assert found.mean_height[row] == pytest.approx(np.mean(scan), abs=2e-3)
        assert abs(found.height_m[row]) <= half + 1e-12


def test_height_and_phase_together_are_no_worse_than_a_fine_scan():
    behind = Behind(IBIS)
    found = survey(behind, birds(True, True))
    half = 0.5 * IBIS.amplitude_m
    x, y = PLACES[1, :2]
    scan = savings(
        behind,
        [(x, y, z, phase) for z in np.linspace(-half, half, 41) for phase in np.arange(40) / 40],
    )
    assert 1.0 - found.cost[1] >= np.max(scan) - 1e-6
    assert found.mean_height[1] >= found.worst_height[1]
    assert found.mean_phase[1] >= found.worst_phase[1]


def test_errors_of_the_place_spread_the_saving():
    behind = Behind(IBIS)
    errors = np.tile([0.03, 0.03, 0.03, 0.0], (3, 1))
    found = survey(behind, birds(False, False, errors))
    random = np.random.default_rng(4)
    for row, place in enumerate(PLACES):
        drawn = savings(behind, place + errors[row] * random.normal(size=(2000, 4)))
        low, high = np.quantile(drawn, [0.05, 0.95])
        width = high - low
        assert found.low[row] == pytest.approx(low, abs=0.12 * width)
        assert found.high[row] == pytest.approx(high, abs=0.12 * width)
    assert np.all(found.balanced_nearby == 1.0)


def test_without_errors_the_quantiles_are_the_saving():
    behind = Behind(IBIS)
    found = survey(behind, birds(False, False, np.zeros((3, 4))))
    assert found.low == pytest.approx(1.0 - found.cost, abs=1e-12)
    assert found.high == pytest.approx(1.0 - found.cost, abs=1e-12)


def test_any_number_of_threads_finds_the_same():
    behind = Behind(IBIS)
    random = np.random.default_rng(3)
    places = random.uniform([0.5, 0.3, -0.2, 0.0], [2.5, 1.5, 0.2, 1.0], (150, 4))
    free = np.arange(150) % 3 == 0
    places[free, 3] = 0.0
    many = Birds(places, np.arange(151), np.zeros(150, bool), free)
    one, four = survey(behind, many), survey(behind, many, threads=4)
    for name in vars(one):
        assert np.array_equal(getattr(one, name), getattr(four, name), equal_nan=True)
