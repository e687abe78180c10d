"""The sweep over all species, run as it stands: every problem has its answer, and the documentation shows it."""

import re
from contextlib import chdir

import pandas as pd
import pytest
import renew_comparison
from click.testing import CliRunner
from upwash.cli import main
from upwash.columns import INFEASIBLE, SOLVED
from upwash.optimum.proof import OPEN
from upwash.report.species_tables import MARK
from upwash.species.library import library_paths
from upwash.study.comparison import compare
from upwash.study.mechanism import count_species, mechanism
from upwash.study.observations import compare_with_observations

pytestmark = pytest.mark.thorough

PROBLEMS_OF_A_SPECIES = 4


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Return the results folder of the sweep, run and gathered as a user does it."""
    folder = tmp_path_factory.mktemp("cross-species")
    with chdir(folder):
        for command in (
            ("run", "cross-species", "--workers", "2"),
            ("aggregate", "results/cross-species"),
            ("check", "results/cross-species"),
        ):
            finished = CliRunner().invoke(main, command, prog_name="upwash")
            assert finished.exit_code == 0, finished.output
    return folder / "results" / "cross-species"


@pytest.fixture(scope="module")
def rows(results):
    return pd.read_parquet(results / "solutions.parquet")


@pytest.fixture(scope="module")
def compared(rows):
    return compare(rows)


class TestEveryProblem:
    def test_is_solved_or_says_why_not(self, compared):
        assert len(compared) == PROBLEMS_OF_A_SPECIES * len(library_paths())
        assert compared["status"].isin([SOLVED, INFEASIBLE]).all()
        unanswered = compared[~compared["has_v"]]
        assert set(unanswered["species"]) == {"bar-tailed-godwit", "dunlin", "homing-pigeon"}
        assert set(unanswered["amplitude_convention"]) == {"strouhal"}
        assert unanswered["remark"].str.startswith("amplitude_m: expected at most twice the semispan").all()

    def test_balances(self, rows):
        solved = rows[rows["status"] == SOLVED]
        assert solved[["residual_lift", "residual_thrust"]].abs().max().max() <= 1e-9

    def test_is_proved_and_its_best_v_is_never_its_best(self, rows, compared):
        solved = rows[rows["status"] == SOLVED]
        assert solved["global_certified_gap"].max() <= 1e-4 * (1 + 1e-6)
        assert compared["v_gap"].dropna().min() > 1e-3

    def test_its_v_is_marked_where_it_is_not_proved_to_be_the_best_in_the_v(self, compared):
        is_open = compared["v_optimum_claim"] == OPEN
        assert set(compared.loc[is_open, ["objective", "amplitude_convention"]].itertuples(index=False)) == {
            ("force", "stroke-angle")
        }
        assert is_open.sum() == 11
        assert compared.loc[is_open, "remark"].str.contains("as close to its leader's side").all()

    def test_has_its_best_v_half_a_wavelength_behind_and_in_antiphase(self, compared):
        v = compared[compared["has_v"]]
        assert v["x_wavelengths"].between(0.45, 0.50).all()
        assert v["y_semispans"].between(1.45, 1.565).all()
        assert v["z_amplitudes"].abs().max() < 0.3
        assert v["phase"].to_numpy() == pytest.approx(0.5, abs=1e-9)


class TestDocumentation:
    """What docs/comparison.md shows is what a fresh run gives, to the last digit shown."""

    def cells(self, name):
        """Return the cells of a table of the page, row by row."""
        text = renew_comparison.between(name).search(renew_comparison.PAGE.read_text(encoding="utf-8"))[1]
        return [line.strip("| ").split(" | ") for line in text.strip().splitlines()]

    def numbers(self, cells):
        """Return the numbers and words of cells, without the intervals; a mark is a word of its own."""
        bare = [word for cell in cells for word in re.sub(r"\s\[.*?\]", "", cell).split(f" {MARK}")]
        return [float(word) if re.fullmatch(r"-?[\d.]+", word) else word for word in bare]

    def test_savings(self, compared):
        heads, _, *shown = self.cells("savings")
        fresh = renew_comparison.savings(compared)
        assert heads == list(fresh.frame.columns)
        for line, page in zip(fresh.cells(), shown, strict=True):
            assert self.numbers(page) == [
                pytest.approx(cell, abs=0.051) if isinstance(cell, float) else cell
                for cell in self.numbers(line)
            ]

    def test_measured_positions(self, rows):
        heads, _, *shown = self.cells("measured")
        fresh = renew_comparison.measurements(compare_with_observations(rows))
        assert heads == list(fresh.frame.columns)
        for (*what, force, power), (*page_what, page_force, page_power) in zip(
            fresh.cells(), shown, strict=True
        ):
            assert page_what == what
            for ours, page in ((force, page_force), (power, page_power)):
                assert float(page.split()[0]) == pytest.approx(float(ours.split()[0]), rel=6e-3)

    def test_statements(self, rows):
        heads, _, *shown = self.cells("mechanism")
        fresh = renew_comparison.mechanism_counts(count_species(mechanism(rows)))
        assert heads == list(fresh.frame.columns)
        for line, page in zip(fresh.cells(), shown, strict=True):
            assert [cell.partition(",")[0] for cell in page] == line

    def test_the_kinds_of_v(self, compared):
        v = compared[
            (compared["objective"] == "force") & (compared["amplitude_convention"] == "stroke-angle")
        ]
        shallow = v[v["z_semispans"] > 0.01]
        assert len(shallow) == 9
        assert shallow["saving_total"].max() < 0.053
        assert v.drop(shallow.index)["saving_total"].min() > 0.08
        assert (v["best_station"] == "abreast").sum() == 16
