"""Maps of savings: what is asked, what is held, and what is handed on."""

import builtins
import json
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from upwash import SearchSettings, WakeModel, evaluate, load_species, map_savings, solve_pair
from upwash.errors import UpwashError
from upwash.report.figures.drawing import METADATA
from upwash.report.figures.saving_map import draw_saving_map
from upwash.study.saving_map import MAP, Asked

IBIS = load_species("northern-bald-ibis").bird()
LIMIT = WakeModel.named("limit")
SMALL = {"size": 5, "ranges": {"x": (0.6, 2.8), "y": (0.5, 1.3)}}


def mapped(plane="xy", **options):
    """Map without searching the optimum."""
    return map_savings(IBIS, plane, **{"finds_optimum": False} | options)


@pytest.fixture(scope="module")
def small():
    return mapped(**SMALL)


class TestValues:
    @pytest.mark.parametrize(
        "model", [WakeModel(), pytest.param(LIMIT, marks=pytest.mark.thorough)], ids=["paper", "limit"]
    )
    def test_a_map_agrees_with_evaluate_at_its_places(self, model):
        found = mapped(model=model, **SMALL | {"size": 3}).frame()
        told = evaluate(IBIS, found[["x_m", "y_m", "z_m", "phase"]], model=model, finds_optimum=False)
        for name in ("saving_total", "saving_induced", "amplitude_m", "spatial_phase", "cost"):
            assert found[name].to_numpy() == pytest.approx(told[name].to_numpy(), abs=1e-9), name
        assert list(found["outcome"]) == list(told["outcome"])
        assert list(found["solutions"]) == list(told["solutions"])
        # And a bird of which neither height nor phase is known saves no more than the map says.
        free = evaluate(IBIS, found[["x_m", "y_m"]], model=model, finds_optimum=False)
        assert np.all(found["cost"] <= free["cost"] + 1e-9)
        assert found["cost"].to_numpy() == pytest.approx(free["cost"].to_numpy(), rel=2e-3)

    def test_rows_go_along_the_first_side(self, small):
        frame = small.frame()
        assert list(frame) == [column.name for column in MAP]
        assert frame["x_m"].to_numpy().reshape(5, 5)[0] == pytest.approx(small.first)
        assert frame["y_m"].to_numpy().reshape(5, 5)[:, 0] == pytest.approx(small.second)
        assert frame["saving_total"].to_numpy().reshape(5, 5)[1, 2] == small.values["saving_total"][1, 2]

    @pytest.mark.parametrize("plane", ["xz", "yz", "xk"])
    def test_other_planes_go_through_the_v_optimum(self, plane):
        best = solve_pair(IBIS, "power", search=SearchSettings(tolerance=1e-2)).v_optimum
        around = {
            "x": (best.x_m - 0.01, best.x_m + 0.01),
            "y": (best.y_m - 0.01, best.y_m + 0.01),
            "z": (best.z_m - 0.01, best.z_m + 0.01),
            "phase": (best.phase - 0.01, best.phase + 0.01),
        }
        sides = Asked(plane).sides
        found = mapped(plane, size=3, ranges={name: around[name] for name in sides}, bounds="paper")
        assert found.shows_optimum()
        middle = found.values["saving_total"][1, 1]
        assert middle >= best.saving_total - 1e-9
        assert middle == pytest.approx(best.saving_total, abs=1e-6)
        assert found.best()["saving_total"] == pytest.approx(middle)
        held = {name: getattr(best, {"x": "x_m", "y": "y_m"}[name]) for name in found.held}
        assert found.held == pytest.approx(held)

    def test_what_is_held_is_taken_and_objective_and_bounds_count(self, small):
        level = mapped(**SMALL, over=["stroke", "phase"], held={"z": 0.0})
        assert np.all(level.values["z_m"] == 0.0)
        assert np.all(level.values["cost"] >= small.values["cost"] * (1.0 - 1e-9))
        narrow = mapped(**SMALL, bounds="paper")
        assert (narrow.values["outcome"] == "no-balance").sum() > (
            small.values["outcome"] == "no-balance"
        ).sum()
        assert not np.any(narrow.values["outside_paper_bounds"] == True)  # noqa: E712
        force = mapped(**SMALL, objective="force")
        assert np.all(force.values["saving_total"] <= small.values["saving_total"] + 1e-9)
        assert np.any(force.values["saving_total"] < small.values["saving_total"] - 1e-4)


class TestHandedOn:
    def test_xarray_has_the_same_values_with_units(self, small):
        data = small.to_xarray()
        assert data["saving_total"].dims == ("y_m", "x_m")
        assert data["x_m"].attrs["units"] == "m" and data["amplitude_m"].attrs["units"] == "m"
        one = data["saving_total"].sel(x_m=small.first[2], y_m=small.second[1])
        assert float(one) == small.values["saving_total"][1, 2]
        assert data.attrs["plane"] == "xy" and data.attrs["over"] == "z,phase,stroke"

    def test_without_xarray_it_says_how_to_get_it(self, small, monkeypatch):
        usual = builtins.__import__

        def missing(name, *rest):
            if name == "xarray":
                raise ImportError(name)
            return usual(name, *rest)

        monkeypatch.setattr(builtins, "__import__", missing)
        with pytest.raises(UpwashError, match=r"pip install 'upwash\[xarray\]'"):
            small.to_xarray()

    def test_parquet_holds_all_with_units_and_what_it_is_of(self, small, tmp_path):
        small.write(tmp_path / "map.parquet", {"species": "northern-bald-ibis"})
        kept = pd.read_parquet(tmp_path / "map.parquet")
        for name in ("x_m", "saving_total", "solutions", "outcome"):
            assert list(kept[name]) == list(small.frame()[name])
        schema = pq.read_schema(tmp_path / "map.parquet")
        assert schema.field("cost").metadata[b"description"] and schema.field("y_m").metadata[b"unit"] == b"m"
        assert schema.metadata[b"species"] == b"northern-bald-ibis"
        assert json.loads(schema.metadata[b"held"]) == {}


@pytest.mark.parametrize(
    ("plane", "options", "words"),
    [
        ("zz", {}, "plane: expected one of xy, xz, yz, xk"),
        ("xy", {"over": ["stroke", "speed"]}, "over: expected some of x, y, z, phase, stroke, found 'speed'"),
        ("xy", {"over": ["x", "stroke"]}, "does not show, found x"),
        ("xy", {"over": ["z"]}, "upwash field"),
        ("xy", {"held": {"z": 0.1}}, "z_m: expected LOW,HIGH or nothing"),
        ("xy", {"held": {"x": 0.1}}, "x_m: expected LOW,HIGH or nothing"),
        ("xy", {"ranges": {"z": (0.0, 0.1)}}, "z_m: expected one number"),
        ("xy", {"ranges": {"x": (2.0, 1.0)}}, "x_m: expected the lower end first"),
        ("xy", {"ranges": {"x": (-2.0, 1.0)}}, "behind the leader, found -2"),
        ("xk", {"ranges": {"phase": (0.0, 1.5)}}, "from 0 to 1, found 1.5"),
        ("xz", {"held": {"y": float("nan")}}, "y_m: expected a finite number"),
        ("xy", {"size": 1}, "size: expected a whole number of at least 2"),
        ("xy", {"bounds": "narrow"}, "bounds: expected one of paper, wide"),
        ("xy", {"objective": "joy"}, "objective"),
        ("xy", {"model": WakeModel(core="rosenhead-moore")}, "core"),
    ],
)
def test_what_does_not_fit_is_one_line(plane, options, words):
    with pytest.raises(UpwashError) as error:
        mapped(plane, **{"size": 2} | options)
    assert words in str(error.value) and "\n" not in str(error.value)


def test_without_a_v_optimum_a_plane_needs_a_value(monkeypatch):
    none = SimpleNamespace(v_optimum=None)
    monkeypatch.setattr("upwash.study.saving_map.solve_pair", lambda *given, **named: none)
    with pytest.raises(UpwashError, match="y_m: expected a value, as there is no V optimum"):
        map_savings(IBIS, "xz", size=2)
    found = map_savings(IBIS, "xz", size=2, held={"y": 1.1})
    assert found.optimum is None and not found.shows_optimum()


class TestFigure:
    def test_it_shows_zones_best_places_and_birds(self, tmp_path):
        found = map_savings(IBIS, size=8, bounds="paper", over=["stroke"], held={"z": 0.0, "phase": 0.5})
        observed = np.array([[1.2, -0.9, np.nan, np.nan], [1.0, 1.0, 0.0, 0.2], [1.0, 9.0, 0.0, 0.2]])
        figure = draw_saving_map(found, "northern-bald-ibis", "paper", observed)
        words = [text.get_text() for text in figure.legends[0].get_texts()]
        assert words[:2] == ["observed (2 of 3)", "leader"]
        assert {"best of the map", "pays", "cannot balance"} <= set(words)
        dots = next(line for line in figure.axes[0].lines if line.get_gid() == "observed")
        # Birds on the left are mirrored.
        assert dots.get_xydata().tolist() == [[1.2, 0.9], [1.0, 1.0]]
        assert "the paper's wake, z = 0.00 m, κ = 0.50" in figure.axes[0].get_title(loc="left")

    def test_a_map_on_which_nothing_balances_is_drawn(self):
        found = mapped(
            size=3,
            model=LIMIT,
            ranges={"y": (0.0, 0.01), "x": (1.8, 1.9)},
            over=["stroke"],
            held={"z": 0.0, "phase": 0.5},
        )
        assert found.best() is None
        figure = draw_saving_map(found, "northern-bald-ibis", "limit")
        assert [text.get_text() for text in figure.legends[0].get_texts()] == ["cannot balance"]

    def test_it_is_the_same_each_time(self, small, tmp_path):
        from upwash.report.figures.catalogue import save_all

        kept = []
        for number in range(2):
            paths = save_all(
                draw_saving_map(small, "northern-bald-ibis", "paper"), tmp_path / f"map{number}", METADATA
            )
            kept.append([path.read_bytes() for path in paths])
        assert kept[0] == kept[1]
