"""The shape of the house: imports go downwards only, and every module has a name that says its one idea."""

import ast
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "pipeline" / "upwash"
MODULES = sorted(PACKAGE.rglob("*.py"))

# A room is a folder or a module right below the package. Each room -> the rooms that it may import from.
MAY_IMPORT = {
    "shipped": set(),
    "columns": set(),
    "errors": set(),
    "parts": set(),
    "kernel": {"parts"},
    "aero": {"kernel"},
    "optimum": {"aero", "columns", "errors", "kernel"},
    "place": {"aero", "columns", "errors", "kernel", "optimum"},
    "species": {"aero", "columns", "errors", "shipped"},
    "jobs": {"aero", "columns", "errors", "kernel", "optimum", "place"},
    "journey": {"aero", "columns", "errors", "optimum", "place", "species"},
    "sweep": {"aero", "columns", "errors", "jobs", "journey", "optimum", "shipped", "species"},
    "batch": {"columns", "errors", "jobs", "shipped", "sweep"},
    "study": {
        "aero",
        "batch",
        "columns",
        "errors",
        "jobs",
        "journey",
        "optimum",
        "place",
        "shipped",
        "species",
    },
    "paper": {"aero", "batch", "columns", "errors", "jobs", "optimum", "study"},
    "literature": {"aero", "columns", "errors", "optimum", "place", "shipped", "species", "study"},
    "report": {
        "aero",
        "batch",
        "columns",
        "errors",
        "jobs",
        "literature",
        "optimum",
        "paper",
        "place",
        "species",
        "study",
    },
    "ahead": {"aero", "errors", "kernel", "optimum", "place", "species", "study"},
    "cli": {
        "aero",
        "ahead",
        "batch",
        "columns",
        "errors",
        "jobs",
        "journey",
        "literature",
        "optimum",
        "paper",
        "place",
        "report",
        "shipped",
        "species",
        "study",
        "sweep",
    },
}

AERO_MAY_IMPORT = {
    "__future__",
    "collections",
    "dataclasses",
    "functools",
    "math",
    "numba",
    "numbers",
    "numpy",
    "typing",
}
NAMES_THAT_SAY_NOTHING = {"common", "core", "helpers", "misc", "shared", "utils"}


def name_of(path):
    """Return the path of a module below the package, as in ``jobs/job.py``."""
    return path.relative_to(PACKAGE).as_posix()


def room_of(path):
    """Return the room that a module stands in: its folder below the package, or its own name."""
    return name_of(path).split("/")[0].removesuffix(".py")


def imports_in(source, package):
    """Return the dotted names that a source imports anywhere in it; `package` resolves the relative ones."""
    names = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            parents = package.split(".")[: package.count(".") + 2 - node.level] if node.level else []
            module = ".".join([*parents, *filter(None, [node.module])])
            names |= {f"{module}.{alias.name}" for alias in node.names}
    return names


def imports_of(path):
    """Return the dotted names that a module of the package imports."""
    package = ".".join(["upwash", *path.relative_to(PACKAGE).parts[:-1]])
    return imports_in(path.read_text(encoding="utf-8"), package)


def rooms_imported_by(path):
    """Return the other rooms of the package that a module imports from."""
    parts = (name.split(".") for name in imports_of(path))
    return {part[1] for part in parts if part[0] == "upwash" and part[1] in MAY_IMPORT} - {room_of(path)}


@pytest.mark.parametrize(
    "statement",
    [
        "import upwash.aero.bird",
        "from upwash import aero",
        "from upwash.aero import bird",
        "from .. import aero",
    ]
    + ["from ..aero.bird import Bird", "def late():\n    from upwash.aero.bird import Bird"],
)
def test_an_import_is_seen_however_it_is_written(statement):
    assert any(name.startswith("upwash.aero") for name in imports_in(statement, "upwash.batch"))


# pipeline/upwash/__init__.py stands above the rooms: it names what is public, and loads each name when it is used.
@pytest.mark.parametrize("path", [path for path in MODULES if room_of(path) != "__init__"], ids=name_of)
def test_imports_only_from_rooms_below(path):
    assert rooms_imported_by(path) <= MAY_IMPORT[room_of(path)]


@pytest.mark.parametrize("path", [path for path in MODULES if room_of(path) == "aero"], ids=name_of)
def test_the_physics_needs_arrays_and_a_compiler_and_no_file(path):
    assert {name.split(".")[0] for name in imports_of(path)} <= AERO_MAY_IMPORT | {"upwash"}
    assert not any(
        isinstance(node, ast.Name) and node.id == "open" for node in ast.walk(ast.parse(path.read_text()))
    )


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_kernels_stand_in_their_own_folders_and_alone(path):
    is_compiled = path.parent.name == "compiled" and path.name != "__init__.py"
    assert ("upwash.kernel.kernel" in imports_of(path)) == is_compiled
    functions = [
        part
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef)
        # A function that makes kernels stands for them.
        for part in ([each for each in node.body if isinstance(each, ast.FunctionDef)] or [node])
    ]
    assert not is_compiled or all(
        any("kernel" in ast.unparse(each) for each in node.decorator_list) for node in functions
    )


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_a_module_says_what_it_is_for(path):
    assert not NAMES_THAT_SAY_NOTHING & set(path.relative_to(PACKAGE).with_suffix("").parts)
    assert ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
