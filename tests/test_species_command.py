"""The commands ``upwash species``: what they print, where, and the walk from an empty file to a bird."""

import json
import math
import re

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.species import load_library, load_species
from upwash.species.library import LIBRARY_FOLDER
from upwash.species.quantity import QUANTITIES

LIBRARY = {species.slug: species for species in load_library()}


def species(*arguments):
    return CliRunner().invoke(main, ["species", *arguments], prog_name="upwash")


def file_of(slug):
    return (LIBRARY_FOLDER / f"{slug}.toml").read_text(encoding="utf-8")


def files_in(folder):
    return {path.name: path.read_text(encoding="utf-8") for path in folder.iterdir()}


class TestList:
    def test_shows_each_bird_and_how_each_value_is_known(self):
        result = species("list")
        assert result.exit_code == 0
        rows = result.stdout.splitlines()[1:]
        assert [row.split()[0] for row in rows] == sorted(LIBRARY)
        by_name = {row.split()[0]: row for row in rows}
        assert by_name["northern-bald-ibis"].endswith("g g g m g g")
        assert by_name["mute-swan"].endswith("m m m c c a")
        assert "a assumed" in result.stderr

    def test_as_json_is_what_the_files_say(self):
        listed = json.loads(species("list", "--json").stdout)
        assert {one["slug"]: one["mass_kg"] for one in listed} == {
            slug: one.quantities["mass"].value for slug, one in LIBRARY.items()
        }
        assert set(listed[0]["basis"]) == set(QUANTITIES)


class TestShow:
    def test_gives_every_value_with_its_source_and_both_conventions(self):
        result = species("show", "Northern bald ibis")
        assert result.exit_code == 0
        assert "Geronticus eremita" in result.stdout
        for name, quantity in LIBRARY["northern-bald-ibis"].quantities.items():
            assert f"\n{name} " in result.stdout
            assert quantity.source in result.stdout
        assert result.stdout.count("h = 1.039 m, half-angle 60 deg") == 2
        assert "Warning: stroke_half_angle is the species' own" in result.stderr

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_says_in_what_formation_a_bird_flies_if_that_is_known(self, slug):
        known = LIBRARY[slug].formation
        told = [line for line in species("show", slug).stdout.splitlines() if line.startswith("flies in: ")]
        assert told == ([f"flies in: {known.shape} ({known.basis}: {known.source})"] if known else [])

    def test_says_where_a_convention_is_impossible(self):
        result = species("show", "dunlin")
        assert re.search(r"^strouhal +impossible$", result.stdout, re.M)
        assert json.loads(species("show", "dunlin", "--json").stdout)["amplitude"]["strouhal"] is None

    def test_as_json_holds_numbers_in_si(self):
        shown = json.loads(species("show", "mute-swan", "--json").stdout)
        assert shown["quantities"]["mass"]["value"] == 10.597
        assert shown["amplitude"]["stroke-angle"]["amplitude_m"] == LIBRARY["mute-swan"].amplitude_m()
        assert any("as-ibis" in caveat for caveat in shown["caveats"])

    def test_an_unknown_bird_is_one_line(self):
        result = species("show", "mute-swann")
        assert result.exit_code == 2
        assert result.stdout == ""
        assert result.stderr.count("\n") == 1
        assert "did you mean mute-swan" in result.stderr


class TestCheck:
    def test_passes_the_library_and_warns_of_what_is_not_measured(self):
        result = species("check")
        assert result.exit_code == 0
        assert result.stdout.splitlines() == [f"ok  {slug}" for slug in sorted(LIBRARY)]
        assert "Warning: mute-swan: not measured: upstroke_span_ratio assumed (as-ibis)" in result.stderr
        assert "Before comparing species: 15 of 20 wingbeat frequencies" in result.stderr

    def test_warns_of_air_that_is_not_the_librarys(self, tmp_path):
        path = tmp_path / "bird.toml"
        text = file_of("northern-bald-ibis").replace("value = 1.29\n", "value = 1.225\n")
        path.write_text(text, encoding="utf-8")
        result = species("check", str(path))
        assert result.exit_code == 0
        assert "air_density is 1.225, not the 1.29" in result.stderr
        assert "confounds bird and air" in result.stderr

    def test_warns_of_an_unusual_dimensionless_group(self, tmp_path):
        path = tmp_path / "bird.toml"
        slow = file_of("northern-bald-ibis").replace("value = 15.0\n", "value = 7.0\n")
        path.write_text(slow.replace("low = 12.0\n", "low = 6.0\n"), encoding="utf-8")
        result = species("check", str(path))
        assert result.exit_code == 0
        assert "W/(rho b^2 U^2): expected 0.03 to 0.4" in result.stderr

    def test_goes_on_after_a_wrong_file_and_exits_2(self, tmp_path):
        wrong = tmp_path / "wrong.toml"
        wrong.write_text("mass = 1", encoding="utf-8")
        result = species("check", str(wrong), "mute-swan", "no-such-bird")
        assert result.exit_code == 2
        assert result.stdout == "ok  mute-swan\n"
        errors = [line for line in result.stderr.splitlines() if line.startswith("Error: ")]
        assert "wrong.toml" in errors[0] and "no-such-bird" in errors[-1]

    def test_as_json_holds_errors_and_warnings(self, tmp_path):
        wrong = tmp_path / "wrong.toml"
        wrong.write_text("mass = 1", encoding="utf-8")
        result = species("check", "--json", str(wrong), "dunlin", "mute-swan")
        assert result.exit_code == 2
        report = json.loads(result.stdout)
        assert [one["ok"] for one in report["files"]] == [False, True, True]
        assert "wrong.toml" in report["files"][0]["error"]
        assert any("impossible" in warning for warning in report["files"][1]["warnings"])
        assert report["comparison"]


class TestNew:
    # What a reader of one paper on the white-faced ibis would write, table by table.
    ANSWERS = {
        "mass": (516, 418, 614, "g"),
        "wingspan": (92.3, 87.7, 96.9, "cm"),
        "wing_area": (0.126, 0.107, 0.145, "m2"),
        "speed": (48, 40, 56, "km/h"),
    }

    def test_a_new_bird_is_a_template_then_a_file_that_passes_then_a_bird(self, tmp_path):
        result = species("new", "White-faced ibis", "--folder", str(tmp_path))
        assert result.exit_code == 0
        path = tmp_path / "white-faced-ibis.toml"
        assert result.stdout == f"{path}\n"
        assert "species check" in result.stderr
        text = path.read_text(encoding="utf-8")
        assert 'common_name = "White-faced ibis"' in text

        unedited = species("check", str(path))
        assert unedited.exit_code == 2
        assert "scientific_name: expected a line of text, found '?'" in unedited.stderr

        text = text.replace('scientific_name = "?"', 'scientific_name = "Plegadis chihi"')
        text = text.replace('source = "?"', 'source = "Pennycuick 2008"')
        for name, (value, low, high, unit) in self.ANSWERS.items():
            head, heading, rest = text.partition(f"[{name}]")
            rest = re.sub(r'value = "\?"\nunit = "[^"]+"', f'value = {value}\nunit = "{unit}"', rest, count=1)
            rest = rest.replace('low = "?"', f"low = {low}", 1).replace('high = "?"', f"high = {high}", 1)
            text = head + heading + rest
        path.write_text(text, encoding="utf-8")

        edited = species("check", str(path))
        assert (edited.exit_code, edited.stdout) == (0, "ok  white-faced-ibis\n")
        bird = load_species(path).bird()
        assert (bird.mass_kg, bird.semispan_m) == pytest.approx((0.516, 0.4615))
        assert bird.speed_m_s == pytest.approx(48 / 3.6)
        half_angle = math.radians(33.5 * 0.923**-0.24)
        assert bird.amplitude_m == pytest.approx(0.923 * math.sin(half_angle))
        assert bird.density_kg_m3 == LIBRARY["northern-bald-ibis"].bird().density_kg_m3

    def test_never_touches_a_file_that_is_there(self, tmp_path):
        (tmp_path / "my-bird.toml").write_text("mine", encoding="utf-8")
        result = species("new", "my bird", "--folder", str(tmp_path))
        assert result.exit_code == 2
        assert "it is unchanged" in result.stderr
        assert files_in(tmp_path) == {"my-bird.toml": "mine"}

    def test_never_writes_through_a_link(self, tmp_path):
        (tmp_path / "elsewhere").mkdir()
        (tmp_path / "my-bird.toml").symlink_to(tmp_path / "elsewhere" / "target.toml")
        assert species("new", "my-bird", "--folder", str(tmp_path)).exit_code == 2
        assert files_in(tmp_path / "elsewhere") == {}

    @pytest.mark.parametrize(
        "name", ["Mönchsgeier", "Bewick's swan", 'a "quoted" bird', "my-bird.toml", "x" * 80]
    )
    def test_an_odd_name_still_makes_valid_toml(self, tmp_path, name):
        assert species("new", name, "--folder", str(tmp_path)).exit_code == 0
        (path,) = tmp_path.iterdir()
        assert re.fullmatch(r"[a-z0-9-]+\.toml", path.name)
        assert "scientific_name" in species("check", str(path)).stderr

    @pytest.mark.parametrize(
        "name",
        [
            "",
            " ",
            "?",
            "../evil",
            "a/b",
            "..\\evil",
            ".hidden",
            "..",
            "鹤",
            "a\nb",
            "a\0b",
            "~/evil",
            "x" * 81,
        ],
    )
    def test_a_hostile_name_writes_nothing_anywhere(self, tmp_path, name):
        inner = tmp_path / "inner"
        inner.mkdir()
        result = species("new", name, "--folder", str(inner))
        assert result.exit_code == 2
        assert result.stderr.count("\n") == 1
        assert [path for path in tmp_path.rglob("*") if path != inner] == []

    def test_a_name_may_be_as_long_as_is_told(self, tmp_path):
        assert species("new", "x" * 80, "--folder", str(tmp_path)).exit_code == 0
        assert list(files_in(tmp_path)) == [f"{'x' * 80}.toml"]

    def test_a_folder_that_is_not_there_is_one_line(self, tmp_path):
        result = species("new", "my-bird", "--folder", str(tmp_path / "nowhere"))
        assert result.exit_code == 2
        assert "expected a folder to write to" in result.stderr
        assert files_in(tmp_path) == {}
