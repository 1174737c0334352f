"""How soon, from how far and how surely, beside listing all action sequences."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import labelled_tables

import habilis as hb
from habilis.analysis.averages import average_empowerment
from habilis.analysis.influence import distances, influence_range, latency, reliability

MDP = hb.TabularMDP


def slow_latency(table, labels, state, horizon):
    """The least h for which two sequences of h actions lead to different observations."""
    for h in range(horizon + 1):
        seen = set()
        for actions in product(range(table.shape[1]), repeat=h):
            at = state
            for action in actions:
                at = table[at, action]
            seen.add(labels[at])
        if len(seen) > 1:
            return h
    return np.inf


@settings(deadline=None)
@given(labelled_tables(), st.integers(0, 5))
def test_latency_is_the_least_number_of_actions_that_leaves_a_choice(drawn, horizon):
    table, labels = drawn
    found = latency(MDP.deterministic(table), horizon, labels)
    slow = [slow_latency(table, labels, state, horizon) for state in range(len(table))]
    np.testing.assert_array_equal(found, slow)


def test_a_choice_that_is_lost_again_has_a_latency_all_the_same():
    join = MDP.deterministic([[1, 2], [3, 3], [3, 3], [3, 3]])
    assert hb.empowerment(join, 2, states=[0]) == 0
    assert latency(join, 2, "state", states=[0]) == 1


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
def test_range_is_the_largest_distance_with_a_choice(tool):
    world = hb.World.parse("A.P.#\n..C..\n....G").with_tool(tool)
    mdp = hb.tabulate(world)
    counted = mdp.flags["equipped"] if tool != "none" else np.ones(mdp.states, bool)
    for horizon in (0, 1, 2):
        furthest = 0
        for state in np.flatnonzero(counted):
            if slow_latency(mdp.next_state, mdp.factor("object"), state, horizon) <= horizon:
                agent, can = (divmod(int(mdp.factor(f)[state]), 5) for f in ("agent", "object"))
                furthest = max(furthest, abs(agent[0] - can[0]) + abs(agent[1] - can[1]))
        assert influence_range(mdp, horizon) == furthest
    assert furthest > 0


def test_a_tool_reaches_as_far_as_it_is_long():
    row = hb.World.parse("T = stick\nA.T..C....G")
    of = {tool: hb.tabulate(row.with_tool(tool)) for tool in ("none", "broom", "stick")}
    assert {tool: influence_range(mdp, 1) for tool, mdp in of.items()} == {
        "none": 1,
        "broom": 2,
        "stick": 3,
    }


def test_a_magnet_reaches_as_far_as_it_sees():
    row = hb.World.parse("T = magnet\nA.T..C....G")
    assert influence_range(hb.tabulate(row), 1) == 10
    wall = hb.World.parse("T = magnet\nA.T..C#...G")
    assert influence_range(hb.tabulate(wall), 1) == 5


def test_distances_go_along_rows_and_columns():
    mdp = hb.tabulate(hb.World.parse("A..\n...\n.CG"))
    assert distances(mdp, "object", np.array([mdp.start])) == [3]
    with pytest.raises(ValueError, match="no distances; give a world's table"):
        influence_range(MDP.deterministic([[0]]), 1)


def test_reliability_is_one_where_nothing_fails_and_nothing_where_there_is_nothing_to_lose():
    room = hb.World.parse("A.P.\n..C.\n...G")
    assert reliability(room, 2) == 1
    assert np.isnan(reliability(room, 0))
    assert np.isnan(reliability(room, 0, slip=0.1))


def test_reliability_is_a_share_of_the_averages():
    room = hb.World.parse("P = picker slip 0.3\nA.P.\n..C.\n...G")
    sure = average_empowerment(hb.tabulate(room.with_tool("none").with_tool("picker")), 2)
    assert reliability(room, 2) == average_empowerment(hb.tabulate(room), 2) / sure
    both = average_empowerment(hb.tabulate(room, slip=0.1), 2)
    assert reliability(room, 2, slip=0.1) == both / sure
    assert both / sure < reliability(room, 2) < 1


def test_reliability_of_one_push_is_the_capacity_of_its_channel():
    # To push or not to: 0.85 against 0.05, since a slip may do it too.
    line = hb.World.parse("A.C.G")
    channel = hb.capacity([[0.85, 0.15], [0.05, 0.95]]).bits
    assert reliability(line, 1, slip=0.2) == pytest.approx(channel, abs=1e-6)


@settings(max_examples=60, deadline=None)
@given(labelled_tables(most_states=4), st.integers(1, 3), st.floats(0, 1))
def test_slipping_actions_never_add_anything(drawn, horizon, slip):
    table, labels = drawn
    sure = MDP.deterministic(table)
    found = hb.empowerment(sure.slippery(slip), horizon, labels)
    assert (found <= hb.empowerment(sure, horizon, labels) + 1e-9).all()


class Anchor:
    """Draws the object onto itself, so that no step east or west can be made."""

    character = "T"

    def attached(self, agent, tool, thing):
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent, tool, thing, step):
        return tool + step if abs(step) == 1 else thing

    def swing(self, agent, tool, thing, step):
        return thing


def test_a_tool_that_fails_may_leave_a_choice_that_it_would_have_taken_away():
    room = hb.World.parse("A.P.\n..C.\n....\n...G").with_tool(Anchor())
    failing = (room.with_tool(replace(room.tools[0], slip=p)) for p in (0.1, 0.9))
    seldom, mostly = (reliability(world, 3) for world in failing)
    assert 1 < seldom < mostly
