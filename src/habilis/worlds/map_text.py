"""The lines of a map's text: what is above the map, and its rows."""

import re

from habilis.worlds.characters import BINDS, COMMENT, check_free

_BYTE_ORDER_MARK = "\ufeff"  # what some editors put at the start of a file
# What binds a character above the map; no row of a map has a small letter or a colon.
_BINDING = re.compile(rf"(\S)\s*{BINDS}\s*(.*[a-z:].*)")
_EMPTY = "the map is empty; draw at least one row, such as 'AP.CG'"

Lines = list[tuple[int, str]]
"""Lines with their numbers, from 1."""


def map_lines(text: str, name: str) -> Lines:
    """The rows of the map with their line numbers; blank lines around the map do not count."""
    lines = [
        (number, line.rstrip())
        for number, line in enumerate(text.removeprefix(_BYTE_ORDER_MARK).split("\n"), start=1)
        if not line.startswith(COMMENT)
    ]
    while lines and not lines[0][1]:
        lines.pop(0)
    while lines and not lines[-1][1]:
        lines.pop()
    if not lines:
        raise ValueError(f"{name}: {_EMPTY}")
    return lines


def bindings(lines: Lines, name: str) -> tuple[dict[str, tuple[int, str]], Lines]:
    """What lines above the map bind, by character with the line's number; and the map's rows."""
    bound: dict[str, tuple[int, str]] = {}
    rows = list(lines)
    while rows and (not rows[0][1] or _BINDING.fullmatch(rows[0][1])):
        line, text = rows.pop(0)
        found = _BINDING.fullmatch(text)
        if found is None:
            continue
        character, kind = found.groups()
        try:
            check_free(character)
        except ValueError as error:
            raise ValueError(f"{name}, line {line}: {error}") from None
        if character in bound:
            raise ValueError(
                f"{name}, line {line}: {character!r} is bound a second time, first in line "
                f"{bound[character][0]}; bind it once"
            )
        bound[character] = line, kind
    if not rows:
        raise ValueError(f"{name}: {_EMPTY}")
    return bound, rows
