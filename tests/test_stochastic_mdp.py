"""A stochastic table holds the probabilities it was given, and refuses what are none."""

import re
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_matrix, csr_array

import habilis as hb
from habilis.mdp import TabularMDP


def probabilities(seed: int, states: int = 4, actions: int = 3) -> np.ndarray:
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(states, 0.5), (states, actions))
    P[rng.random((states, actions)) < 0.3] = np.eye(states)[0]
    return P


@settings(deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 6), st.integers(1, 4))
def test_a_table_gives_back_what_it_was_given(seed: int, states: int, actions: int):
    P = probabilities(seed, states, actions)
    each = [P[:, a] for a in range(actions)]
    sparse = [csr_array(each[0]), *(coo_matrix(matrix) for matrix in each[1:])]
    for given_as in (P, P.tolist(), np.stack(each, axis=1), tuple(sparse)):
        mdp = TabularMDP.stochastic(given_as)
        assert (mdp.states, mdp.action_count) == (states, actions)
        for action in range(actions):
            assert np.allclose(mdp.transition(action).toarray(), P[:, action], atol=1e-15)


def test_a_table_of_certainties_is_deterministic():
    next_state = np.array([[1, 0], [2, 1], [0, 2]])
    mdp = TabularMDP.stochastic(np.eye(3)[next_state])
    assert not mdp.is_stochastic
    assert np.array_equal(mdp.next_state, next_state)
    assert np.array_equal(mdp.transition(0).toarray(), np.eye(3)[next_state[:, 0]])


def test_a_stochastic_table_has_no_next_state():
    mdp = TabularMDP.stochastic(probabilities(0))
    with pytest.raises(ValueError, match="this MDP is stochastic: it has no next_state"):
        mdp.next_state  # noqa: B018
    with pytest.raises(ValueError, match="stochastic"):
        hb.solve(hb.tabulate(hb.load_world("yard"), slip=0.1))


def test_rewards_and_ends_are_kept():
    reward = np.arange(12).reshape(4, 3)
    mdp = TabularMDP.stochastic(probabilities(0), reward, [0, 0, 0, 1], start=2)
    assert np.array_equal(mdp.reward, reward)
    assert mdp.terminal.tolist() == [False, False, False, True]
    assert mdp.start == 2


@pytest.mark.parametrize(
    ("P", "message"),
    [
        ([], "P has shape (0,); give [states, actions, states]"),
        (np.ones((2, 1)), "P has shape (2, 1)"),
        (np.ones((2, 1, 3)) / 3, "P has shape (2, 1, 3)"),
        ([[[1.0]], [[1.0, 0.0]]], "P is ragged"),
        ([[[0.5, 0.4]], [[1.0, 0.0]]], "P, action 0, state 0 sums to 0.9; divide each row"),
        ([[[1.0, 0.0]], [[0.0, 1e-3]]], "P, action 0, state 1 sums to 0.001; divide each row"),
        ([[[1.5, -0.5]], [[1.0, 0.0]]], "P, action 0, state 0, column 1 is -0.5"),
        ([[[np.nan, 1.0]], [[1.0, 0.0]]], "P, action 0, state 0, column 0 is nan"),
        (csr_array(np.eye(2)), "P is one sparse matrix; give a sequence of them"),
        ([csr_array(np.eye(2)), csr_array(np.eye(3))], "P, action 1 has shape (3, 3)"),
        ([csr_array([[1.0, 0.0]])], "P, action 0 has shape (1, 2); give (1, 1)"),
    ],
)
def test_what_are_no_transitions_is_refused(P: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        TabularMDP.stochastic(P)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"reward": np.zeros((4, 2))}, "reward has shape (4, 2); give (4, 3)"),
        ({"reward": np.full((4, 3), np.inf)}, "reward has entries that are not finite"),
        ({"terminal": [True]}, "terminal has shape (1,); give (4,)"),
        ({"start": 4}, "start is 4; use a state from 0 to 3"),
    ],
)
def test_what_does_not_fit_the_transitions_is_refused(arguments: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        TabularMDP.stochastic(probabilities(0), **arguments)


# Slip


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, 1))
def test_slipping_mixes_in_a_uniform_action(seed: int, slip: float):
    P = probabilities(seed)
    mdp = TabularMDP.stochastic(P, np.arange(12).reshape(4, 3)).slippery(slip)
    for action in range(3):
        mixed = (1 - slip) * P[:, action] + slip * P.mean(axis=1)
        assert np.allclose(mdp.transition(action).toarray(), mixed, atol=1e-12)
        rewards = (1 - slip) * np.arange(12).reshape(4, 3)[:, action] + slip * np.array(
            [1, 4, 7, 10]
        )
        assert np.allclose(mdp.reward[:, action], rewards, atol=1e-5)


def test_a_slippery_world_has_the_same_states_and_the_mean_rewards():
    world = hb.load_world("yard")
    certain, slippery = hb.tabulate(world), hb.tabulate(world, slip=0.2)
    assert slippery.is_stochastic
    assert slippery.start == certain.start
    assert slippery.actions == certain.actions
    assert np.array_equal(slippery.factor("object"), certain.factor("object"))
    entering = slippery.transitions @ certain.terminal.astype(float)
    assert np.allclose(slippery.reward.ravel(), entering - 1, atol=1e-6)


def test_no_slip_is_no_noise_and_all_slip_is_no_choice():
    world = hb.World.parse("A.C.G")
    assert not hb.tabulate(world, slip=0).is_stochastic
    assert (hb.empowerment(hb.tabulate(world, slip=1.0), 3) < 1e-9).all()


@pytest.mark.parametrize("slip", [-0.1, 1.1, np.nan, "0.1", True, None])
@pytest.mark.ill_typed
def test_a_slip_that_is_no_probability_is_refused(slip: Any):
    with pytest.raises(ValueError, match="give a probability from 0 to 1"):
        hb.tabulate(hb.load_world("yard"), slip=slip)
