"""Empowerment is what trying out all action sequences would count, and what it must be by theory.

There are three ways through the code, and every property has to hold on each:

- "all": few labels, every state asked about: sets of labels carried backward;
- "some": few labels, some states asked about: the same on the part of the table they can reach;
- "many labels": more than 4096 of them: sets of states grown forward.
"""

from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import rooms

from habilis.empowerment import empowerment
from habilis.empowerment.tabular.counting import count_backward, count_forward
from habilis.mdp import TabularMDP
from habilis.worlds.table import tabulate
from habilis.worlds.world import World

Bits = np.ndarray
MANY = 5000
WAYS = ("all", "some", "many labels")

SWITCH = TabularMDP.deterministic([[1, 2], [1, 1], [2, 2]])
"""From state 0, each action leads to another end."""


def random_table(rng: np.random.Generator, states: int, actions: int) -> np.ndarray:
    return rng.integers(states, size=(states, actions))


@st.composite
def tables(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray]:
    """A transition table, and labels of which several states may share one."""
    states, actions = draw(st.integers(1, 9)), draw(st.integers(1, 4))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    table = random_table(rng, states, actions)
    if draw(st.booleans()):  # sparse: most actions do nothing, so that distance matters
        table = np.where(rng.random(table.shape) < 0.6, np.arange(states)[:, None], table)
    return table, rng.integers(-2, draw(st.integers(-1, 6)), size=states)


WORLDS = rooms([(1, 5), (2, 2), (2, 3), (3, 2), (3, 3)], lambda cells: min(2, cells))


def brute_force(table: np.ndarray, labels: np.ndarray, horizon: int, actions: Any = None) -> Bits:
    """Follows every sequence of actions from every state, and counts the labels at the ends."""
    ends = []
    for sequence in product(range(table.shape[1]) if actions is None else actions, repeat=horizon):
        at = np.arange(len(table))
        for action in sequence:
            at = table[at, action]
        ends.append(labels[at])
    return np.log2([len(set(seen)) for seen in np.transpose(ends).tolist()])


def bits_by(
    way: str, table: np.ndarray, labels: np.ndarray, horizon: int, actions: Any = None
) -> Bits:
    """Empowerment of every state of a small table, by one of the ways through the code."""
    count = len(table)
    if way == "many labels":  # as many lone states beside the table, each with its own label
        lone = np.arange(count, count + MANY)
        table = np.concatenate([table, np.repeat(lone[:, None], table.shape[1], axis=1)])
        labels = np.concatenate([labels, labels.max() + 1 + np.arange(MANY)])
    mdp = TabularMDP.deterministic(table)
    states = None if way == "all" else range(count)
    return empowerment(mdp, horizon, labels, actions, states)


@pytest.fixture(params=WAYS)
def way(request: pytest.FixtureRequest) -> str:
    return request.param


# Against all action sequences


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables(), st.integers(0, 4))
def test_bits_are_those_of_all_action_sequences(way: str, table_and_labels, horizon: int):
    table, labels = table_and_labels
    bits = bits_by(way, table, labels, horizon)
    assert np.array_equal(bits, brute_force(table, labels, horizon))


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables(), st.integers(0, 3), st.data())
def test_sequences_are_made_of_the_chosen_actions_alone(
    way: str, table_and_labels, horizon: int, data: st.DataObject
):
    table, labels = table_and_labels
    actions = data.draw(st.lists(st.integers(0, table.shape[1] - 1), min_size=1, max_size=4))
    bits = bits_by(way, table, labels, horizon, actions)
    assert np.array_equal(bits, brute_force(table, labels, horizon, sorted(set(actions))))


@settings(deadline=None)
@given(tables(), st.integers(0, 4), st.data())
def test_states_are_answered_in_the_order_and_as_often_as_asked(
    table_and_labels, horizon: int, data: st.DataObject
):
    table, labels = table_and_labels
    mdp, count = TabularMDP.deterministic(table), len(table)
    asked = data.draw(st.lists(st.integers(0, count - 1), max_size=2 * count))
    mask = np.array(data.draw(st.lists(st.booleans(), min_size=count, max_size=count)))
    truth = brute_force(table, labels, horizon)
    assert np.array_equal(empowerment(mdp, horizon, labels, states=asked), truth[asked])
    assert np.array_equal(empowerment(mdp, horizon, labels, states=mask), truth[mask])


@settings(max_examples=25, deadline=None)
@given(WORLDS, st.integers(0, 3), st.data())
def test_bits_of_a_world_are_those_of_all_action_sequences(
    world: World, horizon: int, data: st.DataObject
):
    mdp = tabulate(world)
    sensor = data.draw(st.sampled_from(["state", *mdp.factors]))
    actions = data.draw(st.sampled_from([None, range(4), [0, 2], range(len(mdp.actions))]))
    labels = np.arange(mdp.states) if sensor == "state" else mdp.factor(sensor)
    truth = brute_force(mdp.next_state, labels, horizon, actions)
    assert np.array_equal(empowerment(mdp, horizon, sensor, actions), truth)
    some = np.arange(0, mdp.states, 7)
    assert np.array_equal(empowerment(mdp, horizon, sensor, actions, some), truth[some])


@pytest.mark.parametrize("labels", [None, "own", "pairs"])
def test_bits_are_right_on_a_table_with_thousands_of_labels(labels: str | None):
    rng = np.random.default_rng(1)
    table = random_table(rng, 9000, 3)
    seen = np.arange(9000) // 2 if labels == "pairs" else rng.permutation(9000)
    sensor = "state" if labels is None else seen
    truth = brute_force(table, seen, 4)
    mdp = TabularMDP.deterministic(table)
    assert np.array_equal(empowerment(mdp, 4, sensor), truth)
    some = [8999, 0, 17, 0, *range(4000, 4100)]
    assert np.array_equal(empowerment(mdp, 4, sensor, states=some), truth[some])


@pytest.mark.parametrize("count", [4096, 4097])
def test_bits_do_not_depend_on_the_way_that_the_number_of_labels_decides(count: int):
    rng = np.random.default_rng(count)
    table = random_table(rng, 4200, 2)
    labels = rng.permutation(np.arange(4200) % count)
    bits = empowerment(TabularMDP.deterministic(table), 3, labels)
    assert np.array_equal(bits, brute_force(table, labels, 3))


@pytest.mark.parametrize("count", [1, 2, 63, 64, 65, 128, 129, 200])
@pytest.mark.parametrize("horizon", [0, 1, 5])
def test_both_kernels_count_what_all_action_sequences_show(count: int, horizon: int):
    """At the numbers of labels where a word of 64 bits is full, and beside them."""
    rng = np.random.default_rng(count)
    table = random_table(rng, 200, 3).astype(np.int32)
    labels = rng.permutation(np.arange(200) % count).astype(np.int32)
    starts = np.arange(200)
    truth = np.rint(2 ** brute_force(table, labels, horizon)).astype(int)
    backward = count_backward(table, labels, count, horizon)
    forward = count_forward(table, labels, count, horizon, starts)
    assert backward.tolist() == truth.tolist()
    assert forward.tolist() == truth.tolist()


# Known values


@pytest.mark.parametrize("sensor", ["state", [5, 5, 5], [1, -1, 10**12]])
def test_no_action_is_no_power(sensor):
    assert empowerment(SWITCH, 0, sensor).tolist() == [0, 0, 0]


def test_two_ends_are_one_bit():
    assert empowerment(SWITCH, 1).tolist() == [1, 0, 0]
    assert empowerment(SWITCH, 1, sensor=[0, 7, 7]).tolist() == [0, 0, 0]
    assert empowerment(SWITCH, 1, actions=[1]).tolist() == [0, 0, 0]
    assert empowerment(SWITCH, 1, actions=[1, 0, 1]).tolist() == [1, 0, 0]


def test_exactly_h_actions_are_counted_and_not_up_to_h(way: str):
    line = np.array([[1], [2], [2]])
    labels = np.array([0, 1, 2])
    for horizon in range(4):
        assert bits_by(way, line, labels, horizon).tolist() == [0, 0, 0]


def test_an_attached_can_has_eight_cells_to_go_to_four_by_moves_and_four_by_sides():
    mdp = tabulate(World.parse(".......\n" * 3 + "..APC..\n" + ".......\n" * 2 + "......G\n"))
    here = [mdp.start]
    assert empowerment(mdp, 1, "object", states=here) == 3
    assert empowerment(mdp, 1, "object", actions=range(4), states=here) == 2
    assert empowerment(mdp, 1, "object", actions=range(4, 8), states=here) == 2


def test_the_goal_does_not_stop_the_counted_sequences():
    mdp = tabulate(World.parse("A.C.G..."))
    free = TabularMDP.deterministic(mdp.next_state)
    assert mdp.terminal.any()
    assert np.array_equal(empowerment(mdp, 6), empowerment(free, 6))
    start = [mdp.find(agent=(0, 2), object=(0, 3))]
    assert empowerment(mdp, 4, "object", states=start) == np.log2(5)  # the goal and all beyond


# What must hold on any table


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables(), st.integers(0, 6))
def test_there_are_no_more_bits_than_labels_or_sequences(way: str, table_and_labels, horizon: int):
    table, labels = table_and_labels
    bits = bits_by(way, table, labels, horizon)
    assert (bits >= 0).all()
    assert (bits <= np.log2(len(set(labels.tolist())))).all()
    assert (bits <= horizon * np.log2(table.shape[1])).all()


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables())
def test_bits_grow_with_the_horizon_where_one_may_wait(way: str, table_and_labels):
    table, labels = table_and_labels
    table = np.concatenate([table, np.arange(len(table))[:, None]], axis=1)
    by_horizon = np.stack([bits_by(way, table, labels, horizon) for horizon in range(7)])
    assert (np.diff(by_horizon, axis=0) >= 0).all()


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables(), st.integers(0, 4))
def test_more_actions_and_a_finer_sensor_never_give_less(way: str, table_and_labels, horizon: int):
    table, labels = table_and_labels
    bits = bits_by(way, table, labels, horizon)
    assert (bits_by(way, table, labels, horizon, [0]) <= bits).all()
    assert (bits_by(way, table, np.arange(len(table)), horizon) >= bits).all()
    assert (bits_by(way, table, labels // 2, horizon) <= bits).all()


@pytest.mark.parametrize("way", WAYS)
@settings(deadline=None)
@given(tables(), st.integers(0, 4), st.integers(0, 2**32 - 1))
def test_names_of_states_actions_and_labels_do_not_matter(
    way: str, table_and_labels, horizon: int, seed: int
):
    table, labels = table_and_labels
    rng = np.random.default_rng(seed)
    new_name = rng.permutation(len(table))  # of each state
    renamed, far_labels = np.empty_like(table), np.empty_like(labels)
    renamed[new_name] = new_name[rng.permutation(table, axis=1)]
    far_labels[new_name] = 10**15 - 10**14 * labels
    bits = bits_by(way, renamed, far_labels, horizon)
    assert np.array_equal(bits[new_name], bits_by(way, table, labels, horizon))


# Long horizons


@pytest.mark.parametrize("way", WAYS)
@settings(max_examples=30, deadline=None)
@given(tables())
def test_at_last_all_that_can_be_reached_is_counted_where_one_may_wait(way: str, table_and_labels):
    table, labels = table_and_labels
    table = np.concatenate([table, np.arange(len(table))[:, None]], axis=1)
    seen = []
    for state in range(len(table)):
        reached: set[int] = {state}
        while not reached >= (more := {int(to) for at in reached for to in table[at]}):
            reached |= more
        seen.append(len({int(labels[at]) for at in reached}))
    assert np.array_equal(bits_by(way, table, labels, 10_000), np.log2(seen))


def test_a_long_horizon_costs_no_more_than_reaching_everything(way: str):
    table = random_table(np.random.default_rng(3), 60, 3)
    labels = np.arange(60)
    bits = bits_by(way, table, labels, 1_000_000_000)  # action by action it would not end
    assert np.array_equal(bits, bits_by(way, table, labels, 100))


def test_a_count_that_stands_still_while_what_is_counted_moves_is_not_the_end(way: str):
    """Left and right change at every step: two ends each, of which the sensor tells the left."""
    left, right = [0, 1], [2, 3]
    table = np.array([right, right, left, left])
    labels = np.array([0, 1, 2, 2])
    for horizon in (2, 10_000):
        assert bits_by(way, table, labels, horizon).tolist() == [1, 1, 0, 0]
        assert bits_by(way, table, labels, horizon - 1).tolist() == [0, 0, 1, 1]


def test_a_ring_can_be_gone_round_for_ever(way: str):
    ring = np.array([[1], [2], [0]])
    assert bits_by(way, ring, np.arange(3), 10_000).tolist() == [0, 0, 0]


# Asking


def test_bits_come_as_floats_one_for_each_state_asked_about():
    for states, count in [(None, 3), ([2], 1), (1, 1), ([], 0), (np.zeros(3, bool), 0)]:
        bits = empowerment(SWITCH, 1, states=states)
        assert bits.dtype == np.float64
        assert bits.shape == (count,)
    bits = empowerment(tabulate(World.parse("." * 70 + "A.CG")), 1, states=[])
    assert (bits.dtype, bits.shape) == (np.float64, (0,))


@pytest.mark.ill_typed
def test_whole_numbers_of_numpy_are_whole_numbers():
    actions, states = np.array([0, 1], np.uint8), np.array([0], np.int16)
    assert empowerment(SWITCH, np.int64(1), actions=actions, states=states) == [1]  # pyright: ignore[reportArgumentType]


def test_asking_leaves_the_table_as_it_was():
    mdp = tabulate(World.parse("A.PCG"))
    table, labels = mdp.next_state.copy(), mdp.factor("object").copy()
    empowerment(mdp, 3, "object", actions=[0, 5], states=[0, 3])
    empowerment(mdp, 3, "object")
    assert np.array_equal(mdp.next_state, table)
    assert np.array_equal(mdp.factor("object"), labels)


ROOM = tabulate(World.parse("A.PCG"))


@pytest.mark.parametrize("horizon", [-1, 1.0, 2.5, True, np.float64(2), np.True_, "2", None])
@pytest.mark.ill_typed
def test_a_horizon_that_is_not_a_whole_number_from_0_up_is_refused(horizon: Any):
    with pytest.raises(ValueError, match=r"horizon is .*; give a whole number from 0 up"):
        empowerment(ROOM, horizon)


def test_a_sensor_that_the_table_does_not_have_is_refused_with_those_it_has():
    with pytest.raises(ValueError, match="'nose' is unknown; use one of state, agent, tool, obj"):
        empowerment(ROOM, 1, "nose")
    with pytest.raises(ValueError, match=r"'object' is unknown; use one of state$"):
        empowerment(SWITCH, 1, "object")


@pytest.mark.parametrize(
    "labels", [[0, 1], [0, 1, 2, 3], [[0, 1, 2]], 0, [], [0.0, 1.0, 2.0], ["a", "b", "c"]]
)
def test_a_sensor_that_is_not_one_integer_a_state_is_refused(labels: Any):
    with pytest.raises(
        ValueError,
        match=r"give one integer label(, or a row of probabilities,)? for each of the 3 states",
    ):
        empowerment(SWITCH, 1, labels)


@pytest.mark.parametrize(
    "actions", [[], [[0, 1]], [0.0], [True, False], 0, ["north"], np.array([])]
)
@pytest.mark.ill_typed
def test_actions_that_are_not_a_list_of_indices_are_refused(actions: Any):
    with pytest.raises(ValueError, match="give a list of action indices, at least one"):
        empowerment(SWITCH, 1, actions=actions)


@pytest.mark.parametrize("actions", [[2], [0, -1], [0, 1, 2**40]])
def test_an_action_that_the_table_does_not_have_is_refused(actions: list[int]):
    with pytest.raises(ValueError, match=r"actions has -?\d+; use indices from 0 to 1"):
        empowerment(SWITCH, 1, actions=actions)


@pytest.mark.parametrize("states", [[3], [-1], [0, 1, 2, 3], 2**40])
def test_a_state_that_the_table_does_not_have_is_refused(states: Any):
    with pytest.raises(ValueError, match=r"states has -?\d+; use indices from 0 to 2"):
        empowerment(SWITCH, 1, states=states)


@pytest.mark.parametrize("states", [[0.0], [[0, 1]], [True, False], [True] * 4, ["0"]])
def test_states_that_are_neither_indices_nor_one_flag_a_state_are_refused(states: Any):
    with pytest.raises(ValueError, match="give state indices, or one bool a state"):
        empowerment(SWITCH, 1, states=states)
