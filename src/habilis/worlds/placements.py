"""Placements of a world's things: in words, as arrays, and each as one number."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np
from jaxtyping import Int64, Integer

from habilis.mdp import HELD, LAID
from habilis.worlds.rules import NONE, Grid, Places
from habilis.worlds.world import Cell, World

Placement = Mapping[str, Any]
"""The cells of "agent", "object" and, in a world with a tool, "tool"; of several things by name, as
"object:can", and perhaps which tool is "held" and which was "laid" down and not left since: its
place among the tools, -1 for none."""

Keys = Int64[np.ndarray, "states"]

WANTED = (
    "states has {!r}; of a world, give placements such as {{'agent': (0, 0), 'object': (2, 2)}}"
)


def tool_factors(world: World) -> list[str]:
    """What the cells of the tools are called in tables."""
    names = [tool.name for tool in world.tools]
    return [f"tool:{name}" for name in names] if world.several else ["tool"] * len(names)


def object_factors(world: World) -> list[str]:
    """What the cells of the objects are called in tables."""
    names = [thing.name for thing in world.objects]
    return [f"object:{name}" for name in names] if world.several else ["object"]


def start_of(world: World) -> dict[str, Cell]:
    """Where the map has everything."""
    tools = zip(tool_factors(world), (tool.cell for tool in world.tools), strict=True)
    objects = zip(object_factors(world), (thing.cell for thing in world.objects), strict=True)
    return {"agent": world.agent, **dict(tools), **dict(objects)}


def places_of(world: World, grid: Grid, placements: list[Any]) -> Places:
    """Placements as arrays, the first tool beside the agent in hand where they do not say which.

    Raises:
        ValueError: one that is none.
    """
    names = [*tool_factors(world), *object_factors(world)]
    cells = [_checked(world, ["agent", *names], placement) for placement in placements]
    columns = np.array([[grid.index(cell) for cell in one] for one in cells], np.int64)
    agent, *things = columns.reshape(len(cells), 1 + len(names)).T
    tools = len(world.tools)
    at = Places.of(grid, agent, tuple(things[:tools]), tuple(things[tools:]), world.drop)
    if not world.several:
        return at
    held = [_tool(world, HELD, placement) for placement in placements]
    held = np.where([one is None for one in held], at.held, [one or 0 for one in held])
    if not world.drop:
        return replace(at, held=held)
    laid = [_tool(world, LAID, placement) for placement in placements]
    return replace(at, held=held, laid=np.array([NONE if one is None else one for one in laid]))


def placed(world: World, grid: Grid, things: Mapping[str, Cell], agents: Sequence[Cell]) -> Places:
    """The same placement of all things with the agent in each of some cells, as arrays.

    Args:
        world: the map.
        grid: the same.
        things: the cells of the tools and objects, each another.
        agents: free cells, which nothing else is in.

    Raises:
        ValueError: a thing's cell that is not free.
    """
    names = [*tool_factors(world), *object_factors(world)]
    cells = [_cell(world, name, things[name]) for name in names]
    agent = grid.index(np.array(agents, np.int64).reshape(-1, 2).T)
    columns = [np.full(agent.shape, grid.index(cell), np.int64) for cell in cells]
    tools = len(world.tools)
    return Places.of(grid, agent, tuple(columns[:tools]), tuple(columns[tools:]), world.drop)


@dataclass(frozen=True)
class Packing:
    """Each placement as one number, in the order of its cells.

    Attributes:
        free: the cells of the map that are no walls.
        rank: of each cell among them.
        tools, objects: how many there are.
        several: whether it matters, besides the cells, which tool is in hand.
        drop: whether tools may be put down.
    """

    free: Integer[np.ndarray, "free"]
    rank: Integer[np.ndarray, "cells"]
    tools: int
    objects: int
    several: bool
    drop: bool

    @classmethod
    def of(cls, world: World, grid: Grid) -> "Packing":
        """The packing of a world.

        Raises:
            ValueError: there are too many things for so large a map.
        """
        free = grid.free
        rank = np.full(len(grid.wall), -1)
        rank[free] = np.arange(len(free))
        counts = len(world.tools), len(world.objects)
        packing = cls(free, rank, *counts, world.several, world.drop)
        if prod(packing._bases) >= 2**63:
            raise ValueError(
                f"{world.name}: {sum(counts)} things on {len(free)} free cells have more "
                "placements than can be numbered; take things away, or make the map smaller"
            )
        return packing

    @property
    def _bases(self) -> list[int]:
        cells = [len(self.free)] * (1 + self.tools + self.objects)
        hands = [self.tools + 1] * (self.several + self.drop)
        return cells + hands

    def packed(self, at: Places) -> Keys:
        digits = [self.rank[cells] for cells in at.cells]
        if self.several:
            digits.append(at.held - NONE)
        if self.drop and at.laid is not None:
            digits.append(at.laid - NONE)
        keys = np.zeros(at.agent.shape, np.int64)
        for base, digit in zip(self._bases, digits, strict=True):
            keys = keys * base + digit
        return keys

    def unpacked(self, grid: Grid, keys: Keys) -> Places:
        digits = []
        for base in reversed(self._bases):
            keys, digit = np.divmod(keys, base)
            digits.append(digit)
        digits.reverse()
        cells = [self.free[digit] for digit in digits[: 1 + self.tools + self.objects]]
        hands = [digit + NONE for digit in digits[len(cells) :]]
        agent, tools, objects = cells[0], cells[1 : 1 + self.tools], cells[1 + self.tools :]
        if not self.several:
            return Places.of(grid, agent, tuple(tools), tuple(objects))
        return Places(agent, tuple(tools), tuple(objects), *hands)


def _checked(world: World, names: list[str], placement: Any) -> list[Cell]:
    """The cells of a placement, if it is one."""
    if not isinstance(placement, Mapping):
        raise ValueError(WANTED.format(placement))
    said = set(placement) - ({HELD, LAID} if world.several else set())
    if said != set(names):
        raise ValueError(
            f"a placement has {', '.join(map(str, placement)) or 'nothing'}; "
            f"{world.name} has {', '.join(names)}: give a cell for each of them"
        )
    cells = [_cell(world, name, placement[name]) for name in names]
    if len(set(cells)) < len(cells):
        raise ValueError(f"a placement has two things in one cell, {dict(placement)}")
    return cells


def _tool(world: World, name: str, placement: Mapping[str, Any]) -> int | None:
    """Which tool is in hand, or was put down, if a placement says that."""
    place = placement.get(name)
    if place is None or place == NONE:
        return place
    if not isinstance(place, int) or not 0 <= place < len(world.tools):
        raise ValueError(
            f"{name} is {place!r}; give a tool's place among {len(world.tools)}, from 0, or {NONE}"
        )
    (row, column), (agent_row, agent_column) = (
        placement[tool_factors(world)[place]],
        placement["agent"],
    )
    if abs(row - agent_row) + abs(column - agent_column) != 1:
        raise ValueError(
            f"the {world.tools[place].name} is {name} and not beside the agent; put it there"
        )
    return place


def _cell(world: World, name: str, cell: Any) -> Cell:
    try:
        row, column = (int(part) for part in cell)
    except (TypeError, ValueError):
        raise ValueError(f"the {name}'s cell is {cell!r}; give (row, column)") from None
    inside = 0 <= row < world.height and 0 <= column < world.width
    if not inside or (row, column) in world.walls:
        where = "a wall" if inside else f"outside the {world.height} x {world.width} cells"
        raise ValueError(f"the {name}'s cell {(row, column)} is {where}; give a free one")
    return row, column
