"""Cells, the four directions, and a map as a flat array of cells."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Bool, Integer

Cell = tuple[int, int]
"""(row, column), row 0 at the top."""
Cells = Integer[np.ndarray, "*states"]
Flags = Bool[np.ndarray, "*states"]

MOVES = ("north", "east", "south", "west")
STEPS: tuple[Cell, ...] = ((-1, 0), (0, 1), (1, 0), (0, -1))
"""One cell to the north, east, south and west, as (rows, columns)."""

BORDER = 2
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
    def of(cls, height: int, width: int, walls: Collection[Cell] = ()) -> "Grid":
        stride = width + 2 * BORDER
        wall = np.ones((height + 2 * BORDER, stride), bool)
        wall[BORDER : BORDER + height, BORDER : BORDER + width] = False
        row, column = np.array(list(walls), np.intp).reshape(-1, 2).T
        wall[row + BORDER, column + BORDER] = True
        nowhere = wall.size + stride
        flat = np.append(wall.ravel(), np.ones(2 * stride, bool))
        flat[nowhere] = False
        return cls(flat, width, stride, nowhere)

    @property
    def steps(self) -> tuple[int, int, int, int]:
        """The distances to a cell's neighbour to the north, east, south and west."""
        return -self.stride, 1, self.stride, -1

    @property
    def free(self) -> Cells:
        """The cells of the map that are not walls, row by row."""
        return np.flatnonzero(~self.wall[: self.nowhere])

    def index(self, cell: Any) -> Any:
        """The index of a cell (row, column), or of each of int[2, n]."""
        return (cell[0] + BORDER) * self.stride + cell[1] + BORDER

    def cell(self, index: int | np.integer) -> Cell:
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
