"""The explorer's page: one HTML file with its data, and no need of a network."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import asdict
from importlib.resources import files
from pathlib import Path
from typing import Any

import jinja2
import matplotlib

from upwash import __version__
from upwash.aero import power
from upwash.aero.bird import Bird
from upwash.aero.compiled.endless import LEAST_PHASE
from upwash.aero.compiled.rings import END_FLOOR
from upwash.aero.endless import REACH
from upwash.aero.wake import CORE_RADIUS_RATIO, ROLL_UP, STEP_IN_CORES, WakeModel
from upwash.batch.store import write_atomic
from upwash.place.balance import WIDE_AMPLITUDE, WIDE_SPAN_RATIO
from upwash.report.explorer.optima import MODELS, best_places
from upwash.report.explorer.places import paper_place, seen_places
from upwash.report.policy import policy
from upwash.report.words import words_of
from upwash.species import Species, load_library
from upwash.species.library import REFERENCE
from upwash.study.observations import read_observations

ASSETS = files("upwash.report.explorer")
SCRIPTS = (
    *("bird.js", "paper_wake.js", "endless_wake.js", "balance.js", "physics.js", "map.js"),
    *("chosen.js", "words.js", "drawing.js", "views.js", "answer.js", "map_view.js", "explorer.js"),
)
"""What the page's script is made of, each taking only from those before it."""

STROKE_GRID = {"paper": (40, 30), "limit": (16, 10)}
"""Least number of cells, by amplitude and by ratio, in which the page looks for strokes that balance."""

COLOURS = 16
"""Points at which the page is told the colours of its map."""


def constants() -> dict[str, Any]:
    """Return what the page's physics takes from ours."""
    return {
        "induced_power_factor": power.INDUCED_POWER_FACTOR,
        "body_area_m2": power.BODY_AREA_M2,
        "body_area_exponent": power.BODY_AREA_EXPONENT,
        "body_drag_coefficient": power.BODY_DRAG_COEFFICIENT,
        "roll_up": ROLL_UP,
        "core_radius_ratio": CORE_RADIUS_RATIO,
        "step_in_cores": STEP_IN_CORES,
        "end_floor": END_FLOOR,
        "reach": REACH,
        "least_phase": LEAST_PHASE,
        "stroke_bounds": tuple(zip(WIDE_AMPLITUDE, WIDE_SPAN_RATIO, strict=True)),
        "stroke_grid": STROKE_GRID,
    }


def write_explorer(
    path: Path,
    *,
    species: Species | None = None,
    bird: Bird | None = None,
    objective: str = "power",
    model: str = "limit",
    start: WakeModel | None = None,
    observed: Iterable[list[float]] = (),
    solving: Callable[[], None] = lambda: None,
) -> Path:
    """Write the explorer.

    Parameters
    ----------
    path : Path
        The file.
    species : Species, optional
        With which it begins: one of the library, or one's own; the northern bald ibis if not given.
    bird : Bird, optional
        That species' bird, if it is not as in its file.
    objective : str
        Cost function of which it tells what is saved.
    model : str
        ``paper`` or ``limit``: the model with which it begins.
    start : WakeModel, optional
        That model with the core and the span law with which it begins, if they are not its own.
    observed : iterable of [float, float]
        Places of a user's own birds, as `upwash.report.explorer.places.read_observed` returns them.
    solving : callable
        Called before best places are searched, which takes seconds: of birds that are no species' own.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    UpwashError
        If it cannot be written.
    """
    start = start or WakeModel.named(model)
    shown = {one.slug: (one, one.bird()) for one in load_library()}
    first = species.slug if species else REFERENCE
    if species is not None:
        shown[first] = (species, bird or species.bird())
    observations = read_observations()
    weights = power.COST_FUNCTIONS[objective]
    data = {
        "constants": constants(),
        "objective": {
            "name": objective,
            "words": words_of(objective),
            "weights": {name: getattr(weights, name) for name in ("force", "induced", "profile", "parasite")},
        },
        "start": {
            "species": first,
            "model": model,
            "core": start.core_radius_ratio,
            "law": start.span_law if model == "limit" else "stroke",
        },
        "observed": list(observed),
        "colours": [
            [round(255 * part) for part in matplotlib.colormaps["cividis"](share / (COLOURS - 1))[:3]]
            for share in range(COLOURS)
        ],
        "species": [
            {
                "slug": slug,
                "name": one.common_name,
                "scientific": one.scientific_name,
                "bird": asdict(its_bird),
                "optima": {
                    name: [asdict(best) for best in best_places(its_bird, name, objective, solving)]
                    for name in MODELS
                },
                "seen": seen_places(slug, its_bird, observations),
                "paper_place": paper_place(its_bird),
            }
            for slug, (one, its_bird) in shown.items()
        ],
    }
    write_atomic(path, render(data).encode())
    return path


def render(data: dict[str, Any]) -> str:
    """Return the page's HTML."""
    environment = jinja2.Environment(
        loader=jinja2.FunctionLoader(lambda name: (ASSETS / name).read_text(encoding="utf-8")),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    style = (ASSETS / "explorer.css").read_text(encoding="utf-8")
    script = "\n".join((ASSETS / name).read_text(encoding="utf-8") for name in SCRIPTS)
    # No text in the data can end its element.
    text = json.dumps(data, allow_nan=False).replace("<", "\\u003c")
    return environment.get_template("explorer.html.j2").render(
        data=text,
        style=style,
        script=script,
        policy=policy(style, script, "blob:"),
        version=__version__,
    )
