"""Maps at random, and small changes to a map."""

from dataclasses import replace
from random import Random

from habilis.studies.paper.targets import TargetMap
from habilis.studies.reconstruction.shapes import neighbours, one_room, walls_alone
from habilis.worlds.grid import STEPS
from habilis.worlds.things import CAN, PlacedObject, PlacedTool
from habilis.worlds.world import NO_TOOL, Cell, World

_LONGEST = 7  # run of walls that is drawn at once
_TRIES = 10_000


def random_map(targets: TargetMap, random: Random) -> World:
    """Straight runs of walls, and things on free cells: what a search begins with.

    Raises:
        ValueError: there seems to be no such map of one room.
    """
    height, width = targets.height, targets.width
    for _ in range(_TRIES):
        walls: set[Cell] = set()
        while len(walls) < targets.walls:
            row, column = random.randrange(height), random.randrange(width)
            down, right = random.choice(((0, 1), (1, 0)))
            run = ((row + k * down, column + k * right) for k in range(random.randint(2, _LONGEST)))
            walls |= {(r, c) for r, c in run if r < height and c < width}
        free = [(r, c) for r in range(height) for c in range(width) if (r, c) not in walls]
        if len(free) < 4:
            continue
        agent, thing, goal, tool = random.sample(free, 4)
        world = World(
            name=targets.name,
            height=height,
            width=width,
            walls=frozenset(walls),
            agent=agent,
            objects=(PlacedObject(CAN, thing, goal),),
            tools=() if targets.tool == NO_TOOL else (PlacedTool(targets.tool, tool),),
        )
        if not walls_alone(world) and one_room(world):
            return world
    raise ValueError(
        f"{targets.name}: no map of {height} x {width} cells has {targets.walls} walls that leave "
        "one room; give fewer walls"
    )


def neighbour(world: World, random: Random) -> World:
    """A map that differs a little: in a wall, a run of walls, or where things are.

    It is one room, and has no more walls that stand alone.
    """
    alone = walls_alone(world)
    while True:
        change = random.choices(_CHANGES, _WEIGHTS)[0]
        changed = change(world, random)
        if changed is None or changed == world:
            continue
        if walls_alone(changed) <= alone and one_room(changed):
            return changed


def _grow(world: World, random: Random) -> World | None:
    """A wall more, at the side of another where there is one."""
    taken = set(_things(world).values())
    cells = [cell for cell in world.free_cells if cell not in taken]
    beside = [cell for cell in cells if world.walls.intersection(neighbours(cell))]
    if not cells:
        return None
    added = {random.choice(beside)} if beside else set(_pair(random.choice(cells), cells, random))
    return replace(world, walls=world.walls | added)


def _pair(cell: Cell, cells: list[Cell], random: Random) -> tuple[Cell, ...]:
    beside = [other for other in neighbours(cell) if other in cells]
    return (cell, random.choice(beside)) if beside else (cell,)


def _shrink(world: World, random: Random) -> World | None:
    """A wall less; the last two of a run go together."""
    if not world.walls:
        return None
    wall = random.choice(sorted(world.walls))
    walls = world.walls - {wall}
    alone = [w for w in neighbours(wall) if w in walls and not walls.intersection(neighbours(w))]
    return replace(world, walls=walls.difference(alone))


def _shift(world: World, random: Random) -> World | None:
    """A wall elsewhere."""
    less = _shrink(world, random)
    return None if less is None else _grow(less, random)


def _slide(world: World, random: Random) -> World | None:
    """A whole straight run of walls, one cell along or aside."""
    if not world.walls:
        return None
    (row, column), (down, right) = random.choice(sorted(world.walls)), random.choice(STEPS[1:3])
    run = {(row, column)}
    for sign in (1, -1):
        cell = (row + sign * down, column + sign * right)
        while cell in world.walls:
            run.add(cell)
            cell = (cell[0] + sign * down, cell[1] + sign * right)
    step = random.choice(STEPS)
    moved = {(r + step[0], c + step[1]) for r, c in run}
    if not all(_inside(world, cell) for cell in moved) or moved & set(_things(world).values()):
        return None
    return replace(world, walls=(world.walls - run) | moved)


def _move(world: World, random: Random) -> World | None:
    """One or two things, one cell on or anywhere."""
    things = _things(world)
    names = random.sample(sorted(things), random.choice((1, 1, 2)))
    step = random.choice(STEPS) if random.random() < 0.6 else None
    free = world.free_cells
    for name in names:
        row, column = things[name]
        things[name] = random.choice(free) if step is None else (row + step[0], column + step[1])
    return _with_things(world, things)


def _swap(world: World, random: Random) -> World | None:
    """Two things in each other's place."""
    things = _things(world)
    one, other = random.sample(sorted(things), 2)
    things[one], things[other] = things[other], things[one]
    return _with_things(world, things)


def _things(world: World) -> dict[str, Cell]:
    things = {"agent": world.agent, "object": world.object, "goal": world.goal}
    return things | ({"tool": world.tools[0].cell} if world.tools else {})


def _with_things(world: World, things: dict[str, Cell]) -> World | None:
    cells = set(things.values())
    if len(cells) < len(things) or cells & world.walls:
        return None
    if not all(_inside(world, cell) for cell in cells):
        return None
    return world.with_cells(
        agent=things["agent"],
        object=things["object"],
        goal=things["goal"],
        tool=things.get("tool"),
    )


def _inside(world: World, cell: Cell) -> bool:
    return 0 <= cell[0] < world.height and 0 <= cell[1] < world.width


_CHANGES = (_grow, _shrink, _shift, _slide, _move, _swap)
_WEIGHTS = (3, 3, 4, 2, 7, 1)
