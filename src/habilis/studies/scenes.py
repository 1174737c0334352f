"""The paper's two worlds, their tables, and the placements that its figures show."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.measures import average_empowerment, landscape
from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World, load_world

# The paper's Figure 4 has tool and can side by side in the yard; where, is not known. Here an
# agent with the tool between itself and the can has two free cells on every other side.
BESIDE_TOOL: Cell = (2, 6)
BESIDE_CAN: Cell = (2, 5)
FAR_CAN: Cell = (7, 8)


@dataclass(frozen=True)
class Scene:
    """A world, and what is computed from it, each thing once."""

    world: World

    @cached_property
    def mdp(self) -> TabularMDP:
        return tabulate(self.world)

    def with_tool(self, tool: str) -> "Scene":
        return Scene(self.world.with_tool(tool))

    def placed(self, tool: Cell, object: Cell) -> "Scene":
        """The same map with tool and object lying elsewhere."""
        return Scene(replace(self.world, tool_cell=tool, object=object))

    def average(self, horizon: int, sensor: str = "object") -> float:
        """See `measures.average_empowerment`."""
        return average_empowerment(self.mdp, horizon, sensor)

    def landscape(self, horizon: int, sensor: str) -> Float64[np.ndarray, "rows columns"]:
        """Bits for every agent cell, tool and object at their cells of the map."""
        return landscape(
            self.mdp, horizon, sensor, tool=self.world.tool_cell, object=self.world.object
        )

    def beside(self, horizon: int, sensor: str, cell: Cell) -> Float64[np.ndarray, "n"]:
        """The landscape's values in the cells around one."""
        values = self.landscape(horizon, sensor)[self.distance(cell) == 1]
        return values[np.isfinite(values)]

    def distance(self, cell: Cell) -> Int64[np.ndarray, "rows columns"]:
        """The Manhattan distance of every cell to one."""
        rows, columns = np.indices((self.world.height, self.world.width))
        return np.abs(rows - cell[0]) + np.abs(columns - cell[1])

    @property
    def tool_cell(self) -> Cell:
        assert self.world.tool_cell is not None
        return self.world.tool_cell


def corridor() -> Scene:
    """The first experiment's world."""
    return Scene(load_world("corridor"))


def yard() -> Scene:
    """The second experiment's world, with the picker."""
    return Scene(load_world("yard"))
