"""The things of a map somewhere else."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from habilis.worlds.things import PlacedObject, PlacedTool
from habilis.worlds.world import Cell, World

Where = Cell | Mapping[str, Cell]
"""The cell of the only tool or object, or cells by names."""


def elsewhere(
    world: World,
    *,
    agent: Cell | None = None,
    tool: Where | None = None,
    object: Where | None = None,
) -> World:
    r"""The same map with some of its things in other cells.

    Args:
        world: the map.
        agent: its cell; `None` leaves it where it is, or, if something else comes there, puts it
            on the first cell that is free.
        tool, object: a cell where there is one of them, or cells by names.

    Returns:
        Another world.

    Raises:
        ValueError: no such tool or object, it is not said which, or a cell that is not free.

    Example:
        >>> elsewhere(World.parse("R = rake\nA.PRCG"), tool={"rake": (0, 1)}).tools[1].cell
        (0, 1)
    """
    tools = _cells(world, "tool", world.tools, tool)
    objects = _cells(world, "object", world.objects, object)
    taken = {*tools, *objects}
    if agent is None:
        agent = world.agent
        if agent in taken:
            agent = next((cell for cell in free_cells(world) if cell not in taken), agent)
    return put(world, agent, tools, objects)


def put(
    world: World,
    agent: Cell,
    tools: Sequence[Cell],
    objects: Sequence[Cell],
    held: int | None = None,
) -> World:
    """The same map with everything in these cells.

    Args:
        world: the map.
        agent: its cell.
        tools, objects: their cells, in the order of `world.tools` and `world.objects`.
        held: which tool is in hand; `None` for the first beside the agent.

    Raises:
        ValueError: a cell that is not free.
    """
    first = len(world.tools) - len(world.more_tools)
    return replace(
        world,
        agent=agent,
        tool_cell=tools[0] if first else world.tool_cell,
        more_tools=tuple(
            replace(one, cell=at) for one, at in zip(world.more_tools, tools[first:], strict=True)
        ),
        object=objects[0],
        more_objects=tuple(
            replace(one, cell=at) for one, at in zip(world.more_objects, objects[1:], strict=True)
        ),
        held=held,
    )


def agent_cells(world: World) -> list[Cell]:
    """The cells in which the agent can be, everything else as on the map, row by row."""
    taken = {thing.cell for thing in (*world.tools, *world.objects)}
    return [cell for cell in free_cells(world) if cell not in taken]


def free_cells(world: World) -> list[Cell]:
    """The cells that are no walls, row by row."""
    cells = ((row, column) for row in range(world.height) for column in range(world.width))
    return [cell for cell in cells if cell not in world.walls]


def _cells(
    world: World,
    kind: str,
    things: Sequence[PlacedTool] | Sequence[PlacedObject],
    where: Where | None,
) -> list[Cell]:
    """Where all tools, or all objects, are."""
    names = [thing.name for thing in things]
    if where is None:
        where = {}
    elif not isinstance(where, Mapping):
        if not names:
            raise ValueError(f"{world.name} has no {kind} here; leave out its cell")
        if len(names) > 1:
            at = ",".join(map(str, where))
            raise ValueError(
                f"{world.name} has several {kind}s, {', '.join(names)}; say which is at {where}, "
                f"as {names[0]}={at}"
            )
        where = {names[0]: where}
    for name in where:
        if name not in names:
            known = f"name one of {', '.join(names)}" if names else "it has none"
            raise ValueError(f"{world.name} has no {kind} {name!r}; {known}")
    return [where.get(thing.name, thing.cell) for thing in things]
