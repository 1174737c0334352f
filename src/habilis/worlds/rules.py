"""The rule that moves things, written once, over arrays of placements."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool

from habilis.worlds.answers import NEAR, answers
from habilis.worlds.tools import Cells, Tool
from habilis.worlds.world import Cell, World

MOVES = ("north", "east", "south", "west")
ACTIONS = (*MOVES, *(f"tool {side}" for side in MOVES))
"""Names of the actions in their order: 0 to 3 move the agent, 4 to 7 put the tool on a side."""

BORDER = NEAR
"""Cells around the map, and how far at most from agent, tool or its own cell an object lands: so
that no tool, whatever it does, gets past the border, or round it to the other side."""


@dataclass(frozen=True)
class Grid:
    """The map as a flat array of cells inside a border of walls.

    With the border, a neighbour is one addition away and leaving the map is running into a
    wall. Past the map lies one free cell, `nowhere`, adjacent to none: the place of a tool
    that a world does not have.
    """

    wall: Bool[np.ndarray, "cells"]
    width: int
    stride: int
    nowhere: int

    @classmethod
    def of(cls, world: World) -> "Grid":
        stride = world.width + 2 * BORDER
        wall = np.ones((world.height + 2 * BORDER, stride), bool)
        for row in range(world.height):
            for column in range(world.width):
                wall[row + BORDER, column + BORDER] = (row, column) in world.walls
        nowhere = wall.size + stride
        flat = np.append(wall.ravel(), np.ones(2 * stride, bool))
        flat[nowhere] = False
        return cls(flat, world.width, stride, nowhere)

    @property
    def steps(self) -> tuple[int, int, int, int]:
        """What to add to a cell to get its neighbour to the north, east, south and west."""
        return -self.stride, 1, self.stride, -1

    @property
    def free(self) -> Cells:
        """The cells of the map that are not walls, row by row."""
        return np.flatnonzero(~self.wall[: self.nowhere])

    def index(self, cell: Cell) -> int:
        return (cell[0] + BORDER) * self.stride + cell[1] + BORDER

    def cell(self, index: int) -> Cell:
        """The cell that has an index."""
        row, column = divmod(int(index), self.stride)
        return row - BORDER, column - BORDER

    def label(self, cells: Cells) -> Cells:
        """`row * width + column` on the map; -1 for `nowhere`."""
        row, column = np.divmod(cells, self.stride)
        label = (row - BORDER) * self.width + column - BORDER
        return np.where(cells == self.nowhere, -1, label)

    def adjacent(self, a: Cells, b: Cells):
        """Manhattan distance 1. Walls part the rows, so flat neighbours are neighbours."""
        distance = np.abs(a - b)
        return (distance == 1) | (distance == self.stride)


def successor(
    grid: Grid, rule: Tool | None, action: int, agent: Cells, tool: Cells, thing: Cells
) -> tuple[Cells, Cells, Cells]:
    """Where agent, tool and object are after one action: rules 1 to 5 of the worlds.

    Args:
        grid: the map.
        rule: how the tool moves the object; `None` in a world without a tool.
        action: 0 to 3 move the agent north, east, south, west; 4 to 7 put the tool there.
        agent, tool, thing: their cells, one placement an entry.

    Returns:
        The cells of agent, tool and object; unchanged wherever one of them would have come
        onto a wall or onto another.

    Raises:
        ValueError: the tool does not answer as a tool must.
    """
    step = grid.steps[action % 4]
    equipped = grid.adjacent(agent, tool)
    if action < 4:
        new_agent = agent + step
        new_tool = np.where(equipped, tool + step, tool)
        new_thing = thing
        if rule is not None:
            new_thing = answers(
                grid, rule, "carry", (agent, tool, thing), step, where=equipped, elsewhere=thing
            )
        new_thing = np.where(new_agent == thing, thing + step, new_thing)
    else:
        new_agent, new_tool, new_thing = agent, np.where(equipped, agent + step, tool), thing
        if rule is not None:
            new_thing = answers(
                grid, rule, "swing", (agent, tool, thing), step, where=equipped, elsewhere=thing
            )
    stays = grid.wall[new_agent] | grid.wall[new_tool] | grid.wall[new_thing]
    stays |= (new_agent == new_tool) | (new_agent == new_thing) | (new_tool == new_thing)
    return (
        np.where(stays, agent, new_agent),
        np.where(stays, tool, new_tool),
        np.where(stays, thing, new_thing),
    )
