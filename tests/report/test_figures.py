"""Figures, tested on what they draw: the values in their artists, their words and their bytes, not their pixels."""

import re
from pathlib import Path

import matplotlib
import numpy as np
import pandas as pd
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from renew_claims import kept
from upwash.aero.interaction import net_force, state_forces
from upwash.aero.pose import Pose, Stroke
from upwash.aero.wake import vortex_wake
from upwash.errors import UpwashError
from upwash.jobs.pair import Pair
from upwash.report import figures
from upwash.report.figures import (
    configurations,
    fixed_wings,
    flock_formation,
    flock_saving,
    flock_view,
    force_maps,
    limit_claims,
    lone_wake,
    optima_map,
    optimal_position,
    parameter_saving,
    spacing_rule,
    species_groups,
    species_observed,
    speed_power,
)
from upwash.report.figures.catalogue import FIGURES, save_all
from upwash.report.figures.drawing import tip_height
from upwash.report.figures.flocks import papers_flocks, series
from upwash.study import rows, sources
from upwash.study.airspeed import best_speed
from upwash.study.comparison import compare
from upwash.study.field import plane_through
from upwash.study.observations import read_observations
from upwash.study.observed.published_savings import read_published_savings

from report import studies

B, H, WAVELENGTH = 0.6, studies.IBIS["leader_amplitude_m"], 3.75
BIRD = studies.bird_of(studies.IBIS)
FORCE, POWER = (
    dict(zip(("x", "y", "z", "h", "r", "k"), studies.OPTIMA[name][1], strict=True)) for name in studies.OPTIMA
)


def pose_at(place):
    """Return the pose of a place."""
    return Pose(place["x"], place["y"], place["z"], Stroke(place["h"], place["r"]), place["k"])


@pytest.fixture(scope="module")
def pair():
    return studies.frame(studies.pair_rows())


@pytest.fixture(scope="module")
def flock():
    return studies.frame(studies.flock_rows(), "flock")


@pytest.fixture(scope="module")
def species():
    return studies.frame(studies.species_rows())


@pytest.fixture(scope="module")
def varied():
    return studies.frame(studies.varied_rows())


@pytest.fixture(scope="module")
def limit():
    return studies.frame(studies.limit_rows())


@pytest.fixture(scope="module")
def everything(pair, flock, species, varied, limit):
    """All frames that figures take."""
    return sources.Sources(
        pair,
        flock,
        species,
        varied,
        speeds=sources.varied_inputs(varied, sources.subject(varied))["speed_m_s"].query(
            "objective == 'power'"
        ),
        samples=None,
        limit=limit,
        refinement=studies.frame(studies.refinement_rows()),
        drift=studies.drift_of([*studies.pair_rows(), *studies.limit_rows()]),
        ranges=studies.ranges_of(studies.limit_rows()),
        claims=kept(),
        observations=read_observations(),
        phase=sources.read_phase(),
        observed=read_published_savings(),
        folders={},
    )


def drawn(figure, gid):
    """Return the artists of a figure that bear a name."""
    found = figure.findobj(lambda artist: artist.get_gid() == gid)
    assert found, f"nothing is named {gid}"
    return found


def line(figure, gid):
    """Return the points of a line."""
    return drawn(figure, gid)[0].get_xydata()


def points(figure, gid):
    """Return the points of a scatter."""
    return np.asarray(drawn(figure, gid)[0].get_offsets())


@pytest.fixture(scope="module", params=FIGURES)
def shown(request, everything):
    """Each figure in turn, the frames that it takes, and what it draws."""
    picture = FIGURES[request.param]
    frames = picture.arguments(everything)
    return picture, frames, picture.draw(**frames)


class TestEveryFigure:
    def test_says_what_it_shows(self, shown):
        picture, frames, _ = shown
        words = picture.describe(**frames)
        assert picture.title and picture.caption.endswith(".") and words.endswith(".")
        assert any(letter.isdigit() for letter in words) and "nan" not in words

    def test_every_panel_has_a_letter_that_the_caption_explains(self, shown):
        picture, _, figure = shown
        letters = {
            text.get_text()
            for axes in figure.axes
            for text in axes.texts
            if len(text.get_text()) == 1 and text.get_fontweight() == "bold"
        }
        assert letters == set("abcdefghij"[: len(letters)])
        found = re.findall(r"\(([a-j](?:, [a-j])*)( and so on)?\)", picture.caption)
        explained = {name for names, _ in found for name in names.split(", ")}
        # How many panels there are may depend on what was studied.
        assert explained == letters or explained < letters and any(rest for _, rest in found)

    def test_axes_are_named_or_their_ticks_are_words(self, shown):
        _, _, figure = shown
        for axes in figure.axes:
            spec = axes.get_subplotspec()
            if not axes.axison or spec is None:
                continue
            for label, ticks, is_outer in (
                (axes.get_xlabel(), axes.get_xticklabels(), spec.is_last_row()),
                (axes.get_ylabel(), axes.get_yticklabels(), spec.is_first_col()),
            ):
                words = [tick.get_text() for tick in ticks if any(map(str.isalpha, tick.get_text()))]
                assert label or words or not is_outer

    def test_nothing_is_cut_off(self, shown):
        _, _, figure = shown
        width, height = figure.get_size_inches()
        drawn_at = figure.dpi
        for resolution in (drawn_at, 600):
            figure.set_dpi(resolution)
            box = figure.get_tightbbox(FigureCanvasAgg(figure).get_renderer())
            figure.set_dpi(drawn_at)
            assert box.x0 > -0.01 and box.y0 > -0.01
            assert box.x1 < width + 0.01 and box.y1 < height + 0.01

    def test_titles_of_panels_do_not_overlap(self, shown):
        _, _, figure = shown
        renderer = FigureCanvasAgg(figure).get_renderer()
        titles = [axes.title if axes.title.get_text() else axes._left_title for axes in figure.axes]
        boxes = [title.get_window_extent(renderer) for title in titles if title.get_text().strip()]
        for number, box in enumerate(boxes):
            assert not any(box.overlaps(other) for other in boxes[number + 1 :])


class TestBytes:
    @pytest.fixture
    def contents(self, everything, tmp_path):
        """Return a function that draws and writes a figure anew and gives its bytes in each format."""

        def written():
            drawn_anew = FIGURES["spacing-rule"].draw(**FIGURES["spacing-rule"].arguments(everything))
            return [path.read_bytes() for path in save_all(drawn_anew, tmp_path / "figure")]

        return written

    def test_are_the_same_on_every_run_whatever_the_callers_style(self, contents):
        first = contents()
        with matplotlib.rc_context({"font.size": 30, "svg.hashsalt": "another", "savefig.dpi": 20}):
            assert contents() == first

    def test_ticks_do_not_depend_on_who_saves_it(self, everything):
        by_hand = FIGURES["force-maps"].draw(**FIGURES["force-maps"].arguments(everything))
        found = []
        for size in (3, 30):
            with matplotlib.rc_context({"xtick.labelsize": size, "ytick.labelsize": size}):
                found.append([list(axes.get_xticks()) + list(axes.get_yticks()) for axes in by_hand.axes])
        assert found[0] == found[1]

    def test_hold_no_date_and_no_name_of_the_writer(self, contents):
        for content in contents():
            assert not any(word in content for word in (b"Date", b"Producer", b"Creator", b"Software"))


class TestLoneWake:
    def test_areas_are_those_of_the_papers_impulse(self, pair):
        figure = lone_wake.draw(pair)
        rectangle, ellipse = drawn(figure, "up area")[0], drawn(figure, "down area")[0]
        per_area = BIRD.density_kg_m3 * BIRD.circulation_m2_s
        up = rectangle.get_width() * rectangle.get_height() * per_area
        down = np.pi / 4.0 * ellipse.width * ellipse.height * per_area
        assert (up + down) / BIRD.period_s == pytest.approx(BIRD.weight_n)

    def test_impulses_add_up_to_weight_and_drag(self):
        found = np.array(list(lone_wake.impulses(BIRD).values())).sum(axis=0) / BIRD.period_s
        assert found == pytest.approx([BIRD.drag_n, BIRD.weight_n])

    def test_rings_are_tilted_by_the_amplitude(self, pair):
        figure = lone_wake.draw(pair)
        assert np.ptp(line(figure, "down ring")[:, 1]) == pytest.approx(H)
        assert line(figure, "up ring")[0] == pytest.approx([0.0, H / 2])


class TestConfigurations:
    def test_draws_each_filament_of_each_state(self, pair):
        figure = configurations.draw(pair)
        wake = vortex_wake(H, 0.4, B, WAVELENGTH, BIRD.circulation_m2_s)
        for state, panels in ((0, figure.axes[:2]), (1, figure.axes[2:4])):
            expected = [
                configurations.VIEW.flat([corners[k], corners[(k + 1) % 4]])
                for corners in wake.corners()[wake.state == state]
                for k in range(4)
            ]
            for axes in panels:
                filaments = [
                    one.get_xydata() for one in axes.lines if (one.get_gid() or "").startswith("filament")
                ]
                assert np.array(filaments) == pytest.approx(np.array(expected))

    def test_filaments_carry_as_many_pluses_as_minuses(self, pair):
        for axes in configurations.draw(pair).axes:
            signs = [text.get_text() for text in axes.texts]
            assert signs.count("+Γ") == signs.count("−Γ") == 2

    def test_the_follower_is_raised_and_narrow_or_lowered_and_wide(self, pair):
        ends = [one.get_xydata() for one in drawn(configurations.draw(pair), "follower")]
        for k, (height, reach) in enumerate(((FORCE["h"] / 2, B * FORCE["r"]), (-FORCE["h"] / 2, B))):
            tips = [(FORCE["x"], FORCE["y"] + side * reach, FORCE["z"] + height) for side in (-1, 1)]
            assert ends[k] == pytest.approx(configurations.VIEW.flat(tips))

    def test_an_arrow_is_drawn_where_the_force_is_large(self, pair):
        figure = configurations.draw(pair)
        forces = np.linalg.norm(state_forces(BIRD, BIRD.stroke, pose_at(FORCE)), axis=-1)
        shown = [f"{value:+.3f}" for value in state_forces(BIRD, BIRD.stroke, pose_at(FORCE))[0, 1]]
        words = figure.axes[1].texts[-1].get_text() + "".join(
            text.get_text() for text in figure.axes[1].texts
        )
        assert all(number in words for number in shown)
        assert forces.argmax() == 1


@pytest.fixture(scope="module")
def figure(pair):
    """The figure of the optimal position."""
    return optimal_position.draw(pair, read_observations())


class TestOptimalPosition:
    @pytest.mark.parametrize(("name", "place"), [("force", FORCE), ("power", POWER)])
    def test_marks_the_optimum_in_both_planes(self, figure, name, place):
        above, side = drawn(figure, f"optimum {name}")
        assert above.get_xydata()[0] == pytest.approx([place["x"] / WAVELENGTH, place["y"] / B])
        assert side.get_xydata()[0] == pytest.approx([place["x"] / WAVELENGTH, place["z"] / H])

    def test_marks_what_was_observed_of_ibises(self, figure):
        seen = np.array([one.get_xydata()[0] for one in drawn(figure, "observed")]) * (WAVELENGTH, B)
        assert [1.2, 0.904] in np.round(seen, 6).tolist()

    def test_draws_the_spacing_rule(self, figure):
        level = drawn(figure, "rule force")[0].get_ydata()[0]
        assert level == pytest.approx(np.pi / 4 + (1 + FORCE["r"]) / 2)

    def test_the_followers_lowered_wingtip_meets_the_leaders_path(self, figure):
        path, leader = line(figure, "path force"), line(figure, "path leader")
        start = path[0]
        assert start == pytest.approx([FORCE["x"] / WAVELENGTH, (FORCE["z"] - FORCE["h"] / 2) / H])
        assert np.interp(start[0], *leader.T) == pytest.approx(start[1], abs=0.1)

    def test_forces_are_those_of_the_states_over_weight_and_drag(self, figure):
        found = state_forces(BIRD, BIRD.stroke, pose_at(POWER))
        thrust, lift = line(figure, "thrust power")[:, 0], line(figure, "lift power")[:, 0]
        of_states = found.reshape(4, 2)[:, ::-1] / (BIRD.drag_n, BIRD.weight_n)
        assert np.column_stack([thrust, lift])[:4] == pytest.approx(of_states)
        mean = (found[0, 1] + found[1, 0])[::-1] / 2 / (BIRD.drag_n, BIRD.weight_n)
        assert (thrust[4], lift[4]) == pytest.approx(tuple(mean))


class TestForceMaps:
    def test_hold_the_net_force_over_weight_and_drag(self, pair):
        figure = force_maps.draw(pair, size=31)
        images = [axes.images[0] for axes in figure.axes if axes.images]
        assert len(images) == 6
        x, y = np.linspace(0, 1.5 * WAVELENGTH, 31)[20], np.linspace(0, 3 * B, 31)[12]
        lift, thrust = net_force(BIRD, BIRD.stroke, pose_at(FORCE | {"x": x, "y": y}))
        assert images[0].get_array()[12, 20] == pytest.approx(lift / BIRD.weight_n)
        assert images[1].get_array()[12, 20] == pytest.approx(thrust / BIRD.drag_n)
        phase = np.linspace(0, 1, 31)[7]
        lift, thrust = net_force(BIRD, BIRD.stroke, pose_at(FORCE | {"x": x, "k": phase}))
        assert images[5].get_array()[7, 20] == pytest.approx(thrust / BIRD.drag_n)

    def test_colours_mean_the_same_in_both_columns(self, pair):
        """What the wake gives of what the bird lacks, from none in the middle, has one colour for lift and thrust."""
        figure, row = force_maps.draw(pair, size=11), rows.best(pair, "force")
        lift, thrust = (axes.images[0] for axes in figure.axes[:2])
        own = row["lift_self_n"] / row["weight_n"], row["thrust_self_n"] / row["drag_n"]
        for share in (-0.5, 0.0, 0.5, 1.0):
            colours = [
                image.cmap(image.norm(alone + share * (1.0 - alone)))
                for image, alone in zip((lift, thrust), own, strict=True)
            ]
            assert colours[0] == pytest.approx(colours[1], abs=0.01)
        assert lift.norm(own[0]) == pytest.approx(0.5)

    def test_extents_are_wavelengths_semispans_amplitudes_and_phase(self, pair):
        figure = force_maps.draw(pair, size=11)
        extents = [axes.images[0].get_extent() for axes in figure.axes if axes.images][::2]
        assert np.array(extents) == pytest.approx(np.array([(0, 1.5, 0, 3), (0, 1.5, -1, 1), (0, 1.5, 0, 1)]))

    def test_a_single_plane_has_two_panels(self, pair):
        row = rows.best(pair, "power")
        figure = force_maps.draw_plane(plane_through(row, "xz", 21), row)
        assert sum(bool(axes.images) for axes in figure.axes) == 2
        assert line(figure, "optimum xz")[0] == pytest.approx([POWER["x"] / WAVELENGTH, POWER["z"] / H])


class TestSpacingRule:
    def test_the_inner_tip_would_meet_the_vortex_on_the_dotted_lines(self, pair):
        figure = spacing_rule.draw(pair)
        levels = [one.get_ydata()[0] for one in drawn(figure, "meeting")]
        assert levels == pytest.approx([np.pi / 4 + FORCE["r"], np.pi / 4 + 1])

    def test_found_beside_rule(self, pair):
        figure = spacing_rule.draw(pair)
        assert drawn(figure, "found power")[0].get_ydata()[0] == pytest.approx(POWER["y"] / B)
        rule = drawn(figure, "rule power")[0].get_ydata()[0]
        assert rule == pytest.approx(np.pi / 4 + (1 + POWER["r"]) / 2)


class TestFixedWings:
    def test_the_limit_model_meets_its_closed_form_and_two_points_go_beyond_all_there_is(self, pair):
        figure = fixed_wings.draw(pair)
        limit, closed = line(figure, "limit"), line(figure, "closed form")
        # From line to line between the points that are drawn.
        assert np.interp(closed[:, 0], *limit.T) == pytest.approx(closed[:, 1], abs=2e-3)
        assert limit[:, 1].max() == pytest.approx(0.537, abs=1e-3)
        assert line(figure, "two points")[:, 1].max() == pytest.approx(1.336, abs=1e-3)
        assert line(figure, "elliptic")[:, 1].max() == pytest.approx(0.686, abs=1e-3)

    def test_both_wings_together_save_the_same_everywhere(self, pair):
        figure = fixed_wings.draw(pair)
        both = line(figure, "both")[:, 1]
        assert np.ptp(both) < 1e-6
        assert both == pytest.approx(line(figure, "follower")[:, 1] + line(figure, "leader")[:, 1])


class TestOptimaMap:
    def test_shows_the_best_where_they_are_the_best_first(self, pair):
        expected = [[x / WAVELENGTH, y / B] for x, y, *_ in studies.OPTIMA["force"]]
        assert line(optima_map.draw(pair), "aside optima") == pytest.approx(np.array(expected))

    def test_rings_the_v_optimum_and_crosses_the_best(self, pair):
        ring, cross = optima_map.draw(pair).axes[0].collections[:2]
        best = studies.OPTIMA["force"][0]
        assert np.asarray(ring.get_offsets())[0] == pytest.approx([FORCE["x"] / WAVELENGTH, FORCE["y"] / B])
        assert np.asarray(cross.get_offsets())[0] == pytest.approx([best[0] / WAVELENGTH, best[1] / B])

    def test_names_each_and_says_what_it_costs_above_the_best(self, pair):
        figure = optima_map.draw(pair)
        of_force = pair[pair["objective"] == "force"].sort_values("rank")
        above = of_force["cost"] / of_force["cost"].iloc[0] - 1.0
        assert line(figure, "costs")[:, 0] == pytest.approx(above.to_numpy())
        names = [text.get_text() for text in figure.axes[4].get_yticklabels()]
        assert names[1] == "2 outboard, level, astern" and len(names) == len(of_force)

    def test_ten_are_shown_and_the_v_optimum_with_them(self, pair):
        one = pair[(pair["objective"] == "force") & (pair["rank"] == 0)]
        many = [one.assign(rank=rank, cost=one["cost"] + rank) for rank in range(15)]
        many[12] = many[12].assign(is_v_optimum=True)
        shown = optima_map._best_of(studies.pd.concat(many), "force")
        assert list(shown["number"]) == [*range(1, 11), 13]


class TestFlock:
    def test_six_panels_hold_positions_stroke_and_power(self, flock):
        figure = flock_formation.draw(flock)
        steps = np.arange(6)
        assert line(figure, "y_flock_m force immediate") == pytest.approx(
            np.stack([FORCE["x"] * steps, FORCE["y"] * steps], axis=-1)
        )
        assert line(figure, "amplitude_ratio power lone")[:, 1] == pytest.approx([1.0] + [POWER["h"] / H] * 5)
        assert line(figure, "span_ratio_ratio force lone")[:, 1] == pytest.approx(
            [1.0] + [FORCE["r"] / 0.4] * 5
        )
        profile = BIRD.thrust_n(FORCE["h"], FORCE["r"]) / BIRD.drag_n
        assert line(figure, "profile_ratio force immediate")[:, 1] == pytest.approx([1.0] + [profile] * 5)

    def test_turns_at_the_front_spread_the_saving(self, flock):
        _, _, birds = next(series(papers_flocks(flock)))
        found = flock_saving.means(birds)
        saving = birds["saving_total"].iloc[1]
        assert found["saving"].to_numpy() == pytest.approx([saving * n / (n + 1) for n in range(1, 6)])
        assert found["range_gain"].iloc[0] == pytest.approx(1 / (1 - saving / 2) - 1)
        assert line(flock_saving.draw(flock), "mean force immediate")[:, 1] == pytest.approx(
            found["saving"].to_numpy()
        )

    def test_the_flock_most_like_the_papers_is_chosen(self, flock):
        longer = studies.frame(studies.flock_rows(birds=9), "flock").assign(flock_id="another")
        veed = flock.assign(shape="vee", flock_id="a third")
        chosen = papers_flocks(pd.concat([longer, veed, flock]))
        assert set(chosen["birds"]) == {6} and set(chosen["shape"]) == {"echelon"}
        assert set(papers_flocks(longer)["birds"]) == {9}

    def test_each_birds_wings_and_rings_have_its_own_phase(self, flock):
        figure = flock_view.draw(flock)
        spans = [np.ptp(drawn(figure, f"bird {n}")[0].get_xy()[:, 1]) for n in (1, 2)]
        assert spans == pytest.approx([2 * B * 0.4, 2 * B])
        assert flock_view.ring_stations(0.0) == [(0.0, 0.5, True), (0.5, 1.0, False)]
        assert flock_view.ring_stations(0.5) == [(0.0, 0.5, False), (0.5, 1.0, True)]

    def test_a_path_starts_at_the_wingtip(self, flock):
        figure = flock_view.draw(flock)
        assert line(figure, "path 1")[0] == pytest.approx([0.0, H / 2])
        assert line(figure, "path 2")[0] == pytest.approx([FORCE["x"], FORCE["z"] - FORCE["h"] / 2])

    def test_the_tip_is_highest_at_the_end_of_the_upstroke(self):
        assert tip_height(np.array([0.0, 0.25, 0.5, 1.0, -0.5])) == pytest.approx([0.5, 0.0, -0.5, 0.5, -0.5])


class TestSpecies:
    def test_lines_go_from_the_lightest_up(self, species):
        figure = FIGURES["species-position"].draw(species)
        names = [label.get_text() for label in figure.axes[0].get_yticklabels()]
        assert names == ["Dunlin", "Northern bald ibis", "Mute swan"]

    def test_marks_are_the_values_compared(self, species):
        figure, found = FIGURES["species-position"].draw(species), compare(species)
        rows = found[(found["objective"] == "power") & (found["amplitude_convention"] == "stroke-angle")]
        shown = line(figure, "y_semispans power stroke-angle")
        assert sorted(shown[:, 0]) == pytest.approx(sorted(rows["y_semispans"]))
        assert np.round(shown[np.argsort(shown[:, 1])][:, 1]).tolist() == [0, 1, 2]

    def test_what_cannot_fly_has_no_mark(self, species):
        shown = line(FIGURES["species-position"].draw(species), "x_wavelengths force strouhal")
        assert np.isnan(shown[:, 0]).sum() == 1

    def test_intervals_are_drawn_from_samples(self, species):
        samples = pd.concat([species.assign(job_id=species["job_id"] + str(n)) for n in range(9)])
        figure = FIGURES["species-position"].draw(species, samples)
        assert sum(len(one.get_segments()) for one in figure.axes[0].collections) >= 3

    def test_changes_of_the_stroke_are_set_against_each_other(self, species):
        found = line(FIGURES["species-stroke"].draw(species), "both force stroke-angle")
        assert found[:, 1] == pytest.approx([1 - FORCE["h"] / H] * 3)
        assert found[:, 0] == pytest.approx([1 - FORCE["r"] / 0.4] * 3)

    def test_the_chart_is_of_the_groups(self, species):
        figure = species_groups.draw(species)
        place = points(figure, "weight_number stroke-angle")
        ibis = [WAVELENGTH / B, BIRD.weight_n / (1.29 * B**2 * 15**2)]
        assert any(one == pytest.approx(ibis) for one in place)

    def test_a_gap_between_wingtips_is_drawn_as_a_distance_in_semispans(self, species):
        found = species_observed.compared(species, read_observations())
        ibis = found[
            (found["species"] == "northern-bald-ibis") & (found["quantity"] == "wingtip_spacing")
        ].iloc[0]
        assert ibis["observed"] == pytest.approx(2.0 - 0.115 / B)
        assert ibis["ours"] == pytest.approx(FORCE["y"] / B)
        figure = species_observed.draw(species, read_observations())
        assert any(
            one.get_xdata()[0] == pytest.approx(2.0 - 0.115 / B)
            for one in drawn(figure, "published northern-bald-ibis wingtip_spacing")
        )

    def test_the_papers_own_numbers_are_no_observations(self, species):
        found = species_observed.compared(species, read_observations())
        assert not found["study"].str.contains("Pomerenk").any()


class TestParameters:
    def test_only_inputs_varied_alone_are_drawn(self, varied):
        base = sources.subject(varied)
        assert base["mass_kg"].iloc[0] == 1.3 and base["speed_m_s"].iloc[0] == 15.0
        assert sorted(sources.varied_inputs(varied, base)) == ["mass_kg", "speed_m_s"]

    def test_three_values_make_a_line_and_two_do_not(self, varied):
        base = sources.subject(varied)
        fewer = varied[varied["speed_m_s"] != 16.0]
        assert set(fewer["speed_m_s"]) == {14.0, 15.0}
        assert sorted(sources.varied_inputs(fewer, base)) == ["mass_kg"]

    def test_a_line_breaks_where_there_is_no_v_optimum(self, varied):
        found = line(parameter_saving.draw(varied), "mass_kg force")
        assert found[:, 0] == pytest.approx([1.1, 1.2, 1.3, 1.4])
        assert np.isnan(found[0, 1]) and not np.isnan(found[1:, 1]).any()


class TestSpeeds:
    @pytest.fixture
    def speeds(self, everything):
        return everything.speeds

    def test_curves_are_the_stored_powers(self, speeds):
        figure = speed_power.draw(speeds)
        rows = speeds[speeds["is_v_optimum"].eq(True)].sort_values("speed_m_s")
        assert list(rows["speed_m_s"]) == [14.0, 15.0, 16.0]
        assert line(figure, "is_v_optimum power")[:, 1] == pytest.approx(rows["power_total_w"].to_numpy())
        alone = line(figure, "alone energy")
        assert alone[:, 0] == pytest.approx([14.0, 15.0, 16.0])
        assert alone[:, 1] == pytest.approx((rows["leader_power_total_w"] / rows["speed_m_s"]).to_numpy())

    def test_the_best_airspeed_of_a_parabola_is_its_vertex(self):
        speed = np.array([6.0, 7.0, 8.5, 10.0])
        assert best_speed(speed, (speed - 7.3) ** 2 + 2.0) == pytest.approx(7.3)

    @pytest.mark.parametrize(("slope", "end", "words"), [(1.0, 6.0, "≤ 6.0 m/s"), (-1.0, 10.0, "≥ 10.0 m/s")])
    def test_a_least_at_an_end_is_said_to_be_one(self, speeds, slope, end, words):
        assert best_speed(np.array([6.0, 8.0, 10.0]), slope * np.array([1.0, 2.0, 3.0])) == end
        of_ends = speeds.assign(
            speed_m_s=speeds["speed_m_s"].map({14.0: 6.0, 15.0: 8.0, 16.0: 10.0}),
            power_total_w=100.0 + slope * 20.0 * speeds["speed_m_s"],
        )
        assert f"V optimum {words}" in speed_power.describe(of_ends).partition(";")[0]


class TestLimit:
    """The two models' V, when to flap, and what survives of the claims."""

    def test_each_v_is_where_it_was_found_and_to_scale(self, pair, limit, everything):
        figure = FIGURES["limit-place"].draw(pair, limit, everything.observations)
        assert line(figure, "place the paper's model")[0] == pytest.approx((POWER["x"] / B, POWER["y"] / B))
        for law, (y, saving) in {"stroke": (1.8077, 0.0406), "tip": (1.3755, 0.0441)}.items():
            assert line(figure, f"place {law} law")[0] == pytest.approx((3.125, y), rel=1e-3)
            assert set(line(figure, f"ridge {law} law")[:, 1]) == {line(figure, f"place {law} law")[0, 1]}
            (bar,) = drawn(figure, f"saving {law} law")
            assert bar.get_height() == pytest.approx(saving, abs=1e-3)
        assert figure.axes[0].get_aspect() == figure.axes[1].get_aspect() == 1.0

    def test_the_best_phase_lies_on_the_line_of_what_ibises_do(self, limit, everything):
        figure = FIGURES["limit-phase"].draw(limit, everything.phase)
        for name, observed, law, near in (
            ("a", 0.0, "stroke", 1e-3),
            ("a", 0.0, "tip", 0.06),
            ("b", 0.5, "tip", 0.2),
        ):
            marks = line(figure, f"best {name} limit {law}")
            away = (marks[:, 0] - marks[:, 1] - observed + 0.5) % 1.0 - 0.5
            assert len(marks) == 4 and np.abs(away).max() < near
        crosses = line(figure, "best b paper tip")[:, 1]
        assert set(crosses) <= {0.0, 0.5}

    def test_a_line_breaks_where_the_bird_cannot_fly(self, limit, everything):
        figure = FIGURES["limit-phase"].draw(limit, everything.phase)
        for law in ("stroke", "tip"):
            in_line, in_v = (line(figure, f"saving {formation} {law}") for formation in ("in line", "V"))
            grounded = np.isnan(in_line[:, 1])
            assert np.abs(in_line[grounded, 0]).max() < 0.1 and grounded.sum() > 2
            assert np.nanmax(in_line[:, 1]) < 0.0 < in_v[:, 1].min()

    def test_refining_goes_from_the_papers_model_to_the_finest_one_thing_at_a_time(self, everything):
        figure = FIGURES["refinement"].draw(everything.refinement)
        paper = line(figure, "saving_total stroke_states others as in the paper is_v_optimum")
        assert paper[:, 1] == pytest.approx([0.3 / n + 0.05 - 0.01 - 0.01 for n in (2, 4, 8)])
        refined = line(figure, "saving_total wavelengths others refined is_global_optimum")
        assert refined[:, 1] == pytest.approx([0.3 / 8 + 0.1 / 8 - 0.01 * n for n in (1, 2, 4)])
        assert line(figure, "limit saving_total span_nodes")[0, 1] == pytest.approx(0.0441, abs=1e-3)

    def test_refining_breaks_a_line_where_there_is_no_v(self, everything):
        figure = FIGURES["refinement"].draw(everything.refinement)
        nodes = line(figure, "saving_total span_nodes others as in the paper is_v_optimum")
        assert np.isnan(nodes[:, 1]).tolist() == [False, False, True]

    @pytest.mark.parametrize("axis", ["stroke_states", "span_nodes", "wavelengths"])
    def test_refining_takes_all_three(self, axis):
        rows = [row for row in studies.refinement_rows() if row[axis] in (studies.IBIS[axis], None, np.inf)]
        assert sources._refinement(studies.frame(rows)) is None

    def test_a_claim_keeps_its_place_in_both_panels(self, everything):
        claims = everything.claims
        figure = FIGURES["limit-claims"].draw(claims)
        first = claims.iloc[:1].assign(verdict="holds", limit_verdict="fails")
        second = claims.iloc[:1].assign(verdict="fails", limit_verdict="holds")
        marks = FIGURES["limit-claims"].draw(pd.concat([second, first]))
        for column, verdicts in (("verdict", ("holds", "fails")), ("limit_verdict", ("fails", "holds"))):
            for place, verdict in enumerate(verdicts):
                (mark,) = drawn(marks, f"{column} 0 {place}")
                assert mark.get_marker() == limit_claims.LOOKS[verdict]["marker"]
        count = len([one for one in figure.findobj() if str(one.get_gid()).startswith("limit_verdict ")])
        assert count == len(claims)


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A results folder of each kind of study."""
    root = tmp_path_factory.mktemp("studies")
    return {
        "pair": studies.write_folder(root / "pair", studies.pair_rows()),
        "flock": studies.write_folder(root / "flock", studies.flock_rows(), "flock"),
        "species": studies.write_folder(root / "species", studies.species_rows()),
        "varied": studies.write_folder(root / "varied", studies.varied_rows()),
        "limit": studies.write_folder(root / "limit", studies.limit_rows()),
        "refinement": studies.write_folder(root / "refinement", studies.refinement_rows()),
    }


class TestSources:
    def test_a_study_is_known_by_what_it_varies(self, folders):
        for name, path in folders.items():
            found = sources.sort_studies([sources.read_study(path)])
            assert name in found.folders
            shown = {name} - {"pair"} | ({"limit", "varied"} if name == "refinement" else set())
            told = {"species", "varied", "flock", "limit", "refinement"} & set(found.folders)
            assert told == shown

    def test_an_endless_wake_gives_no_frame_of_wakes_that_end(self, folders):
        assert set(sources.sort_studies([sources.read_study(folders["limit"])]).folders) == {"limit"}

    @pytest.mark.parametrize("spoil", ["one span law", "no V", "another core"])
    def test_of_the_limit_both_laws_with_a_v_are_needed(self, spoil, tmp_path):
        rows = studies.limit_rows(**({"core_radius_ratio": 0.2} if spoil == "another core" else {}))
        if spoil == "one span law":
            rows = [row for row in rows if row["span_law"] == "tip"]
        elif spoil == "no V":
            rows = [row | {"is_v_optimum": False} for row in rows]
        found = sources.sort_studies([sources.read_study(studies.write_folder(tmp_path / "limit", rows))])
        assert found.limit is None

    def test_the_paper_s_bird_is_shown_of_several_in_the_limit(self, tmp_path):
        rows = [*studies.limit_rows("dunlin", mass_kg=0.05), *studies.limit_rows()]
        found = sources.sort_studies([sources.read_study(studies.write_folder(tmp_path / "limit", rows))])
        assert set(found.limit["species"]) == {"northern-bald-ibis"}
        assert len(found.limit) == len(studies.LIMIT_OPTIMA)

    def test_the_first_folder_that_has_a_frame_gives_it(self, folders):
        studied = [sources.read_study(folders[name]) for name in ("varied", "pair", "flock")]
        found = sources.sort_studies(studied)
        assert found.folders == {
            "pair": folders["varied"],
            "varied": folders["varied"],
            "speeds": folders["varied"],
            "flock": folders["flock"],
        }

    def test_of_two_studies_of_inputs_the_one_that_varies_more_is_shown(self, folders, tmp_path):
        rows = [row for speed in (13.0, 15.0, 17.0) for row in studies.pair_rows(speed_m_s=speed)]
        speeds = studies.write_folder(tmp_path / "speeds", rows)
        found = sources.sort_studies([sources.read_study(path) for path in (speeds, folders["varied"])])
        assert found.folders == {"pair": speeds, "speeds": speeds, "varied": folders["varied"]}
        assert set(found.speeds["speed_m_s"]) == {13.0, 15.0, 17.0}

    def test_the_bird_about_which_one_input_varies_is_its_species_own(self):
        rows = [row for speed in (13.0, 15.0, 17.0) for row in studies.pair_rows(speed_m_s=speed)]
        assert set(sources.subject(studies.frame(rows))["speed_m_s"]) == {15.0}

    def test_inputs_sampled_at_once_single_out_no_bird(self):
        rows = [
            row for value in (1.1, 1.2, 1.3) for row in studies.pair_rows(mass_kg=value, speed_m_s=10 * value)
        ]
        study = sources.Study(Path(), Pair, studies.frame(rows), {})
        assert sources.sort_studies([study]).pair is None

    def test_a_figure_without_its_study_says_what_it_needs(self, folders):
        with pytest.raises(
            UpwashError, match=r"flock-view: expected a study to draw it from \(flock\), found none in"
        ):
            figures.draw("flock-view", folders["pair"])
        with pytest.raises(UpwashError, match="figure: expected one of lone-wake"):
            figures.draw("no-such", folders["pair"])

    def test_a_folder_that_is_not_gathered_says_how_to_gather_it(self, tmp_path):
        with pytest.raises(UpwashError, match="expected a results folder"):
            figures.draw("lone-wake", tmp_path)
        (tmp_path / "plan.json").write_text("{}")
        with pytest.raises(UpwashError, match="upwash aggregate"):
            figures.draw("lone-wake", tmp_path)

    def test_a_damaged_file_is_one_line(self, folders, tmp_path):
        path = tmp_path / "solutions.parquet"
        path.write_bytes((folders["pair"] / "solutions.parquet").read_bytes()[:-100])
        with pytest.raises(UpwashError, match="upwash check"):
            figures.draw("lone-wake", tmp_path)


class TestObservedSaving:
    def test_each_place_stands_on_a_line_in_both_panels(self):
        observed = read_published_savings()
        figure = FIGURES["observed-saving"].draw(observed)
        for model in ("paper", "limit"):
            rows = observed[observed["model"] == model]
            saved = np.concatenate([line(figure, f"{basis} {model}") for basis in ("measured", "computed")])
            assert sorted(saved[:, 0]) == pytest.approx(sorted(rows["saving_total"]))
            assert sorted(saved[:, 1]) == list(range(len(rows)))
            assert line(figure, f"optimum {model}")[:, 0] == pytest.approx(rows["saving_at_v_optimum"])
            assert line(figure, f"mean {model}")[:, 0] == pytest.approx(rows["saving_mean_phase"])
        names = [text.get_text() for text in figure.axes[0].get_yticklabels()]
        assert names[1] == "Northern bald ibis, 0.90 m aside (Portugal 2014)"
