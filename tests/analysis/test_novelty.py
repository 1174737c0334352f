"""The bonus of counts that a policy leaves, beside all trajectories, and refusals."""

import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trajectories import distributions, random_model, trajectories

import habilis as hb
from habilis.analysis import count_novelty, occupancy

cases = given(st.integers(0, 10_000), st.integers(1, 4), st.booleans())


@settings(deadline=None, max_examples=20)
@cases
def test_it_is_the_mean_over_trajectories_of_the_bonus_that_each_leaves(seed, steps, absorbing):
    P, policy, mdp, rng = random_model(seed, states=3)
    ends = np.flatnonzero(mdp.terminal) if absorbing else ()
    labels = rng.integers(2, size=3)
    for sensor, label in (("state", np.arange(3)), (labels, labels)):
        found = count_novelty(mdp, policy, steps, sensor, range(3), absorbing=absorbing)
        for start in range(3):
            expected = np.zeros(3)
            for probability, path in trajectories(P, policy, start, steps, ends):
                visits = (label[list(path)][:, None] == label).sum(axis=0)
                expected += probability / np.sqrt(1 + visits)
            np.testing.assert_allclose(found[start], expected, atol=1e-12)


@settings(deadline=None, max_examples=15)
@given(st.integers(0, 10_000))
def test_through_a_noisy_sensor_readings_are_counted(seed):
    P, policy, mdp, rng = random_model(seed, states=3)
    noisy = distributions(rng, 3, 2)
    found = count_novelty(mdp, policy, 2, noisy, [0])[0]
    expected = np.zeros(2)
    for probability, path in trajectories(P, policy, 0, 2):
        one, two = path[-2:]
        for first in range(2):
            for second in range(2):
                visits = np.bincount([first, second], minlength=2)
                seen = noisy[one, first] * noisy[two, second]
                expected += probability * seen / np.sqrt(1 + visits)
    np.testing.assert_allclose(found, noisy @ expected, atol=1e-12)


@settings(deadline=None, max_examples=15)
@cases
def test_it_is_never_less_than_the_bonus_of_the_expected_count(seed, steps, absorbing):
    _, policy, mdp, _ = random_model(seed)
    found = count_novelty(mdp, policy, steps, states=range(4), absorbing=absorbing)
    expected = occupancy(mdp, policy, steps, range(4), absorbing=absorbing).sum(axis=1)
    assert (found >= 1 / np.sqrt(1 + expected) - 1e-12).all()
    assert (found <= 1 + 1e-12).all()
    assert (found >= 1 / np.sqrt(1 + steps) - 1e-12).all()


def test_what_is_out_of_reach_is_new():
    mdp = hb.TabularMDP.deterministic([[1], [1], [2]])
    assert count_novelty(mdp, "uniform", 3).tolist() == [[1.0, 0.5, 1.0]]


def test_observations_in_several_blocks_have_the_same_bonus(monkeypatch):
    _, policy, mdp, _ = random_model(2)
    whole = count_novelty(mdp, policy, 3, states=range(4))
    monkeypatch.setattr(sys.modules["habilis.analysis.novelty"], "_BLOCK", 1)
    np.testing.assert_allclose(count_novelty(mdp, policy, 3, states=range(4)), whole, atol=1e-12)


def test_more_than_can_be_followed_is_refused(monkeypatch):
    mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]])
    monkeypatch.setattr(sys.modules["habilis.analysis.novelty"], "_MOST", 10)
    with pytest.raises(ValueError, match="the visits of 2 observations over 3 steps"):
        count_novelty(mdp, "uniform", 3)
