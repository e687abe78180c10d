"""Finding species: by a name in the library's folder, or by the path of a file."""

from __future__ import annotations

import math
import os
import re
import unicodedata
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from upwash.errors import UpwashError
from upwash.shipped import shipped
from upwash.species.file import SpeciesFile, file_here, printable, read_species_file
from upwash.species.groups import outside
from upwash.species.quantity import Quantity
from upwash.species.species import Species

LIBRARY_FOLDER = shipped("species")
REFERENCE = "northern-bald-ibis"


def slug_of(name: str) -> str:
    """Turn a species' name into a file name: small letters, digits and hyphens alone."""
    plain = unicodedata.normalize("NFKD", name).encode("ascii", "ignore").decode()
    return re.sub(r"[^a-z0-9]+", "-", plain.replace("'", "").lower()).strip("-")


def library_paths() -> list[Path]:
    """Return the library's species files, sorted by name."""
    paths = sorted(LIBRARY_FOLDER.glob("*.toml"))
    if not paths:
        raise UpwashError(
            f"species library: expected TOML files in {LIBRARY_FOLDER}, found none; install Upwash again"
        )
    return paths


def find_species(name_or_path: str | os.PathLike[str]) -> Path:
    """Return the file of a species.

    Parameters
    ----------
    name_or_path : str or path
        A name in the library (``mute-swan``, ``Mute swan``), or the path of a TOML file: whatever ends in
        ``.toml`` or contains a path separator.

    Raises
    ------
    UpwashError
        If the library has no such name; the message lists the nearest.
    """
    text = os.fspath(name_or_path)
    if text.endswith(".toml") or "/" in text or os.sep in text:
        return Path(text)
    paths = {path.stem: path for path in library_paths()}
    slug = slug_of(text)
    if slug in paths:
        return paths[slug]
    containing = [other for other in paths if slug and slug in other][:3]
    near = containing or get_close_matches(slug, paths, n=3, cutoff=0.5)
    remedy = f"did you mean {', '.join(near)}?" if near else "'upwash species list' names all"
    remedy = file_here(text) or remedy
    raise UpwashError(
        f"species: expected a name in the library or a path to a TOML file, found {printable(text)}; {remedy}"
    )


def load_species(name_or_path: str | os.PathLike[str]) -> Species:
    """Read, check and return a species.

    Parameters
    ----------
    name_or_path : str or path
        A name in the library, or the path of a TOML file, as for `find_species`.

    Raises
    ------
    UpwashError
        If there is no such species, or anything in its file is missing, unknown or impossible.

    Examples
    --------
    >>> dunlin = load_species("dunlin")
    >>> dunlin.scientific_name, round(dunlin.bird(speed_m_s=14.0).wavelength_m, 2)
    ('Calidris alpina', 1.35)
    """
    path = find_species(name_or_path)
    content = read_species_file(path, _ibis)
    amplitude, wavelength = _reference_stroke()
    species = Species(
        slug=path.stem,
        common_name=content.common_name,
        scientific_name=content.scientific_name,
        quantities=content.quantities,
        formation=content.formation,
        note=content.note,
        reference_amplitude_m=amplitude,
        reference_wavelength_m=wavelength,
    )
    for sentence in outside(species.groups(), "possible"):
        raise UpwashError(f"{path}: {sentence}")
    for name, ends in species.ranges().items():
        for end in ends:
            try:
                species.bird("stroke-angle", **{name: end})
            except UpwashError as error:
                raise UpwashError(f"{path}: at an end of its range: {error}") from error
    return species


def load_library() -> list[Species]:
    """Return every species of the library, sorted by name."""
    return [load_species(path) for path in library_paths()]


@cache
def _reference_file() -> SpeciesFile:
    """Return the northern bald ibis's file, from which other species take what they do not know."""

    def itself() -> Mapping[str, Quantity]:
        raise UpwashError(
            f"{REFERENCE}: expected every value stated, found rule 'as-ibis', which is itself; state a value"
        )

    return read_species_file(LIBRARY_FOLDER / f"{REFERENCE}.toml", itself)


def _ibis() -> Mapping[str, Quantity]:
    return _reference_file().quantities


def _reference_stroke() -> tuple[float, float]:
    """Return the lone northern bald ibis's amplitude and wavelength, in m."""
    ibis = _ibis()
    amplitude = ibis["wingspan"].value * math.sin(math.radians(ibis["stroke_half_angle"].value))
    return amplitude, ibis["speed"].value * (1.0 / ibis["wingbeat_frequency"].value)
