"""Compile ahead what commands need."""

from __future__ import annotations

import time

import click

from upwash.cli.printing import as_json, print_json, say
from upwash.cli.streams import at_work


@click.command()
@as_json
def warm(json_output: bool) -> None:
    """Compile now what commands would compile when first called.

    Kernels are compiled once for this version of them and this processor, in two processes, and kept; `make install`
    does it. Printed is how many were compiled for each part of the work, 0 if they were before. Exit code 2 if they
    cannot be kept.

    \b
    Example:
      upwash warm
    """
    from upwash.ahead import PARTS, compile_ahead, kept_in

    doing: list[str] = []

    def begin(part: str) -> None:
        doing.append(part)
        at_work(f"compiling {' and '.join(doing)}")

    begun = time.monotonic()
    kernels = {}
    for done in compile_ahead(begin):
        doing.remove(done.part)
        kernels[done.part] = done.kernels
        if done.kernels:
            took = f"{time.monotonic() - begun:.0f} s"
            say(f"compiled {done.part} ({len(kernels)} of {len(PARTS)}, {took})")
    folder = kept_in()
    counts = [{"part": part, "kernels": kernels[part]} for part in PARTS]
    if json_output:
        print_json({"folder": folder, "compiled": counts})
        return
    width = max(map(len, PARTS))
    for one in counts:
        click.echo(f"{one['part']:<{width}}  {one['kernels']:>3} compiled")
    click.echo(f"kept in {folder}")
