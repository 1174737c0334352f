"""Where a policy leads: beside all trajectories, and refusals."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trajectories import random_model, trajectories

import habilis as hb
from habilis.analysis import occupancy

cases = given(st.integers(0, 10_000), st.integers(1, 4), st.booleans())


@settings(deadline=None, max_examples=20)
@cases
def test_it_is_the_probability_of_the_trajectories_through_a_state(seed, steps, absorbing):
    P, policy, mdp, _ = random_model(seed, states=3)
    found = occupancy(mdp, policy, steps, range(3), absorbing=absorbing)
    ends = np.flatnonzero(mdp.terminal) if absorbing else ()
    expected = np.zeros((3, steps, 3))
    for start in range(3):
        for probability, path in trajectories(P, policy, start, steps, ends):
            for t, state in enumerate(path):
                expected[start, t, state] += probability
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_it_begins_at_the_start_or_with_a_distribution():
    _, policy, mdp, rng = random_model(1)
    np.testing.assert_array_equal(occupancy(mdp, policy, 3), occupancy(mdp, policy, 3, [mdp.start]))
    belief = rng.dirichlet(np.ones(4))
    mixed = np.einsum("s,sto->to", belief, occupancy(mdp, policy, 3, range(4)))
    np.testing.assert_allclose(occupancy(mdp, policy, 3, belief[None])[0], mixed)


def test_terminal_states_are_left_unless_they_absorb():
    mdp = hb.TabularMDP.deterministic([[1], [0]], terminal=[False, True])
    assert occupancy(mdp, "uniform", 2).argmax(axis=2).tolist() == [[1, 0]]
    assert occupancy(mdp, "uniform", 2, absorbing=True).argmax(axis=2).tolist() == [[1, 1]]


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"steps": 0}, "steps is 0; give a whole number from 1 up"),
        ({"states": [2]}, "states has 2; use indices from 0 to 1"),
        ({"states": [[0.5, 0.4]]}, "states, distribution 0 sums to 0.9"),
        ({"states": [[0.5, 0.4, 0.1]]}, r"states has shape \(1, 3\); as distributions give one"),
        ({"policy": [[1.0, 0.0]]}, r"policy has shape \(1, 2\); give float\[states, actions\]"),
        ({"policy": [[0.5, 0.5], [0.5, 0.5]]}, "policy has 0.5 for action 1 in state 1, which is"),
        ({"steps": 2**30}, "occupancy has 2,147,483,648 probabilities, above 1,073,741,824; give"),
    ],
)
def test_what_it_refuses(arguments, message):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, -1]])
    with pytest.raises(ValueError, match=message):
        occupancy(mdp, **({"policy": "uniform", "steps": 1} | arguments))
