"""A transition table is taken as it is meant, or refused with what to give instead."""

import numpy as np
import pytest

import habilis as hb
from habilis.mdp import TabularMDP

RING = [[1, 0], [2, 0], [0, 0]]


def test_a_table_is_read_from_lists():
    mdp = TabularMDP.deterministic(RING)
    assert mdp.states == 3
    assert mdp.next_state.tolist() == RING
    assert mdp.start == 0


def test_what_is_left_out_is_nothing():
    mdp = TabularMDP.deterministic(RING)
    assert not mdp.reward.any()
    assert not mdp.terminal.any()
    assert mdp.shape is None
    assert not mdp.factors


def test_what_is_given_is_kept():
    reward = [[0.5, -1], [0, 2], [3, 4]]
    mdp = TabularMDP.deterministic(RING, reward, [False, True, False], start=2)
    assert mdp.reward.tolist() == reward
    assert mdp.terminal.tolist() == [False, True, False]
    assert mdp.start == 2


@pytest.mark.parametrize("dtype", [np.int8, np.uint16, np.int64, np.uint64])
def test_arrays_come_out_in_the_types_that_are_promised(dtype: type):
    table = np.asarray(RING, dtype)
    mdp = TabularMDP.deterministic(table, np.zeros((3, 2), int), np.array([0, 1, 0]))
    assert mdp.next_state.dtype == np.int32
    assert mdp.reward.dtype == np.float32
    assert mdp.terminal.dtype == bool
    assert mdp.next_state.tolist() == RING
    assert (mdp.reward.shape, mdp.terminal.shape) == ((3, 2), (3,))


def test_a_table_of_any_memory_order_is_the_same_table():
    table = np.asarray(RING)
    for same in (
        np.asfortranarray(table),
        np.repeat(table, 2, axis=0)[::2],
        table[:, ::-1][:, ::-1],
    ):
        mdp = TabularMDP.deterministic(same)
        assert mdp.next_state.tolist() == RING
        assert mdp.next_state.flags.c_contiguous


@pytest.mark.parametrize(
    "table",
    [
        pytest.param([0, 1], id="one dimension"),
        pytest.param([[[0]]], id="three dimensions"),
        pytest.param([], id="nothing"),
        pytest.param([[], []], id="no actions"),
        pytest.param([[0.0, 1.0], [1.0, 0.0]], id="floats"),
        pytest.param([[False, True], [True, False]], id="truth values"),
        pytest.param([["0", "1"], ["1", "0"]], id="text"),
    ],
)
def test_what_is_not_a_table_of_integers_is_refused(table: list):
    with pytest.raises(ValueError, match=r"give integers of shape \[states, actions\]"):
        TabularMDP.deterministic(table)


@pytest.mark.parametrize("state", [3, -2, 2**40])
def test_a_state_that_does_not_exist_is_named_with_its_place(state: int):
    with pytest.raises(ValueError, match=rf"\[1, 0\] is {state}; use states 0 to 2"):
        TabularMDP.deterministic([[1, 0], [state, 0], [0, 0]])


@pytest.mark.parametrize("reward", [[0, 0, 0], [[0], [0], [0]], [[0, 0], [0, 0]], 0])
def test_a_reward_of_another_shape_is_refused(reward):
    with pytest.raises(ValueError, match=r"reward has shape .*; give \(3, 2\)"):
        TabularMDP.deterministic(RING, reward=reward)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_reward_that_is_no_number_is_refused(value: float):
    with pytest.raises(ValueError, match="reward has entries that are not finite"):
        TabularMDP.deterministic(RING, reward=[[0, 0], [0, value], [0, 0]])


@pytest.mark.parametrize("terminal", [[True], [[True], [False], [False]], True, [0, 0, 0, 1]])
def test_terminal_flags_of_another_shape_are_refused(terminal):
    with pytest.raises(ValueError, match=r"terminal has shape .*; give \(3,\)"):
        TabularMDP.deterministic(RING, terminal=terminal)


@pytest.mark.parametrize("start", [-1, 3])
def test_a_start_that_does_not_exist_is_refused(start: int):
    with pytest.raises(ValueError, match=f"start is {start}; use a state from 0 to 2"):
        TabularMDP.deterministic(RING, start=start)


def test_a_factor_of_a_table_without_any_is_unknown():
    with pytest.raises(ValueError, match="'agent' is unknown; this MDP has: none"):
        TabularMDP.deterministic(RING).factor("agent")


def test_a_table_without_cells_finds_nothing_by_them():
    with pytest.raises(ValueError, match="no cells"):
        TabularMDP.deterministic(RING).find(agent=(0, 0))


@pytest.mark.ill_typed
def test_what_numpy_cannot_make_sense_of_is_refused_in_our_words():
    with pytest.raises(ValueError, match="next_state is ragged; give rows of one length"):
        TabularMDP.deterministic([[0, 1], [0]])
    with pytest.raises(ValueError, match="reward has entries that are not finite"):
        TabularMDP.deterministic([[0]], reward=[["much"]])
    with pytest.raises(ValueError, match="reward has entries that are not finite"):
        TabularMDP.deterministic([[0]], reward=[[1e300]])
    with pytest.raises(ValueError, match=r"start is 0\.5"):
        TabularMDP.deterministic([[0]], start=0.5)  # pyright: ignore[reportArgumentType]


def test_the_table_is_a_copy():
    mine = np.zeros((1, 1), np.int32)
    mdp = TabularMDP.deterministic(mine)
    mine[0, 0] = 7
    assert mdp.next_state[0, 0] == 0


def test_the_bytes_of_a_table_are_those_that_the_documentation_says():
    for world in (hb.load_world("yard"), hb.load_world("corridor", tool="none")):
        mdp = hb.tabulate(world)
        S, A, F, G = mdp.states, mdp.action_count, len(mdp.factors), len(mdp.flags)
        labels = 1 + 4 * F + G + 4  # with the reward of entering a state, which worlds have
        assert mdp.nbytes == S * (8 * A + labels)
        noisy = mdp.slippery(0.1)
        outcomes = sum(noisy.transition(action).nnz for action in range(A))  # k S A
        narrow, wide = ((8 + b) * outcomes + S * (A * (4 + b) + labels) + b for b in (4, 8))
        assert noisy.nbytes in (narrow, wide)
    assert TabularMDP.deterministic(RING).nbytes == 3 * (8 * 2 + 1)
    full = TabularMDP.stochastic(np.full((3, 2, 3), 1 / 3))
    assert full.nbytes == 3 * (2 * (12 * 3 + 8) + 1) + 4
