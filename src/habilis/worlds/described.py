"""The table of a world's placements, once it is known where they lead."""

from typing import TYPE_CHECKING

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32

from habilis.mdp import HELD, LAID, TabularMDP
from habilis.worlds.placements import object_factors, tool_factors
from habilis.worlds.rules import ACTIONS, DROP_NAME, MOVES, NONE, Grid, Kinds, Places, attached
from habilis.worlds.world import World

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def actions_of(world: World) -> tuple[str, ...]:
    """The names of the actions that there are in a world."""
    if not world.tools:
        return MOVES
    return (*ACTIONS, DROP_NAME) if world.drop else ACTIONS


def describe(
    world: World,
    grid: Grid,
    at: Places,
    next_state: Int32[np.ndarray, "S A"],
    start: int,
    failing: Int32[np.ndarray, "S A"] | None = None,
) -> TabularMDP:
    """The table of some of a world's placements, given where they lead.

    Args:
        world: the map.
        grid: its cells.
        at: the placements, one a state.
        next_state: int32[S, A].
        start: the state in which episodes begin.
        failing: int32[S, A], where they lead if the tool in hand fails; the table is stochastic
            then.
    """
    kinds = Kinds.of(world)
    held = [attached(grid, kinds, at, one) for one in range(len(at.objects))]
    terminal = np.ones(at.agent.shape, bool)
    for thing, cells in zip(world.objects, at.objects, strict=True):
        if thing.goal is not None:
            terminal &= cells == grid.index(thing.goal)
    cells = {"agent": at.agent}
    cells |= dict(zip(tool_factors(world), at.tools, strict=True))
    cells |= dict(zip(object_factors(world), at.objects, strict=True))
    factors = {name: grid.label(one).astype(np.int32) for name, one in cells.items()}
    if world.several and world.tools:
        factors[HELD] = at.held.astype(np.int32)
    if world.drop and at.laid is not None:
        factors[LAID] = at.laid.astype(np.int32)
    flags = {"equipped": at.held != NONE, "attached": np.logical_or.reduce(held)}
    if len(world.tools) > 1:
        flags |= {f"equipped:{t.name}": at.held == place for place, t in enumerate(world.tools)}
    entry_reward = entry_rewards(terminal)
    reward, transitions = entry_reward[next_state], next_state
    if failing is not None:
        fails = np.array([*(tool.slip for tool in world.tools), 0.0])[at.held]
        share = fails[:, None].astype(np.float32)
        reward = (1 - share) * reward + share * entry_reward[failing]
        transitions = _mixed(next_state, failing, fails)
    return TabularMDP(
        transitions=transitions,
        reward=reward,
        terminal=terminal,
        factors=factors,
        flags=flags,
        start=start,
        shape=(world.height, world.width),
        actions=actions_of(world),
        entry_reward=entry_reward,
    )


def entry_rewards(terminal: Bool[np.ndarray, "S"]) -> Float32[np.ndarray, "S"]:
    """Rule 6 of the worlds: 0 for what ends an episode, -1 for all else."""
    return -(~terminal).astype(np.float32)


def _mixed(
    works: Int32[np.ndarray, "S A"],
    fails: Int32[np.ndarray, "S A"],
    share: Float64[np.ndarray, "S"],
) -> "csr_array":
    """Transitions to one table's states, or with some probability to another's."""
    from scipy.sparse import csr_array

    states, actions = works.shape
    rows = np.tile(np.arange(states * actions), 2)
    columns = np.concatenate([works.ravel(), fails.ravel()])
    each = np.repeat(share, actions)
    mixed = csr_array(
        (np.concatenate([1 - each, each]), (rows, columns)), (states * actions, states)
    )
    mixed.sum_duplicates()
    mixed.eliminate_zeros()
    return mixed
