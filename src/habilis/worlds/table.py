"""From a world to its table."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Int32

from habilis.mdp import TabularMDP
from habilis.models.explore import AnyModel, explore, explored
from habilis.models.limits import Limits
from habilis.progress import progress_bar
from habilis.worlds import two_agents
from habilis.worlds.grid import Cells, Grid
from habilis.worlds.placements import (
    Factors,
    Placement,
    actions_of,
    describe,
    entry_rewards,
    placed_at,
    start_of,
)
from habilis.worlds.reach import MAX_STATES, TooManyPlacementsError, reachable
from habilis.worlds.rules import Kinds, Places, successor
from habilis.worlds.world import World

_BLOCK = 1 << 14  # placements moved at once: the arrays of one block stay in the cache
_MORE = "or raise max_states if there is memory for it"


def tabulate(
    world: World,
    slip: float = 0.0,
    *,
    starts: Sequence[Placement] | None = None,
    max_states: int = MAX_STATES,
    show_progress: bool = False,
) -> TabularMDP:
    r"""Every placement of agent, tool and object, and where each action leads from it.

    The states are all placements with the tool in hand, and all with the tool lying at its
    cell of the map; without a tool, all placements of agent and object. Reward and end of an
    episode are rule 6 of the worlds: 0 for the transition that brings the object into the
    goal, which ends the episode, and -1 for every other.

    In a world of several tools or objects, or of two agents, the states are all placements that
    can be reached from the map's, and an episode ends when every object that has a goal is in it.
    Two agents are the `players` "agent" and "agent2"; without goals rewards are 0.

    Args:
        world: the map; its tool decides on eight actions, or four without one; nine where it can
            be put down.
        slip: the probability that the chosen action is replaced by one drawn uniformly from
            all (rule 7); above 0 the table is stochastic.
        starts: in place of the map's own placement those from which others are reached, as in
            `reachable`; the first is the table's start.
        max_states: how many placements to accept; each takes about 80 bytes, and 190 while the
            table is made.
        show_progress: whether to draw a progress bar on standard error, once it takes two seconds.

    Returns:
        A table with factors "agent", "object" and, unless the tool is "none", "tool"; flags
        "equipped" and "attached"; the map's placement as `start`. Of several tools and objects the
        factors are "tool:picker", "object:can", and so on; "held", which tool is in hand, from 0
        as in `World.tools`, -1 for none; and where tools can be put down "laid", which of them was
        put down and not left since. Of several tools each has a flag, "equipped:picker" and so on.
        Of two agents, "agent2" is the other's cell, and "door" (then "door2", ...) 1 where one is
        open.

    Raises:
        ValueError: slip is no probability.
        TooManyPlacementsError: a ValueError: the map has more placements than max_states.

    Example:
        >>> from habilis.worlds.world import World
        >>> tabulate(World.parse("A.CG", name="line")).actions
        ('north', 'east', 'south', 'west')
        >>> several = World.parse("D = ball\nH = goal of D\nG = goal of C\nA.CG\nP.DH")
        >>> list(tabulate(several).factors)
        ['agent', 'tool:picker', 'object:can', 'object:ball', 'held']
    """
    if starts is not None or not world.single:
        if starts is None:
            starts = [_start_of(world)]
        try:
            reached = reachable(world, starts, None, max_states, show_progress)[0]
        except TooManyPlacementsError as error:
            raise TooManyPlacementsError(f"{error}, {_MORE}") from None
        return reached.slippery(slip)
    return _whole(world, max_states, show_progress).slippery(slip)


def _start_of(world: World) -> dict[str, Any]:
    """The placement that the map has, of one agent or of two."""
    return start_of(world) if world.second is None else two_agents.start_of(world)


def whole_table(model: AnyModel, show_progress: bool = False) -> TabularMDP:
    """A table as it is; of a world or another model the table of all its states."""
    if isinstance(model, TabularMDP):
        return model
    if isinstance(model, World):
        return tabulate(model, show_progress=show_progress)
    return explore(model, show_progress=show_progress)


@explored.register
def _(
    world: World, states: Sequence[Placement] | None, limits: Limits, show_progress: bool
) -> TabularMDP:
    """`explore` of a world: whole as `tabulate` has it, or what can be reached from placements."""
    most = limits.max_states
    if limits.horizon is None:
        return tabulate(world, starts=states, max_states=most, show_progress=show_progress)
    starts = [_start_of(world)] if states is None else states
    return reachable(world, starts, limits.horizon, most, show_progress)[0]


def placements(world: World) -> int:
    """How many placements a world with one object and at most one tool has at most."""
    return len(_hands(world)) * len(world.grid.free)


def _whole(world: World, max_states: int, show_progress: bool = False) -> TabularMDP:
    """The table of a world with one object and at most one tool, all placements in it."""
    grid, kinds, hands = world.grid, Kinds.of(world), _hands(world)
    most = len(hands) * len(grid.free)
    if most > max_states:
        raise ValueError(
            f"{world.name}: {most:,} placements are more than {max_states:,}; "
            f"make the map smaller, {_MORE}"
        )
    state_of = np.full((len(hands), len(grid.wall)), -1, np.int32)
    in_hand = (hands[:, :, None] == grid.free).any(axis=1)
    state_of[:, grid.free] = np.where(in_hand, -1, 0)
    hand, thing = np.nonzero(state_of == 0)
    state_of[hand, thing] = np.arange(len(hand), dtype=np.int32)
    hand_of = np.full((len(grid.wall), len(grid.wall)), -1, np.int32)
    hand_of[hands[:, 0], hands[:, 1]] = np.arange(len(hands))
    tools = [hands[hand, 1]] if world.tools else []
    at = Places.of(grid, hands[hand, 0], tuple(tools), (thing,))

    actions, works = len(actions_of(world)), [True, False] if world.may_fail else [True]
    with progress_bar("placements", show_progress) as report:
        ways = [_led(grid, kinds, at, state_of, hand_of, actions, way, report) for way in works]
    tool = grid.index(world.tools[0].cell) if world.tools else grid.nowhere
    start = state_of[hand_of[grid.index(world.agent), tool], grid.index(world.object)]
    return describe(world, at, ways[0], int(start), *ways[1:])


def _led(
    grid: Grid,
    kinds: Kinds,
    at: Places,
    state_of: Int32[np.ndarray, "hands cells"],
    hand_of: Int32[np.ndarray, "cells cells"],
    actions: int,
    works: bool,
    report: Callable[[int, int], None],
) -> Int32[np.ndarray, "S A"]:
    """The state that each action leads to."""
    next_state = np.empty((len(at.agent), actions), np.int32)
    for first in range(0, len(at.agent), _BLOCK):
        block = slice(first, first + _BLOCK)
        part = at.part(block)
        for action in range(actions):
            to = successor(grid, kinds, action, part, works)
            tool = to.tools[0] if to.tools else grid.nowhere
            next_state[block, action] = state_of[hand_of[to.agent, tool], to.objects[0]]
        report(first + len(part.agent), len(at.agent))
    return next_state


def restarted(mdp: TabularMDP, world: World) -> TabularMDP:
    """The table of a world from that of another with the same walls, tool and place of the tool.

    Only the goal, and where agent and object start, may be others.
    """
    terminal = mdp.factor("object") == mdp.label(world.goal)
    entry_reward = entry_rewards(terminal)
    return replace(
        mdp,
        terminal=terminal,
        reward=entry_reward[mdp.next_state],
        entry_reward=entry_reward,
        start=mdp.find(**start_of(world)),
        drawn=world,
    )


def placement(world: World, mdp: TabularMDP, state: int | np.integer) -> World:
    """A state as a world: the same map with its things where the state has them.

    Args:
        world: the map.
        mdp: its table.
        state: the state's index.

    Returns:
        Another world. Its own table begins with the first tool beside the agent in hand, whatever
        the state had.
    """
    if world.second is not None:
        return two_agents.placement_of_two(world, mdp, state)
    names = Factors.of(world)
    found: dict[str, Any] = {name: int(mdp.factor(name)[state]) for name in names.hands}
    for name in ("agent", *names.things):
        found[name] = divmod(int(mdp.factor(name)[state]), world.width)
    return placed_at(world, found)


def _hands(world: World) -> Cells:
    """All (agent, tool) cells, int[pairs, 2]: first the tool lying, then in hand by side."""
    grid, free = world.grid, world.grid.free
    if not world.tools:
        return np.stack([free, np.full_like(free, grid.nowhere)], axis=1)
    lies = np.full_like(free, grid.index(world.tools[0].cell))
    apart = (free != lies) & ~grid.adjacent(free, lies)
    pairs = [np.stack([free, lies], axis=1)[apart]]
    for step in grid.steps:
        held = np.stack([free, free + step], axis=1)
        pairs.append(held[~grid.wall[free + step]])
    return np.concatenate(pairs)
