"""What is committed speaks of the project alone and installs the same everywhere."""

import re
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

# Spelled with gaps, so that this file does not match itself.
FOREIGN = {
    "a package registry's host": r"py[p]i\.org|python[h]osted\.org|[n]pmjs\.|deb\.[d]ebian\.|crates[.]io",
    "a package index option": r"--(extra-)?index-[u]rl|--trusted-[h]ost|--find-[l]inks",
    "a path of one machine": r"/[w]ork/(main|shared|\.)|/[r]oot/|/[h]ome/\w+/|\.\./[s]hared/|/[t]mp/upwash",
    "a tracker's number": r"\b[Ii]ssues? #?\d+\b|\(#\d+\)|\bGH-\d+",
}


def tracked_files():
    """Return the files that git tracks; skip in an unpacked archive, where there is no git."""
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git work tree")
    return [ROOT / name for name in listed.stdout.split("\0") if name and (ROOT / name).is_file()]


@pytest.mark.parametrize("what", FOREIGN)
def test_no_tracked_file_holds(what):
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for path in tracked_files()
        if b"\0" not in (content := path.read_bytes())
        and (match := re.search(FOREIGN[what], content.decode("utf-8")))
    ]
    assert found == []


def versions_in(lock):
    """Return the ``name==version ; marker`` lines of a lock file, each of which must carry a hash."""
    entries = re.split(r"\n(?=\S)", (ROOT / lock).read_text().strip())
    assert all(re.search(r"--hash=sha256:[0-9a-f]{64}", entry) for entry in entries)
    return {entry.partition("\\")[0].strip() for entry in entries}


def test_the_locks_agree_and_cover_what_the_project_asks_for():
    run, develop = versions_in("requirements.lock"), versions_in("requirements-dev.lock")
    assert run <= develop
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    asked = [*project["dependencies"], *project["optional-dependencies"]["dev"]]
    names = {re.match(r"[\w-]+", requirement)[0].lower() for requirement in asked} - {"upwash"}
    assert names <= {version.partition("==")[0] for version in develop}


def test_ci_runs_the_readmes_test_command():
    assert "make test" in (ROOT / "README.md").read_text()
    for target in ("test", "thorough"):
        assert re.search(rf"^make {target}\b", (ROOT / ".ci" / "run").read_text(), re.MULTILINE)
    assert "bash .ci/run" in (ROOT / ".github" / "workflows" / "ci.yml").read_text()


def test_the_release_is_named_once():
    citation = (ROOT / "CITATION.cff").read_text()
    version = re.search(r'__version__ = "(.+)"', (ROOT / "pipeline" / "upwash" / "__init__.py").read_text())[
        1
    ]
    assert f"\nversion: {version}\n" in citation
