"""The paper's two worlds, their tables, and the placements that its figures show."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64

from habilis.empowerment.landscape import Landscape, landscape
from habilis.empowerment.measures import average_empowerment
from habilis.mdp import TabularMDP
from habilis.worlds.table import restarted, tabulate
from habilis.worlds.world import NO_TOOL, Cell, World, load_world

# What `Scene.side_by_side` finds in the yard.
BESIDE_TOOL: Cell = (2, 6)
BESIDE_CAN: Cell = (2, 5)
FAR_CAN: Cell = (7, 8)
_SIDES = ((-1, 0), (0, 1), (1, 0), (0, -1))


@dataclass(frozen=True)
class Scene:
    """A world, and what is computed from it, each thing once."""

    world: World
    _like: TabularMDP | None = field(default=None, compare=False, repr=False)
    _tools: dict[str, "Scene"] = field(default_factory=dict, compare=False, repr=False)
    _landscapes: dict[tuple, Landscape] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def mdp(self) -> TabularMDP:
        return tabulate(self.world) if self._like is None else restarted(self._like, self.world)

    def with_tool(self, tool: str) -> "Scene":
        if tool == self.world.tool:
            return self
        if tool not in self._tools:
            self._tools[tool] = Scene(self.world.with_tool(tool))
        return self._tools[tool]

    def restarted(self, world: World) -> "Scene":
        """The scene of a world with the same walls and tool cell, made of this one's tables."""
        other = Scene(world, self.__dict__.get("mdp", self._like))
        for tool, scene in self._tools.items():
            other._tools[tool] = scene.restarted(world.with_tool(tool))
        return other

    def placed(self, tool: Cell, object: Cell) -> "Scene":
        """The same map with tool and object lying elsewhere."""
        return Scene(replace(self.world, tool_cell=tool, object=object))

    def average(self, horizon: int, sensor: str = "object") -> float:
        """See `measures.average_empowerment`."""
        return average_empowerment(self.mdp, horizon, sensor)

    def landscape(
        self, horizon: int, sensor: str, places: tuple[Cell | None, Cell] | None = None
    ) -> Landscape:
        """Bits for every agent cell, tool and object at their cells of the map.

        Or at other places, for the agent cells from which the tool is then in hand.
        """
        tool, thing = places or (self.world.tool_cell, self.world.object)
        key = horizon, sensor, tool, thing
        if key not in self._landscapes:
            tool = None if self.world.tool == NO_TOOL else tool
            self._landscapes[key] = landscape(
                self.world, horizon, sensor, tool=tool, object=thing, mdp=self.mdp
            )
        return self._landscapes[key]

    def beside(self, horizon: int, sensor: str, cell: Cell) -> Float64[np.ndarray, "n"]:
        """The landscape's values in the cells around one."""
        values = self.landscape(horizon, sensor).values[self.distance(cell) == 1]
        return values[np.isfinite(values)]

    def distance(self, cell: Cell) -> Int64[np.ndarray, "rows columns"]:
        """The Manhattan distance of every cell to one."""
        rows, columns = np.indices((self.world.height, self.world.width))
        return np.abs(rows - cell[0]) + np.abs(columns - cell[1])

    @property
    def side_by_side(self) -> tuple[Cell, Cell] | None:
        """Cells of tool and object, side by side in the open; `None` if there are none.

        The paper's Figure 4 has tool and object so; where, is not known. Here an agent with the
        tool between itself and the object has two free cells on every side: the topmost, then
        easternmost such place, in which the tool is to the west of the agent.
        """
        near = [(0, 0), *((d * k, e * k) for k in (1, 2) for d, e in _SIDES)]
        for row in range(2, self.world.height - 2):
            for column in reversed(range(2, self.world.width - 2)):
                if not any((row + r, column + c) in self.world.walls for r, c in near):
                    return (row, column - 1), (row, column - 2)
        return None

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
