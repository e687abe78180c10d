"""The page that tells a sweep's story: one HTML file with figures, tables and provenance, and no need of a network."""

from __future__ import annotations

import json
import math
import os
import re
import tomllib
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import markupsafe
import pandas as pd

from upwash import columns as of
from upwash.batch.folder import ResultsFolder
from upwash.batch.store import write_atomic
from upwash.report.cards import claims_shown
from upwash.report.explorer.page import write_explorer
from upwash.report.figures.catalogue import FIGURES, FOLDER
from upwash.report.figures.drawing import OUTLINE
from upwash.report.first_screen import headline, how_sure, lead, numbers, scenes
from upwash.report.policy import policy
from upwash.report.shown import Shown, draw_all
from upwash.report.story import CHAPTERS, Chapter
from upwash.report.switches import Said, Switches, switches
from upwash.report.table import Table
from upwash.report.words import least, true_minus, words_of
from upwash.species import Species, load_species
from upwash.species.library import library_paths
from upwash.study.sources import Sources, Study, read_study, sort_studies

PAGE, EXPLORER = "index.html", "explorer.html"
TEMPLATES = files("upwash.report") / "templates"
ASSETS = {"css": ("page.css",), "js": ("switches.js", "scene.js", "marks.js", "tables.js")}
"""The parts of the page's style and script."""

NO_BIRD = "These results single out no bird whose optimum could be shown here."

MOST_ROWS = 400
"""A longer table is cut, and says so: the files hold the rest."""

LONG = 40
"""Cells of more characters are wrapped."""

UNIT = r"(?<=[0-9]) (?=(%|cm|m|b|h_L|λ|N|W|J|kg|s|g)(?![\w]))"
"""The blank between a number and its unit."""

CODE = 'from upwash.report.figures import draw; draw("{name}", "{folder}").savefig("{name}.pdf")'
"""The line that makes a figure."""

# What a table of all jobs shows of each, if the results have it; its long id comes last.
OF_A_JOB = sorted(
    (column.name for column in of.COLUMNS if of.JOBS in column.listed), key=lambda name: name == "job_id"
)


def write_page(results: str | os.PathLike[str], *more: str | os.PathLike[str]) -> Path:
    """Draw the figures of results folders and write the page about them.

    Parameters
    ----------
    results : str or path
        Results folder; the page is ``index.html`` in it, the explorer ``explorer.html``, the figures are in its
        folder ``figures``.
    *more : str or path
        Other results folders, for what the first does not hold.

    Returns
    -------
    Path
        The page.

    Raises
    ------
    UpwashError
        If a folder is no gathered results folder, or the page cannot be written.
    """
    folder = Path(results)
    studies = [read_study(Path(path)) for path in (results, *more)]
    sources = sort_studies(studies)
    settings = switches(sources)
    figures = draw_all(sources, settings, folder / FOLDER)
    write_explorer(folder / EXPLORER, species=_first_of_library(studies[0]))
    path = folder / PAGE
    write_atomic(path, render(folder, studies, sources, settings, figures).encode())
    return path


def render(
    folder: Path,
    studies: list[Study],
    sources: Sources,
    settings: Switches,
    figures: dict[str, list[Shown]],
) -> str:
    """Return the page's HTML.

    Parameters
    ----------
    folder : Path
        The results folder that the page is about.
    studies, sources
        What was read, and the frames found in it.
    settings : Switches
        The page's switches.
    figures : dict
        Name -> the figure as it is shown, for each setting in which it differs.
    """
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (TEMPLATES / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["subscripts"] = subscripts
    environment.filters["cost_words"] = least
    texts = {
        ending: "".join((TEMPLATES / name).read_text(encoding="utf-8") for name in names)
        for ending, names in ASSETS.items()
    }
    title, description = _title(studies[0])
    command = " ".join(["upwash page", *(study.path.as_posix() for study in studies)])
    chapters = [_chapter(chapter, folder, sources, figures, command) for chapter in CHAPTERS]
    marks = {figure["name"]: figure["marks"] for one in chapters for figure in one["shown"] + one["folded"]}
    return environment.get_template("page.html.j2").render(
        title=title,
        headline=headline(sources) or [Said(description or title)],
        lead=lead(sources) or [Said(NO_BIRD)],
        numbers=numbers(sources),
        sure=how_sure(sources),
        switches=settings,
        cost_words={cost: words_of(cost) for cost in settings.costs},
        has_scene=bool(scenes(sources)),
        data=as_data({"scenes": scenes(sources), "marks": marks}),
        bird=OUTLINE,
        chapters=[one for one in chapters if one["is_there"]],
        missing=[one for one in chapters if not one["is_there"]],
        claims=claims_shown(sources.claims, table_context),
        jobs=_jobs(studies[0]),
        downloads=_downloads(folder, studies),
        provenance=[_provenance(study, folder) for study in studies],
        command=command,
        explorer=EXPLORER,
        style=texts["css"],
        script=texts["js"],
        policy=policy(**texts),
    )


def as_data(value: Any) -> markupsafe.Markup:
    """Return a value as JSON that can stand in a page: nothing in it ends or opens an element."""
    text = json.dumps(value, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return markupsafe.Markup(text)


def _first_of_library(study: Study) -> Species | None:
    """Return the first of a study's species that is one of the library, with which the explorer begins."""
    library = {path.stem: path for path in library_paths()}
    known = (library[name] for name in study.rows["species"].dropna().unique() if name in library)
    path = next(known, None)
    return load_species(path) if path else None


def subscripts(text: str) -> markupsafe.Markup:
    """Return a text with indices set low, as in h_L and R_1, and units that never part from their numbers.

    Names of columns, such as x_m, stay as they are.
    """
    escaped = re.sub(UNIT, "\u00a0", str(markupsafe.escape(text)))
    low = r"\b([A-Za-zΓβκ])_([A-Z]|\d+|(?<=I_)[xz](?=/)|(?<=β_)[ud]{2})(?![A-Za-z_])"
    return markupsafe.Markup(re.sub(low, r"\1<sub>\2</sub>", escaped))


def _title(study: Study) -> tuple[str, str]:
    plan = ResultsFolder(study.path).plan()
    text = study.metadata.get("sweep", "")
    description = tomllib.loads(text).get("description", "") if text else ""
    return (plan.sweep if plan else study.path.resolve().name), str(description)


def _chapter(
    chapter: Chapter, folder: Path, sources: Sources, figures: dict[str, list[Shown]], command: str
) -> dict[str, Any]:
    at_once, folded = (
        [one for name in names for one in _figures(name, folder, sources, figures.get(name, []))]
        for names in (chapter.figures, chapter.more)
    )
    tables = [
        table_context(one.table, f"{chapter.name}-{number}") | {"costs": one.costs, "models": one.models}
        for number, one in enumerate(chapter.tables(sources), 1)
    ]
    return {
        "name": chapter.name,
        "title": chapter.title,
        "words": chapter.words(sources),
        "shown": at_once,
        "folded": folded,
        "tables": tables,
        "more": _settings([*folded, *tables]),
        "is_there": bool(at_once or folded),
        "needs": chapter.needs,
        "remedy": chapter.remedy(command),
    }


def _settings(parts: list[dict[str, Any]]) -> dict[str, tuple[str, ...]]:
    """Return the settings of the switches for which there is any of some parts; all, if a part is for all."""
    return {
        name: ()
        if any(not one[name] for one in parts)
        else tuple(sorted({v for one in parts for v in one[name]}))
        for name in ("costs", "models")
    }


def _figures(name: str, folder: Path, sources: Sources, shown: list[Shown]) -> list[dict[str, Any]]:
    """Return a figure as the page takes it, for each setting of the switches in which it differs."""
    picture = FIGURES[name]
    figures = []
    for one in shown:
        # What is kept with the code comes with any folder.
        origin = sources.folders.get(picture.needs[0], folder)
        figures.append(
            vars(one)
            | {
                "name": "-".join((name, *(one.costs if len(shown) > 1 else ()))),
                "title": picture.title,
                "caption": picture.caption,
                "marks": [[mark.left, mark.top, mark.text] for mark in one.marks],
                "files": [f"{FOLDER}/{name}{ending}" for ending in (".pdf", ".png", ".svg")],
                "code": CODE.format(name=name, folder=origin.as_posix()),
            }
        )
    return figures


def table_context(table: Table, name: str) -> dict[str, Any]:
    """Return a table as the template takes it: each cell's text, what it is sorted by, whether it is a number."""
    frame = table.frame.head(MOST_ROWS)
    numeric = [
        pd.api.types.is_numeric_dtype(frame[column]) and frame[column].dtype != bool for column in frame
    ]
    cells = table.cells()[:MOST_ROWS]
    looks = [
        "number" if is_number else "long" if max(map(len, column), default=0) > LONG else ""
        for is_number, column in zip(numeric, zip(*cells, strict=True), strict=cells != [])
    ]
    values = frame.itertuples(index=False, name=None)
    rows = [
        [
            {"text": true_minus(text), "sort": sort_key(value, text), "look": look}
            for text, value, look in zip(line, row, looks, strict=True)
        ]
        for line, row in zip(cells, values, strict=True)
    ]
    notes = list(table.notes)
    if len(table.frame) > MOST_ROWS:
        notes.append(f"the first {MOST_ROWS} of {len(table.frame)} rows; the files hold all")
    # A column of labels alone has no name where it is printed.
    head = [
        {"text": str(name) or "label", "numeric": is_number}
        for name, is_number in zip(frame, numeric, strict=True)
    ]
    return {"name": name, "title": table.title, "head": head, "rows": rows, "notes": notes}


def sort_key(value: Any, text: str) -> str:
    """Return what a cell is sorted by: the number, that with which its text begins, or the text; "" if absent."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return repr(float(value)) if math.isfinite(value) else ""
    number = re.match(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?(?![\w.])", text)
    return number[0] if number else "" if text == "-" else text


def _jobs(study: Study) -> dict[str, Any]:
    """Return the summary of a study as a table, one row a job."""
    summary = pd.read_parquet(study.path / "summary.parquet")
    shown = [name for name in OF_A_JOB if name in summary and summary[name].notna().any()]
    return table_context(Table("One row a job", summary[shown], {"solve_time_s": ".2f"}), "jobs")


def _downloads(folder: Path, studies: Iterable[Study]) -> list[dict[str, str]]:
    """Return the files that people may want, with their sizes; names are relative to the page."""
    downloads = []
    for study in studies:
        paths = [*study.path.glob("*.parquet"), *study.path.glob("*.csv"), *(study.path / "tables").glob("*")]
        for path in sorted(path for path in paths if not path.name.startswith(("journal", "retired"))):
            size = path.stat().st_size
            words = f"{size / 1e6:.1f} MB" if size >= 1e6 else f"{size / 1e3:.0f} kB"
            downloads.append({"name": _relative(path, folder), "size": words})
    return downloads


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()


def _provenance(study: Study, folder: Path) -> dict[str, Any]:
    """Return where a study's rows come from: code, packages, schema, sweep, jobs and the time that they took."""
    jobs = study.rows.drop_duplicates("job_id")
    # In a pair's rows the time is the job's, in a flock's that of each bird.
    by_job = study.rows.groupby("job_id")["solve_time_s"]
    times = (by_job.first() if study.kind.is_one_problem else by_job.sum(min_count=1)).dropna()
    versions = [version.partition("+") for version in study.metadata.get("code_version", "").split(", ")]
    return {
        "folder": _relative(study.path, folder),
        "name": study.path.resolve().name,
        "versions": " and ".join(sorted({version for version, _, _ in versions})),
        "commits": " and ".join(sorted({commit for _, _, commit in versions if commit})),
        "schema": study.metadata.get("schema_version", ""),
        "packages": json.loads(study.metadata.get("package_versions", "{}")),
        "sweep": study.metadata.get("sweep", "").strip(),
        "jobs": len(jobs),
        "statuses": ", ".join(f"{count} {status}" for status, count in jobs["status"].value_counts().items()),
        "times": f"{times.sum():.1f} s in all, {times.median():.2f} s a job"
        if len(times)
        else "not measured",
    }
