"""Worlds of several tools and objects: what is in hand, what is in the way, where it ends."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st
from several import becomes, led, stays
from slow_rules import by_the_rules, read, worlds

import habilis as hb
from habilis.worlds.placements import places_of, start_of, with_agents
from habilis.worlds.reach import TooManyPlacementsError, reachable
from habilis.worlds.rules import DROP_NAME

TWO_OBJECTS = "D = can\nG = goal of C"
DROP = "drop: true"


def table_of(rows: str, above: str = "", **options):
    world = hb.World.parse(f"{above}\n" + "\n".join(rows.split()))
    return hb.tabulate(world, starts=[start_of(world)], **options)


def after(mdp, *actions):
    state = mdp.start
    for action in actions:
        state = led(mdp, state, mdp.actions.index(action))
    return state


def held(mdp, state):
    return int(mdp.factor("held")[state])


# One tool in hand at a time


def test_the_first_tool_that_the_agent_comes_beside_is_in_hand_and_stays_there():
    becomes("A.B..P.C   .AB..P.C", "east")
    becomes("A.B..P.C   ..AB.P.C", "east", "east")


def test_a_tool_that_lies_is_in_the_way_of_all():
    stays("ABP..C", "east")
    becomes("CA.P..B   CA.P..B", "tool west")
    stays(
        """
        .A.P...
        .C.....
        .B.....
        """,
        "south",
    )


def test_of_two_tools_at_once_the_one_read_first_is_taken():
    mdp = table_of("P...C .A..G B....")
    state = after(mdp, "west")
    assert held(mdp, state) == 0
    assert mdp.flags["equipped"][state]
    assert held(mdp, mdp.start) == -1
    mdp = table_of("B...C .A..G P....")
    assert held(mdp, after(mdp, "west")) == 0
    assert list(mdp.factors)[1] == "tool:broom"


def test_the_tool_in_hand_alone_acts():
    becomes(
        """
        P....   .P...
        A...C   .A..C
        ..B..   ..B..
        """,
        "east",
    )


# Objects block each other


def test_objects_block_each_other():
    stays(".ACDG..", "east", above=TWO_OBJECTS)
    becomes(".AC.D.G   ..ACD.G", "east", above=TWO_OBJECTS)


def test_a_held_object_is_blocked_by_another():
    stays(".APCD.G", "east", above=TWO_OBJECTS)


def test_a_ball_stops_at_another_object():
    becomes(".AC..DG   ..A.CDG", "east", above="C = ball\nD = crate\nG = goal of C")


def test_a_broom_and_the_agent_push_two_objects_at_once():
    becomes(
        """
        .BD..   ..BD.
        .AC.G   ..ACG
        """,
        "east",
        above=TWO_OBJECTS,
    )


def test_a_magnet_draws_the_nearer_of_two_objects():
    becomes("AM..C.DG   AM.C..DG", "tool east", above=f"M = magnet\n{TWO_OBJECTS}")


def test_a_magnet_does_not_draw_past_another_tool():
    stays("AM..B.C", "tool east", above="M = magnet")


# Putting a tool down


def test_a_tool_put_down_stays_and_is_taken_up_again_after_the_agent_stepped_away():
    mdp = table_of("..... .AB.. C...G", DROP)
    down = after(mdp, "drop")
    assert mdp.actions[-1] == DROP_NAME
    assert (held(mdp, down), int(mdp.factor("laid")[down])) == (-1, 0)
    assert not mdp.flags["equipped"][down]
    beside = after(mdp, "drop", "north", "east")  # away, and back beside it
    assert held(mdp, beside) == 0
    still = after(mdp, "drop", "tool north")
    assert held(mdp, still) == -1
    away = after(mdp, "drop", "west")
    assert (held(mdp, away), int(mdp.factor("laid")[away])) == (-1, -1)
    assert held(mdp, after(mdp, "drop", "west", "east")) == 0


def test_what_is_put_down_next_to_another_tool_is_swapped_for_it():
    mdp = table_of("P.... .AB.. C...G", DROP)
    state = after(mdp, "west")
    assert held(mdp, state) == 1
    swapped = after(mdp, "west", "drop")
    assert held(mdp, swapped) == 0
    assert int(mdp.factor("laid")[swapped]) == 1


def test_a_can_in_the_grip_stays_where_the_picker_is_put_down():
    mdp = table_of(".APC.G", DROP)
    left = after(mdp, "drop", "west")
    assert mdp.factor("object:can")[left] == 3
    assert mdp.factor("tool:picker")[left] == 2


def test_putting_down_nothing_changes_nothing():
    mdp = table_of("A...B C...G", DROP)
    assert after(mdp, "drop") == mdp.start


def test_what_was_put_down_is_not_taken_up_by_putting_down_nothing():
    mdp = table_of(".AP... C...G.", DROP)
    down = after(mdp, "drop")
    assert held(mdp, down) == -1
    assert after(mdp, "drop", "drop") == down


# Tools that may fail


def test_a_broom_that_fails_does_not_push_and_is_stopped():
    becomes(".ABC..   ..ABC.", "east", above="B = broom slip 0.25")
    becomes(".ABC..   .ABC..", "east", above="B = broom slip 0.25", works=False)


def test_a_picker_that_fails_leaves_the_can():
    becomes("..APC.   .APC..", "west", above="P = picker slip 0.25")
    becomes("..APC.   .AP.C.", "west", above="P = picker slip 0.25", works=False)


def test_a_tool_fails_with_its_probability_and_rewards_are_the_means():
    world = hb.World.parse("P = picker slip 0.25\n.APC.G..")
    mdp = hb.tabulate(world)
    row = mdp.transition(1)[[mdp.start]]
    assert sorted(row.data) == [0.25, 0.75]
    pushing = mdp.find(agent=(0, 2), tool=(0, 3), object=(0, 4))
    assert mdp.reward[pushing, 1] == pytest.approx(-0.25)
    sure = hb.tabulate(world.with_tool("none"))
    assert not sure.is_stochastic


def test_a_tool_that_never_fails_is_as_without_saying_so():
    one, other = (
        hb.tabulate(hb.World.parse(f"P = picker{slip}\n.APC.G")) for slip in ("", " slip 0")
    )
    assert np.array_equal(one.next_state, other.next_state)


def test_slip_replaces_actions_besides():
    world = hb.World.parse("P = picker slip 0.25\n.APC.G\n......")
    mdp = hb.tabulate(world, slip=0.1)
    intended, chance = hb.tabulate(world), 0.1 / 8
    state = mdp.start
    mean = sum(intended.transition(a)[[state]].toarray() for a in range(8)) * chance
    wanted = 0.9 * intended.transition(1)[[state]].toarray() + mean
    assert np.allclose(mdp.transition(1)[[state]].toarray(), wanted)


# Ends


def test_an_episode_ends_when_every_object_that_has_a_goal_is_in_it():
    above = "D = can\nE = crate\nG = goal of C\nH = goal of D"
    mdp = table_of("E.... .ACG. .DH.. .....", above)
    one = after(mdp, "east")
    assert not mdp.terminal[one]
    assert mdp.reward[mdp.start, 1] == -1
    both = after(mdp, "east", "west", "west", "south", "east")
    assert mdp.terminal[both]
    plan = hb.solve(mdp)
    assert plan is not None
    assert plan.best_return == 1 - plan.steps


# All of it: every placement that can be reached, and no other


def test_of_one_tool_and_object_the_table_is_part_of_the_whole_one():
    world = hb.load_world("yard", tool="broom")
    whole, part = hb.tabulate(world), hb.tabulate(world, starts=[start_of(world)])
    assert 0 < part.states < whole.states

    def keys(mdp):
        return (mdp.factor("agent") * 100 + mdp.factor("tool")) * 100 + mdp.factor("object")

    place = {key: state for state, key in enumerate(keys(whole).tolist())}
    here = np.array([place[key] for key in keys(part).tolist()])
    assert np.array_equal(whole.next_state[here], here[part.next_state])
    assert np.array_equal(whole.terminal[here], part.terminal)
    assert np.array_equal(whole.reward[here], part.reward)
    assert np.array_equal(whole.flags["attached"][here], part.flags["attached"])


@settings(max_examples=60, deadline=None)
@given(worlds(), st.data())
def test_every_step_is_as_the_rules_say_word_by_word(world, data):
    try:
        mdp = hb.tabulate(world, max_states=200_000)
    except TooManyPlacementsError:
        reject()  # a crowded world says no more than a smaller one
    states = data.draw(st.lists(st.integers(0, mdp.states - 1), min_size=1, max_size=40))
    for state in [mdp.start, *states]:
        for action, name in enumerate(mdp.actions):
            to = int(mdp.next_state[state, action])
            assert read(world, mdp, to) == by_the_rules(world, read(world, mdp, state), name)


def test_too_many_placements_are_refused_in_a_line():
    world = hb.World.parse("D = can\nG = goal of C\nA....\nB.C.D\n....G")
    refused = r"more than 1,000 placements can be reached; remove things"
    with pytest.raises(ValueError, match=refused):
        hb.tabulate(world, max_states=1000)


def test_a_world_whose_placements_need_more_than_64_bits_is_tabulated():
    rows = ["." * 30 for _ in range(26)]
    things = "ABPCDEFIJKLM".ljust(30, ".")
    above = "\n".join(f"{c} = can" for c in "DEFIJKLM") + "\nG = goal of C\n"
    crowded = hb.World.parse(above + "\n".join([things, *rows, "G".ljust(30, ".")]))
    mdp = hb.explore(crowded, horizon=3)
    inside = np.flatnonzero((mdp.next_state != np.arange(mdp.states)[:, None]).any(axis=1))
    assert len(inside) > 5
    for state in inside.tolist():
        for action, name in enumerate(mdp.actions):
            to = int(mdp.next_state[state, action])
            assert read(crowded, mdp, to) == by_the_rules(crowded, read(crowded, mdp, state), name)


def test_every_state_has_a_description():
    world = hb.World.parse("R = rake\ndrop: true\nAP..\n.C.R\n...G\n####")
    mdp = hb.tabulate(world)
    names = [*start_of(world), "held", "laid"]
    for state in range(0, mdp.states, 7):
        cells = {name: divmod(int(mdp.factor(name)[state]), 4) for name in start_of(world)}
        hands = {name: int(mdp.factor(name)[state]) for name in ("held", "laid")}
        found, states = reachable(world, cells | hands, 0)
        for name in names:
            assert found.factor(name)[states[0]] == mdp.factor(name)[state]


@pytest.mark.parametrize(
    ("hands", "message"),
    [
        ({"held": 2}, "held is 2; give a tool's place among 2, from 0, or -1"),
        ({"held": 1}, "the rake is held and not beside the agent; put it there"),
        ({"laid": "x"}, "laid is 'x'; give"),
    ],
)
def test_hands_that_there_are_not_are_refused(hands, message):
    world = hb.World.parse("R = rake\ndrop: true\nAP..\n.C.R\n...G\n####")
    with pytest.raises(ValueError, match=message):
        reachable(world, start_of(world) | hands, 0)


@pytest.mark.parametrize(
    ("above", "message"),
    [
        ("drop: true\ndrop: false", "line 2: drop is set a second time, first in line 1"),
        ("D = ball slip 0.2", "line 1: 'D' is bound to a ball with slip; only tools may fail"),
    ],
)
def test_what_is_given_twice_or_for_the_wrong_thing_is_refused(above, message):
    with pytest.raises(ValueError, match=message):
        hb.World.parse(f"{above}\nAP.CG")


# Maps written as text


def test_a_map_is_written_with_the_characters_that_its_kinds_usually_have():
    rows = "AP..R\n.C.D.\nHE..G\n"
    above = "P = picker slip 0.2\nR = rake\nD = ball\nE = crate\nG = goal of C\nH = goal of D\n"
    assert hb.World.parse(above + "drop: true\n" + rows).text() == above + "drop: true\n" + rows
    other = "V = ball\nB = goal of V\nW = rake\nX = crate\nP = picker slip 0.2\nG = goal of C\n"
    other += "drop: true\nAP..W\n.C.V.\nBX..G\n"
    assert hb.World.parse(other) == hb.World.parse(above + "drop: true\n" + rows)


@pytest.mark.parametrize("slip", ["0.123456789", "1e-09", "1", "0.3"])
def test_a_slip_is_written_as_it_was_read(slip):
    text = f"P = picker slip {slip}\nAP.CG\n"
    assert hb.World.parse(text).text() == text


def test_a_map_that_would_hide_a_goal_is_not_written():
    world = hb.World.parse("D = ball\nH = goal of D\nG = goal of C\nA.CG\n..DH")
    ball = replace(world.objects[1], goal=world.goal)
    both = replace(world, objects=(world.objects[0], ball))
    for hiding in (replace(world, agent=world.goal), both):
        with pytest.raises(ValueError, match=r"something else is on the goal at \(0, 3\)"):
            hiding.text()
        assert len(hiding.rows) == 2


def test_characters_of_further_things_are_not_those_of_others():
    above = "X = picker\nY = can\nZ = goal of Y\nG = goal of C\nV = rake\nW = rake\n"
    world = hb.World.parse(above + "AP.XG\nC.Y.Z\nV...W\n")
    assert world.text() == (
        "Q = picker\nR = rake\nT = rake\nD = can\nG = goal of C\nH = goal of D\n"
        "AP.QG\nC.D.H\nR...T\n"
    )
    assert hb.World.parse(world.text()) == world


@pytest.mark.parametrize("drop", ["", "drop: true\n"])
def test_placements_as_arrays_are_the_same_placements(drop: str):
    world = hb.World.parse(
        f"{drop}R = rake\nD = ball\nG = goal of C\nA....\n.PCR.\n.D#.G", name="room"
    )
    things, cells = {k: v for k, v in start_of(world).items() if k != "agent"}, world.agent_cells
    one_by_one = places_of(world, [{**things, "agent": cell} for cell in cells])
    at_once = with_agents(world, things, cells)
    for one, other in zip(one_by_one.cells, at_once.cells, strict=True):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(one_by_one.held, at_once.held)
    for steps in (0, 2):
        table, states = reachable(world, at_once, steps)
        same, found = reachable(world, [{**things, "agent": cell} for cell in cells], steps)
        assert table.states == same.states
        np.testing.assert_array_equal(states, found)
    with pytest.raises(ValueError, match=r"the object:ball's cell .* is a wall"):
        with_agents(world, {**things, "object:ball": (2, 2)}, cells)
