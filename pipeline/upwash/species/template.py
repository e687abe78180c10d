"""A species file to fill in: every line explained, every ``?`` to be replaced."""

from __future__ import annotations

import json
from contextlib import suppress
from pathlib import Path

from upwash.errors import UpwashError
from upwash.species.file import printable
from upwash.species.library import slug_of

LONGEST_NAME = 80

TEMPLATE = """\
# Replace every "?", then run:  upwash species check ./{slug}.toml
#
# A quantity has   value, unit   as measured; Upwash converts to SI
#                  low, high     the range to sample, in the same unit
#                  basis         measured, given, computed or assumed
#                  source        the original work: authors, year, journal volume:page
#                  rule          instead of all these: the formula that fills the value in
#                  sample, note  optional: number of birds or tracks; what a reader should know
# No published range? The library takes mass ±10 %, wingspan ±5 %, wing_area ±15 %, speed ± its deviation.

common_name = {common_name}
scientific_name = "?"

[mass]
value = "?"
unit = "kg"                  # or "g"
low = "?"
high = "?"
basis = "measured"
source = "?"

[wingspan]                   # tip to tip, outstretched: not the semispan
value = "?"
unit = "m"                   # or "cm"
low = "?"
high = "?"
basis = "measured"
source = "?"

[wing_area]                  # both wings and the body between; unknown: delete it and state the frequency
value = "?"
unit = "m2"                  # or "cm2"
low = "?"
high = "?"
basis = "measured"
source = "?"

[speed]                      # cruising airspeed; not measured: rule = "alerstam-2007" and nothing else
value = "?"
unit = "m/s"                 # or "km/h"
low = "?"
high = "?"
basis = "measured"
source = "?"

[wingbeat_frequency]         # measured, in "Hz"? Write the six lines as above instead of the rule
rule = "pennycuick-1996"

[stroke_half_angle]          # half the angle that a wing sweeps, unit "deg"
rule = "nudds-2004"

[upstroke_span_ratio]        # span on the upstroke over span on the downstroke
rule = "as-ibis"
unit = "1"
low = 0.3                    # wider than the ibis's own range: this is another bird
high = 0.6

[air_density]                # unit "kg/m3"; other air than the library's makes comparisons of species unfair
rule = "as-ibis"

[gravity]                    # unit "m/s2"
rule = "as-ibis"

# How it flies with others, if known: "V", "echelon", "cluster" or "none".
# [formation]
# shape = "V"
# basis = "measured"
# source = "?"
"""


def write_template(name: str, folder: Path) -> Path:
    """Write a species file to fill in, and never over another file.

    Parameters
    ----------
    name : str
        The bird's name; its small letters, digits and hyphens name the file.
    folder : Path
        Where to write it.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    UpwashError
        If the name makes no file name, the file exists, or the folder cannot be written to.
    """
    name = name.strip().removesuffix(".toml")
    slug = slug_of(name)
    if (
        not slug
        or "/" in name
        or "\\" in name
        or name.startswith(".")
        or not name.isprintable()
        or len(name) > LONGEST_NAME
    ):
        raise UpwashError(
            f"NAME: expected a bird's name, at most {LONGEST_NAME} characters and no folder in it, "
            f"found {printable(name)}; name the folder by --folder"
        )
    common_name = name if name != slug else slug.replace("-", " ").capitalize()
    path = folder / f"{slug}.toml"
    text = TEMPLATE.format(slug=slug, common_name=json.dumps(common_name, ensure_ascii=False))
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise UpwashError(
            f"{path}: expected no file of that name, found one; it is unchanged: choose another name"
        ) from error
    except OSError as error:
        # Half a file would be in the way of the next attempt.
        with suppress(OSError):
            path.unlink()
        raise UpwashError(
            f"{path}: expected a folder to write to, found: {error.strerror}; choose another by --folder"
        ) from error
    return path
