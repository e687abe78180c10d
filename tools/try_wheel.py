"""Build an sdist, a wheel from it, and try the wheel in a fresh environment and an empty folder.

``make wheel`` runs it. Nothing is taken from a network: the environment finds the dependencies of this one, but not the
package itself.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
PIP = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input"]
BUILD_SDIST = "import sys; from setuptools.build_meta import build_sdist; build_sdist(sys.argv[1])"

COMMANDS = [
    "species list",
    "species check",
    "optimum northern-bald-ibis",
    "run reproduce",
    "aggregate results/reproduce",
    "check results/reproduce",
    "page results/reproduce",
]
"""What must work where there is nothing but the wheel."""


def build(folder: Path) -> tuple[Path, Path]:
    """Build an sdist and, from it alone, a wheel; return both."""
    subprocess.run(
        [sys.executable, "-c", BUILD_SDIST, folder], cwd=ROOT, check=True, stdout=subprocess.DEVNULL
    )
    (sdist,) = folder.glob("*.tar.gz")
    options = ["--no-deps", "--no-build-isolation", "--wheel-dir", folder]
    subprocess.run([*PIP, "wheel", *options, sdist], check=True)
    (wheel,) = folder.glob("*.whl")
    return sdist, wheel


def install(wheel: Path, folder: Path) -> Path:
    """Install a wheel into a new environment that finds the dependencies of this one; return its ``upwash``."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder], check=True)
    python = folder / "bin" / "python"
    subprocess.run([*PIP, "--python", python, "install", "--no-deps", wheel], check=True)
    (packages,) = folder.glob("lib/python*/site-packages")
    # A path in a .pth file is searched last, and .pth files there, as that of an editable install, are not read.
    (packages / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    return folder / "bin" / "upwash"


def outside() -> dict[str, str]:
    """Return an environment that leads nowhere into the checkout."""
    return {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA"))}


def main() -> None:
    """Run each command in turn; the first that fails ends this."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _, wheel = build(folder)
        command = install(wheel, folder / "environment")
        empty = folder / "empty"
        empty.mkdir()
        for line in COMMANDS:
            print(f"upwash {line}", flush=True)
            arguments = [command, *line.split()]
            told = subprocess.run(arguments, cwd=empty, env=outside(), capture_output=True, text=True)
            if told.returncode:
                sys.exit(f"expected exit code 0, found {told.returncode}:\n{told.stdout}{told.stderr}")
        page = empty / "results" / "reproduce" / "index.html"
        if not page.is_file():
            sys.exit(f"expected {page.name}, found none")
        print(f"{wheel.name}: works")


if __name__ == "__main__":
    main()
