"""Persistence: the outcomes that can be reached repeatedly."""

from math import gcd

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import after, ever, labelled_tables

import habilis as hb
from habilis.empowerment.tabular.persistence import persistence

MDP = hb.TabularMDP


def components(table):
    """For every state the states that it can reach and that can reach it."""
    reached = ever(table)
    return [np.flatnonzero(row) for row in reached & reached.T]


def seen(labels, states):
    return set(labels[states].tolist())


def period(table, component):
    """The greatest common divisor of the lengths of all ways from a state back to it."""
    state, lengths = component[0], range(1, 3 * len(table) + 1)
    return gcd(*(h for h in lengths if after(table, h)[state, state]))


@settings(deadline=None)
@given(labelled_tables())
def test_it_is_the_most_that_any_component_in_reach_has(drawn):
    table, labels = drawn
    found = persistence(MDP.deterministic(table), labels)
    each, reached = components(table), ever(table)
    most = [max(len(seen(labels, each[t])) for t in np.flatnonzero(row)) for row in reached]
    np.testing.assert_array_equal(found, np.log2(most))


@settings(deadline=None)
@given(labelled_tables())
def test_it_is_no_more_than_all_that_can_be_reached(drawn):
    table, labels = drawn
    found = persistence(MDP.deterministic(table), labels)
    for state, row in enumerate(ever(table)):
        assert found[state] <= np.log2(len(seen(labels, row)))


@settings(max_examples=60, deadline=None)
@given(labelled_tables(), st.integers(0, 9))
def test_so_many_observations_are_there_in_as_many_long_horizons_as_the_period(drawn, more):
    table, labels = drawn
    found = persistence(MDP.deterministic(table), labels)
    each, reached, long = components(table), ever(table), len(table) ** 2 + more
    for state, row in enumerate(reached):
        back = [t for t in np.flatnonzero(row) if (reached[table[t]][:, t]).any()]
        best = max((each[t] for t in back), key=lambda c: len(seen(labels, c)))
        horizons = range(long, long + max(1, period(table, best)))
        there = set().union(*(seen(labels, after(table, h)[state]) for h in horizons))
        assert seen(labels, best) <= there
        assert len(there) >= 2 ** found[state] - 1e-9


@settings(deadline=None)
@given(labelled_tables(), st.integers(0, 9))
def test_a_long_empowerment_is_no_less_where_the_agent_can_wait(drawn, more):
    table, labels = drawn
    table = np.column_stack([table, np.arange(len(table))])
    mdp = MDP.deterministic(table)
    bits, found = hb.empowerment(mdp, len(table) + more, labels), persistence(mdp, labels)
    assert (bits >= found).all()
    # And where nothing leads out of the component for good, it is all that there is.
    reached = ever(table)
    for_good = [(reached[row] == row).all() for row in reached]
    np.testing.assert_array_equal(bits[for_good], found[for_good])


def test_a_ring_has_all_again_and_again_and_never_a_choice():
    ring = MDP.deterministic([[1], [2], [3], [0]])
    np.testing.assert_array_equal(persistence(ring, "state"), [2, 2, 2, 2])
    assert not hb.empowerment(ring, 50).any()


@settings(deadline=None)
@given(labelled_tables(), st.data())
def test_states_and_actions_are_as_in_empowerment(drawn, data):
    table, labels = drawn
    mdp = MDP.deterministic(table)
    states = data.draw(st.lists(st.integers(0, len(table) - 1)))
    found = persistence(mdp, labels, states=states)
    np.testing.assert_array_equal(found, persistence(mdp, labels)[states])
    used = data.draw(st.sets(st.integers(0, table.shape[1] - 1), min_size=1))
    alone = MDP.deterministic(table[:, sorted(used)])
    chosen = persistence(mdp, labels, actions=[*used])
    np.testing.assert_array_equal(chosen, persistence(alone, labels))


def test_a_world_is_tabulated_and_nats_are_fewer_than_bits():
    world = hb.load_world("yard", tool="broom")
    bits = persistence(world)
    np.testing.assert_array_equal(bits, persistence(hb.tabulate(world)))
    np.testing.assert_allclose(persistence(world, unit="nats"), bits * np.log(2))


def of_placement(rows: str, tool: str) -> float:
    world = hb.World.parse(rows.replace(" ", "\n")).with_tool(tool)
    mdp = hb.tabulate(world)
    return float(persistence(mdp, states=[mdp.start])[0])


@pytest.mark.parametrize(
    ("rows", "bits"),
    [
        ("C..P .A.. ...G", {"none": 0, "broom": 0, "picker": np.log2(12)}),  # in a corner for good
        (".C.P .A.. ...G", {"none": 1, "picker": np.log2(12)}),  # at a wall, between the corners
        ("...P .CA. ...G", {"none": 1, "picker": np.log2(12)}),  # to a wall and back there is none
        (
            "..... ..... ..CA. ...P. ...GG".replace("GG", ".G"),
            {"none": np.log2(9)},
        ),  # off the walls
        ("AP...C.G", {"none": 0, "picker": 3}),  # in a passage the agent cannot get behind it
    ],
)
def test_what_tools_can_do_to_a_can_for_ever(rows, bits):
    assert {tool: of_placement(rows, tool) for tool in bits} == pytest.approx(bits)


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
def test_a_long_empowerment_in_a_world_is_no_less(tool):
    mdp = hb.tabulate(hb.World.parse("A.P.\n..C.\n....\n...G").with_tool(tool))
    bits, found = hb.empowerment(mdp, 100, "object"), persistence(mdp)
    assert (bits >= found).all()
    # What cannot be undone is left out: without a picker, into which corner the can is brought.
    assert (bits > found).any() == (tool != "picker")


def test_a_long_chain_of_components_is_no_trouble():
    count = 200_000
    chain = MDP.deterministic([[s, min(s + 1, count - 1)] for s in range(count)])
    assert not persistence(chain, "state").any()
    circle = MDP.deterministic([[(s + 1) % count] for s in range(count)])
    assert (persistence(circle, "state", states=[0, 7]) == np.log2(count)).all()


def test_stochastic_tables_are_refused():
    mdp = hb.tabulate(hb.load_world("yard", tool="none"))
    with pytest.raises(ValueError, match=r"stochastic.*; leave out slip"):
        persistence(mdp.slippery(0.1))
    with pytest.raises(ValueError, match=r"; leave out slip, that of the world's tool too"):
        persistence(hb.World.parse("P = picker slip 0.1\nAPC.G"))
    with pytest.raises(ValueError, match=r"noisy; give a factor's name"):
        persistence(mdp, np.ones((mdp.states, 1)))
    with pytest.raises(ValueError, match=r"sensor 'smell' is unknown"):
        persistence(mdp, "smell")
    with pytest.raises(ValueError, match=r"use indices from 0 to 3"):
        persistence(mdp, actions=[4])
