"""What a sweep file means: which jobs it stands for, in which order, with which inputs."""

import math
from collections import Counter

import pytest
from upwash.errors import UpwashError
from upwash.jobs.flock import Flock
from upwash.optimum.settings import FlockRules
from upwash.species import load_species
from upwash.sweep import file, read_sweep
from upwash.sweep.block_reader import block_keys
from upwash.sweep.toml_lines import key_lines, line_of

IBIS = 'species = "northern-bald-ibis"\n'

SOBOL = '[{}sample]\nmethod = "sobol"\ncount = {}\n[{}sample.ranges]\n{}'
# Key -> in the file, in a block, beside it, and an input of which the two have no value in common.
OF_THE_FILE_AND_OF_A_BLOCK = {
    "model": ('model = "paper"', 'model = "limit"', "", "model"),
    "species": (IBIS, 'species = "mute-swan"', "", "species"),
    "objective": ('objective = "power"', 'objective = "force"', "", "objective"),
    "amplitude": ('amplitude = "strouhal"', 'amplitude = "stroke-angle"', "", "amplitude_convention"),
    "speed": ('speed = "least-power"', 'speed = "least-transport"', "", "speed_m_s"),
    "seed": ("seed = 3", "seed = [4, 5]", "", "seed"),
    "tolerance": ("tolerance = 1e-3", "tolerance = 1e-5", "", "tolerance"),
    "grid": ("[grid]\nmass_kg = [1.1, 1.2]", "[block.grid]\nmass_kg = [1.4]", "", "mass_kg"),
    "zip": ("[zip]\nmass_kg = [1.1, 1.2]", "[[block.zip]]\nmass_kg = [1.4]", "", "mass_kg"),
    "sample": (
        SOBOL.format("", 2, "", "mass_kg = [1.1, 1.2]"),
        SOBOL.format("block.", 4, "block.", "mass_kg = [1.3, 1.4]"),
        "",
        "mass_kg",
    ),
    "leader": ('leader = "mute-swan"', 'leader = ["dunlin", "whooper-swan"]', "", "ahead_species"),
    "speed_of": (
        'leader = "mute-swan"\nspeed_of = "leader"',
        'leader = "mute-swan"\nspeed_of = "mean"',
        "",
        "speed_m_s",
    ),
    "phase_lock": ("phase_lock = false", "phase_lock = true", "", "phase_lock"),
    "exclude": (
        "[[exclude]]\nseed = [1, 2]",
        "[[block.exclude]]\nseed = [3, 4]",
        "seed = [1, 2, 3, 4]\n",
        "seed",
    ),
    "flock": (
        '[flock]\nbirds = 3\nshape = "vee"',
        "[block.flock]\nbirds = 4",
        'kind = "flock"\n',
        "birds",
    ),
}


@pytest.fixture
def jobs(tmp_path):
    """Return a function from a sweep's text to its jobs."""

    def expand(text):
        path = tmp_path / "sweep.toml"
        path.write_text(text)
        return read_sweep(path).jobs

    return expand


def values(jobs, name):
    return [job.inputs()[name] for job in jobs]


class TestChoices:
    def test_a_species_alone_is_one_pair_by_the_defaults(self, jobs):
        (job,) = jobs(IBIS)
        bird = load_species("northern-bald-ibis").bird()
        assert (job.kind.name, job.objective, job.amplitude_convention) == ("pair", "force", "stroke-angle")
        assert (job.inputs()["leader_amplitude_m"], job.inputs()["leader_upstroke_span_ratio"]) == (
            bird.amplitude_m,
            bird.upstroke_span_ratio,
        )
        assert (
            job.model.core_radius_ratio,
            job.inputs()["stroke_states"],
            job.model.span_nodes,
            job.search.seed,
        ) == (0.171, 2, 2, 0)

    def test_lists_of_choices_multiply_and_the_first_varies_slowest(self, jobs):
        found = jobs('species = ["mute-swan", "dunlin"]\nobjective = ["power", "force"]\nseed = [1, 2]\n')
        assert [(job.species, job.objective, job.search.seed) for job in found[:3]] == [
            ("mute-swan", "power", 1),
            ("mute-swan", "power", 2),
            ("mute-swan", "force", 1),
        ]
        assert len(found) == 8

    def test_all_stands_for_the_whole_library(self, jobs):
        assert len(set(values(jobs('species = "all"\n'), "species"))) == 20

    def test_a_species_may_be_a_file_beside_the_sweep(self, jobs, tmp_path):
        library = file.SWEEP_FOLDER.parent / "species" / "mute-swan.toml"
        (tmp_path / "my-swan.toml").write_text(library.read_text())
        (job,) = jobs('species = "./my-swan.toml"\n')
        assert (job.species, job.bird.mass_kg) == ("my-swan", load_species("mute-swan").bird().mass_kg)

    def test_both_conventions_for_the_amplitude(self, jobs):
        found = jobs('species = "mute-swan"\namplitude = ["stroke-angle", "strouhal"]\n')
        swan = load_species("mute-swan")
        assert values(found, "leader_amplitude_m") == [
            swan.amplitude_m(convention) for convention in ("stroke-angle", "strouhal")
        ]

    def test_flocks_take_the_papers_by_default_and_lists_multiply(self, jobs):
        (default,) = jobs(IBIS + 'kind = "flock"\n')
        assert default.kind == Flock(6, FlockRules("echelon", "neighbour", "immediate"))
        text = (
            IBIS + 'kind = "flock"\n[flock]\nbirds = [2, 3]\nshape = ["vee", "echelon"]\nreading = "lone"\n'
        )
        assert Counter(values(jobs(text), "birds")) == {2: 2, 3: 2}

    def test_an_impossible_amplitude_is_a_job_and_no_mistake(self, jobs):
        (job,) = jobs('species = "dunlin"\namplitude = "strouhal"\n')
        assert job.inputs()["leader_amplitude_m"] > 2 * job.inputs()["semispan_m"]


class TestValues:
    def test_fixed_values_replace_the_species_own_and_move_its_amplitude(self, jobs):
        (job,) = jobs(IBIS + "[fixed]\nsemispan_m = 1.2\nspeed_m_s = 14\n")
        assert (job.inputs()["semispan_m"], job.bird.speed_m_s) == (1.2, 14.0)
        assert job.inputs()["leader_amplitude_m"] == pytest.approx(2 * 1.2 * math.sin(math.pi / 3), rel=1e-15)

    def test_grids_multiply_lists_and_rows(self, jobs):
        found = jobs(
            IBIS + "[grid]\nmass_kg = [1.2, 1.4]\nspeed_m_s = { linspace = [12, 16, 3] }\n"
            "period_s = { geomspace = [0.1, 0.4, 3] }\n"
        )
        assert len(found) == 18
        assert sorted(set(values(found, "speed_m_s"))) == [12.0, 14.0, 16.0]
        assert sorted(set(values(found, "period_s"))) == pytest.approx([0.1, 0.2, 0.4])

    def test_zipped_lists_go_side_by_side(self, jobs):
        found = jobs(IBIS + "[zip]\nmass_kg = [1.1, 1.2, 1.3]\nspeed_m_s = [13, 14, 15]\n")
        assert [(job.bird.mass_kg, job.bird.speed_m_s) for job in found] == [
            (1.1, 13.0),
            (1.2, 14.0),
            (1.3, 15.0),
        ]

    def test_two_zips_multiply(self, jobs):
        found = jobs(
            IBIS + "[[zip]]\nmass_kg = [1.1, 1.2]\nspeed_m_s = [13, 14]\n[[zip]]\nperiod_s = [0.2, 0.3]\n"
        )
        assert len(found) == 4

    def test_factors_scale_each_species_own_value(self, jobs):
        found = jobs(
            'species = ["mute-swan", "dunlin"]\n[grid]\nmass_kg = { values = [0.8, 1.2], relative = true }\n'
        )
        masses = [load_species(name).bird().mass_kg for name in ("mute-swan", "dunlin")]
        assert values(found, "mass_kg") == [factor * mass for mass in masses for factor in (0.8, 1.2)]

    def test_a_factor_on_the_amplitude_is_on_the_amplitude_by_convention(self, jobs):
        text = 'species = "mute-swan"\namplitude = "strouhal"\n[fixed]\nspeed_m_s = 15\n'
        (job,) = jobs(text + "amplitude_m = { value = 0.5, relative = true }\n")
        expected = 0.5 * load_species("mute-swan").amplitude_m("strouhal", speed_m_s=15.0)
        assert (job.inputs()["leader_amplitude_m"], job.amplitude_convention) == (expected, "strouhal")

    def test_an_amplitude_given_outright_follows_no_convention(self, jobs):
        (job,) = jobs(IBIS + "[fixed]\namplitude_m = 0.9\n")
        assert (job.inputs()["leader_amplitude_m"], job.amplitude_convention) == (0.9, "given")

    def test_the_resolution_of_the_wake_may_vary(self, jobs):
        found = jobs(IBIS + "[grid]\nspan_nodes = [2, 4]\ncore_radius_ratio = [0.1, 0.171]\n")
        assert {(job.model.span_nodes, job.model.core_radius_ratio) for job in found} == {
            (2, 0.1),
            (2, 0.171),
            (4, 0.1),
            (4, 0.171),
        }


class TestSamples:
    @pytest.mark.parametrize("method", ["latin-hypercube", "sobol"])
    def test_points_fill_the_ranges_evenly(self, jobs, method):
        found = jobs(
            IBIS + f'[sample]\nmethod = "{method}"\ncount = 16\nseed = 5\n'
            "[sample.ranges]\nmass_kg = [1.0, 2.0]\nspeed_m_s = { range = [0.8, 1.0], relative = true }\n"
        )
        for name, low, high in (("mass_kg", 1.0, 2.0), ("speed_m_s", 12.0, 15.0)):
            # One point in each sixteenth: that is what makes either method better than chance.
            cells = sorted(int(16 * (value - low) / (high - low)) for value in values(found, name))
            assert cells == list(range(16)), name

    def test_the_seed_decides(self, jobs):
        text = IBIS + '[sample]\nmethod = "sobol"\ncount = 4\nseed = {}\n[sample.ranges]\nmass_kg = [1, 2]\n'
        assert values(jobs(text.format(1)), "mass_kg") == values(jobs(text.format(1)), "mass_kg")
        assert values(jobs(text.format(1)), "mass_kg") != values(jobs(text.format(2)), "mass_kg")

    def test_within_species_takes_each_species_own_ranges(self, jobs):
        text = (
            'species = ["mute-swan", "dunlin"]\n[sample]\nmethod = "sobol"\ncount = 8\nwithin = "species"\n'
        )
        for job in jobs(text):
            ranges = load_species(job.species).ranges()
            for name in ("mass_kg", "semispan_m", "speed_m_s", "period_s", "density_kg_m3", "gravity_m_s2"):
                low, high = ranges[name]
                assert low <= job.inputs()[name] <= high, name

    def test_within_species_samples_only_the_parameters_named(self, jobs):
        text = IBIS + '[sample]\nmethod = "sobol"\ncount = 8\nwithin = "species"\nparameters = ["mass_kg"]\n'
        found = jobs(text)
        assert len(set(values(found, "mass_kg"))) == 8
        assert set(values(found, "speed_m_s")) == {15.0}

    def test_species_share_the_points_of_the_unit_cube(self, jobs):
        text = 'species = ["mute-swan", "dunlin"]\n[sample]\nmethod = "sobol"\ncount = 4\n'
        text += 'within = "species"\nparameters = ["mass_kg"]\n'
        shares = {}
        for job in jobs(text):
            low, high = load_species(job.species).ranges()["mass_kg"]
            shares.setdefault(job.species, []).append((job.bird.mass_kg - low) / (high - low))
        assert shares["mute-swan"] == pytest.approx(shares["dunlin"])

    def test_saltelli_changes_one_parameter_at_a_time(self, jobs):
        found = jobs(
            IBIS + '[sample]\nmethod = "saltelli"\ncount = 4\n'
            "[sample.ranges]\nmass_kg = [1, 2]\nspeed_m_s = [12, 15]\nperiod_s = [0.2, 0.3]\n"
        )
        names = ("mass_kg", "speed_m_s", "period_s")
        points = [tuple(job.inputs()[name] for name in names) for job in found]
        assert len(points) == 4 * (3 + 2)
        for first in range(0, len(points), 5):
            a, *mixed, b = points[first : first + 5]
            for number, point in enumerate(mixed):
                assert point == tuple(b[i] if i == number else a[i] for i in range(3))


class TestBlocks:
    def test_each_block_inherits_and_replaces_and_shared_jobs_come_once(self, jobs):
        text = IBIS + (
            'objective = ["force", "power"]\n[fixed]\nspeed_m_s = 14\n'
            "[[block]]\n[block.grid]\nmass_kg = [1.2, 1.3]\n"
            '[[block]]\nobjective = "force"\n[block.fixed]\nperiod_s = 0.25\n'
            "[block.grid]\nsemispan_m = [0.6, 0.7]\n"
        )
        found = jobs(text)
        # Mass 1.3 kg with semispan 0.6 m is the ibis itself, in both blocks.
        assert len(found) == 4 + 2 - 1
        assert set(values(found, "speed_m_s")) == {14.0}

    def test_a_blocks_fixed_value_comes_before_the_files(self, jobs):
        text = IBIS + "[fixed]\nspeed_m_s = 14\nmass_kg = 1.2\n"
        text += "[[block]]\n[block.fixed]\nspeed_m_s = 13\n[[block]]\n"
        assert [(job.bird.speed_m_s, job.bird.mass_kg) for job in jobs(text)] == [(13.0, 1.2), (14.0, 1.2)]

    @pytest.mark.parametrize("key", [key for key in block_keys() if key != "fixed"])
    def test_any_other_key_of_a_block_stands_in_the_place_of_the_files(self, jobs, key):
        files, blocks, kind, name = OF_THE_FILE_AND_OF_A_BLOCK[key]
        head = "" if key == "species" else IBIS
        shared = jobs(f"{head}{kind}{files}\n[[block]]\n")
        own = jobs(f"{head}{kind}{files}\n[[block]]\n{blocks}\n")
        alone = jobs(f"{head}{kind}[[block]]\n{blocks}\n")
        assert own == alone
        assert not set(values(own, name)) & set(values(shared, name))

    @pytest.mark.parametrize(
        ("condition", "left_out"),
        [
            ("{ above = 13 }", {14, 15}),
            ("{ below = 13 }", {11, 12}),
            ("{ above = 12, below = 15 }", {13, 14}),
            ("{ above = 12.5, below = 13.5 }", {13}),
            ("13", {13}),
            ("[11, 15]", {11, 15}),
        ],
    )
    def test_an_exclusion_ends_before_its_bounds(self, jobs, condition, left_out):
        text = IBIS + f"[grid]\nspeed_m_s = [11, 12, 13, 14, 15]\n[[exclude]]\nspeed_m_s = {condition}\n"
        assert set(values(jobs(text), "speed_m_s")) == {11, 12, 13, 14, 15} - left_out

    def test_exclusions_leave_out_what_meets_all_of_one(self, jobs):
        text = 'species = ["mute-swan", "dunlin"]\nobjective = ["force", "power"]\n'
        text += "[grid]\nspeed_m_s = [12, 14, 16]\n"
        text += '[[exclude]]\nspecies = "dunlin"\nspeed_m_s = { above = 13 }\n'
        text += '[[exclude]]\nobjective = "power"\nspeed_m_s = 12\n'
        found = {(job.species, job.objective, job.bird.speed_m_s) for job in jobs(text)}
        assert found == {
            (species, objective, speed)
            for species in ("mute-swan", "dunlin")
            for objective in ("force", "power")
            for speed in (12.0, 14.0, 16.0)
            if not (species == "dunlin" and speed > 13) and not (objective == "power" and speed == 12.0)
        }

    def test_an_exclusion_finds_a_grid_value_despite_rounding(self, jobs):
        text = IBIS + "[grid]\nmass_kg = { linspace = [1.0, 1.6, 7] }\n[[exclude]]\nmass_kg = 1.3\n"
        assert len(jobs(text)) == 6


class TestSweepFiles:
    def test_every_sweep_of_the_project_is_valid(self):
        paths = sorted(file.SWEEP_FOLDER.glob("*.toml"))
        assert "reproduce" in {read_sweep(path).name for path in paths}

    def test_the_paper_is_an_ibis_for_two_objectives(self):
        assert [(job.species, job.objective) for job in read_sweep("reproduce").jobs] == [
            ("northern-bald-ibis", "force"),
            ("northern-bald-ibis", "power"),
        ]

    def test_an_unknown_name_is_told_the_nearest(self):
        with pytest.raises(UpwashError, match="did you mean 'reproduce'"):
            read_sweep("reproduec")


TOML = '''top = 1  # [not.a.table]
"quoted.key" = [
  1, # ]
  2,
]
a.b = """
c = 3
"""
[table]
inner = { x = [1,
2] }
[[array]]
k = 'it = [is'
[array.below]
m = 1
[[array]]
[[array.deep]]
[[array.deep]]
n = 1
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("top",), 1),
        (("quoted.key",), 2),
        (("a", "b"), 6),
        (("table",), 9),
        (("table", "inner"), 10),
        (("table", "inner", "x"), 10),
        (("array", 0, "k"), 13),
        (("array", 0, "below", "m"), 15),
        (("array", 1), 16),
        (("array", 1, "deep", 1, "n"), 19),
        (("nowhere",), 1),
    ],
)
def test_every_key_is_found_on_its_line(path, line):
    assert line_of(path, key_lines(TOML)) == line


class TestABestSpeed:
    def test_is_the_lone_birds(self, jobs):
        found = jobs(IBIS + 'objective = "power"\nspeed = ["own", "least-power", "least-transport"]\n')
        assert values(found, "speed_m_s") == [
            15.0,
            pytest.approx(7.7259, abs=2e-4),
            pytest.approx(15.13, abs=2e-4),
        ]

    def test_follows_from_the_inputs_as_they_are_set(self, jobs):
        text = 'objective = "aerodynamic_power"\namplitude = "drag"\nspeed = "least-power"\n'
        slim, blunt = jobs(IBIS + text + "[grid]\nbody_drag_coefficient = [0.2, 1]\n")
        assert slim.bird.speed_m_s == pytest.approx(11.6, abs=0.05)
        assert blunt.bird.speed_m_s == pytest.approx(8.45, abs=0.01)


class TestAirAndDrag:
    def test_altitude_is_an_axis_and_gives_density_and_amplitude(self, jobs):
        found = jobs(
            IBIS + 'amplitude = "drag"\n[grid]\naltitude_m = [0, 3000]\nbody_drag_coefficient = [0.2, 1]\n'
        )
        ibis = load_species("northern-bald-ibis")
        assert [job.bird for job in found] == [
            ibis.bird("drag", altitude_m=altitude, body_drag_coefficient=coefficient)
            for altitude in (0.0, 3000.0)
            for coefficient in (0.2, 1.0)
        ]

    def test_a_drag_that_no_stroke_overcomes_is_a_job_and_no_mistake(self, jobs):
        (job,) = jobs('species = "dunlin"\namplitude = "drag"\n[fixed]\nbody_drag_coefficient = 1\n')
        assert job.inputs()["leader_amplitude_m"] > 2 * job.inputs()["semispan_m"]
