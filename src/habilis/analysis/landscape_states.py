"""The states of a landscape: one for every cell of the agent."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.empowerment.arguments import whole_number
from habilis.empowerment.sensors import Sensor
from habilis.mdp import HELD, LAID, TabularMDP
from habilis.models.explore import AnyModel, explore
from habilis.worlds.grid import STEPS
from habilis.worlds.placements import Factors, with_agents
from habilis.worlds.reach import MAX_STATES, TooManyPlacementsError, reachable
from habilis.worlds.rules import NONE, Places
from habilis.worlds.table import placements, tabulate, whole_table
from habilis.worlds.things import Where, cells_of, moved
from habilis.worlds.world import Cell, World

if TYPE_CHECKING:
    from rich.text import Text

AGENT = "agent"
_FEW = 300_000  # placements that are tabulated in an instant
_SHARE = 8  # of all placements one in so many: above, tabulating all takes no longer


def asked(
    world: World,
    horizon: int,
    sensor: Sensor,
    slip: float,
    tool: Where | None,
    object: Where | None,
    mdp: TabularMDP | None,
    show_progress: bool = False,
) -> tuple[World, TabularMDP, np.ndarray]:
    """The world with its things where they are to be, a table, and a state for every agent cell."""
    tools = cells_of(world.name, "tool", world.tools, tool)
    objects = cells_of(world.name, "object", world.objects, object)
    agents = _agents(world, tools, objects)
    shown = replace(
        world,
        agent=agents[0] if world.agent in (*tools, *objects) and agents else world.agent,
        tools=moved(world.tools, tools),
        objects=moved(world.objects, objects),
        held=None,
    )
    things = dict(zip(Factors.of(world).things, (*tools, *objects), strict=True))
    at = with_agents(world, things, agents)
    if mdp is None and isinstance(sensor, str) and (limit := _limit(world)):
        steps = whole_number("horizon", horizon)
        try:
            mdp, states = reachable(world, at, steps, limit, show_progress)
            return shown, mdp.slippery(slip), states
        except TooManyPlacementsError:
            if limit == MAX_STATES:
                raise
    mdp = tabulate(world, slip, show_progress=show_progress) if mdp is None else mdp
    return shown, mdp, _states(world, mdp, things, at)


def asked_of_puzzle(
    puzzle: PushWorld, horizon: int, object: Where | None, show_progress: bool = False
) -> tuple[PushWorld, TabularMDP, np.ndarray]:
    """The same of a puzzle: a state for every cell that the agent's corner can be in."""
    if object is not None and not isinstance(object, Mapping):
        raise ValueError(
            f"{puzzle.name}: object is {object}; give cells by names, as {{'m0': ...}}"
        )
    shown = puzzle.with_cells(objects=object)
    columns, rest = puzzle.width, shown.initial[1:]
    states = [(row * columns + column, *rest) for row, column in shown.agent_cells]
    steps = whole_number("horizon", horizon)
    mdp = explore(shown, states, steps, show_progress=show_progress)
    return shown, mdp, np.arange(len(states))


@dataclass(frozen=True)
class PlainMap:
    """The map of a model of which nothing is known but its size, as pictures take it.

    Attributes:
        name: what messages call it.
        height, width: rows and columns.
    """

    name: str
    height: int
    width: int
    walls: frozenset[Cell] = frozenset()

    def drawings(self, agent: bool = True) -> list[Any]:
        """Nothing."""
        return []

    def colored_text(self) -> "Text":
        """Dots."""
        from rich.text import Text

        return Text("\n".join([". " * self.width] * self.height))


def asked_of_model(
    model: AnyModel, show_progress: bool = False
) -> tuple[World | PlainMap, TabularMDP, np.ndarray]:
    """The same of any other model: the states that differ from the first in the agent's cell alone.

    Raises:
        ValueError: the agent has no cell, or several such states have it in the same one.
    """
    mdp, name = whole_table(model, show_progress), type(model).__name__
    if mdp.shape is None or AGENT not in mdp.factors or not mdp.is_cell(AGENT):
        raise ValueError(
            f"{name} has no landscape: it needs a factor 'agent' whose labels are (row, column)"
        )
    same = np.ones(mdp.states, bool)
    for factor, labels in mdp.factors.items():
        same &= (labels == labels[mdp.start]) | (factor == AGENT)
    states = np.flatnonzero(same)
    cells, counts = np.unique(mdp.factor(AGENT)[states], return_counts=True)
    if counts.max() > 1:
        cell = divmod(int(cells[counts.argmax()]), mdp.shape[1])
        raise ValueError(
            f"{name} has {counts.max()} states with the agent at {cell} and all other factors as "
            "in the first state; add factors that distinguish them"
        )
    two = isinstance(mdp.drawn, World) and mdp.drawn.second is not None
    return mdp.drawn if two else PlainMap(name, *mdp.shape), mdp, states


def _agents(world: World, tools: list[Cell], objects: list[Cell]) -> list[Cell]:
    """The cells in which the agent can be.

    A table of all placements has a tool that lies at its cell of the map, or is in hand. The cells
    are in that table's order: first those apart from the tool, row by row; then those beside it,
    the tool to the north, east, south and west of the agent.

    Raises:
        ValueError: a table of all placements has no such state.
    """
    taken = {*tools, *objects}
    cells = [cell for cell in world.free_cells if cell not in taken]
    if not world.single:
        return cells
    things = [*tools, *objects]
    if len(taken) < len(things) or not all(map(world.is_free, taken)):
        cells = []
    for tool in tools:
        beside = [(tool[0] - down, tool[1] - right) for down, right in STEPS]
        apart = [cell for cell in cells if cell not in beside] if tool == world.tool_cell else []
        there = set(cells)
        cells = [*apart, *(cell for cell in beside if cell in there)]
    if not cells:
        raise ValueError(
            f"no state has the tool at {world.tool_cell if not tools else tools[0]} and the object "
            f"at {objects[0]}; give two distinct free cells, the tool's beside a free one or the "
            "map's own"
        )
    return cells


def _limit(world: World) -> int:
    """The placements to look at before all are tabulated instead; 0 to tabulate at once."""
    if not world.single:
        return MAX_STATES
    most = placements(world)
    if most <= _FEW:
        return 0
    return most // _SHARE if most <= MAX_STATES else MAX_STATES


def _states(world: World, mdp: TabularMDP, things: Mapping[str, Cell], at: Places) -> np.ndarray:
    """The states of a table that are these placements of a world."""
    here = np.ones(mdp.states, bool)
    for name, cell in things.items():
        here &= mdp.factor(name) == mdp.label(cell)
    if HELD in mdp.factors:
        held = np.full(world.height * world.width, NONE)
        held[world.grid.label(at.agent)] = at.held
        here &= mdp.factor(HELD) == held[mdp.factor("agent")]
    if LAID in mdp.factors:
        here &= mdp.factor(LAID) == NONE
    states = np.flatnonzero(here)
    if not len(states):
        raise ValueError(
            f"{world.name}: no state of the table has everything there; leave out the table, and "
            "name the sensor"
        )
    return states
