"""A world's table has every placement once, says where things are, and finds them again."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from rooms import rooms, sizes

from habilis.mdp import TabularMDP
from habilis.worlds.rules import ACTIONS
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World, load_world

Placement = tuple[Cell, ...]

ROOM = World.parse(
    """
    A..#.
    .P.C.
    #...G
    """.replace(" ", ""),
    name="room",
)
CELLAR = World.parse("A#C\n#P#\nG#.", name="cellar")
"""No two free cells are side by side."""


WORLDS = rooms(sizes(range(2, 5), range(2, 6)), lambda cells: cells)


def next_to_each_other(one: Cell, other: Cell) -> bool:
    return abs(one[0] - other[0]) + abs(one[1] - other[1]) == 1


def placements(world: World) -> set[Placement]:
    """(agent, object), or (agent, object, tool): the states that the design asks for."""
    cells = set(product(range(world.height), range(world.width))) - world.walls
    if world.tool == "none":
        return {(agent, can) for agent, can in product(cells, repeat=2) if agent != can}
    return {
        (agent, can, tool)
        for agent, can, tool in product(cells, repeat=3)
        if len({agent, can, tool}) == 3
        and (tool == world.tool_cell or next_to_each_other(agent, tool))
    }


def states(mdp: TabularMDP) -> list[Placement]:
    """Every state's cells, in the order of the states."""
    assert mdp.shape is not None
    names = [name for name in ("agent", "object", "tool") if name in mdp.factors]
    cells = [zip(*np.divmod(mdp.factor(name), mdp.shape[1]), strict=True) for name in names]
    return [
        tuple((int(row), int(column)) for row, column in placement)
        for placement in zip(*cells, strict=True)
    ]


# Which states there are


@settings(deadline=None)
@given(WORLDS)
def test_the_states_are_the_placements_with_the_tool_in_hand_or_lying_each_once(world: World):
    found = states(tabulate(world))
    assert len(found) == len(set(found))
    assert set(found) == placements(world)


@pytest.mark.parametrize(("name", "tool"), [("corridor", "picker"), ("yard", "none")])
def test_the_states_of_a_built_in_world_are_those_counted_by_hand(name: str, tool: str):
    world = load_world(name, tool)
    mdp = tabulate(world)
    free = world.height * world.width - len(world.walls)
    cells = set(product(range(world.height), range(world.width))) - world.walls
    if tool == "none":
        assert mdp.states == free * (free - 1)
        return
    in_hand = sum(next_to_each_other(one, other) for one, other in product(cells, repeat=2))
    assert world.tool_cell is not None
    apart = sum(not next_to_each_other(cell, world.tool_cell) for cell in cells) - 1
    assert mdp.states == (in_hand + apart) * (free - 2)


def test_a_tool_that_there_is_no_room_to_hold_lies_in_every_state():
    mdp = tabulate(CELLAR)
    assert (mdp.factor("tool") == 1 * 3 + 1).all()
    assert mdp.states == 4 * 3
    assert not mdp.flags["equipped"].any()


def test_every_successor_is_a_state():
    for world in (ROOM, ROOM.with_tool("broom"), ROOM.with_tool("none"), load_world("yard")):
        mdp = tabulate(world)
        assert mdp.next_state.min() >= 0
        assert mdp.next_state.max() < mdp.states


# What they say


def test_a_factor_is_the_row_times_the_width_plus_the_column():
    mdp = tabulate(ROOM)
    assert mdp.shape == (3, 5)
    assert mdp.factor("agent")[mdp.start] == 0
    assert mdp.factor("tool")[mdp.start] == 1 * 5 + 1
    assert mdp.factor("object")[mdp.start] == 1 * 5 + 3
    free = [0, 1, 2, 4, 5, 6, 7, 8, 9, 11, 12, 13, 14]
    for name in ("agent", "tool", "object"):
        assert sorted(set(mdp.factor(name))) == free


@settings(deadline=None)
@given(WORLDS)
def test_equipped_is_to_have_the_tool_in_the_next_cell(world: World):
    mdp = tabulate(world)
    for state, (agent, _, *tool) in enumerate(states(mdp)):
        assert mdp.flags["equipped"][state] == any(next_to_each_other(agent, t) for t in tool)


@settings(deadline=None)
@given(WORLDS)
def test_attached_is_to_have_agent_picker_and_can_in_line(world: World):
    mdp = tabulate(world)
    for state, (agent, can, *tools) in enumerate(states(mdp)):
        in_line = any(
            next_to_each_other(agent, tool)
            and can == (2 * tool[0] - agent[0], 2 * tool[1] - agent[1])
            for tool in tools
        )
        assert mdp.flags["attached"][state] == (in_line and world.tool == "picker")


@settings(deadline=None)
@given(WORLDS)
def test_the_terminal_states_are_those_with_the_can_in_the_goal(world: World):
    mdp = tabulate(world)
    assert [can == world.goal for _, can, *_ in states(mdp)] == mdp.terminal.tolist()


@settings(deadline=None)
@given(WORLDS)
def test_episodes_begin_as_the_map_is_drawn(world: World):
    mdp = tabulate(world)
    drawn = [world.agent, world.object, world.tool_cell]
    assert states(mdp)[mdp.start] == tuple(drawn if "tool" in mdp.factors else drawn[:2])


def test_with_a_tool_there_are_eight_actions_and_without_four():
    eight = ("north", "east", "south", "west")
    eight += ("tool north", "tool east", "tool south", "tool west")
    for tool in ("picker", "broom"):
        mdp = tabulate(ROOM.with_tool(tool))
        assert mdp.actions == eight == ACTIONS
        assert mdp.next_state.shape == mdp.reward.shape == (mdp.states, 8)
    mdp = tabulate(ROOM.with_tool("none"))
    assert mdp.actions == eight[:4]
    assert mdp.next_state.shape == mdp.reward.shape == (mdp.states, 4)


def test_without_a_tool_the_table_knows_of_none():
    mdp = tabulate(ROOM.with_tool("none"))
    assert set(mdp.factors) == {"agent", "object"}
    assert not mdp.flags["equipped"].any()
    assert not mdp.flags["attached"].any()
    with pytest.raises(ValueError, match="'tool' is unknown; this MDP has: agent, object"):
        mdp.factor("tool")


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
def test_the_arrays_have_the_types_that_are_promised(tool: str):
    mdp = tabulate(ROOM.with_tool(tool))
    assert mdp.next_state.dtype == np.int32
    assert mdp.reward.dtype == np.float32
    assert mdp.terminal.dtype == bool
    for labels in mdp.factors.values():
        assert (labels.dtype, labels.shape) == (np.int32, (mdp.states,))
    for flags in mdp.flags.values():
        assert (flags.dtype, flags.shape) == (bool, (mdp.states,))


# Finding


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
def test_every_state_is_found_by_its_cells(tool: str):
    mdp = tabulate(ROOM.with_tool(tool))
    names = ("agent", "object", "tool")
    for state, cells in enumerate(states(mdp)):
        assert mdp.find(**dict(zip(names, cells, strict=False))) == state


def test_a_few_cells_are_enough_where_they_leave_one_state():
    mdp = tabulate(World.parse("ACG"))
    assert mdp.find(agent=(0, 0), object=(0, 1)) == mdp.start
    mdp = tabulate(CELLAR)
    assert mdp.find(agent=(0, 0), object=(0, 2)) == mdp.start


@pytest.mark.parametrize(
    "cells",
    [
        pytest.param({"agent": (0, 3), "object": (1, 3), "tool": (1, 1)}, id="in a wall"),
        pytest.param({"agent": (1, 1), "object": (1, 3), "tool": (1, 1)}, id="two in a cell"),
        pytest.param({"agent": (0, 0), "object": (1, 3), "tool": (2, 3)}, id="tool elsewhere"),
        pytest.param({"agent": (3, 0), "object": (1, 3), "tool": (1, 1)}, id="below the map"),
        pytest.param({"agent": (-1, 5), "object": (1, 3), "tool": (1, 1)}, id="above the map"),
        pytest.param({"agent": (0, 5), "object": (1, 3), "tool": (1, 1)}, id="right of the map"),
        pytest.param({"agent": (1, -1), "object": (1, 3), "tool": (1, 1)}, id="left of the map"),
    ],
)
def test_cells_that_no_state_has_are_not_found(cells: dict[str, Cell]):
    with pytest.raises(KeyError, match="no states have agent="):
        tabulate(ROOM).find(**cells)


def test_cells_that_several_states_have_do_not_name_one():
    with pytest.raises(KeyError, match=r"\d+ states have agent=.*, object=\(1, 3\); give tool too"):
        tabulate(ROOM.with_tool("broom")).find(agent=(0, 0), object=(1, 3))
    with pytest.raises(KeyError):
        tabulate(ROOM).find()


def test_a_thing_that_a_world_does_not_have_cannot_be_found():
    with pytest.raises(ValueError, match="'spoon' is unknown; this MDP has: agent, tool, object"):
        tabulate(ROOM).find(spoon=(0, 0))
    with pytest.raises(ValueError, match="'tool' is unknown; this MDP has: agent, object"):
        tabulate(ROOM.with_tool("none")).find(agent=(0, 0), tool=(1, 1), object=(1, 3))


def test_more_placements_than_the_limit_are_refused_before_they_are_made():
    rows = [["."] * 100 for _ in range(100)]
    rows[0][:4] = "APCG"
    world = World.parse("\n".join(map("".join, rows)), "field")
    with pytest.raises(ValueError, match=r"field: [\d,]{11} placements are more than 50,000,000"):
        tabulate(world)
    with pytest.raises(ValueError, match="more than 10; make the map smaller"):
        tabulate(World.parse("APCG....."), max_states=10)
