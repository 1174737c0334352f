"""From a world to its table."""

from dataclasses import replace

import numpy as np
from jaxtyping import Int32

from habilis.mdp import TabularMDP
from habilis.worlds.answers import answers
from habilis.worlds.rules import ACTIONS, MOVES, Grid, successor
from habilis.worlds.tools import Cells
from habilis.worlds.world import Cell, World

MAX_STATES = 50_000_000
_BLOCK = 1 << 14  # placements moved at once: the arrays of one block stay in the cache


def tabulate(world: World, slip: float = 0.0, *, max_states: int = MAX_STATES) -> TabularMDP:
    """Every placement of agent, tool and object, and what each action does to it.

    The states are all placements with the tool in hand, and all with the tool lying at its
    cell of the map; without a tool, all placements of agent and object. Reward and end of an
    episode are rule 6 of the worlds: 0 for the transition that brings the object into the
    goal, which ends the episode, and -1 for every other.

    Args:
        world: the map; its tool decides on eight actions, or four without one.
        slip: the probability that the chosen action is replaced by one drawn uniformly from
            all (rule 7); above 0 the table is stochastic.
        max_states: how many placements to accept; each takes about 80 bytes, and 190 while the
            table is made.

    Returns:
        A table with factors "agent", "object" and, unless the tool is "none", "tool"; flags
        "equipped" and "attached"; the map's placement as `start`.

    Raises:
        ValueError: the map has more placements, or slip is no probability.

    Example:
        >>> from habilis.worlds.world import Cell, World
        >>> tabulate(World.parse("A.CG", name="line")).actions
        ('north', 'east', 'south', 'west')
    """
    grid, rule = Grid.of(world), world.tool_rule
    hands = _hands(world, grid)
    most = len(hands) * len(grid.free)
    if most > max_states:
        raise ValueError(
            f"{world.name}: {most:,} placements are more than {max_states:,}; "
            "make the map smaller, or raise max_states if there is memory for it"
        )
    state_of = np.full((len(hands), len(grid.wall)), -1, np.int32)
    in_hand = (hands[:, :, None] == grid.free).any(axis=1)
    state_of[:, grid.free] = np.where(in_hand, -1, 0)
    hand, thing = np.nonzero(state_of == 0)
    state_of[hand, thing] = np.arange(len(hand), dtype=np.int32)
    hand_of = np.full((len(grid.wall), len(grid.wall)), -1, np.int32)
    hand_of[hands[:, 0], hands[:, 1]] = np.arange(len(hands))
    agent, tool = hands[hand, 0], hands[hand, 1]

    actions = MOVES if rule is None else ACTIONS
    next_state = np.empty((len(hand), len(actions)), np.int32)
    for first in range(0, len(hand), _BLOCK):
        block = slice(first, first + _BLOCK)
        for action in range(len(actions)):
            to = successor(grid, rule, action, agent[block], tool[block], thing[block])
            next_state[block, action] = state_of[hand_of[to[0], to[1]], to[2]]

    start_tool = grid.nowhere if rule is None else _tool_cell(world, grid)
    start = state_of[hand_of[grid.index(world.agent), start_tool], grid.index(world.object)]
    return describe(world, grid, (agent, tool, thing), next_state, int(start)).slippery(slip)


def describe(
    world: World,
    grid: Grid,
    placements: tuple[Cells, Cells, Cells],
    next_state: Int32[np.ndarray, "S A"],
    start: int,
) -> TabularMDP:
    """The table of some of a world's placements, given where they lead.

    Args:
        world: the map.
        grid: its cells.
        placements: the cells of agent, tool and object in each state.
        next_state: int32[S, A].
        start: the state in which episodes begin.
    """
    agent, tool, thing = placements
    rule = world.tool_rule
    terminal = thing == grid.index(world.goal)
    equipped = grid.adjacent(agent, tool)
    attached = np.zeros(len(thing), bool)
    if rule is not None:
        attached = answers(grid, rule, "attached", placements, where=equipped, elsewhere=attached)
    cells = {"agent": agent, "tool": tool, "object": thing}
    if rule is None:
        del cells["tool"]
    return TabularMDP(
        transitions=next_state,
        reward=_rewards(terminal, next_state),
        terminal=terminal,
        factors={name: grid.label(at).astype(np.int32) for name, at in cells.items()},
        flags={"equipped": equipped, "attached": attached},
        start=start,
        shape=(world.height, world.width),
        actions=MOVES if rule is None else ACTIONS,
    )


def restarted(mdp: TabularMDP, world: World) -> TabularMDP:
    """The table of a world from that of another with the same walls, tool and place of the tool.

    Only the goal, and where agent and object start, may be others.
    """
    terminal = mdp.factor("object") == mdp.label(world.goal)
    cells = {"agent": world.agent, "object": world.object, "tool": world.tool_cell}
    return replace(
        mdp,
        terminal=terminal,
        reward=_rewards(terminal, mdp.next_state),
        start=mdp.find(
            **{name: cell for name, cell in cells.items() if name in mdp.factors and cell}
        ),
    )


def _rewards(terminal: np.ndarray, next_state: np.ndarray) -> np.ndarray:
    return -(~terminal[next_state]).astype(np.float32)


def placement(world: World, mdp: TabularMDP, state: int) -> World:
    """A state as a world: the same map with its things where the state has them.

    Args:
        world: the map.
        mdp: its table.
        state: the state's index.

    Returns:
        Another world.
    """

    def cell(factor: str) -> Cell:
        row, column = divmod(int(mdp.factor(factor)[state]), world.width)
        return row, column

    tool_cell = cell("tool") if "tool" in mdp.factors else world.tool_cell
    return replace(world, agent=cell("agent"), object=cell("object"), tool_cell=tool_cell)


def _hands(world: World, grid: Grid) -> Cells:
    """All (agent, tool) cells, int[pairs, 2]: first the tool lying, then in hand by side."""
    free = grid.free
    if world.tool_rule is None:
        return np.stack([free, np.full_like(free, grid.nowhere)], axis=1)
    lies = np.full_like(free, _tool_cell(world, grid))
    apart = (free != lies) & ~grid.adjacent(free, lies)
    pairs = [np.stack([free, lies], axis=1)[apart]]
    for step in grid.steps:
        held = np.stack([free, free + step], axis=1)
        pairs.append(held[~grid.wall[free + step]])
    return np.concatenate(pairs)


def _tool_cell(world: World, grid: Grid) -> int:
    assert world.tool_cell is not None, "a world with a tool has a cell for it"
    return grid.index(world.tool_cell)
