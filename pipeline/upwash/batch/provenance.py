"""Where results come from, as their files state it: whether it is complete, and can be true."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping

from upwash import __version__
from upwash.batch.store import PACKAGES, provenance

CODE = re.compile(r"(\d+)\.(\d+)\.(\d+)(\+[0-9a-f]{7,40}(-dirty)?)?")
"""A version of Upwash and, in a checkout, the commit and whether files differed from it."""

PACKAGE = re.compile(r"\d+(\.\w+)*([+.-]\w+)*")
STATED = tuple(provenance(""))


def misstated(metadata: Mapping[str, str], sweep: str | None) -> Iterator[tuple[str, str]]:
    """Give what of a file's metadata is missing or cannot be true, and why.

    Parameters
    ----------
    metadata : mapping
        The file's metadata.
    sweep : str or None
        The sweep's own text; None if it is not known.
    """
    for name in STATED:
        if name not in metadata:
            yield (
                name,
                "expected in the file's metadata, found none; take the results from where they were made",
            )
    for code in metadata.get("code_version", __version__).split(", "):
        form = CODE.fullmatch(code)
        if form is None:
            yield "code_version", f"expected a version of Upwash, as {__version__}, found {code!r}"
        elif tuple(map(int, form.groups()[:3])) > tuple(map(int, __version__.split("."))):
            yield "code_version", f"expected {__version__} or an earlier one, found {code}; update Upwash"
    if sweep is not None and metadata.get("sweep", sweep) != sweep:
        yield "sweep", "expected the text that stands in plan.json, found another"
    yield from _packages(metadata.get("package_versions"))


def _packages(text: str | None) -> Iterator[tuple[str, str]]:
    if text is None:
        return
    try:
        found = json.loads(text)
        versions = {name: str(found[name]).split(", ") for name in PACKAGES}
    except (ValueError, KeyError, TypeError):
        yield "package_versions", f"expected those of {', '.join(PACKAGES)}, found {text[:60]!r}"
        return
    for name, several in versions.items():
        if not all(PACKAGE.fullmatch(version) for version in several):
            yield "package_versions", f"expected versions of {name}, found {found[name]!r}"
