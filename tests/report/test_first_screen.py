"""The page's first screen, switches and figures in a real browser: where, how much, how sure, and what a mark is."""

import json
import re
from pathlib import Path

import pytest
from renew_claims import kept
from upwash.report.figures.marks import marks_of, tell
from upwash.report.first_screen import between, straight_behind
from upwash.report.page import as_data
from upwash.report.shown import DARK, in_both_schemes
from upwash.study.drift import TOLD_M

from report import studies

ACCESSIBILITY = (Path(__file__).parent / "accessibility.js").read_text(encoding="utf-8")
COSTS, MODELS = ("power", "force"), ("paper", "limit")


class Opened:
    """The page as a person sees it."""

    def __init__(self, browser, path):
        self.browser, self.path = browser, path

    def open(self, width=1280, height=900, scheme="light", motion="reduce"):
        self.browser.messages.clear()
        self.browser.requests.clear()
        self.browser.resize(width, height, is_phone=width < 600)
        preferred = {"prefers-color-scheme": scheme, "prefers-reduced-motion": motion}
        self.browser.call(
            "Emulation.setEmulatedMedia",
            features=[{"name": name, "value": value} for name, value in preferred.items()],
        )
        self.browser.open(self.path)
        return self

    def run(self, expression):
        return self.browser.run(expression)

    def seen(self, selector):
        """Return the texts of what fits and is seen."""
        texts = self.run(
            f"Array.from(document.querySelectorAll({json.dumps(selector)}))"
            ".filter((one) => one.checkVisibility()).map((one) => one.innerText)"
        )
        return [" ".join(text.replace("\u00a0", " ").split()) for text in texts]

    def choose(self, cost, model):
        for name, value in (("cost", cost), ("model", model)):
            self.run(f"document.getElementById('{name}-{value}').click()")


@pytest.fixture
def page(browser, written):
    return Opened(browser, written).open()


def of_pair(cost, column, model="paper", law="tip"):
    """Return a column of the stored V optimum, or None if there is none."""
    rows = studies.pair_rows() if model == "paper" else studies.limit_rows()
    found = [
        row[column]
        for row in rows
        if row["objective"] == cost and row["is_v_optimum"] and row["span_law"] == law
    ]
    return found[0] if found else None


class TestFirstScreen:
    def test_a_minute_tells_where_how_much_how_sure_and_what_fails(self, page):
        (headline,) = page.seen("h1 span")
        assert headline == "Flying in a V saves a northern bald ibis 4 % of its power, not 17 %"
        (sentence,) = page.seen(".lead")
        assert "1.78 m behind and 0.89 m aside" in sentence and "0.83–1.08 m aside" in sentence
        (sure,) = page.seen(".sure")
        fails = (kept()["verdict"] == "fails").sum()
        assert f"Of {len(kept())} claims of the paper {fails} fail in its own model" in sure

    @pytest.mark.parametrize(("width", "height"), [(1280, 900), (390, 844)])
    def test_all_of_it_is_on_the_first_screen(self, page, width, height):
        page.open(width, height)
        ends = page.run(
            "Array.from(document.querySelectorAll('h1, .lead, #scene, .numbers li'))"
            ".filter((one) => one.checkVisibility()).map((one) => one.getBoundingClientRect())"
            ".map((box) => [box.left, box.right, box.top, box.bottom])"
        )
        assert len(ends) == 6
        bar = page.run("document.querySelector('body > header').getBoundingClientRect().bottom")
        assert all(
            left >= 0 and right <= width and top >= bar and bottom <= height
            for left, right, top, bottom in ends
        )

    @pytest.mark.parametrize("cost", COSTS)
    @pytest.mark.parametrize("model", MODELS)
    def test_numbers_are_the_stored_ones_whatever_is_chosen(self, page, cost, model):
        page.choose(cost, model)
        paper, limit, drift = page.seen(".numbers strong")
        assert paper == between([of_pair(cost, "saving_total")])
        laws = [of_pair(cost, "saving_total", "limit", law) for law in ("stroke", "tip")]
        assert limit == ("no V" if None in laws else between(laws))
        still = [of_pair(cost, "saving_total")] if model == "paper" else laws
        left = "no V" if None in still else between([saving * (1.0 - 4.0 * TOLD_M) for saving in still])
        assert drift == left

    def test_the_picture_is_drawn_from_the_stored_optimum(self, page):
        for cost in COSTS:
            page.choose(cost, "paper")
            moved = page.run("document.querySelector('#scene .follower').getAttribute('transform')")
            x, y = map(float, re.findall(r"translate\(([-\d.]+),([-\d.]+)\)", moved)[0])
            b = studies.IBIS["semispan_m"]
            assert x == pytest.approx(100 * of_pair(cost, "x_m") / b, abs=0.02)
            assert -y == pytest.approx(100 * of_pair(cost, "y_m") / b, abs=0.02)

    def test_where_there_is_no_v_it_says_so(self, page):
        page.choose("force", "limit")
        assert "no V optimum of least force" in " ".join(page.seen(".lead"))
        assert "no best place in a V" in page.seen("#scene-label")[0]

    def test_birds_and_their_names_are_within_the_picture(self, page):
        for cost in COSTS:
            for model in MODELS:
                page.choose(cost, model)
                inside = page.run(
                    "(() => { const all = document.getElementById('scene').getBoundingClientRect();"
                    " return Array.from(document.querySelectorAll('#scene text, #scene use'),"
                    " (one) => one.getBoundingClientRect()).every((box) => box.top >= all.top - 1"
                    " && box.bottom <= all.bottom + 1 && box.left >= all.left - 1 && box.right <= all.right + 1); })()"
                )
                assert inside, (cost, model)

    def test_a_place_straight_behind_is_said_to_lack_a_bodys_wake(self, page):
        assert straight_behind({"y_m": 0.026, "semispan_m": 0.6})
        assert not straight_behind({"y_m": 0.3196, "semispan_m": 0.6})
        assert "leader's body, whose own wake the model leaves out" in " ".join(page.seen("#all-optima p"))
        page.choose("force", "paper")
        assert "own wake" not in " ".join(page.seen("#all-optima p"))


class TestMotion:
    STATE = "document.querySelector('#scene .leader').getAttribute('transform')"

    def later(self, page):
        return page.run(f"new Promise((done) => setTimeout(() => done({self.STATE}), 250))")

    def test_birds_flap_and_can_be_stopped(self, page):
        page.open(motion="no-preference")
        before = page.run(self.STATE)
        assert self.later(page) != before
        page.run("document.getElementById('motion').click()")
        still = page.run(self.STATE)
        assert self.later(page) == still
        assert page.seen("#motion") == ["Play"]

    def test_they_are_still_where_motion_is_not_wanted(self, page):
        before = page.run(self.STATE)
        assert self.later(page) == before


class TestSwitches:
    def test_what_is_of_another_setting_is_not_seen(self, page):
        for cost in COSTS:
            for model in MODELS:
                page.choose(cost, model)
                wrong = page.run(
                    "Array.from(document.querySelectorAll('[data-costs], [data-models]'))"
                    ".filter((one) => one.checkVisibility())"
                    f".filter((one) => !(one.dataset.costs ?? '{cost}').split(' ').includes('{cost}')"
                    f" || !(one.dataset.models ?? '{model}').split(' ').includes('{model}')).length"
                )
                assert wrong == 0

    def test_nothing_that_unfolds_is_empty(self, page):
        page.run("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        for model in MODELS:
            page.choose("power", model)
            texts = page.seen("details.more")
            assert texts and all(len(text) > 100 for text in texts)

    def test_figures_change_with_the_cost_and_say_of_which_they_are(self, page):
        names = "Array.from(document.querySelectorAll('main > section > figure .stage'))"
        names += ".filter((one) => one.checkVisibility()).map((one) => one.dataset.figure)"
        page.choose("power", "paper")
        of_power = page.run(names)
        page.choose("force", "paper")
        of_force = page.run(names)
        assert {"drift-power", "optima-map-power", "limit-place"} <= set(of_power)
        assert {"drift-force", "optima-map-force"} <= set(of_force) and "limit-place" not in of_force
        assert not set(of_power) & set(of_force)

    def test_by_keyboard_alone(self, page):
        page.run("document.getElementById('cost-power').focus()")
        page.browser.press("ArrowRight", 39)
        assert page.run("document.documentElement.dataset.cost") == "force"
        assert page.seen(".numbers strong")[0] == between([of_pair("force", "saving_total")])


class TestMarks:
    def test_what_is_told_is_what_is_drawn(self, page):
        """Each stored optimum is behind a mark of the map of the best, with its numbers and its row."""
        told = page.run("JSON.parse(document.getElementById('data').textContent).marks")
        wavelength = studies.IBIS["speed_m_s"] * studies.IBIS["period_s"]
        for cost in COSTS:
            texts = [text for _, _, text in told[f"optima-map-{cost}"]]
            for row in studies.pair_rows():
                if row["objective"] == cost:
                    (text,) = [one for one in texts if f"rank {row['rank']};" in one and "y/b" in one]
                    assert f"{row['x_m']:.3f} m behind, {row['y_m']:.3f} m aside" in text
                    assert f"x/λ, downstream {row['x_m'] / wavelength:.4g}; y/b" in text
                    assert f"job {row['job_id'][:8]}" in text

    def test_under_the_pointer(self, page):
        stage = "document.querySelector('[data-figure=drift-power]')"
        marks = page.run("JSON.parse(document.getElementById('data').textContent).marks['drift-power']")
        page.run(f"{stage}.scrollIntoView({{block: 'center'}})")
        box = page.run(
            f"(({{left, top, width, height}}) => [left, top, width, height])({stage}.getBoundingClientRect())"
        )
        left, top, text = next(mark for mark in marks if "10 cm" in mark[2])
        x, y = box[0] + left * box[2], box[1] + top * box[3]
        page.browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x + 2, y=y - 2)
        assert page.run(f"{stage}.querySelector('output').textContent") == text
        page.browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=2, y=400)
        assert page.run(f"{stage}.querySelector('output').hidden")

    def test_with_the_arrow_keys(self, page):
        stage = "document.querySelector('[data-figure=drift-power]')"
        page.run(f"{stage}.parentElement.focus()")
        said = []
        for _ in range(3):
            page.browser.press("ArrowRight", 39)
            said.append(page.run(f"{stage}.querySelector('output').textContent"))
        marks = page.run("JSON.parse(document.getElementById('data').textContent).marks['drift-power']")
        assert said == [text for _, _, text in marks[:3]]
        page.browser.press("Escape", 27)
        assert page.run(f"{stage}.querySelector('output').hidden")

    def test_every_figure_with_marks_says_how_to_ask(self, page):
        told = page.run("JSON.parse(document.getElementById('data').textContent).marks")
        with_hint = page.run(
            "Array.from(document.querySelectorAll('.answers'), (one) =>"
            " one.previousElementSibling.querySelector('.stage').dataset.figure)"
        )
        assert sorted(with_hint) == sorted(name for name, marks in told.items() if marks)

    def test_marks_lie_where_they_are_drawn(self):
        from matplotlib.figure import Figure

        figure = Figure(figsize=(4, 2), dpi=100)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.set(xlim=(0, 4), ylim=(0, 2), xlabel="x (m)", ylabel="$h_L$/b")
        (line,) = axes.plot([1.0, 5.0], [0.5, 0.5], "o", gid="points", label="bird")
        tell(line, ["row 1", "row 2"])
        (mark,) = marks_of(figure)
        assert (mark.left, mark.top) == (0.25, 0.75)
        assert mark.text == "row 1; x 1 m; h_L/b 0.5"


class TestEverywhere:
    @pytest.mark.parametrize("width", [1280, 820, 390])
    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_no_fault_in_any_setting(self, page, width, scheme):
        page.open(width, 844 if width < 600 else 900, scheme)
        page.run(ACCESSIBILITY + ";globalThis.rules = rules; globalThis.contrasts = contrasts; 0")
        for cost, model in (("power", "paper"), ("force", "limit")):
            page.choose(cost, model)
            assert page.run("document.documentElement.scrollWidth") <= width
            assert page.run("contrasts()") == []
        assert page.run("rules()") == []
        assert page.browser.messages == []
        assert all(one.startswith(("data:", "file:")) for one in page.browser.requests)

    def test_it_is_short(self, page):
        assert page.run("document.body.innerText.split(/\\s+/).length") < 2500
        assert page.run("document.documentElement.scrollHeight") <= 8 * 900
        assert page.path.stat().st_size < 6e6

    def test_unfolded_it_has_no_fault_either(self, page):
        page.run(ACCESSIBILITY + ";globalThis.rules = rules; globalThis.contrasts = contrasts; 0")
        page.run("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
        assert page.run("contrasts()") == [] and page.run("rules()") == []
        assert page.run("document.documentElement.scrollWidth") <= 1280

    def test_figures_are_dark_in_the_dark(self):
        svg = in_both_schemes('<svg><defs></defs><path style="fill: #ffffff"/></svg>')
        assert f'[style*="fill: #ffffff"]{{fill:{DARK["#ffffff"]} !important}}' in svg
        assert svg.index("<style>") < svg.index("<defs>")

    def test_data_end_no_element(self):
        text = as_data({"name": "</script><script>alert(1)</script>&\u2028"})
        assert "<" not in text and "\u2028" not in text
        assert json.loads(text) == {"name": "</script><script>alert(1)</script>&\u2028"}
