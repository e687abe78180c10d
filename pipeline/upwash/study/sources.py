"""What the figures draw from: the frames that results folders hold, sorted by the kind of study they are."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from upwash import columns as of
from upwash.aero.wake import WakeModel
from upwash.batch.folder import ResultsFolder
from upwash.batch.store import Damaged, metadata_of, read_table
from upwash.errors import UpwashError
from upwash.jobs.bird import BIRD_COLUMNS
from upwash.jobs.flock import Flock
from upwash.jobs.kind import Kind
from upwash.jobs.kinds import KINDS
from upwash.shipped import shipped
from upwash.species.library import LIBRARY_FOLDER, REFERENCE, load_species
from upwash.study.drift import read_drift
from upwash.study.intervals import KEYS
from upwash.study.limit_ranges import read_ranges
from upwash.study.observations import read_observations
from upwash.study.observed.published_savings import read_published_savings
from upwash.study.studies import samples_beside

# What one problem is told from another by, the objective apart.
PROBLEM = tuple(name for name in of.names(of.belonging(of.PROBLEM)) if name != "objective")
NUMBERS = tuple(
    column.name
    for column in of.belonging(of.PROBLEM)
    if column.type == of.FLOAT and column.absent == of.NEVER
)

CLAIMS = "claims.parquet"
"""File of the ledger of the paper's claims, in a results folder."""

PHASE = shipped("results/reference/phase.csv")
"""What the paper's bird saves in every phase, by the columns of `upwash.study.phase_rule.CURVE`."""

# A parameter that is drawn as a line has at least so many values.
LEAST_VALUES = 3


@dataclass(frozen=True)
class Sources:
    """The frames that figures take; None where no folder holds such a study.

    Attributes
    ----------
    pair : DataFrame or None
        All optima of one bird, for each objective that was solved: the bird that the paper's figures show.
    flock : DataFrame or None
        Flocks, one row a bird.
    species : DataFrame or None
        All optima of several species, one problem for each objective and amplitude convention.
    varied : DataFrame or None
        All optima of one bird of which one input at a time is varied (and perhaps others).
    speeds : DataFrame or None
        All optima of least power of one bird at several airspeeds.
    samples : DataFrame or None
        All optima of the same species, their inputs sampled from their ranges.
    limit : DataFrame or None
        All optima of one bird behind an endless wake, for each objective and span law.
    refinement : DataFrame or None
        All optima of one bird as states, points of the span and wavelengths are refined.
    claims : DataFrame or None
        The ledger of the paper's claims.
    drift : DataFrame or None
        What is left at the V optima of one bird while it drifts, by the columns of `upwash.study.drift.DRIFT`.
    ranges : DataFrame or None
        What birds within the species' own ranges save in the limit.
    observations : DataFrame
        What was measured on birds.
    phase : DataFrame
        What the paper's bird saves in every phase, kept with the code.
    observed : DataFrame
        What birds save where they were published to fly, kept with the code.
    folders : dict of str to Path
        Frame -> the folder that it was read from.
    """

    pair: pd.DataFrame | None
    flock: pd.DataFrame | None
    species: pd.DataFrame | None
    varied: pd.DataFrame | None
    speeds: pd.DataFrame | None
    samples: pd.DataFrame | None
    limit: pd.DataFrame | None
    refinement: pd.DataFrame | None
    claims: pd.DataFrame | None
    drift: pd.DataFrame | None
    ranges: pd.DataFrame | None
    observations: pd.DataFrame
    phase: pd.DataFrame
    observed: pd.DataFrame
    folders: dict[str, Path]


@dataclass(frozen=True)
class Study:
    """One gathered results folder: its rows, and the metadata of the file that holds them."""

    path: Path
    kind: type[Kind]
    rows: pd.DataFrame
    metadata: dict[str, str]


def read_study(path: Path) -> Study:
    """Read the gathered rows of a results folder.

    Raises
    ------
    UpwashError
        If there is no such folder, or its jobs have not been gathered.
    """
    kind = next((kind for kind in KINDS.values() if (path / kind.file).exists()), None)
    if kind is None:
        ResultsFolder(path).require()
        expected = " or ".join(kind.file for kind in KINDS.values())
        raise UpwashError(f"{path}: expected {expected}, found neither; gather it: upwash aggregate {path}")
    try:
        table = read_table(path / kind.file, kind.rows)
    except Damaged as error:
        raise UpwashError(
            f"{error}; 'upwash check {path}' says more, running the sweep again fixes it"
        ) from error
    return Study(path, kind, table.to_pandas(), metadata_of(table.schema))


def sort_studies(studies: Iterable[Study]) -> Sources:
    """Find in some studies the frames that figures take.

    The first study that has a frame gives it; of those that vary inputs, the first that varies the most.
    """
    always = ("observations", "phase", "observed", "folders")
    frames: dict[str, pd.DataFrame | None] = {
        field.name: None for field in fields(Sources) if field.name not in always
    }
    folders: dict[str, Path] = {}
    studies = list(studies)
    for study in studies:
        for name, rows in _frames_of(study).items():
            if rows is not None and _is_better(name, rows, frames[name]):
                frames[name], folders[name] = rows, study.path
    frames["drift"] = _drift_of(frames, [study.path for study in studies])
    if frames["drift"] is not None:
        folders["drift"] = folders["pair" if frames["pair"] is not None else "limit"]
    return Sources(
        **frames,
        observations=read_observations(),
        phase=read_phase(),
        observed=read_published_savings(),
        folders=folders,
    )


def _drift_of(frames: dict[str, pd.DataFrame | None], paths: Iterable[Path]) -> pd.DataFrame | None:
    """Return what is left of the jobs that are shown of the pair, in the paper's model and in the limit."""
    kept = [found for path in dict.fromkeys(paths) for found in [read_drift(path)] if found is not None]
    shown = [frame["job_id"] for name in ("pair", "limit") for frame in [frames[name]] if frame is not None]
    if not kept or not shown:
        return None
    rows = pd.concat(kept, ignore_index=True).drop_duplicates(["job_id", "sigma_m"])
    rows = rows[rows["job_id"].isin(pd.concat(shown))]
    return rows.reset_index(drop=True) if len(rows) else None


def read_phase() -> pd.DataFrame:
    """Return what the paper's bird saves in every phase, by the columns of `upwash.study.phase_rule.CURVE`."""
    return pd.read_csv(PHASE).fillna({"missing": ""})


def _frames_of(study: Study) -> dict[str, pd.DataFrame | None]:
    if study.kind is Flock:
        solved = study.rows[study.rows["status"] == of.SOLVED]
        return {"flock": solved if len(solved) else None}
    # What else is drawn is of birds that are alike and beat in step.
    is_usual = study.rows["ahead_species"].isna() & study.rows["phase_lock"].ne(False)
    study = replace(study, rows=study.rows[is_usual])
    # Behind an endless wake distance is free and there are no states: what is drawn of a pair would not be true.
    is_endless = np.isinf(study.rows["wavelengths"].astype(float))
    ledger = study.path / CLAIMS
    return {
        "claims": pd.read_parquet(ledger) if ledger.exists() else None,
        "limit": _limit(study.rows[is_endless]),
        "ranges": read_ranges(study.path),
        "refinement": _refinement(study.rows),
        **_frames_of_ending(replace(study, rows=study.rows[~is_endless])),
    }


def _limit(rows: pd.DataFrame) -> pd.DataFrame | None:
    """Return the rows of one bird in the limit by both span laws, the paper's if it is among them."""
    model, solved = WakeModel.named("limit"), rows[rows["status"] == of.SOLVED]
    same = (solved["core"] == model.core) & (solved["core_radius_ratio"] == model.core_radius_ratio)
    rows = solved[same & (solved["stroke_rule"] == model.stroke_rule) & solved["span_nodes"].isna()]
    if rows.empty:
        return None
    others = rows.assign(is_other=rows["species"] != REFERENCE)
    first = others.sort_values(["is_other", "amplitude_convention"], kind="stable").iloc[0]
    alike = rows["species"] == first["species"]
    for name in BIRD_COLUMNS.values():
        alike &= rows[name] == first[name]
    jobs = rows[alike].drop_duplicates("job_id").drop_duplicates(["objective", "span_law"])
    found = rows[rows["job_id"].isin(jobs["job_id"])]
    in_v = found[found["is_v_optimum"].eq(True) & (found["objective"] == "power")]
    return found if in_v["span_law"].nunique() > 1 else None


# What of a model is refined.
REFINED = ("stroke_states", "span_nodes", "wavelengths")


def _refinement(rows: pd.DataFrame) -> pd.DataFrame | None:
    """Return the optima of one bird if all that makes the paper's model coarse is refined."""
    solved = rows[rows["status"] == of.SOLVED]
    ending = solved[(solved["wavelengths"] < np.inf) & (solved["objective"] == "power")]
    if ending.empty or solved["species"].nunique() > 1 or (ending[list(REFINED)].nunique() < 2).any():
        return None
    return solved


def _frames_of_ending(study: Study) -> dict[str, pd.DataFrame | None]:
    """Return the frames of wakes that end."""
    solved = study.rows[study.rows["status"] == of.SOLVED]
    if solved.empty:
        return {}
    problems = study.rows.drop_duplicates([*PROBLEM, "objective"])
    pair = subject(solved)
    if not problems.duplicated(list(KEYS)).any():
        is_comparison = problems["species"].nunique() > 1
        samples = (
            samples_beside(ResultsFolder(study.path), study.rows, _say_nothing) if is_comparison else None
        )
        return {"pair": pair, "species": study.rows if is_comparison else None, "samples": samples}
    # Of inputs that are sampled all at once no bird stands out that could be shown.
    inputs = varied_inputs(solved, pair)
    return {"pair": pair, "varied": solved, "speeds": _at_speeds(inputs)} if inputs else {}


def _at_speeds(inputs: dict[str, pd.DataFrame]) -> pd.DataFrame | None:
    """Return the optima of least power at several airspeeds, if airspeed is among the inputs that are varied."""
    if "speed_m_s" not in inputs:
        return None
    rows = inputs["speed_m_s"]
    rows = rows[rows["objective"] == "power"]
    return rows if rows["speed_m_s"].nunique() >= LEAST_VALUES else None


def _is_better(name: str, rows: pd.DataFrame, than: pd.DataFrame | None) -> bool:
    """Whether a frame is to be taken in the place of the one that was found before it, if any."""
    if than is None or name != "varied":
        return than is None
    return len(varied_inputs(rows, subject(rows))) > len(varied_inputs(than, subject(than)))


def _say_nothing(_: str) -> None:
    """Pass over what the tables of the same comparison say already."""


def subject(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the one bird that the figures of a pair show.

    The bird with the most objectives solved; among those the paper's northern bald ibis, the one whose
    inputs are its species' own, and then the one whose inputs are the commonest, as they are at the centre
    of a study that varies one at a time.
    """
    problems = rows.drop_duplicates([*PROBLEM, "objective"])
    common = sum((problems[name] == problems[name].mode()[0]).astype(int) for name in NUMBERS)
    ranked = problems.assign(
        objectives=problems.groupby(list(PROBLEM), dropna=False)["objective"].transform("size"),
        is_reference=problems["species"] == REFERENCE,
        own=_own_inputs(problems),
        common=common,
    ).sort_values(["objectives", "is_reference", "own", "common"], ascending=False, kind="stable")
    return rows[_same_problem(rows, ranked.iloc[0])]


def _own_inputs(problems: pd.DataFrame) -> pd.Series:
    """Return how many inputs of each problem are those of its species in the library."""
    count = pd.Series(0, index=problems.index)
    for species, of_it in problems.groupby("species"):
        path = LIBRARY_FOLDER / f"{species}.toml"
        if path.exists():
            own = load_species(path).bird()
            same = [np.isclose(of_it[name], getattr(own, name)) for name in NUMBERS if hasattr(own, name)]
            count[of_it.index] = sum(is_same.astype(int) for is_same in same)
    return count


def _same_problem(rows: pd.DataFrame, problem: pd.Series) -> pd.Series:
    same = pd.Series(True, index=rows.index)
    for name in PROBLEM:
        same &= _is(rows[name], problem[name])
    return same


def _is(values: pd.Series, value: Any) -> pd.Series:
    """Return which values are one, or are absent as that one is."""
    return values.isna() if pd.isna(value) else values == value


def varied_inputs(rows: pd.DataFrame, pair: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Return for each input that is varied alone, all others being those of a pair, the rows that show it.

    Parameters
    ----------
    rows : DataFrame
        Optima of many problems.
    pair : DataFrame
        Those of the one about which inputs vary.
    """
    base = pair.iloc[0]
    # How the amplitude was chosen does not matter, but what it came to.
    told_apart = [name for name in PROBLEM if name != "amplitude_convention"]
    differs = pd.DataFrame({name: ~_is(rows[name], base[name]) for name in told_apart})
    count = differs.sum(axis=1)
    varied = {}
    for name in NUMBERS:
        alone = rows[(count == 0) | ((count == 1) & differs[name])]
        if alone[name].nunique() >= LEAST_VALUES:
            varied[name] = alone
    return varied
