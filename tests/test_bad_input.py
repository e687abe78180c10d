"""Bad input as a shell sees it: one line that says what is wrong, exit code 2, and nothing written."""

import pickle
import subprocess
import sys
from contextlib import chdir

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.errors import UpwashError
from upwash.species import load_species
from upwash.species.library import LIBRARY_FOLDER
from upwash.sweep import read_sweep

COMMAND = [sys.executable, "-c", "from upwash.cli import main; main(prog_name='upwash')"]
IBIS = (LIBRARY_FOLDER / "northern-bald-ibis.toml").read_text(encoding="utf-8")
SWEEP = 'species = "northern-bald-ibis"\n'

FILES = {
    "no-mass.toml": IBIS.replace("[mass]", "[mas]"),
    "negative.toml": IBIS.replace("value = 1.3\n", "value = -1.3\n"),
    "nan.toml": IBIS.replace("value = 15.0\n", "value = nan\n"),
    "ratio.toml": IBIS.replace("value = 0.4\n", "value = 1.4\n"),
    "syntax.toml": IBIS.replace("[mass]", "[mass"),
    "sweep.toml": SWEEP,
    "unknown-input.toml": SWEEP + "[grid]\nspeed_of_wind = [1, 2]\n",
    "sweep-syntax.toml": SWEEP + "objective = force\n",
    "table.csv": "species,mass_kg\nibis,1.3\n",
    "my-bird.toml": IBIS.replace("1.3", "1.31"),
}

# Arguments of the command, and what its one line must name.
MISTAKES = {
    **{
        f"a limit that {command[0]} does not keep": (
            [*command, "--set", "x_min_m=1.5"],
            ["no limit on the follower's place", f"upwash {command[0]}", "x_min_m"],
        )
        for command in (
            ["map", "northern-bald-ibis"],
            ["robust", "northern-bald-ibis"],
            ["phase", "northern-bald-ibis"],
            ["explore", "northern-bald-ibis"],
            ["evaluate", "northern-bald-ibis", "table.csv"],
        )
    },
    "a missing field": (["optimum", "./no-mass.toml"], ["no-mass.toml", "mas"]),
    "a negative mass": (["optimum", "./negative.toml"], ["negative.toml", "mass", "-1.3"]),
    "a NaN": (["optimum", "./nan.toml"], ["nan.toml", "speed", "nan"]),
    "a span ratio beyond 1": (["optimum", "./ratio.toml"], ["ratio.toml", "upstroke_span_ratio", "1.4"]),
    "a syntax error": (["optimum", "./syntax.toml"], ["syntax.toml", "TOML"]),
    "an unknown species": (["optimum", "northern-bold-ibis"], ["did you mean northern-bald-ibis"]),
    "an unknown objective": (["optimum", "northern-bald-ibis", "--objective", "speed"], ["'speed'", "power"]),
    "an unknown parameter": (
        ["run", "./unknown-input.toml"],
        ["unknown-input.toml, line 3", "speed_of_wind"],
    ),
    "a sweep's syntax error": (["run", "./sweep-syntax.toml"], ["sweep-syntax.toml, line 2", "TOML"]),
    "a species file where a sweep is due": (
        ["run", "./no-mass.toml"],
        ["a species file", "upwash optimum no-mass.toml"],
    ),
    "a sweep file where a species is due": (
        ["optimum", "./sweep.toml"],
        ["a sweep file", "upwash run sweep.toml"],
    ),
    "a table where a sweep is due": (["run", "table.csv"], ["./table.csv"]),
    "a table by its path where a sweep is due": (
        ["run", "./table.csv"],
        ["table.csv", "found a file of kind CSV"],
    ),
    "a table where a species is due": (["optimum", "./table.csv"], ["table.csv", "found a file of kind CSV"]),
    "a species' own file without its ending": (["optimum", "my-bird"], ["./my-bird.toml"]),
    "a sweep's own file without its ending": (["run", "sweep"], ["./sweep.toml"]),
    "a seed beyond 64 bits": (["optimum", "northern-bald-ibis", "--seed", "9" * 30], ["--seed", "9" * 30]),
    "results under a file": (
        ["run", "./sweep.toml", "--results", "sweep.toml/results"],
        ["sweep.toml/results"],
    ),
    "an explorer that is a folder": (["explore", "--output", "."], ["'--output'", "'.' is a directory"]),
    "a map in a file": (
        ["field", "northern-bald-ibis", "--output", "sweep.toml"],
        ["'--output'", "'sweep.toml' is a file"],
    ),
    "a film that is a folder": (
        ["animate", "northern-bald-ibis", "--output", "."],
        ["'--output'", "'.' is a directory"],
    ),
    "observed birds that are a folder": (
        ["evaluate", "northern-bald-ibis", "."],
        ["'TABLE'", "'.' is a directory"],
    ),
    "a table told in a folder": (
        ["evaluate", "northern-bald-ibis", "table.csv", "--output", "."],
        ["'--output'", "'.' is a directory"],
    ),
    "results of a name that cannot be": (
        ["status", "x" * 300],
        ["expected a results folder, found File name too long"],
    ),
    "results that are a file": (["reproduce", "--results", "sweep.toml"], ["sweep.toml"]),
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with all the bad files in it."""
    folder = tmp_path_factory.mktemp("bad")
    for name, text in FILES.items():
        assert text not in (IBIS, ""), name
        (folder / name).write_text(text, encoding="utf-8")
    return folder


@pytest.fixture
def told(folder):
    """Run the command in this process; return its output, what it said, and its exit code."""

    def run(arguments):
        with chdir(folder):
            result = CliRunner().invoke(main, arguments, prog_name="upwash")
        assert isinstance(result.exception, SystemExit), result.exception
        return result.stdout, result.stderr, result.exit_code

    return run


@pytest.mark.parametrize("mistake", MISTAKES)
def test_is_one_clear_line_and_exit_2(told, mistake):
    arguments, words = MISTAKES[mistake]
    output, said, code = told(arguments)
    assert (output, code) == ("", 2), said
    assert said.startswith("Error: ") and said.count("\n") == 1, said
    assert all(word in said for word in words), said


@pytest.mark.parametrize("mistake", ["a missing field", "a sweep's syntax error"])
def test_a_shell_sees_the_same(folder, told, mistake):
    arguments, _ = MISTAKES[mistake]
    done = subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True)
    assert (done.stdout, done.stderr, done.returncode) == told(arguments)


def test_writes_nothing(told, folder):
    for arguments, _ in MISTAKES.values():
        told(arguments)
    assert {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()} == FILES


def test_files_that_begin_with_a_byte_order_mark_are_read(tmp_path):
    for name, text in (("bird.toml", IBIS), ("sweep.toml", 'species = "bird.toml"\n')):
        (tmp_path / name).write_text(text, encoding="utf-8-sig")
    (job,) = read_sweep(tmp_path / "sweep.toml").jobs
    assert job.bird.mass_kg == load_species("northern-bald-ibis").quantities["mass"].value


@pytest.mark.parametrize(
    ("given", "field"),
    [
        ({"speed_m_s": -1.0}, "speed_m_s"),
        ({"wingspan": 1.0}, "wingspan"),
        ({"circulation_ratio": 5.0}, "upstroke_span_ratio"),
    ],
)
def test_an_error_names_its_field(given, field):
    with pytest.raises(UpwashError) as caught:
        load_species("northern-bald-ibis").bird(**given)
    assert caught.value.field == field
    assert pickle.loads(pickle.dumps(caught.value)).field == field
