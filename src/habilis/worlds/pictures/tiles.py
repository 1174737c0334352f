"""Pictures of very many states: every look of every cell is drawn once, the rest is copying."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Integer, UInt8
from numpy.typing import ArrayLike

from habilis.reprs import short, unfailing
from habilis.worlds.pictures.figures import bins, object_drawings, rendered, tool_looks
from habilis.worlds.pictures.shapes import SHAPES, Drawing
from habilis.worlds.world import Cell, World
from habilis.worlds.world_checks import check_one_agent

Labels = Integer[np.ndarray, "N"]
Look = UInt8[np.ndarray, "cells size size 3"]
"""The pixels of each cell when some thing is there."""

# Which of `tool_looks`, by how far a tool is from the agent: rows and columns, -2 or less to 2.
_LOOK = np.zeros((5, 5), np.intp)
_LOOK[[1, 2, 3, 2], [2, 3, 2, 1]] = [1, 2, 3, 4]


@dataclass(frozen=True, eq=False)
class Tiles:
    """The looks of a world's cells, of which the picture of any of its states is laid.

    Attributes:
        empty: the map with its walls and its bins.
        agent: the pixels of each cell when the agent is there (no matter where walls are).
        objects: those when an object is there, for each of them.
        tools: those when a tool is there, for each of them and of its looks: lying, then in hand to
            the north, east, south and west of the agent.
    """

    empty: UInt8[np.ndarray, "rows size columns size 3"]
    agent: Look
    objects: tuple[Look, ...]
    tools: tuple[UInt8[np.ndarray, "5 cells size size 3"], ...]

    @unfailing
    def __repr__(self) -> str:
        rows, size, columns, _, _ = self.empty.shape
        return short("Tiles", f"{rows} × {columns} cells of {size} pixels")

    @classmethod
    def of(cls, world: World, cell: int = 32) -> "Tiles":
        """Draws the tiles of a world.

        They take `3 * cells * cell ** 2` bytes of memory for the agent and for each object, five
        times as many for each tool: 8 MB for a map of 20 x 20 cells with one of each.

        Args:
            world: the map, in any state.
            cell: the side of a tile, in pixels.

        Returns:
            The tiles of everything that the world has.

        Example:
            >>> tiles = Tiles.of(World.parse("A.CG", "line"), cell=8)
            >>> tiles.frame(agent=1, tool=None, object=2).shape
            (8, 32, 3)
        """
        check_one_agent(world)
        sizes = (world.height, cell, world.width, cell, 3)
        goals = bins(world)

        def look(drawing: Drawing) -> Look:
            things = dict.fromkeys(world.free_cells, drawing)
            things |= {goal: its.with_thing(drawing) for goal, its in goals.items()}
            pixels = rendered(world, things, cell).reshape(sizes)
            return pixels.swapaxes(1, 2).reshape(-1, cell, cell, 3)

        empty = {goal: its.with_thing(None) for goal, its in goals.items()}
        return cls(
            empty=rendered(world, empty, cell).reshape(sizes),
            agent=look(SHAPES["agent"]),
            objects=tuple(map(look, object_drawings(world))),
            tools=tuple(np.stack(list(map(look, tool_looks(tool.rule)))) for tool in world.tools),
        )

    @property
    def tool(self) -> UInt8[np.ndarray, "5 cells size size 3"] | None:
        """The looks of the only tool, or the first; `None` in a world without one."""
        return self.tools[0] if self.tools else None

    def picture(self, state: World) -> UInt8[np.ndarray, "height width 3"]:
        """Draws a state.

        Args:
            state: of the same world.

        Returns:
            Its picture (see `frame`).
        """

        def labels(cell: Cell) -> list[int]:
            return [cell[0] * state.width + cell[1]]

        tools = [labels(tool.cell) for tool in state.tools]
        objects = [labels(thing.cell) for thing in state.objects]
        return self.laid(labels(state.agent), tools, objects, [state.in_hand])[0]

    def frame(
        self, agent: int, tool: int | None, object: int
    ) -> UInt8[np.ndarray, "height width 3"]:
        """Draws a state, given by its cells.

        Args:
            agent, tool, object: distinct free cells, as `row * width + column`. The tool's is
                ignored in a world without one.

        Returns:
            Its picture, equal to the pixel to the one that Matplotlib draws.
        """
        return self.frames([agent], None if tool is None else [tool], [object])[0]

    def frames(
        self, agent: ArrayLike, tool: ArrayLike | None, object: ArrayLike
    ) -> UInt8[np.ndarray, "N height width 3"]:
        """Draws N states of a world with one object and at most one tool.

        Args:
            agent, tool, object: the N cells of each (see `frame`); a tool next to the agent is in
                hand.

        Returns:
            Their pictures.
        """
        return self.laid(agent, [] if tool is None else [tool], [object])

    def laid(
        self,
        agent: ArrayLike,
        tools: Sequence[ArrayLike],
        objects: Sequence[ArrayLike],
        held: ArrayLike | None = None,
    ) -> UInt8[np.ndarray, "N height width 3"]:
        """Draws N states of a world with any number of tools and objects.

        Args:
            agent: the N cells of the agent, `row * width + column`.
            tools, objects: those of each tool and each object.
            held: the index of the tool in hand, -1 for none; `None`: any tool next to the agent.

        Returns:
            Their pictures.
        """
        agent = np.asarray(agent)
        rows, size, columns, _, _ = self.empty.shape
        pictures = np.empty((len(agent), *self.empty.shape), np.uint8)
        pictures[:] = self.empty
        state = np.arange(len(agent))

        def lay(cells: np.ndarray, tiles: np.ndarray) -> None:
            row, column = np.divmod(cells, columns)
            pictures[state, row, :, column] = tiles

        for cells, look in zip(map(np.asarray, objects), self.objects, strict=True):
            lay(cells, look[cells])
        lay(agent, self.agent[agent])
        for index, (cells, looks) in enumerate(zip(map(np.asarray, tools), self.tools)):  # noqa: B905  # a world without tools looks at none
            which = self._look(agent, cells)
            if held is not None:
                which = np.where(np.asarray(held) == index, which, 0)
            lay(cells, looks[which, cells])
        return pictures.reshape(-1, rows * size, columns * size, 3)

    def _look(self, agent: Labels, tool: Labels) -> Labels:
        columns = self.empty.shape[2]
        down = tool // columns - agent // columns
        right = tool % columns - agent % columns
        return _LOOK[np.clip(down, -2, 2) + 2, np.clip(right, -2, 2) + 2]
