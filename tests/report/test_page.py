"""The page in a real browser: it loads, sorts, asks nobody, and reads well by eye, keyboard and voice."""

import re

import pytest
from renew_claims import kept
from upwash.columns import SCHEMA_VERSION
from upwash.errors import UpwashError
from upwash.report import figures
from upwash.report.page import sort_key, subscripts, table_context, write_page
from upwash.report.shown import BY_COST
from upwash.report.story import CHAPTERS
from upwash.report.table import Table
from upwash.report.words import true_minus

from report import studies
from report.conftest import SWEEP


@pytest.fixture
def page(browser, written):
    """The page, opened anew at a desktop's size."""
    browser.messages.clear()
    browser.requests.clear()
    browser.resize(1280, 900)
    browser.prefer("light")
    browser.open(written)
    return browser


FIGURES = "Array.from(document.querySelectorAll('.stage'), (one) => one.dataset.figure)"


def unparted(text):
    """Return a text with plain blanks between numbers and units."""
    return text.replace("\u00a0", " ")


def column(page, table, number):
    """Return the texts of a column of a table, from the top."""
    cells = f'document.querySelectorAll("#{table} tbody tr td:nth-child({number})")'
    return page.run(f"Array.from({cells}, (cell) => cell.textContent.replaceAll('\\u00a0', ' '))")


class TestLoading:
    def test_the_console_stays_empty(self, page):
        assert page.messages == []

    def test_nothing_is_requested_from_anywhere(self, page, written):
        assert page.requests[0] == written.resolve().as_uri()
        assert {one.partition(":")[0] for one in page.requests[1:]} == {"data"}

    def test_the_policy_forbids_a_request(self, page):
        asked = page.run('fetch("https://example.org").then(() => "answered", () => "refused")')
        assert asked == "refused"
        assert any("Content Security Policy" in one for one in page.messages)

    def test_every_figure_is_there(self, page):
        widths = page.run("Array.from(document.images, (one) => one.complete && one.naturalWidth)")
        names = [
            name
            for chapter in CHAPTERS
            for name in chapter.figures + chapter.more
            if not name.startswith(("species", "speed", "parameter", "refinement"))
        ]
        expected = {f"{name}-{cost}" for name in names for cost in ("power", "force") if name in BY_COST}
        expected |= {name for name in names if name not in BY_COST}
        assert set(page.run(FIGURES)) == expected
        assert len(widths) == len(expected) and all(width > 300 for width in widths)

    @pytest.mark.parametrize("width", [320, 390, 1000, 1280])
    def test_it_never_scrolls_sideways_as_a_whole(self, page, width):
        page.resize(width, 800, is_phone=width < 600)
        assert page.run("document.documentElement.scrollWidth") <= width


class TestSorting:
    TABLE = "all-optima-1"

    @pytest.fixture(autouse=True)
    def unfolded(self, page):
        page.run("document.getElementById('cost-force').click()")
        page.run("document.querySelectorAll('details').forEach((one) => { one.open = true; })")

    def press_head(self, page, number):
        head = f'document.querySelector("#{self.TABLE} th:nth-child({number})")'
        page.run(f'{head}.querySelector("button").focus()')
        page.press("Enter", 13, "\r")
        return page.run(f'{head}.getAttribute("aria-sort")')

    def number_of(self, page, name):
        heads = page.run(
            f'Array.from(document.querySelectorAll("#{self.TABLE} th"), (head) => head.textContent)'
        )
        return heads.index(name) + 1

    def test_by_number_both_ways_from_the_keyboard(self, page):
        number = self.number_of(page, "y m")
        assert self.press_head(page, number) == "ascending"
        values = [float(one) for one in column(page, self.TABLE, number)]
        assert values == sorted(values) and len(set(values)) > 2
        assert self.press_head(page, number) == "descending"
        assert [float(one) for one in column(page, self.TABLE, number)] == values[::-1]

    def test_by_word(self, page):
        number = self.number_of(page, "placement")
        self.press_head(page, number)
        words = column(page, self.TABLE, number)
        assert words == sorted(words) and len(set(words)) == 2

    def test_only_one_column_is_said_to_be_sorted(self, page):
        for name in ("y m", "placement"):
            self.press_head(page, self.number_of(page, name))
        sorted_by = page.run(f'document.querySelectorAll("#{self.TABLE} th[aria-sort]").length')
        assert sorted_by == 1
        assert "by placement, ascending" in page.run('document.getElementById("announcement").textContent')

    def test_what_is_absent_comes_last_either_way(self, page):
        page.run('document.querySelector("#all-optima-1 tbody td:nth-child(5)").dataset.sort = ""')
        first = page.run('document.querySelector("#all-optima-1 tbody tr").textContent')
        for _ in range(2):
            self.press_head(page, 5)
            assert (
                page.run('document.querySelector("#all-optima-1 tbody tr:last-child").textContent') == first
            )

    def test_keys_are_the_numbers_and_not_their_texts(self):
        assert sort_key(0.1 + 0.2, "0.300") == "0.30000000000000004"
        assert sort_key("11.4 [9.0, 13.2]", "11.4 [9.0, 13.2]") == "11.4"
        assert sort_key("2 semispans", "2 semispans") == "2"
        assert sort_key("2x", "2x") == "2x"
        assert sort_key(None, "-") == sort_key(float("nan"), "-") == ""


class TestReading:
    def test_colours_follow_the_readers_preference(self, page):
        ground = "getComputedStyle(document.body).backgroundColor"
        light = page.run(ground)
        page.prefer("dark")
        dark = page.run(ground)
        brightness = [sum(map(int, re.findall(r"\d+", one))) for one in (light, dark)]
        assert brightness[0] > 700 and brightness[1] < 150

    @pytest.mark.parametrize("scheme", ["light", "dark"])
    def test_text_has_contrast(self, page, scheme):
        page.prefer(scheme)
        for selector in ("p", "a", "figcaption p", ".missing", "td", "dt"):
            assert contrast(page, selector) >= 4.5, selector

    def test_language_title_landmarks_and_headings(self, page):
        assert page.run("document.documentElement.lang") == "en"
        assert page.run("document.title") == "Upwash: pair"
        assert page.run('document.querySelectorAll("h1").length') == 1
        assert page.run('["header", "nav", "main"].every((name) => document.querySelector(name))')
        levels = page.run(
            'Array.from(document.querySelectorAll("h1,h2,h3"), (head) => Number(head.tagName[1]))'
        )
        assert all(after - before <= 1 for before, after in zip(levels, levels[1:], strict=False))

    def test_the_first_tab_skips_to_the_content(self, page):
        page.press("Tab", 9)
        assert page.run("document.activeElement.textContent") == "Skip to the content"
        page.press("Enter", 13, "\r")
        assert page.run("document.activeElement.id") == "content"

    def test_figures_are_described_with_their_numbers(self, page):
        texts = page.run("Array.from(document.images, (one) => one.alt)")
        assert all(len(text) > 80 and re.search(r"\d", text) for text in texts)

    def test_what_scrolls_can_be_reached_by_keyboard_and_has_a_name(self, page):
        assert page.run(
            'Array.from(document.querySelectorAll(".wide")).every((one) => one.tabIndex === 0)'
            ' && Array.from(document.querySelectorAll("div.wide")).every((one) => one.ariaLabel)'
        )

    def test_links_within_lead_somewhere(self, page):
        assert (
            page.run(
                "Array.from(document.querySelectorAll(\"a[href^=\\'#\\']\"))"
                ".filter((link) => !document.getElementById(link.hash.slice(1))).length"
            )
            == 0
        )

    def test_names_are_unique(self, page):
        ids = page.run('Array.from(document.querySelectorAll("[id]"), (one) => one.id)')
        assert len(ids) == len(set(ids))


def contrast(page, selector):
    """Return the contrast of the text of the first element that fits with what lies behind it, as WCAG has it."""
    seen = page.run(
        f"""(() => {{
            let one = document.querySelector("main " + {selector!r});
            const ink = getComputedStyle(one).color;
            while (getComputedStyle(one).backgroundColor === "rgba(0, 0, 0, 0)") one = one.parentElement;
            return [ink, getComputedStyle(one).backgroundColor];
        }})()"""
    )
    levels = []
    for color in seen:
        parts = [int(part) / 255 for part in re.findall(r"\d+", color)[:3]]
        linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
        levels.append(0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])
    return (max(levels) + 0.05) / (min(levels) + 0.05)


class TestContent:
    def test_table_1_stands_beside_ours(self, page):
        assert "1.83" in column(page, "optimum-1", 3)

    def test_what_is_missing_is_named_with_the_way_to_get_it(self, page, written):
        told = page.run('document.querySelector("#species pre").textContent')
        pair, flock, limit = (written.parents[1] / name for name in ("pair", "flock", "limit"))
        assert told.splitlines() == [
            "upwash run cross-species",
            "upwash aggregate results/cross-species",
            f"upwash page {pair} {flock} {limit} results/cross-species",
        ]
        assert page.run('document.querySelector("#missing #flock")') is None

    def test_downloads_exist(self, page, written):
        links = page.run(
            'Array.from(document.querySelectorAll("a[download]"), (link) => link.getAttribute("href"))'
        )
        assert "solutions.parquet" in links and "../flock/flock.parquet" in links
        assert {"drift.parquet", "../limit/drift.parquet", "../limit/ranges.parquet"} <= set(links)
        assert len([link for link in links if not link.startswith("figures/")]) == 10
        assert all((written.parent / link).stat().st_size > 1000 for link in links)

    def test_the_line_shown_makes_the_figure(self, page, tmp_path, monkeypatch):
        code = page.run('document.querySelector("#optimum figure pre").textContent')
        monkeypatch.chdir(tmp_path)
        drawn = []
        monkeypatch.setattr(figures, "draw", lambda *asked: drawn.append(asked) or Saved())
        exec(code, {})
        assert (tmp_path / "optimal-position.pdf").exists()
        assert drawn[0][0] == "optimal-position" and drawn[0][1].endswith("pair")

    def test_provenance_is_told(self, page):
        told = page.run('document.getElementById("provenance").textContent')
        assert (
            "numpy" in told
            and f"version {SCHEMA_VERSION}" in told
            and "2 (2 solved)" in told
            and "1.0 s in all" in told
        )
        assert SWEEP.strip() in told

    def test_names_from_files_stay_text(self, page):
        assert page.run("document.querySelector('.brand span').textContent") == "pair"
        told = page.run('document.getElementById("provenance").textContent')
        assert "# A pair & its <flock>." in told
        assert page.run("document.querySelector('flock')") is None

    def test_indices_are_set_low(self):
        assert (
            subscripts("h_L/b & R_1, I_z/T, β_ud, x_m, I_z, job_id")
            == "h<sub>L</sub>/b &amp; R<sub>1</sub>, I<sub>z</sub>/T, β<sub>ud</sub>, x_m, I_z, job_id"
        )

    def test_every_claim_is_there_with_its_verdict_and_why(self, page):
        ledger = kept()
        assert column(page, "claims", 1) == list(ledger["verdict"])
        assert column(page, "claims", 6)[5] == str(ledger["why"][5])

    def test_every_claim_that_fails_is_a_card(self, page):
        fails = kept()[kept()["verdict"] == "fails"]
        cards = page.run(
            "Array.from(document.querySelectorAll('[data-models=paper] .card h4'), (one) => one.textContent)"
        )
        plain = {re.sub(r"(?<=\w)_(?=\w)", "", claim) for claim in fails["claim"]}
        assert len(cards) == len(fails) and {unparted(card) for card in cards} == plain
        told = page.run('document.querySelector("#claims-of-the-paper p").textContent')
        assert told.startswith(f"{len(fails)} of the paper's {len(kept())} claims")

    def test_negative_numbers_have_a_true_minus(self, page):
        assert any(text.startswith("−") for text in column(page, "optimum-1", 5))
        assert true_minus("-0.5 to 1e-09, -2 [-3, -1], ibis-force, 2014-15") == (
            "−0.5 to 1e-09, −2 [−3, −1], ibis-force, 2014-15"
        )

    def test_tables_are_folded_away(self, page):
        assert page.run(
            "Array.from(document.querySelectorAll('table')).every((one) => !one.checkVisibility())"
        )

    def test_a_long_table_is_cut_and_says_so(self, pair_frame):
        long = table_context(Table("t", pair_frame), "t")
        assert len(long["rows"]) == 400
        assert "the first 400 of 500 rows" in long["notes"][-1]


@pytest.fixture
def pair_frame():
    return studies.pd.DataFrame({"number": range(500)})


class Saved:
    """A figure that writes its name."""

    def savefig(self, name):
        with open(name, "w") as file:
            file.write(name)


class TestWriting:
    def test_the_same_results_give_the_same_page(self, written, monkeypatch):
        before = written.read_bytes()
        # In this process and without its helpers: who draws does not matter.
        monkeypatch.setattr("upwash.report.shown.PROCESSES", 1)
        others = (written.parents[1] / name for name in ("flock", "limit"))
        assert write_page(written.parent, *others).read_bytes() == before

    def test_a_jobs_time_is_told_once_however_many_rows_it_has(self, written):
        # Each optimum of a pair holds its job's time; each bird of a flock its own.
        told = written.read_text(encoding="utf-8")
        assert "1.0 s in all, 0.50 s a job" in told
        assert "12.0 s in all, 3.00 s a job" in told

    def test_a_folder_that_is_none_is_one_line(self, tmp_path):
        with pytest.raises(UpwashError, match="expected a results folder"):
            write_page(tmp_path / "nowhere")

    def test_none_solved_and_a_hostile_name_make_a_page_in_which_it_stays_text(self, tmp_path):
        name = "</script><script>alert(1)</script>"
        inputs = {key: studies.pair_rows()[0][key] for key in ("job_id", "objective", "kind", *studies.IBIS)}
        rows = [inputs | studies.IMPOSSIBLE | {"species": name}]
        text = write_page(
            studies.write_folder(tmp_path / "none", rows, text=f"description = '{name}'\n")
        ).read_text()
        assert "single out no bird" in text and "1 infeasible" in text
        assert "&lt;script&gt;alert(1)" in text and "<script>alert" not in text
        assert text.count("<script") == 2

    def test_results_that_single_out_no_bird_have_a_page_too(self, tmp_path, monkeypatch):
        rows = [
            row for value in (1.1, 1.2, 1.3) for row in studies.pair_rows(mass_kg=value, speed_m_s=10 * value)
        ]
        text = write_page(studies.write_folder(tmp_path / "sampled", rows)).read_text()
        assert "single out no bird" in text and "Not in these results" in text
        assert text.count("<tr>") == 1 + 6
        assert 'id="scene"' not in text
        assert "upwash claims results/reproduce" in text
