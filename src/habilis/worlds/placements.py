"""Placements of a world's things: in words, as arrays, and as the states of a table."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32

from habilis.mdp import HELD, LAID, TabularMDP
from habilis.worlds.grid import Cells
from habilis.worlds.rules import ACTIONS, DROP_NAME, MOVES, NONE, Kinds, Places, attached
from habilis.worlds.things import moved
from habilis.worlds.world import Cell, World
from habilis.worlds.world_checks import check_one_agent

if TYPE_CHECKING:
    from scipy.sparse import csr_array

Placement = Mapping[str, Any]
"""The cells of "agent", "object" and, in a world with a tool, "tool"; of several things by name, as
"object:can", and perhaps which tool is "held" and which was "laid" down and not left since: its
place among the tools, -1 for none."""

WANTED = (
    "states has {!r}; of a world, give placements such as {{'agent': (0, 0), 'object': (2, 2)}}"
)


@dataclass(frozen=True)
class Factors:
    """The names of a world's factors, besides "agent".

    Attributes:
        tools, objects: of the cell of each tool and object.
        hands: of which tool is in hand, and of which was put down and not left since.
    """

    tools: tuple[str, ...]
    objects: tuple[str, ...]
    hands: tuple[str, ...]

    @classmethod
    def of(cls, world: World) -> "Factors":
        check_one_agent(world)
        if world.single:  # the tool is in hand wherever it is beside the agent
            return cls(("tool",) * len(world.tools), ("object",), ())
        held, laid = (HELD,) if world.tools else (), (LAID,) if world.drop else ()
        return cls(
            tuple(f"tool:{tool.name}" for tool in world.tools),
            tuple(f"object:{thing.name}" for thing in world.objects),
            held + laid,
        )

    @property
    def things(self) -> tuple[str, ...]:
        """Those of the tools and objects."""
        return *self.tools, *self.objects


def start_of(world: World) -> dict[str, Cell]:
    """The placement that the map has."""
    things = (*world.tools, *world.objects)
    cells = zip(Factors.of(world).things, (thing.cell for thing in things), strict=True)
    return {"agent": world.agent, **dict(cells)}


def placed_at(world: World, placement: Placement) -> World:
    """The same map with its things where a placement has them, and that tool in hand.

    Raises:
        ValueError: a cell that is not free.
    """
    factors = Factors.of(world)
    return replace(
        world,
        agent=placement["agent"],
        tools=moved(world.tools, [placement[name] for name in factors.tools]),
        objects=moved(world.objects, [placement[name] for name in factors.objects]),
        held=placement.get(HELD),
    )


def places_of(world: World, placements: list[Any]) -> Places:
    """Placements as arrays, the first tool beside the agent in hand where they do not say which.

    Raises:
        ValueError: one that is none.
    """
    factors = Factors.of(world)
    names = ["agent", *factors.things]
    cells = [_checked(world, names, factors.hands, placement) for placement in placements]
    columns = np.array([[world.grid.index(cell) for cell in one] for one in cells], np.int64)
    at = _arrays(world, *columns.reshape(len(cells), len(names)).T)
    if HELD in factors.hands:
        held = [_tool(world, HELD, placement) for placement in placements]
        held = np.where([one is None for one in held], at.held, [one or 0 for one in held])
        at = replace(at, held=held)
    if LAID in factors.hands:
        laid = [_tool(world, LAID, placement) for placement in placements]
        at = replace(at, laid=np.array([NONE if one is None else one for one in laid]))
    return at


def with_agents(world: World, things: Mapping[str, Cell], agents: Sequence[Cell]) -> Places:
    """The same placement of all things with the agent in each of some cells, as arrays.

    Args:
        world: the map.
        things: the cells of the tools and objects, each another.
        agents: free cells, which nothing else is in.

    Raises:
        ValueError: a thing's cell that is not free.
    """
    cells = [_cell(world, name, things[name]) for name in Factors.of(world).things]
    agent = world.grid.index(np.array(agents, np.int64).reshape(-1, 2).T)
    columns = [np.full(agent.shape, world.grid.index(cell), np.int64) for cell in cells]
    return _arrays(world, agent, *columns)


def actions_of(world: World) -> tuple[str, ...]:
    """The names of the actions that there are in a world."""
    if not world.tools:
        return MOVES
    return (*ACTIONS, DROP_NAME) if world.drop else ACTIONS


def describe(
    world: World,
    at: Places,
    next_state: Int32[np.ndarray, "S A"],
    start: int,
    failing: Int32[np.ndarray, "S A"] | None = None,
) -> TabularMDP:
    """The table of some of a world's placements, given where they lead.

    Args:
        world: the map.
        at: the placements, one a state.
        next_state: int32[S, A].
        start: the state in which episodes begin.
        failing: int32[S, A], where they lead if the tool in hand fails; the table is stochastic
            then.
    """
    grid, kinds, names = world.grid, Kinds.of(world), Factors.of(world)
    held = [attached(grid, kinds, at, one) for one in range(len(at.objects))]
    terminal = np.ones(at.agent.shape, bool)
    for thing, cells in zip(world.objects, at.objects, strict=True):
        if thing.goal is not None:
            terminal &= cells == grid.index(thing.goal)
    cells = zip(("agent", *names.things), at.cells, strict=True)
    factors = {name: grid.label(one).astype(np.int32) for name, one in cells}
    hands = {HELD: at.held, LAID: at.laid}
    factors |= {name: np.asarray(hands[name], np.int32) for name in names.hands}
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
        drawn=world,
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


def _arrays(world: World, agent: Cells, *things: Cells) -> Places:
    """Placements with the first tool beside the agent in hand."""
    tools = len(world.tools)
    return Places.of(world.grid, agent, things[:tools], things[tools:], world.drop)


def _checked(world: World, names: list[str], hands: tuple[str, ...], placement: Any) -> list[Cell]:
    """The cells of a placement, if it is one."""
    if not isinstance(placement, Mapping):
        raise ValueError(WANTED.format(placement))
    if set(placement) - set(hands) != set(names):
        raise ValueError(
            f"a placement has {', '.join(map(str, placement)) or 'nothing'}; "
            f"{world.name} has {', '.join(names)}: give a cell for each of them"
        )
    cells = [_cell(world, name, placement[name]) for name in names]
    if len(set(cells)) < len(cells):
        raise ValueError(f"a placement has two things in one cell, {dict(placement)}")
    return cells


def _tool(world: World, name: str, placement: Mapping[str, Any]) -> int | None:
    """Which tool is in hand, or was put down, if a placement says that."""
    place = placement.get(name)
    if place is None or place == NONE:
        return place
    if not isinstance(place, int) or not 0 <= place < len(world.tools):
        raise ValueError(
            f"{name} is {place!r}; give a tool's place among {len(world.tools)}, from 0, or {NONE}"
        )
    (row, column), (agent_row, agent_column) = (
        placement[name] for name in (Factors.of(world).tools[place], "agent")
    )
    if abs(row - agent_row) + abs(column - agent_column) != 1:
        raise ValueError(
            f"the {world.tools[place].name} is {name} and not beside the agent; put it there"
        )
    return place


def _cell(world: World, name: str, cell: Any) -> Cell:
    try:
        row, column = (int(part) for part in cell)
    except (TypeError, ValueError):
        raise ValueError(f"the {name}'s cell is {cell!r}; give (row, column)") from None
    if not world.is_free((row, column)):
        inside = (row, column) in world.walls
        where = "a wall" if inside else f"outside the {world.height} x {world.width} cells"
        raise ValueError(f"the {name}'s cell {(row, column)} is {where}; give a free one")
    return row, column
