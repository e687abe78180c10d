"""Too few steps of the wingbeat behind an endless wake are told of; a named model takes as many as it needs."""

import logging

import pytest
from report.studies import limit_rows
from upwash.report.words import model_in_words
from upwash.sweep import block, read_sweep

HEAD = 'description = "A study"\nspecies = "northern-bald-ibis"\n[fixed]\nmodel = "limit"\n'


@pytest.fixture
def steps_of(tmp_path, caplog):
    """The steps of a sweep's jobs, and the lines that are told of them."""

    def read(text):
        path = tmp_path / "steps.toml"
        path.write_text(HEAD + text, encoding="utf-8")
        with caplog.at_level(logging.WARNING, logger="upwash"):
            jobs = read_sweep(path).jobs
        return [job.inputs()["stroke_states"] for job in jobs], caplog.messages

    block._tell_once.cache_clear()
    return read


def test_steps_that_are_given_and_too_few_are_told_once_for_many_jobs(steps_of):
    grid = '[grid]\ncore = ["rankine", "rosenhead-moore"]\nspan_law = ["tip", "stroke"]\n'
    steps, lines = steps_of(f"stroke_states = 16\n{grid}")
    assert steps == [16] * 4
    (line,) = lines
    assert line.startswith("stroke_states: each of 16 steps carries the wing 2.3 core radii along the wake, ")
    assert line.endswith("several per cent; 32 would tell them to about one")


@pytest.mark.parametrize(
    ("given", "steps"),
    [("core_radius_ratio = 0.05", 106), ("period_s = 0.6", 74), ("core_radius_ratio = 0.3", 32)],
)
def test_a_named_model_is_given_the_steps_that_its_core_and_wave_need(steps_of, given, steps):
    assert steps_of(given + "\n") == ([steps], [])


def test_a_wake_that_ends_is_as_its_states_are(steps_of):
    assert steps_of("stroke_states = 4\nwavelengths = 1\n") == ([4], [])


def test_an_answer_tells_what_too_few_steps_cost():
    row = limit_rows()[0]
    assert not any("core radii" in line for line in model_in_words(row))
    coarse = [line for line in model_in_words(row | {"stroke_states": 16}) if "core radii" in line]
    assert len(coarse) == 1 and "32 would tell them to about one" in coarse[0]
