"""Sokoban's levels, as puzzles of bodies of one cell."""

import re
from pathlib import Path

import numpy as np

from habilis.bridges.puzzles.bodies import Body
from habilis.bridges.puzzles.pushworld import Goal, PushWorld, load_pushworld
from habilis.files import shown, text_of
from habilis.worlds.grid import Cell

_WALL, _AGENT, _AGENT_ON_GOAL, _BOX, _BOX_ON_GOAL, _GOAL = "#@+$*."
_FLOOR = " -_"
_ROW_END = "|"
_KNOWN = frozenset("#@+$*." + _FLOOR)
_TOKEN = re.compile(r"(\d*)(\D?)")
_TEXT = re.compile(r"\s*[;'\":A-Za-z]")  # how titles, authors and comments begin

Row = list[tuple[str, int]]
"""The characters of a row, each with its column in the file, from 1."""

_PUSHWORLD = re.compile(r".+\.pwp", re.IGNORECASE | re.DOTALL)
_SOKOBAN = re.compile(r"(.+\.xsb)(?:#(\d+))?", re.IGNORECASE | re.DOTALL)


def load_sokoban(path: str | Path, level: int = 0) -> PushWorld:
    """A level from a file of Sokoban levels (.xsb, .txt).

    `#` is a wall, `@` the agent, `+` the agent on a goal, `$` a box, `*` a box on a goal, `.` a
    goal; a space, `-` or `_` is floor. Rows may be run-length encoded, as in `3#|#@#`. Levels are
    separated by empty lines and by lines of text, such as the headers `; 0` of Boxoban.

    Args:
        path: of the file.
        level: which of its levels, counted from 0.

    Returns:
        The level as a model. Boxes are its objects, `b0`, `b1`, ... row by row, and keep their
        identities; one at a time is pushed. It is solved when every goal holds some box.

    Raises:
        ValueError: the file cannot be read or has no such level, or the level has not one agent,
            fewer boxes than goals, or an unknown character; the message names line and column.

    Example:
        >>> level = load_sokoban("levels.xsb", level=2)  # doctest: +SKIP
        >>> level.objects  # doctest: +SKIP
        ('b0', 'b1', 'b2')
    """
    return parsed_level(text_of(path, "Sokoban levels"), level, shown(Path(path).name))


def parsed_level(text: str, level: int = 0, name: str = "levels") -> PushWorld:
    """One of the levels in a text; see `load_sokoban`."""
    found = _levels(text)
    if not found:
        raise ValueError(f"{name}: there is no level; draw one with the characters # @ + $ * .")
    whole = isinstance(level, int | np.integer) and not isinstance(level, bool)
    if not whole or not 0 <= level < len(found):
        raise ValueError(
            f"{name}: level is {level!r}; the file has {len(found)}, give one from 0 to "
            f"{len(found) - 1}"
        )
    first, lines = found[level]
    rows = [(first + offset, row) for offset, line in enumerate(lines) for row in _decoded(line)]
    cells: dict[Cell, str] = {}
    places: dict[Cell, str] = {}
    for row, (number, characters) in enumerate(rows):
        for column, (character, position) in enumerate(characters):
            place = f"{name}, line {number}, column {position}"
            if character not in _KNOWN:
                raise ValueError(
                    f"{place}: unknown character {character!r}; use # @ + $ * . - and spaces"
                )
            cells[row, column], places[row, column] = character, place

    def those(*characters: str) -> list[Cell]:
        return [cell for cell, there in cells.items() if there in characters]

    agents, boxes = those(_AGENT, _AGENT_ON_GOAL), those(_BOX, _BOX_ON_GOAL)
    goals = those(_GOAL, _AGENT_ON_GOAL, _BOX_ON_GOAL)
    start = f"{name}, line {first}, column 1"
    if not agents:
        raise ValueError(f"{start}: the level has no agent; put an @ on a floor cell")
    if len(agents) > 1:
        raise ValueError(f"{places[agents[1]]}: a second agent; keep one @ or +")
    if len(boxes) < len(goals):
        raise ValueError(
            f"{start}: the level has {len(boxes)} boxes for {len(goals)} goals; draw a $ for each"
        )
    movables = [Body.covering(f"b{number}", [box]) for number, box in enumerate(boxes)]
    names = tuple(box.name for box in movables)
    return PushWorld(
        name=name if len(found) == 1 else f"{name}#{level}",
        shape=(len(rows), max(len(characters) for _, characters in rows)),
        walls=frozenset(those(_WALL)),
        agent_walls=frozenset(),
        bodies=(Body.covering("agent", agents), *movables),
        goals=tuple(Goal(cell, names) for cell in goals),
        most_pushed=1,
    )


def _levels(text: str) -> list[tuple[int, list[str]]]:
    """The lines of each level, with the number of the first."""
    found: list[tuple[int, list[str]]] = []
    inside = False
    for number, line in enumerate(text.removeprefix("\ufeff").split("\n"), 1):
        row = line.rstrip()
        drawn = bool(row) and not _TEXT.match(row)
        if drawn and not inside:
            found.append((number, []))
        if drawn:
            found[-1][1].append(row)
        inside = drawn
    return found


def _decoded(line: str) -> list[Row]:
    """The rows of a line: several where `|` ends them, each run of characters written out."""
    rows: list[Row] = [[]]
    for token in _TOKEN.finditer(line):
        count, character = token.groups()
        position = token.start(2) + 1
        if character == _ROW_END and not count:
            rows.append([])
        elif character:
            rows[-1] += [(character, position)] * int(count or 1)
        elif count:  # of nothing: an unknown character
            rows[-1].append((count, token.start() + 1))
    return rows if len(rows) == 1 or rows[-1] else rows[:-1]


def names_puzzle(name: str) -> bool:
    """Whether a name is that of a puzzle's file, such as `levels.xsb#3`."""
    return bool(_PUSHWORLD.fullmatch(name) or _SOKOBAN.fullmatch(name))


def puzzle_named(name: str) -> PushWorld | None:
    """The puzzle in a file; `None` if the name is not that of such a file.

    Raises:
        ValueError: the file is none.
    """
    if _PUSHWORLD.fullmatch(name):
        return load_pushworld(name)
    level = _SOKOBAN.fullmatch(name)
    return None if level is None else load_sokoban(level[1], int(level[2] or 0))
