"""What all evaluated birds come to: how many save, how much, and in which phase they fly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from upwash.study.told import OUTCOMES


@dataclass
class EvaluationTally:
    """Counts evaluated birds, piece by piece.

    Attributes
    ----------
    outcomes : dict of str to int
        Birds by what came out for them.
    savings, shares : list of ndarray of float
        Savings, and their shares of what is attainable.
    spatial_phases : list of ndarray of float
        Spatial phases of those birds whose phase was given.
    """

    outcomes: dict[str, int] = field(default_factory=lambda: dict.fromkeys(OUTCOMES, 0))
    savings: list[np.ndarray] = field(default_factory=list)
    shares: list[np.ndarray] = field(default_factory=list)
    spatial_phases: list[np.ndarray] = field(default_factory=list)
    first_fault: str = ""
    _names: list[np.ndarray] = field(default_factory=list)

    def add(self, told: pd.DataFrame) -> None:
        """Count a piece."""
        for outcome, count in told["outcome"].value_counts().items():
            self.outcomes[str(outcome)] += int(count)
        savings = told["saving_total"].to_numpy(dtype=float)
        balances = np.isfinite(savings)
        self.savings.append(savings[balances])
        self.shares.append(told["share_of_attainable"].to_numpy(dtype=float)[balances])
        was_given = told["saving_best_phase"].isna().to_numpy() & balances
        self.spatial_phases.append(told["spatial_phase"].to_numpy(dtype=float)[was_given])
        faults = told.loc[told["outcome"] == "invalid", "reason"]
        if len(faults) and not self.first_fault:
            self.first_fault = str(faults.iloc[0])
        if "id" in told:
            self._names.append(pd.util.hash_array(told["id"].astype(str).to_numpy(dtype=object)))

    @property
    def rows(self) -> int:
        """All rows."""
        return sum(self.outcomes.values())

    def ids_twice(self) -> int:
        """Return how many rows of a table with ids have one that another row has too."""
        names = np.concatenate(self._names) if self._names else np.empty(0)
        _, counts = np.unique(names, return_counts=True)
        return int(np.sum(counts[counts > 1]))

    def median_saving(self) -> float:
        """Return the median saving of those birds that balance; NaN if none does."""
        return _median(self.savings)

    def median_share(self) -> float:
        """Return the median share of what is attainable; NaN if that is not known."""
        return _median(self.shares)

    def phase_statistics(self) -> tuple[int, float, float, float]:
        """Return of given phases their number, mean spatial phase, concentration and Rayleigh's p."""
        return rayleigh(np.concatenate(self.spatial_phases) if self.spatial_phases else np.empty(0))


def rayleigh(turns: np.ndarray | Sequence[float]) -> tuple[int, float, float, float]:
    """Return number, mean direction, concentration and Rayleigh's p of phases in turns.

    The concentration is the length of the mean of unit vectors, from 0 (evenly spread) to 1 (all alike); p is the
    chance of one so large if there were no preferred phase (Zar 2010, eq. 27.4).

    Examples
    --------
    >>> count, mean, concentration, p = rayleigh([0.05, -0.05, 0.0, 0.1, -0.1, 0.02])
    >>> count, round(mean, 3), round(concentration, 2), round(p, 3)
    (6, 0.004, 0.92, 0.002)
    """
    turns = np.asarray(turns, dtype=float)
    if not turns.size:
        return 0, math.nan, math.nan, math.nan
    mean = np.mean(np.exp(2j * np.pi * turns))
    count, length = turns.size, float(np.abs(mean))
    resultant = count * length
    p = math.exp(math.sqrt(1.0 + 4.0 * count + 4.0 * (count**2 - resultant**2)) - (1.0 + 2.0 * count))
    return count, float(np.angle(mean) / (2.0 * np.pi)), length, min(p, 1.0)


def _median(parts: list[np.ndarray]) -> float:
    values = np.concatenate(parts) if parts else np.empty(0)
    values = values[np.isfinite(values)]
    return float(np.median(values)) if values.size else math.nan
