"""Rigid bodies on a map, and tables of what they would run into."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int64

from habilis.worlds.grid import Cell

ACTIONS = ("left", "right", "up", "down")
STEPS: tuple[Cell, ...] = ((0, -1), (0, 1), (-1, 0), (1, 0))
"""What each action adds to row and column."""


@dataclass(frozen=True)
class Body:
    """A rigid body of any shape, which need not be connected.

    Attributes:
        name: "agent", "m0", "b0", ...
        corner: the cell of the upper left corner of its bounding box, which it may not cover.
        cells: the cells that it covers, counted from there, row by row.
    """

    name: str
    corner: Cell
    cells: tuple[Cell, ...]

    @classmethod
    def covering(cls, name: str, cells: Iterable[Cell]) -> "Body":
        """The body that covers some cells of the map."""
        covered = sorted(cells)
        top, left = min(row for row, _ in covered), min(column for _, column in covered)
        return cls(name, (top, left), tuple((row - top, column - left) for row, column in covered))

    def covered(self, corner: Cell | None = None) -> list[Cell]:
        """The cells of the map that it covers, with its corner somewhere else if that is given."""
        top, left = self.corner if corner is None else corner
        return [(top + row, left + column) for row, column in self.cells]


@dataclass(frozen=True, eq=False)
class Collisions:
    """What bodies that move by a cell run into, whatever their corners are.

    Attributes:
        shape: rows and columns of the map.
        stopped: bool[bodies, actions, cells], whether a body whose corner is in a cell would come
            onto a wall or off the map.
        outlines: int64[bodies], which bodies have the same cells: the index of their outline.
        meets: bool[outlines, outlines, 2 rows + 1, 2 columns + 1], whether two bodies overlap, by
            how far the corner of the second is from that of the first, plus rows and columns.
    """

    shape: tuple[int, int]
    stopped: Bool[np.ndarray, "bodies actions cells"]
    outlines: Int64[np.ndarray, "bodies"]
    meets: Bool[np.ndarray, "outlines outlines down across"]

    @classmethod
    def of(
        cls,
        shape: tuple[int, int],
        bodies: Sequence[Body],
        walls: Sequence[Collection[Cell]],
    ) -> "Collisions":
        """The tables of some bodies, each with the walls that stop it."""
        different = [*dict.fromkeys(body.cells for body in bodies)]
        rows, columns = shape
        meets = np.zeros((len(different), len(different), 2 * rows + 1, 2 * columns + 1), bool)
        for one, its in enumerate(different):
            for other, those in enumerate(different):
                for row, column in its:
                    for to_row, to_column in those:
                        meets[one, other, rows + row - to_row, columns + column - to_column] = True
        stopped = [_stopped(shape, *pair) for pair in zip(bodies, walls, strict=True)]
        outlines = np.array([different.index(body.cells) for body in bodies])
        return cls(shape, np.array(stopped), outlines, meets)


def _stopped(
    shape: tuple[int, int], body: Body, walls: Collection[Cell]
) -> Bool[np.ndarray, "actions cells"]:
    padded = np.ones((shape[0] + 2, shape[1] + 2), bool)
    padded[1:-1, 1:-1] = False
    for row, column in walls:
        padded[row + 1, column + 1] = True
    corners = np.indices(shape)
    stops = np.zeros((len(STEPS), *shape), bool)
    for stop, step in zip(stops, STEPS, strict=True):
        for cell in body.cells:
            row, column = (corners[axis] + step[axis] + cell[axis] + 1 for axis in (0, 1))
            stop |= padded[np.minimum(row, shape[0] + 1), np.minimum(column, shape[1] + 1)]
    return stops.reshape(len(STEPS), -1)
