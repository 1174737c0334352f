"""From the things of a world to its map's text."""

from dataclasses import dataclass
from string import ascii_uppercase
from typing import TYPE_CHECKING

from habilis.worlds.characters import AGENT, BINDS, FLOOR, GOAL, OBJECT, TOOL, WALL
from habilis.worlds.map_text import DROP
from habilis.worlds.things import CAN, OBJECTS, Cell, PlacedTool
from habilis.worlds.tools import TOOLS, UNBOUND

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
    alone = len(world.objects) == 1
    usual_ones = [OBJECT if alone else OBJECTS[thing.kind].character for thing in world.objects]
    known = (rule.character for rule in (*world.rules, *TOOLS.values()))
    free = _Characters({WALL, FLOOR, AGENT}, {OBJECT, GOAL, *usual_ones, *known})
    goals, objects = [], []
    for thing, wanted in zip(world.objects, usual_ones, strict=True):
        character = free.take(wanted)
        usual = character == OBJECT and thing.kind == CAN
        binds = "" if usual else _bound(character, thing.kind)
        objects.append(Mark(character, thing.cell, OBJECT, binds))
        if thing.goal is not None:
            goal = free.take(GOAL)
            of = _bound(goal, f"goal of {character}") if not alone else ""
            goals.append(Mark(goal, thing.goal, GOAL, of))
    tools = []
    for tool, rule in zip(world.tools, world.rules, strict=True):
        character = free.take(rule.character)
        binds = _tool_binding(character, rule.character, tool)
        tools.append(Mark(character, tool.cell, TOOL, binds))
    return [*goals, *objects, Mark(AGENT, world.agent, AGENT), *tools]


def header_of(world: "World") -> list[str]:
    """The lines above the map: tools, objects, then the goals of these."""
    bound = [
        mark.binding
        for role in (TOOL, OBJECT, GOAL)
        for mark in marks_of(world)
        if mark.role == role and mark.binding
    ]
    return [*bound, *([f"{DROP}: true"] if world.drop else [])]


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
