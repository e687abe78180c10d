"""What branch and bound has shown of a job, and what that claims: three claims, each in one word and in a sentence.

- Of the V region: no V formation costs less than the bound.
- Of the V optimum: it is the best of all local optima in the V region.  That does not follow from the first where the
  region's best place lies on one of its walls, which is where no bird is held by anything but our word for a V.
- Of the global optimum: no follower at all costs less.

Which of them is proved follows from bounds, gaps and the tolerance asked for, and is not stored beside them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from upwash.aero.power import COST_FUNCTIONS
from upwash.columns import Row

PROVED, OPEN, NOT_CLAIMED = "proved", "open", "not claimed"

ROUNDING = 1e-6
"""Share of the tolerance by which a proved gap may exceed it: the division of two costs rounds."""

COST_ROUNDING = 1e-11
"""By how much the costs of two solves of one optimum may differ, as a fraction; a gap is not known more closely."""

FINEST = 1e-8
"""Least tolerance to which a proof is sure to close with work enough: finer ones come near its margin."""

WALLS = {
    "x_lower": "as close behind its leader as still counts as astern, one semispan",
    "y_lower": "as close to its leader's side as still counts as outboard, one semispan",
    "z_lower": "as far below its leader as still counts as level, half an amplitude",
    "z_upper": "as far above its leader as still counts as level, half an amplitude",
}
"""The walls of the V region, by variable and side, as places of a follower."""


@dataclass(frozen=True)
class Proof:
    """What branch and bound has shown of a job, in the unit of its cost.

    Attributes
    ----------
    v_lower_bound, global_lower_bound : float
        Costs below which no V formation, and no follower at all, can fly; infinite if none can.  The second is None
        if it was not asked for, and 0 if no follower was found either.
    v_region_certified_gap : float or None
        Cost of the best place known in the V region over its bound, less 1; None if none is known.
    v_certified_gap, global_certified_gap : float or None
        Cost of the best optimum found over the bound, less 1; None if there is no such optimum or no bound.
    certificate_boxes : int
        Boxes examined.
    v_wall : str
        Walls of the V region on which its best place lies when that is no optimum, comma separated, as in `WALLS`.
    feasible : bool
        Whether a balanced follower was found.
    tolerance : float
        Gap to which it was to be proved.
    """

    v_lower_bound: float
    v_region_certified_gap: float | None
    v_certified_gap: float | None
    global_lower_bound: float | None
    global_certified_gap: float | None
    certificate_boxes: int
    v_wall: str
    feasible: bool
    tolerance: float

    def columns(self) -> Row:
        """Return the columns of the results that tell the proof; the tolerance is one of the job."""
        return {name: value for name, value in asdict(self).items() if name != "tolerance"}

    @property
    def claims(self) -> Claims:
        """What is claimed, each in a word."""
        return claims_of(asdict(self))

    @property
    def is_closed(self) -> bool:
        """Whether nothing that is claimed is open."""
        return OPEN not in (self.claims.v_region, self.claims.v_optimum, self.claims.everywhere)


@dataclass(frozen=True)
class Claims:
    """Three claims, each `PROVED`, `OPEN` or `NOT_CLAIMED`.

    Attributes
    ----------
    v_region : str
        No V formation costs less than the bound, or none can fly.
    v_optimum : str
        The V optimum is the best of all local optima in the V region.
    everywhere : str
        No follower at all costs less than the global optimum, or none can fly.
    """

    v_region: str
    v_optimum: str
    everywhere: str


def is_proved(gap: float | None, tolerance: float) -> bool:
    """Whether a gap is as small as was asked for, but for the rounding of costs."""
    return gap is not None and gap <= tolerance * (1.0 + ROUNDING) + COST_ROUNDING


def claims_of(row: Mapping[Any, Any]) -> Claims:
    """Return the three claims of a job.

    Parameters
    ----------
    row : mapping
        The columns of its proof and its tolerance, as in any of its rows; what is absent is None or NaN.

    Returns
    -------
    Claims
        The claims.

    Examples
    --------
    >>> solved = {"tolerance": 1e-4, "certificate_boxes": 65724, "feasible": True, "v_wall": ""}
    >>> gaps = {"v_region_certified_gap": 1e-4, "v_certified_gap": 2e-3, "global_certified_gap": 1e-4}
    >>> claims_of(solved | gaps | {"v_lower_bound": 11.97, "global_lower_bound": 11.93})
    Claims(v_region='proved', v_optimum='open', everywhere='proved')
    """
    if _is_absent(row["certificate_boxes"]):
        return Claims(NOT_CLAIMED, NOT_CLAIMED, NOT_CLAIMED)
    tolerance = row["tolerance"]

    def of(gap: float | None) -> str:
        return PROVED if is_proved(gap, tolerance) else OPEN

    # A bound that is absent where there is a proof is infinite: no such follower balances.
    v_region = PROVED if _is_absent(row["v_lower_bound"]) else of(row["v_region_certified_gap"])
    v_optimum = NOT_CLAIMED if _is_absent(row["v_certified_gap"]) else of(row["v_certified_gap"])
    everywhere = of(row["global_certified_gap"])
    if _is_absent(row["global_lower_bound"]):
        everywhere = NOT_CLAIMED if row["feasible"] else PROVED
    return Claims(v_region, v_optimum, everywhere)


def claims_in_words(row: Mapping[Any, Any]) -> tuple[str, str, str]:
    """Say the three claims of a job, each in a sentence.

    Parameters
    ----------
    row : mapping
        As for `claims_of`, with the job's objective.

    Returns
    -------
    tuple of three str
        Of the V region, of the V optimum, and of all followers.
    """
    claims = claims_of(row)
    unit = COST_FUNCTIONS[row["objective"]].unit
    region = _bound_in_words(
        "V formation", claims.v_region, row, "v_lower_bound", "v_region_certified_gap", unit
    )
    whole = _bound_in_words(
        "follower at all", claims.everywhere, row, "global_lower_bound", "global_certified_gap", unit
    )
    return region, _v_optimum_in_words(claims, row), whole


def _bound_in_words(what: str, claim: str, row: Mapping[Any, Any], bound: str, gap: str, unit: str) -> str:
    if claim == NOT_CLAIMED:
        return f"Nothing is claimed of what any {what.removesuffix(' at all')} costs at least."
    if _is_absent(row[bound]):
        return f"Proved: no {what} can fly here, lift and thrust balance nowhere."
    least = f"no {what} costs less than {row[bound]:.6g} {unit}"
    if claim == PROVED:
        return f"Proved: {least}, and one is known that costs {percent(row[gap])} more."
    known = (
        "none that can fly is known"
        if _is_absent(row[gap])
        else f"the best known costs {percent(row[gap])} more"
    )
    return f"Open: {least}, but {known}{_too_fine(row)}."


def _v_optimum_in_words(claims: Claims, row: Mapping[Any, Any]) -> str:
    on_wall = ""
    if row["v_wall"]:
        on_wall = f": a follower in the V does best {wall_in_words(row['v_wall'])}, and better still beyond"
    if claims.v_optimum == NOT_CLAIMED:
        return f"There is no V optimum to claim anything of{on_wall}."
    if claims.v_optimum == PROVED:
        return "Proved: the V optimum is the best of all local optima in the V, to " + (
            f"{percent(row['v_certified_gap'])}."
        )
    least = (
        f"another optimum in the V may cost up to {percent(row['v_certified_gap'])} less than the V optimum"
    )
    return f"Open: {least}{on_wall}{_too_fine(row)}."


def _too_fine(row: Mapping[Any, Any]) -> str:
    """Say of an open claim that it was to be proved more closely than a proof is sure to tell."""
    if row["tolerance"] >= FINEST:
        return ""
    return f"; {row['tolerance']:.1e} was asked for, and to less than {FINEST:.0e} rounding may keep a proof open"


def wall_in_words(v_wall: str) -> str:
    """Say where a follower on walls of the V region flies.

    Examples
    --------
    >>> wall_in_words("y_lower")
    "as close to its leader's side as still counts as outboard, one semispan"
    """
    return ", and ".join(WALLS[wall] for wall in v_wall.split(","))


def percent(fraction: float) -> str:
    """Write a small fraction as a percentage of two digits.

    Examples
    --------
    >>> percent(1e-4), percent(0.0123)
    ('0.01 %', '1.2 %')
    """
    return f"{100.0 * fraction:.2g} %"


def _is_absent(value: Any) -> bool:
    """Whether a number is not there: bounds are infinite in memory, None in Parquet and NaN in a frame."""
    return value is None or (isinstance(value, float) and not math.isfinite(value))
