"""Agents that do not know where they are: distributions in the place of states."""

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
    return (
        P / P.sum(axis=-1, keepdims=True),
        rng.dirichlet(np.ones(observations), size=states),
        rng.dirichlet(np.ones(states), size=2),
    )


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.integers(1, 3))
def test_it_is_the_capacity_of_the_mean_channel(seed, horizon):
    P, W, beliefs = random_model(seed)
    found = hb.empowerment(hb.TabularMDP.stochastic(P, axes="SAS"), horizon, W, states=beliefs)
    for bits, belief in zip(found, beliefs, strict=True):
        rows = []
        for sequence in product(range(2), repeat=horizon):
            b = belief
            for action in sequence:
                b = b @ P[:, action]
            rows.append(b @ W)
        assert bits == pytest.approx(hb.capacity(rows, tolerance=1e-9).bits, abs=2e-6)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000), st.integers(0, 3))
def test_knowing_the_state_never_costs_anything(seed, horizon):
    P, W, beliefs = random_model(seed)
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    known = beliefs @ hb.empowerment(mdp, horizon, W)
    assert (hb.empowerment(mdp, horizon, W, states=beliefs) <= known + 4e-6).all()


def test_a_belief_that_is_certain_is_its_state():
    mdp = hb.tabulate(hb.load_world("yard"))
    states = [mdp.start, 17]
    sure = np.zeros((2, mdp.states))
    sure[[0, 1], states] = 1
    for sensor in ("state", "object", "agent + object"):
        expected = hb.empowerment(mdp, 2, sensor, states=states)
        np.testing.assert_allclose(hb.empowerment(mdp, 2, sensor, states=sure), expected)


def test_on_a_ring_that_looks_alike_not_knowing_costs_everything():
    ring = hb.TabularMDP.deterministic([[(s - 1) % 8, (s + 1) % 8] for s in range(8)])
    assert hb.empowerment(ring, 1, states=np.full((1, 8), 1 / 8))[0] == pytest.approx(0)
    assert hb.empowerment(ring, 1, states=[0])[0] == 1


def test_lists_of_probabilities_are_distributions_and_those_of_indices_are_not():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    assert hb.empowerment(mdp, 1, states=[[1.0, 0.0]]).tolist() == [1]
    with pytest.raises(ValueError, match="give state indices, or one bool a state"):
        hb.empowerment(mdp, 1, states=[[1, 0]])


def test_an_action_is_available_where_it_is_in_every_state_that_is_possible():
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, -1]])
    assert hb.empowerment(mdp, 1, states=np.array([[0.5, 0.5], [1.0, 0.0]])).tolist() == [0, 1]


def test_a_sensor_that_depends_on_the_last_action():
    P, _, beliefs = random_model(4)
    heard = np.random.default_rng(0).dirichlet(np.ones(3), size=(2, 4))
    mdp = hb.TabularMDP.stochastic(P, axes="SAS")
    bits = hb.empowerment(mdp, 1, heard, states=beliefs)
    for found, belief in zip(bits, beliefs, strict=True):
        rows = [belief @ P[:, action] @ heard[action] for action in range(2)]
        assert found == pytest.approx(hb.capacity(rows).bits, abs=2e-6)


@pytest.mark.parametrize(
    ("beliefs", "message"),
    [
        ([[0.5, 0.5, 0.0]], r"states has shape \(1, 3\); as distributions give one probability"),
        ([[0.5, 0.4]], "states, belief 0 sums to 0.9; divide each row by its sum"),
        ([[1.5, -0.5]], "states"),
    ],
)
def test_what_is_no_distribution_is_refused(beliefs, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    with pytest.raises(ValueError, match=message):
        hb.empowerment(mdp, 1, states=np.array(beliefs))
