"""The explorer in a real browser: it moves, adapts, maps and remembers, by eye, hand, keyboard and voice."""

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner
from upwash.cli import main
from upwash.report.explorer.optima import OBJECTIVES, best_places
from upwash.report.explorer.page import ASSETS, SCRIPTS, write_explorer
from upwash.report.explorer.places import paper_place, seen_places
from upwash.species import load_library, load_species
from upwash.study.observations import read_observations

IBIS = "northern-bald-ibis"
ACCESSIBILITY = (Path(__file__).parent / "accessibility.js").read_text(encoding="utf-8")
HOSTILE = "</script><script>alert(1)</script>"


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    return write_explorer(
        tmp_path_factory.mktemp("explorer") / "explorer.html", observed=[[1.1, 0.8], [1.3, -0.9]]
    )


class Explorer:
    """The page as a person uses it."""

    def __init__(self, browser, path):
        self.browser, self.path = browser, path

    def open(self, address="", width=1280, height=900, scheme="light", motion="reduce"):
        self.browser.messages.clear()
        self.browser.requests.clear()
        self.browser.resize(width, height, is_phone=width < 600)
        preferred = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
        self.browser.call(
            "Emulation.setEmulatedMedia",
            features=[{"name": name, "value": value} for name, value in preferred.items()],
        )
        # Another fragment alone would not load it anew.
        self.browser.call("Page.navigate", url="about:blank")
        self.browser.wait_for("Page.loadEventFired")
        self.browser.requests.clear()
        self.browser.call("Page.navigate", url=self.path.resolve().as_uri() + address)
        self.browser.wait_for("Page.loadEventFired")
        return self

    def run(self, expression):
        return self.browser.run(expression)

    def text(self, name):
        return self.run(f"document.getElementById('{name}').textContent").replace("\u00a0", " ")

    def value(self, name):
        return self.run(f"Number(document.getElementById('{name}').value)")

    def set(self, name, value):
        self.run(
            f"""(() => {{
                const one = document.getElementById('{name}');
                one.value = {json.dumps(value)};
                one.dispatchEvent(new Event('input'));
                one.dispatchEvent(new Event('change'));
            }})()"""
        )

    def click(self, name):
        self.run(f"document.getElementById('{name}').click()")

    def until(self, condition):
        """Wait until a condition holds."""
        self.run(
            f"""new Promise((done) => {{
                const look = () => {condition} ? done(true) : setTimeout(look, 30);
                look();
            }})"""
        )

    def picture(self):
        """Wait for the next picture of the screen, with which what moved is shown."""
        self.run(
            "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))"
        )


@pytest.fixture
def explorer(browser, written):
    return Explorer(browser, written).open()


class TestLoading:
    @pytest.mark.parametrize("width", [1280, 820, 390, 320])
    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_it_fits_and_stays_silent(self, explorer, width, scheme):
        explorer.open(width=width, scheme=scheme)
        explorer.picture()
        assert explorer.run("document.documentElement.scrollWidth") <= width
        assert explorer.browser.messages == []
        # Its map may make pictures of its own.
        assert {one.partition(":")[0] for one in explorer.browser.requests} <= {"file", "data"}
        assert sum(one.startswith("file:") for one in explorer.browser.requests) == 1

    def test_the_policy_forbids_a_request(self, explorer):
        assert (
            explorer.run('fetch("https://example.org").then(() => "answered", () => "refused")') == "refused"
        )

    def test_it_flaps_only_where_motion_is_wanted(self, explorer):
        # From above a wing that is outstretched does not move.
        wing = "document.querySelector('#side .leader').getAttribute('d')"
        for motion, moves in (("reduce", False), ("no-preference", True)):
            explorer.open(motion=motion)
            before = explorer.run(wing)
            explorer.picture()
            explorer.run("new Promise((done) => setTimeout(() => done(true), 150))")
            assert (explorer.run(wing) != before) is moves
            assert (
                explorer.run("document.getElementById('play').getAttribute('aria-pressed')")
                == str(moves).lower()
            )

    def test_names_from_files_stay_text(self, browser, tmp_path):
        text = (load_species_path("dunlin")).read_text(encoding="utf-8")
        text = text.replace('common_name = "Dunlin"', f'common_name = "{HOSTILE}"')
        mine = tmp_path / "mine.toml"
        mine.write_text(text, encoding="utf-8")
        path = write_explorer(tmp_path / "explorer.html", species=load_species(mine))
        page = Explorer(browser, path).open()
        assert browser.messages == []
        assert HOSTILE.lower() in page.text("leader-name")
        assert page.run("document.scripts.length") == 2


def load_species_path(name):
    from upwash.species.library import find_species

    return find_species(name)


class TestFlying:
    def test_it_begins_at_the_best_place_in_the_v(self, explorer):
        best = next(
            one for one in best_places(load_species(IBIS).bird(), "limit", "power") if one.kind == "v"
        )
        assert explorer.text("verdict") == f"Here it saves {100 * best.saving_total:.1f} % of its power."
        assert explorer.value("y") == pytest.approx(best.y_m)

    def test_the_bars_meet_their_mark_where_it_balances(self, explorer):
        for name in ("lift", "thrust"):
            bar = f"document.getElementById('{name}-bar')"
            assert explorer.run(f"{bar}.getAttribute('aria-valuenow')") == "1.000"
            assert "100.0 %" in explorer.run(f"{bar}.getAttribute('aria-valuetext')").replace("\u00a0", " ")

    def test_another_stroke_does_not_fly_until_it_adapts(self, explorer):
        explorer.set("amplitude", 0.5)
        assert re.match(
            r"This bird can.t fly here like this: short of \d+ % of thrust", explorer.text("verdict")
        )
        explorer.click("adapt")
        assert explorer.text("verdict").startswith("Here it saves 4.1 %")

    def test_where_nothing_balances_it_says_what_is_missing(self, explorer):
        # In the limit, straight behind and in the wake's own phase.
        explorer.open("#model=limit&x=1.2&y=0&z=0&phase=0.32")
        explorer.until("!document.getElementById('verdict').textContent.includes('like this')")
        assert re.match(
            r"This bird can.t fly here: short of .* % of lift and .* % of thrust", explorer.text("verdict")
        )
        assert "body leaves in the air is missing" in explorer.text("notes")

    def test_where_ibises_were_seen_it_saves_what_python_says(self, explorer):
        explorer.open("#model=limit&x=1.2&y=0.904&z=0&phase=0.32")
        assert explorer.text("verdict") == "Here it saves 1.8 % of its power."

    def test_best_places_of_both_models(self, explorer):
        for model in ("paper", "limit"):
            explorer.click(f"model-{model}")
            for best in best_places(load_species(IBIS).bird(), model, "power"):
                explorer.click(f"best-{best.kind}")
                assert (
                    explorer.text("verdict") == f"Here it saves {100 * best.saving_total:.1f} % of its power."
                )

    def test_another_airspeed_has_a_best_place_of_its_own(self, explorer):
        explorer.set("speed", 13.0)
        explorer.click("best-v")
        assert re.match(r"Here it saves [\d.]+ %", explorer.text("verdict"))

    def test_the_papers_point_is_a_place_to_start_from(self, explorer):
        place = paper_place(load_species(IBIS).bird())
        explorer.set("place", "paper")
        assert explorer.value("x") == pytest.approx(place["x_m"]) == 1.83
        assert explorer.run("document.getElementById('model-paper').checked")

    def test_every_species_can_be_chosen(self, explorer):
        for slug in explorer.run(
            "Array.from(document.getElementById('species').options, (one) => one.value)"
        ):
            explorer.set("species", slug)
            assert re.match(r"Here it saves [\d.]+ %", explorer.text("verdict")), slug
        assert explorer.browser.messages == []

    def test_the_map_is_computed_by_a_worker(self, explorer):
        explorer.click("model-paper")
        explorer.click("map")
        explorer.until("document.getElementById('map-progress').textContent === 'map complete'")
        best = float(re.search(r"Best on this map: ([\d.]+) %", explorer.text("legend-words"))[1])
        assert 10.0 < best < 30.0
        assert explorer.run("document.querySelector('#above image').href.baseVal").startswith(
            "data:image/png"
        )
        assert explorer.browser.messages == []
        explorer.click("map")
        assert explorer.run("document.querySelector('#above image').hasAttribute('href')") is False

    def test_the_address_holds_all_that_was_chosen(self, explorer):
        explorer.set("species", "mute-swan")
        explorer.click("model-paper")
        explorer.set("core", 0.1)
        explorer.set("phase", 0.3)
        explorer.until("location.hash.includes('phase=0.3')")
        explorer.run("new Promise((done) => setTimeout(() => done(true), 900))")
        address, verdict = explorer.run("location.hash"), explorer.text("verdict")
        assert "model=paper" in address and "species=mute-swan" in address and "core=0.1" in address
        assert explorer.open(address).text("verdict") == verdict

    def test_an_address_that_makes_no_sense_is_no_error(self, explorer):
        explorer.open("#species=dodo&model=none&x=1e99&y=NaN&phase=-3.5&speed=0&core=&ratio=9")
        assert explorer.browser.messages == []
        assert explorer.text("verdict")

    def test_a_users_birds_and_published_ones_are_dots(self, explorer):
        assert explorer.run("document.querySelectorAll('#above .observed').length") == 2
        seen = seen_places(IBIS, load_species(IBIS).bird(), read_observations())
        assert len(seen) == explorer.run("document.querySelectorAll('#above .seen').length") == 3
        assert {round(one["y_m"], 3) for one in seen} == {0.904, 1.085, 1.1}


class TestByHand:
    def drag(self, explorer, view, across, up):
        box = explorer.run(
            f"""(() => {{
                const box = document.querySelector('#{view} .halo').getBoundingClientRect();
                return [box.x + box.width / 2, box.y + box.height / 2];
            }})()"""
        )
        mouse = {"button": "left", "clickCount": 1}
        call = explorer.browser.call
        call("Input.dispatchMouseEvent", type="mousePressed", x=box[0], y=box[1], **mouse)
        for share in (0.5, 1.0):
            x, y = box[0] + share * across, box[1] + share * up
            call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y, **mouse)
            explorer.picture()
        call("Input.dispatchMouseEvent", type="mouseReleased", x=x, y=y, **mouse)
        explorer.picture()

    @pytest.mark.parametrize("width", [1280, 390])
    def test_the_follower_can_be_dragged(self, explorer, width):
        explorer.open(width=width)
        before = explorer.value("x"), explorer.value("y")
        self.drag(explorer, "above", -60, 20)
        assert explorer.value("x") < before[0] - 0.1 and explorer.value("y") < before[1] - 0.02

    @pytest.mark.parametrize(
        ("view", "across", "up"), [("above", "x", "y"), ("side", "x", "z"), ("behind", "y", "z")]
    )
    def test_arrows_move_it_in_every_view(self, explorer, view, across, up):
        explorer.run(f"document.querySelector('#{view} .handle').focus()")
        before = {name: explorer.value(name) for name in "xyz"}
        for key, code in (("ArrowLeft", 37), ("ArrowUp", 38)):
            explorer.browser.press(key, code)
            explorer.picture()
        after = {name: explorer.value(name) for name in "xyz"}
        moved = {name for name in "xyz" if after[name] != before[name]}
        assert moved == {across, up}
        assert after[across] < before[across] and after[up] > before[up]

    def test_tab_alone_reaches_everything(self, explorer):
        reached = set()
        for _ in range(60):
            explorer.browser.press("Tab", 9)
            reached.add(
                explorer.run("document.activeElement.id || document.activeElement.getAttribute('aria-label')")
            )
        wanted = explorer.run(
            """Array.from(document.querySelectorAll("button:not(:disabled), select, input, .handle"))
                .filter((one) => one.checkVisibility() && !(one.type === "radio" && !one.checked))
                .map((one) => one.id || one.getAttribute("aria-label"))"""
        )
        assert set(wanted) <= reached

    def test_what_has_the_focus_shows_it(self, explorer):
        explorer.browser.press("Tab", 9)
        for _ in range(8):
            explorer.browser.press("Tab", 9)
            seen = explorer.run(
                """(() => {
                    const one = document.activeElement, halo = one.querySelector?.(".halo");
                    return halo ? getComputedStyle(halo).strokeWidth : getComputedStyle(one).outlineWidth;
                })()"""
            )
            assert seen == "3px"


class TestReading:
    @pytest.mark.parametrize("width", [1280, 390])
    def test_names_roles_values_and_sizes(self, explorer, width):
        assert explorer.open(width=width).run(f"{{{ACCESSIBILITY}; rules()}}") == []

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_every_text_has_contrast(self, explorer, scheme):
        explorer.open(scheme=scheme)
        assert explorer.run(f"{{{ACCESSIBILITY}; contrasts()}}") == []

    def test_what_is_found_is_said(self, explorer):
        explorer.run("document.querySelector('#above .handle').focus()")
        explorer.browser.press("ArrowRight", 39)
        explorer.until("document.getElementById('announcement').textContent !== ''")
        assert "saves" in explorer.text("announcement") and "m behind" in explorer.text("announcement")


class TestKept:
    @pytest.mark.parametrize("objective", OBJECTIVES)
    @pytest.mark.parametrize("model", ["paper", "limit"])
    def test_every_species_has_its_best_places(self, objective, model):
        def refuse():
            raise AssertionError("a species of the library was not kept; python tools/renew_explorer.py")

        for species in load_library():
            found = {one.kind for one in best_places(species.bird(), model, objective, refuse)}
            assert "global" in found and ("v" in found or objective == "force")

    def test_they_balance_and_save_what_is_said(self):
        from upwash.aero.interaction import wake_force
        from upwash.aero.pose import Pose, Stroke
        from upwash.aero.power import total_power_w
        from upwash.aero.wake import WakeModel

        for species in load_library():
            bird = species.bird()
            for model in ("paper", "limit"):
                wake = WakeModel.named(model).resolving(bird.wavelength_m / bird.semispan_m)
                for one in best_places(bird, model, "power"):
                    stroke = Stroke(one.amplitude_m, one.upstroke_span_ratio)
                    pose = Pose(one.x_m, one.y_m, one.z_m, stroke, one.phase)
                    force, own = wake_force(bird, bird.stroke, pose, wake), bird.self_force_n(stroke)
                    assert force[0] + own[0] == pytest.approx(bird.weight_n, rel=1e-9)
                    assert force[1] + own[1] == pytest.approx(bird.drag_n, rel=1e-9)
                    alone = total_power_w(bird, bird.weight_n, bird.drag_n)
                    assert 1.0 - total_power_w(bird, *own) / alone == pytest.approx(
                        one.saving_total, abs=1e-9
                    )

    def test_scripts_name_no_address_to_load_from(self):
        for name in SCRIPTS:
            # The name of SVG is no address.
            text = (ASSETS / name).read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
            assert "http" not in text, name


class TestCommand:
    def run(self, *arguments):
        return CliRunner().invoke(main, ["explore", *map(str, arguments)])

    def test_it_prints_the_name_of_the_page(self, tmp_path):
        path = tmp_path / "mine.html"
        observed = tmp_path / "birds.csv"
        observed.write_text("bird,x_m,y_m\na,1.2,0.9\nb,1.4,-0.8\n")
        result = self.run("dunlin", "--observed", observed, "--objective", "force", "--output", path)
        assert (result.exit_code, result.stdout) == (0, f"{path}\n")
        data = json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(encoding="utf-8"))[1])
        assert data["start"]["species"] == "dunlin" and data["objective"]["name"] == "force"
        assert data["observed"] == [[1.2, 0.9], [1.4, -0.8]]

    @pytest.mark.parametrize(
        ("text", "said"),
        [
            (None, "expected to use it"),
            ("", "expected a table as CSV"),
            ("bird,x,y\na,1,2\n", "expected columns x_m (behind) and y_m"),
            ("x_m,y_m\n", "expected 1 to 20000 birds, found 0"),
            ("x_m,y_m\n1.2,0.9\n1.3,near\n", "line 3, y_m: expected a number in m, found near"),
            ("x_m,y_m\n,0.9\n", "line 2, x_m: expected a number in m"),
            ("x_m,y_m\ninf,0.9\n", "line 2, x_m: expected a number in m"),
        ],
    )
    def test_a_table_that_is_none_is_one_line(self, tmp_path, text, said):
        observed, path = tmp_path / "birds.csv", tmp_path / "explorer.html"
        if text is not None:
            observed.write_text(text)
        result = self.run(IBIS, "--observed", observed, "--output", path)
        assert (result.exit_code, result.stdout) == (2, "")
        assert said in result.stderr and len(result.stderr.splitlines()) == 1
        assert not path.exists()

    @pytest.mark.parametrize(
        ("arguments", "said"),
        [
            (["no-such-bird"], "expected a name in the library"),
            ([IBIS, "--set", "stroke_states=64"], "another part of the wake's model"),
            ([IBIS, "--model", "paper", "--set", "core_radius_ratio=2"], "core_radius_ratio"),
        ],
    )
    def test_a_mistake_is_one_line(self, tmp_path, arguments, said):
        result = self.run(*arguments, "--output", tmp_path / "explorer.html")
        assert result.exit_code == 2
        assert said in result.stderr and len(result.stderr.splitlines()) == 1

    def test_it_begins_as_it_was_asked_to(self, tmp_path):
        path = tmp_path / "explorer.html"
        chosen = ["--set", "core_radius_ratio=0.1", "--set", "span_law=tip"]
        assert self.run(IBIS, *chosen, "--output", path).exit_code == 0
        data = json.loads(re.search(r'id="data">(.*?)</script>', path.read_text(encoding="utf-8"))[1])
        assert data["start"] == {"species": IBIS, "model": "limit", "core": 0.1, "law": "tip"}
