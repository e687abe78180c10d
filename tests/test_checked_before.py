"""Whatever can be known to be wrong is refused before anything runs, by the same rules wherever it is stated.

The cases are made of the inputs as they are declared, so that a new input is tried as the others are.
"""

import math
from dataclasses import fields

import pytest
from upwash import Bird, WakeModel, load_species, solve_flock, solve_pair
from upwash.aero.checked import rules_of
from upwash.aero.pose import Pose, Stroke
from upwash.aero.power import COST_FUNCTIONS
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.jobs.job import Job
from upwash.jobs.pair import Pair
from upwash.optimum.settings import FLOCK_CHOICES, FlockRules, SearchSettings
from upwash.optimum.spacing import UNITS, Spacing
from upwash.species import AMPLITUDE_CONVENTIONS
from upwash.species.library import LIBRARY_FOLDER
from upwash.species.quantity import QUANTITIES
from upwash.sweep import read_sweep
from upwash.sweep.choices import CHOICES, PARAMETERS
from upwash.sweep.single import single_job

IBIS = load_species("northern-bald-ibis")
BIRD = IBIS.bird()
BIRD_FILE = (LIBRARY_FOLDER / "northern-bald-ibis.toml").read_text(encoding="utf-8")

# As TOML and the command line write them -> as Python does.
NO_INPUT = {
    "0": 0,
    "-1": -1,
    "-0.0": -0.0,
    "1e-300": 1e-300,
    "1e300": 1e300,
    "1" + "0" * 18: 10**18,
    "nan": math.nan,
    "inf": math.inf,
    "-inf": -math.inf,
    "true": True,
    '"1.3"': "1.3",
    "{}": {},
}
LIMIT = WakeModel.named("limit")
FLOCK = {"birds": 6, "shape": "echelon", "wake": "neighbour", "reading": "immediate"}
USUAL = {"objective": "force", "seed": 0, "tolerance": 1e-4}
WORDS = {"objective": COST_FUNCTIONS, "amplitude": AMPLITUDE_CONVENTIONS, "kind": ("pair",), **FLOCK_CHOICES}


def is_legal(name, value):
    """Whether a value is one that an input may have: any whole seed, say."""
    return CHOICES.get(name, PARAMETERS.get(name)).broken_by(value) == ""


BAD_PARAMETERS = [
    (name, text) for name in PARAMETERS for text, value in NO_INPUT.items() if not is_legal(name, value)
]
BAD_CHOICES = [
    (name, text) for name in CHOICES for text, value in NO_INPUT.items() if not is_legal(name, value)
]


def assert_refused(text, tmp_path, *words):
    """A sweep is refused with the line of its last line."""
    path = tmp_path / "sweep.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UpwashError) as refused:
        read_sweep(path)
    message = str(refused.value)
    assert message.startswith(f"{path}, line {text.count(chr(10)) + 1}: "), message
    assert "expected " in message and "\n" not in message
    assert all(word in message for word in words), message


def test_what_is_no_input_is_none_but_where_nothing_is_a_value():
    legal = {(name, text) for name in PARAMETERS for text, value in NO_INPUT.items() if is_legal(name, value)}
    # Nothing may be shed, the sea is as high as nothing, and wingtips may overlap.
    nothing = ("0", "-0.0", "1e-300")
    where = ("circulation_ratio", "altitude_m", "wingtip_gap_min_m")
    assert legal == {(name, text) for name in where for text in nothing} | {("wingtip_gap_min_m", "-1")}


@pytest.mark.parametrize(("name", "text"), BAD_PARAMETERS)
class TestParameters:
    @pytest.mark.parametrize("form", ["[fixed]\nX = V", "[grid]\nX = [V]", "[zip]\nX = [V]"])
    def test_in_a_sweep(self, tmp_path, name, text, form):
        sweep = 'species = "northern-bald-ibis"\n' + form.replace("X", name).replace("V", text)
        assert_refused(sweep, tmp_path, name, "found ")

    def test_at_either_end_of_a_sampled_range(self, tmp_path, name, text):
        for ends in (f"[{text}, 1.0]", f"[1e-9, {text}]"):
            head = 'species = "northern-bald-ibis"\n[sample]\nmethod = "sobol"\ncount = 2\n[sample.ranges]\n'
            assert_refused(f"{head}{name} = {ends}", tmp_path, name)

    def test_on_the_command_line(self, name, text):
        with pytest.raises(UpwashError, match=f"--set {name}: expected ") as refused:
            single_job(Pair, "northern-bald-ibis", [f"{name}={text}"], "stroke-angle", **USUAL)
        assert "found " in str(refused.value)

    def test_from_python(self, name, text):
        value = NO_INPUT[text]
        if name in rules_of(WakeModel):
            with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
                # In Python it is what endless is elsewhere.
                WakeModel(**{name: -math.inf if (name, value) == ("wavelengths", math.inf) else value})
            return
        if name in UNITS:
            with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
                Spacing(**{name: value})
            return
        if name == "position_sigma_ratio":
            with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
                Job("ibis", "power", "given", BIRD, position_sigma_ratio=value)
            return
        if name in ("model", "distance_m"):
            with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
                solve_pair(
                    BIRD, **{"model": LIMIT, name: WakeModel.named(value) if name == "model" else value}
                )
            return
        with pytest.raises(UpwashError, match=f"{name}: expected .*, found "):
            IBIS.bird("stroke-angle", **{name: value})
        if name in rules_of(Bird):
            inputs = {field: getattr(BIRD, field) for field in rules_of(Bird)}
            with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
                Bird(**{**inputs, name: value})


@pytest.mark.parametrize(("name", "text"), BAD_CHOICES)
class TestChoices:
    def test_in_a_sweep(self, tmp_path, name, text):
        head = 'species = "northern-bald-ibis"\n'
        head += 'kind = "flock"\n[flock]\n' if name in FLOCK else ""
        for written in (text, f"[{text}]"):
            assert_refused(f"{head}{name} = {written}", tmp_path, name, "found ")

    def test_on_the_command_line(self, name, text):
        kind, choices = (Flock, USUAL | FLOCK) if name in FLOCK else (Pair, USUAL)
        with pytest.raises(UpwashError, match=f"--{name}: expected .*, found "):
            single_job(kind, "northern-bald-ibis", [], "stroke-angle", **choices | {name: NO_INPUT[text]})


@pytest.mark.parametrize("name", WORDS)
@pytest.mark.parametrize("text", ['"nosuch"', '""', "1", "true", "[[]]", "{}", '" force"'])
def test_an_unknown_word(tmp_path, name, text):
    head = 'species = "northern-bald-ibis"\n'
    head += 'kind = "flock"\n[flock]\n' if name in FLOCK else ""
    assert_refused(f"{head}{name} = {text}", tmp_path, name, "one of ")


@pytest.mark.parametrize("text", NO_INPUT)
@pytest.mark.parametrize("key", ["value", "low", "high"])
@pytest.mark.parametrize("name", QUANTITIES)
def test_a_species_quantity(tmp_path, name, key, text):
    head, table, tail = BIRD_FILE.partition(f"[{name}]\n")
    quantity = getattr(IBIS.quantities[name], key)
    tail = tail.replace(f"{key} = {quantity!r}\n", f"{key} = {text}\n", 1)
    path = tmp_path / "bird.toml"
    path.write_text(head + table + tail, encoding="utf-8")
    with pytest.raises(UpwashError) as refused:
        load_species(path)
    assert str(refused.value).startswith(f"{path}: [{name}]")
    assert "expected " in str(refused.value) and "\n" not in str(refused.value)


@pytest.mark.parametrize(
    "settings",
    [
        {"mass_kg": 450},
        {"semispan_m": 60},
        {"speed_m_s": 300},
        {"period_s": 1e-3},
        {"gravity_m_s2": 980},
        {"density_kg_m3": 1000},
        {"amplitude_m": 0.01},
        {"stroke_half_angle_deg": 0.5},
    ],
)
class TestNoBird:
    """What each value allows by itself, but no bird is."""

    def test_in_a_sweep(self, tmp_path, settings):
        ((name, value),) = settings.items()
        sweep = f'species = "northern-bald-ibis"\n[fixed]\n{name} = {value}'
        assert_refused(sweep, tmp_path, name, "look at the values and units")

    def test_on_the_command_line(self, settings):
        ((name, value),) = settings.items()
        with pytest.raises(UpwashError, match=f"{name}: .* look at the values and units"):
            single_job(Pair, "northern-bald-ibis", [f"{name}={value}"], "stroke-angle", **USUAL)

    def test_from_python(self, settings):
        with pytest.raises(UpwashError, match="look at the values and units"):
            IBIS.bird("stroke-angle", **settings)


def test_an_impossible_amplitude_hides_no_other_mistake(tmp_path):
    # By this convention a pigeon's amplitude is beyond its wingspan, which is a result.
    head = 'species = "homing-pigeon"\namplitude = "strouhal"\n[fixed]\n'
    assert_refused(f"{head}upstroke_span_ratio = 0.9", tmp_path, "makes thrust")
    assert_refused(f"{head}mass_kg = 100", tmp_path, "W/(rho b^2 U^2)")


@pytest.mark.parametrize(
    ("solver", "words"),
    [
        ("nosuch.module:fn", "ModuleNotFoundError"),
        ("math:nosuch", "a function nosuch in math, found none"),
        ("math:pi", "found something else"),
    ],
)
def test_a_solver_that_is_not_there(tmp_path, solver, words):
    assert_refused(f'species = "northern-bald-ibis"\nsolver = "{solver}"', tmp_path, words)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[flock]\nbirds = [1000000000]", "at most 1000 ("),
        ("[flock]\nwavelengths = 99999999", "at most 1000 ("),
        ("[grid]\nspan_nodes = [1000000000]", "at most 1000 ("),
        ("[grid]\ncore_radius_ratio = { value = 1e9, relative = true }", "0.001 to 1 ("),
    ],
)
def test_a_bound_says_why(tmp_path, text, words):
    assert_refused(f'species = "northern-bald-ibis"\nkind = "flock"\n{text}', tmp_path, words)


def held_by(kind):
    """Return the values of each of a class's inputs that its rules refuse."""
    return [
        (kind, name, text)
        for name, rule in rules_of(kind).items()
        for text, value in NO_INPUT.items()
        if rule.broken_by(value)
    ]


@pytest.mark.parametrize(
    ("kind", "name", "text"),
    [case for kind in (Stroke, Pose, WakeModel, SearchSettings, FlockRules) for case in held_by(kind)],
)
def test_what_a_call_from_python_takes(kind, name, text):
    usual = {
        Stroke: {"amplitude_m": 1.0, "span_ratio": 0.4},
        Pose: {"x_m": 1.0, "y_m": 1.0, "z_m": 0.0, "stroke": Stroke(1.0, 0.4), "phase": 0.5},
    }
    with pytest.raises(ValueError, match=f"^{name}: expected .*, found "):
        kind(**usual.get(kind, {}) | {name: NO_INPUT[text]})


@pytest.mark.parametrize("kind", [Bird, Stroke, WakeModel, SearchSettings, FlockRules])
def test_no_input_is_without_a_rule(kind):
    assert set(rules_of(kind)) == {entry.name for entry in fields(kind)}


@pytest.mark.parametrize("text", NO_INPUT)
def test_the_number_of_birds_from_python(text):
    with pytest.raises(ValueError, match=r"^birds: expected .*, found "):
        solve_flock(BIRD, NO_INPUT[text])


@pytest.mark.parametrize("objective", ["nosuch", "", 1, None, "Force"])
def test_an_unknown_objective_from_python(objective):
    for solve in (lambda: solve_flock(BIRD, 2, objective), lambda: solve_pair(BIRD, objective)):
        with pytest.raises(ValueError, match=r"^objective: expected one of .*, found "):
            solve()


@pytest.mark.parametrize("name", sorted(rules_of(Bird)))
@pytest.mark.parametrize("value", [1e-9, 1e9])
def test_whatever_a_bird_may_be_has_finite_forces(name, value):
    """Whether at the ends of what is let in, or refused there, nothing ends as an error of arithmetic."""
    inputs = {field: getattr(BIRD, field) for field in rules_of(Bird)} | {name: value}
    try:
        bird = Bird(**inputs)
    except ValueError as error:
        assert "expected " in str(error)
        return
    numbers = [bird.weight_n, bird.drag_n, bird.circulation_m2_s, bird.lift_n(0.4), bird.thrust_n(0.1, 0.4)]
    assert all(map(math.isfinite, numbers))
    assert bird.lift_n(bird.upstroke_span_ratio) == pytest.approx(bird.weight_n, rel=1e-12)


# Least and most of each input, both of them allowed; the last digit is that of the number's kind.
REACH = (1e-9, 1e9)
ENDS = {
    **dict.fromkeys(
        ("mass_kg", "semispan_m", "speed_m_s", "period_s", "density_kg_m3", "gravity_m_s2"), REACH
    ),
    "amplitude_m": REACH,
    "stroke_half_angle_deg": (1e-9, 90.0),
    "upstroke_span_ratio": (1e-9, math.nextafter(1.0, 0.0)),
    "circulation_ratio": (0.0, 1e9),
    "core_radius_ratio": (1e-3, 1.0),
    "span_nodes": (2, 1000),
    "stroke_states": (2, 1000),
    "seed": (0, 2**63 - 1),
    "tolerance": (1e-12, math.nextafter(1.0, 0.0)),
    "birds": (2, 1000),
    "wavelengths": (1, 1000),
    "distance_m": REACH,
    "x_min_m": REACH,
    "wingtip_gap_min_m": (-1000.0, 1000.0),
    "distance_min_m": REACH,
    "bearing_max_deg": (0.1, 90.0),
    "wing_area_m2": REACH,
    "body_drag_coefficient": REACH,
    "altitude_m": (0.0, 11000.0),
    "position_sigma_ratio": (1e-4, 1.0),
}
OF_WORDS = [name for name, rule in PARAMETERS.items() if rule.words.startswith("one of ")]


@pytest.mark.parametrize("name", [name for name in (*PARAMETERS, *CHOICES) if name not in OF_WORDS])
def test_an_input_reaches_to_its_ends_and_no_further(name):
    for end, beyond in zip(ENDS[name], (-math.inf, math.inf), strict=True):
        step = 1 if beyond > 0 else -1
        assert is_legal(name, end)
        assert not is_legal(name, end + step if isinstance(end, int) else math.nextafter(end, beyond))


@pytest.mark.parametrize("name", OF_WORDS)
def test_an_input_that_is_a_word_is_one_of_those_that_are_told(name):
    told = PARAMETERS[name].words.removeprefix("one of ").split(", ")
    assert len(told) > 1
    assert all(is_legal(name, word) for word in told)
    assert not any(is_legal(name, word) for word in ("", told[0].upper(), told[0] + "s", 0))


@pytest.mark.parametrize(
    ("name", "most", "is_most_allowed"),
    [
        ("amplitude_m", 2.0 * BIRD.semispan_m, True),
        ("stroke_half_angle_deg", 90.0, True),
        # From there on a lone bird makes no thrust.
        ("upstroke_span_ratio", math.pi / 4.0, False),
    ],
)
def test_a_stroke_reaches_to_where_wings_can_make_it(name, most, is_most_allowed):
    inner, outer = math.nextafter(most, 0.0), math.nextafter(most, math.inf)
    allowed, refused = (most, outer) if is_most_allowed else (inner, most)
    assert IBIS.bird("stroke-angle", **{name: allowed})
    with pytest.raises(UpwashError, match=name.partition("_half")[0]):
        IBIS.bird("stroke-angle", **{name: refused})
    assert QUANTITIES["stroke_half_angle"].rule.broken_by(90.0) == ""
    assert QUANTITIES["upstroke_span_ratio"].rule.broken_by(math.pi / 4.0) != ""
