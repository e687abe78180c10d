"""Make the table of ibises that docs/observed.md walks through, and put it there: python tools/renew_observed.py.

The birds are made, not observed: 40 followers on both sides of their leaders about where northern bald ibises were
reported (Portugal et al. 2014: 1.2 m behind, 0.9 to 1.1 m aside, close to one plane, wingtips nearly in phase with the
wake), with a scatter that GPS and video have.  Of 16 the phase could not be told.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

PAGE = Path(__file__).parents[1] / "docs" / "observed.md"
TITLE = '```csv title="ibises.csv"\n'
SEED, BIRDS, WITHOUT_PHASE = 2014, 40, 16
WAVELENGTH_M = 3.75


def made_ibises() -> pd.DataFrame:
    """Return the table: x_m, y_m, z_m and phase of each follower, by its name and flight."""
    random = np.random.default_rng(SEED)
    x = np.clip(random.normal(1.2, 0.3, BIRDS), 0.4, None)
    y = random.normal(1.0, 0.15, BIRDS) * random.choice([-1.0, 1.0], BIRDS)
    z = random.normal(-0.03, 0.08, BIRDS)
    spatial_phase = random.vonmises(0.0, 1.2, BIRDS) / (2.0 * np.pi)
    phase = (x / WAVELENGTH_M - spatial_phase) % 1.0
    phase[random.choice(BIRDS, WITHOUT_PHASE, replace=False)] = np.nan
    return pd.DataFrame(
        {
            "bird": [f"ibis {number:02d}" for number in range(1, BIRDS + 1)],
            "flight": random.integers(1, 4, BIRDS),
            "x_m": x.round(2),
            "y_m": y.round(2),
            "z_m": z.round(2),
            "phase": phase.round(2),
        }
    )


def made_text() -> str:
    """Return the table as it stands on the page."""
    return made_ibises().to_csv(index=False, lineterminator="\n")


if __name__ == "__main__":
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(TITLE)
    PAGE.write_text(before + TITLE + made_text() + "```" + rest.partition("```")[2], encoding="utf-8")
