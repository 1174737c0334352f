"""From the things of a world to its map's text."""

from collections.abc import Sequence
from dataclasses import dataclass
from string import ascii_uppercase
from typing import TYPE_CHECKING

from habilis.reprs import counted
from habilis.worlds.grid import Cell
from habilis.worlds.map_text import (
    AGENT,
    BINDS,
    DOOR,
    DROP,
    FLOOR,
    GOAL,
    OBJECT,
    SECOND,
    TOOL,
    WALL,
)
from habilis.worlds.things import CAN, OBJECTS, Door, PlacedObject, PlacedTool
from habilis.worlds.tools import TOOLS, UNBOUND

if TYPE_CHECKING:
    from habilis.worlds.world import World


@dataclass(frozen=True)
class Mark:
    """A character on a map.

    Attributes:
        character: drawn.
        cell: where.
        role: `AGENT`, `OBJECT`, `GOAL`, `TOOL`, `SECOND` or `DOOR`.
        binding: the line above the map that says what it stands for; "" if none must.
    """

    character: str
    cell: Cell
    role: str
    binding: str = ""


def marks_of(
    agent: Cell,
    tools: Sequence[PlacedTool],
    objects: Sequence[PlacedObject],
    second: Cell | None = None,
    doors: Sequence[Door] = (),
) -> list[Mark]:
    """The marks of a map besides walls, goals and doors first: what is on them hides them."""
    alone = len(objects) == 1
    usual_ones = [OBJECT if alone else OBJECTS[thing.kind].character for thing in objects]
    known = (rule.character for rule in (*(tool.rule for tool in tools), *TOOLS.values()))
    free = _Characters({WALL, FLOOR, AGENT}, {OBJECT, GOAL, *usual_ones, *known})
    goals, marks = [], []
    for thing, wanted in zip(objects, usual_ones, strict=True):
        character = free.take(wanted)
        usual = character == OBJECT and thing.kind == CAN
        binds = "" if usual else _bound(character, thing.kind)
        marks.append(Mark(character, thing.cell, OBJECT, binds))
        if thing.goal is not None:
            goal = free.take(GOAL)
            of = _bound(goal, f"goal of {character}") if not alone else ""
            goals.append(Mark(goal, thing.goal, GOAL, of))
    marks.append(Mark(AGENT, agent, AGENT))
    for tool in tools:
        character = free.take(tool.rule.character)
        binds = _tool_binding(character, tool.rule.character, tool)
        marks.append(Mark(character, tool.cell, TOOL, binds))
    if second is not None:
        character = free.take("E")
        marks.append(Mark(character, second, SECOND, _bound(character, "agent")))
    for door in doors:
        character = free.take("O" if door.is_open else "D")
        kind = "open door" if door.is_open else "door"
        goals.append(Mark(character, door.cell, DOOR, _bound(character, kind)))
    return [*goals, *marks]


def header_of(marks: Sequence[Mark], drop: bool) -> list[str]:
    """The lines above the map: second agent and doors, tools, objects, then the goals of these."""
    bound = [
        mark.binding
        for role in (SECOND, DOOR, TOOL, OBJECT, GOAL)
        for mark in marks
        if mark.role == role and mark.binding
    ]
    return [*bound, *([f"{DROP}: true"] if drop else [])]


def described(world: "World") -> list[str]:
    """The map and its things in words, a part for each kind of thing."""
    goals = [f"{thing.name}'s goal {thing.goal}" for thing in world.objects if thing.goal]
    things = [f"{thing.name} {thing.cell}" for thing in (*world.tools, *world.objects)]
    second = [] if world.second is None else [f"second agent {world.second}"]
    return [
        f"{world.height} × {world.width} cells, {counted(len(world.walls), 'wall')}",
        ", ".join([f"agent {world.agent}", *second, *things]),
        ", ".join(f"{'open ' if door.is_open else ''}door {door.cell}" for door in world.doors),
        ", ".join(goals),
        "tools can be dropped" if world.drop else "",
    ]


def binding(character: str, kind: str) -> str:
    """The line that says which tool a character stands for; "" where none is needed."""
    return "" if kind in UNBOUND else _bound(character, kind)


class _Characters:
    """Characters that are still free, where some are kept for what usually has them."""

    def __init__(self, taken: set[str], usual: set[str]):
        self.taken, self.usual = taken, usual

    def take(self, wanted: str) -> str:
        """The one that is wanted, or one of the next."""
        after = [*ascii_uppercase[ascii_uppercase.find(wanted) + 1 :], *ascii_uppercase]
        unusual = [character for character in after if character not in self.usual]
        one = next(c for c in (wanted, *unusual, *after) if c not in self.taken)
        self.taken.add(one)
        return one


def _tool_binding(character: str, usual: str, tool: PlacedTool) -> str:
    kind = f"{tool.kind} {tool.reading.words}".rstrip()
    if character == usual and kind == tool.kind and not tool.slip:
        return binding(character, kind)
    return _bound(character, f"{kind} slip {_exactly(tool.slip)}" if tool.slip else kind)


def _exactly(slip: float) -> str:
    """In as few digits as say it: 1, not 1.0."""
    return f"{slip:g}" if float(f"{slip:g}") == slip else repr(float(slip))


def _bound(character: str, what: str) -> str:
    return f"{character} {BINDS} {what}"
