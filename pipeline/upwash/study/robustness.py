"""What is left of the best place's saving while a bird drifts, and the place that leaves most."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from upwash.aero.bird import Bird
from upwash.aero.wake import WakeModel
from upwash.columns import TEXT, Column, column, told
from upwash.optimum.pair import solve_pair
from upwash.optimum.settings import SearchSettings
from upwash.place.balance import Behind
from upwash.place.robust import Jittering, Spread
from upwash.place.tolerance import tolerance

V_FORMATION, ANYWHERE = "V", "anywhere"
"""Where the best place is sought: where the still optimum lies."""

_SIDES = {
    "x": ("nearer", "farther"),
    "y": ("inward", "outward"),
    "z": ("below", "above"),
    "phase": ("earlier", "later"),
}
_WIDTHS = tuple(
    (axis, side, f"half_width_{'phase' if axis == 'phase' else f'{axis}_m'}_{side}")
    for axis, sides in _SIDES.items()
    for side in sides
)

ROBUSTNESS = (
    column("species"),
    column("objective"),
    column("model"),
    column("span_law"),
    Column(
        "region",
        "",
        f"where the places are sought: in the {V_FORMATION}, or {ANYWHERE} if it has no optimum",
        TEXT,
    ),
    Column("sigma_ratio", "1", "standard deviation of the place in x, y and z, in semispans", format=".3g"),
    Column("sigma_m", "m", "the same in metres", format=".3g"),
    Column("sigma_phase", "1", "standard deviation of the phase, in wingbeats", format=".3g"),
    *(column(name) for name in ("x_m", "y_m", "z_m", "phase")),
    Column(
        "saving_still", "1", "saving of total power at the still optimum, at rest", percent=True, format=".1f"
    ),
    Column(
        "saving_held",
        "1",
        "saving there while the place jitters, with one stroke that balances in the mean; absent if none does",
        percent=True,
        format=".1f",
    ),
    Column(
        "saving_retrimmed",
        "1",
        "mean saving there with the stroke trimmed anew at each place, of those at which one balances",
        percent=True,
        format=".1f",
    ),
    Column("balanced_share", "1", "share of these places at which some stroke balances"),
    *(
        Column(
            f"robust_{name}",
            unit,
            f"{words} of the place that leaves most to one stroke; absent if none is found",
        )
        for name, unit, words in (
            ("x_m", "m", "x"),
            ("y_m", "m", "y"),
            ("z_m", "m", "z"),
            ("phase", "1", "phase"),
            ("amplitude_m", "m", "amplitude"),
            ("upstroke_span_ratio", "1", "upstroke span ratio"),
        )
    ),
    Column("robust_saving_held", "1", "saving that it leaves to one stroke", percent=True, format=".1f"),
    Column(
        "robust_saving_retrimmed", "1", "the same with the stroke trimmed anew", percent=True, format=".1f"
    ),
    *(
        Column(
            name,
            "1" if axis == "phase" else "m",
            f"how far {side} the saving at the still optimum falls to half; absent if it does not",
        )
        for axis, side, name in _WIDTHS
    ),
    Column("fold_m", "m", "least distance along x, y or z at which its stroke, followed, balances no more"),
)
"""Columns of `robustness`, one row for each deviation."""


def robustness(
    bird: Bird,
    objective: str = "power",
    *,
    model: WakeModel | None = None,
    sigmas_m: Sequence[float] = (),
    sigma_phase: float = 0.0,
    search: SearchSettings | None = None,
    species: str = "",
) -> pd.DataFrame:
    """Return what is left of the best place's saving while the place jitters, and the place that leaves most.

    Parameters
    ----------
    bird : Bird
        Leader and follower, flying alone.
    objective : str
        Name of a cost function.
    model : WakeModel, optional
        The wake; the paper's if not given.
    sigmas_m : sequence of float
        Standard deviations of the place in x, y and z, in m.
    sigma_phase : float
        Standard deviation of the phase, in wingbeats.
    search : SearchSettings, optional
        Of the still optimum.
    species : str
        What the rows are said to be of.

    Returns
    -------
    DataFrame
        The columns of `ROBUSTNESS`; no row if no follower can fly.

    Raises
    ------
    ValueError
        If an input is out of range.
    """
    model = model or WakeModel()
    solution = solve_pair(bird, objective, model=model, search=search)
    names = [one.name for one in ROBUSTNESS]
    still = solution.v_optimum or solution.global_optimum
    if still is None:
        return pd.DataFrame(columns=names)
    pose, behind = still.pose, Behind(bird, objective, model=model)
    reach = tolerance(behind, pose)
    widths = np.array([*reach.half_width_m, reach.half_width_phase]).ravel()
    b = bird.semispan_m
    same = {
        "species": species,
        "objective": objective,
        "model": model.name(bird.wavelength_m / b),
        "region": V_FORMATION if solution.v_optimum else ANYWHERE,
        **told({"span_law": model.span_law}),
        **{name: getattr(still, name) for name in ("x_m", "y_m", "z_m", "phase")},
        "saving_still": still.saving_total,
        **{name: _finite(value) for (_, _, name), value in zip(_WIDTHS, widths, strict=True)},
        "fold_m": _finite(reach.fold_m),
        "sigma_phase": sigma_phase,
    }
    rows = []
    for sigma_m in sigmas_m:
        jittering = Jittering(behind, Spread.of_place(sigma_m, sigma_phase))
        there = jittering.remaining(pose)
        best = jittering.best([pose], in_v=solution.v_optimum is not None)
        row = same | {
            "sigma_ratio": sigma_m / b,
            "sigma_m": sigma_m,
            "saving_held": there.saving_held,
            "saving_retrimmed": there.saving_retrimmed,
            "balanced_share": there.balanced_share,
        }
        if best is not None and best.pose is not None:
            place, stroke = best.pose, best.pose.stroke
            row |= {f"robust_{name}": getattr(place, name) for name in ("x_m", "y_m", "z_m", "phase")}
            row |= {
                "robust_amplitude_m": stroke.amplitude_m,
                "robust_upstroke_span_ratio": stroke.span_ratio,
                "robust_saving_held": best.saving_held,
                "robust_saving_retrimmed": best.saving_retrimmed,
            }
        rows.append(row)
    return pd.DataFrame(rows, columns=names)


def _finite(value: float) -> float:
    return float(value) if np.isfinite(value) else np.nan
