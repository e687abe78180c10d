"""A browser; and rows of results as the batch layer stores them, with figures that are easy to check by eye."""

import os

import pandas as pd
import pytest
from renew_claims import kept
from upwash import columns as of
from upwash.aero.wake import WakeModel
from upwash.paper.ledger import write_claims
from upwash.report.page import write_page

from report import studies
from report.browser import Browser, find_browser

IBIS = {
    "species": "northern-bald-ibis",
    "status": "solved",
    "mass_kg": 1.3,
    "semispan_m": 0.5,
    "speed_m_s": 10.0,
    "period_s": 0.25,
    "density_kg_m3": 1.29,
    "gravity_m_s2": 10.0,
    "leader_amplitude_m": 1.0,
    "leader_upstroke_span_ratio": 0.4,
    "model": "paper",
    **vars(WakeModel()),
    "tolerance": 1e-4,
    "weight_n": 13.0,
    "drag_n": 2.0,
    "lift_self_n": 12.0,
    "thrust_self_n": 1.6,
    "power_total_w": 45.0,
    "power_profile_w": 28.0,
    "leader_power_total_w": 50.0,
    "leader_power_profile_w": 32.0,
    "saving_induced": 0.1,
    "saving_profile": 0.125,
    "saving_total": 0.1,
    "cost_leader": 13.0,
    "residual_lift": 1e-13,
    "residual_thrust": -2e-12,
    "phase": 0.5,
    "hits": 3,
    "starts": 60,
    "active_bounds": "mu_lower",
    "core_edges": "left/down/right tip/upstroke/up, both/down/stopping/upstroke/up",
    "stationarity": 1e-13,
    "v_region_certified_gap": 1e-4,
    "v_certified_gap": 1e-4,
    "global_certified_gap": 1e-4,
    "certificate_boxes": 100,
    "v_lower_bound": 12.3,
    "global_lower_bound": 12.2,
    "v_wall": "",
    "feasible": True,
    "solve_time_s": 0.5,
}
INBOARD = {
    "rank": 0,
    "is_v_optimum": False,
    "is_global_optimum": True,
    "placement": "inboard",
    "tier": "level",
    "station": "astern",
    "cost": 12.0,
    "x_m": 1.25,
    "y_m": 0.25,
    "z_m": -0.05,
    "amplitude_m": 0.8,
    "upstroke_span_ratio": 0.35,
}
IN_THE_V = {
    "rank": 1,
    "is_v_optimum": True,
    "is_global_optimum": False,
    "placement": "outboard",
    "tier": "level",
    "station": "astern",
    "cost": 12.06,
    "x_m": 1.8,
    "y_m": 0.75,
    "z_m": -0.04,
    "amplitude_m": 0.75,
    "upstroke_span_ratio": 0.36,
}


def rows_of_a_job(*optima, **more):
    """Return a frame with every column of the results, one row an optimum."""
    names = [column.name for column in of.SOLUTIONS_COLUMNS]
    rows = [{"objective": "force", **IBIS, **optimum, **more} for optimum in optima]
    return pd.DataFrame([{name: row.get(name) for name in names} for row in rows])


@pytest.fixture
def two_optima():
    """A job whose V optimum is the second best."""
    return rows_of_a_job(INBOARD, IN_THE_V)


@pytest.fixture
def one_optimum():
    """A job whose V optimum is the best of all."""
    return rows_of_a_job(IN_THE_V | {"rank": 0, "is_global_optimum": True})


@pytest.fixture
def inboard_alone():
    """A job without a V optimum; no V formation can fly at all."""
    return rows_of_a_job(INBOARD, v_lower_bound=None, v_certified_gap=None)


@pytest.fixture(scope="module")
def browser():
    """A headless Chromium, which CI must have."""
    if find_browser() is None:
        if os.environ.get("CI") == "true":
            pytest.fail("expected a Chromium in CI, found none; .ci/run installs it")
        pytest.skip("no Chromium on this machine: apt-get install chromium, or let CI run this")
    with Browser() as one:
        yield one


SWEEP = """# A pair & its <flock>.
description = "The ibis's pair, & more"
species = "northern-bald-ibis"
"""


@pytest.fixture(scope="session")
def written(tmp_path_factory):
    """A page about a pair, a flock, the limit and the kept verdicts on the claims; other species were not run."""
    root = tmp_path_factory.mktemp("results")
    pair = studies.write_folder(root / "pair", studies.pair_rows(), text=SWEEP)
    studies.keep_beside(pair, studies.pair_rows())
    flock = studies.write_folder(root / "flock", studies.flock_rows(), "flock")
    limit = studies.write_folder(root / "limit", studies.limit_rows())
    studies.keep_beside(limit, studies.limit_rows(), with_ranges=True)
    write_claims(kept(), pair)
    return write_page(pair, flock, limit)
