"""Pictures of very many states: every look of every cell is drawn once, the rest is copying."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Integer, UInt8
from numpy.typing import ArrayLike

from habilis.worlds.pictures import looks, on_goal, rendered
from habilis.worlds.world import NO_TOOL, Cell, World

Labels = Integer[np.ndarray, "N"]

# Which of a tool's looks, by how far it is from the agent: rows and columns, from -2 or less to 2.
_LOOKS = ("tool", "north", "east", "south", "west")
_LOOK = np.zeros((5, 5), np.intp)
_LOOK[[1, 2, 3, 2], [2, 3, 2, 1]] = [1, 2, 3, 4]


@dataclass(frozen=True, eq=False)
class Tiles:
    """The looks of a world's cells, of which the picture of any of its states is laid.

    Attributes:
        empty: the map with its walls and its bin.
        agent, can: the pixels of each cell when agent or can is there (no matter where walls are).
        tool: those when the tool is there, for each of its looks: lying, then in hand to the
            north, east, south and west of the agent. `None` in a world without one.
    """

    empty: UInt8[np.ndarray, "rows size columns size 3"]
    agent: UInt8[np.ndarray, "cells size size 3"]
    can: UInt8[np.ndarray, "cells size size 3"]
    tool: UInt8[np.ndarray, "5 cells size size 3"] | None

    @classmethod
    def of(cls, world: World, cell: int = 32) -> "Tiles":
        """Draws the tiles of a world, `cell` by `cell` pixels each.

        They take `21 * cells * cell ** 2` bytes of memory: 8 MB for a map of 20 x 20 cells.

        Example:
            >>> tiles = Tiles.of(World.parse("A.CG", "line"), cell=8)
            >>> tiles.frame(agent=1, tool=None, object=2).shape
            (8, 32, 3)
        """
        sizes = (world.height, cell, world.width, cell, 3)
        cells = np.ndindex(world.height, world.width)
        free = [(row, column) for row, column in cells if (row, column) not in world.walls]
        tiles = {}
        for name, drawing in looks(world).items():
            everywhere = dict.fromkeys(free, drawing) | {world.goal: on_goal(drawing)}
            pixels = rendered(world, everywhere, cell).reshape(sizes)
            tiles[name] = pixels.swapaxes(1, 2).reshape(-1, cell, cell, 3)
        return cls(
            empty=rendered(world, {world.goal: on_goal(None)}, cell).reshape(sizes),
            agent=tiles["agent"],
            can=tiles["can"],
            tool=None if world.tool == NO_TOOL else np.stack([tiles[name] for name in _LOOKS]),
        )

    def picture(self, state: World) -> UInt8[np.ndarray, "height width 3"]:
        """The picture of a state of the same world (see `frame`)."""

        def label(cell: Cell) -> int:
            return cell[0] * state.width + cell[1]

        tool = None if state.tool_cell is None else label(state.tool_cell)
        return self.frame(label(state.agent), tool, label(state.object))

    def frame(
        self, agent: int, tool: int | None, object: int
    ) -> UInt8[np.ndarray, "height width 3"]:
        """The picture of a state: what `pictures.frame` gives, to the pixel.

        Args:
            agent, tool, object: distinct free cells, as `row * width + column`. The tool's is not
                looked at in a world without one.
        """
        return self.frames([agent], None if tool is None else [tool], [object])[0]

    def frames(
        self, agent: ArrayLike, tool: ArrayLike | None, object: ArrayLike
    ) -> UInt8[np.ndarray, "N height width 3"]:
        """The pictures of N states, of which each argument gives the N cells (see `frame`)."""
        agent, thing = np.asarray(agent), np.asarray(object)
        rows, size, columns, _, _ = self.empty.shape
        pictures = np.empty((len(agent), *self.empty.shape), np.uint8)
        pictures[:] = self.empty
        state = np.arange(len(agent))

        def lay(cells: np.ndarray, tiles: np.ndarray) -> None:
            row, column = np.divmod(cells, columns)
            pictures[state, row, :, column] = tiles

        lay(thing, self.can[thing])
        lay(agent, self.agent[agent])
        if self.tool is not None and tool is not None:
            tool = np.asarray(tool)
            lay(tool, self.tool[self._look(agent, tool), tool])
        return pictures.reshape(-1, rows * size, columns * size, 3)

    def _look(self, agent: Labels, tool: Labels) -> Labels:
        columns = self.empty.shape[2]
        down = tool // columns - agent // columns
        right = tool % columns - agent % columns
        return _LOOK[np.clip(down, -2, 2) + 2, np.clip(right, -2, 2) + 2]
