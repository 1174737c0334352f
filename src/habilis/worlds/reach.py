"""The part of a world's table that a few actions from given placements can touch."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from jaxtyping import Int64
from numpy.typing import ArrayLike

from habilis.mdp import TabularMDP
from habilis.worlds.rules import ACTIONS, MOVES, Grid, successor
from habilis.worlds.table import MAX_STATES, describe
from habilis.worlds.tools import Cells
from habilis.worlds.world import Cell, World

Placement = Mapping[str, Cell]
"""The cells of "agent", "object" and, in a world with a tool, "tool"."""

Keys = Int64[np.ndarray, "states"]


def reachable(
    world: World,
    placements: "Placement | Sequence[Placement] | ArrayLike",
    horizon: int,
    max_states: int = MAX_STATES,
) -> tuple[TabularMDP, Int64[np.ndarray, "n"]]:
    """Enumerates what h actions from some placements can reach, breadth first.

    Args:
        world: the map.
        placements: where agent, tool and object are, once or several times; any distinct free
            cells, also where the tool lies elsewhere than on the map.
        horizon: h, in actions.
        max_states: how many placements to accept.

    Returns:
        A table with the same factors and flags as `tabulate` gives, whose states reached last stay
        where they are; and the states of the placements asked about, the first of which is its
        start.

    Raises:
        ValueError: a placement that is none, or more states than max_states.

    Example:
        >>> from habilis.worlds.world import World
        >>> line = World.parse("A.C..G", name="line")
        >>> mdp, asked = reachable(line, [{"agent": (0, 0), "object": (0, 2)}], horizon=2)
        >>> mdp.states
        3
    """
    grid = Grid.of(world)
    asked = np.array([_key(world, grid, place) for place in _listed(placements)], np.int64)
    actions = len(MOVES if world.tool_rule is None else ACTIONS)
    known = frontier = np.unique(asked)
    inner = known[:0]
    for _ in range(horizon):
        after = np.unique(_after(world, grid, frontier, actions))
        inner = known
        frontier = np.setdiff1d(after, known, assume_unique=True)
        known = np.union1d(known, frontier)
        if len(known) > max_states:
            raise ValueError(
                f"{world.name}: {horizon} actions reach more than {max_states:,} placements; "
                "ask for a lower horizon, or raise max_states if there is memory for it"
            )
        if not len(frontier):
            break
    next_state = np.repeat(np.arange(len(known), dtype=np.int32)[:, None], actions, axis=1)
    within = np.searchsorted(known, inner)
    next_state[within] = np.searchsorted(known, _after(world, grid, inner, actions))
    states = np.searchsorted(known, asked)
    start = int(states[0]) if len(states) else 0
    return describe(world, grid, _unpacked(grid, known), next_state, start), states


def _listed(placements: Any) -> list[Any]:
    if isinstance(placements, Mapping):
        return [placements]
    if isinstance(placements, Sequence) and not isinstance(placements, str):
        return list(placements)
    raise ValueError(_WANTED.format(placements))


_WANTED = (
    "states has {!r}; of a world, give placements such as {{'agent': (0, 0), 'object': (2, 2)}}"
)


def _key(world: World, grid: Grid, placement: Any) -> int:
    """A placement as one number, if it is one."""
    names = ["agent", "object"] if world.tool_rule is None else ["agent", "tool", "object"]
    if not isinstance(placement, Mapping):
        raise ValueError(_WANTED.format(placement))
    if set(placement) != set(names):
        raise ValueError(
            f"a placement has {', '.join(map(str, placement)) or 'nothing'}; "
            f"{world.name} has {', '.join(names)}: give a cell for each of them"
        )
    cells = [_cell(world, name, placement[name]) for name in names]
    if len(set(cells)) < len(cells):
        raise ValueError(f"a placement has two things in one cell, {dict(placement)}")
    if world.tool_rule is None:
        agent, thing = (grid.index(cell) for cell in cells)
        return int(_packed(grid, agent, grid.nowhere, thing))
    agent, tool, thing = (grid.index(cell) for cell in cells)
    return int(_packed(grid, agent, tool, thing))


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


def _packed(grid: Grid, agent: Any, tool: Any, thing: Any) -> Any:
    cells = np.int64(len(grid.wall))
    return (agent * cells + tool) * cells + thing


def _unpacked(grid: Grid, keys: Keys) -> tuple[Cells, Cells, Cells]:
    pair, thing = np.divmod(keys, len(grid.wall))
    agent, tool = np.divmod(pair, len(grid.wall))
    return agent, tool, thing


def _after(world: World, grid: Grid, keys: Keys, actions: int) -> Int64[np.ndarray, "states A"]:
    """Where each action leads from each placement."""
    agent, tool, thing = _unpacked(grid, keys)
    rule = world.tool_rule
    ways = [successor(grid, rule, action, agent, tool, thing) for action in range(actions)]
    return np.stack([_packed(grid, *cells) for cells in ways], axis=1)
