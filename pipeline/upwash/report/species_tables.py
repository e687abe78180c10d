"""The comparison of species as tables to read: few columns, percent, and intervals in brackets."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from upwash.columns import Column
from upwash.optimum.proof import PROVED
from upwash.report.table import ABSENT, Table, cell
from upwash.study.mechanism import STATEMENTS
from upwash.study.observations import ABOVE, AGREES, BELOW, NEAR, NOT_COMPARED
from upwash.study.quantities import ALIKE, COMPARED, GAP, GROUPS, POSITION, QUANTITIES, SAVING, STROKE

NO_V = "no V"
INTERVALS = "in brackets: 5 % and 95 % quantiles of the samples from each species' own ranges"

MARK = "†"
"""Stands beside what is not proved to be the best of all local optima in the V."""

NOT_PROVED = f"{MARK} not proved to be the best optimum in the V: another may cost less, by as much as {{}}"

OURS = Column("ours", "", "what we find", format=".3g")


def with_interval(row: pd.Series, column: Column, name: str = "", spec: str = "") -> str:
    """Write a quantity and, if it has one, its interval: ``11.4 [9.0, 13.2]``.

    `name` is where it stands and `spec` how it is written, if not as the column says.
    """
    name, spec = name or column.name, spec or column.format
    written = cell(column.factor * row[name], spec)
    ends = [column.factor * row[f"{name}_{end}"] for end in ("low", "high")]
    if written == ABSENT or any(map(pd.isna, ends)):
        return written
    return f"{written} [{', '.join(cell(end, spec) for end in ends)}]"


def marked(written: str, row: pd.Series) -> str:
    """Mark what is written of a V optimum that is not proved to be the best in the V."""
    return f"{written} {MARK}" if row["has_v"] and row["v_optimum_claim"] != PROVED else written


def _marks_explained(compared: pd.DataFrame, where: str) -> list[str]:
    """Explain the mark if anything bears it."""
    is_marked = compared["has_v"] & (compared["v_optimum_claim"] != PROVED)
    return [NOT_PROVED.format(where)] if is_marked.any() else []


def _written(frame: pd.DataFrame, columns: Iterable[Column]) -> dict[str, list[str]]:
    """Return the written cells of those columns that are for people, by their heads."""
    return {
        column.heading: [with_interval(row, column) for _, row in frame.iterrows()]
        for column in columns
        if COMPARED in column.listed
    }


def comparison_tables(compared: pd.DataFrame) -> list[Table]:
    """Return the V optima of all species, a table for each objective and amplitude convention, from
    `upwash.study.comparison.compare`.
    """
    tables = []
    for (objective, convention), group in compared.groupby(["objective", "amplitude_convention"], sort=False):
        frame = pd.DataFrame(
            {
                "species": [marked(row["species"], row) for _, row in group.iterrows()],
                **_written(group, POSITION + SAVING),
            }
            | {"alike %": [_alike(row) for _, row in group.iterrows()]}
            | {**_written(group, STROKE + GAP), "remark": group["remark"].replace("", ABSENT)}
        )
        notes = [
            f"alike: what all the optima in a V save that cost the same to within {ALIKE:.1%}",
            "gap: cost of the V optimum above that of the best optimum found",
            *_marks_explained(group, "the remark says"),
        ]
        if group["samples"].notna().any():
            notes.append(f"{INTERVALS}; {_samples(group)}")
        tables.append(Table(f"V optima by {objective}, amplitude by {convention}", frame, notes=tuple(notes)))
    return tables


def _alike(row: pd.Series) -> str:
    """Write the range of savings among optima in a V that cost the same, if there are several."""
    if row["v_alike"] < 2:
        return ABSENT
    return " to ".join(cell(100.0 * row[f"v_alike_saving_{end}"], ".1f") for end in ("low", "high"))


def overview_table(compared: pd.DataFrame) -> Table:
    """Return the saving of total power of every species under every problem, from
    `upwash.study.comparison.compare`.
    """
    problems = compared["objective"] + ", " + compared["amplitude_convention"]
    written = compared.assign(
        problem=problems,
        written=[
            marked(with_interval(row, SAVING[0]), row) if row["has_v"] else NO_V
            for _, row in compared.iterrows()
        ],
    ).pivot(index="species", columns="problem", values="written")
    frame = written.fillna(ABSENT).rename_axis(columns=None).reset_index()
    notes = [f"{NO_V}: there is no V optimum; the next tables say why"]
    notes += _marks_explained(compared, "the next tables say")
    if compared["samples"].notna().any():
        notes.append(f"{INTERVALS}; {_samples(compared)}")
    return Table("Saving of total power at the V optimum, in percent", frame, notes=tuple(notes))


def intervals_table(ends: pd.DataFrame) -> Table:
    """Return the intervals alone, from `upwash.study.intervals.intervals` with its index as columns."""
    shown = {
        column.heading: [
            " to ".join(
                cell(column.factor * row[f"{column.name}_{end}"], column.format) for end in ("low", "high")
            )
            for _, row in ends.iterrows()
        ]
        for column in QUANTITIES
        if COMPARED in column.listed
    }
    frame = pd.DataFrame({**ends[["species", "objective", "amplitude_convention"]], **shown})
    return Table(f"5 % to 95 % quantiles over the samples: {_samples(ends)}", frame)


def _samples(group: pd.DataFrame) -> str:
    """Say how many samples there are, and what came of them."""
    count, failed, without = (
        int(group[name].sum()) for name in ("samples", "samples_failed", "samples_without_v")
    )
    by_species = group.groupby("species")["samples_without_v"].sum()
    where = ", ".join(f"{species} {int(many)}" for species, many in by_species[by_species > 0].items())
    counted = f"{count} samples, {failed} failed, {without} without a V optimum"
    return f"{counted} ({where})" if where else counted


def groups_table(compared: pd.DataFrame) -> Table:
    """Return the dimensionless groups of all species, and the saving of force that follows from them alone,
    from `upwash.study.comparison.compare`.
    """
    keys = ["species", "amplitude_convention"]
    by_force = compared[compared["objective"] == "force"].sort_values(
        ["amplitude_convention", "weight_number"], kind="stable"
    )
    frame = by_force[[*keys, *(column.name for column in GROUPS)]].rename(
        columns={column.name: column.head for column in GROUPS}
    )
    for column in POSITION:
        if column.name.endswith("_semispans") and column.head:
            frame[column.head] = by_force[column.name]
    frame["force saved %"] = 100.0 * by_force["saving_cost"]
    formats = dict.fromkeys(frame.columns, ".3f") | {"force saved %": ".2f"}
    return Table("The four groups, and the force-optimal V that follows from them alone", frame, formats)


def objectives_tables(changes: pd.DataFrame) -> list[Table]:
    """Return what changes from least force to least power, a table for each amplitude convention, from
    `upwash.study.comparison.compare_objectives`.
    """
    tables = []
    for convention, group in changes.groupby("amplitude_convention", sort=False):
        shown = {
            f"Δ {column.heading}": [
                with_interval(row, column, f"{column.name}_change", f"+{column.format}")
                for _, row in group.iterrows()
            ]
            for column in QUANTITIES
            if COMPARED in column.listed
        }
        frame = pd.DataFrame({"species": group["species"], **shown})
        title = f"By power less by force, amplitude by {convention}"
        notes = ("Δ of a percentage is in percentage points", INTERVALS)
        has_intervals = group.filter(like="_change_low").notna().any(axis=None)
        tables.append(Table(title, frame, notes=notes if has_intervals else notes[:1]))
    return tables


def counts_table(counts: pd.DataFrame) -> Table:
    """Return of how many species each statement holds, from `upwash.study.mechanism.count_species`."""
    heads = {"amplitude_convention": "amplitude", "without_v": "without V"}
    return Table("Of how many species each statement holds", counts.replace("", ABSENT).rename(columns=heads))


def answers_table(answers: pd.DataFrame) -> Table:
    """Return whether each statement holds, species by species, from `upwash.study.mechanism.mechanism`."""
    frame = answers[["species", "objective", "amplitude_convention"]].copy()
    for name in STATEMENTS:
        frame[name] = [_answer(row[name], row[f"{name}_share"]) for _, row in answers.iterrows()]
    title = "How each follower saves; in brackets the share of the samples in which it holds"
    return Table(title, frame, notes=tuple(f"{name}: {words}" for name, (words, _) in STATEMENTS.items()))


def _answer(holds: bool | None, share: float) -> str:
    if pd.isna(holds):
        return NO_V
    return cell(bool(holds)) + ("" if pd.isna(share) else f" ({share:.0%})")


def observations_tables(observed: pd.DataFrame) -> list[Table]:
    """Return the verdicts counted, then each observation with ours, then what is not compared and why, from
    `upwash.study.observations.compare_with_observations`.
    """
    compared = observed[observed["verdict"] != NOT_COMPARED]
    # What the paper got from this very model is no observation.
    basis = compared["basis"].mask(compared["this_model"].astype(bool), "computed, by the paper itself")
    counts = (
        compared.groupby([basis, "objective", "amplitude_convention", "verdict"])
        .size()
        .unstack(fill_value=0)
        .reindex(columns=[AGREES, NEAR, ABOVE, BELOW], fill_value=0)
    )
    others = observed[observed["verdict"] == NOT_COMPARED]
    left = others[["species", "study", "quantity", "objective", "amplitude_convention", "remark"]]
    return [
        Table("Verdicts", counts.rename_axis(columns=None).reset_index()),
        Table("Published and ours", _side_by_side(compared)),
        Table("Not compared, and why", left.fillna("").replace("", ABSENT)),
    ]


def _side_by_side(compared: pd.DataFrame) -> pd.DataFrame:
    """Return one row an observation, and a column with ours for each objective and amplitude convention."""
    shown = pd.DataFrame(
        {
            "species": compared["species"],
            "study": compared["study"],
            "quantity": compared["quantity"].str.replace("_", " "),
            "unit": compared["unit"],
            "basis": compared["basis"],
            "published": [_published(row) for _, row in compared.iterrows()],
            "problem": compared["objective"] + ", " + compared["amplitude_convention"],
            "ours": [f"{with_interval(row, OURS)} {row['verdict']}" for _, row in compared.iterrows()],
        }
    )
    keys = [name for name in shown.columns if name not in ("problem", "ours")]
    # In the order of the file, not of the alphabet.
    wide = shown.pivot(index=keys, columns="problem", values="ours")
    return wide.loc[list(dict.fromkeys(map(tuple, shown[keys].to_numpy())))].fillna(NO_V).reset_index()


def _published(row: pd.Series) -> str:
    """Write a published value and range: ``0.169 (-0.9 to 1.89)``, ``at most 0.5``."""
    value, low, high = (row[name] for name in ("observed", "observed_low", "observed_high"))
    if pd.notna(low) and pd.notna(high):
        span = f"{cell(low, '.3g')} to {cell(high, '.3g')}"
        return f"{cell(value, '.3g')} ({span})" if pd.notna(value) else span
    if pd.notna(low) or pd.notna(high):
        return f"at most {cell(high, '.3g')}" if pd.notna(high) else f"at least {cell(low, '.3g')}"
    return cell(value, ".3g")


def sensitivity_tables(indices: pd.DataFrame) -> list[Table]:
    """Return the indices, a table for each problem and kind of index: inputs by outputs, from
    `upwash.study.sensitivity.sensitivity`.
    """
    tables = []
    keys = ["species", "objective", "amplitude_convention"]
    for key, group in indices.groupby(keys, sort=False):
        varying = group[group["total"].notna()]
        for name, words in (("total", "Total"), ("first_order", "First-order")):
            written = varying.assign(
                written=[
                    f"{row[name]:.2f} ± {row[f'{name}_confidence']:.2f}" for _, row in varying.iterrows()
                ]
            ).pivot(index="input", columns="output", values="written")
            inputs, outputs = (varying[column].drop_duplicates() for column in ("input", "output"))
            frame = written.loc[inputs, outputs].reset_index().rename_axis(columns=None)
            title = f"{words} Sobol' indices: {', '.join(map(str, key))}"
            tables.append(Table(title, frame, notes=_coverage(group)))
    return tables


def _coverage(group: pd.DataFrame) -> tuple[str, ...]:
    """Say what the indices rest on, and for which outputs there are none."""
    first = group.iloc[0]
    lines = [
        f"{first['samples']} samples of {first['points']} points, {first['samples_failed']} failed, "
        f"{first['samples_without_v']} without a V optimum; ±: half width of the 95 % interval",
    ]
    by_output = group.groupby("output", sort=False).first()
    lost = by_output[by_output["points_usable"] < by_output["points"]]
    if len(lost):
        lines.append(
            "left out, with all samples of their points: "
            + ", ".join(
                f"{name} {row['points'] - row['points_usable']} points" for name, row in lost.iterrows()
            )
        )
    constant = by_output.index[by_output["total"].isna()]
    if len(constant):
        lines.append(f"no index, as it does not vary or too few points are usable: {', '.join(constant)}")
    return tuple(lines)
