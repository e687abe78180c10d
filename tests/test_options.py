"""Each option of each command changes something: what is solved, what is called, what is printed or what is written.

The options are those that the commands declare, so that a new one without an effect fails here. What takes long is
stood in for at the places where a command hands its work on; what an option then does there is tested with that.
"""

import re
import shutil
from contextlib import chdir
from types import SimpleNamespace

import click
import pytest
from click.testing import CliRunner
from report import studies
from upwash import Pose, cli
from upwash.ahead import PARTS, Compiled
from upwash.batch.check import Checked
from upwash.batch.dry_run import Foresight
from upwash.batch.runner import Tally
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.run import Ended
from upwash.literature.ledger import read_kept
from upwash.place.least import least_over
from upwash.place.survey import survey

IBIS = "northern-bald-ibis"
RESULTS = "results/pair"
JOB = studies.pair_rows()[0]["job_id"]

# How each command is called without options, in a folder that holds a sweep and its results.
CALLS = {
    "species list": [],
    "species show": ["mute-swan"],
    "species check": [IBIS],
    "species new": ["Common shelduck"],
    "optimum": [IBIS],
    "flock": [IBIS],
    # The ibis's own amplitude is that of either convention.
    "phase": ["mute-swan"],
    "robust": ["mute-swan"],
    "speed": ["mute-swan"],
    "migrate": ["mute-swan"],
    "field": [IBIS],
    "animate": [IBIS],
    # The ibis's own amplitude is that of either convention.
    "explore": ["mute-swan"],
    "evaluate": ["mute-swan", "seen.csv"],
    # The ibis's own amplitude is that of either convention.
    "map": ["--size", "4", "mute-swan"],
    "run": ["./sweep.toml"],
    "merge": ["merged", RESULTS],
    "status": [RESULTS],
    "aggregate": [RESULTS],
    "check": [RESULTS],
    "show": [RESULTS, JOB],
    "rerun": [RESULTS, JOB],
    "diff": [RESULTS, RESULTS],
    "page": [RESULTS],
    "reproduce": [],
    "claims": [RESULTS],
    "literature": [],
    "warm": [],
}
# What is chosen where it does not follow from the option's type.
VALUES = {
    "--x-min-m": "1.2",
    "--wingtip-gap-min-m": "-0.2",
    "--distance-min-m": "1.5",
    "--bearing-max-deg": "30",
    "--set": "speed_m_s=14",
    "--tolerance": "1e-3",
    "--results": "elsewhere",
    "--output": "elsewhere.gif",
    "--folder": "elsewhere",
    "--shard": "2/3",
    "--size": "9",
    "--model": "limit",
    "--leader": "greylag-goose",
    "--member": "greylag-goose",
    "--wavelengths": "2",
    "--sigma": "0.3",
    "--birds": "3",
    "--fuel": "0.2",
    "--altitude": "1000",
    "--profile": "way.csv",
    "--wind": "2",
    "--efficiency": "0.2",
    "--keep": "kept.json",
    "--figure": "drawn",
    "--sigma-m": "0.02",
    "--sigma-phase": "0.1",
    "--observed": "birds.csv",
    "--jobs": "3",
    "--phase-unit": "rad",
    "--over": "phase,stroke",
    "--x-m": "1,2",
    "--y-m": "0.5,1",
}
# A table of birds: one whose phase is not known, and one that pays with a stroke beyond the paper's bounds.
SEEN_BIRDS = """time,bird,x_m,y_m,z_m,phase,off_cm
0,A,1.2,0.904,0,,3
0,B,1.2,0.904,0,0.01,3
0,C,2.0,-0.8,0.1,0.3,3
"""
# An option that needs another: how the command is called without its effect, and with it.
TOGETHER = {
    ("optimum", "--speed-of"): tuple(
        ["--leader", "greylag-goose", "--speed-of", of] for of in ("follower", "leader")
    ),
    ("optimum", "--phase-lock"): ([], ["--no-phase-lock"]),
    ("flock", "--phase-lock"): ([], ["--no-phase-lock"]),
    ("evaluate", "--phase-lock"): ([], ["--no-phase-lock"]),
    ("phase", "--model"): ([], ["--model", "paper"]),
    ("explore", "--model"): ([], ["--model", "paper"]),
    ("optimum", "--distance-m"): (["--model", "limit"], ["--model", "limit", "--distance-m", "1.2"]),
    ("evaluate", "--columns"): ([], ["--columns", "off_cm=sigma_x_m"]),
    ("evaluate", "--wake"): (["--pairs"], ["--pairs", "--wake", "all-upstream"]),
    ("evaluate", "--heading"): (["--pairs"], ["--pairs", "--heading", "200"]),
    ("evaluate", "--output"): ([], ["--output", "told.parquet"]),
    ("map", "--z-m"): (["--over", "phase,stroke"], ["--over", "phase,stroke", "--z-m", "0.1"]),
    ("map", "--phase"): (["--plane", "xk"], ["--plane", "xk", "--phase", "0.1,0.4"]),
    ("run", "--backend"): ([], ["--backend", "dask", "--scheduler", "tcp://one:1"]),
    ("run", "--scheduler"): tuple(
        ["--backend", "dask", "--scheduler", address] for address in ("tcp://one:1", "tcp://two:2")
    ),
}
# What of the limit's wake a job states is not the paper's.
LIMIT = {
    "model": "limit",
    "stroke_states": 32,
    "stroke_rule": "gauss",
    "span_nodes": "exact",
    "wavelengths": "endless",
    "span_law": "stroke",
}
# What an option of a single problem changes in its job, and nothing else.
IN_THE_JOB = {
    "--objective": ("power", {"objective": "power"}),
    "--amplitude": ("strouhal", {"amplitude_convention": "strouhal"}),
    "--set": ("speed_m_s=14", {"speed_m_s": 14.0}),
    "--seed": ("7", {"seed": 7}),
    "--tolerance": ("1e-3", {"tolerance": 1e-3}),
    "--birds": ("3", {"birds": 3}),
    "--shape": ("vee", {"shape": "vee"}),
    "--wake": ("all-upstream", {"wake": "all-upstream"}),
    "--model": ("limit", LIMIT),
    "--wavelengths": ("2", {"model": "given", "wavelengths": 2}),
    "--reading": ("lone", {"reading": "lone"}),
    "--x-min-m": ("1.2", {"x_min_m": 1.2}),
    "--wingtip-gap-min-m": ("-0.2", {"wingtip_gap_min_m": -0.2}),
    "--distance-min-m": ("1.5", {"distance_min_m": 1.5}),
    "--bearing-max-deg": ("30", {"bearing_max_deg": 30.0}),
}


def options_of(path):
    """Return the options that a command declares, by their long name."""
    command = cli.main
    for name in path.split():
        command = command.get_command(click.Context(command), name)
    return {one.opts[0]: one for one in command.params if isinstance(one, click.Option)}


def paths():
    for name in (name for commands in cli.COMMANDS.values() for name in commands):
        command = cli.main.get_command(click.Context(cli.main), name)
        yield from (
            (f"{name} {sub}" for sub in command.commands) if isinstance(command, click.Group) else [name]
        )


OPTIONS = [(path, name) for path in paths() for name in options_of(path)]
# It prints when all of the paper is solved: test_reproduce.py.
STOPPED = ("reproduce", "--json")
OF_A_JOB = [
    (path, name)
    for path, name in OPTIONS
    if path in ("optimum", "flock", "field", "animate") and name in IN_THE_JOB
]


def chosen(path, name):
    """Return how a command is called with an option at another value than its default."""
    option = options_of(path)[name]
    if option.is_flag:
        return [name]
    if name in VALUES:
        return [name, VALUES[name]]
    if isinstance(option.type, click.Choice):
        return [name, next(value for value in option.type.choices if value != option.default)]
    assert isinstance(option.type, click.IntRange), f"{path} {name}: give it a value in VALUES"
    return [name, str(option.default + 1)]


@pytest.fixture(scope="module")
def template(tmp_path_factory):
    """A folder that holds a sweep and its results."""
    folder = tmp_path_factory.mktemp("options")
    studies.write_folder(folder / RESULTS, studies.pair_rows())
    (folder / "sweep.toml").write_text(f'species = "{IBIS}"\n', encoding="utf-8")
    (folder / "way.csv").write_text("distance_m,altitude_m\n0,500\n", encoding="utf-8")
    (folder / "birds.csv").write_text("x_m,y_m\n1.2,0.9\n", encoding="utf-8")
    (folder / "seen.csv").write_text(SEEN_BIRDS, encoding="utf-8")
    return folder


@pytest.fixture
def see(template, tmp_path, monkeypatch):
    """Return a function that runs a command and returns all that can be seen of it: calls, words, files."""
    calls = []

    def stand_in(target, answer):
        def called(*given, **named):
            plain = [
                one for one in (*given, *named.values()) if not callable(one) and not hasattr(one, "write")
            ]
            calls.append((target, *map(str, plain)))
            return answer(*given)

        monkeypatch.setattr(target, called)

    def stop(*given):
        raise UpwashError("far enough")

    def rows(job):
        if isinstance(job.kind, Flock):
            return studies.complete(studies.flock_rows(job.kind.birds)[: job.kind.birds], "flock")
        return studies.complete([one for one in studies.pair_rows() if one["objective"] == "force"], "pair")

    def survey_of(behind, birds, threads):
        calls.append(("survey", threads))
        return survey(behind, birds, threads)

    def least_of(behind, places, free, threads, told):
        calls.append(("least_over", behind.bounds, places.tolist(), free, threads))
        return least_over(behind, places, free)

    def pair_of(bird, objective, *, model, search):
        calls.append(("solve_pair", bird, objective, search))
        return SimpleNamespace(v_optimum=SimpleNamespace(pose=Pose(1.5, 1.8, 0.0, bird.stroke, 0.4)))

    def drawn(found, species, model, observed):
        calls.append(("draw", species, model, None if observed is None else observed.tolist()))

    def fly(journey, keep, **given):
        calls.append(("migrate", str(journey), str(given)))
        keep({})
        return studies.flight_frame()

    monkeypatch.setattr("upwash.study.observed.evaluation.survey", survey_of)
    stand_in("upwash.study.observed.evaluation.solve_pair", lambda *given: SimpleNamespace(v_optimum=None))
    monkeypatch.setattr("upwash.study.saving_map.least_over", least_of)
    monkeypatch.setattr("upwash.study.saving_map.solve_pair", pair_of)
    monkeypatch.setattr("upwash.report.figures.saving_map.draw_saving_map", drawn)
    stand_in("upwash.jobs.run.solve", rows)
    stand_in("upwash.jobs.run.run_job", lambda job: Ended(job, rows(job)))
    stand_in("upwash.jobs.flock.flock_of", lambda job: job)
    stand_in("upwash.optimum.joint.improve_together", stop)
    stand_in("upwash.study.limit_ranges.limit_ranges", lambda *given: [])
    stand_in("upwash.study.phase_rule.phase_rules", lambda *given: studies.phase_frames())
    stand_in("upwash.study.robustness.robustness", lambda *given: studies.drift_frame())
    stand_in("upwash.study.best_speed.best_speeds", lambda *given: studies.speed_frame())
    monkeypatch.setattr("upwash.study.migration.migrate", fly)
    stand_in("upwash.literature.ledger.judge_literature", read_kept)
    stand_in("upwash.report.figures.catalogue.save_all", lambda *given: [])
    stand_in("upwash.report.animation.write_animation", lambda birds, path: None)
    stand_in("upwash.batch.runner.run_sweep", lambda *given: Tally(jobs=1, kept=0))
    stand_in("upwash.batch.dry_run.foresee", lambda *given: Foresight(1, 1, None, 2, "nothing", False))
    stand_in("upwash.batch.check.check", lambda *given: Checked())
    stand_in("upwash.report.explorer.page.write_explorer", lambda path: path)
    stand_in("upwash.report.page.write_page", lambda *given: "index.html")
    stand_in("upwash.cli.reproduce.solve_and_check", stop)
    stand_in(
        "upwash.ahead.compile_ahead", lambda begun: [Compiled(part, 0) for part in PARTS if not begun(part)]
    )

    def run(path, options):
        calls.clear()
        folder = tmp_path / "here"
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(template, folder)
        with chdir(folder):
            result = CliRunner().invoke(cli.main, [*path.split(), *CALLS[path], *options])
        if result.exception and not isinstance(result.exception, SystemExit):
            raise result.exception
        # The names of what was gathered end by chance.
        files = sorted(
            re.sub("-[0-9a-f]{8}[.]", ".", str(one.relative_to(folder))) for one in folder.rglob("*")
        )
        return result.exit_code, result.stdout, result.stderr, tuple(calls), files

    return run


SEEN = {}


@pytest.mark.parametrize(("path", "name"), [one for one in OPTIONS if one != STOPPED])
def test_an_option_changes_something(see, path, name):
    without, with_it = TOGETHER[path, name] if (path, name) in TOGETHER else ([], chosen(path, name))
    if (path, *without) not in SEEN:
        SEEN[path, *without] = see(path, without)
        # Else any option would seem to change something.
        assert see(path, without) == SEEN[path, *without]
    after = see(path, with_it)
    assert after != SEEN[path, *without]
    assert "No such option" not in after[2] and "Invalid value" not in after[2]


@pytest.mark.parametrize(
    "path", [path for path in CALLS if CALLS[path] and path not in ("species check", "explore")]
)
def test_a_command_asks_for_each_argument_that_it_needs(see, monkeypatch, path):
    monkeypatch.setitem(CALLS, path, CALLS[path][:-1])
    code, out, said, calls, _ = see(path, [])
    assert (code, out, calls) == (2, "", ())
    assert "Missing argument" in said and len(said.splitlines()) == 1


@pytest.mark.parametrize(("path", "name"), OF_A_JOB)
def test_an_option_of_a_problem_changes_its_own_input_alone(monkeypatch, path, name):
    jobs = []

    def solve(job):
        jobs.append(job.inputs())
        raise UpwashError("far enough")

    monkeypatch.setattr("upwash.jobs.run.solve", solve)
    value, expected = IN_THE_JOB[name]
    for options in ([], [name, value]):
        CliRunner().invoke(cli.main, [path, IBIS, *options])
    before, after = jobs
    assert {key for key in after if after[key] != before[key]} == set(expected)
    assert {key: after[key] for key in expected} == expected


@pytest.mark.parametrize(("path", "name"), OPTIONS)
def test_a_least_and_most_number_are_taken_and_what_is_beyond_is_not(monkeypatch, path, name):
    option = options_of(path)[name]
    for bound, step in ((getattr(option.type, "min", None), -1), (getattr(option.type, "max", None), 1)):
        if bound is not None:
            assert option.type.convert(bound, option, None) == bound
            with pytest.raises(click.BadParameter):
                option.type.convert(bound + step, option, None)


# What the help of a command tells: least and most of each number.
ENDS = {
    ("flock", "--birds"): (2, None),
    ("animate", "--birds"): (2, 24),
    ("field", "--size"): (2, 10000),
    ("map", "--size"): (2, 5000),
    ("map", "--jobs"): (1, 1024),
    ("evaluate", "--jobs"): (1, 1024),
    ("run", "--workers"): (1, 1024),
    **{
        (path, "--seed"): (0, None)
        for path in ("optimum", "flock", "phase", "robust", "field", "animate", "map")
    },
}


@pytest.mark.parametrize(("path", "name"), ENDS)
def test_least_and_most_are_those_that_people_know(path, name):
    kind = options_of(path)[name].type
    assert (kind.min, kind.max) == ENDS[path, name]
