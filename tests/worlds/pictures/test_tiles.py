"""A picture laid of tiles is the picture that is drawn, to the pixel."""

from itertools import permutations

import numpy as np
import pytest

from habilis.worlds.pictures.figures import frame
from habilis.worlds.pictures.tiles import Tiles
from habilis.worlds.world import Cell, World, load_world

SMALL = World.parse("A#P.\n.C.G\n..#.\n", name="small")
WORLDS = [
    *(load_world(name) for name in ("corridor", "yard")),
    load_world("yard", tool="broom"),
    load_world("corridor", tool="none"),
    World.parse("######\n#A.C.#\n#..G.#\n######", name="walled"),
]


def free_cells(world: World) -> list[Cell]:
    cells = np.ndindex(world.height, world.width)
    return [(row, column) for row, column in cells if (row, column) not in world.walls]


def placements(world: World, count: int) -> list[World]:
    """The world's things elsewhere: anywhere, in hand on any side, and each on the goal."""
    random = np.random.default_rng(0)
    cells = free_cells(world)
    found = []
    while len(found) < count:
        agent, tool, thing = (cells[n] for n in random.choice(len(cells), 3, replace=False))
        goal_takes = len(found) % 8
        if goal_takes == 1:
            agent = world.goal
        elif goal_takes == 2:
            tool = world.goal
        elif goal_takes == 3:
            thing = world.goal
        if goal_takes % 2:
            near = [
                cell for cell in cells if abs(cell[0] - agent[0]) + abs(cell[1] - agent[1]) == 1
            ]
            tool = near[random.integers(len(near))]
        if len({agent, tool, thing}) == 3:
            found.append(put(world, agent, tool, thing))
    return found


def put(world: World, agent: Cell, tool: Cell, thing: Cell) -> World:
    """The state with everything in these cells; that of the tool where there is one."""
    return world.with_cells(agent=agent, tool=tool if world.tools else None, object=thing)


def labels(world: World) -> tuple[int, int, int]:
    """Agent, tool and object, as a table's factors have them; -1 for no tool."""
    agent, tool, thing = (
        -1 if cell is None else cell[0] * world.width + cell[1]
        for cell in (world.agent, world.tool_cell, world.object)
    )
    return agent, -1 if world.tool == "none" else tool, thing


@pytest.mark.parametrize("size", [8, 16, 32])
@pytest.mark.parametrize("world", WORLDS, ids=lambda world: f"{world.name}-{world.tool}")
def test_laid_pictures_are_the_drawn_ones(world: World, size: int):
    tiles = Tiles.of(world, size)
    states = placements(world, 24)
    for state, picture in zip(
        states, tiles.frames(*np.transpose([labels(state) for state in states])), strict=True
    ):
        drawn = frame(state, size)
        np.testing.assert_array_equal(picture, drawn)
        np.testing.assert_array_equal(tiles.frame(*labels(state)), drawn)


@pytest.mark.parametrize("size", [7, 33])
@pytest.mark.parametrize("tool", ["picker", "broom"])
def test_every_placement_of_a_small_map_is_as_drawn(tool: str, size: int):
    small = SMALL.with_tool(tool)
    tiles = Tiles.of(small, size)
    cells = free_cells(small)[::2] if size > 7 else free_cells(small)[-6:]
    for agent, place, thing in permutations(cells, 3):
        state = put(small, agent, place, thing)
        np.testing.assert_array_equal(tiles.frame(*labels(state)), frame(state, size))


def test_a_world_without_a_tool_needs_no_word_of_it():
    bare = SMALL.with_tool("none")
    tiles = Tiles.of(bare, 16)
    assert tiles.tool is None
    agent, _, thing = labels(bare)
    for tool in (None, -1, 2):
        np.testing.assert_array_equal(tiles.frame(agent, tool, thing), frame(bare, 16))


def test_a_tools_look_does_not_run_around_the_edge_of_the_map():
    world = World.parse("..A\nP..\nC.G", name="edge")
    tiles = Tiles.of(world, 16)
    np.testing.assert_array_equal(tiles.frame(*labels(world)), frame(world, 16))
