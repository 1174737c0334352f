"""Closed-loop empowerment: beside a list of all policies, its relations, and refusals."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb


def random_model(seed, states=4, actions=2, observations=3):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(states, 0.6), size=(states, actions))
    P[P < 0.25] = 0
    return P / P.sum(axis=-1, keepdims=True), rng.dirichlet(np.ones(observations), size=states)


def capacity_over_all_policies(P, W, state, horizon):
    """The channel of every deterministic policy of state and time, one row each."""
    rows = [W[x][None] for x in range(len(P))]
    for _ in range(horizon):
        after = []
        for x in range(len(P)):
            mixed = []
            for action in range(P.shape[1]):
                reached = np.flatnonzero(P[x, action])
                for choice in product(*(range(len(rows[y])) for y in reached)):
                    parts = zip(reached, choice, strict=True)
                    mixed.append(sum(P[x, action, y] * rows[y][i] for y, i in parts))
            after.append(np.unique(np.round(mixed, 12), axis=0))
        rows = after
    channel = rows[state]
    return hb.capacity(channel / channel.sum(axis=1, keepdims=True), tolerance=1e-9).bits


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10_000), st.integers(1, 3), st.booleans())
def test_it_is_the_capacity_over_all_policies(seed, horizon, noisy):
    P, W = random_model(seed)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    sensor = W if noisy else "state"
    bits, gap = hb.closed_loop_empowerment(mdp, horizon, sensor, [0], return_gap=True)
    expected = capacity_over_all_policies(P, W if noisy else np.eye(4), 0, horizon)
    assert bits[0] == pytest.approx(expected, abs=2e-6)
    assert gap[0] <= 1e-6


@settings(deadline=None, max_examples=10)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_looking_never_costs_anything(seed, horizon):
    P, W = random_model(seed)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    open_loop = hb.empowerment(mdp, horizon, W)
    assert (hb.closed_loop_empowerment(mdp, horizon, W) >= open_loop - 2e-6).all()


def test_in_a_deterministic_model_it_is_open_loop_empowerment():
    mdp = hb.tabulate(hb.load_world("yard"))
    closed = hb.closed_loop_empowerment(mdp, 2, "object")
    np.testing.assert_array_equal(closed, hb.empowerment(mdp, 2, "object"))


def test_an_agent_that_looks_can_correct_a_slip():
    # Two actions lead on or back. Who sees a slip repeats the action.
    P = np.zeros((4, 2, 4))
    P[0] = P[1] = [[0, 0.5, 0.5, 0], [0, 0.5, 0.5, 0]]  # chance first, then a choice
    P[1], P[2] = [[1, 0, 0, 0], [0, 0, 0, 1]], [[0, 0, 0, 1], [1, 0, 0, 0]]
    P[3] = [[0, 0, 0, 1], [0, 0, 0, 1]]
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    assert hb.empowerment(mdp, 2, states=[0])[0] == pytest.approx(0, abs=1e-6)
    assert hb.closed_loop_empowerment(mdp, 2, states=[0])[0] == pytest.approx(1, abs=1e-6)


def test_where_boxes_run_out_the_gap_says_so():
    P, W = random_model(8, states=4, observations=4)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    with pytest.warns(hb.ConvergenceWarning):
        bits, gap = hb.closed_loop_empowerment(mdp, 3, W, [0], return_gap=True, max_boxes=1)
    assert bits[0] <= capacity_over_all_policies(P, W, 0, 3) <= bits[0] + gap[0] + 1e-9


def test_some_actions_alone():
    P, W = random_model(2)
    some = hb.closed_loop_empowerment(hb.TabularMDP.stochastic(P, axes="SAS"), 2, W, actions=[1])
    np.testing.assert_allclose(some, 0, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"horizon": -1}, "horizon is -1; give a whole number from 0 up"),
        ({"sensor": "agent"}, "agent"),
        ({"states": [4]}, "states has 4; use indices from 0 to 3"),
        ({"max_boxes": 0}, "max_boxes is 0; give a whole number from 1 up"),
        ({"sensor": "state * state"}, "several; give one alone"),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.stochastic(random_model(0)[0], axes="SAS")
    with pytest.raises(ValueError, match=message):
        hb.closed_loop_empowerment(mdp, **({"horizon": 2} | arguments))


def test_a_dead_end_is_refused_with_its_state():
    P = np.zeros((2, 2, 2))
    P[0] = 0.5
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    with pytest.raises(ValueError, match="state 1, which a policy from state 0 can reach before"):
        hb.closed_loop_empowerment(mdp, 2, states=[0])
