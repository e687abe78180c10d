"""The commands that make pictures: field, animate and page."""

import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet as pq
import pytest
from click.testing import CliRunner
from PIL import Image
from upwash.aero.interaction import net_force
from upwash.aero.wake import wake_at_phases
from upwash.cli import main, pictures
from upwash.report import animation
from upwash.report.animation import Scene, flexed, half_span, outlines, own_phases, rings, tip_track
from upwash.study.field import field_table, plane_through
from upwash.study.rows import best, bird_of, pose_of

from report import studies


@pytest.fixture
def solved(monkeypatch):
    """Let the commands find stored results instead of searching."""
    rows = {
        "pair": studies.frame([row for row in studies.pair_rows() if row["objective"] == "force"]),
        "flock": studies.frame(list(studies.flock_rows(birds=3)[:3]), "flock"),
    }
    monkeypatch.setattr(pictures, "_solved", lambda kind, chosen: rows[kind.name])
    return rows


def run(*arguments):
    return CliRunner().invoke(main, [str(one) for one in arguments], prog_name="upwash")


class TestField:
    def test_writes_the_map_and_its_figure(self, solved, tmp_path):
        result = run(
            "field", "northern-bald-ibis", "--plane", "xz", "--size", 12, "--output", tmp_path / "maps"
        )
        assert result.exit_code == 0, result.output
        names = [f"northern-bald-ibis-force-xz.{ending}" for ending in ("parquet", "pdf", "png")]
        assert sorted(path.name for path in (tmp_path / "maps").iterdir()) == sorted(names)
        assert [line.rpartition("/")[2] for line in result.stdout.splitlines()[2:]] == names

    def test_every_row_is_the_net_force_at_its_place(self, solved, tmp_path):
        run("field", "northern-bald-ibis", "--plane", "xk", "--size", 9, "--output", tmp_path)
        table = pq.read_table(tmp_path / "northern-bald-ibis-force-xk.parquet")
        row, bird = best(solved["pair"], "force"), studies.bird_of(studies.IBIS)
        assert table.num_rows == 81
        for one in table.slice(30, 5).to_pylist():
            expected = net_force(bird, bird.stroke, replace(pose_of(row), x_m=one["x_m"], phase=one["phase"]))
            assert (one["lift_n"], one["thrust_n"]) == pytest.approx(expected)

    def test_units_and_the_optimum_stand_in_the_file(self, solved):
        row = best(solved["pair"], "force")
        schema = field_table(plane_through(row, "xy", 5), row).schema
        assert schema.field("lift_n").metadata[b"unit"] == b"N"
        assert float(schema.metadata[b"weight_n"]) == row["weight_n"]
        assert {b"code_version", b"package_versions", b"plane", b"y_m"} <= set(schema.metadata)

    def test_json_says_the_same(self, solved, tmp_path):
        record = json.loads(
            run("field", "northern-bald-ibis", "--size", 8, "--output", tmp_path, "--json").stdout
        )
        assert record["plane"] == "xy" and set(record["files"]) == {"parquet", "pdf", "png"}
        assert record["lift_over_weight"][0] < 1.0

    def test_rows_shared_out_to_threads_are_those_of_one(self, solved, monkeypatch):
        row = best(solved["pair"], "force")
        monkeypatch.setattr("os.cpu_count", lambda: 3)
        shared = plane_through(row, "xy", 10)
        monkeypatch.setattr("os.cpu_count", lambda: 1)
        alone = plane_through(row, "xy", 10)
        assert np.array_equal(shared.lift_n, alone.lift_n) and np.array_equal(shared.second, alone.second)

    def test_without_a_v_optimum_says_what_to_do(self, solved):
        solved["pair"]["is_v_optimum"] = False
        result = run("field", "northern-bald-ibis")
        assert result.exit_code == 2 and "try --optimum global" in result.stderr
        assert len(result.stderr.splitlines()) == 1

    def test_a_folder_that_cannot_be_made_is_one_line(self, solved, tmp_path):
        (tmp_path / "file").write_text("")
        result = run("field", "northern-bald-ibis", "--size", 5, "--output", tmp_path / "file" / "maps")
        assert result.exit_code == 2 and len(result.stderr.splitlines()) == 1


class TestSolving:
    """The commands from the species to the file, nothing put in the place of the search."""

    def test_a_field_goes_through_the_optimum_that_is_solved_for_it(self, tmp_path):
        result = run("field", "northern-bald-ibis", "--size", 3, "--output", tmp_path, "--json")
        assert result.exit_code == 0, result.output
        expected = dict(zip(("x_m", "y_m", "z_m"), studies.OPTIMA["force"][1], strict=False))
        found = json.loads(result.stdout)["optimum"]
        assert {name: found[name] for name in expected} == pytest.approx(expected, abs=1e-4)

    def test_an_animation_is_of_the_flock_that_is_solved_for_it(self, tmp_path, monkeypatch):
        drawn = []
        monkeypatch.setattr(animation, "write_animation", lambda birds, path: drawn.append(birds))
        result = run(
            "animate", "northern-bald-ibis", "--birds", 3, "--shape", "vee", "--output", tmp_path / "vee.gif"
        )
        assert result.exit_code == 0, result.output
        second, third = studies.OPTIMA["force"][1], drawn[0].iloc[2]
        assert list(drawn[0]["bird"]) == [1, 2, 3]
        assert (third["x_flock_m"], third["y_flock_m"]) == pytest.approx((second[0], -second[1]), abs=1e-4)


class TestAnimate:
    @pytest.fixture
    def birds(self):
        return studies.frame(studies.flock_rows(birds=3)[:3], "flock")

    def test_writes_one_wingbeat_that_repeats(self, solved, tmp_path, monkeypatch):
        monkeypatch.setattr(animation, "FRAMES", 4)
        result = run("animate", "northern-bald-ibis", "--birds", 3, "--output", tmp_path / "flock.gif")
        assert result.exit_code == 0, result.output
        assert result.stdout == f"{tmp_path / 'flock.gif'}\n"
        with Image.open(tmp_path / "flock.gif") as picture:
            assert picture.n_frames == 4 and picture.info["loop"] == 0
            pictures_of_it = []
            for number in range(4):
                picture.seek(number)
                pictures_of_it.append(np.asarray(picture.convert("RGB")).copy())
        assert not np.array_equal(pictures_of_it[0], pictures_of_it[1])

    def test_each_bird_flaps_in_its_own_phase(self, birds):
        assert own_phases(birds, 0.0) == pytest.approx([0.0, 0.5, 0.0])
        assert own_phases(birds, 0.75) == pytest.approx([0.75, 0.25, 0.75])

    def test_wings_are_raised_and_flexed_at_phase_0_and_lowered_and_wide_at_half(self, birds):
        leader = birds.iloc[0]
        for phase, height, reach in ((0.0, 0.5, 0.4), (0.5, -0.5, 1.0)):
            tip = tip_track(leader, phase)[0]
            assert tip[2] == pytest.approx(height * leader["amplitude_m"])
            assert tip[1] == pytest.approx(reach * 0.6) == pytest.approx(half_span(leader, np.array(phase)))

    def test_the_air_carries_the_path_downstream(self, birds):
        leader = birds.iloc[0]
        now, later = tip_track(leader, 0.2), tip_track(leader, 0.3)
        step = np.flatnonzero(np.isclose(later[:, 0], 0.1 * 3.75))[0]
        assert later[step, 1:] == pytest.approx(now[0, 1:])

    def test_at_the_optimum_the_follower_retraces_the_path_of_the_bird_ahead(self, birds):
        leader, follower = birds.iloc[0], birds.iloc[1]
        apart = []
        for time in np.linspace(0.0, 1.0, 21):
            ahead, own = (
                tip_track(one, phase)
                for one, phase in zip((leader, follower), own_phases(birds, time), strict=False)
            )
            apart.append(np.interp(own[0, 0], ahead[:, 0], ahead[:, 2]) - own[0, 2])
        # The heights differ by what the smaller stroke leaves out, and never by more than half of it and the offset.
        assert np.abs(apart).max() < (leader["amplitude_m"] - follower["amplitude_m"]) / 2 + 0.12
        against = birds.assign(phase_flock=0.0)
        wrong = tip_track(against.iloc[1], 0.5)[0, 2] - np.interp(1.8, *tip_track(leader, 0.5)[:, [0, 2]].T)
        assert abs(wrong) > 0.7

    @pytest.mark.parametrize("phase", [0.0, 0.3, 0.5, 0.8])
    def test_rings_are_those_of_the_model(self, birds, phase):
        leader = birds.iloc[0]
        wavelength = leader["speed_m_s"] * leader["period_s"]
        stroke = leader["amplitude_m"], leader["upstroke_span_ratio"]
        wake = wake_at_phases([phase], *stroke, leader["semispan_m"], wavelength, 1.0)
        found = rings(leader, phase)
        assert [is_up for is_up, _ in found] == list(wake.is_upstroke)
        for (_, corners), expected in zip(found, wake.corners(), strict=True):
            assert corners == pytest.approx(expected)

    def test_the_ring_that_is_being_shed_grows_at_the_bird(self, birds):
        leader = birds.iloc[0]
        lengths = []
        for phase in (0.1, 0.25, 0.4):
            is_up, corners = rings(leader, phase)[0]
            assert not is_up and corners[0, 0] == leader["x_flock_m"]
            assert corners[0, 2] == pytest.approx(tip_track(leader, phase)[0, 2])
            lengths.append(corners[2, 0] - corners[0, 0])
        assert lengths == pytest.approx([0.375, 0.9375, 1.5])

    def test_an_endless_wake_is_drawn_beyond_a_wavelength(self, birds):
        leader = birds.assign(wavelengths=np.inf).iloc[0]
        assert max(corners[:, 0].max() for _, corners in rings(leader, 0.3)) == pytest.approx(1.5 * 3.75)

    def test_wings_flex_by_the_span_law(self, birds):
        tip, stroke = birds.assign(span_law="tip").iloc[0], birds.assign(span_law="stroke").iloc[0]
        assert flexed(tip, np.array([0.25, 0.75])) == pytest.approx([0.5, 0.5])
        assert flexed(stroke, np.array([0.25, 0.75])) == pytest.approx([0.0, 1.0])
        assert flexed(stroke, np.array([0.0, 0.5, 1.0])) == pytest.approx([0.5, 0.5, 0.5])

    def test_wingtips_of_the_drawn_bird_are_where_the_model_has_them(self, birds):
        follower = birds.iloc[1]
        right, *_, left = outlines(follower, 0.3)
        tip = tip_track(follower, 0.3)[0]
        assert right[:, 1].max() == pytest.approx(tip[1], abs=0.1 * follower["semispan_m"])
        assert left[:, 1].min() == pytest.approx(2 * follower["y_flock_m"] - tip[1], abs=0.06)
        furthest = right[right[:, 1].argmax()]
        assert furthest[2] == pytest.approx(tip[2], abs=0.06)

    def test_lines_of_the_picture_are_the_tracks(self, birds):
        scene = Scene(birds)
        scene.show(0.3)
        tip = tip_track(birds.iloc[1], own_phases(birds, 0.3)[1])[0]
        assert scene.moving[1]["tip"].get_xydata()[0] == pytest.approx([tip[0], tip[2]])

    @pytest.mark.parametrize(("name", "words"), [("flock.avi", ".gif or .mp4"), ("flock.mp4", "ffmpeg")])
    def test_a_file_that_cannot_be_written_is_one_line_before_anything_is_solved(
        self, name, words, monkeypatch
    ):
        monkeypatch.setattr(animation.FFMpegWriter, "isAvailable", lambda: False)
        monkeypatch.setattr(pictures, "_solved", None)
        result = run("animate", "northern-bald-ibis", "--output", name)
        assert result.exit_code == 2 and words in result.stderr and len(result.stderr.splitlines()) == 1

    def test_a_flock_that_ends_early_is_shown_and_said(self, solved, tmp_path, monkeypatch):
        monkeypatch.setattr(animation, "FRAMES", 2)
        flock = solved["flock"]
        flock.loc[2, ["status", "error"]] = "infeasible", "no V optimum"
        result = run("animate", "northern-bald-ibis", "--birds", 3, "--output", tmp_path / "two.gif")
        assert result.exit_code == 0 and "2 of 3 birds: no V optimum" in result.stderr


def test_page_prints_where_it_is(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(
        "upwash.report.page.write_page", lambda *results: asked.append(results) or "x/index.html"
    )
    result = run("page", "x", "y")
    assert (result.exit_code, result.stdout, asked) == (0, "x/index.html\n", [("x", "y")])


def test_a_stored_row_gives_its_bird_back():
    assert bird_of(studies.frame(studies.pair_rows()).iloc[0]) == studies.bird_of(studies.IBIS)
