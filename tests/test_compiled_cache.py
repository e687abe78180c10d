"""Compiled code is kept between runs, and never outlives the sources that it was made from."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import upwash

PACKAGE = Path(upwash.__file__).parent


@pytest.fixture
def small_package(tmp_path):
    """Make a package with this one's cache and two compiled functions, one calling the other across files."""
    rooms = tmp_path / "upwash" / "aero"
    rooms.mkdir(parents=True)
    for name in ("__init__.py", "compiled_cache.py"):
        shutil.copy(PACKAGE / name, rooms.parent / name)
    (rooms / "inner.py").write_text(
        "from numba import njit\n\n@njit(cache=True)\ndef inner(x):\n    return x + 1\n"
    )
    (rooms / "outer.py").write_text(
        "from numba import njit\nfrom upwash.aero.inner import inner\n\n"
        "@njit(cache=True)\ndef outer(x):\n    return 10 * inner(x)\n"
    )
    return rooms


def run_outer(small_package, **environment):
    """Call the outer function in a fresh process; return its result, cache hits, and the cache's path."""
    script = (
        "from upwash.aero.outer import outer\n"
        "print(outer(1), sum(outer.stats.cache_hits.values()), outer.stats.cache_path)"
    )
    inherited = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    where = {"cwd": small_package.parents[1], "env": {**inherited, **environment}}
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, **where)
    result, hits, path = done.stdout.split(maxsplit=2)
    return int(result), int(hits), Path(path.strip())


def test_compiled_code_is_kept_until_any_file_it_depends_on_changes(small_package):
    assert run_outer(small_package)[:2] == (20, 0)
    assert run_outer(small_package)[:2] == (20, 1)
    inner = small_package / "inner.py"
    inner.write_text(inner.read_text().replace("x + 1", "x + 2"))
    assert run_outer(small_package)[:2] == (30, 0)


def test_a_process_does_not_inherit_the_folder_of_older_sources(small_package):
    older = small_package.parent / "__pycache__" / "numba-000000000000"
    path = run_outer(small_package, NUMBA_CACHE_DIR=str(older))[2]
    assert not path.is_relative_to(older)
    assert path.is_relative_to(older.parent)


def test_the_users_own_folder_is_respected(small_package, tmp_path):
    assert run_outer(small_package, NUMBA_CACHE_DIR=str(tmp_path / "mine"))[2].is_relative_to(
        tmp_path / "mine"
    )


def test_numba_uses_the_folder_even_when_it_was_imported_first(small_package):
    script = "import numba, upwash; print(numba.config.CACHE_DIR)"
    where = {
        "cwd": small_package.parents[1],
        "env": {k: v for k, v in os.environ.items() if k != "NUMBA_CACHE_DIR"},
    }
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, **where)
    assert Path(done.stdout.strip()).parent == small_package.parent / "__pycache__"
