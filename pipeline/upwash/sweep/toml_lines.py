"""Where in a TOML file a key stands, which Python's parser does not tell."""

from __future__ import annotations

import re

Path = tuple[str | int, ...]

_TOKEN = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}|' + r"'''.*?'{3,5}|"  # text over several lines
    r'"(?:\\.|[^"\\\n])*"|' + r"'[^'\n]*'|"  # text on one line
    r"#[^\n]*|[^\S\n]+|[\[\]{}=.,\n]|[^\s\[\]{}=.,#\"']+",
    re.DOTALL,
)


def key_lines(text: str) -> dict[Path, int]:
    """Return the line, from 1, of every table and key of a valid TOML text.

    Parameters
    ----------
    text : str
        What `tomllib` has accepted.

    Returns
    -------
    dict
        Path of the key, with the index in an array of tables, -> line. Keys inside ``{}`` are not listed.
    """
    lines: dict[Path, int] = {}
    counts: dict[Path, int] = {}
    table: Path = ()
    for line, statement in _statements(text):
        if statement[0] == "[":
            is_array = statement[:2] == ["[", "["]
            *above, last = _names(statement)
            table = ()
            for name in above:
                table += (name,)
                if table in counts:
                    table += (counts[table],)
            table += (last,)
            if is_array:
                lines.setdefault(table, line)
                counts[table] = counts.get(table, -1) + 1
                table += (counts[table],)
            lines[table] = line
        else:
            path = table
            for name in _names(statement[: statement.index("=")]):
                path += (name,)
                lines.setdefault(path, line)
    return lines


def line_of(path: Path, lines: dict[Path, int]) -> int:
    """Return the line of a key, or of the nearest table above it that has one."""
    while path and path not in lines:
        path = path[:-1]
    return lines.get(path, 1)


def _statements(text: str) -> list[tuple[int, list[str]]]:
    """Split a text into headers and assignments, each with its first line; comments are dropped."""
    statements: list[tuple[int, list[str]]] = []
    tokens: list[str] = []
    line, first, depth = 1, 1, 0
    for match in _TOKEN.finditer(text):
        token = match.group()
        if token == "\n" and depth == 0:
            if tokens:
                statements.append((first, tokens))
            tokens = []
        elif not token.isspace() and not token.startswith("#"):
            if not tokens:
                first = line
            tokens.append(token)
            depth += (token in "[{") - (token in "]}")
        line += token.count("\n")
    return [*statements, (first, tokens)] if tokens else statements


def _names(tokens: list[str]) -> list[str]:
    """Return the parts of a key, unquoted."""
    return [token.strip("\"'") if token[0] in "\"'" else token for token in tokens if token not in "[].,="]
