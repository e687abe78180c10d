"""Malformed sweeps and species, hostile names: exit code 2, one line that says where, nothing written."""

import os
import random
import subprocess
import sys

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.errors import UpwashError
from upwash.sweep import read_sweep
from upwash.sweep.file import SWEEP_FOLDER

IBIS = 'species = "northern-bald-ibis"\n'
SWAN = (SWEEP_FOLDER.parent / "species" / "mute-swan.toml").read_text()

# Text of the sweep -> line at fault, and what the message must name.
MALFORMED = [
    ("", 1, "species"),
    ("species = ", 1, "TOML"),
    (IBIS + "[grid\n", 2, "TOML"),
    (IBIS + 'objective = "force', 2, "TOML"),
    (IBIS + IBIS, 2, "TOML"),
    (IBIS + "[fixed]\n[fixed]\n", 3, "TOML"),
    ('species = "northern-bold-ibis"\n', 1, "northern-bald-ibis"),
    ("species = 3\n", 1, "text"),
    ("species = []\n", 1, "at least one"),
    (IBIS + 'objective = "thrust"\n', 2, "cost_of_transport"),
    (IBIS + 'objective = ["force", "powr"]\n', 2, "did you mean 'power'"),
    (IBIS + 'amplitude = "stroke_angle"\n', 2, "did you mean 'stroke-angle'"),
    (IBIS + "seed = -1\n", 2, "whole number"),
    (IBIS + "seed = 1.5\n", 2, "whole number"),
    (IBIS + "seed = true\n", 2, "whole number"),
    (IBIS + f"seed = {2**63}\n", 2, "64 bits"),
    (IBIS + f"[fixed]\nmass_kg = {'9' * 400}\n", 3, "finite"),
    (IBIS + "tolerance = 0\n", 2, "between 0 and 1"),
    (IBIS + "tolerance = nan\n", 2, "between 0 and 1"),
    (IBIS + "kind = 'flok'\n", 2, "flock"),
    (IBIS + "[flock]\nbirds = 3\n", 2, 'kind = "flock"'),
    (IBIS + 'kind = "flock"\n[flock]\nbirds = 1\n', 4, "at least 2"),
    (IBIS + 'kind = "flock"\n[flock]\nshape = "wedge"\n', 4, "echelon"),
    (IBIS + 'kind = "flock"\n[flock]\nsize = 3\n', 4, "size"),
    (IBIS + "speed = 12\n", 2, "speed"),
    (IBIS + 'speed = "least"\n', 2, "least-power"),
    (IBIS + 'speed = "least-power"\n[fixed]\nspeed_m_s = 12\n', 4, "leave one out"),
    (IBIS + "grids = 3\n", 2, "did you mean 'grid'"),
    (IBIS + "fixed = 3\n", 2, "table"),
    (IBIS + "[fixed]\nmass = 3\n", 3, "did you mean 'mass_kg'"),
    (IBIS + "\n# a comment\n[grid]\nspeed_ms = [1, 2]\n", 5, "did you mean 'speed_m_s'"),
    (IBIS + "[fixed]\naltitude_m = 12000\n", 3, "tropopause"),
    (IBIS + "[fixed]\naltitude_m = { value = 1.1, relative = true }\n", 3, "leave out relative"),
    (IBIS + "[exclude]\naltitude_m = 0\n", 3, "altitude_m"),
    (IBIS + "[fixed]\nbody_drag_coefficient = 0.2\n", 3, "drag"),
    (IBIS + "[fixed]\nmass_kg = -1\n", 3, "positive"),
    (IBIS + "[fixed]\nmass_kg = nan\n", 3, "finite"),
    (IBIS + "[fixed]\nmass_kg = '1.3'\n", 3, "number"),
    (IBIS + "[fixed]\nmass_kg = true\n", 3, "number"),
    (IBIS + "[fixed]\nmass_kg = [1, 2]\n", 3, "number"),
    (IBIS + "[fixed]\nupstroke_span_ratio = 1.5\n", 3, "upstroke_span_ratio"),
    (IBIS + "[fixed]\nstroke_half_angle_deg = 100\n", 3, "at most 90"),
    (IBIS + "[fixed]\nstroke_half_angle_deg = 40\namplitude_m = 0.5\n", 3, "amplitude_m"),
    (IBIS + "[grid]\nmass_kg = []\n", 3, "numbers"),
    (IBIS + "[grid]\nmass_kg = [1.2, inf]\n", 3, "finite"),
    (IBIS + "[grid]\nmass_kg = { linspace = [1, 2] }\n", 3, "linspace"),
    (IBIS + "[grid]\nmass_kg = { linspace = [1, 2, 1] }\n", 3, "count"),
    (IBIS + "[grid]\nmass_kg = { linspace = [1, 2, 9999999999] }\n", 3, "count"),
    (IBIS + "[grid]\nmass_kg = { geomspace = [-1, 2, 3] }\n", 3, "positive"),
    (IBIS + "[grid]\nmass_kg = { linspce = [1, 2, 3] }\n", 3, "linspce"),
    (IBIS + "[grid]\nspan_nodes = [2, 2.5]\n", 3, "a whole number"),
    (IBIS + "[zip]\nmass_kg = [1, 2]\nspeed_m_s = [12, 13, 14]\n", 2, "mass_kg 2, speed_m_s 3"),
    (IBIS + "[fixed]\nmass_kg = 1\n[grid]\nmass_kg = [1, 2]\n", 5, "fixed"),
    (IBIS + "[sample]\ncount = 4\n", 2, "method"),
    (IBIS + '[sample]\nmethod = "sobol"\ncount = 6\nwithin = "species"\n', 4, "take 4 or 8"),
    (IBIS + '[sample]\nmethod = "sobol"\ncount = 4\n', 2, "ranges"),
    (IBIS + '[sample]\nmethod = "lhs"\ncount = 4\nwithin = "species"\n', 3, "latin-hypercube"),
    (IBIS + '[sample]\nmethod = "sobol"\ncount = 4\n[sample.ranges]\nmass_kg = [2, 1]\n', 6, "low first"),
    (
        IBIS + '[sample]\nmethod = "sobol"\ncount = 4\nwithin = "species"\nparameters = ["amplitude_m"]\n',
        6,
        "amplitude_m",
    ),
    (IBIS + '[[exclude]]\nobjective = "power"\n', 2, "none that fits"),
    (IBIS + '[[exclude]]\nobjective = "force"\n', 2, "all excluded"),
    (IBIS + "[[exclude]]\n", 2, "at least one condition"),
    (IBIS + "[[exclude]]\nmass_kg = 'heavy'\n", 3, "number"),
    (IBIS + "[[block]]\n[block.grid]\nmass_kg = [1]\n[[block]]\n[block.grid]\nmass = [2]\n", 7, "mass_kg"),
    (IBIS + "block = 3\n", 2, "tables"),
    (IBIS + "[grid]\nmass_kg = X\nspeed_m_s = X".replace("X", "{ linspace = [1, 9, 9999] }"), 1, "jobs"),
    (IBIS + "a = " + "[" * 5000 + "]" * 5000, 1, "nested"),
    (IBIS + 'solver = "os.system"\n', 2, "module:function"),
    (IBIS + 'name = "../elsewhere"\n', 2, "name"),
    (IBIS + 'name = "two\\nlines"\n', 2, "name"),
    (IBIS + f'name = "{"x" * 300}"\n', 2, "name"),
    (IBIS + 'name = ".hidden"\n', 2, "name"),
    (IBIS + 'name = ""\n', 2, "name"),
]  # fmt: skip

# Change of the swan's file: text -> its replacement, and what the message must name.
MALFORMED_SPECIES = [
    ("[mass]", "[mass", "TOML"),
    ("[mass]", "[weight]", "weight"),
    ('unit = "kg"', 'unit = "stone"', "stone"),
    ("value = ", "value = -", "positive"),
    ("value = ", "value = nan #", "nan"),
    ('common_name = "', 'common_nam = "', "common_nam"),
    ('scientific_name = "', "scientific_name = 3 #", "scientific_name"),
    ("low = ", "lowest = ", "lowest"),
]


def assert_refused(result, folder, *words):
    """A refusal is one line on standard error, exit code 2, and leaves no trace."""
    assert (result.exit_code, result.stdout) == (2, "")
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert result.stderr.startswith("Error: ")
    assert all(word in result.stderr for word in words), result.stderr
    assert sorted(os.listdir(folder)) == before_in(folder)


def before_in(folder):
    return sorted(name for name in os.listdir(folder) if name.endswith(".toml"))


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Return a function that runs a sweep file in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def invoke(text, name="sweep.toml", options=()):
        (tmp_path / name).write_bytes(text if isinstance(text, bytes) else text.encode())
        return CliRunner().invoke(main, ["run", f"./{name}", *options])

    return invoke


@pytest.mark.parametrize(("text", "line", "word"), MALFORMED)
def test_a_malformed_sweep_is_refused_with_its_line(run, tmp_path, text, line, word):
    assert_refused(run(text), tmp_path, f"sweep.toml, line {line}:", word)


@pytest.mark.parametrize(("old", "new", "word"), MALFORMED_SPECIES)
def test_a_malformed_species_is_refused_with_the_sweeps_line(run, tmp_path, old, new, word):
    assert old in SWAN
    (tmp_path / "swan.toml").write_text(SWAN.replace(old, new, 1))
    assert_refused(
        run('# swans\nspecies = "swan.toml"\n'), tmp_path, "sweep.toml, line 2:", "swan.toml", word
    )


GOOD_SWEEP = """\
species = ["northern-bald-ibis", "swan.toml"]
objective = ["force", "power"]
amplitude = "stroke-angle"
seed = 1
tolerance = 1e-3

[fixed]
speed_m_s = 14.0
mass_kg = { value = 1.1, relative = true }

[grid]
period_s = [0.20, 0.25]
upstroke_span_ratio = { linspace = [0.35, 0.45, 2] }

[[exclude]]
species = "swan"
period_s = { above = 0.22 }
"""
OTHER_VALUES = [
    "",
    "nan",
    "-1",
    "1e999",
    "true",
    "[]",
    "{}",
    "'x'",
    "[[1]]",
    "2020-01-01",
    '"""',
    "\x00",
    "9" * 400,
]


def spoilt(text, chance):
    """Return a file with one thing gone wrong: cut, a sign lost, a key misspelt, another value, a line twice."""
    lines = text.splitlines()
    at = chance.choice([number for number, line in enumerate(lines) if "=" in line])
    key, _, value = lines[at].partition("=")
    match chance.randrange(6):
        case 0:
            return text[: chance.randrange(1, len(text))]
        case 1:
            signs = [place for place, sign in enumerate(text) if sign in '[]{}="']
            place = chance.choice(signs)
            return text[:place] + text[place + 1 :]
        case 2:
            place = chance.randrange(len(key.rstrip()) + 1)
            lines[at] = f"{key[:place]}q{key[place:]}={value}"
        case 3 | 4:
            lines[at] = f"{key}= {chance.choice(OTHER_VALUES)}"
        case 5:
            lines.insert(at, lines[at])
    return "\n".join(lines) + "\n"


def is_good(path):
    try:
        read_sweep(path)
    except UpwashError:
        return False
    return True


@pytest.mark.parametrize("part", ["sweep", "swan"])
def test_whatever_goes_wrong_in_a_file_is_one_line_and_leaves_no_trace(tmp_path, monkeypatch, part):
    monkeypatch.chdir(tmp_path)
    chance = random.Random(part)
    good = {"sweep": GOOD_SWEEP, "swan": SWAN}
    refused = 0
    for _ in range(150):
        for name, text in good.items():
            (tmp_path / f"{name}.toml").write_text(spoilt(text, chance) if name == part else text)
        # A line lost at the end, or another number, may leave a file in order.
        if not is_good("./sweep.toml"):
            assert_refused(CliRunner().invoke(main, ["run", "./sweep.toml"]), tmp_path, f"{part}.toml")
            refused += 1
    assert refused > 75


def test_bytes_that_are_no_text_are_refused_with_their_line(run, tmp_path):
    assert_refused(run(b"# fine\nspecies = '\xff'\n"), tmp_path, "line 2:", "UTF-8")


def test_a_name_with_a_newline_in_it_is_shown_on_one_line(run, tmp_path):
    assert_refused(run(IBIS, name="two\nlines.toml"), tmp_path, "two\\nlines")


@pytest.mark.parametrize(
    "options",
    [("--workers", "0"), ("--backend", "dask"), ("--scheduler", "x"), ("--shard", "3/2"), ("--shard", "0/2")],
)
def test_bad_options_are_refused(run, tmp_path, options):
    assert_refused(run(IBIS, options=options), tmp_path, options[0])


@pytest.mark.parametrize(
    "sweep", ["no-such-sweep", "./no-such-file.toml", "../x", ".", "x" * 300, "a\nb", ""]
)
def test_a_sweep_that_is_not_there_is_refused(tmp_path, monkeypatch, sweep):
    monkeypatch.chdir(tmp_path)
    assert_refused(CliRunner().invoke(main, ["run", sweep]), tmp_path)


@pytest.mark.parametrize("command", ["status", "aggregate", "check"])
@pytest.mark.parametrize("results", ["no-such-folder", "../x", "x" * 300, "a\nb"])
def test_results_that_are_not_there_are_refused(tmp_path, monkeypatch, command, results):
    monkeypatch.chdir(tmp_path)
    assert_refused(CliRunner().invoke(main, [command, results]), tmp_path)


def test_the_shell_sees_the_same(tmp_path):
    (tmp_path / "sweep.toml").write_text(IBIS + "[fixed]\nmass = 3\n")
    command = [sys.executable, "-c", "from upwash.cli import main; main()", "run", "sweep.toml"]
    told = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert (told.returncode, told.stdout, os.listdir(tmp_path)) == (2, "", ["sweep.toml"])
    assert told.stderr == (
        "Error: sweep.toml, line 3: fixed.mass: expected a key that Upwash knows; did you mean 'mass_kg'?\n"
    )
