"""The things of a map, checked: each on a free cell of its own, with what its map must have."""

from typing import TYPE_CHECKING

from habilis.worlds.things import OBJECTS

if TYPE_CHECKING:
    from habilis.worlds.world import World


def check_things(world: "World") -> None:
    """Refuses things that are not on free cells, or on each other.

    Raises:
        ValueError: names the thing and its cell.
    """
    if world.second is not None:
        _check_for_two(world)
    elif not world.objects or world.objects[0].goal is None:
        first = f"the first object, the {world.objects[0].name}," if world.objects else "it"
        has = "has no goal; give it one" if world.objects else "has no object; give it one"
        raise ValueError(f"{world.name}: {first} {has}")
    elif world.doors:
        raise ValueError(f"{world.name}: doors are for two agents; bind a second, as 'E = agent'")
    tools = [("tool" if world.single else tool.name, tool.cell) for tool in world.tools]
    objects = [(thing.name, thing.cell) for thing in world.objects]
    placed = [("agent", world.agent), *objects[:1], *tools, *objects[1:]]
    if world.second is not None:
        placed.append(("second agent", world.second))
    goals = [
        (f"goal of {thing.name}" if number else "goal", thing.goal)
        for number, thing in enumerate(world.objects)
    ]
    doors = [("door", door.cell) for door in world.doors]
    for name, cell in [*placed, *goals, *doors]:
        if cell is not None and not world.is_free(cell):
            raise ValueError(
                f"{world.name}: the {name} is at {cell}; put it on a free cell of the "
                f"{world.height} x {world.width} map"
            )
    if len({cell for _, cell in placed}) < len(placed):
        raise ValueError(f"{world.name}: {dict(placed)} share a cell; give each its own")
    for things in (world.tools, world.objects):
        names = [thing.name for thing in things]
        if len(set(names)) < len(names):
            raise ValueError(
                f"{world.name}: two of {', '.join(names)} have one name; give each its own"
            )
    _check_doors(world, dict(placed))


def _check_for_two(world: "World") -> None:
    """Refuses what maps with two agents do not have."""
    if world.tools or world.drop or world.vacancy is not None:
        raise ValueError(
            f"{world.name}: a map with two agents has no tools; leave them out, or the second agent"
        )
    for thing in world.objects:
        if OBJECTS[thing.kind].slides:
            raise ValueError(
                f"{world.name}: on a map with two agents nothing slides, as the {thing.name} does; "
                "use a can or a crate"
            )


def _check_doors(world: "World", placed: dict[str, tuple[int, int]]) -> None:
    cells = [door.cell for door in world.doors]
    if len(set(cells)) < len(cells):
        raise ValueError(f"{world.name}: two doors share a cell; give each its own")
    for door in world.doors:
        there = next((name for name, cell in placed.items() if cell == door.cell), None)
        if there is not None and not door.is_open:
            raise ValueError(
                f"{world.name}: the {there} is in the closed door at {door.cell}; open that, or "
                "put it elsewhere"
            )


def check_one_agent(world: "World") -> None:
    """Refuses maps with two agents, for what has one agent only.

    Raises:
        ValueError: says what takes them.
    """
    if world.second is not None:
        raise ValueError(
            f"{world.name}: the map has two agents, and this is for one; give a map with one "
            "(tabulate, explore, solve, empowerment and landscape take two)"
        )
