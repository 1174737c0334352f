"""Worlds in the page's format: walls as text, and a list of things."""

from collections.abc import Collection
from typing import Any

from habilis.studio.fields import cell, checked, number, one_of, shown
from habilis.studio.limits import THINGS, TOOL_SLIP
from habilis.worlds.map_text import FLOOR, WALL
from habilis.worlds.things import OBJECTS, PlacedObject, PlacedTool
from habilis.worlds.world import World

_GROUND = f"; {FLOOR} floor and {WALL} walls"


def drawn_of(world: World) -> dict[str, Any]:
    """A world in the page's format.

    Raises:
        ValueError: a tool has another reading of the rules, which the page cannot represent.
    """
    for tool in world.tools:
        if tool.reading.words:
            raise ValueError(
                f"{world.name}: the page cannot represent the reading {tool.reading.words!r} of "
                "rules 3 to 5; remove it from the line above the map"
            )
    rows = [
        "".join(WALL if (row, column) in world.walls else FLOOR for column in range(world.width))
        for row in range(world.height)
    ]
    return {
        "ground": "\n".join(rows),
        "agent": list(world.agent),
        "tools": [
            {"kind": tool.kind, "cell": list(tool.cell), "slip": tool.slip} for tool in world.tools
        ],
        "objects": [
            {
                "kind": thing.kind,
                "cell": list(thing.cell),
                "goal": None if thing.goal is None else list(thing.goal),
            }
            for thing in world.objects
        ],
        "drop": world.drop,
    }


def world_of(value: Any, kinds: Collection[str], name: str) -> World:
    """A world from the page's format, equal to the one from its map's text.

    Args:
        value: as returned by `drawn_of`.
        kinds: the known tools.
        name: the world's name in errors.

    Raises:
        ValueError: the value is not a valid world; the message says why.
    """
    given = checked("drawn", value, ("ground", "agent", "tools", "objects", "drop"))
    rows = given["ground"].split("\n") if isinstance(given["ground"], str) else []
    if len({len(row) for row in rows}) != 1 or set("".join(rows)) - {FLOOR, WALL}:
        raise ValueError(f"ground is not a map; give rows of equal length{_GROUND}")
    if not isinstance(given["drop"], bool):
        raise ValueError(f"drop is {shown(given['drop'])}; give true or false")
    tools = [_tool(one, kinds) for one in _few("tools", given["tools"], 0)]
    objects = [_object(one) for one in _few("objects", given["objects"], 1)]
    tools.sort(key=lambda tool: tool["cell"])  # as a map is read
    objects.sort(key=lambda thing: (thing["goal"] is None, thing["cell"]))
    return World(
        name=name,
        height=len(rows),
        width=len(rows[0]),
        walls=frozenset(
            (row, column)
            for row, line in enumerate(rows)
            for column, mark in enumerate(line)
            if mark == WALL
        ),
        agent=cell("agent", given["agent"]),
        objects=tuple(PlacedObject(**thing) for thing in objects),
        tools=tuple(PlacedTool(**tool) for tool in tools),
        drop=given["drop"] and bool(tools),
    )


def _few(name: str, value: Any, least: int) -> list[Any]:
    if not isinstance(value, list) or not least <= len(value) <= THINGS:
        raise ValueError(f"{name} is not a list of {least} to {THINGS} things; give one")
    return value


def _tool(value: Any, kinds: Collection[str]) -> dict[str, Any]:
    given = checked("a tool", value, ("kind", "cell"), ("slip",))
    return {
        "kind": one_of("tool", given["kind"], list(kinds)),
        "cell": cell("a tool", given["cell"]),
        "slip": float(number("a tool's slip", given.get("slip", 0.0), 0, TOOL_SLIP)),
    }


def _object(value: Any) -> dict[str, Any]:
    given = checked("an object", value, ("kind", "cell"), ("goal",))
    goal = given.get("goal")
    return {
        "kind": one_of("object", given["kind"], list(OBJECTS)),
        "cell": cell("an object", given["cell"]),
        "goal": None if goal is None else cell("a goal", goal),
    }
