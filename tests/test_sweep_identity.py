"""A job's id follows from its inputs and the model's version, and from nothing else."""

import dataclasses
import json
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from upwash import columns as of
from upwash.aero.wake import WakeModel
from upwash.jobs.bird import NoBird
from upwash.jobs.job import canonical_text, job_id
from upwash.optimum.settings import FLOCK_CHOICES, SearchSettings
from upwash.sweep import Job

INPUT = {
    "kind": "pair",
    "species": "northern-bald-ibis",
    "objective": "force",
    "amplitude_convention": "stroke-angle",
    "mass_kg": 1.3,
    "semispan_m": 0.6,
    "speed_m_s": 15.0,
    "period_s": 0.25,
    "density_kg_m3": 1.29,
    "gravity_m_s2": 9.8,
    "leader_amplitude_m": 1.0392304845413263,
    "leader_upstroke_span_ratio": 0.4,
    "circulation_ratio": 1.0,
    "core_radius_ratio": 0.171,
    "stroke_states": 2,
    "span_nodes": 2,
    "seed": 0,
    "tolerance": 1e-4,
    "solver": "upwash",
}
FLOCK = INPUT | {"kind": "flock", "birds": 6, "shape": "vee", "wake": "neighbour", "reading": "lone"}
FLOCK |= {"wavelengths": 1}
JOBS_OF_OLD = json.loads((Path(__file__).parent / "job_ids.json").read_text())


def other(name, value):
    """A value of the same type that is the next one to it."""
    if name in FLOCK_CHOICES:
        return next(one for one in FLOCK_CHOICES[name] if one != value)
    if isinstance(value, str):
        return value + "x"
    return value + 1 if isinstance(value, int) else value * (1 + 2**-52)


def test_the_id_of_the_papers_pair_is_what_it_was():
    # Results on people's disks are found by it: if this fails, all of them would be solved again.
    assert Job.of(INPUT).job_id == "20f1cc3353d94ba4"


def test_whole_numbers_and_floats_of_equal_value_are_equal():
    assert Job.of(INPUT | {"speed_m_s": 15}).job_id == Job.of(INPUT).job_id


def test_negative_zero_is_zero():
    assert job_id(INPUT | {"gravity_m_s2": -0.0}) == job_id(INPUT | {"gravity_m_s2": 0.0})


def test_the_order_of_the_inputs_does_not_matter():
    assert job_id(dict(reversed(INPUT.items()))) == job_id(INPUT)


def test_the_ids_that_jobs_had_when_they_were_flat_are_what_they_were():
    for row in JOBS_OF_OLD:
        assert Job.of(row).job_id == row["job_id"]
    assert {row["kind"] for row in JOBS_OF_OLD} == {"pair", "flock"} and len(JOBS_OF_OLD) > 30


@pytest.mark.parametrize("row", JOBS_OF_OLD, ids=lambda row: row["job_id"])
def test_a_job_is_what_its_columns_say_and_says_them_again(row):
    job = Job.of(row)
    stated = {name: value for name, value in job.inputs().items() if value is not None}
    # What came later is the paper's.
    usual = of.told(vars(WakeModel())) | {"model": WakeModel().name(1.0), "phase_lock": True}
    name = job.inputs()["model"]
    assert {**usual, "job_id": job.job_id, **stated} == usual | row | {"model": name}
    assert (name == "paper") == (job.model == WakeModel())
    assert Job.of(job.inputs()) == Job.of(of.kept(job.inputs())) == job


def test_inputs_that_make_no_bird_are_kept_with_the_reason():
    job = Job.of(INPUT | {"leader_amplitude_m": 1.3})
    assert isinstance(job.bird, NoBird) and "at most twice the semispan" in job.bird.why
    assert job.inputs()["leader_amplitude_m"] == 1.3


@pytest.mark.parametrize("name", [entry.name for entry in dataclasses.fields(WakeModel)])
def test_every_input_of_the_wakes_model_counts_and_is_left_out_at_the_papers_value(name):
    job, limit = Job.of(INPUT), WakeModel.named("limit")
    value = getattr(limit, name)
    if value != getattr(job.model, name):
        changed = dataclasses.replace(job, model=dataclasses.replace(job.model, **{name: value}))
        assert changed.job_id != job.job_id
    assert (f"\n{name}=" in canonical_text(job.inputs())) == (name in INPUT)


def test_a_search_that_no_column_tells_is_refused():
    with pytest.raises(ValueError, match="search: expected .* seed and tolerance, found"):
        dataclasses.replace(Job.of(INPUT), search=SearchSettings(starts=5))


@pytest.mark.parametrize("name", FLOCK)
def test_every_input_counts_to_its_last_bit(name):
    if name == "kind":
        assert Job.of(FLOCK).job_id != Job.of(INPUT).job_id
        return
    assert Job.of(FLOCK | {name: other(name, FLOCK[name])}).job_id != Job.of(FLOCK).job_id


def test_the_models_version_counts():
    assert job_id(INPUT, model_version=1) != job_id(INPUT, model_version=2)


def test_an_input_that_does_not_apply_changes_nothing():
    assert job_id(INPUT | {"an_input_of_tomorrow": None}) == job_id(INPUT)


@given(st.floats(allow_nan=False, allow_infinity=False), st.floats(allow_nan=False, allow_infinity=False))
def test_two_masses_share_an_id_only_if_they_are_equal(one, another):
    ids = {job_id(INPUT | {"mass_kg": mass}) for mass in (one, another)}
    assert (len(ids) == 1) == (one == another)


@given(st.text(), st.text())
def test_text_cannot_pose_as_another_input(species, objective):
    text = canonical_text(INPUT | {"species": species, "objective": objective})
    assert len(text.split("\n")) == len(INPUT) + 1
    lines = dict(line.split("=", 1) for line in text.split("\n"))
    assert (json.loads(lines["species"]), json.loads(lines["objective"])) == (species, objective)


def test_another_process_gives_the_same_id():
    script = f"from upwash.sweep import Job; print(Job.of({INPUT!r}).job_id)"
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert told.stdout.strip() == Job.of(INPUT).job_id


def test_a_job_cannot_be_changed():
    with pytest.raises(dataclasses.FrozenInstanceError):
        Job.of(INPUT).species = "dunlin"
