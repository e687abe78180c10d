"""Studies as the batch layer leaves them, for figures and pages: an ibis, its flock, other birds, inputs varied.

No search is run. The optima are those of the paper's ibis to a few digits; what follows from them is computed by
the plain statement of the physics. Other birds are the ibis with lengths stretched and the same shares saved.
"""

from dataclasses import replace
from hashlib import sha256
from itertools import product

import numpy as np
import pandas as pd
import pyarrow as pa
from upwash import columns as of
from upwash.aero.bird import Bird
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import WakeModel
from upwash.batch.folder import Plan, ResultsFolder
from upwash.batch.store import TableWriter, provenance
from upwash.jobs.kinds import KINDS
from upwash.jobs.schema import table_of
from upwash.journey.speed import CRITERIA
from upwash.optimum.record import record
from upwash.study import drift, limit_ranges
from upwash.study.best_speed import SPEEDS
from upwash.study.drift import SIGMAS_M
from upwash.study.migration import MIGRATION
from upwash.study.phase_rule import CURVE, IN_LINE, V, phase_rule, wrapped
from upwash.study.robustness import ROBUSTNESS, V_FORMATION

PAPER = WakeModel()

IBIS = {
    "mass_kg": 1.3,
    "semispan_m": 0.6,
    "speed_m_s": 15.0,
    "period_s": 0.25,
    "density_kg_m3": 1.29,
    "gravity_m_s2": 9.8,
    "leader_amplitude_m": 1.0392304845413263,
    "leader_upstroke_span_ratio": 0.4,
    "circulation_ratio": 1.0,
    "amplitude_convention": "stroke-angle",
    **vars(WakeModel()),
    "model": "paper",
    "seed": 0,
    "tolerance": 1e-4,
    "solver": "upwash",
}

# x, y, z in m, amplitude in m, upstroke span ratio, phase; the V optimum is the second of each.
OPTIMA = {
    "force": [
        (1.816666, 0.319567, -0.052438, 0.765548, 0.344774, 0.5),
        (1.817833, 0.879798, -0.061520, 0.745795, 0.349295, 0.5),
        (1.931801, 0.879596, 0.816972, 0.765598, 0.348535, 0.0),
        (0.0, 0.496267, 0.040658, 0.915346, 0.344791, 0.0),
    ],
    "power": [
        (2.212556, 0.026169, 0.029339, 0.720891, 0.419788, 0.5),
        (1.776509, 0.888574, -0.145865, 0.690013, 0.368373, 0.5),
        (1.973497, 0.888570, 0.843600, 0.705420, 0.368021, 0.0),
    ],
}
OTHERS = {"mute-swan": 1.9, "dunlin": 0.3}
"""Other species: their lengths over the ibis's."""


def bird_of(inputs):
    """Return the bird of a row's inputs."""
    names = ("mass_kg", "semispan_m", "speed_m_s", "period_s", "density_kg_m3", "gravity_m_s2")
    stroke = inputs["leader_amplitude_m"], inputs["leader_upstroke_span_ratio"]
    return Bird(*(inputs[name] for name in names), *stroke, inputs["circulation_ratio"])


def row_of(species, objective, inputs, place, rank, kind="pair", ahead=None, model=PAPER):
    """Return one row of results; `ahead` is how the bird ahead flaps, as the bird does alone if not given."""
    x, y, z, amplitude, ratio, phase = place
    pose = Pose(x, y, z, Stroke(amplitude, ratio), phase)
    bird = bird_of(inputs)
    labels = (
        f"{species} {objective} {inputs['amplitude_convention']} {inputs['speed_m_s']} {inputs['mass_kg']}"
    )
    return {
        **inputs,
        "job_id": id_of(labels),
        "species": species,
        "objective": objective,
        "status": of.SOLVED,
        "kind": kind,
        **vars(record(bird, objective, ahead or bird.stroke, pose, model)),
        # The optima are known to a few digits.
        "residual_lift": 0.0,
        "residual_thrust": 0.0,
        "rank": rank,
        "hits": 3,
        "starts": 180,
        "is_v_optimum": rank == 1,
        "is_global_optimum": rank == 0,
        "active_bounds": "mu_lower",
        "core_edges": "left/down/right tip/upstroke/up",
        "stationarity": 1e-13,
        "solve_time_s": 0.5,
        "v_region_certified_gap": 1e-4,
        "v_certified_gap": 1e-4,
        "v_lower_bound": 11.9,
        "global_lower_bound": 11.9,
        "global_certified_gap": 1e-4,
        "v_wall": "",
        "feasible": True,
        "certificate_boxes": 1000,
    }


def id_of(text):
    """Return a job's id: the same for a text on every run."""
    return sha256(text.encode()).hexdigest()[:16]


def pair_rows(species="northern-bald-ibis", stretch=1.0, **changes):
    """Return all optima of a bird for both objectives, its lengths stretched and its inputs changed."""
    inputs = IBIS | {name: IBIS[name] * stretch for name in ("semispan_m", "leader_amplitude_m")}
    inputs |= {"period_s": IBIS["period_s"] * stretch, **changes}
    rows = []
    for objective, places in OPTIMA.items():
        for rank, (*lengths, ratio, phase) in enumerate(places):
            rows.append(
                row_of(species, objective, inputs, (*(one * stretch for one in lengths), ratio, phase), rank)
            )
    return rows


# As OPTIMA, in the limit, by span law: the best of each objective, and whether that is a V optimum.
LIMIT_OPTIMA = {
    ("force", "stroke"): ((1.875, 0.42521, -0.0079, 1.0316, 0.3837, 0.4875), False),
    ("force", "tip"): ((1.875, 0.5706, 0.0, 1.0, 0.389, 0.481), False),
    ("power", "stroke"): ((1.875, 1.08462, 0.0, 0.97877, 0.40565, 0.5), True),
    ("power", "tip"): ((1.875, 0.82532, -0.01848, 0.95473, 0.39794, 0.52891), True),
}


def limit_rows(species="northern-bald-ibis", **changes):
    """Return the best of a bird in the limit for both objectives, by both span laws."""
    rows = []
    for (objective, law), (place, is_v) in LIMIT_OPTIMA.items():
        model = replace(WakeModel.named("limit"), span_law=law)
        # As a file holds it: no number of points is the whole span.
        inputs = IBIS | vars(model) | {"span_nodes": None, "model": model.name(6.25)} | changes
        row = row_of(species, objective, inputs, place, 0, model=model)
        rows.append(row | {"job_id": id_of(f"limit {species} {objective} {law}"), "is_v_optimum": is_v})
    return rows


def refinement_rows():
    """Return a pair's optima as the model is refined; with eight points of the span there is no V."""
    rows = limit_rows()
    for states, nodes, length in product((2, 4, 8), (2, 4, 8), (1, 2, 4)):
        model = {"stroke_states": states, "span_nodes": nodes, "wavelengths": length, "model": "given"}
        rows += [
            row
            | {"job_id": id_of(f"{states} {nodes} {length} {row['objective']}")}
            | {"saving_total": saving}
            for row in pair_rows(**model)
            for saving in [0.3 / states + 0.1 / nodes - 0.01 * length - 0.01 * row["rank"]]
            if not (nodes == 8 and row["is_v_optimum"])
        ]
    return rows


def species_rows():
    """Return three species under two conventions; under the second, one of them cannot fly so."""
    rows = []
    for convention in ("stroke-angle", "strouhal"):
        for species, stretch in {"northern-bald-ibis": 1.0, **OTHERS}.items():
            of_it = pair_rows(species, stretch, mass_kg=1.3 * stretch**2, amplitude_convention=convention)
            if (species, convention) == ("dunlin", "strouhal"):
                kept = ("job_id", "species", "objective", "kind", *IBIS)
                firsts = {row["objective"]: row for row in of_it if row["rank"] == 0}
                of_it = [{name: row[name] for name in kept} | IMPOSSIBLE for row in firsts.values()]
            rows += of_it
    return rows


IMPOSSIBLE = {"status": of.INFEASIBLE, "error": "amplitude_m: expected at most twice the semispan"}


def varied_rows():
    """Return the ibis and birds that differ in one input; the lightest has no V optimum."""
    rows = pair_rows()
    for name, values in {"mass_kg": (1.1, 1.2, 1.4), "speed_m_s": (14.0, 16.0)}.items():
        for value in values:
            rows += pair_rows(**{name: value})
    return [row | {"is_v_optimum": row["is_v_optimum"] and row["mass_kg"] != 1.1} for row in rows]


def flock_rows(birds=6):
    """Return flocks of both objectives and readings: a chain in which every step is the pair's V optimum."""
    rows = []
    for objective, places in OPTIMA.items():
        x, y, z, _, _, phase = places[1]
        for reading in ("immediate", "lone"):
            ahead = None
            flock = {"birds": birds, "shape": "echelon", "wake": "neighbour", "reading": reading}
            job_id = id_of(objective + reading)
            for number in range(1, birds + 1):
                leads = number == 1
                own = (0.0, 0.0, 0.0, IBIS["leader_amplitude_m"], 0.4, 0.0) if leads else places[1]
                row = row_of("northern-bald-ibis", objective, IBIS, own, 1, "flock", ahead)
                step = number - 1
                rows.append(
                    row
                    | flock
                    | {
                        "job_id": job_id,
                        "flock_id": job_id,
                        "bird": number,
                        "leader": None if leads else number - 1,
                    }
                    | {"x_flock_m": x * step, "y_flock_m": y * step, "z_flock_m": z * step}
                    | {"phase_flock": phase * step % 1.0}
                    | ({"ahead_amplitude_m": ahead.amplitude_m} if ahead else {})
                    | ({"ahead_upstroke_span_ratio": ahead.span_ratio} if ahead else {})
                )
                ahead = Stroke(*own[3:5])
    return rows


def frame(rows, kind="pair"):
    """Return rows as a frame with every column of the results."""
    return table_of(complete(rows, kind), KINDS[kind].rows).to_pandas()


def complete(rows, kind):
    """Return rows with the columns of a kind of study alone."""
    return [{name: row[name] for name in row if name in KINDS[kind].rows.names} for row in rows]


def write_folder(path, rows, kind="pair", text='description = "A study"\n'):
    """Write a gathered results folder as `upwash aggregate` leaves it, and return its path."""
    order = [("job_id", "ascending"), ("bird" if kind == "flock" else "rank", "ascending")]
    table = table_of(complete(rows, kind), KINDS[kind].rows).sort_by(order).combine_chunks()
    path.mkdir(parents=True)
    ids = pd.unique(table.column("job_id").to_pandas())
    ResultsFolder(path).write_plan(Plan(path.name, KINDS[kind], text, list(ids)))
    for name, schema, content in (
        (KINDS[kind].file, KINDS[kind].rows, table),
        ("summary.parquet", KINDS[kind].summary, KINDS[kind].summarise(table)),
    ):
        writer = TableWriter(path / name, schema)
        writer.write(pa.table(content))
        writer.close(provenance(text))
    return path


def phase_frames():
    """Return a phase rule and the phases that were tried, as `upwash.study.phase_rule.phase_rules` does."""
    rows = []
    for formation, best in ((V, 0.0), (IN_LINE, 0.5)):
        for phase in np.arange(12) / 12:
            saving = 0.04 * np.cos(2.0 * np.pi * (0.5 - phase - best)) - (
                0.06 if formation == IN_LINE else 0.0
            )
            flies = saving > -0.09
            numbers = {"amplitude_m": 0.9, "upstroke_span_ratio": 0.4, "saving_cost": saving}
            rows.append(
                {
                    "model": "limit",
                    "span_law": "stroke",
                    "formation": formation,
                    "x_m": 1.875,
                    "x_wavelengths": 0.5,
                }
                | {"y_m": 1.0 if formation == V else 0.0, "z_m": 0.0, "phase": phase}
                | {"spatial_phase": wrapped(0.5 - phase), "missing": "" if flies else "thrust"}
                | {name: value if flies else np.nan for name, value in numbers.items()}
            )
    curve = pd.DataFrame(rows, columns=[column.name for column in CURVE])
    return phase_rule(curve), curve


def drift_frame():
    """Return what is left while a bird drifts, as `upwash.study.robustness.robustness` does."""
    words = {"species": "northern-bald-ibis", "objective": "power", "model": "paper", "span_law": "tip"}
    numbers = {column.name: 0.05 for column in ROBUSTNESS}
    return pd.DataFrame([numbers | words | {"region": V_FORMATION, "half_width_x_m_nearer": np.nan}])


def speed_frame():
    """Return best speeds, as `upwash.study.best_speed.best_speeds` does."""
    words = {"species": "northern-bald-ibis", "objective": "power", "amplitude_convention": "stroke-angle"}
    numbers = {column.name: 0.5 for column in SPEEDS}
    each = [(1, "alone", False), (2, "follower", False), (2, "flock", False), (2, "flock", True)]
    return pd.DataFrame(
        [
            numbers
            | words
            | {"criterion": criterion, "birds": birds, "who": who, "turns": turns, "proved": True}
            | {"bound": "", "error": ""}
            for criterion in CRITERIA
            for birds, who, turns in each
        ]
    )


def flight_frame():
    """Return two flights, as `upwash.study.migration.migrate` does."""
    words = {"species": "northern-bald-ibis", "objective": "power", "amplitude_convention": "stroke-angle"}
    numbers = {column.name: 0.5 for column in MIGRATION}
    return pd.DataFrame(
        [
            numbers
            | words
            | {"birds": birds, "speed_rule": "held", "step": step, "proof": "", "ended": "the fuel is spent"}
            for birds in (1, 2)
            for step in (0, 1)
        ]
    )


def drift_of(rows):
    """Return what is left of the V optima of some rows while birds drift: the less, the farther they do."""
    return pd.DataFrame(
        [
            {name: row[name] for name in ("job_id", "species", "objective", "model", "span_law")}
            | {"sigma_m": sigma, "saving_still": row["saving_total"]}
            | {"saving_held": row["saving_total"] * (1.0 - 4.0 * sigma)}
            for row in rows
            if row["is_v_optimum"]
            for sigma in SIGMAS_M
        ]
    )


def ranges_of(rows):
    """Return what birds within the species' ranges save in the limit, by span law."""
    return pd.DataFrame(
        [
            {name: row[name] for name in ("species", "objective", "span_law")}
            | {
                f"saving_{name}{end}": row["saving_total"] * factor
                for name in ("total", "cost")
                for end, factor in (("", 1.0), ("_low", 0.9), ("_high", 2.0))
            }
            | {"samples": 32, "samples_without": 0}
            for row in rows
            if row["is_v_optimum"]
        ]
    )


def keep_beside(folder, rows, with_ranges=False):
    """Keep what is left of some rows' savings beside them, as `upwash reproduce` does."""
    drift_of(rows).to_parquet(folder / drift.FILE)
    if with_ranges:
        ranges_of(rows).to_parquet(folder / limit_ranges.FILE)
    return folder
