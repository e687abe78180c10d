"""Where numba keeps what it compiles: a folder named after the sources, so that any change of them is seen.

numba renews a compiled function when the file of that function changes, but not when a function or a constant
that it takes from another file does. A stale kernel would silently compute yesterday's physics.
"""

from __future__ import annotations

import os
import sys
from hashlib import sha256
from pathlib import Path

PACKAGE = Path(__file__).parent
COMPILED_ROOMS = ("aero", "optimum")


def cache_folder() -> Path:
    """Return the folder for compiled code: it differs for every content of the rooms that hold some."""
    digest = sha256()
    for path in sorted(path for room in COMPILED_ROOMS for path in (PACKAGE / room).glob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return PACKAGE / "__pycache__" / f"numba-{digest.hexdigest()[:12]}"


def use_cache_folder() -> None:
    """Point numba, imported already or not, at `cache_folder`, unless the user's NUMBA_CACHE_DIR says where.

    Where the folder cannot be written numba falls back to its own choices.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR", "")
    inherited = (
        Path(chosen).parent.name == "__pycache__"
    )  # set below by a parent process, perhaps for older sources
    if chosen and not inherited:
        return
    folder = str(cache_folder())
    os.environ["NUMBA_CACHE_DIR"] = folder
    if "numba" in sys.modules:
        sys.modules["numba"].config.CACHE_DIR = folder
