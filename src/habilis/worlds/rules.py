"""The rule that moves things, written once, over arrays of placements."""

from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import combinations

import numpy as np

from habilis.worlds.grid import MOVES, STEPS, Cell, Cells, Flags, Grid
from habilis.worlds.things import OBJECTS, ObjectKind
from habilis.worlds.tool_calls import call_in_hand
from habilis.worlds.tools import Reading, Tool
from habilis.worlds.world import World
from habilis.worlds.world_checks import check_one_agent

ACTIONS = (*MOVES, *(f"tool {side}" for side in MOVES))
"""Names of the actions in their order: 0 to 3 move the agent, 4 to 7 put the tool on a side."""
DROP, DROP_NAME = len(ACTIONS), "drop"
"""The action that puts the tool down, in worlds that have it."""
NONE = -1
"""No tool, where a tool is given by its place among them."""

Way = tuple[tuple[Cell, ...], tuple[tuple[Cell, tuple[Cell, ...]], ...]]
"""Cells that a tool crosses, and for each cell of what it may hold the cells that this crosses."""


@dataclass(frozen=True)
class Kinds:
    """The kinds of a world's things, which decide how they move."""

    tools: tuple[Tool, ...]
    objects: tuple[ObjectKind, ...]
    readings: tuple[Reading, ...]

    @classmethod
    def of(cls, world: World) -> "Kinds":
        check_one_agent(world)
        return cls(
            tuple(tool.rule for tool in world.tools),
            tuple(OBJECTS[thing.kind] for thing in world.objects),
            tuple(tool.reading for tool in world.tools),
        )


@dataclass(frozen=True)
class Places:
    """Where everything is, in one placement an entry.

    Attributes:
        agent: its cells.
        tools, objects: those of each tool and object.
        held: which tool is in hand; -1 for none.
        laid: which tool was put down and not left since; -1 for none.
    """

    agent: Cells
    tools: tuple[Cells, ...]
    objects: tuple[Cells, ...]
    held: Cells
    laid: Cells | None = None

    @classmethod
    def of(
        cls,
        grid: Grid,
        agent: Cells,
        tools: tuple[Cells, ...],
        objects: tuple[Cells, ...],
        drop: bool = False,
    ) -> "Places":
        """With the first tool beside the agent in hand."""
        none = np.full(np.shape(agent), NONE)
        return taken_up(grid, cls(agent, tools, objects, none, none if drop else None))

    @property
    def cells(self) -> tuple[Cells, ...]:
        """Of agent, tools and objects."""
        return self.agent, *self.tools, *self.objects

    def part(self, which: slice) -> "Places":
        """Some of the placements."""
        return Places(
            self.agent[which],
            tuple(cells[which] for cells in self.tools),
            tuple(cells[which] for cells in self.objects),
            self.held[which],
            None if self.laid is None else self.laid[which],
        )


def successor(grid: Grid, kinds: Kinds, action: int, at: Places, works: bool = True) -> Places:
    """Where everything is after one action: rules 1 to 5 of the worlds.

    Args:
        grid: the map.
        kinds: how tools and objects move.
        action: 0 to 3 move the agent north, east, south, west; 4 to 7 put the tool there; 8 puts
            it down.
        at: where everything is before.
        works: whether the tool in hand does to objects what it does.

    Returns:
        Where everything is; unchanged wherever something would have come onto a wall or onto
        another thing. What is taken up then, `taken_up` says.

    Raises:
        ValueError: a tool does not answer as a tool must.
    """
    if action == DROP:
        laid = at.held if at.laid is None else np.where(at.held == NONE, at.laid, at.held)
        return replace(at, held=np.full_like(at.held, NONE), laid=laid)
    step = grid.steps[action % 4]
    carried = action < len(MOVES)
    agent = at.agent + step if carried else at.agent
    tools = tuple(
        np.where(at.held == index, (tool if carried else at.agent) + step, tool)
        for index, tool in enumerate(at.tools)
    )
    to = replace(at, agent=agent, tools=tools)
    objects = [_moved(grid, kinds, action, at, to, one, works) for one in range(len(at.objects))]
    to = replace(to, objects=tuple(objects))
    stays = _clash(grid, to.cells)
    if not carried:
        stays |= _stopped(grid, kinds, action, at, works)
    for one, kind in enumerate(kinds.objects):
        if kind.slides:
            objects[one] = _slid(grid, kinds, at, to, one, ~stays)
            to = replace(to, objects=tuple(objects))
    return replace(
        to,
        agent=np.where(stays, at.agent, to.agent),
        tools=_unless(stays, at.tools, to.tools),
        objects=_unless(stays, at.objects, to.objects),
    )


def taken_up(grid: Grid, at: Places) -> Places:
    """The same with the first tool beside the agent in hand, where none is (rule 1).

    A tool that was put down has to be left first.
    """
    held, laid = at.held, at.laid
    if laid is not None:
        left = np.ones(laid.shape, bool)
        for index, tool in enumerate(at.tools):
            left &= ~((laid == index) & grid.adjacent(at.agent, tool))
        laid = np.where(left, NONE, laid)
    for index in reversed(range(len(at.tools))):
        taken = (at.held == NONE) & grid.adjacent(at.agent, at.tools[index])
        if laid is not None:
            taken &= laid != index
        held = np.where(taken, index, held)
    return replace(at, held=held, laid=laid)


def attached(grid: Grid, kinds: Kinds, at: Places, one: int) -> Flags:
    """Whether an object goes wherever the tool in hand goes (rule 4)."""
    found = np.zeros(at.held.shape, bool)
    if kinds.objects[one].pulled:
        for index, rule in enumerate(kinds.tools):
            places = at.agent, at.tools[index], at.objects[one]
            held = at.held == index
            found = call_in_hand(grid, rule, "attached", places, where=held, elsewhere=found)
            found |= _sideways(grid, kinds, at, index, one)
    return found


def _sideways(grid: Grid, kinds: Kinds, at: Places, index: int, one: int) -> Flags | bool:
    """Whether an object is held that stands beside the tool, not in line with the agent."""
    if not (kinds.readings[index].sticky and getattr(kinds.tools[index], "holds", False)):
        return False
    tool, thing = at.tools[index], at.objects[one]
    in_line = thing - tool == tool - at.agent
    return (at.held == index) & grid.adjacent(tool, thing) & ~in_line


def _moved(
    grid: Grid, kinds: Kinds, action: int, at: Places, to: Places, one: int, works: bool
) -> Cells:
    """Where an object is when agent and tool have gone from `at` to `to`."""
    carried, step = action < len(MOVES), grid.steps[action % 4]
    thing = at.objects[one]
    new = thing
    for index, rule in enumerate(kinds.tools if works else ()):
        seen = None
        if getattr(rule, "sees", False):
            others = (*at.tools[:index], *at.tools[index + 1 :], *at.objects)
            seen = _ahead(grid, to.tools[index], step, others)
        method = "carry" if carried else "swing"
        places, held = (at.agent, at.tools[index], thing), at.held == index
        new = call_in_hand(grid, rule, method, places, step, where=held, elsewhere=new, seen=seen)
        beside = _sideways(grid, kinds, at, index, one)
        if np.any(beside):
            with_it = thing + step if carried else _turned(at, index, one, step)
            new = np.where(beside, with_it, new)
    if not kinds.objects[one].pulled:
        pushed = (new == thing + step) & _is_ahead(grid, at.agent, thing, step)
        new = np.where(carried & pushed & ~_held_fast(grid, kinds, at, one), new, thing)
    for tool, reading in zip(to.tools if works else (), kinds.readings, strict=False):
        if reading.pushes if carried else reading.shoves:
            # What is held has gone elsewhere by now, and a tool that lies cannot meet anything.
            new = np.where((tool == thing) & (new == thing), thing + step, new)
    return np.where(to.agent == thing, thing + step, new) if carried else new


def _turned(at: Places, index: int, one: int, step: int) -> Cells:
    """Where an object that is held beside a tool goes when that is put on a side of the agent."""
    arm = at.tools[index] - at.agent
    off = at.objects[one] - at.tools[index]
    quarter = at.agent + step + np.where(step == off, -arm, arm)
    quarter = np.where(step == arm, at.objects[one], quarter)
    return np.where(step == -arm, at.agent - arm - off, quarter)


def _stopped(grid: Grid, kinds: Kinds, action: int, at: Places, works: bool) -> Flags:
    """Whether a wall is in the way of a tool that is put on a side, or of what it holds.

    A tool that comes to the opposite side may go either way round.
    """
    found = np.zeros(at.held.shape, bool)
    sweeping = [index for index, reading in enumerate(kinds.readings) if reading.sweeps]
    objects = range(len(at.objects)) if works and sweeping else ()
    held = [attached(grid, kinds, at, one) for one in objects]
    for index in sweeping:
        for arm, step in enumerate(grid.steps):
            turning = (at.held == index) & (at.tools[index] == at.agent + step)
            free = np.zeros(at.held.shape, bool)
            for cells, with_it in ways_round(arm, action % len(MOVES)):
                hit = _any_wall(grid, at.agent, cells)
                for one, is_held in zip(objects, held, strict=True):
                    for (row, column), more in with_it:
                        there = at.objects[one] == at.agent + row * grid.stride + column
                        hit |= is_held & there & _any_wall(grid, at.agent, more)
                free |= ~hit
            found |= turning & ~free
    return found


def _any_wall(grid: Grid, agent: Cells, offsets: tuple[Cell, ...]) -> Flags:
    found = np.zeros(agent.shape, bool)
    for row, column in offsets:
        found |= grid.wall[agent + row * grid.stride + column]
    return found


@lru_cache
def ways_round(arm: int, side: int) -> tuple[Way, ...]:
    """The ways in which a tool comes from one side of the agent to another, turning about it.

    Args:
        arm, side: from where and to where: 0 to 3 for north, east, south, west.

    Returns:
        One way, or two to the opposite side. Of each the cells, from the agent's, whose squares the
        middle of the tool crosses; and with every cell in which something may be that is held,
        those whose squares its middle crosses then.
    """
    row, column = STEPS[arm]
    beside = [(row + r, column + c) for r, c in STEPS if abs(r) != abs(row)]
    quarters = (side - arm + 1) % 4 - 1
    return tuple(
        (
            _arc((row, column), turn),
            tuple((off, _arc(off, turn)) for off in ((2 * row, 2 * column), *beside)),
        )
        for turn in ((2, -2) if quarters == 2 else (quarters,))
    )


def _arc(off: Cell, quarters: int) -> tuple[Cell, ...]:
    """The cells whose squares a point crosses that turns clockwise about the agent."""
    angles = np.linspace(0, quarters * np.pi / 2, 1 + 90 * abs(quarters))
    rows = off[0] * np.cos(angles) + off[1] * np.sin(angles)
    columns = off[1] * np.cos(angles) - off[0] * np.sin(angles)
    points = np.rint(np.stack([rows, columns], axis=1)).astype(int)
    return tuple(dict.fromkeys((int(row), int(column)) for row, column in points))


def _held_fast(grid: Grid, kinds: Kinds, at: Places, one: int) -> Flags:
    """Whether the tool in hand would hold an object if it could be held."""
    held = tuple(replace(kind, pulled=True) for kind in kinds.objects)
    return attached(grid, replace(kinds, objects=held), at, one)


def _slid(grid: Grid, kinds: Kinds, at: Places, to: Places, one: int, free: Flags) -> Cells:
    """Where an object that was set going stops."""
    was, new = at.objects[one], to.objects[one]
    way = np.where(free & ~attached(grid, kinds, at, one), new - was, 0)
    goes = np.isin(way, grid.steps)
    others = to.agent, *to.tools, *to.objects[:one], *to.objects[one + 1 :]
    way = way[goes]
    stopped = new.copy()
    stopped[goes] = _ahead(grid, new[goes], way, tuple(cells[goes] for cells in others)) - way
    return stopped


def _ahead(grid: Grid, cells: Cells, step: Cells | int, things: tuple[Cells, ...]) -> Cells:
    """The first cell straight on from some that holds a wall or a thing."""
    cells = cells + step
    while True:
        taken = grid.wall[cells]
        for thing in things:
            taken |= cells == thing
        if taken.all():
            return cells
        cells = np.where(taken, cells, cells + step)


def _is_ahead(grid: Grid, agent: Cells, thing: Cells, step: int) -> Flags:
    """Whether a step in this direction leads no closer to a thing's own side of the agent."""
    row, column = np.divmod(agent, grid.stride)
    its_row, its_column = np.divmod(thing, grid.stride)
    return (
        ((its_row - row) * np.sign(step)) if abs(step) > 1 else (its_column - column) * step
    ) >= 0


def _clash(grid: Grid, cells: tuple[Cells, ...]) -> Flags:
    """Where one of these is on a wall, or on another."""
    found = grid.wall[cells[0]]
    for one in cells[1:]:
        found |= grid.wall[one]
    for one, other in combinations(cells, 2):
        found |= one == other
    return found


def _unless(stays: Flags, old: tuple[Cells, ...], new: tuple[Cells, ...]) -> tuple[Cells, ...]:
    return tuple(np.where(stays, one, other) for one, other in zip(old, new, strict=True))
