"""Worlds in the page's format: walls as text, and a list of things."""

from collections.abc import Collection

from habilis.studio.placements import Order
from habilis.studio.protocol.scenes import Drawn
from habilis.studio.protocol.scenes import PlacedObject as DrawnObject
from habilis.studio.protocol.scenes import PlacedTool as DrawnTool
from habilis.worlds.map_text import FLOOR, WALL
from habilis.worlds.things import OBJECTS, PlacedObject, PlacedTool
from habilis.worlds.world import World
from habilis.worlds.world_checks import check_one_agent

_GROUND = f"; {FLOOR} floor and {WALL} walls"


def drawn_of(world: World) -> Drawn:
    """A world in the page's format.

    Raises:
        ValueError: a tool has another reading of the rules, which the page cannot represent.
    """
    check_one_agent(world)
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
    return Drawn(
        ground="\n".join(rows),
        agent=world.agent,
        tools=[DrawnTool(tool.kind, tool.cell, tool.slip) for tool in world.tools],
        objects=[DrawnObject(thing.kind, thing.cell, thing.goal) for thing in world.objects],
        drop=world.drop,
    )


def world_of(drawn: Drawn, kinds: Collection[str], name: str) -> World:
    """A world from the page's format, equal to the one from its map's text.

    Args:
        drawn: as returned by `drawn_of`, with things in any order.
        kinds: the known tools.
        name: the world's name in errors.

    Raises:
        ValueError: the drawing is not a valid world; the message says why.
    """
    rows = drawn.ground.split("\n")
    if len({len(row) for row in rows}) != 1 or set("".join(rows)) - {FLOOR, WALL}:
        raise ValueError(f"ground is not a map; give rows of equal length{_GROUND}")
    for tool in drawn.tools:
        check_known("tool", tool.kind, kinds)
    for thing in drawn.objects:
        check_known("object", thing.kind, OBJECTS)
    tools, objects = _as_read(drawn)
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
        agent=drawn.agent,
        objects=tuple(
            PlacedObject(thing.kind, thing.cell, thing.goal)
            for thing in (drawn.objects[k] for k in objects)
        ),
        tools=tuple(
            PlacedTool(kind=tool.kind, cell=tool.cell, slip=tool.slip)
            for tool in (drawn.tools[k] for k in tools)
        ),
        drop=drawn.drop and bool(tools),
    )


def order_of(drawn: Drawn) -> Order:
    """The order in which a drawing lists the things of its world."""
    tools, objects = _as_read(drawn)
    return Order(
        tuple(tools.index(k) for k in range(len(tools))),
        tuple(objects.index(k) for k in range(len(objects))),
    )


def _as_read(drawn: Drawn) -> tuple[list[int], list[int]]:
    """The indices of tools and objects in the order of the world: as a map is read, goals first."""
    tools = sorted(range(len(drawn.tools)), key=lambda k: drawn.tools[k].cell)
    objects = sorted(
        range(len(drawn.objects)),
        key=lambda k: (drawn.objects[k].goal is None, drawn.objects[k].cell),
    )
    return tools, objects


def check_known(what: str, name: str, known: Collection[str]) -> None:
    """Refuses a name that is not one of those known.

    Raises:
        ValueError: naming them.
    """
    if name not in known:
        raise ValueError(f"{what} {name!r:.60} is unknown; use one of {', '.join(known)}")
