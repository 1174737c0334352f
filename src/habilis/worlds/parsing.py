"""From a map's text to the things of a world."""

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from habilis.files import shown
from habilis.own_code import is_own
from habilis.worlds.grid import Cell
from habilis.worlds.map_text import (
    AGENT,
    DOOR,
    FLOOR,
    GOAL,
    OBJECT,
    SECOND,
    TOOL,
    WALL,
    Header,
    Lines,
    check_free,
    header,
    map_lines,
)
from habilis.worlds.own_tools import beside, tool_named
from habilis.worlds.things import CAN, OBJECTS, Door, PlacedObject, PlacedTool
from habilis.worlds.tools import OURS, TOOLS, UNBOUND, Reading

_GOAL_OF = re.compile(r"goal of (\S)")
_SLIP = re.compile(r"(.+?)\s+slip\s+(\S+)")
_ROLES = {role: role for role in (TOOL, SECOND, DOOR)}
_ROLES |= {AGENT: "agent", OBJECT: CAN, GOAL: "goal"}
_SECOND, _DOORS = "agent", {"door": False, "open door": True}


@dataclass(frozen=True)
class Meaning:
    """The meaning of a character of a map.

    Attributes:
        role: `AGENT`, `OBJECT`, `GOAL`, `TOOL`, `SECOND` or `DOOR`.
        kind: of object, tool or door; of a goal the character of its object, "" if it is not said.
        slip, reading: of a tool, see `PlacedTool`.
    """

    role: str
    kind: str = ""
    slip: float = 0.0
    reading: Reading = OURS


def parsed(text: str, name: str, folder: Path | None) -> dict[str, Any]:
    """The fields of a world from its map's text; see `World.parse`."""
    for what, given in (("the text of a map", text), ("the name of a map", name)):
        if not isinstance(given, str):
            raise ValueError(
                f"{what} is {shown(repr(given))}; give a str (load_world reads a map from a file)"
            )
    head, lines = header(map_lines(text, name), name)
    meanings = _meanings(head, name, None if folder is None else Path(folder))
    walls, marks = _read(lines, meanings, name)
    _check_used(head, marks, name)
    roles = {meanings[mark].role for mark in marks}
    for role in (AGENT,) if SECOND in roles else (AGENT, OBJECT, GOAL):
        if role not in roles:
            raise ValueError(
                f"{name}: the map has no {_ROLES[role]}; put one {role!r} on a floor cell"
            )
    agent = next(cell for mark, cell in marks.items() if meanings[mark].role == AGENT)
    second = [cell for mark, cell in marks.items() if meanings[mark].role == SECOND]
    if len(second) > 1:
        raise ValueError(f"{name}: a third agent is at {second[1]}; a map has two at most")
    return {
        "name": name,
        "height": len(lines),
        "width": len(lines[0][1]),
        "walls": frozenset(walls),
        "agent": agent,
        "tools": _tools(marks, meanings),
        "objects": _objects(marks, meanings, name),
        "drop": head.drop,
        "second": second[0] if second else None,
        "doors": tuple(
            Door(cell, _DOORS[meanings[mark].kind])
            for mark, cell in marks.items()
            if meanings[mark].role == DOOR
        ),
    }


def _check_used(head: Header, marks: Collection[str], name: str) -> None:
    """Refuses lines above the map that bind a character which the map does not have."""
    for character, (line, said) in head.bound.items():
        if character not in marks:
            other = character.swapcase()
            hint = f" (the map has {other!r}, which is another)" if other in marks else ""
            raise ValueError(
                f"{name}, line {line}: {character!r} is bound to {said!r} but is not on the "
                f"map{hint}; put it on a floor cell, or leave out the line"
            )


def _meanings(head: Header, name: str, folder: Path | None) -> dict[str, Meaning]:
    meanings = {AGENT: Meaning(AGENT), OBJECT: Meaning(OBJECT, CAN), GOAL: Meaning(GOAL)}
    meanings |= {TOOLS[kind].character: Meaning(TOOL, kind) for kind in UNBOUND}
    for character, (line, said) in head.bound.items():
        try:
            meanings[character] = _meaning(character, said, folder)
        except ValueError as error:
            raise type(error)(f"{name}, line {line}: {error}") from None
    return meanings


def _meaning(character: str, said: str, folder: Path | None) -> Meaning:
    """The meaning that a line above the map gives a character."""
    goal, slipping = _GOAL_OF.fullmatch(said), _SLIP.fullmatch(said)
    if goal is not None:
        check_free(character, but=GOAL)
        return Meaning(GOAL, goal[1])
    if said in OBJECTS:
        check_free(character, but=OBJECT)
        return Meaning(OBJECT, said)
    if slipping is not None and slipping[1] in OBJECTS:
        raise ValueError(
            f"{character!r} is bound to a {slipping[1]} with slip; only tools may fail"
        )
    check_free(character)
    if said == _SECOND:
        return Meaning(SECOND)
    if said in _DOORS:
        return Meaning(DOOR, said)
    kind, slip = (said, 0.0) if slipping is None else (slipping[1], _probability(slipping[2]))
    kind, reading = Reading.of(kind)
    kind = kind if folder is None else beside(folder, kind)
    if kind not in TOOLS and not is_own(kind):
        raise ValueError(
            f"{character!r} is bound to {kind!r}, which is unknown; bind it to a tool "
            f"({', '.join(TOOLS)}, or one of your own as FILE.py:CLASS), an object "
            f"({', '.join(OBJECTS)}), a goal, as in 'H = goal of C', a second agent ({_SECOND}) or "
            f"a door ({', '.join(_DOORS)})"
        )
    tool_named(kind)
    return Meaning(TOOL, kind, slip, reading)


def _probability(said: str) -> float:
    try:
        value = float(said)
    except ValueError:
        value = -1.0
    if not 0 <= value <= 1:
        raise ValueError(f"slip is {said!r}; give a probability from 0 to 1")
    return value


def _read(
    lines: Lines, meanings: dict[str, Meaning], name: str
) -> tuple[set[Cell], dict[str, Cell]]:
    """The walls, and the cells of all that is marked."""
    width = len(lines[0][1])
    known = {WALL, FLOOR, *meanings}
    walls: set[Cell] = set()
    marks: dict[str, Cell] = {}
    seen: dict[str, str] = {}
    for row, (line, cells) in enumerate(lines):
        if len(cells) != width:
            column = min(len(cells), width) + 1
            raise ValueError(
                f"{name}, line {line}, column {column}: the row has {len(cells)} cells and the "
                f"first row has {width}; give all rows the same length"
            )
        for column, character in enumerate(cells):
            place = f"line {line}, column {column + 1}"
            if character not in known:
                raise ValueError(
                    f"{name}, {place}: unknown character {character!r}; use one of "
                    f"{' '.join(sorted(known))}, or bind it above the map, as in "
                    "'R = mytools.py:Rake'"
                )
            if character == WALL:
                walls.add((row, column))
            elif character != FLOOR:
                if character in seen:
                    what = _ROLES[meanings[character].role]
                    raise ValueError(
                        f"{name}, {place}: a second {what} {character!r}, the first is at "
                        f"{seen[character]}; keep one and put {FLOOR!r} for the other"
                    )
                seen[character] = place
                marks[character] = row, column
    return walls, marks


def _objects(
    marks: dict[str, Cell], meanings: dict[str, Meaning], name: str
) -> tuple[PlacedObject, ...]:
    """The objects as the map is read, those with goals first."""
    objects = [mark for mark in marks if meanings[mark].role == OBJECT]
    goals: dict[str, Cell] = {}
    for mark, cell in marks.items():
        meaning = meanings[mark]
        if meaning.role != GOAL:
            continue
        of = meaning.kind or (objects[0] if len(objects) == 1 else "")
        if of not in objects:
            if not objects:
                raise ValueError(
                    f"{name}: {mark!r} is a goal, but no object is on the map; add one, or put "
                    f"{FLOOR!r} there"
                )
            problem = f"is the goal of {of!r}, which is not an object on the map" if of else ""
            raise ValueError(
                f"{name}: {mark!r} {problem or 'is the goal of one of several objects'}; name it "
                f"above the map, as in '{mark} = goal of {objects[0]}'"
            )
        if of in goals:
            raise ValueError(f"{name}: {mark!r} is a second goal of {of!r}; keep one")
        goals[of] = cell
    objects.sort(key=lambda mark: mark not in goals)
    return tuple(
        PlacedObject(meanings[mark].kind, marks[mark], goals.get(mark)) for mark in objects
    )


def _tools(marks: dict[str, Cell], meanings: dict[str, Meaning]) -> tuple[PlacedTool, ...]:
    """The tools as the map is read."""
    return tuple(
        PlacedTool(said.kind, cell, said.slip, reading=said.reading)
        for mark, cell in marks.items()
        if (said := meanings[mark]).role == TOOL
    )
