"""The documentation is true: it builds without a warning, its links hold, and its code does what it shows."""

import doctest
import importlib
import os
import re
import shlex
import subprocess
import sys
from contextlib import redirect_stdout
from io import StringIO
from itertools import zip_longest
from pathlib import Path

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.columns import (
    FLOCK_COLUMNS,
    FLOCK_SUMMARY_COLUMNS,
    SOLUTIONS_COLUMNS,
    SUMMARY_COLUMNS,
    TEXT,
    TRUTH,
)
from upwash.species.library import find_species
from upwash.sweep import read_sweep

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = [ROOT / "README.md", *sorted(DOCS.rglob("*.md"))]
FENCE = re.compile(r"^```(?P<language>\w+)(?: title=\"(?P<title>[^\"]+)\")?\n(?P<body>.*?)^```$", re.M | re.S)


def page_name(path):
    """Return a page's path below the root, to name its test."""
    return path.relative_to(ROOT).as_posix()


def blocks(page):
    """Return a page's fenced blocks, each as its language, its title if it has one, and its text."""
    return [(m["language"], m["title"], m["body"]) for m in FENCE.finditer(page.read_text(encoding="utf-8"))]


COLUMN_TABLES = ("Quantities", "Other columns")

# What this page shows is run on real results by the tests of reading them back.
RUN_ELSEWHERE = {"sweeps.md"}


def is_run(page):
    """Whether a page holds code that is run here."""
    return page.name not in RUN_ELSEWHERE and any(
        language in {"python", "console"} for language, _, _ in blocks(page)
    )


def run_session(text):
    """Run each line after ``$ upwash``; what it prints must be the lines below it, ``...`` being anything."""
    for step in re.split(r"^\$ ", text, flags=re.M)[1:]:
        command, _, shown = step.partition("\n")
        program, *arguments = shlex.split(command, comments=True)
        assert program == "upwash", f"only upwash is run in a console block, found: {command}"
        result = CliRunner().invoke(main, arguments, prog_name="upwash")
        assert result.exit_code == 0, f"{command}\n{result.output}"
        is_right = not shown.strip() or is_shown(result.stdout, shown)
        assert is_right, f"{command}\nshown:\n{shown}\nprinted:\n{result.stdout}"


def is_shown(printed, shown):
    """Whether what was printed is what is shown, ``...`` being anything and a space as good as several."""
    rules = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return doctest.OutputChecker().check_output(shown, printed, rules)


def test_the_site_builds_without_a_warning_and_every_link_in_it_leads_somewhere(tmp_path):
    pytest.importorskip("material", reason="the documentation's packages are not installed")
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", tmp_path / "site"]
    finished = subprocess.run(build, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    home = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
    assert not re.search(r"<(script|link|img)[^>]+(src|href)=\"?https?:", home.replace('rel="canonical"', ""))


@pytest.mark.parametrize("page", [ROOT / "README.md", ROOT / "CHANGELOG.md"], ids=page_name)
def test_links_outside_the_site_lead_somewhere(page):
    targets = re.findall(r"\]\((?!https?:)([^)#\s]+)", page.read_text(encoding="utf-8"))
    assert [target for target in targets if not (page.parent / target).exists()] == []


# These are run whenever the tests are; the code of other pages, which solves one thing after another, where all is.
FIRST_READ = {"README.md", "api.md", "extending.md", "species.md", "tutorial.md"}


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[] if page.name in FIRST_READ else pytest.mark.thorough)
        for page in PAGES
        if is_run(page)
    ],
    ids=page_name,
)
def test_code_in_the_documentation_does_what_it_shows(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for (language, title, body), following in zip_longest(blocks(page), blocks(page)[1:]):
        if title:
            (tmp_path / title).write_text(body, encoding="utf-8")
        elif language == "python":
            with redirect_stdout(StringIO()) as printed:
                exec(compile(body, str(page), "exec"), names)
            if printed.getvalue() and following and following[0] == "text":
                assert is_shown(printed.getvalue(), following[2]), printed.getvalue()
        elif language == "console":
            run_session(body)


SWEEPS = [body for language, _, body in blocks(DOCS / "sweeps.md") if language == "toml"]


@pytest.mark.parametrize("text", SWEEPS)
def test_a_sweep_shown_on_the_page_about_them_can_be_read(text, tmp_path):
    (tmp_path / "mybird.toml").write_text(
        find_species("dunlin").read_text(encoding="utf-8"), encoding="utf-8"
    )
    path = tmp_path / "shown.toml"
    path.write_text(text, encoding="utf-8")
    assert len(read_sweep(path).jobs) > 0


VALIDATED = re.findall(
    r"^\|.*\| (?:`([^`]+)` )?[^|]*\| `(tests/[^`]+)` \|$", (DOCS / "validation.md").read_text(), re.M
)


@pytest.mark.parametrize(("tolerance", "file"), sorted(set(VALIDATED)))
def test_a_tolerance_stands_in_the_test_that_the_page_on_validation_names(tolerance, file):
    assert len(VALIDATED) > 30
    assert re.search(rf"(?<![\w.]){re.escape(tolerance)}\b", (ROOT / file).read_text(encoding="utf-8"))


def column_units():
    """Return the unit of each column that the nomenclature lists, as written there."""
    page = (DOCS / "nomenclature.md").read_text(encoding="utf-8")
    quantities, others = (page.partition(f"## {head}\n")[2].partition("\n## ")[0] for head in COLUMN_TABLES)
    rows = re.findall(r"^\|[^|]+\|[^|]+\|[^|]+\| (`\w+`(?:, `\w+`)*) \| ([^|]+) \|", quantities, flags=re.M)
    rows += re.findall(r"^\| (`\w+`) \| ([^|]+) \|", others, flags=re.M)
    return [(name, unit) for cell, unit in rows for name in re.findall(r"\w+", cell)]


def test_every_column_of_the_results_is_in_the_nomenclature_once_with_its_unit():
    tables = (SOLUTIONS_COLUMNS, SUMMARY_COLUMNS, FLOCK_COLUMNS, FLOCK_SUMMARY_COLUMNS)
    units = {
        column.name: {TEXT: "text", TRUTH: "yes or no"}.get(column.type, column.unit)
        for table in tables
        for column in table
    }
    listed = column_units()
    assert sorted(name for name, _ in listed) == sorted(units)
    assert {name: unit.replace("³", "3").replace("²", "2") for name, unit in listed} == units


def equations():
    """Return the nomenclature's equation labels, each with the dotted name of what implements it."""
    page = (DOCS / "nomenclature.md").read_text(encoding="utf-8")
    return re.findall(r"^\| `([^`]+)` \|[^|]+\| `(upwash\.[^`]+)` \|$", page, flags=re.M)


@pytest.mark.parametrize(("label", "home"), equations())
def test_an_equation_of_the_paper_is_named_once_where_it_is_implemented(label, home):
    parts, source = home.split("."), ROOT / "pipeline"
    files = {source.joinpath(*parts[:end]).with_suffix(".py"): end for end in range(2, len(parts))}
    (path, end), *others = [(path, end) for path, end in files.items() if path.exists()]
    assert not others and hasattr(importlib.import_module(".".join(parts[:end])), parts[end])
    sources = [one for room in ("aero", "optimum") for one in (source / "upwash" / room).rglob("*.py")]
    cited = re.compile(rf"[(\s]{re.escape(label)}[),]")
    found = [one for one in sources for _ in cited.finditer(one.read_text(encoding="utf-8"))]
    assert found == [path]
