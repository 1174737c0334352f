"""Some actions are not available in some states: every way to say so is the same table."""

import re
from typing import Any

import numpy as np
import pytest
from available import random_probabilities, random_table
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

from habilis.mdp import TabularMDP

LINE = [[-1, 1], [0, 2], [1, -1]]


def dense(mdp: TabularMDP) -> np.ndarray:
    """float[S, A, S]."""
    return np.stack([mdp.transition(a).toarray() for a in range(mdp.action_count)], axis=1)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_minus_one_a_row_of_zeros_and_available_mean_the_same(seed: int):
    rng = np.random.default_rng(seed)
    table = random_table(rng)
    there = table >= 0
    states = len(table)
    anything = np.where(there, table, rng.integers(-3, states + 3, table.shape))
    P = np.where(there[..., None], np.eye(states)[table], 0.0)
    nonsense = np.where(there[..., None], P, rng.choice([np.nan, -1.0, 7.0, 0.0], P.shape))
    sparse = [csr_array(P[:, a]) for a in range(table.shape[1])]
    wild = [csr_array(nonsense[:, a]) for a in range(table.shape[1])]
    for mdp in (
        TabularMDP.deterministic(table),
        TabularMDP.deterministic(anything, available=there),
        TabularMDP.deterministic(anything, available=there.astype(np.int8)),
        TabularMDP.stochastic(P),
        TabularMDP.stochastic(P, available=there),
        TabularMDP.stochastic(nonsense, available=there),
        TabularMDP.stochastic(sparse),
        TabularMDP.stochastic(wild, available=there.tolist()),
    ):
        assert np.array_equal(mdp.next_state, table)
        assert np.array_equal(mdp.available, there)
        assert mdp.always_available == there.all()
        assert np.array_equal(mdp.ends, ~there.any(axis=1))
        assert np.array_equal(dense(mdp), P)


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_stochastic_table_keeps_its_empty_rows(seed: int):
    P = random_probabilities(np.random.default_rng(seed))
    mdp = TabularMDP.stochastic(P)
    assert np.array_equal(mdp.available, P.any(axis=2))
    assert np.allclose(dense(mdp), P, atol=1e-15)


def test_rewards_of_unavailable_actions_are_zero_whatever_was_given():
    reward = [[np.nan, 1.0], [2.0, 3.0], [4.0, np.inf]]
    kept = [[0, 1], [2, 3], [4, 0]]
    assert TabularMDP.deterministic(LINE, reward).reward.tolist() == kept
    P = np.eye(3)[LINE] * (np.array(LINE) >= 0)[..., None]
    assert TabularMDP.stochastic(P, reward).reward.tolist() == kept
    with pytest.raises(ValueError, match="not finite"):
        TabularMDP.deterministic(LINE, [[0, np.nan], [0, 0], [0, 0]])


@pytest.mark.parametrize("share", [1.0, 0.5])
def test_a_terminal_state_without_actions_loops_to_itself(share: float):
    P = np.zeros((3, 2, 3))
    P[0, 1, 1] = share
    P[0, 1, 2] += 1 - share
    reward = np.full((3, 2), 5.0)
    made = [TabularMDP.stochastic(P, reward, [False, False, True])]
    if share == 1:
        table = [[-1, 1], [-1, -1], [-1, -1]]
        made.append(TabularMDP.deterministic(table, reward, [False, False, True]))
    for mdp in made:
        assert mdp.available.tolist() == [[False, True], [False, False], [True, True]]
        assert mdp.transition(0).toarray()[2].tolist() == [0, 0, 1]
        assert mdp.reward.tolist() == [[0, 5], [0, 0], [0, 0]]
        assert mdp.ends.tolist() == [False, True, True]


def test_a_terminal_state_with_an_action_keeps_it_alone():
    mdp = TabularMDP.deterministic([[1, 1], [-1, 0]], terminal=[False, True])
    assert mdp.next_state.tolist() == [[1, 1], [-1, 0]]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: TabularMDP.deterministic(LINE, available=np.ones((3, 2), bool)),
            "next_state[0, 0] is -1, but available[0, 0] is True",
        ),
        (
            lambda: TabularMDP.deterministic([[0, 9]], available=[[False, True]]),
            "next_state[0, 1] is 9; use states 0 to 0, or -1",
        ),
        (lambda: TabularMDP.deterministic([[-2, 0]]), "next_state[0, 0] is -2; use states 0 to 0"),
        (
            lambda: TabularMDP.deterministic(LINE, available=[True, False]),
            "available has shape (2,); give (3, 2), [states, actions]",
        ),
        (
            lambda: TabularMDP.deterministic(LINE, available=np.full((3, 2), 2)),
            "available has entries that are neither True nor False",
        ),
        (
            lambda: TabularMDP.stochastic([[[1.0]]], available=[[0.5]]),
            "available has entries that are neither True nor False",
        ),
        (
            lambda: TabularMDP.stochastic(
                [[[1.0, 0], [0, 0]], [[0, 1.0], [0, 0]]], available=[[True, False], [True, True]]
            ),
            "P, action 1, state 1 sums to 0, but available[1, 1] is True",
        ),
        (
            lambda: TabularMDP.stochastic(
                [[[1.0, 0], [0.5, 0]], [[0, 1.0], [0, 0]]], available=[[True, True], [True, False]]
            ),
            "P, action 1, state 0 sums to 0.5",
        ),
    ],
)
def test_what_contradicts_itself_is_refused_with_its_place(make: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        make()


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1), st.booleans())
def test_slip_draws_among_the_available_actions(seed: int, slip: float, certain: bool):
    rng = np.random.default_rng(seed)
    if certain:
        table = random_table(rng)
        P = np.where((table >= 0)[..., None], np.eye(len(table))[table], 0.0)
    else:
        P = random_probabilities(rng)
    there = np.asarray(np.any(P, axis=2))
    reward = np.where(there, rng.normal(size=there.shape), 0).astype(np.float32)
    mdp = TabularMDP.stochastic(P, reward).slippery(slip)
    counts = np.maximum(there.sum(axis=1), 1)
    mixed = (1 - slip) * P + slip * P.sum(axis=1, keepdims=True) / counts[:, None, None]
    assert np.allclose(dense(mdp), np.where(there[..., None], mixed, 0), atol=1e-12)
    assert np.array_equal(mdp.available, there)
    earned = (1 - slip) * reward + slip * reward.sum(axis=1, keepdims=True) / counts[:, None]
    assert np.allclose(mdp.reward, np.where(there, earned, 0), atol=1e-6)


# The order of axes


def test_a_list_of_matrices_is_by_action_as_a_list_of_sparse_ones_is():
    P = np.random.default_rng(0).dirichlet(np.ones(3), (3, 2))
    each = [P[:, a] for a in range(2)]
    for given_as in (
        each,
        tuple(each),
        [csr_array(m) for m in each],
        [each[0], csr_array(each[1])],
    ):
        assert np.allclose(dense(TabularMDP.stochastic(given_as)), P)
        assert np.allclose(dense(TabularMDP.stochastic(given_as, axes="ASS")), P)
    for given_as in (P, P.tolist(), list(P.tolist()), list(P)):
        assert np.allclose(dense(TabularMDP.stochastic(given_as, axes="SAS")), P)
    for given_as in (np.stack(each), np.stack(each).tolist(), each):
        assert np.allclose(dense(TabularMDP.stochastic(given_as, axes="ASS")), P)
    for given_as in (P, P.tolist(), [list(one) for one in P]):
        assert np.allclose(dense(TabularMDP.stochastic(given_as)), P)


def test_as_many_matrices_as_states_need_their_axes():
    P = np.random.default_rng(0).dirichlet(np.ones(3), (3, 3))
    with pytest.raises(ValueError, match="by state or by action; give axes='SAS' or axes='ASS'"):
        TabularMDP.stochastic(list(P))
    assert np.allclose(dense(TabularMDP.stochastic(list(P), axes="SAS")), P)
    assert np.allclose(dense(TabularMDP.stochastic(list(P), axes="ASS")), P.swapaxes(0, 1))
    assert np.allclose(dense(TabularMDP.stochastic(np.array(list(P)))), P)
    assert np.allclose(dense(TabularMDP.stochastic([np.ones((1, 1))])), 1)


@pytest.mark.parametrize(
    ("P", "axes", "message"),
    [
        (np.ones((1, 1, 1)), "SSA", "axes is 'SSA'; use 'SAS' for"),
        (np.ones((1, 1, 1)), ["SAS"], "axes is ['SAS']; use 'SAS' for"),
        ([csr_array(np.eye(2))], "SAS", "one an action; leave out axes"),
        (np.ones((2, 3, 3)) / 3, None, "axes='ASS' for [actions, states, states]"),
        (np.ones((3, 2, 3)) / 3, "ASS", "P has shape (3, 2, 3); give [actions, states, states]"),
        (
            list(np.ones((3, 2, 3)) / 3),
            None,
            "the first of shape (2, 3); give one [states, states]",
        ),
        ([np.eye(2), np.eye(3), np.eye(2)], None, "P is ragged"),
    ],
)
@pytest.mark.ill_typed
def test_axes_that_do_not_fit_are_refused(P: Any, axes: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        TabularMDP.stochastic(P, axes=axes)


@pytest.mark.parametrize("axes", ["SAS", "ASS"])
def test_matrices_whose_columns_sum_to_one_are_recognised(axes: Any):
    P = np.random.default_rng(0).dirichlet(np.ones(3), (3, 2))
    by_action = P.swapaxes(0, 1).swapaxes(1, 2)  # [actions, next states, states]
    wrong = by_action if axes == "ASS" else by_action.swapaxes(0, 1)
    message = r"action 0, state 0 sums to .* every column to 1: rows are states; transpose it"
    with pytest.raises(ValueError, match=message):
        TabularMDP.stochastic(wrong, axes=axes)
    with pytest.raises(ValueError, match=message):
        TabularMDP.stochastic([csr_array(one) for one in by_action])
