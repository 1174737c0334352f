"""The shapes of maps, and the difference of two maps."""

from collections.abc import Iterable

from habilis.worlds.grid import STEPS
from habilis.worlds.map_text import FLOOR
from habilis.worlds.world import Cell, World


def neighbours(cell: Cell) -> list[Cell]:
    """The cells to the north, east, south and west, on the map or not."""
    return [(cell[0] + row, cell[1] + column) for row, column in STEPS]


def walls_alone(world: World) -> int:
    """The number of walls without a neighbouring wall: many of them do not look like rooms."""
    return sum(not world.walls.intersection(neighbours(wall)) for wall in world.walls)


def one_room(world: World) -> bool:
    """Whether every free cell can be walked to from every other."""
    free = set(world.free_cells)
    found, edge = {world.agent}, [world.agent]
    while edge:
        fresh = (free - found).intersection(neighbours(edge.pop()))
        found |= fresh
        edge += fresh
    return found == free


def difference(one: World, other: World) -> float:
    """The share of what is drawn on either of two maps that is not on both.

    Walls and things count, plain floor does not. Of the turns and mirror images of one map, the
    most alike counts: 0 if they are the same map, 1 if nothing is in the same place.
    """
    here = _drawn(one.text().splitlines())
    shares = []
    for rows in _symmetries(other.text().splitlines()):
        there = _drawn(rows)
        shares.append(1 - len(here & there) / max(len(here | there), 1))
    return min(shares)


def _drawn(rows: Iterable[str]) -> set[tuple[int, int, str]]:
    return {
        (row, column, mark)
        for row, cells in enumerate(rows)
        for column, mark in enumerate(cells)
        if mark != FLOOR
    }


def _symmetries(rows: list[str]) -> list[list[str]]:
    """The eight turns and mirror images."""
    found = []
    for _ in range(4):
        rows = ["".join(column) for column in zip(*reversed(rows), strict=True)]
        found += [rows, rows[::-1]]
    return found
