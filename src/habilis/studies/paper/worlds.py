"""The paper's two worlds, their tables, and what is computed from them."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int32, Int64

from habilis.analysis.averages import compared_states
from habilis.analysis.landscape import landscape
from habilis.analysis.landscape_values import Landscape
from habilis.empowerment.api import empowerment
from habilis.mdp import TabularMDP
from habilis.studies.paper.published import FIRST_WORLD, SECOND_WORLD
from habilis.worlds.grid import STEPS
from habilis.worlds.table import restarted, tabulate
from habilis.worlds.world import NO_TOOL, Cell, World, load_world

OVER = ("equipped", "all", "reachable")
"""The states over which an average may go, as the paper does not say which: all placements with the
tool in hand (without a tool: all), as in `measures.average_empowerment`; all states of the table,
so those with the tool in its cell of the map, too; all that can be reached from the start."""


@dataclass(frozen=True)
class CachedWorld:
    """A world, and what is computed from it, each thing once.

    Attributes:
        world: with its tool.
        over: the states over which averages go, one of `OVER`.
    """

    world: World
    over: str = "equipped"
    _like: TabularMDP | None = field(default=None, compare=False, repr=False)
    _tools: dict[str, "CachedWorld"] = field(default_factory=dict, compare=False, repr=False)
    _landscapes: dict[tuple, Landscape] = field(default_factory=dict, compare=False, repr=False)

    @cached_property
    def mdp(self) -> TabularMDP:
        return tabulate(self.world) if self._like is None else restarted(self._like, self.world)

    def with_tool(self, tool: str) -> "CachedWorld":
        if tool == self.world.tool:
            return self
        if tool not in self._tools:
            self._tools[tool] = CachedWorld(self.world.with_tool(tool), self.over)
        return self._tools[tool]

    def restarted(self, world: World) -> "CachedWorld":
        """A world with the same walls and tool cell, made of this one's tables."""
        other = CachedWorld(world, self.over, self.__dict__.get("mdp", self._like))
        for tool, world_with in self._tools.items():
            other._tools[tool] = world_with.restarted(world.with_tool(tool))
        return other

    def with_object_far(self) -> "CachedWorld":
        """The same map with the object as far from the tool as can be, where it can be pushed.

        All four cells around it are free; of several such the topmost, then westernmost.
        """
        world, distance = self.world, self.distance(self.tool_cell)
        cells = world.free_cells
        inner = [c for c in cells if all((c[0] + r, c[1] + k) in cells for r, k in STEPS)]
        taken = world.agent, self.tool_cell
        far = max((c for c in inner or cells if c not in taken), key=lambda cell: distance[cell])
        return CachedWorld(world.with_cells(object=far), self.over)

    def average(self, horizon: int, sensor: str = "object") -> float:
        """Mean empowerment in bits over the states that `over` names."""
        return float(empowerment(self.mdp, horizon, sensor, states=self._averaged).mean())

    @property
    def _averaged(self) -> Bool[np.ndarray, "S"]:
        if self.over == "equipped":
            return compared_states(self.mdp)
        if self.over == "all":
            return np.ones(self.mdp.states, bool)
        return reached_from(self.mdp.next_state, self.mdp.start)

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

        Where a map has them elsewhere, for lists that speak of them so: an agent with the tool
        between itself and the object has two free cells on every side. It is the topmost, then
        easternmost such place, in which the tool is to the west of the agent.
        """
        near = [(0, 0), *((d * k, e * k) for k in (1, 2) for d, e in STEPS)]
        for row in range(2, self.world.height - 2):
            for column in reversed(range(2, self.world.width - 2)):
                if not any((row + r, column + c) in self.world.walls for r, c in near):
                    return (row, column - 1), (row, column - 2)
        return None

    @property
    def tool_cell(self) -> Cell:
        assert self.world.tool_cell is not None
        return self.world.tool_cell


def reached_from(next_state: Int32[np.ndarray, "S A"], start: int) -> Bool[np.ndarray, "S"]:
    """The states that can be reached from one in any number of steps, itself among them."""
    reached = np.zeros(len(next_state), bool)
    edge = np.array([start])
    while len(edge):
        reached[edge] = True
        after = np.unique(next_state[edge])
        edge = after[~reached[after]]
    return reached


@dataclass(frozen=True)
class PaperWorlds:
    """The worlds of the two experiments."""

    corridor: CachedWorld
    yard: CachedWorld


def paper_worlds() -> PaperWorlds:
    """Those of the reproduction, each with the picker."""
    return PaperWorlds(CachedWorld(load_world(FIRST_WORLD)), CachedWorld(load_world(SECOND_WORLD)))
