"""What species are compared by: inputs and optima free of units, as columns with a meaning.

Positions are in semispans, wavelengths and amplitudes, savings and changes of the stroke fractions, and the
bird is its four dimensionless groups, on which alone a force-optimal pair depends.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from upwash import columns as of
from upwash.columns import Column

COMPARED = "comparison of species"
"""The list of quantities in which species are compared for people."""

_group = partial(Column, unit="1", format=".3f")
_position = partial(Column, unit="1", format=".3f")
_share = partial(Column, unit="1", format=".1f", percent=True)

GROUPS = (
    _group(
        "weight_number",
        description="W/(rho b^2 U^2), twice the lift coefficient over the aspect ratio",
        head="W/(ρ b² U²)",
    ),
    _group("wavelength_number", description="lambda/b, wavelength of the wake in semispans", head="λ/b"),
    _group("amplitude_number", description="h_L/b, leader's amplitude in semispans", head="h_L/b"),
    _group(
        "leader_upstroke_span_ratio",
        description="R_L, leader's upstroke span over downstroke span",
        head="R_L",
    ),
)
"""The four groups on which a force-optimal pair depends."""

POSITION = (
    _position(
        "x_wavelengths",
        description="follower downstream of its leader, in wavelengths",
        head="x/λ",
        listed=(COMPARED,),
    ),
    _position(
        "x_semispans",
        description="follower downstream of its leader, in semispans",
        head="x/b",
        format=".2f",
        listed=(COMPARED,),
    ),
    _position(
        "y_semispans",
        description="follower right of its leader, in semispans",
        head="y/b",
        listed=(COMPARED,),
    ),
    _position(
        "tip_spacing_semispans", description="gap between the two wingtips, in semispans; overlap negative"
    ),
    _position("z_semispans", description="follower above its leader, in semispans", head="z/b"),
    _position(
        "z_amplitudes",
        description="follower above its leader, in the leader's amplitudes",
        head="z/h_L",
        listed=(COMPARED,),
    ),
    of.column("phase"),
    _position(
        "path_phase", description="lag behind the path of the leader's wingtip, in wingbeats; 0 retraces it"
    ),
)

SAVING = (
    *(
        replace(of.column(f"saving_{part}"), format=".1f", listed=(COMPARED,))
        for part in ("total", "induced", "profile")
    ),
    _share("profile_share", description="share of the power saved that is profile power"),
    _share("saving_cost", description="share of the leader's cost saved, the cost being the objective's"),
)

STROKE = (
    _share(
        "amplitude_reduction",
        description="1 - h_F/h_L, by how much less far the follower flaps",
        head="amplitude less by",
        listed=(COMPARED,),
    ),
    _share(
        "span_ratio_reduction",
        description="1 - R_F/R_L, by how much more the follower flexes its wing on the upstroke",
        head="span ratio less by",
        listed=(COMPARED,),
    ),
)

GAP = (
    replace(
        of.column("v_gap"),
        description="cost of the V optimum over that of the best optimum found, less 1",
        listed=(COMPARED,),
    ),
)

QUANTITIES = (*POSITION, *SAVING, *STROKE, *GAP)
"""What a V optimum is compared by; each can have an uncertainty interval."""

ALIKE = 1e-3
"""Optima in a V whose costs differ by no more than this, as a fraction, are alike to a bird that minds the cost."""

# What is true of the job and not of one of its optima.
OF_THE_JOB = tuple(
    column.name
    for column in of.belonging(of.OUTCOME, of.PROBLEM, of.SEARCH, of.PROOF)
    if column.name not in ("job_id", *of.names(GROUPS))
)


def with_groups(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows of results with the bird's dimensionless groups beside them.

    Parameters
    ----------
    rows : DataFrame
        Any rows with the inputs of jobs, in SI units, solved or not.

    Returns
    -------
    DataFrame
        The rows and the columns of `GROUPS`.
    """
    semispan = rows["semispan_m"]
    weight = rows["mass_kg"] * rows["gravity_m_s2"]
    # A copy is in one piece, which frames that were put together are not.
    return rows.copy().assign(
        weight_number=weight / (rows["density_kg_m3"] * semispan**2 * rows["speed_m_s"] ** 2),
        wavelength_number=rows["speed_m_s"] * rows["period_s"] / semispan,
        amplitude_number=rows["leader_amplitude_m"] / semispan,
    )


def with_quantities(rows: pd.DataFrame) -> pd.DataFrame:
    """Return rows of optima with their positions, savings and changes of the stroke free of units.

    Parameters
    ----------
    rows : DataFrame
        Rows of results. A row without an optimum gets NaN.

    Returns
    -------
    DataFrame
        The rows and the columns of `GROUPS` and of `QUANTITIES` but `v_gap`, which needs all of a job's rows.
    """
    scaled = with_groups(rows)
    # Of the bird ahead, which is like its follower where nothing else is told.
    period, height = rows["period_s"], rows["leader_amplitude_m"]
    if "ahead_species" in rows:
        is_other = rows["ahead_species"].notna()
        period = rows["ahead_period_s"].astype(float).where(is_other, period)
        height = rows["ahead_amplitude_m"].astype(float).where(is_other, height)
    semispan, wavelength = rows["semispan_m"], rows["speed_m_s"] * period
    x, y, z = (rows[name].astype(float) for name in ("x_m", "y_m", "z_m"))
    saved = rows["leader_power_total_w"] - rows["power_total_w"]
    scaled["x_wavelengths"] = x / wavelength
    scaled["x_semispans"] = x / semispan
    scaled["y_semispans"] = y / semispan
    scaled["tip_spacing_semispans"] = y / semispan - 2.0
    scaled["z_semispans"] = z / semispan
    scaled["z_amplitudes"] = z / height
    # The leader's wingtip was here x/lambda wingbeats ago.
    scaled["path_phase"] = np.mod(rows["phase"].astype(float) - x / wavelength + 0.5, 1.0) - 0.5
    scaled["profile_share"] = (rows["leader_power_profile_w"] - rows["power_profile_w"]) / saved
    scaled["saving_cost"] = 1.0 - rows["cost"] / rows["cost_leader"]
    scaled["amplitude_reduction"] = 1.0 - rows["amplitude_m"] / rows["leader_amplitude_m"]
    scaled["span_ratio_reduction"] = 1.0 - rows["upstroke_span_ratio"] / rows["leader_upstroke_span_ratio"]
    return scaled


def optima_of_jobs(rows: pd.DataFrame) -> pd.DataFrame:
    """Return one row a job: its V optimum by `QUANTITIES`, and what its best optimum is.

    Parameters
    ----------
    rows : DataFrame
        All rows of some jobs, as in ``solutions.parquet``.

    Returns
    -------
    DataFrame
        By job id: the job's inputs and outcome, `GROUPS`, `QUANTITIES` (NaN without a V optimum), ``has_v``,
        ``v_gap_bound`` (the V optimum's cost over what is proved to be the least, less 1), ``v_alike`` (how many
        optima in a V cost the same to within `ALIKE`) with the least and largest ``saving_total`` among them,
        and of the best optimum found placement, tier, station, position and saving, with the prefix ``best_``.
    """
    from upwash.optimum.record import V_LABELS

    scaled = with_quantities(rows)
    best = scaled.sort_values(["job_id", "rank"]).drop_duplicates("job_id").set_index("job_id")
    in_v = scaled[scaled["is_v_optimum"].eq(True)].set_index("job_id").reindex(best.index)
    optima = best[[*OF_THE_JOB, *(column.name for column in GROUPS)]].copy()
    for column in QUANTITIES:
        if column.name != "v_gap":
            optima[column.name] = in_v[column.name].astype(float)
    optima["v_gap"] = in_v["cost"] / best["cost"] - 1.0
    optima["v_gap_bound"] = in_v["cost"] / best["global_lower_bound"] - 1.0
    optima["has_v"] = in_v["cost"].notna()
    is_in_v = (scaled[["placement", "tier", "station"]] == list(V_LABELS)).all(axis=1)
    cost_of_v = scaled["job_id"].map(in_v["cost"])
    alike = scaled[is_in_v & (scaled["cost"] <= (1.0 + ALIKE) * cost_of_v)].groupby("job_id")["saving_total"]
    optima["v_alike"] = alike.size().reindex(optima.index, fill_value=0)
    optima["v_alike_saving_low"] = alike.min().reindex(optima.index)
    optima["v_alike_saving_high"] = alike.max().reindex(optima.index)
    for name in ("placement", "tier", "station", "x_semispans", "y_semispans", "z_semispans", "saving_total"):
        optima[f"best_{name}"] = best[name]
    return optima
