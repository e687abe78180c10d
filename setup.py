"""What the build does beyond pyproject.toml: a wheel carries the species, the sweeps and the kept results."""

from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

INSIDE = Path("upwash", "_shipped")
"""Where `upwash.shipped` looks for them."""

FILES = sorted(
    path
    for pattern in ("species/*.*", "sweeps/*.toml", "results/reference/*")
    for path in Path().glob(pattern)
)


class BuildWithFiles(build_py):
    """Copies the files at the top of the repository into the package; an editable install finds them there."""

    def run(self) -> None:
        """Copy what the package holds, and what comes with it."""
        super().run()
        for source, target in self._copies():
            Path(target).parent.mkdir(parents=True, exist_ok=True)
            self.copy_file(str(source), target)

    def get_outputs(self, include_bytecode: bool = True) -> list[str]:
        """Name what `run` leaves."""
        return super().get_outputs(include_bytecode) + [target for _, target in self._copies()]

    def _copies(self) -> list[tuple[Path, str]]:
        if self.editable_mode:
            return []
        return [(path, str(self.build_lib / INSIDE / path)) for path in FILES]


setup(cmdclass={"build_py": BuildWithFiles})
