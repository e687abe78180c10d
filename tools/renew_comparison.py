"""Renew the tables and the figure of docs/comparison.md from results of three sweeps.

They are cross-species, uncertainty and sensitivity. Run and aggregate them (cross-species last, so that it finds
its samples), then name the folder that holds the results:

    python tools/renew_comparison.py results

Each table stands between two marks that bear its name.
"""

import re
import sys
from pathlib import Path

import pandas as pd
from upwash.report.figures.catalogue import draw
from upwash.report.figures.drawing import save
from upwash.report.species_tables import NO_V, OURS, marked, with_interval
from upwash.report.table import Table
from upwash.report.words import common_name
from upwash.study.comparison import OBJECTIVES
from upwash.study.mechanism import STATEMENTS
from upwash.study.observations import ABOVE, AGREES, BELOW, NEAR, NOT_COMPARED
from upwash.study.quantities import SAVING

PAGE = Path(__file__).parents[1] / "docs" / "comparison.md"
FIGURE = "species-saving"
PROBLEMS = [
    (objective, convention) for objective in OBJECTIVES for convention in ("stroke-angle", "strouhal")
]
INTERVAL = re.compile(r"\[(\S+), (\S+)\]")
INPUTS = {
    "leader_upstroke_span_ratio": "upstroke span ratio R",
    "speed_m_s": "airspeed U",
    "semispan_m": "semispan b",
    "period_s": "wingbeat period T",
    "stroke_half_angle_deg": "stroke half-angle θ",
    "density_kg_m3": "air density ρ",
    "mass_kg": "mass M",
    "gravity_m_s2": "gravity g",
}
OUTPUTS = {
    "saving_total": "saving",
    "saving_induced": "induced",
    "saving_profile": "profile",
    "x_wavelengths": "x/λ",
    "y_semispans": "y/b",
    "z_semispans": "z/b",
}


def savings(compared: pd.DataFrame) -> Table:
    """Return what each species saves under each problem, lightly loaded wings first."""
    loading = compared.groupby("species")["weight_number"].first().sort_values()
    rows = compared.set_index(["species", "objective", "amplitude_convention"])
    frame = pd.DataFrame({"species": map(common_name, loading.index), "W/(ρ b² U²)": loading.to_numpy()})
    for problem in PROBLEMS:
        of_problem = [rows.loc[(species, *problem)] for species in loading.index]
        frame[", ".join(problem)] = [
            marked(with_interval(row, SAVING[0]), row) if row["has_v"] else NO_V for row in of_problem
        ]
    return Table("", frame, {"W/(ρ b² U²)": ".3f"})


def mechanism_counts(counts: pd.DataFrame) -> Table:
    """Return of how many species each statement holds, and how many their ranges leave open."""
    rows = counts.set_index(["statement", "objective", "amplitude_convention"])
    frame = pd.DataFrame({"statement": [words for words, _ in STATEMENTS.values()]})
    for problem in PROBLEMS:
        frame[", ".join(problem)] = [_count(rows.loc[(words, *problem)]) for words in frame["statement"]]
    return Table("", frame)


def _count(row: pd.Series) -> str:
    undecided = len(row["undecided"].split(", ")) if row["undecided"] else 0
    return f"{row['holds']} of {row['holds'] + row['fails']}" + (f", {undecided} open" if undecided else "")


def measurements(observed: pd.DataFrame) -> Table:
    """Return what was measured on birds beside ours, for amplitudes by stroke angle."""
    chosen = observed[
        (observed["basis"] == "measured")
        & (observed["verdict"] != NOT_COMPARED)
        & (observed["amplitude_convention"] == "stroke-angle")
    ]
    lines: dict[tuple[str, ...], dict[str, str]] = {}
    for _, row in chosen.iterrows():
        what = f"{row['quantity'].replace('_', ' ')}, {row['unit']}".removesuffix(", 1")
        key = (common_name(row["species"]), row["study"], what, _published(row))
        lines.setdefault(key, {})[row["objective"]] = f"{with_interval(row, OURS)} {row['verdict']}"
    heads = ("species", "study", "quantity", "measured")
    return Table("", pd.DataFrame([dict(zip(heads, key, strict=True)) | ours for key, ours in lines.items()]))


def _published(row: pd.Series) -> str:
    ends = f"{row['observed_low']:.3g} to {row['observed_high']:.3g}"
    return (
        ends
        if pd.isna(row["observed"])
        else f"{row['observed']:.3g}" + ("" if pd.isna(row["observed_low"]) else f" ({ends})")
    )


def verdicts(observed: pd.DataFrame) -> Table:
    """Return how many measurements agree and disagree, for each problem."""
    measured = observed[(observed["basis"] == "measured") & (observed["verdict"] != NOT_COMPARED)]
    counts = measured.groupby(["objective", "amplitude_convention", "verdict"]).size().unstack(fill_value=0)
    frame = counts.reindex(columns=[AGREES, NEAR, ABOVE, BELOW], fill_value=0).rename_axis(columns=None)
    return Table("", frame.reset_index().rename(columns={"amplitude_convention": "amplitude"}))


def indices(found: pd.DataFrame, objective: str) -> Table:
    """Return the total Sobol' indices of the ibis, inputs by outputs."""
    of_it = found[found["objective"] == objective].pivot(index="input", columns="output", values="total")
    frame = of_it.loc[list(INPUTS), list(OUTPUTS)].rename(columns=OUTPUTS).reset_index(drop=True)
    frame.insert(0, "input", list(INPUTS.values()))
    return Table("", frame.rename_axis(columns=None), dict.fromkeys(OUTPUTS.values(), ".2f"))


def tables(results: Path) -> dict[str, Table]:
    """Return the page's tables by their names, from a folder of results."""
    compared, counts, observed = (
        pd.read_parquet(results / "cross-species" / "tables" / f"{name}.parquet")
        for name in ("comparison", "mechanism-counts", "observations")
    )
    found = pd.read_parquet(results / "sensitivity" / "tables" / "sensitivity.parquet")
    return {
        "savings": savings(compared),
        "mechanism": mechanism_counts(counts),
        "measured": measurements(observed),
        "verdicts": verdicts(observed),
        **{f"indices-{objective}": indices(found, objective) for objective in OBJECTIVES},
    }


def between(name: str) -> re.Pattern[str]:
    """Return what matches the table of a name on the page."""
    return re.compile(rf"(?<=<!-- {name}: begin -->\n)(.*?)(?=<!-- {name}: end -->)", re.DOTALL)


def main(results: str) -> None:
    """Put the tables of a folder of results into the page, and the figure beside it."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables(Path(results)).items():
        # An interval is not broken over two lines.
        body = INTERVAL.sub("[\\1,\N{NO-BREAK SPACE}\\2]", table.markdown().partition("\n\n")[2])
        text, count = between(name).subn(lambda _, body=body: f"\n{body}\n\n", text)
        if count != 1:
            sys.exit(f"{PAGE}: expected one table named {name}, found {count}; mark its place")
    PAGE.write_text(text, encoding="utf-8")
    save(draw(FIGURE, Path(results) / "cross-species"), PAGE.with_name(f"{FIGURE}.png"))


if __name__ == "__main__":
    main(*sys.argv[1:])
