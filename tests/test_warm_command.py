"""Compiling ahead: whatever commands need is compiled and kept, in two processes, or one line says why not."""

import json
import os
import subprocess
import sys
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from upwash import ahead, cli, kernel
from upwash.ahead import Compiled, compile_ahead
from upwash.errors import UpwashError

IBIS = "northern-bald-ibis"


def child(script):
    """Stand for the process that compiles: a program that answers each line."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    ahead_of = "import json, os, sys\nfor line in sys.stdin:\n    part = line.rstrip()\n    "
    return subprocess.Popen([sys.executable, "-c", ahead_of + script], encoding="utf-8", **pipes)


def answering(monkeypatch, script):
    started = []

    def start():
        started.append(child(script))
        return started[-1]

    monkeypatch.setattr(ahead, "_start", start)
    return started


def test_every_part_is_begun_and_done_once_in_two_processes(monkeypatch):
    begun = []
    started = answering(monkeypatch, "print(json.dumps({'part': part, 'kernels': os.getpid()}), flush=True)")
    done = list(compile_ahead(begun.append))
    assert sorted(one.part for one in done) == sorted(begun) == sorted(ahead.PARTS)
    assert {one.kernels for one in done} <= {one.pid for one in started}
    assert len(started) == 2
    assert all(one.returncode is not None for one in started)


@pytest.mark.parametrize(
    ("script", "words"),
    [
        ("print(json.dumps({'fault': 'no room'}), flush=True)", "no room"),
        ("os.kill(os.getpid(), 9)", "-9"),
        ("sys.exit(3)", "3"),
    ],
    ids=["it says why", "it is killed", "it ends"],
)
def test_what_cannot_be_compiled_is_one_line_and_exit_2(monkeypatch, script, words):
    started = answering(monkeypatch, script)
    result = CliRunner().invoke(cli.main, ["warm"])
    assert (result.exit_code, result.stdout) == (2, "")
    assert words in result.stderr.splitlines()[-1]
    assert "Traceback" not in result.stderr
    assert all(one.returncode is not None for one in started)


def test_a_bug_keeps_its_traceback(monkeypatch):
    answering(monkeypatch, "print(json.dumps({'bug': 'Traceback: division'}), flush=True)")
    with pytest.raises(RuntimeError, match="division"):
        list(compile_ahead())


@pytest.fixture
def one_part(monkeypatch):
    """Return a function that lets one stand-in part run in this process."""

    def answer(work):
        monkeypatch.setitem(ahead.PARTS, "a part", work)
        return ahead._answer("a part")

    return answer


def test_kernels_are_counted_when_they_are_compiled_and_not_when_they_are_loaded(
    one_part, tmp_path, monkeypatch
):
    monkeypatch.setattr(kernel, "cache_folders", lambda: (tmp_path,))

    def twice(x):
        return x + x

    assert one_part(lambda: kernel.kernel(twice)(1.0)) == {"part": "a part", "kernels": 1}
    assert one_part(lambda: kernel.kernel(twice)(1.0)) == {"part": "a part", "kernels": 0}
    assert one_part(lambda: kernel.kernel(twice)(1)) == {"part": "a part", "kernels": 1}


def test_what_cannot_be_kept_is_a_fault(one_part, tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(kernel, "cache_folders", lambda: (tmp_path / "file",))
    kernel._tell_once.cache_clear()
    kernel._tell_once(20, kernel.COMPILING)
    answer = one_part(lambda: kernel.kernel(lambda x: x)(1.0))
    assert "NUMBA_CACHE_DIR" in answer["fault"]


def test_faults_are_told_apart_from_bugs(one_part):
    def stop(error):
        def work():
            raise error

        return work

    assert one_part(stop(UpwashError("a word"))) == {"fault": "a word"}
    assert "No space" in one_part(stop(OSError(28, "No space left on device")))["fault"]
    assert "ZeroDivisionError" in one_part(stop(ZeroDivisionError()))["bug"]


def test_what_is_printed(monkeypatch):
    def done(begun):
        for part in ahead.PARTS:
            begun(part)
            yield Compiled(part, 2)

    monkeypatch.setattr(ahead, "compile_ahead", done)
    printed = CliRunner().invoke(cli.main, ["warm", "--json"])
    assert printed.exit_code == 0
    record = json.loads(printed.stdout)
    assert [one["part"] for one in record["compiled"]] == list(ahead.PARTS)
    lines = CliRunner().invoke(cli.main, ["warm"]).stdout.splitlines()
    assert len(lines) == len(ahead.PARTS) + 1
    assert lines[-1] == f"kept in {record['folder']}"


@pytest.mark.thorough
def test_after_it_commands_compile_nothing(tmp_path):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "kernels")}
    (tmp_path / "seen.csv").write_text("x_m,y_m\n1.2,0.9\n", encoding="utf-8")

    def call(*arguments):
        command = [sys.executable, "-c", "from upwash.cli import main; main()", *arguments]
        done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return SimpleNamespace(out=done.stdout, files={path.name for path in tmp_path.rglob("*.kernel")})

    kept = call("warm").files
    assert len(kept) > 10
    for arguments in (
        ["optimum", IBIS],
        ["optimum", IBIS, "--model", "limit"],
        ["flock", IBIS, "--birds", "3"],
        ["phase", IBIS],
        ["robust", IBIS, "--sigma", "0.05"],
        ["evaluate", IBIS, "seen.csv"],
        ["evaluate", IBIS, "seen.csv", "--model", "limit"],
        ["map", IBIS, "--size", "3"],
        ["field", IBIS, "--size", "3"],
    ):
        assert call(*arguments).files == kept, arguments
    again = json.loads(call("warm", "--json").out)
    assert {one["kernels"] for one in again["compiled"]} == {0}
