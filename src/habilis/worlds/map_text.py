"""The characters and lines of a map's text: its rows, and the header above them."""

import re
from dataclasses import dataclass

WALL, FLOOR, AGENT, OBJECT, GOAL = "#.ACG"
TOOL, SECOND, DOOR = "tool", "second agent", "door"
"""The roles of characters without one that a map always has for them."""
COMMENT = ";"
BINDS = "="
"""Between a character and what it stands for, in a line above the map."""

DROP = "drop"
"""The setting above a map that lets the agent put down its tool."""

_BYTE_ORDER_MARK = "\ufeff"  # what some editors put at the start of a file
# What binds a character above the map, or sets something.
_BINDING = re.compile(rf"(\S)\s*{BINDS}\s*(.*[^\s{BINDS}].*)")
_SETTING = re.compile(r"([a-z]+)\s*:\s*(\S+)")
# Lines that try to: what has the sign and a space, a small letter or a colon is no drawn row.
_TRIES_TO_BIND = re.compile(rf"(?=.*[\sa-z:]).*{BINDS}.*")
_TRIES_TO_SET = re.compile(r"(?=.*[a-z])[A-Za-z]{2,}\s*:.*")
_EMPTY = "the map is empty; draw at least one row, such as 'AP.CG'"

_TAKEN = {
    WALL: "a wall",
    FLOOR: "floor",
    AGENT: "the agent",
    OBJECT: "the can",
    GOAL: "the goal",
    COMMENT: "a comment",
    BINDS: "what binds a character",
}

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


@dataclass(frozen=True)
class Header:
    """The lines above a map.

    Attributes:
        bound: by character the line's number and what it binds the character to.
        drop: whether a tool may be put down.
    """

    bound: dict[str, tuple[int, str]]
    drop: bool = False


def header(lines: Lines, name: str) -> tuple[Header, Lines]:
    """The header that the lines above the map make, and the map's rows."""
    bound: dict[str, tuple[int, str]] = {}
    drop: tuple[int, bool] | None = None
    rows = list(lines)
    while rows and _is_above(rows[0][1]):
        line, text = rows.pop(0)
        _check_line(f"{name}, line {line}", text)
        setting = _SETTING.fullmatch(text)
        if setting is not None:
            said = _drop(f"{name}, line {line}", *setting.groups())
            if drop is not None:
                raise ValueError(
                    f"{name}, line {line}: {DROP} is set a second time, first in line {drop[0]}; "
                    "set it once"
                )
            drop = line, said
        found = _BINDING.fullmatch(text)
        if found is None:
            continue
        character, kind = found.groups()
        if character in bound:
            raise ValueError(
                f"{name}, line {line}: {character!r} is bound a second time, first in line "
                f"{bound[character][0]}; bind it once"
            )
        bound[character] = line, kind
    if not rows:
        raise ValueError(f"{name}: {_EMPTY}")
    for line, text in rows:
        if _TRIES_TO_BIND.fullmatch(text):
            raise ValueError(
                f"{name}, line {line}: {text!r} binds a character below the first row of the map; "
                "put it above that"
            )
    return Header(bound, drop is not None and drop[1]), rows


def _is_above(text: str) -> bool:
    """Whether a line is none of the map's rows."""
    return not text or bool(_TRIES_TO_BIND.fullmatch(text) or _TRIES_TO_SET.fullmatch(text))


def _check_line(place: str, text: str) -> None:
    """Refuses a line above the map that neither binds a character nor sets anything."""
    if not text or _BINDING.fullmatch(text) or _SETTING.fullmatch(text):
        return
    left, _, right = (part.strip() for part in text.partition(BINDS))
    if BINDS not in text or left.lower() == DROP:
        raise ValueError(f"{place}: {text!r} is not a setting; the only one is '{DROP}: true'")
    problem = f"{left!r} is not one character" if left and right else f"{text!r} binds nothing"
    raise ValueError(
        f"{place}: {problem}; write one character, {BINDS!r} and its meaning, as in 'R = rake'"
    )


def _drop(place: str, setting: str, value: str) -> bool:
    if setting != DROP:
        raise ValueError(f"{place}: setting {setting!r} is unknown; the only one is {DROP!r}")
    if value not in ("true", "false"):
        raise ValueError(f"{place}: {DROP} is {value!r}; write 'true' or 'false'")
    return value == "true"


def check_free(character: object, but: str = "") -> None:
    """Refuses what cannot stand for a tool, or something else of one's own, on a map.

    Args:
        character: what is to stand for it.
        but: a character that may, though a map has another use for it.

    Raises:
        ValueError: it is not one printable character, or a map needs it for something else.
    """
    if not isinstance(character, str) or len(character) != 1 or not character.isprintable():
        raise ValueError(f"character is {character!r}; give one printable character, such as 'R'")
    if character.isspace() or (character in _TAKEN and character != but):
        meaning = _TAKEN.get(character, "nothing")
        raise ValueError(
            f"character {character!r} stands for {meaning} on a map; give another, such as 'R'"
        )
