"""Three tools and two objects: the table of all that can be reached, beside a plain search."""

from habilis.benchmarks import Result, times
from habilis.worlds.grid import STEPS
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World

ROOM = """
R = rake
M = magnet
D = can
G = goal of C
H = goal of D
A....
..C.P
.R..D
....#
HM..G
"""
Placement = tuple[Cell, tuple[Cell, ...], tuple[Cell, ...], int]
"""The agent's cell, those of tools and of objects, and which tool is in hand, -1 for none."""


def results() -> list[Result]:
    world = World.parse(ROOM, "room")
    mdp = tabulate(world)
    assert len(plain_search(world)) == mdp.states
    seconds = times({"ours": lambda: tabulate(world), "plain": lambda: plain_search(world)})
    ours, plain = seconds["ours"], seconds["plain"]
    of = f"3 tools and 2 objects, 5x5, {mdp.states:,} placements"
    return [
        Result.of("tabulate, several things", mdp.states / ours / 1e6, "M states/s", of),
        Result.of(
            "tabulate, several things: plain search / ours",
            plain / ours,
            "times",
            f"breadth first in plain Python, a dictionary of placements; {of}",
        ),
    ]


def plain_search(world: World) -> dict[Placement, list[Placement]]:
    """Where each action leads from all placements that can be reached, one at a time.

    Of pickers, rakes, magnets and cans, without putting down.
    """
    kinds = [tool.kind for tool in world.tools]
    tools, objects = (tuple(one.cell for one in many) for many in (world.tools, world.objects))
    start = _taken((world.agent, tools, objects, -1))
    leads: dict[Placement, list[Placement]] = {start: []}
    frontier = [start]
    while frontier:
        reached = []
        for at in frontier:
            leads[at] = [_taken(_moved(world, kinds, at, action)) for action in range(8)]
            for to in leads[at]:
                if to not in leads:
                    leads[to] = []
                    reached.append(to)
        frontier = reached
    return leads


def _taken(at: Placement) -> Placement:
    agent, tools, objects, held = at
    if held < 0:
        for one, tool in enumerate(tools):
            if abs(tool[0] - agent[0]) + abs(tool[1] - agent[1]) == 1:
                return agent, tools, objects, one
    return at


def _moved(world: World, kinds: list[str], at: Placement, action: int) -> Placement:
    agent, tools, objects, held = at
    way, carried = STEPS[action % 4], action < 4
    step = _plus(agent, way)
    new_agent = step if carried else agent
    new_tools = list(tools)
    if held >= 0:
        new_tools[held] = _plus(tools[held], way) if carried else step
    new_objects = []
    for thing in objects:
        new = thing
        if held >= 0:
            tool = tools[held]
            in_line = thing == (2 * tool[0] - agent[0], 2 * tool[1] - agent[1])
            if kinds[held] == "picker" and in_line:
                new = _plus(thing, way) if carried else _plus(step, way)
            elif kinds[held] == "rake" and in_line and carried and _plus(tool, way) == agent:
                new = tool
            elif kinds[held] == "magnet" and not carried:
                others = {*objects, *tools[:held], *tools[held + 1 :]}
                new = _drawn(world, step, way, thing, others)
        new_objects.append(_plus(thing, way) if carried and step == thing else new)
    cells = [new_agent, *new_tools, *new_objects]
    if len(set(cells)) < len(cells) or not all(_is_floor(world, cell) for cell in cells):
        return at
    return new_agent, tuple(new_tools), tuple(new_objects), held


def _drawn(world: World, magnet: Cell, way: Cell, thing: Cell, others: set[Cell]) -> Cell:
    before, seen = magnet, _plus(magnet, way)
    while _is_floor(world, seen) and seen not in others:
        before, seen = seen, _plus(seen, way)
    return before if seen == thing and before != magnet else thing


def _plus(one: Cell, other: Cell) -> Cell:
    return one[0] + other[0], one[1] + other[1]


def _is_floor(world: World, cell: Cell) -> bool:
    inside = 0 <= cell[0] < world.height and 0 <= cell[1] < world.width
    return inside and cell not in world.walls
