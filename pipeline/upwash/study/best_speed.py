"""How fast a bird should fly alone, behind another, and in flocks that take turns at the front or do not."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.columns import INTEGER, TEXT, TRUTH, Column, column, told
from upwash.errors import UpwashError
from upwash.journey.line import Line, Lines, line_of, row_of
from upwash.journey.speed import (
    CRITERIA,
    LEAST_TRANSPORT,
    BestSpeed,
    NoSpeed,
    SpeedSearch,
    speed_range,
    states_needed,
)
from upwash.optimum.settings import SearchSettings

ALONE, FOLLOWER, FLOCK = "alone", "follower", "flock"
"""Whose speed it is: a lone bird's, the best of a bird behind one other, or a flock's."""

MOST_BOXES = 300_000
"""Budget of boxes of each proof: one that takes more is left open, and told so."""

FASTER = 1.1
"""Wakes are told in as many steps as so many times the lone bird's speed of least transport needs."""

SPEEDS = (
    column("species"),
    column("objective"),
    column("amplitude_convention"),
    column("model"),
    column("span_law"),
    Column("criterion", "", f"what the speed makes least: {' or '.join(CRITERIA)}", TEXT),
    Column("birds", "1", "birds that fly together", INTEGER),
    Column("who", "", f"whose speed it is: {ALONE}, {FOLLOWER} (of bird 2) or {FLOCK}", TEXT),
    Column("turns", "", "whether the birds take turns at the front, so that the mean counts", TRUTH),
    Column("speed_m_s", "m/s", "best airspeed; absent if there is none", format=".2f"),
    Column("speed_ratio", "1", "the same over that of the lone bird", format=".3f"),
    Column(
        "power_w", "W", "power that counts there: the mean, the first bird's or the follower's", format=".3f"
    ),
    Column("power_mean_w", "W", "mean power of all the birds there", format=".3f"),
    Column("transport_j_m", "J/m", "power that counts over airspeed", format=".4f"),
    Column(
        "range_ratio", "1", "range on the same energy over the lone bird's, each at its speed", format=".3f"
    ),
    Column("saving", "1", "power that counts there less a lone bird's there", percent=True, format=".1f"),
    Column("slope", "1", "slope of the logarithm of cost against that of speed"),
    Column("bound", "", "what holds the speed where the slope does not vanish", TEXT),
    Column("proved", "", "whether each follower is proved to be at its best there, to the tolerance", TRUTH),
    *(column(name) for name in ("x_m", "y_m", "z_m", "phase", "amplitude_m", "upstroke_span_ratio")),
    Column("error", "", "why there is no such speed", TEXT),
)
"""Columns of `best_speeds`, one row for each criterion, size and way to share; places are those of bird 2."""


def best_speeds(
    birds: Callable[..., Bird],
    objective: str = "power",
    *,
    model: WakeModel | None = None,
    is_resolved: bool = False,
    sizes: Sequence[int] = (1, 2, 6, 12),
    shape: str = "vee",
    turns_alone: bool = False,
    search: SearchSettings | None = None,
    **labels: Any,
) -> pd.DataFrame:
    """Return the best speeds of a bird alone, behind another, and in flocks of some sizes.

    Parameters
    ----------
    birds : callable
        The bird at ``speed_m_s``; it raises an `UpwashError` where there is none.
    objective : str
        Name of the cost function that each follower minimises; its power counts.
    model : WakeModel, optional
        The wake; the paper's if not given.
    is_resolved : bool
        Whether the number of the model's steps is to be kept as it is.
    sizes : sequence of int
        Sizes of flocks.
    shape : str
        One of the shapes of a flock.
    turns_alone : bool
        Whether flocks that take no turns are left out.
    search : SearchSettings, optional
        Of the complete search at each speed found.
    **labels
        Columns that say what the rows are of: ``species`` and ``amplitude_convention``.

    Returns
    -------
    DataFrame
        The columns of `SPEEDS`.

    Raises
    ------
    UpwashError
        If there is no speed at which the lone bird can fly.
    """
    model = model or WakeModel()

    def at(speed: float) -> Bird:
        return birds(speed_m_s=float(speed))

    usual = search or SearchSettings()
    limited = SearchSettings(usual.seed, usual.tolerance, usual.starts, min(MOST_BOXES, usual.most_boxes))
    lines = Lines(objective, model)
    try:
        within = speed_range(at, UpwashError)
        alone = SpeedSearch(at, within, lines, limited)
        if not is_resolved:
            fastest = min(within.high, FASTER * alone.alone(LEAST_TRANSPORT).speed_m_s)
            lines = states_needed(at, [fastest], lines)
    except NoSpeed as error:
        raise UpwashError(str(error)) from error
    depth = max((row_of(size, shape) for size in sizes if size > 1), default=0)
    sought = SpeedSearch(at, within, lines, limited, depth=depth)
    rows: list[dict[str, Any]] = []
    for criterion in CRITERIA:
        told_of = _Rows(sought, criterion, shape, sought.alone(criterion), labels)
        rows += [told_of.alone_row()] if 1 in sizes else []
        rows += [told_of.follower()] if any(size > 1 for size in sizes) else []
        for size in (size for size in sizes if size > 1):
            rows += [] if turns_alone else [told_of.without_turns(size)]
            rows.append(told_of.with_turns(size))
    return pd.DataFrame(rows, columns=[one.name for one in SPEEDS])


@dataclass(frozen=True)
class _Rows:
    """Makes the rows of one criterion."""

    sought: SpeedSearch
    criterion: str
    shape: str
    alone: BestSpeed
    labels: dict[str, Any]

    def alone_row(self) -> dict[str, Any]:
        return self._row(1, ALONE, False, self.alone, self.alone.power_w)

    def follower(self) -> dict[str, Any]:
        """Return the row of a bird behind one other, whose power alone counts."""
        return self._sought(2, FOLLOWER, 1, lambda line: self.sought.lines.powers_w(line)[1])

    def with_turns(self, birds: int) -> dict[str, Any]:
        """Return the row of a flock whose mean power counts."""
        return self._sought(birds, FLOCK, row_of(birds, self.shape), partial(self._mean_w, birds))

    def without_turns(self, birds: int) -> dict[str, Any]:
        """Return the row of a flock whose first bird is alone, and sets the speed and the range."""
        depth = row_of(birds, self.shape)
        flock = self.sought.lines.proved(self.alone.line.bird, depth, self.sought.search)
        best = replace(self.alone, line=line_of(flock), flock=flock)
        if best.line.cut(depth) is None:
            return self._none(birds, FLOCK, False, flock.members[-1].error)
        return self._row(birds, FLOCK, False, best, self._mean_w(birds, best.line))

    def _mean_w(self, birds: int, line: Line) -> float:
        return self.sought.lines.flock_power_w(line, birds, self.shape)

    def _sought(self, birds: int, who: str, depth: int, share: Callable[[Line], float]) -> dict[str, Any]:
        try:
            best = self.sought.best(self.criterion, share, depth)
        except NoSpeed as error:
            return self._none(birds, who, who == FLOCK, str(error))
        # A follower's pair is one line, whatever the flocks' shape.
        mean_w = (
            self._mean_w(birds, best.line) if who == FLOCK else sum(self.sought.lines.powers_w(best.line)) / 2
        )
        return self._row(birds, who, who == FLOCK, best, mean_w)

    def _same(self, birds: int, who: str, turns: bool) -> dict[str, Any]:
        lines, bird = self.sought.lines, self.alone.line.bird
        return {
            **self.labels,
            "objective": lines.objective,
            "model": lines.model.name(bird.wavelength_m / bird.semispan_m),
            **told({"span_law": lines.model.span_law}),
            "criterion": self.criterion,
            "birds": birds,
            "who": who,
            "turns": turns,
        }

    def _none(self, birds: int, who: str, turns: bool, error: str) -> dict[str, Any]:
        return self._same(birds, who, turns) | {"bound": "", "proved": False, "error": error}

    def _row(self, birds: int, who: str, turns: bool, best: BestSpeed, mean_w: float) -> dict[str, Any]:
        bird = best.line.bird
        transport, of_alone = best.power_w / bird.speed_m_s, self.alone.power_w / self.alone.speed_m_s
        found = self._same(birds, who, turns) | {
            "speed_m_s": bird.speed_m_s,
            "speed_ratio": bird.speed_m_s / self.alone.speed_m_s,
            "power_w": best.power_w,
            "power_mean_w": mean_w,
            "transport_j_m": transport,
            "range_ratio": of_alone / transport,
            "saving": 1.0 - best.power_w / self.sought.lines.power_w(bird, bird.stroke),
            "slope": best.slope,
            "bound": best.bound,
            "proved": best.is_proved,
            "error": "",
        }
        for place in best.line.poses[:1]:
            found |= {name: getattr(place, name) for name in ("x_m", "y_m", "z_m", "phase")}
            found |= {
                "amplitude_m": place.stroke.amplitude_m,
                "upstroke_span_ratio": place.stroke.span_ratio,
            }
        return found
