"""From the things of a world to its map's text."""

from dataclasses import dataclass
from string import ascii_uppercase
from typing import TYPE_CHECKING

from habilis.worlds.characters import AGENT, BINDS, FLOOR, GOAL, OBJECT, TOOL, WALL
from habilis.worlds.map_text import DROP
from habilis.worlds.things import CAN, Cell, PlacedTool
from habilis.worlds.tools import UNBOUND

if TYPE_CHECKING:
    from habilis.worlds.world import World


@dataclass(frozen=True)
class Mark:
    """A character on a map.

    Attributes:
        character: drawn.
        cell: where.
        role: `AGENT`, `OBJECT`, `GOAL` or `TOOL`.
        binding: the line above the map that says what it stands for; "" if none must.
    """

    character: str
    cell: Cell
    role: str
    binding: str = ""


def marks_of(world: "World") -> list[Mark]:
    """All that stands on a map besides walls, the goals first: what is on them hides them."""
    free = _Characters({WALL, FLOOR, AGENT})
    goals, objects = [], []
    for place, thing in enumerate(world.objects):
        character = free.take(OBJECT if place == 0 or thing.kind == CAN else thing.kind[0].upper())
        usual = character == OBJECT and thing.kind == CAN
        binds = "" if usual else _bound(character, thing.kind)
        objects.append(Mark(character, thing.cell, OBJECT, binds))
        if thing.goal is not None:
            goal = free.take(GOAL)
            of = _bound(goal, f"goal of {character}") if world.more_objects else ""
            goals.append(Mark(goal, thing.goal, GOAL, of))
    tools = []
    for tool, rule in zip(world.tools, world.rules, strict=True):
        character = free.take(rule.character)
        binds = _tool_binding(character, rule.character, tool)
        tools.append(Mark(character, tool.cell, TOOL, binds))
    return [*goals, *objects, Mark(AGENT, world.agent, AGENT), *tools]


def header_of(world: "World") -> list[str]:
    """The lines above the map."""
    bound = [mark.binding for mark in marks_of(world) if mark.binding]
    return [*bound, *([f"{DROP}: true"] if world.drop else [])]


def binding(character: str, kind: str) -> str:
    """The line that says which tool a character stands for; "" where none is needed."""
    return "" if kind in UNBOUND else _bound(character, kind)


class _Characters:
    """Characters that are still free."""

    def __init__(self, taken: set[str]):
        self.taken = taken

    def take(self, wanted: str) -> str:
        """The one that is wanted, or another."""
        one = next(c for c in (wanted, *ascii_uppercase) if c not in self.taken)
        self.taken.add(one)
        return one


def _tool_binding(character: str, usual: str, tool: PlacedTool) -> str:
    if character == usual and not tool.slip:
        return binding(character, tool.kind)
    return _bound(character, f"{tool.kind} slip {tool.slip:g}" if tool.slip else tool.kind)


def _bound(character: str, what: str) -> str:
    return f"{character} {BINDS} {what}"
