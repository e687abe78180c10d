"""A wheel carries all that the package needs, and works where there is no checkout."""

import subprocess
import tarfile
import zipfile
from importlib import util
from pathlib import Path

import pytest
import upwash
from click.testing import CliRunner
from upwash.cli import main
from upwash.shipped import checkout, shipped

ROOT = Path(__file__).parents[1]
PACKAGE = Path(upwash.__file__).parent

_spec = util.spec_from_file_location("try_wheel", ROOT / "tools" / "try_wheel.py")
try_wheel = util.module_from_spec(_spec)
_spec.loader.exec_module(try_wheel)

PATTERNS = ("species/*.*", "sweeps/*.*", "results/reference/*.*")
BESIDE = sorted(path for pattern in PATTERNS for path in ROOT.glob(pattern))
WITHIN = sorted(path for path in PACKAGE.rglob("*.*") if path.is_file() and "__pycache__" not in path.parts)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The sdist and the wheel."""
    return try_wheel.build(tmp_path_factory.mktemp("built"))


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """The folder of an environment with the wheel in it."""
    folder = tmp_path_factory.mktemp("installed") / "environment"
    try_wheel.install(built[1], folder)
    return folder


def run(command, *arguments, cwd):
    told = subprocess.run(
        [command, *arguments], cwd=cwd, env=try_wheel.outside(), capture_output=True, text=True
    )
    assert told.returncode == 0, told.stderr
    return told.stdout


def test_a_checkout_reads_what_stands_at_its_top():
    assert checkout() == ROOT
    assert shipped("species") == ROOT / "species"


def test_the_wheel_holds_every_file_of_the_package_and_what_comes_with_it(built):
    with zipfile.ZipFile(built[1]) as wheel:
        names = {name for name in wheel.namelist() if ".dist-info/" not in name}
        expected = {f"upwash/{path.relative_to(PACKAGE).as_posix()}": path for path in WITHIN}
        expected |= {f"upwash/_shipped/{path.relative_to(ROOT).as_posix()}": path for path in BESIDE}
        assert names == set(expected)
        assert all(wheel.read(name) == path.read_bytes() for name, path in expected.items())


def test_the_sdist_holds_what_the_wheel_is_built_of(built):
    with tarfile.open(built[0]) as sdist:
        names = {name.partition("/")[2] for name in sdist.getnames()}
    assert {path.relative_to(ROOT).as_posix() for path in (*WITHIN, *BESIDE)} <= names


def test_it_works_in_an_empty_folder(installed, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    command = installed / "bin" / "upwash"
    # In this process what is printed is the checkout's own.
    for line in ("species list --json", "run reproduce --dry-run", "--version"):
        here = CliRunner().invoke(main, line.split(), prog_name="upwash")
        assert run(command, *line.split(), cwd=tmp_path) == here.stdout != ""
    assert list(tmp_path.iterdir()) == []


def test_it_takes_no_other_repositorys_commit_for_its_own(installed, tmp_path):
    subprocess.run(["git", "init", "--quiet", installed.parent], check=True)
    script = (
        "from upwash.batch.store import code_version; import upwash; print(upwash.__file__, code_version())"
    )
    file, version = run(installed / "bin" / "python", "-c", script, cwd=tmp_path).split()
    assert Path(file).is_relative_to(installed)
    assert version == upwash.__version__
