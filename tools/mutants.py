"""Put faults into the code, one at a time, and see which of them the tests notice: ``make mutants``.

A seeded sample of one-line faults is drawn evenly over the rooms of the package: an operator exchanged, a comparison
shifted or turned round, a number changed by one, a condition negated, a loop left early.  Each is put into a copy of
the tree, and the tests that are meant for its room are run there until one fails.  What is done is written down at
once, so that an interrupted run goes on where it stopped; other code, another seed or another count begins anew.
"""

from __future__ import annotations

import ast
import difflib
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import click
import cosmic_ray.plugins
from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code

ROOT = Path(__file__).parents[1]
PACKAGE = Path("pipeline", "upwash")
KEPT = ROOT / ".mutants"

# Room of the package -> the tests that are meant for it, those that take seconds first.  The tests named after the
# module that holds a fault are asked before the others.
TESTS = {
    "species": ["test_species_library.py", "test_species_command.py", "test_species_file.py"],
    "sweep": [
        *("test_sweep.py", "test_sweep_identity.py", "test_sweep_mistakes.py", "test_checked_before.py"),
        "batch/test_own_solver.py",
    ],
    "cli": [
        *(
            "test_cli_contract.py",
            "test_species_command.py",
            "test_optimum_command.py",
            "test_flock_command.py",
        ),
        *("test_options.py", "test_bad_input.py", "batch/test_store.py", "batch/test_compare.py"),
        *("batch/test_merge.py", "batch/test_run.py", "batch/test_check.py", "batch/test_recovery.py"),
        *("report/test_pictures.py", "paper/test_claims.py", "test_broken_environments.py"),
        "test_reproduce.py",
    ],
    "study": ["study/test_sensitivity.py", "study/test_comparison.py", "paper", "study", "report"],
    "batch": [
        *("batch/test_store.py", "batch/test_compare.py", "batch/test_dry_run.py", "batch/test_recovery.py"),
        *("batch/test_run.py", "batch/test_merge.py", "batch/test_check.py", "batch/test_reading_back.py"),
        *("test_checked_before.py", "batch"),
    ],
    "aero": ["aero"],
    "optimum": ["optimum", "test_optimum_command.py", "test_flock_command.py"],
    "jobs": [
        *("batch/test_kinds.py", "batch/test_own_solver.py", "batch/test_limit_jobs.py"),
        *(
            "test_sweep_identity.py",
            "test_checked_before.py",
            "batch/test_check.py",
            "batch/test_forgeries.py",
        ),
        "batch",
    ],
    "place": ["place", "test_robust_command.py", "study/test_observed.py", "test_evaluate_command.py"],
    "paper": ["paper", "report/test_tables.py", "test_reproduce.py"],
    "literature": ["literature"],
}
# Processor time that a process of the tests may take, and time on the clock: an endless loop is noticed by the first
# alone, however busy the machine is, a standstill by the second.
LEAST_PROCESSOR_S = 300.0
LEAST_TIMEOUT_S = 3600.0
NO_TESTS = 5  # as pytest ends where none is marked so

# Faults that people make; no shifts of bits, and no decorator left out.
ARITHMETIC = [("Add", "Sub"), ("Sub", "Add"), ("Mul", "Div"), ("Div", "Mul"), ("Pow", "Mul"), ("Mod", "Mul")]
COMPARISONS = [("Lt", "LtE"), ("LtE", "Lt"), ("Gt", "GtE"), ("GtE", "Gt"), ("Eq", "NotEq"), ("NotEq", "Eq")]
COMPARISONS += [("Lt", "Gt"), ("Gt", "Lt"), ("Is", "IsNot"), ("IsNot", "Is"), ("LtE", "GtE"), ("GtE", "LtE")]
FAULTS = [
    *(f"core/ReplaceBinaryOperator_{one}_{other}" for one, other in ARITHMETIC),
    *(f"core/ReplaceComparisonOperator_{one}_{other}" for one, other in COMPARISONS),
    *("core/ReplaceUnaryOperator_Delete_Not", "core/ReplaceUnaryOperator_USub_UAdd", "core/AddNot"),
    *(
        "core/ReplaceAndWithOr",
        "core/ReplaceOrWithAnd",
        "core/ReplaceTrueWithFalse",
        "core/ReplaceFalseWithTrue",
    ),
    *("core/ReplaceBreakWithContinue", "core/ReplaceContinueWithBreak", "core/NumberReplacer"),
]

Fault = dict[str, Any]


def faults_in(path: Path) -> list[Fault]:
    """Return the faults that might be put into a module."""
    nodes = list(ast_nodes(get_ast(path.read_text(encoding="utf-8"))))
    found = []
    for name in FAULTS:
        operator = cosmic_ray.plugins.get_operator(name)()
        positions = [start for node in nodes for start, _ in operator.mutation_positions(node)]
        for occurrence, (line, _) in enumerate(positions):
            found.append(
                {"module": str(path.relative_to(ROOT)), "line": line, "fault": name, "occurrence": occurrence}
            )
    return found


def is_fault(fault: Fault) -> bool:
    """Whether a fault changes what its module does, and not annotations alone."""
    source = (ROOT / fault["module"]).read_text(encoding="utf-8")
    return meaning_of(mutated_code(fault, source)) not in ("", meaning_of(source))


def meaning_of(source: str) -> str:
    """Return what a source does, without annotations; "" if it is no Python."""
    try:
        tree = ast.parse(source)
    except SyntaxError:
        return ""
    for node in ast.walk(tree):
        for name in ("annotation", "returns"):
            if hasattr(node, name):
                setattr(node, name, ast.Constant(None))
    return ast.dump(tree)


def draw(count: int, seed: int, rooms: tuple[str, ...]) -> list[Fault]:
    """Draw faults evenly over the rooms and, within a room, over its lines; return those of some rooms, or of all."""
    chosen = []
    for number, room in enumerate(TESTS):
        if rooms and room not in rooms:
            continue
        generator = random.Random(f"{seed} {room}")
        paths = sorted((ROOT / PACKAGE / room).rglob("*.py"))
        lines = [(path, line) for path in paths for line in range(1, len(path.read_text().splitlines()) + 1)]
        generator.shuffle(lines)
        wanted = count // len(TESTS) + (number < count % len(TESTS))
        by_path: dict[Path, list[Fault]] = {}
        for path, line in lines:
            if wanted == 0:
                break
            if path not in by_path:
                by_path[path] = list(faults_in(path))
            here = [fault for fault in by_path[path] if fault["line"] == line and is_fault(fault)]
            if here:
                fault = generator.choice(here)
                chosen.append(fault | {"room": room, "change": difference(fault)})
                wanted -= 1
    return chosen


def copy_tree(folder: Path) -> None:
    """Make a copy of what git tracks, as it stands in the work tree."""
    tracked = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=True)
    shutil.rmtree(folder, ignore_errors=True)
    for name in filter(None, tracked.stdout.split("\0")):
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, folder / name)


def is_noticed(fault: Fault, folder: Path, timeout_s: float) -> bool:
    """Put a fault into a copy of the tree, run the tests of its room there, and take it out again."""
    module = folder / fault["module"]
    source = module.read_text(encoding="utf-8")
    module.write_text(mutated_code(fault, source), encoding="utf-8")
    try:
        return not passes(tests_for(fault), folder, timeout_s)
    finally:
        module.write_text(source, encoding="utf-8")


def seconds_without_a_fault(room: str, folder: Path) -> float:
    """Return how long a room's tests take where nothing is wrong; then they must pass."""
    begun = time.monotonic()
    if not passes(TESTS[room], folder):
        found = f"see {folder / 'tests.log'}"
        raise click.ClickException(f"{room}: expected tests that pass before a fault is put in, {found}")
    taken_s = time.monotonic() - begun
    click.echo(f"{room}: {taken_s:.0f} s without a fault", err=True)
    return taken_s


def limit_processor_time(limit_s: float) -> None:
    """Let this process and each that it begins take no more processor time than this."""
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (int(limit_s), most))


def tests_for(fault: Fault) -> list[str]:
    """Return the tests of a fault's room, those named after its module first."""
    name = Path(fault["module"]).stem
    return sorted(TESTS[fault["room"]], key=lambda path: name not in Path(path).stem)


def passes(tests: list[str], folder: Path, timeout_s: float | None = None) -> bool:
    """Whether tests pass in a copy of the tree, and within a time."""
    environment = os.environ | {
        "PYTHONPATH": str(folder / "pipeline"),
        "PYTHONDONTWRITEBYTECODE": "1",
        # What one copy compiled serves the others: it is found by what it was compiled from.
        "NUMBA_CACHE_DIR": str(KEPT / "kernels"),
    }
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    command += [f"tests/{path}" for path in tests if (folder / "tests" / path).exists()]
    with (folder / "tests.log").open("w") as log:
        for mark in ("not thorough", "thorough"):
            try:
                done = subprocess.run(
                    [*command, "-m", mark],
                    cwd=folder,
                    env=environment,
                    stdout=log,
                    stderr=log,
                    timeout=timeout_s,
                    check=False,
                )
            except subprocess.TimeoutExpired:
                return False
            if done.returncode not in (0, NO_TESTS):
                return False
    return True


def mutated_code(fault: Fault, source: str) -> str:
    """Return a module's source with a fault in it."""
    operator = cosmic_ray.plugins.get_operator(fault["fault"])()
    code: str = mutate_code(source, operator, fault["occurrence"])
    return code


def difference(fault: Fault) -> str:
    """Show the line that a fault changes, before and after."""
    source = (ROOT / fault["module"]).read_text(encoding="utf-8")
    lines = difflib.unified_diff(
        source.splitlines(), mutated_code(fault, source).splitlines(), lineterm="", n=0
    )
    return "\n".join(f"    {line}" for line in list(lines)[3:])


@click.command()
@click.option("--count", default=100, show_default=True, help="Faults to put in, over all rooms.")
@click.option("--seed", default=0, show_default=True, help="Seed of the sample.")
@click.option("--workers", default=2, show_default=True, help="Faults tried at the same time.")
@click.option("--room", "rooms", type=click.Choice(list(TESTS)), multiple=True, help="This room's alone.")
@click.option("--again", is_flag=True, help="Try those again that were not noticed, as after adding a test.")
def main(count: int, seed: int, workers: int, rooms: tuple[str, ...], again: bool) -> None:
    """Put a sample of faults into the code and print how many the tests notice, by room, and the survivors."""
    code = subprocess.run(
        ["git", "rev-parse", "--short", f"HEAD:{PACKAGE}"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=True,
    )
    record = KEPT / f"{code.stdout.strip()}-{seed}-{count}.jsonl"
    record.parent.mkdir(exist_ok=True)
    lines = record.read_text(encoding="utf-8").splitlines() if record.exists() else []
    done = {key_of(fault): fault for fault in map(json.loads, lines) if fault["noticed"] or not again}
    sample = draw(count, seed, rooms)
    left = [fault for fault in sample if key_of(fault) not in done]
    folders: SimpleQueue[Path] = SimpleQueue()
    for number in range(workers):
        copy_tree(KEPT / f"tree-{number}")
        folders.put(KEPT / f"tree-{number}")
    timeouts_s: dict[str, float] = {}

    def attempt(fault: Fault) -> Fault:
        folder = folders.get()
        begun = time.monotonic()
        try:
            noticed = is_noticed(fault, folder, timeouts_s[fault["room"]])
            return fault | {"noticed": noticed, "taken_s": round(time.monotonic() - begun, 1)}
        finally:
            folders.put(folder)

    with ThreadPoolExecutor(workers) as pool, record.open("a", encoding="utf-8") as file:
        for room in dict.fromkeys(fault["room"] for fault in left):
            taken_s = seconds_without_a_fault(room, KEPT / "tree-0")
            timeouts_s[room] = LEAST_TIMEOUT_S + 5.0 * taken_s
            limit_processor_time(LEAST_PROCESSOR_S + 2.0 * taken_s)
            for fault in pool.map(attempt, [fault for fault in left if fault["room"] == room]):
                done[key_of(fault)] = fault
                print(json.dumps(fault), file=file, flush=True)
                word = "noticed" if fault["noticed"] else "NOT NOTICED"
                click.echo(f"{fault['module']}:{fault['line']} {word} ({fault['taken_s']} s)", err=True)
    results = [done[key_of(fault)] for fault in sample]
    for room in rooms or TESTS:
        of_room = [fault for fault in results if fault["room"] == room]
        click.echo(f"{room:10} {sum(fault['noticed'] for fault in of_room):3} of {len(of_room):3} noticed")
    click.echo(f"{'all':10} {sum(fault['noticed'] for fault in results):3} of {len(results):3} noticed")
    for fault in results:
        if not fault["noticed"]:
            click.echo(f"\n{fault['module']}:{fault['line']}\n{fault['change']}")


def key_of(fault: Fault) -> tuple[str, str, int]:
    """Return what tells one fault from another."""
    return fault["module"], fault["fault"], fault["occurrence"]


if __name__ == "__main__":
    main()
