"""The species library: the paper's ibis to the last digit, twenty birds with sources, three conventions."""

import csv
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from upwash.aero.atmosphere import density_kg_m3
from upwash.aero.bird import Bird
from upwash.aero.drag import DragPolar
from upwash.aero.power import COST_FUNCTIONS
from upwash.errors import UpwashError
from upwash.species import AMPLITUDE_CONVENTIONS, ImpossibleAmplitude, load_library, load_species, slug_of
from upwash.species.allometry import RULES, nudds_half_angle_deg, pennycuick_frequency_hz
from upwash.species.caveats import comparison_caveats, species_caveats
from upwash.species.groups import GROUPS, outside
from upwash.species.library import LIBRARY_FOLDER
from upwash.species.quantity import BASES, QUANTITIES

LIBRARY = {species.slug: species for species in load_library()}
IBIS = LIBRARY["northern-bald-ibis"]
NOT_MEASURED = (
    r"(?i)derived|estimat|comput|formula|mid-point|assum|popular|handbook|knowledge|memory|\bso \d|arcsin|\^"
)
# At the ibis's Strouhal number these would need a half-angle of more than 90 degrees.
IMPOSSIBLE = {"bar-tailed-godwit", "dunlin", "homing-pigeon"}


def filled_by(name, rule):
    return {slug for slug, species in LIBRARY.items() if species.quantities[name].rule == rule}


class TestNorthernBaldIbis:
    def test_is_the_papers_bird_to_the_last_digit(self):
        assert IBIS.bird() == Bird(
            mass_kg=1.3,
            semispan_m=0.6,
            speed_m_s=15.0,
            period_s=1 / 4,
            density_kg_m3=1.29,
            gravity_m_s2=9.8,
            amplitude_m=2 * 0.6 * math.sin(math.pi / 3),
            upstroke_span_ratio=0.4,
        )

    def test_is_the_same_bird_under_either_convention(self):
        assert IBIS.bird("strouhal") == IBIS.bird("stroke-angle")

    def test_has_the_papers_dimensionless_groups(self):
        groups = IBIS.groups()
        assert groups["weight_number"] == pytest.approx(12.74 / (1.29 * 0.36 * 225), rel=1e-12)
        assert groups["wavelength_number"] == pytest.approx(6.25, rel=1e-12)
        assert groups["amplitude_number"] == pytest.approx(math.sqrt(3), rel=1e-12)
        assert groups["strouhal"] == pytest.approx(0.277, abs=5e-4)


class TestEverySpecies:
    def test_there_are_twenty(self):
        assert len(LIBRARY) == 20

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_is_named_after_its_bird(self, slug):
        assert slug_of(LIBRARY[slug].common_name) == slug
        assert load_species(LIBRARY[slug].common_name).slug == slug
        assert len(LIBRARY[slug].scientific_name.split()) == 2

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_states_a_source_a_basis_and_a_range_for_every_value(self, slug):
        species = LIBRARY[slug]
        assert list(species.quantities) == list(QUANTITIES)
        assert species.formation is not None
        for quantity in species.quantities.values():
            assert quantity.source
            assert quantity.basis in BASES
            assert quantity.low <= quantity.value <= quantity.high
            assert quantity.low < quantity.high
            assert not quantity.rule or quantity.basis in {"assumed", "computed"}

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_says_which_rule_filled_a_kinematic_value_that_nobody_measured(self, slug):
        for name in ("wingbeat_frequency", "stroke_half_angle"):
            quantity = LIBRARY[slug].quantities[name]
            assert quantity.rule or quantity.basis in {"measured", "given"} or "et al." in quantity.source

    # What is known of each quantity by other than the word that stands for all other species.
    KNOWN = {
        "mass": ("measured", {"northern-bald-ibis": "given"}),
        "wingspan": ("measured", {"northern-bald-ibis": "given", "pink-footed-goose": "assumed"}),
        "wing_area": ("measured", {"northern-bald-ibis": "given", "pink-footed-goose": "computed"}),
        "speed": ("measured", {"northern-bald-ibis": "given", "pink-footed-goose": "computed"}),
        "wingbeat_frequency": (
            "computed",
            dict.fromkeys(
                ("northern-bald-ibis", "barnacle-goose", "herring-gull", "common-starling"), "measured"
            ),
        ),
        "stroke_half_angle": ("computed", {"northern-bald-ibis": "given"}),
        "upstroke_span_ratio": ("assumed", {"northern-bald-ibis": "given"}),
        "air_density": ("assumed", {"northern-bald-ibis": "given"}),
        "gravity": ("assumed", {"northern-bald-ibis": "given"}),
        "formation": (
            "measured",
            dict.fromkeys(
                (
                    "glossy-ibis",
                    "mute-swan",
                    "whooper-swan",
                    "barnacle-goose",
                    "brent-goose",
                    "common-crane",
                    "great-cormorant",
                    "greater-flamingo",
                    "herring-gull",
                    "common-eider",
                    "eurasian-curlew",
                    "bar-tailed-godwit",
                ),
                "assumed",
            ),
        ),
    }

    @pytest.mark.parametrize("name", KNOWN)
    def test_says_how_it_is_known_as_the_collected_sources_do(self, name):
        usual, others = self.KNOWN[name]
        found = {
            slug: (one.formation if name == "formation" else one.quantities[name]).basis
            for slug, one in LIBRARY.items()
        }
        assert found == dict.fromkeys(LIBRARY, usual) | others

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_calls_nothing_measured_that_its_source_says_is_not(self, slug):
        species = LIBRARY[slug]
        for one in filter(None, (*species.quantities.values(), species.formation)):
            worked_out = re.search(NOT_MEASURED, one.source)
            assert not (worked_out and one.basis == "measured"), one.source

    @pytest.mark.parametrize("slug", LIBRARY)
    def test_lies_within_the_usual_dimensionless_groups(self, slug):
        groups = LIBRARY[slug].groups()
        assert set(groups) == set(GROUPS)
        assert outside(groups, "usual") == []

    @pytest.mark.parametrize("slug", sorted(set(LIBRARY) - {IBIS.slug}))
    def test_flies_in_the_ibiss_air(self, slug):
        for name in ("air_density", "gravity"):
            assert LIBRARY[slug].quantities[name].value == IBIS.quantities[name].value
            assert LIBRARY[slug].quantities[name].rule == "as-ibis"

    @pytest.mark.parametrize("convention", AMPLITUDE_CONVENTIONS)
    @pytest.mark.parametrize("slug", LIBRARY)
    def test_makes_a_bird_at_either_end_of_each_of_its_ranges(self, slug, convention):
        species = LIBRARY[slug]
        for name, ends in species.ranges(convention).items():
            for end in ends:
                try:
                    bird = species.bird(convention, **{name: end})
                except ImpossibleAmplitude as error:
                    assert convention != "stroke-angle"
                    assert error.amplitude_m > error.wingspan_m
                else:
                    assert getattr(bird, name, end) == end


class TestRules:
    def test_pennycuick_fills_fifteen_frequencies_with_a_quarter_either_way(self):
        filled = filled_by("wingbeat_frequency", "pennycuick-1996")
        assert len(filled) == 15
        for slug in filled:
            quantity = LIBRARY[slug].quantities["wingbeat_frequency"]
            assert quantity.low == pytest.approx(0.75 * quantity.value, rel=5e-3)
            assert quantity.high == pytest.approx(1.25 * quantity.value, rel=5e-3)

    def test_pennycuick_is_within_10_percent_low_and_30_percent_high_of_the_known_birds(self):
        known = set(LIBRARY) - filled_by("wingbeat_frequency", "pennycuick-1996")
        errors = []
        for slug in known:
            of = LIBRARY[slug].quantities
            rule = pennycuick_frequency_hz(of["mass"].value, of["wingspan"].value, of["wing_area"].value)
            errors.append(rule / of["wingbeat_frequency"].value - 1.0)
        assert len(errors) == 5
        assert min(errors) == pytest.approx(-0.10, abs=0.005)
        assert max(errors) == pytest.approx(0.30, abs=0.005)

    def test_nudds_fills_eighteen_half_angles(self):
        known = set(LIBRARY) - filled_by("stroke_half_angle", "nudds-2004")
        assert known == {"northern-bald-ibis", "common-starling"}
        assert nudds_half_angle_deg(1.2) == pytest.approx(32.07, abs=0.005)

    def test_the_ibis_lends_its_upstroke_span_ratio_to_eighteen(self):
        known = set(LIBRARY) - filled_by("upstroke_span_ratio", "as-ibis")
        assert known == {"northern-bald-ibis", "common-starling"}

    @pytest.mark.parametrize("name", RULES)
    def test_a_rule_scales_as_its_exponents_say(self, name):
        # A bird twice as long, all else similar: mass x 8, wingspan x 2, wing area x 4.
        exponent = {"pennycuick-1996": 9 / 8 - 23 / 24 - 2 / 3, "nudds-2004": -0.24, "alerstam-2007": 0.31}
        size = {"mass": (1.3, 8), "wingspan": (1.2, 2), "wing_area": (0.18, 4)}
        rule = RULES[name]
        small = rule.formula(*(size[need][0] for need in rule.needs))
        large = rule.formula(*(size[need][0] * size[need][1] for need in rule.needs))
        assert large / small == pytest.approx(2 ** exponent[name], rel=1e-12)


class TestAmplitude:
    def test_of_the_stroke_angle_is_wingspan_times_sine(self):
        swan = LIBRARY["mute-swan"]
        assert swan.amplitude_m() == pytest.approx(2.3 * math.sin(math.radians(27.4)), rel=1e-15)

    @pytest.mark.parametrize("slug", sorted(set(LIBRARY) - IMPOSSIBLE))
    def test_of_strouhal_gives_every_bird_the_ibiss_strouhal_number(self, slug):
        assert LIBRARY[slug].groups("strouhal")["strouhal"] == pytest.approx(
            IBIS.groups()["strouhal"], rel=1e-14
        )
        angle = math.radians(LIBRARY[slug].half_angle_deg("strouhal"))
        bird = LIBRARY[slug].bird("strouhal")
        assert bird.amplitude_m == pytest.approx(2 * bird.semispan_m * math.sin(angle), rel=1e-14)

    @pytest.mark.parametrize("slug", sorted(IMPOSSIBLE))
    def test_of_strouhal_is_impossible_for_three_birds_and_says_by_how_much(self, slug):
        species = LIBRARY[slug]
        with pytest.raises(ImpossibleAmplitude, match="at most the wingspan") as caught:
            species.bird("strouhal")
        strouhal = caught.value.amplitude_m / species.bird().wavelength_m
        assert strouhal == pytest.approx(IBIS.groups()["strouhal"], rel=1e-14)
        assert caught.value.amplitude_m > caught.value.wingspan_m == species.quantities["wingspan"].value
        assert "\n" not in str(caught.value)

    def test_follows_from_the_inputs_as_overridden(self):
        assert IBIS.bird(semispan_m=1.2).amplitude_m == pytest.approx(2 * IBIS.bird().amplitude_m, rel=1e-15)
        slower = IBIS.bird("strouhal", speed_m_s=7.5)
        assert slower.amplitude_m == pytest.approx(IBIS.bird().amplitude_m / 2, rel=1e-15)
        assert IBIS.bird(stroke_half_angle_deg=30).amplitude_m == pytest.approx(0.6, rel=1e-15)
        assert IBIS.bird("strouhal", amplitude_m=0.5).amplitude_m == 0.5

    def test_the_strouhal_convention_samples_no_stroke_angle(self):
        assert set(IBIS.ranges()) - set(IBIS.ranges("strouhal")) == {"stroke_half_angle_deg"}

    @pytest.mark.parametrize("coefficient", [1.0, 0.2])
    def test_of_drag_makes_the_thrust_that_overcomes_it(self, coefficient):
        area = IBIS.quantities["wing_area"].value
        for speed in (9.0, 12.0):
            bird = IBIS.bird("drag", speed_m_s=speed, body_drag_coefficient=coefficient)
            drag = DragPolar(area, coefficient).drag_n(1.3, 0.6, speed, 1.29, 9.8)
            assert bird.drag_n == pytest.approx(drag, rel=1e-13)

    def test_of_drag_makes_power_against_speed_a_valley(self):
        def power(speed):
            bird = IBIS.bird("drag", speed_m_s=speed, body_drag_coefficient=0.2)
            return COST_FUNCTIONS["aerodynamic_power"].value(bird, bird.weight_n, bird.drag_n)

        slow, best, fast = power(7.0), power(11.6), power(20.0)
        assert best < power(11.4)
        assert best < power(11.8)
        assert slow > 1.2 * best
        assert fast > 1.5 * best

    def test_of_drag_takes_and_samples_the_wings_area(self):
        assert IBIS.ranges("drag")["wing_area_m2"] == (0.15, 0.235)
        assert "stroke_half_angle_deg" not in IBIS.ranges("drag")
        assert IBIS.bird("drag", wing_area_m2=0.22).amplitude_m != IBIS.bird("drag").amplitude_m

    def test_of_drag_needs_a_wing_area(self):
        quantities = {name: of for name, of in IBIS.quantities.items() if name != "wing_area"}
        without = replace(IBIS, quantities=quantities)
        with pytest.raises(UpwashError, match="add .wing_area. to the species file, or set wing_area_m2"):
            without.bird("drag")
        assert without.bird("drag", wing_area_m2=0.18) == IBIS.bird("drag")

    def test_altitude_stands_for_the_density_there(self):
        high = IBIS.bird(altitude_m=5000.0)
        assert high == IBIS.bird(density_kg_m3=density_kg_m3(5000.0))
        assert IBIS.bird(altitude_m=0.0).density_kg_m3 == pytest.approx(1.225, abs=1e-5)


class TestOverrides:
    @pytest.mark.parametrize(
        ("overrides", "says"),
        [
            ({"mass": 1.0}, "did you mean 'mass_kg'"),
            ({"colour": 1.0}, "choose from mass_kg"),
            ({"mass_kg": -1.0}, "mass_kg: expected a positive, finite number, found -1.0"),
            ({"mass_kg": math.nan}, "found nan"),
            ({"speed_m_s": math.inf}, "found inf"),
            ({"mass_kg": "heavy"}, "found 'heavy'"),
            ({"mass_kg": True}, "found True"),
            ({"upstroke_span_ratio": 1.2}, "upstroke_span_ratio"),
            ({"stroke_half_angle_deg": 91.0}, "at most 90"),
            ({"stroke_half_angle_deg": 30.0, "amplitude_m": 1.0}, "leave one of them out"),
            ({"amplitude": "strouhal", "stroke_half_angle_deg": 30.0}, "leave one of them out"),
            ({"amplitude": "guess"}, 'expected "stroke-angle" or "strouhal" or "drag"'),
            ({"body_drag_coefficient": 0.2}, "expected amplitude = 'drag'"),
            ({"amplitude": "drag", "wing_area_m2": 0.2, "amplitude_m": 1.0}, "leave one of them out"),
            ({"amplitude": "drag", "upstroke_span_ratio": 0.9}, "upstroke_span_ratio"),
            ({"altitude_m": 0.0, "density_kg_m3": 1.2}, "leave one of them out"),
            ({"altitude_m": 11001.0}, "at most 11000"),
            ({"altitude_m": -1.0}, "not negative"),
            ({"amplitude_m": 1.21}, "at most the wingspan, 1.2"),
        ],
    )
    def test_a_wrong_one_is_one_line(self, overrides, says):
        with pytest.raises(UpwashError, match=".") as caught:
            IBIS.bird(**overrides)
        assert says in str(caught.value)
        assert "\n" not in str(caught.value)


class TestSimilarity:
    def test_a_hundredfold_mass_at_the_same_shape_and_speed_number_keeps_every_group(self, tmp_path):
        # W/(rho b^2 U^2) and lambda/b stay if b grows as M^(1/3), U as M^(1/6) and f as M^(-1/6).
        text = (LIBRARY_FOLDER / "northern-bald-ibis.toml").read_text(encoding="utf-8")
        exponents = {
            "mass": 1,
            "wingspan": 1 / 3,
            "wing_area": 2 / 3,
            "speed": 1 / 6,
            "wingbeat_frequency": -1 / 6,
        }
        for name, exponent in exponents.items():
            quantity = IBIS.quantities[name]
            head, table, tail = text.partition(f"[{name}]\n")
            for key in ("value", "low", "high"):
                scaled = getattr(quantity, key) * 100**exponent
                tail = tail.replace(f"{key} = {getattr(quantity, key)!r}\n", f"{key} = {scaled!r}\n", 1)
            text = head + table + tail
        path = tmp_path / "giant-ibis.toml"
        path.write_text(text, encoding="utf-8")
        giant = load_species(path)
        assert giant.quantities["mass"].value == pytest.approx(130.0)
        for name, value in IBIS.groups().items():
            assert giant.groups()[name] == pytest.approx(value, rel=1e-13)


class TestCaveats:
    def test_name_what_was_not_measured_and_by_which_rule(self):
        caveats = "; ".join(species_caveats(LIBRARY["mute-swan"], IBIS))
        assert "upstroke_span_ratio assumed (as-ibis)" in caveats
        assert "wingbeat_frequency computed (pennycuick-1996)" in caveats
        assert "stroke_half_angle computed (nudds-2004)" in caveats

    @pytest.mark.parametrize("slug", ["canada-goose", "great-white-pelican"])
    def test_name_a_speed_that_rests_on_one_track(self, slug):
        assert "speed (1)" in "; ".join(species_caveats(LIBRARY[slug], IBIS))

    @pytest.mark.parametrize(("sample", "is_few"), [(1, True), (2, True), (3, False), (30, False)])
    def test_name_a_sample_of_less_than_three(self, sample, is_few):
        speed = replace(IBIS.quantities["speed"], sample=sample)
        bird = replace(IBIS, quantities={**IBIS.quantities, "speed": speed})
        assert (f"speed ({sample})" in "; ".join(species_caveats(bird, IBIS))) is is_few

    @pytest.mark.parametrize("slug", sorted(IMPOSSIBLE))
    def test_name_an_impossible_convention(self, slug):
        assert any("is impossible" in caveat for caveat in species_caveats(LIBRARY[slug], IBIS))

    def test_of_a_comparison_are_counted_from_the_library(self):
        caveats = "\n".join(comparison_caveats(list(LIBRARY.values()), IBIS))
        for fact in (
            "15 of 20",
            "18 of 20",
            "-10% to +30%",
            "±25%",
            "60 degrees",
            "0.277",
            "32.1",
            *IMPOSSIBLE,
        ):
            assert fact in caveats
        assert "one optimum of nature" in caveats
        assert "compare like with like" in caveats


class TestObservations:
    with (LIBRARY_FOLDER / "observations.csv").open(encoding="utf-8", newline="") as file:
        ROWS = tuple(csv.DictReader(file))

    def test_give_numbers_in_a_unit_or_say_why_not(self):
        for row in self.ROWS:
            numbers = {key: float(row[key]) for key in ("low", "value", "high") if row[key]}
            assert list(numbers.values()) == sorted(numbers.values())
            assert all(map(math.isfinite, numbers.values()))
            assert numbers or row["note"]
            assert row["unit"] in {"m", "wingspans", "semispans", "wavelengths", "%", "deg", "s", "1"}

    def test_cite_the_work_and_say_how_it_is_known(self):
        for row in self.ROWS:
            assert any(character.isdigit() for character in row["study"])
            assert row["metric"]
            assert row["basis"] in {"measured", "computed"}
            assert row["this_model"] == ("yes" if "arXiv:2602.22043" in row["study"] else "no")
            author, year = row["label"].split()
            assert row["study"].startswith(author) and f" {year}" in row["study"]
            assert row["read"] in {"original", "quoted", "recalled"}
            assert not {"where", "seen"} & set(row)

    def test_are_of_species_in_the_library_or_of_named_others(self):
        others = {"american-white-pelican", "brown-pelican", "marbled-godwit", ""}
        assert {row["species"] for row in self.ROWS} <= set(LIBRARY) | others

    def test_compare_a_distance_with_a_position_and_a_saving_with_a_saving(self):
        columns = {
            "distance_behind": "x_m",
            "lateral_distance": "y_m",
            "wingtip_spacing": "y_m",
            "vertical_distance": "z_m",
            "phase": "phase",
            "induced_power_saving": "saving_induced",
            "profile_power_saving": "saving_profile",
            "total_power_saving": "saving_total",
        }
        for row in self.ROWS:
            assert row["compare"] == columns.get(row["quantity"], "")


def test_the_library_stands_beside_the_package():
    assert Path(__file__).parents[1] / "species" == LIBRARY_FOLDER


class TestLimits:
    """The limits of the dimensionless groups, as the page on species tells them."""

    TOLD = re.findall(
        r"^\| (\S.*?) \| (\S+) to (\S+) \| (\S+) to (\S+) \|",
        (Path(__file__).parents[1] / "docs" / "species.md").read_text(encoding="utf-8"),
        re.M,
    )

    def test_every_group_is_told(self):
        assert len(self.TOLD) == len(GROUPS)

    @pytest.mark.parametrize(("name", "told"), list(zip(GROUPS, TOLD, strict=False)))
    def test_are_those_that_are_told_and_lie_within_themselves(self, name, told):
        ends = [math.pi / 4.0 if one == "π/4" else float(one) for one in told[1:]]
        for limits, (low, high) in (("usual", ends[:2]), ("possible", ends[2:])):
            for end, beyond in ((low, -math.inf), (high, math.inf)):
                assert outside({name: end}, limits) == []
                (sentence,) = outside({name: math.nextafter(end, beyond)}, limits)
                assert f"expected {low:.3g} to {high:.3g}" in sentence
