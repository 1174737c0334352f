"""Arrays in the conventions of other packages, as the page about them reads them.

`docs/how-to/arrays-of-others.md` has these lines; its blocks run as tests too. Here the tables are
random, and what becomes of them is compared with an independent reading of each convention.
"""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from habilis.mdp import TabularMDP

SEEDS = st.integers(0, 2**32 - 1)


def model(seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """P[s, a, t], R[s, a] and which actions are available, at least one in each state."""
    rng = np.random.default_rng(seed)
    states, actions = rng.integers(1, 6, size=2)
    P = rng.dirichlet(np.full(states, 0.3), (states, actions))
    available = rng.random((states, actions)) < 0.7
    available[np.arange(states), rng.integers(actions, size=states)] = True
    return P, rng.integers(-9, 10, size=(states, actions)) / 4, available


def assert_is(mdp: TabularMDP, P: np.ndarray, R: np.ndarray, available: np.ndarray):
    assert np.array_equal(mdp.available, available)
    for s, a in np.ndindex(available.shape):
        assert mdp.reward[s, a] == (R[s, a] if available[s, a] else 0)
        row = mdp.transition(a).toarray()[s]
        assert np.allclose(row, P[s, a] if available[s, a] else 0, atol=1e-12)


@settings(max_examples=50, deadline=None)
@given(SEEDS, st.booleans())
def test_arrays_by_action_are_read(seed: int, is_sparse: bool):
    P, R, available = model(seed)
    available[:] = True
    by_action = np.moveaxis(P, 1, 0)
    if is_sparse:
        mdp = TabularMDP.stochastic([sparse.csr_matrix(one) for one in by_action], R)
    else:
        mdp = TabularMDP.stochastic(by_action, R, axes="ASS")
    assert_is(mdp, P, R, available)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_rewards_of_minus_infinity_mark_unavailable_actions(seed: int):
    P, R, available = model(seed)
    product = np.where(available, R, -np.inf)
    mdp = TabularMDP.stochastic(P, product, available=np.isfinite(product), axes="SAS")
    assert_is(mdp, P, R, available)


@settings(max_examples=50, deadline=None)
@given(SEEDS, st.booleans())
def test_pairs_of_states_and_actions_are_read(seed: int, shuffled: bool):
    P, R, available = model(seed)
    available[-1, -1] = True  # so that the last action is among them
    s_indices, a_indices = np.nonzero(available)
    if shuffled:
        order = np.random.default_rng(seed).permutation(len(s_indices))
        s_indices, a_indices = s_indices[order], a_indices[order]
    Q, rewards = sparse.csr_array(P[s_indices, a_indices]), R[s_indices, a_indices]

    pairs, states, actions = len(rewards), len(P), a_indices.max() + 1
    place = s_indices, np.arange(pairs)
    each = [sparse.csr_array((a_indices == a, place), (states, pairs)) @ Q for a in range(actions)]
    reward = np.zeros((states, actions))
    reward[s_indices, a_indices] = rewards
    assert_is(TabularMDP.stochastic(each, reward), P, R, available)


@settings(max_examples=50, deadline=None)
@given(SEEDS)
def test_an_end_that_is_written_as_minus_one_is_a_terminal_state(seed: int):
    rng = np.random.default_rng(seed)
    states, actions = rng.integers(1, 7, size=2)
    table = rng.integers(-1, states, size=(states, actions)).astype(np.int32)
    rewards = rng.integers(-5, 6, size=table.shape).astype(np.float32)
    end = len(table)
    ended = np.pad(np.where(table < 0, end, table), ((0, 1), (0, 0)), constant_values=end)
    mdp = TabularMDP.deterministic(
        ended, reward=np.pad(rewards, ((0, 1), (0, 0))), terminal=np.arange(end + 1) == end
    )
    assert mdp.always_available
    assert np.flatnonzero(mdp.terminal).tolist() == [end]
    state, earned, expected = 0, 0.0, 0.0
    for action in rng.integers(actions, size=20):
        if mdp.terminal[state]:
            break
        expected += float(rewards[state, action])
        earned += float(mdp.reward[state, action])
        following = int(table[state, action])
        state = int(mdp.next_state[state, action])
        assert state == (end if following < 0 else following)
    assert earned == expected
