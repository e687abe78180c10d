"""What every command promises: it starts at once, says one line on a mistake, and exits with a known code."""

import io
import os
import subprocess
import sys
import threading
import types
from contextlib import contextmanager, redirect_stderr, redirect_stdout

import click
import pytest
import upwash
from click.testing import CliRunner
from upwash import cli
from upwash.cli import streams
from upwash.errors import CheckFailed, UpwashError

HEAVY = {
    "duckdb",
    "jinja2",
    "joblib",
    "matplotlib",
    "numba",
    "numpy",
    "pandas",
    "pyarrow",
    "scipy",
    "scipy.stats",
}
NAMES = sorted(name for commands in cli.COMMANDS.values() for name in commands)
MODULES = sorted({module for commands in cli.COMMANDS.values() for module, _ in commands.values()})


def heavy_modules_after(code):
    """Run Python code in a fresh interpreter; return which heavy packages it imported."""
    script = f"{code}\nimport sys\nprint('imported:', *sorted({HEAVY!r} & set(sys.modules)))"
    finished = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(finished.stdout.rpartition("imported:")[2].split())


@pytest.fixture
def run_command(monkeypatch):
    """Return a function that runs a stand-in command `probe` with the body given, as a user would."""

    def run(body):
        module = types.ModuleType("upwash.cli.stand_in")
        module.probe = click.command("probe")(body)
        monkeypatch.setitem(sys.modules, module.__name__, module)
        monkeypatch.setitem(cli.COMMANDS, "Tests", {"probe": ("stand_in", "A stand-in.")})
        return CliRunner().invoke(cli.main, ["probe"])

    return run


def failing_with(error):
    def body():
        raise error

    return body


class TestStartsAtOnce:
    def test_help_imports_nothing_heavy(self):
        assert (
            heavy_modules_after("from upwash.cli import main\nmain(['--help'], standalone_mode=False)")
            == set()
        )

    @pytest.mark.parametrize("module", MODULES)
    def test_a_command_module_imports_nothing_heavy_until_it_works(self, module):
        assert heavy_modules_after(f"import upwash.cli.{module}") == set()

    def test_importing_the_package_imports_nothing_heavy(self):
        assert heavy_modules_after("import upwash") == set()

    @pytest.mark.parametrize("command", ["optimum", "flock", "species show"])
    def test_an_answer_imports_nothing_of_pictures_workers_and_samples(self, command):
        arguments = [
            *command.split(),
            "northern-bald-ibis",
            *(["--birds", "2"] if command == "flock" else []),
        ]
        run = f"from upwash.cli import main\nmain({arguments}, standalone_mode=False)"
        assert not heavy_modules_after(run) & {"duckdb", "jinja2", "joblib", "matplotlib", "scipy.stats"}


class TestHelp:
    def test_lists_every_command(self):
        output = CliRunner().invoke(cli.main, ["--help"]).output
        assert all(f"\n  {name} " in output for name in NAMES)

    @pytest.mark.parametrize("name", NAMES)
    def test_every_command_shows_an_example(self, name):
        command = cli.main.get_command(click.Context(cli.main), name)
        paths = [[name, sub] for sub in command.commands] if isinstance(command, click.Group) else [[name]]
        for path in paths:
            result = CliRunner().invoke(cli.main, [*path, "--help"], prog_name="upwash")
            assert result.exit_code == 0
            # On lines of its own, as it would be typed.
            assert f"\n  Example:\n    upwash {' '.join(path)}" in result.output, path
            assert "\\b" not in result.output

    def test_version_is_the_package_version(self):
        assert (
            CliRunner().invoke(cli.main, ["--version"], prog_name="upwash").output
            == f"upwash {upwash.__version__}\n"
        )


class TestMistakes:
    @pytest.mark.parametrize(
        "arguments", [["no-such-command"], ["--no-such-option"], ["run", "--no-such-option"], ["run"]]
    )
    def test_bad_usage_is_one_line_and_exit_2(self, arguments):
        result = CliRunner().invoke(cli.main, arguments)
        assert result.exit_code == 2
        assert result.stdout == ""
        assert len(result.stderr.splitlines()) == 1
        assert "--help" in result.stderr

    @pytest.mark.parametrize(("error", "code"), [(UpwashError, 2), (CheckFailed, 3)])
    def test_a_users_mistake_is_one_line_and_its_exit_code(self, run_command, error, code):
        result = run_command(failing_with(error("mass_kg: expected a number > 0,\nfound -1")))
        assert result.exit_code == code
        assert result.stdout == ""
        assert result.stderr == "Error: mass_kg: expected a number > 0, found -1\n"

    def test_a_bug_keeps_its_traceback(self, run_command):
        result = run_command(failing_with(ZeroDivisionError("a bug")))
        assert isinstance(result.exception, ZeroDivisionError)

    def test_an_interrupt_is_one_line_and_exit_130(self, run_command):
        result = run_command(failing_with(KeyboardInterrupt()))
        assert result.exit_code == 130
        assert result.stderr == "Interrupted.\n"


def test_a_reader_that_leaves_early_is_no_error():
    reading, writing = os.pipe()
    os.close(reading)
    script = "from upwash.cli import main; main(['--help'])"
    finished = subprocess.run(
        [sys.executable, "-c", script], stdout=writing, stderr=subprocess.PIPE, text=True
    )
    os.close(writing)
    assert (finished.returncode, finished.stderr) == (141, "")


class Clock:
    """A clock that stands still until it is put forward, and tells when it was looked at."""

    def __init__(self):
        self.now, self.looked = 100.0, threading.Semaphore(0)

    def monotonic(self):
        self.looked.release()
        return self.now

    def forward(self, seconds):
        """Let time pass, and then be looked at twice, so that what follows from it has followed."""
        self.now += seconds
        while self.looked.acquire(blocking=False):
            pass
        for _ in range(3):
            assert self.looked.acquire(timeout=60)


class TestSilence:
    """After eight seconds without a word, on either stream, a command says that it is still at work, and at what."""

    @pytest.fixture
    def clock(self, monkeypatch):
        clock = Clock()
        monkeypatch.setattr(streams, "time", clock)
        monkeypatch.setattr(streams, "SILENCE_S", 8.0)
        monkeypatch.setattr(streams, "LOOK_EVERY_S", 0.001)
        return clock

    @staticmethod
    @contextmanager
    def command():
        """Guard the streams as of a command; give what is told to a person."""
        told = io.StringIO()
        with redirect_stdout(io.StringIO()), redirect_stderr(told), streams.guarded_streams():
            yield told

    def test_is_broken_after_eight_seconds_and_again_after_eight_more(self, clock):
        with self.command() as told:
            streams.at_work("solving")
            clock.forward(7.99)
            assert told.getvalue() == ""
            clock.forward(0.01)
            assert told.getvalue() == "still solving, 8 s\n"
            clock.forward(7.99)
            assert told.getvalue() == "still solving, 8 s\n"
            clock.forward(0.01)
            assert told.getvalue() == "still solving, 8 s\nstill solving, 16 s\n"

    @pytest.mark.parametrize("name", ["stdout", "stderr"])
    def test_a_word_begins_it_anew_and_keeps_its_own_line(self, clock, name):
        with self.command() as told:
            streams.at_work("checking")
            clock.forward(5.0)
            getattr(sys, name).write("half a line")
            clock.forward(7.99)
            before = told.getvalue()
            assert before == ("half a line" if name == "stderr" else "")
            clock.forward(0.01)
            assert told.getvalue() == f"{before}\nstill checking, 13 s\n"

    def test_it_counts_from_where_the_work_began(self, clock):
        with self.command() as told:
            streams.at_work("reading")
            clock.forward(7.0)
            streams.at_work("drawing")
            clock.forward(7.99)
            assert told.getvalue() == ""
            clock.forward(0.01)
            assert told.getvalue() == "still drawing, 8 s\n"

    def test_nothing_is_told_of_a_command_that_did_not_begin_or_has_ended(self, clock):
        with self.command() as told:
            clock.forward(100.0)
        streams.at_work("solving")
        clock.now += 100.0
        assert told.getvalue() == ""


class TestPackage:
    def test_offers_its_public_names(self):
        assert all(getattr(upwash, name) is not None for name in upwash.__all__)

    def test_an_unknown_name_is_an_attribute_error(self):
        with pytest.raises(AttributeError, match="no_such_name"):
            upwash.no_such_name  # noqa: B018
