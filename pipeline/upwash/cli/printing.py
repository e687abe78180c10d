"""What commands print: JSON for programs, on standard output, and lines for people, apart from it."""

from __future__ import annotations

import json
from typing import Any

import click

as_json = click.option("--json", "json_output", is_flag=True, help="Print JSON instead of text.")


def say(line: str) -> None:
    """Write a line for a person, apart from the results."""
    click.echo(line, err=True)


def print_json(value: Any) -> None:
    """Write JSON for a program."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))
