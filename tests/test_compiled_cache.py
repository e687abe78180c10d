"""Compiled code is kept between runs, and never outlives what it was made from."""

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numba
import numpy as np
import pytest
import upwash
from upwash import kernel as compiling
from upwash.kernel import kernel

PACKAGE = Path(upwash.__file__).parent

INNER = '''"""Inner."""
from upwash.kernel import kernel
from upwash.aero.constants import STEP

@kernel
def inner(x):
    """Add a step."""
    return x + STEP
'''
OUTER = '''"""Outer."""
from typing import NamedTuple
from upwash.kernel import kernel
from upwash.aero.inner import inner

class Pair(NamedTuple):
    first: float
    second: float

@kernel
def outer(pair):
    return 10 * inner(pair.first)
'''


@pytest.fixture
def small_package(tmp_path):
    """Make a package with this one's cache, a constant, and two kernels, one calling the other across files."""
    room = tmp_path / "upwash" / "aero"
    room.mkdir(parents=True)
    for name in ("__init__.py", "kernel.py", "parts.py"):
        shutil.copy(PACKAGE / name, room.parent / name)
    (room / "constants.py").write_text("STEP = 1.0\n")
    (room / "inner.py").write_text(INNER)
    (room / "outer.py").write_text(OUTER)
    return room


def run_outer(small_package, ahead="", **environment):
    """Call the outer kernel in a fresh process; return its result, and whether it was compiled."""
    script = (
        "from upwash.aero.outer import Pair, outer\n"
        "print(outer(Pair(1.0, 2.0)), sum(outer.stats.cache_hits.values()) == 0)"
    )
    inherited = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    where = {"cwd": small_package.parents[1], "env": {**inherited, **environment}}
    done = subprocess.run([sys.executable, "-c", ahead + script], capture_output=True, text=True, **where)
    assert done.returncode == 0, done.stderr
    result, is_compiled = done.stdout.split()
    return float(result), is_compiled == "True"


def edit(path, old, new):
    """Replace a piece of a file."""
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


@pytest.mark.parametrize(
    ("file", "old", "new", "result"),
    [
        ("inner.py", "x + STEP", "x - STEP", 0.0),
        ("inner.py", "@kernel", "@kernel(fastmath=True)", 20.0),
        ("constants.py", "1.0", "2.0", 30.0),
        ("outer.py", "first: float\n    second: float", "second: float\n    first: float", 30.0),
    ],
    ids=[
        "a kernel that is called",
        "how it is compiled",
        "a constant of a file without kernels",
        "order of fields",
    ],
)
def test_what_changes_the_code_is_compiled_again(small_package, file, old, new, result):
    assert run_outer(small_package) == (20.0, True)
    assert run_outer(small_package) == (20.0, False)
    edit(small_package / file, old, new)
    assert run_outer(small_package) == (result, True)


def test_another_version_of_numba_compiles_as_it_always_does(small_package):
    other = (
        "import importlib.metadata as about\n"
        "real = about.version\n"
        "about.version = lambda name: '0.99.0' if name == 'numba' else real(name)\n"
        "import sys\n"
        "sys.modules['upwash.parts'] = None\n"
    )
    assert run_outer(small_package, other) == (20.0, True)
    assert run_outer(small_package, other) == (20.0, False)


@pytest.mark.thorough
def test_a_kernel_that_moved_to_another_file_is_looked_for_there(small_package):
    assert run_outer(small_package) == (20.0, True)
    (small_package / "inner.py").rename(small_package / "within.py")
    edit(small_package / "outer.py", "upwash.aero.inner", "upwash.aero.within")
    assert run_outer(small_package) == (20.0, True)


def test_what_changes_no_code_is_not_compiled_again(small_package):
    assert run_outer(small_package) == (20.0, True)
    edit(small_package / "inner.py", '"""Add a step."""', '"""Add\n\n    one\n    step."""  # a comment')
    edit(small_package / "outer.py", "def outer(pair):", 'def outer(pair):\n    """Ten times inner."""')
    edit(small_package / "constants.py", "STEP", "OTHER = 3.0\nSTEP")
    for path in small_package.glob("*.py"):
        os.utime(path, (1e9, 1e9))
    assert run_outer(small_package) == (20.0, False)
    # A checkout that was moved takes its compiled code along.
    moved = small_package.parents[1] / "moved"
    moved.mkdir()
    shutil.move(small_package.parent, moved)
    assert run_outer(moved / "upwash" / "aero") == (20.0, False)


@pytest.mark.thorough
def test_packages_of_different_kernels_share_a_folder_and_no_code(small_package, tmp_path):
    other = tmp_path / "other" / "upwash"
    shutil.copytree(small_package.parent, other)
    edit(other / "aero" / "inner.py", "x + STEP", "x - STEP")
    shared = {"NUMBA_CACHE_DIR": str(tmp_path / "shared")}
    assert run_outer(small_package, **shared) == (20.0, True)
    assert run_outer(other / "aero", **shared) == (0.0, True)
    assert run_outer(small_package, **shared) == (20.0, False)
    assert run_outer(other / "aero", **shared) == (0.0, False)
    assert list((tmp_path / "shared").rglob("*outer*"))
    assert not (small_package.parent / "__pycache__" / "kernels").exists()


def test_importing_changes_nothing_in_the_process(tmp_path):
    script = f"""
import json, os, sys
sys.path.insert(0, {str(PACKAGE.parent)!r})
from numba import config, njit
settings = dict(vars(config))
environment = dict(os.environ)
import upwash, upwash.optimum
@njit
def own(x):
    return x
print(json.dumps([environment == dict(os.environ), settings == dict(vars(config)), type(own._cache).__name__]))
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert json.loads(done.stdout) == [True, True, "NullCache"]


@pytest.mark.thorough
def test_where_the_package_cannot_be_written_the_users_folder_serves_then_a_temporary_one(
    small_package, tmp_path
):
    # A file where a folder must be stands for a place that cannot be written, for any user.
    (small_package.parent / "__pycache__").write_text("")
    quiet = "import sys; sys.dont_write_bytecode = True\n"
    users, temporary = tmp_path / "users", tmp_path / "temporary"
    temporary.mkdir()
    where = {"XDG_CACHE_HOME": str(users), "HOME": str(users), "TMPDIR": str(temporary)}
    assert run_outer(small_package, quiet, **where) == (20.0, True)
    assert run_outer(small_package, quiet, **where) == (20.0, False)
    assert list(users.rglob("*outer*"))
    assert not list(temporary.iterdir())
    shutil.rmtree(users)
    users.write_text("")
    assert run_outer(small_package, quiet, **where) == (20.0, True)
    assert run_outer(small_package, quiet, **where) == (20.0, False)
    [folder] = temporary.iterdir()
    assert folder.stat().st_mode & 0o777 == 0o700
    # Where anybody may have put code it is neither run nor added to.
    folder.chmod(0o777)
    assert run_outer(small_package, quiet, **where) == (20.0, True)


@pytest.mark.thorough
def test_code_that_was_cut_short_is_compiled_again(small_package):
    assert run_outer(small_package) == (20.0, True)
    for path in (small_package.parent / "__pycache__" / "kernels").iterdir():
        path.write_bytes(path.read_bytes()[:-100])
    assert run_outer(small_package) == (20.0, True)
    assert run_outer(small_package) == (20.0, False)


def test_a_disk_without_room_costs_the_code_and_not_the_result(small_package, tmp_path):
    ahead = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
    where = {"PYTHONDONTWRITEBYTECODE": "1", "HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path)}
    where["TMPDIR"] = tempfile.mkdtemp(dir=tmp_path)
    assert run_outer(small_package, ahead, **where) == (20.0, True)
    assert not [path for path in tmp_path.rglob("*") if path.suffix in (".kernel", ".tmp")]


def test_a_kernel_names_what_it_reads():
    numbers = {"one": 1.0}

    @kernel
    def reads(x):
        return x + numbers["one"]

    @kernel
    def through_a_module(x):
        return x + compiling.DIGEST_SIZE

    assert "dict" in str(compiling._told(numbers, reads.py_func))
    with pytest.raises(TypeError, match=r"test_compiled_cache.*through_a_module.*upwash.kernel"):
        through_a_module(1.0)


@pytest.mark.parametrize(
    ("one", "other"),
    [(0.0, -0.0), (1, 1.0), (1, True), ((1, 2), (1, (2,))), (np.zeros(2), np.zeros((2, 1))), ("a", b"a")],
)
def test_constants_that_compile_differently_are_told_apart(one, other):
    def function():
        """Stand for a kernel's function."""

    assert compiling._told(one, function) != compiling._told(other, function)


def test_a_kernel_that_is_said_to_make_no_arrays_makes_none():
    @kernel(allocates=False)
    def total(values):
        found = 0.0
        for value in values:
            found += value
        return found

    @kernel(allocates=False)
    def doubled(values):
        return np.sum(values + values)

    assert total(np.ones(3)) == 3.0
    with pytest.raises(numba.core.errors.NumbaError, match="NRT required"):
        doubled(np.ones(3))


def test_what_is_told_is_the_same_in_every_process():
    script = (
        "from upwash.kernel import _name\n"
        "from upwash.optimum.compiled.boxes import clear_boxes\n"
        "print(_name(clear_boxes))"
    )
    names = {
        subprocess.run(
            [sys.executable, "-c", script],
            capture_output=True,
            text=True,
            check=True,
            env={**os.environ, "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }
    assert len(names) == 1
