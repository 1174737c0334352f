"""The rules of the worlds (design, section 3), as pictures before and after, and in full.

In the pictures `T` stands for either tool, picker and broom alike. The goal is kept out of the way.
Rules know no direction, so each picture must hold turned and mirrored too: eight times.
"""

import numpy as np
import pytest
from before_after import SIDES, STEPS, becomes, cell_of, drawn, find, stays
from hypothesis import given, settings
from rooms import rooms, sizes

from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import Cell, World, load_world

# Moving without a tool in hand (rule 2)


def test_a_move_takes_the_agent_one_cell():
    becomes(
        """
        ....   ....
        .A..   ..A.
        C..G   C..G
        """,
        "east",
    )


def test_the_four_moves_go_round_in_a_circle():
    becomes(
        """
        ....   ....
        .A..   .A..
        C..G   C..G
        """,
        *("north", "east", "south", "west"),
    )


def test_the_edge_of_the_map_stops_the_agent():
    stays(
        """
        ..A
        ...
        C.G
        """,
        *("north", "east"),
    )


def test_a_wall_stops_the_agent():
    stays(
        """
        .#..
        #A#.
        .#CG
        """,
        *SIDES,
    )


def test_the_agent_pushes_the_can():
    becomes(
        """
        .....   .....
        .AC..   ..AC.
        ....G   ....G
        """,
        "east",
    )


def test_a_can_is_pushed_cell_by_cell_and_never_pulled():
    becomes(
        """
        .AC..   ..A.C
        ....G   ....G
        """,
        *("east", "east", "west"),
    )


def test_a_can_against_a_wall_stops_the_agent():
    stays(
        """
        .AC#
        ...G
        """,
        "east",
    )


def test_a_can_against_the_edge_stops_the_agent():
    stays(
        """
        .AC
        G..
        """,
        "east",
    )


def test_a_can_against_a_lying_tool_stops_the_agent():
    stays(
        """
        .ACT.
        ....G
        """,
        "east",
    )


def test_a_can_may_be_pushed_past_a_lying_tool():
    becomes(
        """
        ...T.   ...T.
        .AC..   ..AC.
        G....   G....
        """,
        "east",
    )


# Equipping (rule 1)


def test_a_lying_tool_stays_where_it_is():
    becomes(
        """
        A..T   .A.T
        C..G   C..G
        """,
        "east",
    )


def test_a_tool_across_a_corner_is_not_in_hand():
    becomes(
        """
        .T..   .T..
        A...   ....
        ....   A...
        C..G   C..G
        """,
        "south",
    )


def test_a_tool_is_in_hand_as_soon_as_the_agent_stands_next_to_it():
    becomes(
        """
        A..T.   ..AT.
        C...G   C...G
        """,
        *("east", "east"),
    )
    becomes(
        """
        A..T.   .AT..
        C...G   C...G
        """,
        *("east", "east", "west"),
    )


def test_a_tool_beside_the_way_comes_along_with_the_next_move():
    becomes(
        """
        ..T..   ...T.
        .A...   ...A.
        C...G   C...G
        """,
        *("east", "east"),
    )


def test_a_tool_in_hand_stays_in_hand():
    becomes(
        """
        .....   ..A..
        .T...   ..T..
        .A...   .....
        .....   .....
        C...G   C...G
        """,
        *("east", "east", "south", "west", "tool east", "north", "north", "west", "tool south"),
        *("north", "east"),
    )


# Moving with a tool in hand (rule 3)


def test_a_tool_goes_ahead_of_the_agent():
    becomes(
        """
        .AT.   ..AT
        C..G   C..G
        """,
        "east",
    )


def test_a_tool_goes_beside_the_agent():
    becomes(
        """
        .T..   ..T.
        .A..   ..A.
        C..G   C..G
        """,
        "east",
    )


def test_a_tool_goes_behind_the_agent():
    becomes(
        """
        TA..   .TA.
        C..G   C..G
        """,
        "east",
    )


def test_a_wall_before_the_tool_stops_agent_and_tool():
    stays(
        """
        .T#.
        .A..
        C..G
        """,
        "east",
    )
    stays(
        """
        .AT#
        C..G
        """,
        "east",
    )


def test_the_edge_before_the_tool_stops_agent_and_tool():
    stays(
        """
        ..AT
        C..G
        """,
        "east",
    )


def test_a_wall_before_the_agent_stops_agent_and_tool():
    stays(
        """
        .T..
        .A#.
        C..G
        """,
        "east",
    )


def test_the_edge_before_the_agent_stops_agent_and_tool():
    stays(
        """
        A...
        T...
        C..G
        """,
        *("north", "west"),
    )


def test_the_agent_pushes_the_can_with_a_tool_at_its_side():
    becomes(
        """
        .T...   ..T..
        .AC..   ..AC.
        ....G   ....G
        """,
        "east",
    )


def test_the_agent_pushes_the_can_with_a_tool_behind_it():
    becomes(
        """
        TAC..   .TAC.
        ....G   ....G
        """,
        "east",
    )


def test_a_can_that_cannot_be_pushed_stops_agent_and_tool():
    stays(
        """
        .T...
        .AC#.
        ....G
        """,
        "east",
    )
    stays(
        """
        ..T
        G.A
        ..C
        """,
        "south",
    )


def test_a_can_behind_the_agent_stays():
    becomes(
        """
        CAT..   C.AT.
        ....G   ....G
        """,
        "east",
    )


def test_a_can_at_the_other_side_of_the_agent_stays():
    becomes(
        """
        .T...   ..T..
        .A...   ..A..
        .C..G   .C..G
        """,
        "east",
    )


# The picker (rules 3 and 4)


def test_a_picker_takes_an_attached_can_ahead():
    becomes(
        """
        .APC.   ..APC
        ....G   ....G
        """,
        "east",
    )


def test_a_picker_pulls_an_attached_can():
    becomes(
        """
        .APC.   APC..
        ....G   ....G
        """,
        "west",
    )


def test_a_picker_takes_an_attached_can_sideways():
    becomes(
        """
        .....   .APC.
        .APC.   .....
        ....G   ....G
        """,
        "north",
    )


def test_a_can_that_the_picker_comes_up_to_is_attached_from_then_on():
    becomes(
        """
        .AP.C.   .APC..
        .....G   .....G
        """,
        *("east", "west"),
    )
    becomes(
        """
        AP.....   ...APC.
        ....C..   .......
        G......   G......
        """,
        *("east", "south", "east", "north", "east"),
    )


def test_an_attached_can_stays_attached():
    becomes(
        """
        .......   .......
        .......   .CPA...
        .......   .......
        .APC...   .......
        ......G   ......G
        """,
        *("east", "north", "tool north", "east", "tool west", "north"),
    )


def test_a_wall_before_an_attached_can_stops_all():
    stays(
        """
        ...#..
        .APC#.
        .....G
        """,
        *("north", "east"),
    )


def test_the_edge_before_an_attached_can_stops_all():
    stays(
        """
        ..APC
        .....
        G....
        """,
        *("north", "east"),
    )


def test_a_wall_before_a_picker_or_its_agent_stops_the_attached_can():
    stays(
        """
        ..#..
        .APC.
        .#..G
        """,
        *("north", "south"),
    )
    stays(
        """
        #APC.
        ....G
        """,
        "west",
    )


def test_a_picker_carried_from_the_side_into_a_can_is_blocked():
    stays(
        """
        .PC..
        .A...
        ....G
        """,
        "east",
    )


def test_a_can_beside_a_picker_is_not_attached():
    becomes(
        """
        ..PC.   ...C.
        ..A..   ..P..
        .....   ..A..
        ....G   ....G
        """,
        "south",
    )


def test_a_can_one_cell_off_the_picker_is_not_attached():
    becomes(
        """
        .AP.C.   AP..C.
        .....G   .....G
        """,
        "west",
    )


def test_a_picker_behind_the_agent_does_not_hold_the_can_ahead():
    becomes(
        """
        .PAC.   PA.C.
        ....G   ....G
        """,
        "west",
    )


def test_a_lying_picker_holds_nothing():
    becomes(
        """
        A..PC.   .A.PC.
        .....G   .....G
        """,
        "east",
    )


# The broom (rule 3)


def test_a_broom_pushes_a_can_straight_ahead():
    becomes(
        """
        .ABC..   ..ABC.
        .....G   .....G
        """,
        "east",
    )


def test_a_broom_pushes_a_can_from_the_side_of_the_agent():
    becomes(
        """
        .BC..   ..BC.
        .A...   ..A..
        ....G   ....G
        """,
        "east",
    )


def test_a_broom_does_not_push_a_can_it_only_comes_up_to():
    becomes(
        """
        .AB.C.   ..ABC.
        .....G   .....G
        """,
        "east",
    )


def test_a_broom_leaves_its_can_when_the_agent_draws_back():
    becomes(
        """
        .ABC.   AB.C.
        ....G   ....G
        """,
        "west",
    )


def test_a_broom_leaves_its_can_when_the_agent_steps_aside():
    becomes(
        """
        .....   .AB..
        .ABC.   ...C.
        ....G   ....G
        """,
        "north",
    )


def test_a_can_that_the_broom_cannot_push_stops_agent_and_broom():
    stays(
        """
        .ABC#
        ....G
        """,
        "east",
    )
    stays(
        """
        .BC#.
        .A...
        ....G
        """,
        "east",
    )
    stays(
        """
        ..BC
        ..A.
        G...
        """,
        "east",
    )


def test_an_agent_that_cannot_go_does_not_push_with_the_broom():
    stays(
        """
        .BC..
        .A#..
        ....G
        """,
        "east",
    )


def test_a_lying_broom_pushes_nothing():
    becomes(
        """
        A..BC.   .A.BC.
        .....G   .....G
        """,
        "east",
    )


# Putting the tool on a side (rule 5)


def test_a_tool_goes_to_the_side_it_is_put_on():
    becomes(
        """
        .T..   ....
        .A..   .AT.
        ....   ....
        C..G   C..G
        """,
        "tool east",
    )


def test_a_tool_goes_to_the_opposite_side():
    becomes(
        """
        .T..   ....
        .A..   .A..
        ....   .T..
        C..G   C..G
        """,
        "tool south",
    )


def test_a_tool_put_on_its_own_side_stays():
    stays(
        """
        .T..
        .A..
        C..G
        """,
        "tool north",
    )


def test_a_wall_at_a_side_keeps_the_tool_where_it_is():
    stays(
        """
        .T..
        #A#.
        .#.C
        ...G
        """,
        *("tool east", "tool south", "tool west"),
    )


def test_the_edge_at_a_side_keeps_the_tool_where_it_is():
    stays(
        """
        AT.C
        ...G
        """,
        *("tool north", "tool west"),
    )


def test_a_can_at_a_side_keeps_the_tool_where_it_is():
    stays(
        """
        .T..
        .AC.
        ...G
        """,
        "tool east",
    )
    stays(
        """
        .T..
        .A..
        .C.G
        """,
        "tool south",
    )


def test_nothing_is_swept_on_the_way_to_a_side():
    becomes(
        """
        .TC.   ..C.
        .A..   .AT.
        ...G   ...G
        """,
        "tool east",
    )
    becomes(
        """
        .T..   ....
        .AC.   .AC.
        ...G   .T.G
        """,
        "tool south",
    )


def test_walls_on_the_way_to_a_side_do_not_matter():
    becomes(
        """
        .T#.   ..#.
        .A#.   .A#.
        ..#.   .T#.
        C..G   C..G
        """,
        "tool south",
    )


def test_a_tool_that_is_not_in_hand_is_put_nowhere():
    sides = ("tool north", "tool east", "tool south", "tool west")
    stays(
        """
        .A.T
        ....
        C..G
        """,
        *sides,
    )
    stays(
        """
        ..T.
        .A..
        C..G
        """,
        *sides,
    )
    stays(
        """
        .....
        .....
        A.T.C
        .....
        ....G
        """,
        *sides,
    )


def test_a_broom_put_elsewhere_leaves_its_can():
    becomes(
        """
        .....   ..B..
        ..ABC   ..A.C
        ....G   ....G
        """,
        "tool north",
    )


def test_a_picker_put_elsewhere_takes_the_attached_can():
    becomes(
        """
        ..C..   .....
        ..P..   .....
        ..A..   ..APC
        ....G   ....G
        """,
        "tool east",
    )
    becomes(
        """
        .CPA....   ...APC..
        .......G   .......G
        """,
        "tool east",
    )


def test_an_attached_can_blocks_nothing_on_its_own_side():
    stays(
        """
        .APC.
        ....G
        """,
        "tool east",
    )


def test_a_wall_where_an_attached_can_would_go_keeps_picker_and_can():
    stays(
        """
        .....
        CPA.#
        ....G
        """,
        "tool east",
    )


def test_the_edge_where_an_attached_can_would_go_keeps_picker_and_can():
    stays(
        """
        CPA.
        ....
        ...G
        """,
        *("tool north", "tool east"),
    )
    stays(
        """
        .....
        CPA..
        .....
        ....G
        """,
        "tool north",
    )


def test_a_wall_where_a_picker_would_go_keeps_picker_and_can():
    stays(
        """
        .....
        CPA#.
        ....G
        """,
        "tool east",
    )


def test_a_picker_put_elsewhere_does_not_take_a_can_that_is_not_in_line():
    becomes(
        """
        .PC.   ..C.
        .A..   .A..
        ...G   .P.G
        """,
        "tool south",
    )


# The goal (rule 6)


def test_things_pass_over_the_goal():
    becomes(
        """
        .ACG..   ..AGC.
        """,
        *("east", "east", "west"),
    )
    becomes(
        """
        .ATG...   ...GAT.
        C......   C......
        """,
        *("east", "east", "east"),
    )


@pytest.mark.parametrize(
    ("picture", "action"),
    [
        (".ACG.", "east"),
        (".ABCG", "east"),
        (".APCG", "east"),
        (".BCG. .A...", "east"),
        (".G. .C. .P. .A.", "north"),
        ("G.. C.. AP. ...", "north"),
        ("..C ..P G.A", "tool west"),
    ],
)
def test_bringing_the_can_into_the_goal_costs_nothing_and_ends_the_episode(
    picture: str, action: str
):
    world = World.parse("\n".join(picture.split()))
    mdp = tabulate(world)
    state, column = find(mdp, world), mdp.actions.index(action)
    end = mdp.next_state[state, column]
    assert cell_of(mdp, "object", end) == world.goal
    assert mdp.reward[state, column] == 0
    assert mdp.terminal[end]
    assert not mdp.terminal[state]


@pytest.mark.parametrize(
    ("picture", "action"),
    [
        pytest.param("..AC..G", "east", id="the can elsewhere"),
        pytest.param("AGC", "east", id="stopped"),
        pytest.param(".AG C..", "east", id="the agent in the goal"),
        pytest.param(".APG C...", "east", id="the picker in the goal"),
        pytest.param(".ABG C...", "east", id="the broom in the goal"),
        pytest.param("..A ..B C.G", "tool east", id="stopped tool"),
    ],
)
def test_every_other_step_costs_one(picture: str, action: str):
    world = World.parse("\n".join(picture.split()))
    mdp = tabulate(world)
    state, column = find(mdp, world), mdp.actions.index(action)
    assert mdp.reward[state, column] == -1
    assert not mdp.terminal[mdp.next_state[state, column]]


def test_leaving_the_goal_again_costs_one():
    mdp = tabulate(World.parse(".ACG.."))
    there = mdp.next_state[mdp.start, mdp.actions.index("east")]
    assert mdp.terminal[there]
    assert mdp.reward[there, mdp.actions.index("east")] == -1


# All of it: against the rules written once more, slowly, one placement at a time


WORLDS = rooms(sizes(range(2, 6), range(2, 6)), lambda cells: cells // 2)


def is_as_ruled(world: World, mdp: TabularMDP, state: int) -> bool:
    placement = {name: cell_of(mdp, name, state) for name in mdp.factors}
    over = placement["object"] == world.goal  # rewards after the end are irrelevant
    for action in range(len(mdp.actions)):
        to = int(mdp.next_state[state, action])
        found = {name: cell_of(mdp, name, to) for name in mdp.factors}
        ruled = by_the_rules(world, placement, action)
        cost = 0 if ruled["object"] == world.goal else -1
        if found != ruled or not (over or mdp.reward[state, action] == cost):
            return False
    return True


def by_the_rules(world: World, placement: dict[str, Cell], action: int) -> dict[str, Cell]:
    """The placement after an action: rules 1 to 5, word by word."""
    down, right = STEPS[action % 4]

    def next_to(cell: Cell) -> Cell:
        return cell[0] + down, cell[1] + right

    agent, can, tool = placement["agent"], placement["object"], placement.get("tool")
    pushed = next_to(agent) == can
    after = dict(placement)
    if tool is None or abs(agent[0] - tool[0]) + abs(agent[1] - tool[1]) != 1:
        if action < 4:
            after["agent"] = next_to(agent)
            after["object"] = next_to(can) if pushed else can
    else:
        in_line = can == (2 * tool[0] - agent[0], 2 * tool[1] - agent[1])
        attached = in_line and world.tool == "picker"
        if action < 4:
            swept = world.tool == "broom" and next_to(tool) == can
            after["agent"], after["tool"] = next_to(agent), next_to(tool)
            after["object"] = next_to(can) if attached or pushed or swept else can
        else:
            after["tool"] = next_to(agent)
            after["object"] = next_to(next_to(agent)) if attached else can
    inside = all(
        0 <= row < world.height and 0 <= column < world.width for row, column in after.values()
    )
    free = world.walls.isdisjoint(after.values())
    apart = len(set(after.values())) == len(after)
    return after if inside and free and apart else placement


@settings(max_examples=60, deadline=None)
@given(WORLDS)
def test_every_action_in_every_state_of_any_world_is_as_ruled(world: World):
    mdp = tabulate(world)
    for state in range(mdp.states):
        assert is_as_ruled(world, mdp, state), picture_of(world, mdp, state)


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
@pytest.mark.parametrize("name", ["corridor", "corridor-b", "yard", "yard-b"])
def test_the_built_in_worlds_are_as_ruled(name: str, tool: str):
    world = load_world(name, tool=tool)
    mdp = tabulate(world)
    some = np.random.default_rng(0).choice(mdp.states, size=1000, replace=False)
    for state in [mdp.start, mdp.states - 1, *some]:
        assert is_as_ruled(world, mdp, state), picture_of(world, mdp, state)


def picture_of(world: World, mdp: TabularMDP, state: int) -> str:
    things = {name: cell_of(mdp, name, state) for name in mdp.factors}
    return "\n".join([f"{world.tool}:", *drawn(world, things)])
