"""A solver of one's own: found in the current folder, tried before anything is stored, with columns of its own."""

import json
import subprocess
import sys

import pyarrow.parquet as pq
import pytest
from upwash.columns import COLUMNS, FLOAT, Column
from upwash.errors import UpwashError
from upwash.jobs.own_solver import BrokenContract, kept_to_contract, own_columns
from upwash.jobs.pair import Pair

SWEEP = """\
name = "sweep"
solver = "{module}:solve"
species = "northern-bald-ibis"
[grid]
mass_kg = {{ linspace = [1.1, 1.4, {jobs}] }}
"""
LOADING = """\
from upwash.columns import Column

def solve(job):
    loading = job.mass_kg * job.gravity_m_s2 / job.semispan_m**2
    light = {"rank": 0, "cost": 1.0, "is_v_optimum": False, "is_global_optimum": True, "loading_n_m2": loading}
    heavy = light | {"rank": 1, "cost": 2.0, "is_v_optimum": True, "loading_n_m2": 2 * loading, "class": "heavy"}
    return "solved", "", [light, heavy]

solve.columns = [
    Column("loading_n_m2", "N/m2", "weight over the square of the semispan"),
    Column("class", "", "what kind of bird that is", "text"),
]
"""


@pytest.fixture
def own(bench, request):
    """Write a solver, in a module of the test's own, and a sweep that names it."""
    of_the_test = f"own_{abs(hash(request.node.name))}"

    def write(text, jobs=3, module=of_the_test):
        (bench.folder / f"{module}.py").write_text(text)
        (bench.folder / "sweep.toml").write_text(SWEEP.format(module=module, jobs=jobs))
        return module

    return write


@pytest.fixture
def loaded(bench, own):
    """A sweep of the solver with columns of its own, run."""
    own(LOADING)
    bench.run()
    return bench


def test_a_module_in_the_current_folder_is_found_by_the_installed_command(bench, own):
    own(LOADING)
    # -P: as in an installed command, the current folder is not on the path.
    command = [sys.executable, "-P", "-c", "from upwash.cli import main; main()", "run", "./sweep.toml"]
    told = subprocess.run(command, cwd=bench.folder, capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    assert bench.status()["solved"] == 3


@pytest.mark.parametrize("name", ["solutions.parquet", "summary.parquet"])
def test_own_columns_are_stored_with_unit_and_description(loaded, name):
    loaded("aggregate", "results/sweep")
    table = pq.read_table(loaded.results / name)
    field = table.schema.field("loading_n_m2")
    assert field.metadata[b"unit"] == b"N/m2"
    assert field.metadata[b"description"] == b"weight over the square of the semispan"
    rows = table.to_pylist()
    v = [row for row in rows if row["is_v_optimum"]]
    assert len(v) == 3 and all(row["class"] == "heavy" for row in v)
    expected = [2 * row["mass_kg"] * row["gravity_m_s2"] / row["semispan_m"] ** 2 for row in v]
    assert [row["loading_n_m2"] for row in v] == pytest.approx(expected)


def test_every_command_reads_them(loaded):
    (first, *_) = (path.stem for path in loaded.job_files())

    def look():
        assert "0 done now, 3 before" in loaded.run()[1]
        assert json.loads(loaded("status", "results/sweep", "--json")[0])["solved"] == 3
        assert "loading_n_m2" in loaded("show", "results/sweep", first)[0]
        assert json.loads(loaded("show", "results/sweep", first, "--json")[0])[1]["class"] == "heavy"
        assert "agree in 2 rows" in loaded("rerun", "results/sweep", first)[1]
        findings = json.loads(loaded("check", "results/sweep", "--json", code=3)[0])["findings"]
        assert not [one for one in findings if "columns" in one["message"] or "gather" in one["message"]]

    look()
    loaded("merge", "merged", "results/sweep")
    loaded("aggregate", "results/sweep")
    look()
    loaded("aggregate", "merged")
    assert "agree in 3 rows" in loaded("diff", "results/sweep", "merged")[1]
    assert pq.read_schema(loaded.folder / "merged" / "summary.parquet").get_field_index("class") > 0


def test_diff_and_rerun_see_that_an_own_column_differs(loaded):
    path = loaded.job_files()[0]
    table = pq.read_table(path)
    place = table.schema.get_field_index("loading_n_m2")
    doubled = table.set_column(place, table.schema.field(place), [[1.0, 2.0]])
    pq.write_table(doubled, path, use_dictionary=False, write_page_checksum=True)
    out, _ = loaded("rerun", "results/sweep", path.stem, code=3)
    assert out.startswith("loading_n_m2: 2 of 2 rows")


def test_a_column_that_comes_later_is_null_before_and_one_that_changes_is_refused(bench, own):
    old = own(LOADING.replace('    Column("class"', "    #").replace(', "class": "heavy"', ""))
    bench.run()
    module = own(LOADING, module=old + "_later")
    bench.run()
    bench("aggregate", "results/sweep")
    # Another solver's jobs are others.
    assert bench.status()["others"] == 3
    retired = pq.read_table(bench.results / "retired.parquet")
    assert retired.column("class").null_count == retired.num_rows == 6
    own(LOADING.replace("N/m2", "kg"), module=module + "_changed")
    _, said = bench.run(code=2)
    assert "expected column 'loading_n_m2' as it was declared before (N/m2, float: weight" in said
    assert len(said.splitlines()) == 1


BAD = {
    "none": ("return None", "expected status, error and rows, found None"),
    "two": ('return "solved", []', "expected status, error and rows"),
    "status": (
        'return "done", "", [{"rank": 0}]',
        "expected a status of solved, infeasible, failed, found 'done'",
    ),
    "rows": ('return "solved", "", [1]', "expected a list of rows, each a dict by column, found [1]"),
    "no row": ('return "solved", "", []', "expected at least one row of a job that is solved"),
    "why": ('return "infeasible", "", []', "expected to learn why a job is infeasible"),
    "column": ('return "solved", "", [{"wingspan_in_feet": 4.0}]', "found wingspan_in_feet"),
    "type": ('return "solved", "", [{"rank": "best"}]', "ArrowInvalid"),
}


@pytest.mark.parametrize("body", BAD)
def test_a_broken_contract_is_told_before_anything_is_stored(bench, own, body):
    own(f"def solve(job):\n    {BAD[body][0]}\n")
    _, said = bench.run(code=2)
    last = said.splitlines()[-1]
    assert last.startswith("Error: solver, job ") and BAD[body][1] in last and "no result was stored" in last
    assert not bench.job_files() and bench.status()["left"] == 3


def test_a_job_that_fails_is_no_broken_contract(bench, own):
    own("def solve(job):\n    raise ZeroDivisionError('no lift')\n")
    bench.run(code=1)
    assert bench.status(code=1)["causes"] == {"ZeroDivisionError": 3}


@pytest.mark.parametrize(
    ("text", "error"),
    [
        ("solve = 3\n", "expected a function solve in"),
        ("def other(job): pass\n", "expected a function solve in"),
        ("def solve(): pass\n", "to take one argument, a job, found too many positional arguments"),
        (
            "def solve(job, bird): pass\n",
            "to take one argument, a job, found missing a required argument: 'bird'",
        ),
        ("import nothing_of_that_name\n", "No module named 'nothing_of_that_name'"),
        ("raise SystemExit(3)\n", "SystemExit: 3"),
        ("def solve(job): pass\nsolve.columns = ['x']\n", "to be a list of upwash.columns.Column"),
        (LOADING.replace("loading_n_m2", "cost"), "expected a name that no other column has"),
        (LOADING.replace("loading_n_m2", "class"), "expected a name that no other column has"),
        (LOADING.replace("loading_n_m2", "Wing Loading"), "expected a name of small letters"),
        (LOADING.replace('"N/m2"', '""'), "expected a description and, of numbers, a unit"),
        (LOADING.replace('"text"', '"string"'), "expected a type of float, integer, text, truth"),
    ],
)
def test_what_can_be_known_before_is_one_line_with_its_place(bench, own, text, error):
    own(text)
    _, said = bench.run(code=2)
    assert said.startswith("Error: ./sweep.toml, line 2: solver: ") or "sweep.toml, line 2: solver" in said
    assert error in said and len(said.splitlines()) == 1
    assert not bench.results.exists()


def test_the_contract_in_words():
    assert kept_to_contract(("infeasible", "nowhere", [])) == ("infeasible", "nowhere", [])
    assert kept_to_contract(("solved", None, ({"rank": 0},))) == ("solved", "", [{"rank": 0}])
    with pytest.raises(BrokenContract):
        kept_to_contract(["solved", "", [{}]])


def test_own_columns_are_none_unless_declared():
    assert own_columns(lambda job: None) == ()
    with pytest.raises(UpwashError, match="no other column"):
        twice = Column("twice", "1", "a column", FLOAT)
        solver = lambda job: None  # noqa: E731
        solver.columns = [twice, twice]
        own_columns(solver)
    assert set(Pair.rows.names) <= {column.name for column in COLUMNS}
