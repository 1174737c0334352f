"""Goal-directed empowerment: beside a list of all sequences, its relations, and refusals."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.empowerment.goal_directed import distances


def random_table(seed, states=6, actions=2, missing=0.2):
    rng = np.random.default_rng(seed)
    table = rng.integers(states, size=(states, actions))
    table[rng.random((states, actions)) < missing] = -1
    table[(table < 0).all(axis=1), 0] = 0
    return table, rng.integers(3, size=states), rng.random(states) < 0.3


def counted(table, labels, goals, horizon, slack):
    """The definition, sequence by sequence."""
    table = table.copy()
    table[goals] = np.flatnonzero(goals)[:, None]
    states, actions = table.shape
    far = 10**6
    d = np.where(goals, 0, far)
    for _ in range(states):
        for s, a in product(range(states), range(actions)):
            if table[s, a] >= 0:
                d[s] = min(d[s], 1 + d[table[s, a]])
    bits = np.zeros(states)
    for s in np.flatnonzero(d < far):
        n = min(horizon, d[s] + slack)
        seen = set()
        for sequence in product(range(actions), repeat=n):
            x = s
            for action in sequence:
                x = table[x, action] if x >= 0 else x
            if x >= 0 and n + d[x] <= d[s] + slack:
                seen.add(labels[x])
        bits[s] = np.log2(len(seen))
    return bits


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.integers(0, 5), st.integers(0, 4))
def test_it_is_the_count_of_the_definition(seed, horizon, slack):
    table, labels, goals = random_table(seed)
    goals[seed % 6] = True
    mdp = hb.TabularMDP.deterministic(table)
    found = hb.goal_directed_empowerment(mdp, horizon, goals, slack, labels)
    np.testing.assert_array_equal(found, counted(table, labels, goals, horizon, slack))


def test_with_much_slack_it_is_empowerment_where_the_goal_absorbs_and_is_never_lost():
    ring = np.array([[(s - 1) % 7, (s + 1) % 7] for s in range(7)])
    found = hb.goal_directed_empowerment(hb.TabularMDP.deterministic(ring), 4, [0], 100)
    ring[0] = 0
    plain = hb.empowerment(hb.TabularMDP.deterministic(ring), 4)
    np.testing.assert_array_equal(found, plain)


def test_a_way_that_is_longer_is_worth_nothing_without_slack():
    corridor = hb.TabularMDP.deterministic([[max(s - 1, 0), min(s + 1, 4)] for s in range(5)])
    assert hb.goal_directed_empowerment(corridor, 3, [4]).tolist() == [0] * 5
    some = hb.goal_directed_empowerment(corridor, 3, [4], slack=2)
    assert some.tolist() == [np.log2(3), 1, 1, 0, 0]  # 0 bumps into the wall, or goes


def test_where_the_goal_cannot_be_reached_there_are_no_bits():
    mdp = hb.TabularMDP.deterministic([[0, 0], [0, 2], [2, 2]])
    assert hb.goal_directed_empowerment(mdp, 2, [2], slack=9)[0] == 0


def test_a_goal_that_no_other_state_reaches_leaves_none_of_them_any_bits():
    table = [[1, 5], [4, 4], [4, 4], [0, 5], [1, 5], [5, 1]]
    mdp = hb.TabularMDP.deterministic(table)
    assert hb.goal_directed_empowerment(mdp, 2, [3], slack=2).tolist() == [0] * 6


def test_the_default_goal_is_the_terminal_states():
    world = hb.load_world("yard")
    mdp = hb.tabulate(world)
    found = hb.goal_directed_empowerment(mdp, 3, sensor="object", states=[mdp.start])
    goal = hb.goal_directed_empowerment(mdp, 3, mdp.terminal, 0, "object", [mdp.start])
    assert found == goal


def test_distances_are_those_of_shortest_plans():
    world = hb.load_world("corridor")
    mdp = hb.tabulate(world)
    plan = hb.solve(mdp)
    assert plan is not None
    assert distances(mdp.next_state, mdp.terminal)[mdp.start] == len(plan.actions)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "the table has no terminal state; give goal=, some of its states"),
        ({"goal": []}, "goal is empty; give at least one state"),
        ({"goal": [3]}, "goal has 3; use indices from 0 to 1"),
        ({"goal": [0], "slack": -1}, "slack is -1; give a whole number from 0 up"),
        ({"goal": [0], "sensor": np.eye(2)}, "the sensor is noisy; goal-directed"),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match=message):
        hb.goal_directed_empowerment(mdp, 2, **arguments)


def test_a_stochastic_table_is_refused():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.1)
    with pytest.raises(ValueError, match="the table is stochastic; goal-directed"):
        hb.goal_directed_empowerment(mdp, 2, [0])


def test_a_slack_that_takes_too_much_memory_is_refused_at_once():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
    with pytest.raises(ValueError, match=r"takes about 10.7 GiB; .* give less slack"):
        hb.goal_directed_empowerment(ring, 2 * 10**7, goal=[0], slack=2 * 10**7)
