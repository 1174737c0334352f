"""The states of a landscape: one for every cell of the agent."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from habilis.empowerment.arguments import whole_number
from habilis.empowerment.sensors import Sensor
from habilis.mdp import HELD, LAID, TabularMDP
from habilis.worlds.moving import Where, agent_cells, elsewhere, free_cells
from habilis.worlds.placements import placed, start_of
from habilis.worlds.reach import MAX_STATES, TooManyPlacementsError, reachable, too_many
from habilis.worlds.rules import NONE, Grid, Places
from habilis.worlds.table import placements, tabulate
from habilis.worlds.world import Cell, World

_FEW = 300_000  # placements that are tabulated in an instant
_SHARE = 8  # of all placements one in so many: above, tabulating all takes no longer
_STEPS = (-1, 0), (0, 1), (1, 0), (0, -1)  # north, east, south, west


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
    if world.several:
        shown = elsewhere(world, tool=tool, object=object)
        if mdp is not None or not isinstance(sensor, str):
            mdp = tabulate(world, slip) if mdp is None else mdp
            return shown, mdp, _states_of_several(shown, mdp)
        steps = whole_number("horizon", horizon)
        mdp, states = reachable(shown, _placed(shown), steps, show_progress=show_progress)
        return shown, mdp.slippery(slip), states
    tool_cell = _only(world, "tool", world.tool_cell, tool)
    object_cell = _only(world, "object", world.object, object)
    found = None
    if mdp is None and isinstance(sensor, str) and (most := placements(world)) > _FEW:
        # Of a map too large for its table, all that can be reached is looked at, however much.
        limit = most // _SHARE if most <= MAX_STATES else MAX_STATES
        steps = whole_number("horizon", horizon)
        found = _reached(world, tool_cell, object_cell, steps, limit, show_progress)
        if found is None and most > MAX_STATES:
            raise too_many(world, steps, MAX_STATES)
    if found is not None:
        mdp, states = found
        mdp = mdp.slippery(slip)
    else:
        mdp = tabulate(world, slip, show_progress=show_progress) if mdp is None else mdp
        states = _states(mdp, tool_cell, object_cell)
    row, column = divmod(int(mdp.factor("agent")[states[0]]), world.width)
    agent = (row, column) if world.agent in (tool_cell, object_cell) else world.agent
    return replace(world, agent=agent, tool_cell=tool_cell, object=object_cell), mdp, states


def _reached(
    world: World,
    tool: Cell | None,
    object: Cell,
    horizon: int,
    most: int,
    show_progress: bool,
) -> tuple[TabularMDP, np.ndarray] | None:
    """What can be reached from where the agent can be, and these states, as in the whole table.

    They are in that table's order: the agent apart from the tool, row by row; then beside it, the
    tool to the north, east, south and west of the agent. `None` if there is more than `most`.
    """
    taken = {tool, object} if world.tools else {object}
    cells = [cell for cell in free_cells(world) if cell not in taken]
    if world.tools:
        assert tool is not None, "a world with a tool has a cell for it"
        beside = [(tool[0] - down, tool[1] - right) for down, right in _STEPS]
        apart = [cell for cell in cells if cell not in beside] if tool == world.tool_cell else []
        there = set(cells)
        cells = [*apart, *(cell for cell in beside if cell in there)]
        if tool in world.walls or object in world.walls or tool == object:
            cells = []
    names = {"tool": tool, "object": object} if world.tools else {"object": object}
    if not cells:
        raise _nowhere(tool, object)
    try:
        return reachable(
            world, placed(world, Grid.of(world), names, cells), horizon, most, show_progress
        )
    except TooManyPlacementsError:
        return None


def _only(world: World, kind: str, cell: Cell | None, where: Where | None) -> Any:
    """Where the only tool or object is to be."""
    if not isinstance(where, Mapping):
        return cell if where is None else where
    things = world.tools if kind == "tool" else world.objects
    unknown = [name for name in where if name not in {thing.name for thing in things}]
    if unknown:
        known = f"its only one is {things[0].name}" if things else "it has none"
        raise ValueError(f"{world.name} has no {kind} {unknown[0]!r}; {known}")
    return next(iter(where.values()), cell)


def _placed(world: World) -> Places:
    """The agent in every cell where it can be, everything else as on the map."""
    things = {name: cell for name, cell in start_of(world).items() if name != "agent"}
    return placed(world, Grid.of(world), things, agent_cells(world))


def _states_of_several(world: World, mdp: TabularMDP) -> np.ndarray:
    """The states of a table with all things but the agent there, and in hand what follows."""
    grid, at = Grid.of(world), _placed(world)
    held = np.full(world.height * world.width, NONE)
    held[grid.label(at.agent)] = at.held
    here = np.ones(mdp.states, bool)
    for name, cell in start_of(world).items():
        if name != "agent":
            here &= mdp.factor(name) == mdp.label(cell)
    if HELD in mdp.factors:
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


def _states(mdp: TabularMDP, tool: Cell | None, object: Cell) -> np.ndarray:
    """The states with tool and object there, one for every agent cell."""
    here = mdp.factor("object") == mdp.label(object)
    if "tool" in mdp.factors:
        assert tool is not None, "a world with a tool has a cell for it"
        here &= mdp.factor("tool") == mdp.label(tool)
    states = np.flatnonzero(here)
    if not len(states):
        raise _nowhere(tool, object)
    return states


def _nowhere(tool: Cell | None, object: Cell) -> ValueError:
    return ValueError(
        f"no state has the tool at {tool} and the object at {object}; "
        "give two distinct free cells, the tool's beside a free one or the map's own"
    )
