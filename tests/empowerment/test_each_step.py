"""The observations of every step: beside lists of sequences, relations, and refusals."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10_000), st.integers(0, 5))
def test_without_noise_it_counts_sequences_of_observations(seed, horizon):
    rng = np.random.default_rng(seed)
    table, labels = rng.integers(6, size=(6, 2)), rng.integers(3, size=6)
    table[rng.random((6, 2)) < 0.2] = -1
    table[(table < 0).all(axis=1), 0] = 0
    found = hb.empowerment(
        hb.TabularMDP.deterministic(table), horizon, labels, sensor_at="each step"
    )
    for start in range(6):
        seen = set()
        for sequence in product(range(2), repeat=horizon):
            state, shown = start, []
            for action in sequence:
                state = table[state, action] if state >= 0 else state
                shown.append(labels[state] if state >= 0 else None)
            if state >= 0:
                seen.add(tuple(shown))
        assert found[start] == pytest.approx(np.log2(max(len(seen), 1)))


def written_out(P, W, start, horizon):
    """P(o_1 ... o_h | a_1 ... a_h), one product of matrices for each pair of sequences."""
    actions, outputs = P.shape[1], W.shape[-1]
    by_action = W if W.ndim == 3 else np.repeat(W[None], actions, axis=0)
    rows = []
    for sequence in product(range(actions), repeat=horizon):
        row = []
        for shown in product(range(outputs), repeat=horizon):
            b = np.eye(len(P))[start]
            for action, o in zip(sequence, shown, strict=True):
                b = (b @ P[:, action]) * by_action[action][:, o]
            row.append(b.sum())
        rows.append(row)
    return np.array(rows)


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10_000), st.integers(1, 2), st.booleans())
def test_with_noise_it_is_the_capacity_of_the_channel_written_out(seed, horizon, by_action):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(4, 0.5), size=(4, 2))
    W = rng.dirichlet(np.ones(3), size=(2, 4) if by_action else 4)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    found = hb.empowerment(mdp, horizon, W, states=[1], sensor_at="each step")
    expected = hb.capacity(written_out(P, W, 1, horizon), tolerance=1e-9).bits
    assert found[0] == pytest.approx(expected, abs=2e-6)


@settings(deadline=None, max_examples=12)
@given(st.integers(0, 10_000), st.integers(0, 3))
def test_more_observations_never_cost_anything(seed, horizon):
    rng = np.random.default_rng(seed)
    P = rng.dirichlet(np.full(3, 0.5), size=(3, 2))
    W = rng.dirichlet(np.ones(2), size=3)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    every = hb.empowerment(mdp, horizon, W, sensor_at="each step")
    assert (every >= hb.empowerment(mdp, horizon, W) - 2e-6).all()


def test_of_one_step_both_are_the_same():
    mdp = hb.tabulate(hb.load_world("yard"))
    every = hb.empowerment(mdp, 1, "object", sensor_at="each step")
    np.testing.assert_allclose(every, hb.empowerment(mdp, 1, "object"))


def test_long_counts_do_not_overflow():
    mdp = hb.TabularMDP.deterministic([[0, 1], [0, 1]])
    assert hb.empowerment(mdp, 3000, states=[0], sensor_at="each step")[0] == pytest.approx(3000)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"sensor_at": "start"}, "sensor_at is 'start'; use 'end' or 'each step'"),
        ({"sensor": "state * state"}, "with the observations of each step give one alone"),
        ({"method": hb.Sampled()}, "each step needs every sequence; use method=hb.Exact"),
        ({"budget": 1}, "budget is given without cost; give both, or neither"),
        (
            {"horizon": 30, "sensor": np.full((2, 2), 0.5), "method": hb.Exact(max_gib=0.001)},
            "the largest horizon that fits is",
        ),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match=message):
        hb.empowerment(mdp, **({"horizon": 2, "sensor_at": "each step"} | arguments))


@pytest.mark.parametrize("states", [None, [[0.5, 0.5, 0.0]]])
def test_where_no_sequence_can_surely_be_carried_out_it_is_0(states):
    P = np.zeros((3, 2, 3))
    P[0, 0, [1, 2]] = 0.5  # after it no action is available in both
    P[1, 0, 0] = P[2, 1, 0] = 1
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    asked = {"states": None if states is None else np.array(states), "sensor_at": "each step"}
    assert hb.empowerment(mdp, 2, **asked)[0] == 0
    cost = np.ones((3, 2))
    assert hb.empowerment(mdp, 2, **asked, cost=cost, budget=2)[0] == 0
