"""Every command in every broken environment: one line and exit code 2, or the same answer as in a sound one.

Run as a program this file is a server that imports everything once and then forks for each command, so that
hundreds of commands take seconds; a forked command sees its streams as the interpreter would have made them.
"""

import json
import os
import resource
import shutil
import subprocess
import sys
import traceback
from contextlib import chdir
from functools import partial
from pathlib import Path

import pytest
from click.testing import CliRunner
from upwash import cli
from upwash.kernel import cache_folders

pytestmark = pytest.mark.thorough

SWEEP = 'name = "study"\nspecies = "northern-bald-ibis"\nobjective = ["force", "power"]\n'
MORE = 'name = "more"\nspecies = "mute-swan"\n'
IBIS = "northern-bald-ibis"
RESULTS = "results/study"

# How each command is called in a folder that holds the sweep's gathered results.
COMMANDS = {
    "": ["--version"],
    "species list": ["species", "list"],
    "species show": ["species", "show", "mute-swan"],
    "species check": ["species", "check", IBIS, "--json"],
    "species new": ["species", "new", "Common shelduck"],
    "optimum": ["optimum", IBIS, "--all"],
    "phase": ["phase", IBIS, "--model", "paper"],
    "robust": ["robust", IBIS, "--sigma", "0"],
    "flock": ["flock", IBIS, "--birds", "2"],
    "field": ["field", IBIS, "--size", "4"],
    "animate": ["animate", IBIS, "--birds", "2"],
    "explore": ["explore", IBIS],
    "evaluate": ["evaluate", IBIS, "seen.csv"],
    "run": ["run", "./sweep.toml", "--json"],
    "merge": ["merge", "results/merged", RESULTS],
    "status": ["status", RESULTS],
    "aggregate": ["aggregate", RESULTS, "--json"],
    "check": ["check", RESULTS],
    "show": ["show", RESULTS, "JOB"],
    "rerun": ["rerun", RESULTS, "JOB"],
    "diff": ["diff", RESULTS, RESULTS],
    "page": ["page", RESULTS],
    "claims": ["claims", RESULTS],
    "literature": ["literature"],
    "warm": ["warm"],
    "a mistake": ["optimum", "no-such-bird"],
}
# Runs the commands above one after another, for minutes.
TOO_LONG = {"reproduce"}
# Each draws for seconds, and prints no more than a name.
DRAWING = {"animate", "field", "page"}

STREAMS = {
    "a full output": {"out": "full"},
    "a closed output": {"out": "closed"},
    "an output in ASCII": {"encoding": "ascii"},
    "closed messages": {"err": "closed"},
    "full messages": {"err": "full"},
}

# What the commands that write files are to write, where no file may grow, and where there is no folder.
WRITING = {
    "species new": ["species", "new", "Common shelduck", "--folder", "DIR"],
    "field": ["field", IBIS, "--size", "4", "--output", "DIR"],
    "animate": ["animate", IBIS, "--birds", "2", "--output", "DIR/flock.gif"],
    "explore": ["explore", IBIS, "--output", "DIR/explorer.html"],
    "evaluate": ["evaluate", IBIS, "seen.csv", "--output", "DIR/told.parquet"],
    "run": ["run", "./more.toml", "--results", "DIR"],
    "merge": ["merge", "DIR", RESULTS],
}
WRITING_IN_RESULTS = {"aggregate", "claims", "page"}
LARGEST_FILE = 512


class Server:
    """The process that forks."""

    def __init__(self):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen([sys.executable, "-W", "ignore", __file__], **pipes)

    def run(self, folder, arguments, **environment):
        """Run a command; return its exit code, its output, and what it said."""
        streams = {name: str(folder.parent / f"{folder.name}.{name}") for name in ("stdout", "stderr")}
        for path in streams.values():
            Path(path).write_bytes(b"")
        job = json.loads((folder / RESULTS / "plan.json").read_text())["jobs"].split()[0]
        arguments = [one.replace("JOB", job) for one in arguments]
        request = {"folder": str(folder), "arguments": arguments, **streams, **environment}
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        code = int(self.process.stdout.readline())
        return (code, *(Path(path).read_text(encoding="utf-8") for path in streams.values()))

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        self.process.wait()


def serve():
    """Fork for each line of standard input, and answer with an exit code."""
    import pandas as pd
    import pyarrow.parquet  # noqa: F401
    from upwash import evaluate
    from upwash.batch import aggregate, check, merge, runner  # noqa: F401
    from upwash.optimum.pair import solve_pair
    from upwash.report import animation, page  # noqa: F401
    from upwash.report.explorer import page as explorer  # noqa: F401
    from upwash.species import load_library, load_species

    # The kernels are loaded once as well.
    load_library()
    ibis = load_species(IBIS).bird()
    solve_pair(ibis, "force")
    evaluate(ibis, pd.DataFrame({"x_m": [1.2], "y_m": [0.9]}), finds_optimum=False)
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    for line in sys.stdin:
        child = os.fork()
        if not child:
            os._exit(run_here(json.loads(line)))
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), file=answers)


def run_here(request):
    """Run a command in this process, with its streams made as the interpreter makes them; return its exit code."""
    os.chdir(request["folder"])
    for descriptor, short, name in ((1, "out", "stdout"), (2, "err", "stderr")):
        place = request.get(short, request[name])
        if place == "closed":
            os.close(descriptor)
        else:
            os.dup2(os.open("/dev/full" if place == "full" else place, os.O_WRONLY), descriptor)
    sys.stdout = sys.stderr = None
    make = partial(open, mode="w", closefd=False)
    if request.get("out") != "closed":
        sys.stdout = make(1, encoding=request.get("encoding", "utf-8"))
    if request.get("err") != "closed":
        sys.stderr = make(2, encoding="utf-8", errors="backslashreplace")
    if "largest" in request:
        resource.setrlimit(resource.RLIMIT_FSIZE, (request["largest"], request["largest"]))
    code = 0
    try:
        cli.main(request["arguments"], prog_name="upwash")
    except SystemExit as end:
        code = end.code or 0
    except BaseException:
        traceback.print_exc()
        code = 1
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            code = 120
    return code


@pytest.fixture(scope="module")
def server():
    server = Server()
    yield server
    server.close()


@pytest.fixture(scope="module")
def sound_folder(tmp_path_factory):
    """A folder with a sweep that was run and gathered, and one that was not."""
    folder = tmp_path_factory.mktemp("sound")
    (folder / "sweep.toml").write_text(SWEEP)
    (folder / "more.toml").write_text(MORE)
    (folder / "seen.csv").write_text("bird,x_m,y_m,z_m\nÁgnes,1.2,0.9,0.0\n", encoding="utf-8")
    with chdir(folder):
        for arguments in (["run", "./sweep.toml"], ["aggregate", RESULTS]):
            result = CliRunner().invoke(cli.main, arguments)
            assert result.exit_code == 0, result.output
    return folder


@pytest.fixture
def folder(sound_folder, tmp_path):
    """A copy of it."""
    return shutil.copytree(sound_folder, tmp_path / "folder")


@pytest.fixture(scope="module")
def sound(sound_folder, server, tmp_path_factory):
    """Return a function that tells what a command answers in a sound environment."""
    answers = {}

    def answer(name):
        if name not in answers:
            copy = shutil.copytree(sound_folder, tmp_path_factory.mktemp("copy") / "folder")
            answers[name] = server.run(copy, COMMANDS[name])
        return answers[name]

    return answer


def is_one_line(said, *words):
    """Whether a command ended with one line that names some words; it may have told before what it does."""
    lines = said.splitlines()
    errors = [line for line in lines if line.startswith("Error: ")]
    return errors == lines[-1:] and "Traceback" not in said and all(word in errors[0] for word in words)


def test_every_command_is_tried():
    names = {name for commands in cli.COMMANDS.values() for name in commands}
    assert {name.split()[0] for name in COMMANDS if name not in ("", "a mistake")} | TOO_LONG == names


@pytest.mark.parametrize("fault", STREAMS)
@pytest.mark.parametrize("name", [name for name in COMMANDS if name not in DRAWING])
def test_broken_streams(server, sound, folder, name, fault):
    code, output, said = server.run(folder, COMMANDS[name], **STREAMS[fault])
    sound_code, sound_output, _ = sound(name)
    assert sound_code == (2 if name == "a mistake" else 0)
    if fault.endswith("messages"):
        assert (code, output) == (sound_code, sound_output)
    elif sound_output and not (fault.endswith("ASCII") and sound_output.isascii()):
        assert code == 2
        assert is_one_line(said, "standard output: expected "), said
    else:
        assert (code, output) == (sound_code, sound_output), said


@pytest.mark.parametrize("name", sorted(DRAWING))
def test_a_full_output_where_a_name_is_printed(server, folder, name):
    code, _, said = server.run(folder, COMMANDS[name], out="full")
    assert code == 2
    assert is_one_line(said, "standard output: expected "), said


def contents(folder):
    """Return the bytes of every file in a folder, by its name there, but for locks and journals."""
    paths = (path for path in folder.rglob("*") if path.is_file() and path.name[:5] not in (".lock", "journ"))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


@pytest.mark.parametrize("name", [*WRITING, *sorted(WRITING_IN_RESULTS - {"claims"})])
def test_a_disk_without_room_loses_nothing_and_leaves_no_stump(server, folder, name):
    before = contents(folder)
    arguments = [one.replace("DIR", "made") for one in WRITING.get(name, COMMANDS[name])]
    if name in WRITING:
        (folder / "made").mkdir(exist_ok=name != "merge")
    if name == "merge":
        (folder / "made").rmdir()
    code, output, said = server.run(folder, arguments, largest=LARGEST_FILE)
    assert (code, output) == (2, ""), said
    assert is_one_line(said), said
    after = contents(folder)
    assert before.items() <= after.items()
    assert not [path for path in after.keys() - before.keys() if len(after[path]) > 0 and "plan" not in path]


@pytest.mark.parametrize("name", WRITING)
def test_a_folder_that_cannot_be_made(server, folder, name):
    code, output, said = server.run(folder, [one.replace("DIR", "/dev/null/made") for one in WRITING[name]])
    assert (code, output) == (2, "")
    assert is_one_line(said, "/dev/null"), said


def test_a_run_on_a_full_disk_leaves_its_jobs_to_do(server, folder):
    arguments = ["run", "./more.toml", "--json"]
    assert server.run(folder, arguments, largest=LARGEST_FILE)[0] == 2
    code, output, said = server.run(folder, arguments)
    assert code == 0, said
    assert json.loads(output)["done"] == 1


NOWHERE = "/dev/null/nowhere"
SURROUNDINGS = {
    "no home": {"HOME": NOWHERE, "XDG_CACHE_HOME": NOWHERE, "XDG_CONFIG_HOME": NOWHERE},
    "no temporary folder": {"TMPDIR": NOWHERE, "TEMP": NOWHERE, "TMP": NOWHERE},
    "a numba cache that cannot be": {"NUMBA_CACHE_DIR": NOWHERE},
    "a narrow terminal": {"COLUMNS": "1", "LINES": "1"},
    "no programs": {"PATH": ""},
    "an unknown language": {"LANG": "xx_YY.nonsense", "LC_ALL": "xx_YY.nonsense"},
}


NEEDED_BY = dict.fromkeys(SURROUNDINGS, ("optimum",)) | {"no home": ("field",)}
"""What is tried in each: what is drawn looks for a home as well, where fonts are kept."""


@pytest.fixture(scope="module")
def told(sound_folder, tmp_path_factory):
    """What each command told in each of the surroundings, all of them run side by side."""
    caches = tmp_path_factory.mktemp("caches")
    (caches / "upwash").mkdir()
    kept = next(place for place in cache_folders() if place.exists())
    (caches / "upwash" / "kernels").symlink_to(kept, target_is_directory=True)
    started = {}
    for place, settings in SURROUNDINGS.items():
        for name in NEEDED_BY[place]:
            arguments = ["optimum", IBIS] if name == "optimum" else WRITING[name]
            environment = {**os.environ, "XDG_CACHE_HOME": str(caches), **settings}
            command = [sys.executable, "-c", "from upwash.cli import main; main()"]
            arguments = [one.replace("DIR", str(caches / f"{place} {name}")) for one in arguments]
            started[place, name] = subprocess.Popen(
                [*command, *arguments], env=environment, stdout=-1, stderr=-1, text=True, encoding="utf-8"
            )
    return {key: (*process.communicate(), process.returncode) for key, process in started.items()}


@pytest.mark.parametrize(
    ("place", "name"), [(place, name) for place in NEEDED_BY for name in NEEDED_BY[place]]
)
def test_surroundings_that_a_command_can_do_without(told, place, name):
    output, said, code = told[place, name]
    assert code == 0, said
    assert name != "optimum" or output == told["a narrow terminal", name][0]
    assert "Traceback" not in said and "compiling" not in said


if __name__ == "__main__":
    serve()
