"""A species file: units become SI, rules fill gaps, and whatever is wrong is said in one line that helps."""

import itertools
import json
import math
import os
import re
import tempfile
from pathlib import Path

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.errors import UpwashError
from upwash.species import load_species
from upwash.species.library import LIBRARY_FOLDER
from upwash.species.quantity import QUANTITIES
from upwash.species.template import write_template

IBIS = (LIBRARY_FOLDER / "northern-bald-ibis.toml").read_text(encoding="utf-8")
GOOSE = (LIBRARY_FOLDER / "greylag-goose.toml").read_text(encoding="utf-8")


def table(text, name):
    """Return a table of a species file, from its heading to the next."""
    return re.search(rf"^\[{name}\]\n(?:(?!\[).*\n?)*", text, re.M)[0]


def with_table(text, name, new):
    """Replace a table of a species file."""
    return text.replace(table(text, name), new)


def with_line(text, name, key, line):
    """Replace the line that gives a key in a table; an empty line deletes it."""
    old = table(text, name)
    new = re.sub(rf"^{key} = .*\n", f"{line}\n" if line else "", old, flags=re.M)
    assert new != old
    return text.replace(old, new)


def checked(path):
    return CliRunner().invoke(main, ["species", "check", str(path)], prog_name="upwash")


def loaded(tmp_path, text):
    path = tmp_path / "bird.toml"
    path.write_text(text, encoding="utf-8")
    return load_species(path)


def assert_one_helpful_line(result, *fragments):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    assert len(result.stderr.splitlines()) == 1, result.stderr
    assert result.stderr.startswith("Error: ")
    assert "expected " in result.stderr
    assert "found " in result.stderr
    for fragment in fragments:
        assert fragment in result.stderr


class TestUnits:
    @pytest.mark.parametrize(
        ("name", "unit", "factor"),
        [("mass", "g", 1000.0), ("wingspan", "cm", 100.0), ("wing_area", "cm2", 1e4), ("speed", "km/h", 3.6)],
    )
    def test_become_si(self, tmp_path, name, unit, factor):
        expected = load_species("northern-bald-ibis").quantities[name]
        text = with_line(IBIS, name, "unit", f'unit = "{unit}"')
        for key in ("value", "low", "high"):
            text = with_line(text, name, key, f"{key} = {getattr(expected, key) * factor!r}")
        found = loaded(tmp_path, text).quantities[name]
        assert found.unit == expected.unit
        for key in ("value", "low", "high"):
            assert getattr(found, key) == pytest.approx(getattr(expected, key), rel=1e-15)

    def test_45_km_h_are_exactly_12_5_m_s(self, tmp_path):
        text = with_line(IBIS, "speed", "unit", 'unit = "km/h"')
        for key, value in {"value": 45, "low": 40, "high": 54}.items():
            text = with_line(text, "speed", key, f"{key} = {value}")
        speed = loaded(tmp_path, text).quantities["speed"]
        assert (speed.value, speed.high) == (12.5, 15.0)


class TestRules:
    def test_fill_in_a_value_its_range_basis_and_source(self, tmp_path):
        text = with_table(GOOSE, "stroke_half_angle", '[stroke_half_angle]\nrule = "nudds-2004"\n\n')
        angle = loaded(tmp_path, text).quantities["stroke_half_angle"]
        assert angle.value == pytest.approx(33.5 * 1.55**-0.24)
        assert (angle.low, angle.high) == pytest.approx((0.75 * angle.value, 1.25 * angle.value))
        assert (angle.basis, angle.unit) == ("computed", "deg")
        assert "Nudds" in angle.source

    def test_take_over_the_ibiss_value_and_range(self, tmp_path):
        text = with_table(GOOSE, "air_density", '[air_density]\nrule = "as-ibis"\n\n')
        air = loaded(tmp_path, text).quantities["air_density"]
        ibis = load_species("northern-bald-ibis").quantities["air_density"]
        assert (air.value, air.low, air.high, air.basis) == (ibis.value, ibis.low, ibis.high, "assumed")

    def test_compute_from_tables_that_come_later(self, tmp_path):
        area = table(GOOSE, "wing_area")
        assert loaded(tmp_path, GOOSE.replace(area, "") + "\n" + area) == loaded(tmp_path, GOOSE)

    def test_wing_area_may_be_left_out_where_no_rule_needs_it(self, tmp_path):
        species = loaded(tmp_path, with_table(IBIS, "wing_area", ""))
        assert species.bird() == load_species("northern-bald-ibis").bird()
        assert "aspect_ratio" not in species.groups()


MALFORMED = {
    "missing name": (lambda: IBIS.replace('common_name = "Northern bald ibis"\n', ""), "common_name"),
    "name that is a number": (lambda: IBIS.replace('"Northern bald ibis"', "7"), "common_name", "found 7"),
    "name left open": (lambda: IBIS.replace('"Geronticus eremita"', '"?"'), "scientific_name", "found '?'"),
    "name of two lines": (
        lambda: IBIS.replace('"Geronticus eremita"', '"a\\nb"'),
        "scientific_name",
        "one line",
    ),
    "unknown table": (lambda: IBIS + "\n[beak]\nvalue = 1\n", "found 'beak'", "choose from"),
    "misspelt table": (
        lambda: IBIS.replace("[wingspan]", "[wing_span]"),
        "'wing_span'",
        "did you mean 'wingspan'",
    ),
    "misspelt key": (
        lambda: with_line(IBIS, "mass", "value", "vlaue = 1.3"),
        "[mass]",
        "did you mean 'value'",
    ),
    "quantity that is no table": (lambda: "mass = 1.3\n" + with_table(IBIS, "mass", ""), "[mass]", "a table"),
    "wrong unit": (
        lambda: with_line(IBIS, "mass", "unit", 'unit = "lb"'),
        "[mass] unit",
        '"kg" or "g"',
        "'lb'",
    ),
    "no unit": (lambda: with_line(IBIS, "speed", "unit", ""), "[speed] unit", '"m/s" or "km/h"'),
    "unit that is a number": (lambda: with_line(IBIS, "upstroke_span_ratio", "unit", "unit = 1"), "found 1"),
    "no basis": (lambda: with_line(IBIS, "mass", "basis", ""), "[mass] basis", '"measured" or "given"'),
    "unknown basis": (lambda: with_line(IBIS, "mass", "basis", 'basis = "guessed"'), "'guessed'"),
    "no source": (lambda: with_line(IBIS, "mass", "source", ""), "[mass]", "source"),
    "empty source": (lambda: with_line(IBIS, "mass", "source", 'source = " "'), "[mass] source"),
    "no low": (lambda: with_line(IBIS, "mass", "low", ""), "[mass]", "low", "range"),
    "range below the value": (
        lambda: with_line(IBIS, "mass", "high", "high = 1.2"),
        "low <= value <= high",
        "1.2",
    ),
    "range upside down": (lambda: with_line(IBIS, "mass", "low", "low = 1.5"), "low <= value <= high", "1.5"),
    "sample of none": (
        lambda: with_line(GOOSE, "mass", "sample", "sample = 0"),
        "[mass] sample",
        "whole number",
    ),
    "sample in parts": (lambda: with_line(GOOSE, "mass", "sample", "sample = 2.5"), "[mass] sample"),
    "R of 1": (lambda: with_line(IBIS, "upstroke_span_ratio", "high", "high = 1"), "below 0.7854"),
    "R above 1": (lambda: with_line(IBIS, "upstroke_span_ratio", "value", "value = 1.4"), "found 1.4"),
    "R without thrust": (
        lambda: with_line(IBIS, "upstroke_span_ratio", "value", "value = 0.79"),
        "found 0.79",
    ),
    "half-angle beyond 90": (lambda: with_line(IBIS, "stroke_half_angle", "high", "high = 91"), "at most 90"),
    "unknown rule": (
        lambda: with_line(GOOSE, "stroke_half_angle", "rule", 'rule = "nudds"'),
        '"nudds-2004"',
        "'nudds'",
    ),
    "rule for what has none": (
        lambda: with_line(GOOSE, "mass", "basis", 'rule = "as-ibis"'),
        "no rule",
        "'as-ibis'",
    ),
    "rule of another quantity": (
        lambda: with_line(GOOSE, "stroke_half_angle", "rule", 'rule = "pennycuick-1996"'),
        "[stroke_half_angle] rule",
    ),
    "value that is not its rule's": (
        lambda: with_line(GOOSE, "stroke_half_angle", "value", "value = 31"),
        "30.16 deg by rule 'nudds-2004'",
        "found 31",
    ),
    "basis that is not its rule's": (
        lambda: with_line(GOOSE, "stroke_half_angle", "basis", 'basis = "measured"'),
        "'computed' with rule",
    ),
    "rule without what it needs": (lambda: with_table(GOOSE, "wing_area", ""), "[wing_area] to compute from"),
    "rule that gives too wide an angle": (
        lambda: with_table(
            with_table(
                IBIS,
                "wingspan",
                '[wingspan]\nvalue = 2\nunit = "cm"\nlow = 1\nhigh = 3\nbasis = "given"\nsource = "fly"\n\n',
            ),
            "stroke_half_angle",
            '[stroke_half_angle]\nrule = "nudds-2004"\n\n',
        ),
        "at most 90",
    ),
    "grams taken for kilograms": (
        lambda: re.sub(r"(?m)^(value|low|high) = (1\.3|1\.17|1\.43)$", r"\1 = 1300.0", IBIS),
        "W/(rho b^2 U^2)",
        "found 122",
        "units of mass",
    ),
    "grams taken for kilograms where a rule makes up for it by speed": (
        lambda: with_table(
            re.sub(r"(?m)^(value|low|high) = (1\.3|1\.17|1\.43)$", r"\1 = 1300.0", IBIS),
            "speed",
            '[speed]\nrule = "alerstam-2007"\n\n',
        ),
        "W/(rho b^2 U^2)",
        "units of mass",
    ),
    "centimetres taken for metres": (
        lambda: re.sub(r"(?m)^(value|low|high) = (1\.2|1\.14|1\.26)$", r"\1 = 120.0", IBIS),
        "W/(rho b^2 U^2)",
        "wingspan",
    ),
    "unknown formation": (
        lambda: IBIS.replace('shape = "V"', 'shape = "W"'),
        "[formation] shape",
        '"echelon"',
        "'W'",
    ),
    "formation without a source": (
        lambda: with_line(IBIS, "formation", "source", ""),
        "[formation]",
        "source",
    ),
    "syntax error": (lambda: IBIS.replace("value = 1.3", "value 1.3"), "TOML syntax", "line 7"),
    "text without quotes": (lambda: IBIS.replace('"Geronticus eremita"', "Geronticus eremita"), "line 4"),
    "table given twice": (lambda: IBIS + "\n[mass]\nvalue = 1\n", "TOML syntax", "line"),
    "key given twice": (
        lambda: with_line(IBIS, "mass", "value", "value = 1\nvalue = 2"),
        "TOML syntax",
        "line",
    ),
    "tables without end": (lambda: "mass = " + "[" * 5000, "TOML syntax"),
    "no TOML at all": (lambda: "<html><body>404</body></html>", "TOML syntax", "line 1"),
    "number without end": (lambda: with_line(IBIS, "mass", "value", f"value = 1{'0' * 5000}"), "TOML syntax"),
    "bytes that are no text": (lambda: b"\xff\xfe\x00", "UTF-8"),
}
WRONG_VALUES = {
    "negative": ("value = -1.3", "found -1.3"),
    "zero": ("value = 0", "found 0"),
    "not a number": ("value = nan", "found nan"),
    "infinite": ("value = inf", "found inf"),
    "beyond floats": (f"value = 1{'0' * 400}", "found 1000"),
    "text": ('value = "1.3"', "found '1.3'", "without quotes"),
    "left open": ('value = "?"', "found '?'"),
    "true": ("value = true", "found True"),
    "a list": ("value = [1.3]", "found [1.3]"),
    "a date": ("value = 2026-01-01", "found datetime.date"),
    "missing": ("", "value = a number", "no such key"),
}
for quantity, (kind, (line, *says)) in itertools.product(QUANTITIES, WRONG_VALUES.items()):
    MALFORMED[f"{quantity}: {kind}"] = (
        lambda quantity=quantity, line=line: with_line(IBIS, quantity, "value", line),
        f"[{quantity}]",
        *says,
    )
for quantity in (name for name, kind in QUANTITIES.items() if not kind.optional):
    MALFORMED[f"{quantity}: no table"] = (
        lambda quantity=quantity: with_table(IBIS, quantity, ""),
        f"[{quantity}]: expected this table",
        *QUANTITIES[quantity].rules,
    )


class TestMalformed:
    @pytest.mark.parametrize("kind", MALFORMED)
    def test_is_one_line_with_place_finding_and_remedy_and_exit_2(self, tmp_path, kind):
        make, *fragments = MALFORMED[kind]
        content = make() if isinstance(make(), bytes) else make().encode()
        path = tmp_path / "bird.toml"
        path.write_bytes(content)
        result = checked(path)
        assert_one_helpful_line(result, str(path), *fragments)
        assert len(result.stderr) < 500
        assert os.listdir(tmp_path) == ["bird.toml"]
        assert path.read_bytes() == content

    def test_there_are_more_than_a_hundred_ways(self):
        assert len(MALFORMED) > 100

    @pytest.mark.parametrize("what", ["nothing", "a folder", "a pipe"])
    def test_no_file_at_all(self, tmp_path, what):
        path = tmp_path / "bird.toml"
        if what == "a folder":
            path.mkdir()
        if what == "a pipe":
            os.mkfifo(path)
        assert_one_helpful_line(checked(path), str(path), "species file")

    def test_a_file_that_may_not_be_read(self, as_nobody):
        path = as_nobody / "bird.toml"
        assert_one_helpful_line(checked(path), str(path), "permission")

    def test_a_path_with_a_line_break_stays_one_line(self, tmp_path):
        assert_one_helpful_line(checked(tmp_path / "a\nb.toml"), "no such file")


class TestSeveralMistakes:
    def test_all_that_is_open_is_said_at_once(self, tmp_path):
        path = write_template("My bird", tmp_path)
        lines = checked(path).stderr.splitlines()
        opened = [
            line for line in path.read_text(encoding="utf-8").splitlines() if re.match(r'\w+ = "\?"', line)
        ]
        assert len(lines) == len(opened) == 17
        assert all(line.startswith(f"Error: {path}: ") and "found '?'" in line for line in lines)
        report = json.loads(CliRunner().invoke(main, ["species", "check", "--json", str(path)]).stdout)
        assert [f"Error: {one}" for one in report["files"][0]["errors"]] == lines

    def test_an_empty_file_lacks_every_name_and_table(self, tmp_path):
        path = tmp_path / "bird.toml"
        path.write_text("")
        needed = [name for name, kind in QUANTITIES.items() if not kind.optional]
        said = checked(path).stderr
        assert len(said.splitlines()) == 2 + len(needed)
        assert all(f"[{name}]: expected this table" in said for name in needed)

    def test_elsewhere_it_is_one_line_that_says_how_many(self, tmp_path):
        path = write_template("My bird", tmp_path)
        with pytest.raises(
            UpwashError, match=r"scientific_name: .*\(16 more: 'upwash species check "
        ) as refused:
            load_species(path)
        assert "\n" not in str(refused.value)

    def test_what_a_rule_lacks_is_said_once_where_it_is_wrong(self, tmp_path):
        text = with_table(GOOSE, "speed", '[speed]\nrule = "alerstam-2007"\n\n')
        path = tmp_path / "bird.toml"
        path.write_text(with_line(text, "mass", "value", 'value = "?"'), encoding="utf-8")
        assert_one_helpful_line(checked(path), "[mass] value")


class TestOtherNames:
    """Names that people look for, and what stands for them here."""

    @pytest.mark.parametrize(
        ("name", "says"),
        [
            ("semispan", "write wingspan, which is twice the semispan"),
            ("semispan_m", "write wingspan, which is twice the semispan"),
            ("period_s", "write wingbeat_frequency, which is one over the period"),
            ("wingspan_m", "did you mean 'wingspan'?"),
        ],
    )
    def test_in_a_species_file(self, tmp_path, name, says):
        path = tmp_path / "bird.toml"
        path.write_text(f"{IBIS}\n[{name}]\nvalue = 1\n", encoding="utf-8")
        assert_one_helpful_line(checked(path), says)

    @pytest.mark.parametrize(
        ("name", "says"),
        [
            ("wingspan_m", "write semispan_m, which is half of the wingspan"),
            ("wingspan_cm", "write semispan_m, which is half of the wingspan"),
            ("wingspan", "write semispan_m, which is half of the wingspan"),
            ("wingbeat_frequency_hz", "write period_s, which is one over the frequency"),
            ("speed", "did you mean 'speed_m_s'?"),
        ],
    )
    def test_as_an_input_that_is_set(self, name, says):
        result = CliRunner().invoke(main, ["optimum", "mute-swan", "--set", f"{name}=1"])
        assert_one_helpful_line(result, says)


@pytest.fixture
def as_nobody():
    """A folder with a species file that may not be read, not even by the superuser, who is nobody meanwhile."""
    with tempfile.TemporaryDirectory() as folder:
        os.chmod(folder, 0o755)
        path = Path(folder, "bird.toml")
        path.write_text(IBIS, encoding="utf-8")
        path.chmod(0)
        is_superuser = os.geteuid() == 0
        if is_superuser:
            os.seteuid(65534)
        try:
            yield Path(folder)
        finally:
            if is_superuser:
                os.seteuid(0)


class TestFinding:
    @pytest.mark.parametrize(
        ("name", "near"),
        [
            ("mute-swann", "mute-swan"),
            ("ibis", "glossy-ibis, northern-bald-ibis"),
            ("GODWIT", "bar-tailed-godwit"),
            ("archaeopteryx", "upwash species list"),
            ("", "upwash species list"),
        ],
    )
    def test_an_unknown_name_names_the_nearest(self, name, near):
        with pytest.raises(UpwashError, match="a name in the library") as caught:
            load_species(name)
        assert near in str(caught.value)

    @pytest.mark.parametrize("name", ["mute-swan", "Mute swan", "MUTE_SWAN", " mute swan "])
    def test_a_name_is_found_however_it_is_written(self, name):
        assert load_species(name).slug == "mute-swan"

    def test_a_path_is_a_path_and_no_name(self, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        with pytest.raises(UpwashError, match=r"mute-swan\.toml: file: expected a species file"):
            load_species("mute-swan.toml")

    def test_a_users_file_is_a_species_of_its_own_name(self, tmp_path):
        path = tmp_path / "mybird.toml"
        path.write_text(IBIS, encoding="utf-8")
        assert load_species(path).slug == "mybird"
        assert load_species(str(path)).bird() == load_species("northern-bald-ibis").bird()
        assert math.isfinite(load_species(path).bird().circulation_m2_s)
